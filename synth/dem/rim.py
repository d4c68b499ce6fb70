"""The elastic rim of a tool in the rows that the kernels work on, and what a run tells about it."""

from dataclasses import dataclass, replace

import numpy as np

from synth.dem.grains import Grains
from synth.dem.tool import Tool
from synth.implements import Shape

_CARRYING = 0.95
"""Share of the upward force that the contact's length carries: single grains at its ends do not count."""


def unloaded_rim(tool: Tool) -> Tool:
    """The tool with its nodes where nothing acts on them, moving with the hub."""
    assert tool.ring is not None
    sine, cosine = np.sin(tool.angle), np.cos(tool.angle)
    offset = tool.ring.unloaded @ np.array([[cosine, sine], [-sine, cosine]])
    turning = tool.spin * np.stack([-offset[:, 1], offset[:, 0]], axis=1)
    velocity = turning + np.array([tool.velocity_x, tool.velocity_z])
    return replace(tool, nodes=offset + np.array([tool.x, tool.z]), node_velocity=velocity)


def rim_rows(tool: Tool | None) -> np.ndarray:
    """Nodes in the columns of `rim_kernels`, shape (N, 8); of a rigid tool none."""
    from synth.dem import rim_kernels as k

    if tool is None or tool.ring is None:
        return np.zeros((0, k.NODE_SIZE))
    if tool.nodes is None:
        tool = unloaded_rim(tool)
    assert tool.ring is not None and tool.nodes is not None and tool.node_velocity is not None
    return np.column_stack([tool.nodes, tool.node_velocity, np.zeros_like(tool.nodes), tool.ring.unloaded])


def ring_row(tool: Tool | None) -> np.ndarray:
    """Constants of the rim in the entries of `rim_kernels`, and no impulse yet."""
    from synth.dem import rim_kernels as k

    row = np.zeros(k.RING_SIZE)
    if tool is not None and tool.ring is not None:
        ring = tool.ring
        row[[k.NODE_MASS, k.DAMPING]] = ring.node_mass, ring.damping
        row[[k.RADIAL, k.TANGENTIAL]] = ring.radial_stiffness, ring.tangential_stiffness
        row[[k.HOOP, k.BENDING]] = ring.hoop_stiffness, ring.bending_stiffness
        row[[k.BAR_LENGTH, k.HINGE_ANGLE]] = ring.bar_length, ring.hinge_angle
    return row


def with_nodes(tool: Tool, rows: np.ndarray) -> Tool:
    """The tool with its nodes as the kernels have left them."""
    return replace(tool, nodes=rows[:, 0:2].copy(), node_velocity=rows[:, 2:4].copy())


@dataclass(frozen=True)
class RimState:
    """What a rim looks like at a moment.

    Attributes
    ----------
    deflection : float
        How much nearer the axle is to the rim's lowest point than to that of the unloaded one, m.
    contact_length : float
        Horizontal extent of the contacts that carry the middle 95 % of the upward force, m; 0: none.
    rolling_radius : float
        Mean speed of the rim along the bin over that extent, as seen from the axle, / angular velocity, m;
        NaN where the wheel does not turn or touches nothing.
    """

    deflection: float
    contact_length: float
    rolling_radius: float


def rim_state(tool: Tool, grains: Grains) -> RimState:
    """Measure a wheel with an elastic rim among grains."""
    assert tool.nodes is not None and tool.node_velocity is not None
    section = tool.section
    left, right = contact_extent(section, grains.position.T - (tool.x, tool.z), grains.radius)
    x = tool.nodes[:, 0] - tool.x
    below = (x >= left) & (x <= right) & (tool.nodes[:, 1] < tool.z)
    radius = np.nan
    if below.any() and tool.spin != 0:
        radius = float((tool.node_velocity[below, 0] - tool.velocity_x).mean()) / tool.spin
    return RimState(tool.shape.reach + section.lowest, right - left, radius)


def contact_extent(section: Shape, offset: np.ndarray, radius: np.ndarray) -> tuple[float, float]:
    """Ends, from the reference point, of the contacts that carry the middle 95 % of the upward force, m.

    Forces are those of the contacts' springs; (0, 0) where nothing touches.

    Parameters
    ----------
    section : Shape
        The implement as it stands.
    offset : ndarray, shape (N, 2)
        Grains' centres from the reference point, m.
    radius : ndarray, shape (N,)
        m.
    """
    near = np.flatnonzero(np.hypot(*offset.T) < section.reach + radius)
    x, upward = _upward_forces(section, offset[near], radius[near])
    if upward.sum() <= 0:
        return 0.0, 0.0
    order = np.argsort(x)
    share = np.cumsum(upward[order]) / upward.sum()
    rest = (1 - _CARRYING) / 2
    left, right = np.searchsorted(share, [rest, 1 - rest])
    return float(x[order[left]]), float(x[order[min(right, x.size - 1)]])


def _upward_forces(section: Shape, points: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where grains at `points` (n, 2) touch, and their upward push / stiffness, m: shape (contacts,)."""
    grain, part = np.nonzero(section.distance_to_capsules(points) < radius[:, None])
    start, along = section.start[part], section.end[part] - section.start[part]
    length = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(((points[grain] - start) * along).sum(axis=1) / length, 0, 1)
    owned = (share > 0) | ~section.continues[part]
    towards = (start + share[:, None] * along - points[grain])[owned]
    distance = np.hypot(*towards.T)
    overlap = (section.radius[part] + radius[grain])[owned] - distance
    return points[grain[owned], 0], np.maximum(overlap * towards[:, 1] / distance, 0)
