"""A wheel with an elastic rim in the picture: which point of its side is where.

The side gives way from the hub, which does not, to the rim linearly along the line from the axle. All is in
the wheel's own frame, which turns with the hub: px from the axle, y down.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

HUB = 0.25
"""Radius of the rigid hub / that of the unloaded wheel."""
_DIRECTIONS = 1440
_MOST_ITERATIONS = 200
_CLOSE = 1e-4
"""px."""


def rigid() -> "np.ndarray":
    """The table of a wheel that nothing deforms, shape (1, 4)."""
    import numpy as np

    return np.zeros((1, 4))


def rim_table(nodes: "np.ndarray", unloaded: "np.ndarray", half_thickness: float) -> "np.ndarray":
    """What happens to the rim in evenly spaced directions from -pi to pi, shape (A, 4), px.

    Columns: radius of its surface, its displacement from where it is unloaded, and the hub's radius.

    Parameters
    ----------
    nodes, unloaded : ndarray, shape (N, 2)
        Points of its middle line, deformed and not, px.
    """
    import numpy as np

    at = np.linspace(-np.pi, np.pi, _DIRECTIONS, endpoint=False)

    def around(points: np.ndarray, values: np.ndarray) -> np.ndarray:
        return np.interp(at, np.arctan2(points[:, 1], points[:, 0]), values, period=2 * np.pi)

    along = np.roll(nodes, -1, axis=0) - np.roll(nodes, 1, axis=0)
    outwards = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    outwards *= np.sign((outwards * nodes).sum(axis=1))[:, None]
    surface = nodes + half_thickness * outwards
    hub = HUB * (np.hypot(*unloaded.T) + half_thickness)
    moved = (nodes - unloaded).T
    columns = (np.hypot(*surface.T), moved[0], moved[1], hub)
    return np.stack([around(surface if i == 0 else nodes, one) for i, one in enumerate(columns)], axis=1)


def material_points(rim: "np.ndarray", points: "np.ndarray") -> "np.ndarray":
    """Where points of the deformed side, (n, 2), are while nothing acts."""
    return points - _displacement(rim, points)


def deformed_points(rim: "np.ndarray", material: "np.ndarray") -> "np.ndarray":
    """Where points of the unloaded side, (n, 2), have gone to: the inverse of `material_points`."""
    import numpy as np

    points, share = material + _displacement(rim, material), 1.0
    miss = material - material_points(rim, points)
    for _ in range(_MOST_ITERATIONS):
        if np.abs(miss).max(initial=0.0) < _CLOSE:
            break
        ahead = points + share * miss
        ahead_miss = material - material_points(rim, ahead)
        if np.abs(ahead_miss).max() > np.abs(miss).max():
            share = max(0.1, share / 2)
        points, miss = ahead, ahead_miss
    return points


def _displacement(rim: "np.ndarray", points: "np.ndarray") -> "np.ndarray":
    import numpy as np

    if len(rim) == 1:
        return np.zeros_like(points)
    place = (np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi) + 0.5) * len(rim)
    first = np.floor(place).astype(int)
    part = (place - first)[:, None]
    here = (1 - part) * rim[first % len(rim)] + part * rim[(first + 1) % len(rim)]
    share = np.clip((np.hypot(*points.T) - here[:, 3]) / (here[:, 0] - here[:, 3]), 0, 1)
    return share[:, None] * here[:, 1:3]
