"""The truth of an analytic scene: the formula at every pixel's centre.

Grains are Gaussians that stay round while their centres follow the formula. A rotation of a round grain
cannot be seen, so a rigid motion is met exactly at every point. Where soil is strained a grain stays round
that a continuum would stretch: at the distance d from a grain's centre, what is seen and what the formula
says differ by at most e d, with e the largest principal strain (px/px) there.
"""

from typing import TYPE_CHECKING

import numpy as np

from synth.truth import JUMP_LIMIT, MIXED_LIMIT, PairTruth

if TYPE_CHECKING:
    from synth.scene import AnalyticScene


def pixel_centres(scene: "AnalyticScene") -> tuple[np.ndarray, np.ndarray]:
    """x, y of every pixel's centre, px from the picture's middle: (H, W) float64 each."""
    height, width = scene.camera.height, scene.camera.width
    y, x = np.mgrid[:height, :width].astype(float)
    return x - (width - 1) / 2, y - (height - 1) / 2


def displacement_of(scene: "AnalyticScene", first: int, second: int) -> np.ndarray:
    """Motion of what is at every pixel's centre: (H, W, 2) float32 px."""
    u, v = scene.motion.displacement(*pixel_centres(scene), first, second)
    return np.stack([u, v], axis=-1).astype(np.float32)


def scored(scene: "AnalyticScene", displacement: np.ndarray) -> np.ndarray:
    """Where a motion is to be measured: it ends inside the picture and starts within `scored_radius`."""
    x, y = pixel_centres(scene)
    then_x, then_y = x + displacement[..., 0], y + displacement[..., 1]
    inside = (np.abs(then_x) <= np.abs(x).max()) & (np.abs(then_y) <= np.abs(y).max())
    radius = scene.camera.scored_radius
    return inside if radius is None else inside & (np.hypot(x, y) <= radius)


def analytic_truth(scene: "AnalyticScene", first: int, second: int) -> PairTruth:
    """Truth between any two frames, on the first one's pixels, with all variables of `synth.truth`."""
    displacement = displacement_of(scene, first, second)
    u, v = np.ascontiguousarray(displacement[..., 0]), np.ascontiguousarray(displacement[..., 1])
    gradient = scene.motion.gradient(*pixel_centres(scene), first, second)
    everywhere, nowhere = np.ones(u.shape, bool), np.zeros(u.shape, bool)
    distance, jump = _discontinuities(u, v)
    arrays = {
        "u": u,
        "v": v,
        "valid": scored(scene, displacement),
        "soil": everywhere,
        "implement": nowhere,
        "mixed": _mixed(scene, first, second),
        "particle_id": np.full(u.shape, -1, np.int32),
        "distance_to_implement": np.full(u.shape, np.inf, np.float32),
        "distance_to_discontinuity": distance,
        "discontinuity_jump": jump,
        "strain_rate": (_shear_strain(gradient) / abs(second - first)).astype(np.float32),
        "rotation": (_turn(gradient) / (second - first)).astype(np.float32),
    }
    return PairTruth(first, second, arrays, {"camera_u": 0.0, "camera_v": 0.0})


def _shear_strain(gradient: np.ndarray) -> np.ndarray:
    """Equivalent shear strain sqrt(2 e:e), e the deviator of the symmetric gradient."""
    stretch = gradient[..., 0, 0] - gradient[..., 1, 1]
    return np.hypot(stretch, gradient[..., 0, 1] + gradient[..., 1, 0])


def _turn(gradient: np.ndarray) -> np.ndarray:
    """Angle of the rotation in F = I + gradient (polar decomposition), from x to y."""
    curl = gradient[..., 1, 0] - gradient[..., 0, 1]
    return np.arctan2(curl, 2.0 + gradient[..., 0, 0] + gradient[..., 1, 1])


def _mixed(scene: "AnalyticScene", first: int, second: int) -> np.ndarray:
    """Pixels with two corners whose motions are more than `MIXED_LIMIT` apart."""
    height, width = scene.camera.height, scene.camera.width
    y, x = np.mgrid[: height + 1, : width + 1].astype(float)
    u, v = scene.motion.displacement(x - width / 2, y - height / 2, first, second)
    corners = [np.s_[a : a + height, b : b + width] for a in (0, 1) for b in (0, 1)]
    mixed = np.zeros((height, width), bool)
    for k, one in enumerate(corners):
        for other in corners[k + 1 :]:
            mixed |= np.hypot(u[one] - u[other], v[one] - v[other]) > MIXED_LIMIT
    return mixed


def _discontinuities(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance (px) to the nearest neighbours that move more than `JUMP_LIMIT` apart, and how far apart.

    The same as for a rendered recording (`synth.truth`), without a kernel to compile.
    """
    from scipy.ndimage import distance_transform_edt

    largest = np.zeros(u.shape, np.float32)
    for one, other in ((np.s_[1:, :], np.s_[:-1, :]), (np.s_[:, 1:], np.s_[:, :-1])):
        apart = np.hypot(u[one] - u[other], v[one] - v[other])
        for side in (one, other):
            largest[side] = np.maximum(largest[side], apart)
    marked = largest > JUMP_LIMIT
    if not marked.any():
        return np.full(u.shape, np.inf, np.float32), np.full(u.shape, np.nan, np.float32)
    distance, (row, column) = distance_transform_edt(~marked, return_indices=True)
    return (distance + 0.5).astype(np.float32), largest[row, column]
