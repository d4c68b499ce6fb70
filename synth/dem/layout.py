"""What differs between discs and spheres on the device: the kernels, and what stands where in arrays."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from synth.dem.contact_law import ContactLaw, HertzMindlinLaw, Law, contact_damping
from synth.dem.grains import Grains, Spheres
from synth.dem.tool import Tool

if TYPE_CHECKING:
    from synth.dem.solver import Solver


@dataclass(frozen=True)
class Layout(ABC):
    """One kind of grains.

    Attributes
    ----------
    kernels : module
        With `advance` and `greatest_shift_and_speed`.
    features : int
        What the kernels are compiled for.
    memory, load : int
        Numbers that a contact remembers, and of what it does to a grain: force and moment.
    wall_memory : tuple of int
        Rows a grain, and numbers in each, that contacts with walls remember.
    """

    kernels: ModuleType
    features: int
    memory: int
    wall_memory: tuple[int, int]
    load: int

    @abstractmethod
    def motion(self, grains: Grains) -> np.ndarray:
        """Rows of `motion`."""

    @abstractmethod
    def position(self, motion: np.ndarray) -> np.ndarray:
        """Places in rows of `motion`, m, shape (2, N) or (3, N)."""

    @abstractmethod
    def grains(self, motion: np.ndarray, like: Grains) -> Grains:
        """Grains in rows of `motion`; radius and density are those of others."""

    @abstractmethod
    def constants(self, solver: "Solver") -> np.ndarray:
        """Entries of `constants`."""

    @abstractmethod
    def near_wall(self, position: np.ndarray, reach: np.ndarray, solver: "Solver") -> np.ndarray:
        """Mask of the grains nearer than `reach` (N,) to a wall, shape (N,)."""


@dataclass(frozen=True)
class _Discs(Layout):
    memory: int = 2
    wall_memory: tuple[int, int] = (1, 6)
    load: int = 3

    def motion(self, grains: Grains) -> np.ndarray:
        return np.column_stack([grains.position.T, grains.velocity.T, grains.angle, grains.spin])

    def position(self, motion: np.ndarray) -> np.ndarray:
        return motion.T[0:2]

    def grains(self, motion: np.ndarray, like: Grains) -> Grains:
        rows = motion.T
        return Grains(rows[0:2], rows[2:4], rows[4], rows[5], like.radius, like.density)

    def constants(self, solver: "Solver") -> np.ndarray:
        row = np.zeros(self.kernels.CONSTANT_COUNT)
        _fill(row, solver)
        return row

    def near_wall(self, position: np.ndarray, reach: np.ndarray, solver: "Solver") -> np.ndarray:
        x, z = position
        return np.asarray((z < reach) | (x < reach) | (x > solver.width - reach))


@dataclass(frozen=True)
class _Spheres(Layout):
    memory: int = 6
    wall_memory: tuple[int, int] = (5, 6)
    load: int = 6

    def motion(self, grains: Grains) -> np.ndarray:
        return np.column_stack([grains.position.T, grains.velocity.T, grains.angle, grains.spin.T])

    def position(self, motion: np.ndarray) -> np.ndarray:
        return motion.T[0:3]

    def grains(self, motion: np.ndarray, like: Grains) -> Grains:
        rows = motion.T
        return Spheres(rows[0:3], rows[3:6], rows[6], rows[7:10], like.radius, like.density)

    def constants(self, solver: "Solver") -> np.ndarray:
        k, law = self.kernels, solver.law
        row = np.zeros(k.SPHERE_CONSTANT_COUNT)
        _fill(row, solver)
        if isinstance(law, HertzMindlinLaw):
            row[[k.WALL_KN, k.WALL_KT]] = law.wall_effective_modulus, law.wall_shear_modulus
        else:
            row[[k.WALL_KN, k.WALL_KT]] = law.normal_stiffness, law.tangential_stiffness
        row[[k.GLASS_FRICTION, k.BACK_FRICTION]] = law.glass_friction, law.back_friction
        row[k.THICKNESS] = solver.thickness
        return row

    def near_wall(self, position: np.ndarray, reach: np.ndarray, solver: "Solver") -> np.ndarray:
        x, y, z = position
        beside = (y < reach) | (y > solver.thickness - reach)
        return np.asarray((z < reach) | (x < reach) | (x > solver.width - reach) | beside)


def _fill(row: np.ndarray, solver: "Solver") -> None:
    """Entries that discs and spheres have in common."""
    from synth.dem import kernels as k

    law = solver.law
    stiffness = _stiffness(law)
    row[[k.KN, k.KT]] = stiffness
    row[[k.ROOT_KN, k.ROOT_KT]] = np.sqrt(stiffness)
    row[[k.FRICTION, k.WALL_FRICTION, k.TOOL_FRICTION]] = (
        law.friction,
        law.wall_friction,
        law.implement_friction,
    )
    row[k.ROLLING_FRICTION] = law.rolling_friction
    row[k.ROLLING_STIFFNESS] = 2.25 * stiffness[0] * law.rolling_friction**2
    row[k.TIME_STEP] = solver.time_step
    row[[k.GRAVITY_X, k.GRAVITY_Z]] = solver.gravity
    row[[k.WIDTH, k.DRAG, k.COHESION]] = solver.width, solver.drag, law.cohesion


def _stiffness(law: Law) -> tuple[float, float]:
    """Of grains along normal and tangent: N/m, or with Hertz and Mindlin the moduli, Pa."""
    if isinstance(law, ContactLaw):
        return law.normal_stiffness, law.tangential_stiffness
    return law.effective_modulus, law.shear_modulus


def layout_of(grains: Grains, law: Law) -> Layout:
    """The layout of these grains.

    Raises
    ------
    ValueError
        Discs with contacts after Hertz.
    """
    from synth.dem import kernels

    features = kernels.COHESIVE if law.cohesion else 0
    if not isinstance(grains, Spheres):
        if isinstance(law, HertzMindlinLaw):
            raise ValueError("law = 'hertz_mindlin': for spheres only, a slab's thickness is needed")
        return _Discs(kernels, features)
    from synth.dem import sphere_kernels

    if isinstance(law, HertzMindlinLaw):
        features |= sphere_kernels.HERTZIAN
    return _Spheres(sphere_kernels, features)


def body_rows(grains: Grains, law: Law, time_step: float) -> np.ndarray:
    """Rows of `body`: radius, mass, moment of inertia, damping at walls; shape (N, 4)."""
    mass, radius = grains.mass, grains.radius
    damping = contact_damping(law, mass, radius, time_step, boundary=True)
    return np.column_stack([radius, mass, grains.inertia, damping])


def pair_rows(grains: Grains, law: Law, time_step: float, pairs: np.ndarray) -> np.ndarray:
    """Rows of `pair_body`: damping, reduced radius and both radii of every pair, shape (P, 4)."""
    (mi, mj), (ri, rj) = grains.mass[pairs], grains.radius[pairs]
    reach = ri * rj / (ri + rj)
    damping = contact_damping(law, mi * mj / (mi + mj), reach, time_step)
    return np.stack([damping, reach, ri, rj], axis=1)


def tool_row(tool: Tool | None) -> np.ndarray:
    """Entries of `tool`; without an implement, those of one that does nothing."""
    from synth.dem import kernels as k

    row = np.zeros(k.TOOL_SIZE)
    row[[k.TOOL_COS, k.TOOL_MASS]] = 1.0
    if tool is not None:
        row[[k.TOOL_X, k.TOOL_Z, k.TOOL_ANGLE]] = tool.x, tool.z, tool.angle
        row[[k.TOOL_COS, k.TOOL_SIN]] = np.cos(tool.angle), np.sin(tool.angle)
        row[[k.TOOL_VX, k.TOOL_VZ, k.TOOL_SPIN]] = tool.velocity_x, tool.velocity_z, tool.spin
        row[[k.TOOL_MASS, k.TOOL_LOAD, k.TOOL_HEAVES]] = tool.mass, tool.load, tool.heaves
    return row


def part_rows(tool: Tool | None) -> np.ndarray:
    """Capsules of the implement in the columns that the kernels read, shape (C, 6)."""
    if tool is None:
        return np.zeros((1, 6))
    shape = tool.shape
    return np.column_stack([shape.start, shape.end, shape.radius, shape.continues])


def device_array(ti: Any, values: np.ndarray) -> Any:
    """Values (n,), or records (n, k), on the device; at least one: there are no empty arrays there."""
    if len(values) == 0:
        values = np.zeros((1, *values.shape[1:]), values.dtype)
    kind = ti.i32 if values.dtype == np.int32 else ti.f64
    if values.ndim == 1:
        array = ti.ndarray(kind, values.shape)
    else:
        array = ti.Vector.ndarray(values.shape[1], kind, len(values))
    array.from_numpy(np.ascontiguousarray(values))
    return array
