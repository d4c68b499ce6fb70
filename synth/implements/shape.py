"""The outline of an implement: capsules, which grains can touch and pictures can show."""

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True, eq=False)
class Shape:
    """An implement's section in its own frame: x along the bin, z up, the reference point at the origin.

    Grains touch capsules: all points within a radius of a line from `start` to `end`. A wheel is one capsule
    of no length; a blade is a chain of them, in which an end that the next capsule starts from belongs to one
    of the two only.

    Attributes
    ----------
    start, end : ndarray, shape (C, 2)
        m.
    radius : ndarray, shape (C,)
        m.
    continues : ndarray of bool, shape (C,)
        The capsule starts where another one ends: that point is touched through the other one.
    closed : ndarray of bool, shape (C,), optional
        The capsule is an edge of a closed outline, whose inside is solid. Default: none is.
    """

    start: np.ndarray
    end: np.ndarray
    radius: np.ndarray
    continues: np.ndarray
    closed: np.ndarray = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        if self.closed is None:
            object.__setattr__(self, "closed", np.zeros(self.radius.size, bool))

    @classmethod
    def disc(cls, radius: float) -> "Shape":
        """A wheel about the origin."""
        return cls(np.zeros((1, 2)), np.zeros((1, 2)), np.array([radius]), np.zeros(1, bool))

    @classmethod
    def chain(cls, points: np.ndarray, radius: float) -> "Shape":
        """A bent blade along points (K, 2), m."""
        points = np.asarray(points, float)
        count = len(points) - 1
        return cls(points[:-1], points[1:], np.full(count, radius), np.arange(count) > 0)

    @classmethod
    def outline(cls, points: np.ndarray) -> "Shape":
        """A solid with the corners `points` (K, 2), m, without repeating the first one at the end.

        Its edges are capsules without thickness: a grain's surface touches them where the solid's is.
        """
        points = np.asarray(points, float)
        whole = np.ones(len(points), bool)
        return cls(points, np.roll(points, -1, axis=0), np.zeros(len(points)), whole, whole.copy())

    def joined(self, other: "Shape") -> "Shape":
        """Both shapes as one implement."""
        return Shape(
            np.concatenate([self.start, other.start]),
            np.concatenate([self.end, other.end]),
            np.concatenate([self.radius, other.radius]),
            np.concatenate([self.continues, other.continues]),
            np.concatenate([self.closed, other.closed]),
        )

    def only(self, chosen: np.ndarray) -> "Shape":
        """The chosen capsules, by mask."""
        columns = (self.start, self.end, self.radius, self.continues, self.closed)
        return Shape(*(column[chosen] for column in columns))

    def distance_to_capsules(self, points: np.ndarray) -> np.ndarray:
        """Distance of points (n, 2) of the implement's frame to every capsule, m, negative inside: (n, C)."""
        along = self.end - self.start
        length = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
        offset = points[:, None, :] - self.start
        share = np.clip((offset * along).sum(axis=2) / length, 0, 1)
        return np.hypot(*np.moveaxis(offset - share[:, :, None] * along, 2, 0)) - self.radius

    def encloses(self, points: np.ndarray) -> np.ndarray:
        """Whether points (n, 2) of the implement's frame are inside a closed outline: bool, shape (n,)."""
        start, end = self.start[self.closed], self.end[self.closed]
        x, z = np.asarray(points, float).T[:, :, None]
        across = (start[:, 1] > z) != (end[:, 1] > z)
        rise = np.where(start[:, 1] == end[:, 1], 1.0, end[:, 1] - start[:, 1])
        crossing = start[:, 0] + (z - start[:, 1]) / rise * (end[:, 0] - start[:, 0])
        return (across & (x < crossing)).sum(axis=1) % 2 == 1

    @property
    def reach(self) -> float:
        """Greatest distance of a point of the implement from the origin, m."""
        ends = np.maximum(np.hypot(*self.start.T), np.hypot(*self.end.T))
        return float((ends + self.radius).max())

    @property
    def lowest(self) -> float:
        """Height of the lowest point above the origin, m; negative below."""
        return float((np.minimum(self.start[:, 1], self.end[:, 1]) - self.radius).min())

    def turned(self, angle: float) -> "Shape":
        """The same about the origin, turned counter-clockwise by `angle` (rad)."""
        sine, cosine = np.sin(angle), np.cos(angle)
        rotation = np.array([[cosine, sine], [-sine, cosine]])
        return replace(self, start=self.start @ rotation, end=self.end @ rotation)
