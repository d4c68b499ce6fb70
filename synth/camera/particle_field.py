"""The motion of the particles between two frames, as a smooth field: local affine fits, blended."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

    from synth.recording import Recording

_FIT_REACH = 2.5
"""Neighbours up to this distance, in mean particle diameters, take part in a particle's affine fit."""
_BLEND_REACH = 1.75
"""A particle's affine motion acts up to this distance, in mean diameters: about ten act at any place."""
_FLOOR = 0.05
"""Least spread of the neighbours, in squared mean diameters, that a fit trusts; a full ring has 0.3."""


@dataclass(frozen=True)
class Blend:
    """Motion of points between two frames; shape (point,) and (point, 2).

    Attributes
    ----------
    displacement : float64
        m, x and z.
    turn : float64
        rad, counter-clockwise.
    strain : float32
        Equivalent shear strain sqrt(2 e:e), e the deviator of the symmetric displacement gradient.
    particle : int32
        Nearest particle; -1 where none is near: there the other values are 0.
    """

    displacement: "np.ndarray"
    turn: "np.ndarray"
    strain: "np.ndarray"
    particle: "np.ndarray"


@dataclass(frozen=True)
class _Cells:
    """Particles sorted into square cells; `first` has one entry more than there are cells."""

    order: "np.ndarray"
    first: "np.ndarray"
    columns: int
    rows: int
    left: float
    bottom: float
    size: float


class ParticleField:
    """Motion of the particles between two frames of a recording.

    Every particle has an affine motion: its own displacement, and a gradient fitted to its neighbours'
    displacements. Points move by a partition of unity (C2) over these, so an affine field is met exactly.
    """

    def __init__(self, recording: "Recording", first: int, second: int) -> None:
        import numpy as np

        self._diameter = 2 * float(recording.data["radius"].values.mean())
        x, z = _positions(recording, first)
        next_x, next_z = _positions(recording, second)
        self._cells = _sort_into_cells(x, z, _BLEND_REACH * self._diameter)
        order = self._cells.order
        self._x, self._z = x[order], z[order]
        self._moved_x, self._moved_z = (next_x - x)[order], (next_z - z)[order]
        self._gradient = np.empty((len(x), 2, 2))
        self._fit()

    def _fit(self) -> None:
        from synth.camera import field_kernels

        cells = self._cells
        field_kernels.fit_gradients(
            self._x,
            self._z,
            self._moved_x,
            self._moved_z,
            cells.first,
            cells.columns,
            cells.rows,
            cells.left,
            cells.bottom,
            cells.size,
            _FIT_REACH * self._diameter,
            _FLOOR * self._diameter**2,
            self._gradient,
        )

    def at(self, x: "np.ndarray", z: "np.ndarray", alive: "np.ndarray") -> Blend:
        """Motion of the points `x`, `z` (m) where `alive` (uint8) is 1."""
        import numpy as np

        from synth.camera import field_kernels

        count, cells = len(x), self._cells
        blend = Blend(
            np.zeros((count, 2)), np.zeros(count), np.zeros(count, np.float32), np.empty(count, np.int32)
        )
        field_kernels.blend_motion(
            x,
            z,
            alive,
            self._x,
            self._z,
            self._moved_x,
            self._moved_z,
            self._gradient,
            cells.first,
            cells.columns,
            cells.rows,
            cells.left,
            cells.bottom,
            cells.size,
            _BLEND_REACH * self._diameter,
            blend.displacement,
            blend.turn,
            blend.strain,
            blend.particle,
        )
        found = blend.particle >= 0
        blend.particle[found] = cells.order[blend.particle[found]]
        return blend

    def strain_of_particles(self) -> "np.ndarray":
        """Equivalent shear strain at every particle; (particle,) float32."""
        import numpy as np

        gradient = self._gradient
        strain = np.hypot(gradient[:, 0, 0] - gradient[:, 1, 1], gradient[:, 0, 1] + gradient[:, 1, 0])
        unsorted = np.empty(len(strain), np.float32)
        unsorted[self._cells.order] = strain
        return unsorted


def _positions(recording: "Recording", frame: int) -> tuple["np.ndarray", "np.ndarray"]:
    import numpy as np

    x, z = recording.data["position_x"].values[frame], recording.data["position_z"].values[frame]
    return x.astype(np.float64), z.astype(np.float64)


def _sort_into_cells(x: "np.ndarray", z: "np.ndarray", size: float) -> _Cells:
    import numpy as np

    left, bottom = float(x.min()), float(z.min())
    # A particle that flew far away must not make the table of cells grow without bound.
    size = max(size, math.sqrt((float(x.max()) - left) * (float(z.max()) - bottom) / (16 * len(x) + 1024)))
    columns, rows = int((float(x.max()) - left) / size) + 1, int((float(z.max()) - bottom) / size) + 1
    cell = ((z - bottom) / size).astype(np.int32) * columns + ((x - left) / size).astype(np.int32)
    order = np.argsort(cell, kind="stable").astype(np.int32)
    first = np.zeros(columns * rows + 1, np.int32)
    first[1:] = np.cumsum(np.bincount(cell, minlength=columns * rows))
    return _Cells(order, first, columns, rows, left, bottom, size)
