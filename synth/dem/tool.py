"""The implement among the grains: its pose and motion, and which grains may touch which of its parts."""

from dataclasses import dataclass

import numpy as np

from synth.dem.grains import Grains
from synth.implements import Shape
from synth.implements.compliant_wheel import rim_shape
from synth.implements.ring import Ring


@dataclass(frozen=True, eq=False)
class Tool:
    """An implement that travels and turns as told, and rises and sinks as told or under a load.

    Per metre of width. World frame; rotation counter-clockwise positive.

    Attributes
    ----------
    shape : Shape
    x, z, angle : float
        Pose of the reference point, m and rad.
    velocity_x, velocity_z, spin : float
        m/s and rad/s.
    mass : float
        That rises and sinks, kg/m.
    load : float
        Presses it down, N/m.
    heaves : bool
        It rises and sinks under its load, else at `velocity_z`.
    ring : Ring or None
        Its elastic rim; `mass` is then without that.
    nodes, node_velocity : ndarray or None, shape (N, 2)
        The rim's nodes in the world, m, and their velocities, m/s; None: unloaded, and moving with the hub.
    """

    shape: Shape
    x: float
    z: float
    angle: float = 0.0
    velocity_x: float = 0.0
    velocity_z: float = 0.0
    spin: float = 0.0
    mass: float = 1.0
    load: float = 0.0
    heaves: bool = False
    ring: Ring | None = None
    nodes: np.ndarray | None = None
    node_velocity: np.ndarray | None = None

    @property
    def section(self) -> Shape:
        """The shape as it stands about the reference point: turned, and deformed where it is elastic."""
        if self.ring is None or self.nodes is None:
            return self.shape.turned(self.angle)
        return rim_shape(self.nodes - (self.x, self.z), self.ring.half_thickness)

    @property
    def lowest(self) -> float:
        """Height of its lowest point, m."""
        return self.z + self.section.lowest

    def shift_since(self, other: "Tool") -> float:
        """Bound of how far any point of its surface has moved since another pose, m."""
        if self.nodes is not None and other.nodes is not None:  # a bar moves no further than its ends
            return float(np.hypot(*(self.nodes - other.nodes).T).max())
        arm = np.hypot(*np.concatenate([self.shape.start, self.shape.end]).T).max()
        travel = np.hypot(self.x - other.x, self.z - other.z)
        return float(travel + arm * abs(self.angle - other.angle))


@dataclass(frozen=True)
class ToolImpulse:
    """What the grains did to the implement over an interval: integrals over time, per metre of width."""

    x: float
    z: float
    moment: float


@dataclass(frozen=True)
class ToolContacts:
    """Grains that may touch parts of the implement until something has moved by half a skin.

    Attributes
    ----------
    near_tool : ndarray of int32, shape (N,)
        Place of a grain among those near the implement; -1: not near.
    first_contact : ndarray of int32, shape (near + 1,)
        Where a near grain's contacts begin.
    parts : ndarray of int32, shape (K,)
        The part of each contact, by grain and then by part.
    keys : ndarray of int64, shape (K,)
        One ascending integer a contact, the same for the same grain and part in every list.
    """

    near_tool: np.ndarray
    first_contact: np.ndarray
    parts: np.ndarray
    keys: np.ndarray

    @classmethod
    def none(cls, grain_count: int) -> "ToolContacts":
        """No implement."""
        nothing = np.zeros(0, np.int32)
        return cls(
            np.full(grain_count, -1, np.int32), np.zeros(1, np.int32), nothing, nothing.astype(np.int64)
        )

    @classmethod
    def of(cls, grain: np.ndarray, part: np.ndarray, *, grain_count: int, part_count: int) -> "ToolContacts":
        """List pairs of a grain and a part, each of shape (K,), that come by grain and then by part."""
        near, count = np.unique(grain, return_counts=True)
        near_tool = np.full(grain_count, -1, np.int32)
        near_tool[near] = np.arange(near.size)
        first = np.concatenate([[0], np.cumsum(count)]).astype(np.int32)
        return cls(near_tool, first, part.astype(np.int32), grain.astype(np.int64) * part_count + part)


def list_tool_contacts(grains: Grains, position: np.ndarray, tool: Tool, skin: float) -> ToolContacts:
    """List the grains whose surfaces are nearer than `skin` (m) to parts of the implement.

    Parameters
    ----------
    position : ndarray, shape (2, N)
        Where the grains are now along the bin and upwards, m.
    """
    offset = position.T - (tool.x, tool.z)
    section = tool.section
    around = np.flatnonzero(np.hypot(*offset.T) < section.reach + grains.radius + skin)
    gap = section.distance_to_capsules(offset[around]) - grains.radius[around, None]
    place, part = np.nonzero(gap < skin)
    return ToolContacts.of(around[place], part, grain_count=grains.count, part_count=tool.shape.radius.size)
