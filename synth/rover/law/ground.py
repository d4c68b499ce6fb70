"""The surface of the soil along the tracks, as wheels leave it: ruts, and where wheels have been."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

_GROWTH = 1.0
"""m that a track is lengthened by at least where a wheel comes to its end."""


class Tracks:
    """Height fields on one grid along x, one a track; level, at z = 0, where no wheel has been.

    A wheel lowers a column of soil when its axle passes over it: soil ahead of the axle is as it was, soil
    behind is a rut. Passed again, the column is lowered again, from where it was left.

    Parameters
    ----------
    track : sequence of int
        The track of each wheel.
    spacing : float
        Of the columns, m.
    share : float
        Of a wheel's depth below the former surface that stays behind it as rut: 1 where nothing flows back.
    """

    def __init__(self, track: Sequence[int], *, spacing: float, share: float) -> None:
        self._track = np.asarray(track)
        self._spacing, self._share = spacing, share
        self._first = 0
        self._height = np.zeros((int(self._track.max()) + 1, 0))
        self._passes = np.zeros_like(self._height)
        self._column: NDArray | None = None

    def height(self, x: NDArray) -> NDArray:
        """Surface at places x (wheel_count, n), m, linear between columns."""
        column, share = self._columns_at(x)
        column += self._track[:, None] * self._height.shape[1]
        heights = self._height.reshape(-1)
        low = heights.take(column)
        column += 1
        return low + share * (heights.take(column) - low)

    def passes(self, x: NDArray) -> NDArray:
        """How often an axle passed over the column next to x (wheel_count, n)."""
        column, share = self._columns_at(x)
        return self._passes[self._track[:, None], column + (share > 0.5)]

    def follow(self, x: NDArray, lowest: NDArray) -> None:
        """Lower the columns that the axles, now at `x`, passed: down to `lowest`, where the rims are."""
        column = np.floor(x / self._spacing).astype(np.int64)
        if self._column is None:
            self._column = column
        passing = column != self._column
        if not passing.any():
            return
        self._reach(float(x.min()), float(x.max()))
        for wheel in np.flatnonzero(passing):
            first, last = sorted((int(self._column[wheel]), int(column[wheel])))
            self._lower(int(self._track[wheel]), first, last, float(lowest[wheel]))
        self._column = column

    def state(self) -> dict[str, NDArray]:
        """All that is remembered, for `restore`."""
        return {
            "first": np.array(self._first),
            "height": self._height.copy(),
            "passes": self._passes.copy(),
            "column": np.zeros(0, np.int64) if self._column is None else self._column.copy(),
        }

    def restore(self, state: Mapping[str, NDArray]) -> None:
        """Take up what `state` gave."""
        self._first = int(state["first"])
        self._height, self._passes = state["height"].copy(), state["passes"].copy()
        self._column = state["column"].copy() if state["column"].size else None

    def profile(self, track: int) -> NDArray:
        """Surface along a track, shape (n, 2): x and z, m."""
        count = self._height.shape[1]
        return np.stack([(self._first + np.arange(count)) * self._spacing, self._height[track]], axis=1)

    def _lower(self, track: int, first: int, last: int, lowest: float) -> None:
        """Columns first + 1 to last, both numbered from x = 0."""
        passed = slice(first + 1 - self._first, last + 1 - self._first)
        height = self._height[track, passed]
        height -= self._share * np.maximum(height - lowest, 0.0)
        self._passes[track, passed] += 1

    def _columns_at(self, x: NDArray) -> tuple[NDArray, NDArray]:
        place = x / self._spacing - self._first
        if self._height.shape[1] == 0 or place.min() < 1 or place.max() > self._height.shape[1] - 3:
            self._reach(float(x.min()), float(x.max()))
            place = x / self._spacing - self._first
        column = place.astype(np.int64)
        return column, place - column

    def _reach(self, left: float, right: float) -> None:
        """Lengthen the tracks so that they hold a place, with room around."""
        room = int(_GROWTH / self._spacing) + 3
        first = int(np.floor(left / self._spacing)) - 3
        last = int(np.ceil(right / self._spacing)) + 3
        count = self._height.shape[1]
        if count == 0:
            self._first = first - room
            before, after = 0, last + room - self._first
        else:
            before = self._first - first + room if first < self._first else 0
            after = last - (self._first + count) + room if last >= self._first + count else 0
        if before or after:
            self._first -= before if count else 0
            self._height = np.pad(self._height, ((0, 0), (before, after)))
            self._passes = np.pad(self._passes, ((0, 0), (before, after)))
