"""A solid of any section: a closed outline, drawn by hand or cut out of an STL."""

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from synth.implements.rigid_wheel import RigidWheel
from synth.implements.shape import Shape
from synth.table import Table

MOST_POINTS = 2000
"""Corners of an outline, at most: every grain nearby is held against every edge."""

Point = Annotated[list[float], Field(min_length=2, max_length=2)]
Points = Annotated[list[Point], Field(min_length=3, max_length=MOST_POINTS, description="m, x and z")]


class OutlineError(ValueError):
    """An outline that encloses nothing, or crosses itself."""


class Outline(Table):
    """A tool: all that its outline encloses is solid. Corners are joined in order, the last to the first."""

    kind: Literal["outline"]
    width: float = Field(gt=0, le=1, description="m, of the half-width implement")
    points: Points
    source: str = Field(default="", description="where the outline comes from")

    @model_validator(mode="after")
    def _encloses(self) -> Self:
        check_outline(np.array(self.points))
        return self

    @property
    def shape(self) -> Shape:
        """The outline."""
        return Shape.outline(np.array(self.points))


class OutlineWheel(RigidWheel):
    """A wheel of any section, which rolls about its reference point.

    `radius` is the rolling radius: that of rim speed and slip.
    """

    kind: Literal["outline_wheel"]  # type: ignore[assignment]
    points: Points
    source: str = Field(default="", description="where the outline comes from")

    @model_validator(mode="after")
    def _encloses(self) -> Self:
        check_outline(np.array(self.points))
        return self

    @property
    def shape(self) -> Shape:
        """The outline."""
        return Shape.outline(np.array(self.points))


def signed_area(points: np.ndarray) -> float:
    """Area that an outline (K, 2) encloses, m2; negative where it runs clockwise."""
    x, z = points.T
    return 0.5 * float(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1)))


def check_outline(points: np.ndarray) -> None:
    """Refuse an outline (K, 2) that encloses nothing or crosses itself.

    Raises
    ------
    OutlineError
        Naming the edges, counted from 0.
    """
    extent = float(np.ptp(points, axis=0).max())
    if abs(signed_area(points)) <= 1e-9 * extent**2:
        raise OutlineError(f"points: these {len(points)} enclose no area")
    for edge in range(len(points) - 2):
        crossed = _crossed_by(points, edge)
        if crossed.size:
            raise OutlineError(f"points: edge {edge} crosses edge {crossed[0]}: an outline without is needed")


def _crossed_by(points: np.ndarray, edge: int) -> np.ndarray:
    """Later edges, its neighbours left out, that an edge crosses or touches."""
    others = np.arange(edge + 2, len(points) - (edge == 0))
    start, end = points[edge], points[edge + 1]
    first, second = points[others], points[(others + 1) % len(points)]
    apart = _side(start, end, first) * _side(start, end, second) > 0
    apart |= _side(first, second, start) * _side(first, second, end) > 0
    low, high = np.minimum(start, end), np.maximum(start, end)
    apart |= ((np.maximum(first, second) < low) | (np.minimum(first, second) > high)).any(axis=1)
    return others[~apart]


def _side(start: np.ndarray, end: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Positive where a point is left of the line from `start` to `end`, as seen along it."""
    along, offset = end - start, point - start
    return along[..., 0] * offset[..., 1] - along[..., 1] * offset[..., 0]
