"""The motion of the particles between two frames, as a smooth field: local affine fits, blended."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

    from synth.recording import Recording
    from synth.scene import Scene

_FIT_REACH = 2.5
"""Neighbours up to this distance, in mean particle diameters, take part in a particle's affine fit."""
_BLEND_REACH = 1.75
"""A particle's affine motion acts up to this distance, in mean diameters: about ten act at any place."""
_FLOOR = 0.05
"""Least spread of the neighbours, in squared mean diameters, that a fit trusts; a full ring has 0.3."""
_NEAR = _BLEND_REACH + 3 * _FIT_REACH
"""Mean diameters; particles further away do not matter: a blend of fits, among neighbours that are calmed by
fits to their neighbours."""
_NODE_SPACING = 1 / 3
"""Of the nodes the field is computed at, in mean diameters: a fifth of a particle's reach."""
_LOOSE_RATIO = 5.0
"""A particle this many times further from what its neighbours lead to expect than these are is loose."""
_LOOSE_LEAST = 0.005
"""What is never loose, in mean diameters."""


@dataclass(frozen=True)
class MovedPoints:
    """Points after the motion between two frames; shape (point,) each.

    Attributes
    ----------
    x, z : float64
        m.
    angle : float64
        rad, counter-clockwise.
    alive : uint8
        0 for points without a particle near.
    """

    x: "np.ndarray"
    z: "np.ndarray"
    angle: "np.ndarray"
    alive: "np.ndarray"


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
    displacements. A partition of unity (C2) over these is computed at the nodes of a grid that is finer than
    the particles, and quadratic B-splines (C1) carry it to points: an affine field is met exactly. Particles
    act only where the implement does not hide them.

    A loose particle, which falls through a pore or rolls over its neighbours, stands for no soil around it:
    it gets the motion that its neighbours lead to expect.

    Attributes
    ----------
    loose : (particle,) uint8
        1 for loose particles.
    """

    def __init__(
        self,
        recording: "Recording",
        first: int,
        second: int,
        scene: "Scene",
        *,
        around: "tuple[np.ndarray, np.ndarray] | None" = None,
    ) -> None:
        """Field from one frame to another; at points within the bounds of `around` (x, z, m), or anywhere."""
        import numpy as np

        radius = recording.data["radius"].values
        self._diameter = 2 * float(np.median(radius))
        x, z = _positions(recording, first)
        next_x, next_z = _positions(recording, second)
        self._bounds = None if around is None else _bounds(*around)
        self._bounded = None if around is None else around[0]
        chosen = _within(x, z, self._bounds, _NEAR * self._diameter)
        self._cells = _sort_into_cells(x[chosen], z[chosen], _BLEND_REACH * self._diameter)
        order = chosen[self._cells.order]
        self._order = order.astype(np.int32)
        self._x, self._z = x[order], z[order]
        self._moved_x, self._moved_z = (next_x - x)[order], (next_z - z)[order]
        self._parts = _implement_parts(recording, first, scene)
        loose = self._calm_loose()
        self._gradient = np.empty((len(order), 2, 2))
        self._fit(loose)
        self.loose = np.zeros(len(x), np.uint8)
        self.loose[order] = loose
        self._latest: tuple[np.ndarray, tuple[Any, ...]] | None = None

    def carry(
        self,
        x: "np.ndarray",
        z: "np.ndarray",
        angle: "np.ndarray",
        alive: "np.ndarray",
        carried: MovedPoints | None = None,
    ) -> MovedPoints:
        """Move the points `x`, `z` (m) with the angles `angle` (rad) where `alive` (uint8) is 1.

        `carried`: what is overwritten and returned; others than the points.
        """
        import numpy as np

        from synth.camera import field_kernels

        if carried is None:
            count = len(x)
            carried = MovedPoints(
                np.empty(count), np.empty(count), np.empty(count), np.empty(count, np.uint8)
            )
        field_kernels.carry(
            x,
            z,
            angle,
            alive,
            self._affine,
            self._cells.first,
            *self._where,
            _BLEND_REACH * self._diameter,
            self._parts,
            *self._nodes(x, z),
            carried.x,
            carried.z,
            carried.angle,
            carried.alive,
        )
        return carried

    def look_around(
        self, x: "np.ndarray", z: "np.ndarray", point: "np.ndarray", chosen: "np.ndarray"
    ) -> "tuple[np.ndarray, np.ndarray]":
        """Particle nearest to points, and the strain there: int32, float32, as many as `point` lists.

        `point` (int32) lists which of the points `x`, `z` (m) are meant; only at the places of this list that
        `chosen` (int32) names the result means something. The strain is the equivalent shear strain
        sqrt(2 e:e), e the deviator of the symmetric displacement gradient. Without a particle near they are
        -1 and 0.
        """
        import numpy as np

        from synth.camera import field_kernels

        particle, strain = np.empty(len(point), np.int32), np.empty(len(point), np.float32)
        field_kernels.look_around(
            x,
            z,
            point,
            chosen,
            self._affine,
            self._cells.first,
            self._order,
            *self._where,
            _BLEND_REACH * self._diameter,
            self._parts,
            *self._nodes(x, z),
            strain,
            particle,
        )
        return particle, strain

    @cached_property
    def _affine(self) -> "np.ndarray":
        """Every particle's place, displacement and gradient: see `field_kernels.py`; (particle, 8)."""
        import numpy as np

        gradient = self._gradient.reshape(-1, 4).T
        return np.stack([self._x, self._z, self._moved_x, self._moved_z, *gradient], axis=1)

    @cached_property
    def _where(self) -> tuple[Any, Any]:
        """The cells' place and shape, for kernels."""
        from synth.camera import sight_kernels

        cells = self._cells
        grid = sight_kernels.grid_vector((cells.left, cells.bottom, cells.size))
        return grid, sight_kernels.shape_vector((cells.columns, cells.rows))

    def _calm_loose(self) -> "np.ndarray":
        """Find loose particles and give them the motion that is expected of them; (particle,) uint8."""
        import numpy as np

        from synth.camera import fit_kernels

        moving = (self._x, self._z, self._moved_x, self._moved_z)
        expected = np.empty((len(self._x), 2))
        loose = np.empty(len(self._x), np.uint8)
        reach, floor = _FIT_REACH * self._diameter, _FLOOR * self._diameter**2
        fit_kernels.fit_neighbours(
            *moving, self._cells.first, *self._where, reach, self._parts, floor, expected
        )
        fit_kernels.find_loose(
            *moving,
            expected,
            self._cells.first,
            *self._where,
            reach,
            _LOOSE_RATIO,
            _LOOSE_LEAST * self._diameter,
            loose,
        )
        chosen = loose == 1
        self._moved_x[chosen], self._moved_z[chosen] = expected[chosen].T
        return loose

    def _fit(self, loose: "np.ndarray") -> None:
        from synth.camera import fit_kernels

        fit_kernels.fit_gradients(
            self._x,
            self._z,
            self._moved_x,
            self._moved_z,
            loose,
            self._cells.first,
            *self._where,
            _FIT_REACH * self._diameter,
            self._parts,
            _FLOOR * self._diameter**2,
            self._gradient,
        )

    def _nodes(self, x: "np.ndarray", z: "np.ndarray") -> tuple[Any, ...]:
        """Left, bottom and spacing of the nodes around points; their values, nearest particles, states."""
        if self._latest is None or self._latest[0] is not x:
            self._latest = x, self._nodes_anew(x, z)
        return self._latest[1]

    def _nodes_anew(self, x: "np.ndarray", z: "np.ndarray") -> tuple[Any, ...]:
        import numpy as np

        from synth.camera import field_kernels

        reach, spacing = _BLEND_REACH * self._diameter, _NODE_SPACING * self._diameter
        bounds = self._bounds if self._bounded is x else _bounds(x, z)
        ends = []
        for axis, particles in enumerate((self._x, self._z)):
            low = max(bounds[axis][0], float(particles.min()) - reach) if bounds else 0.0
            high = min(bounds[axis][1], float(particles.max()) + reach) if bounds else 0.0
            ends.append((low - 2 * spacing, max(math.ceil((high - low) / spacing), 0) + 5))
        (left, columns), (bottom, rows) = ends
        value, state = np.empty((rows, columns, 4)), np.empty((rows, columns), np.uint8)
        nearest = np.empty((rows, columns), np.int32)
        where = (left, bottom, spacing, value, nearest, state)
        field_kernels.blend_at_nodes(
            self._affine, self._cells.first, *self._where, reach, self._parts, *where
        )
        field_kernels.find_inner(state)
        return where

    def strain_of_particles(self) -> "np.ndarray":
        """Equivalent shear strain at every particle; (particle,) float32."""
        import numpy as np

        gradient = self._gradient
        strain = np.hypot(gradient[:, 0, 0] - gradient[:, 1, 1], gradient[:, 0, 1] + gradient[:, 1, 0])
        unsorted = np.zeros(len(self.loose), np.float32)
        unsorted[self._order] = strain
        return unsorted


def _implement_parts(recording: "Recording", frame: int, scene: "Scene") -> "np.ndarray":
    """The implement's capsules in the world: both ends and radius (m), (C, 5); none for a plate."""
    import numpy as np

    from synth.implements import Plate

    if isinstance(scene.implement, Plate):
        return np.zeros((0, 5))
    data = recording.data
    at = (float(data["implement_x"].values[frame]), float(data["implement_z"].values[frame]))
    shape = scene.implement.shape.turned(float(data["implement_angle"].values[frame]))
    return np.column_stack([shape.start + at, shape.end + at, shape.radius])


def _bounds(x: "np.ndarray", z: "np.ndarray") -> tuple[tuple[float, float], ...]:
    """Least and greatest coordinate of points along both axes; empty without points."""
    return tuple((float(along.min()), float(along.max())) for along in (x, z)) if len(x) else ()


def _within(
    x: "np.ndarray", z: "np.ndarray", bounds: tuple[tuple[float, float], ...] | None, reach: float
) -> "np.ndarray":
    """Particles within the bounds, or nearer to them than `reach` (m); all without bounds."""
    import numpy as np

    if not bounds:
        return np.arange(len(x))
    inside = np.ones(len(x), bool)
    for particles, (low, high) in zip((x, z), bounds, strict=True):
        inside &= (particles >= low - reach) & (particles <= high + reach)
    # A field needs one particle at least, were it out of reach.
    return np.flatnonzero(inside) if inside.any() else np.arange(len(x))


def _positions(recording: "Recording", frame: int) -> tuple["np.ndarray", "np.ndarray"]:
    import numpy as np

    x, z = (recording.states(f"position_{axis}", frame).astype(np.float64) for axis in "xz")
    return x, z


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
