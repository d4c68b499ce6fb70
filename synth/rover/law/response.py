"""Resistive force theory: the traction of flowing grains on a piece of surface, in the plane of a wheel.

Three-dimensional resistive force theory (Agarwal, Goldman, Kamrin, *PNAS* 120(4), 2023, DOI
10.1073/pnas.2214017120), restricted to surfaces whose normal lies in the plane of motion. Its generic form
is a vector in the three directions that there are,

    alpha = f1 n + f2 v - f3 z,

n the outward normal, v the direction of motion, z up; f1, f2, f3 are cubic polynomials in x1 = -v.z,
x2 = -n.z, x3 = n.v, with the published coefficients (the paper's supplement S3). Traction is
`scale` x depth x alpha, alpha's tangential part held to surface friction.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_COEFFICIENTS = np.array(
    [
        # f1, f2, f3 of
        [0.00212, -0.06796, -0.02634],  # 1
        [-0.02320, -0.10941, -0.03436],  # x1
        [-0.20890, 0.04725, 0.45256],  # x2
        [-0.43083, -0.06914, 0.00835],  # x3
        [-0.00259, -0.05835, 0.02553],  # x1^2
        [0.48872, -0.65880, -1.31290],  # x2^2
        [-0.00415, -0.11985, -0.05532],  # x3^2
        [0.07204, -0.25739, 0.06790],  # x1 x2
        [-0.02750, -0.26834, -0.16404],  # x2 x3
        [-0.08772, 0.02692, 0.02287],  # x3 x1
        [0.01992, -0.00736, 0.02927],  # x1^3
        [-0.45961, 0.63758, 0.95406],  # x2^3
        [0.40799, 0.08997, -0.00131],  # x3^3
        [-0.10107, 0.21069, -0.11028],  # x1 x2^2
        [-0.06576, 0.04748, 0.01487],  # x2 x1^2
        [0.05664, 0.20406, -0.02730],  # x2 x3^2
        [-0.09269, 0.18519, 0.10911],  # x3 x2^2
        [0.01892, 0.04934, -0.04097],  # x3 x1^2
        [0.01033, 0.13527, 0.07881],  # x1 x3^2
        [0.15120, -0.33207, -0.27519],  # x1 x2 x3
    ]
)
_TRANSPOSED = np.ascontiguousarray(_COEFFICIENTS.T)
_LEAST_FRICTION, _GREATEST_FRICTION = 0.3, 0.9
"""Range of the internal friction that the published scale was fitted over."""


class SoilError(ValueError):
    """A soil that a law cannot use; the message names the key, the value and what is allowed."""


@dataclass(frozen=True)
class Response:
    """Generic traction, resolved at the surface; dimensionless, each of the surfaces' shape.

    Attributes
    ----------
    pressure : ndarray
        Against the outward normal: positive pushes the surface back.
    shear : ndarray
        Along the tangent.
    """

    pressure: NDArray
    shear: NDArray


def published_scale(*, density: float, friction_angle: float, gravity: float = 9.81) -> float:
    """Traction per depth, Pa/m, from the critical density (kg/m3) and the angle of internal friction (deg).

    The paper's fit over internal frictions of 0.3 to 0.9: density x gravity x (894 mu^3 - 386 mu^2 + 89 mu).

    Raises
    ------
    SoilError
        The friction is outside that range.
    """
    friction = math.tan(math.radians(friction_angle))
    if not _LEAST_FRICTION <= friction <= _GREATEST_FRICTION:
        low, high = (math.degrees(math.atan(one)) for one in (_LEAST_FRICTION, _GREATEST_FRICTION))
        raise SoilError(f"friction_angle = {friction_angle}: {low:.1f} to {high:.1f} deg is allowed")
    return density * gravity * (894 * friction**3 - 386 * friction**2 + 89 * friction)


def generic_response(
    normal_x: NDArray, normal_z: NDArray, velocity_x: NDArray, velocity_z: NDArray
) -> Response:
    """The paper's generic traction, friction between surface and grains not yet considered.

    Parameters
    ----------
    normal_x, normal_z : ndarray
        Unit vectors out of the body. The tangent is the normal turned counter-clockwise by a quarter.
    velocity_x, velocity_z : ndarray, of the same shape
        Unit vectors of motion.
    """
    along = normal_x * velocity_x + normal_z * velocity_z
    f1, f2, f3 = (_TRANSPOSED @ _monomials(-velocity_z, -normal_z, along)).reshape(3, *np.shape(along))
    across = normal_x * velocity_z - normal_z * velocity_x
    return Response(f3 * normal_z - f1 - f2 * along, f2 * across - f3 * normal_x)


def _monomials(x1: NDArray, x2: NDArray, x3: NDArray) -> NDArray:
    """The twenty terms, shape (20, number of surfaces)."""
    x1, x2, x3 = x1.ravel(), x2.ravel(), x3.ravel()
    terms = np.empty((20, x1.size))
    terms[0], terms[1], terms[2], terms[3] = 1.0, x1, x2, x3
    first, second, third = terms[4], terms[5], terms[6]
    np.multiply(x1, x1, out=first)
    np.multiply(x2, x2, out=second)
    np.multiply(x3, x3, out=third)
    np.multiply(x1, x2, out=terms[7])
    np.multiply(x2, x3, out=terms[8])
    np.multiply(x3, x1, out=terms[9])
    for row, (one, other) in enumerate(
        ((first, x1), (second, x2), (third, x3), (second, x1), (first, x2), (third, x2), (second, x3)),
        start=10,
    ):
        np.multiply(one, other, out=terms[row])
    np.multiply(first, x3, out=terms[17])
    np.multiply(third, x1, out=terms[18])
    np.multiply(terms[7], x3, out=terms[19])
    return terms
