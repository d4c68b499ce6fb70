"""The lower part of a rim, cut into elements that turn with it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.rover.law.interface import PlacedWheel

_HALF_WINDOW = np.radians(80.0)
"""How far on either side of the lowest point a rim is looked at."""


@dataclass(frozen=True)
class RimElements:
    """Elements of all wheels now.

    Attributes
    ----------
    sine, cosine : ndarray, shape (wheel_count, element_count)
        Of an element's angle from the rim's lowest point, positive ahead of it. The outward normal is
        (sine, -cosine), the tangent (cosine, sine).
    moved : ndarray of int, shape (wheel_count,)
        What was element k at the last call is element k + moved now.
    """

    sine: NDArray
    cosine: NDArray
    moved: NDArray


class Rims:
    """Follows the elements of rims that turn.

    Parameters
    ----------
    wheels : sequence of PlacedWheel
    element_count : int
        Of the part of a rim that is looked at: 80 degrees on either side of the lowest point.

    Attributes
    ----------
    radius : ndarray, shape (wheel_count, 1)
        m.
    area : ndarray, shape (wheel_count, 1)
        Of an element, m2.
    pitch : float
        Angle from an element to the next, rad.
    """

    def __init__(self, wheels: Sequence[PlacedWheel], element_count: int) -> None:
        self.pitch = 2 * _HALF_WINDOW / element_count
        self.radius = np.array([[wheel.radius] for wheel in wheels])
        self.area = self.radius * self.pitch * np.array([[wheel.width] for wheel in wheels])
        self._first = (np.arange(element_count) + 0.5) * self.pitch - _HALF_WINDOW
        self._turns: NDArray | None = None

    @property
    def turns(self) -> NDArray:
        """Whole elements that the rims had turned by at the last call, (wheel_count,); empty before it."""
        return np.zeros(0) if self._turns is None else self._turns

    @turns.setter
    def turns(self, turns: NDArray) -> None:
        self._turns = turns.copy() if turns.size else None

    def at(self, angle: NDArray) -> RimElements:
        """Elements where the rims have turned by `angle` (wheel_count,), rad, as their tops move ahead."""
        turned = -angle / self.pitch  # at the bottom, what turns with spin > 0 goes backwards
        turns = np.floor(turned)
        moved = turns - (turns if self._turns is None else self._turns)
        self._turns = turns
        place = self._first + ((turned - turns) * self.pitch)[:, None]
        sine = np.sin(place)
        return RimElements(sine, np.sqrt(1 - sine * sine), moved.astype(np.int64))


def carried(state: NDArray, moved: NDArray) -> NDArray:
    """What elements (wheel_count, n) keep, where the rims turned by whole elements; new ones come with 0."""
    if not moved.any():
        return state
    shifted = np.zeros_like(state)
    count = state.shape[1]
    for wheel, by in enumerate(moved):
        if by >= 0:
            shifted[wheel, by:] = state[wheel, : max(count - by, 0)]
        else:
            shifted[wheel, :by] = state[wheel, -by:]
    return shifted
