"""How elements of rims meet the soil."""

from dataclasses import dataclass

from numpy.typing import NDArray


@dataclass(frozen=True)
class Touch:
    """Elements of rims now; arrays of shape (wheel_count, element_count).

    Attributes
    ----------
    sine, cosine : ndarray
        The outward normal is (sine, -cosine), the tangent (cosine, sine).
    depth : ndarray
        Below the surface, m; 0 above it.
    into, along : ndarray
        Velocity against the soil and along the tangent, m/s.
    x : ndarray
        Place along the track, m.
    """

    sine: NDArray
    cosine: NDArray
    depth: NDArray
    into: NDArray
    along: NDArray
    x: NDArray
