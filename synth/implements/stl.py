"""An STL file cut by the glass: the section's outline becomes the implement."""

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from pydantic import Field

from synth.implements.outline import MOST_POINTS, Point, signed_area
from synth.table import Table

if TYPE_CHECKING:
    import trimesh

_SAME = 1e-7
"""Ends of a section's pieces nearer than this share of its size are one point: STL has single precision."""

Axis = Literal["+x", "-x", "+y", "-y", "+z", "-z"]


class StlError(ValueError):
    """An STL file that cannot be used; the message names the key, the value and what is allowed."""


class Stl(Table):
    """How a file becomes an implement: what a scene may say instead of an outline.

    The glass cuts the body across `along` and `up`. Its section, in metres, is moved so that `reference`
    comes to lie at the implement's reference point: a wheel's axle, a tool's point that `drive.start` is of.
    With `normal_load` and `moving_mass` it is a wheel; without, a tool that cuts.
    """

    kind: Literal["stl"]
    file: str = Field(min_length=1, description="path, relative to the scene file")
    scale: float = Field(gt=0, description="m per unit of the file")
    along: Axis = Field(default="+x", description="the file's axis that points along the bin")
    up: Axis = Field(default="+z", description="the file's axis that points up")
    slice: float = Field(default=0.0, description="m along the third axis: where the glass is")
    reference: Point = Field(default=[0.0, 0.0], description="m along `along` and `up`")
    tolerance: float = Field(
        default=1e-4, ge=0, le=0.01, description="m that the outline may be off, to have fewer corners"
    )
    width: float = Field(gt=0, le=1, description="m, of the half-width implement")
    normal_load: float | None = Field(default=None, gt=0, description="N, on the half-width wheel")
    moving_mass: float | None = Field(default=None, gt=0, description="kg, that rises and sinks")
    radius: float | None = Field(
        default=None, gt=0, le=1, description="m, rolling radius; default: the section's reach"
    )

    def outlined(self, folder: Path) -> dict[str, Any]:
        """Cut the file, which is in `folder`: the table of an `Outline` or `OutlineWheel`.

        Raises
        ------
        StlError
            The file cannot be read, is not one watertight body, or the cut does not give one outline.
        """
        path = folder / self.file
        points = self._section(_read(path, self.file))
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        common: dict[str, Any] = {
            "width": self.width,
            "points": points.tolist(),
            "source": f"{path.name} (SHA-256 {digest}) cut at slice = {self.slice:g} m",
        }
        wheel = {"normal_load": self.normal_load, "moving_mass": self.moving_mass}
        if all(value is None for value in (*wheel.values(), self.radius)):
            return {"kind": "outline", **common}
        for key, value in wheel.items():
            if value is None:
                raise StlError(f"{key}: missing: a wheel has normal_load and moving_mass, another tool none")
        radius = self.radius or float(np.hypot(*points.T).max())
        return {"kind": "outline_wheel", "radius": radius, **wheel, **common}

    def _section(self, mesh: "trimesh.Trimesh") -> np.ndarray:
        """Outline of the cut, m, counter-clockwise from its lowest point, shape (K, 2)."""
        loops = _loops(self._pieces(mesh))
        if not loops:
            across = mesh.vertices @ self._axes()[1] * self.scale
            raise StlError(
                f"slice = {self.slice:g}: no section there: the body is between "
                f"{across.min():.6g} and {across.max():.6g} m"
            )
        outline = max(loops, key=lambda loop: abs(signed_area(loop)))
        beside = [loop for loop in loops if loop is not outline and not _within(loop, outline)]
        if beside:
            raise StlError(
                f"slice = {self.slice:g}: the section there has {1 + len(beside)} separate parts, "
                "one is allowed: cut elsewhere"
            )
        simple = _simplified(outline, self.tolerance)
        if len(simple) > MOST_POINTS:
            raise StlError(
                f"tolerance = {self.tolerance:g}: the outline still has {len(simple)} corners, at most "
                f"{MOST_POINTS} are allowed: take it higher"
            )
        return simple - np.array(self.reference)

    def _pieces(self, mesh: "trimesh.Trimesh") -> np.ndarray:
        """Straight pieces of the section, not in order, m, shape (n, 2, 2)."""
        import trimesh

        plane, normal = self._axes()
        pieces = trimesh.intersections.mesh_plane(mesh, normal, normal * (self.slice / self.scale))
        return np.asarray(pieces, float).reshape(-1, 2, 3) @ plane * self.scale

    def _axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Unit vectors of `along` and `up` as columns (3, 2), and the third axis, always positive, (3,)."""
        if self.along[1] == self.up[1]:
            raise StlError(f"up = {self.up!r}: along = {self.along!r} is the same axis: another is needed")
        plane = np.stack([_unit(self.along), _unit(self.up)], axis=1)
        return plane, np.abs(np.cross(*plane.T))


def _unit(axis: str) -> np.ndarray:
    vector = np.zeros(3)
    vector["xyz".index(axis[1])] = 1.0 if axis[0] == "+" else -1.0
    return vector


def _read(path: Path, name: str) -> "trimesh.Trimesh":
    """One watertight body."""
    import trimesh

    if not path.is_file():
        raise StlError(f"file = {name!r}: no such file: {path}")
    try:
        mesh = trimesh.load_mesh(path, file_type="stl")
    except Exception as error:  # trimesh lets through whatever its parsers meet
        raise StlError(f"file = {name!r}: not an STL file: {error}") from None
    if len(mesh.faces) == 0:
        raise StlError(f"file = {name!r}: holds no triangle")
    if not mesh.is_watertight:
        raise StlError(f"file = {name!r}: the body is not watertight: its surface must be closed")
    if mesh.body_count != 1:
        raise StlError(f"file = {name!r}: holds {mesh.body_count} bodies, one is allowed")
    return mesh


def _loops(pieces: np.ndarray) -> list[np.ndarray]:
    """Closed outlines that straight pieces (n, 2, 2) make, each of shape (K, 2).

    Raises
    ------
    StlError
        They do not close, or branch: the cut runs along a face or through a pinched edge.
    """
    if len(pieces) == 0:
        return []
    ends = pieces.reshape(-1, 2)
    grid = np.round(ends / (_SAME * np.ptp(ends, axis=0).max())).astype(np.int64)
    _, first, corner = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    edges = {tuple(sorted(edge)) for edge in corner.reshape(-1, 2).tolist() if edge[0] != edge[1]}
    beside: dict[int, list[int]] = {}
    for start, end in sorted(edges):
        beside.setdefault(start, []).append(end)
        beside.setdefault(end, []).append(start)
    if any(len(others) != 2 for others in beside.values()):
        raise StlError("slice: the cut runs along a face or touches itself there: move it a little")
    loops = []
    while beside:
        loops.append(ends[first[_walk(beside)]])
    return loops


def _walk(beside: dict[int, list[int]]) -> list[int]:
    """Corners of one loop, in order; they are taken out of `beside`."""
    corner: int | None = min(beside)
    loop = []
    while corner is not None:
        loop.append(corner)
        corner = next((other for other in beside.pop(corner) if other in beside), None)
    return loop


def _within(loop: np.ndarray, outline: np.ndarray) -> bool:
    """Whether a loop, which does not cross an outline, is inside of it: soil cannot get there."""
    from synth.implements.shape import Shape

    return bool(Shape.outline(outline).encloses(loop[:1])[0])


def _simplified(outline: np.ndarray, tolerance: float) -> np.ndarray:
    """The outline with the fewest corners that Douglas and Peucker's way leaves, none off by more, m."""
    import cv2

    if signed_area(outline) < 0:
        outline = outline[::-1]
    outline = np.roll(outline, -int(np.lexsort(outline.T)[0]), axis=0)
    span = float(np.ptp(outline, axis=0).max())
    # OpenCV works in single precision; what it keeps is found again among the exact points.
    rough = ((outline - outline.mean(axis=0)) / span).astype(np.float32)
    kept = cv2.approxPolyDP(rough, max(tolerance / span, 1e-6), True)[:, 0]
    apart = np.abs(rough[:, None] - kept[None]).sum(axis=2)
    return outline[np.sort(apart.argmin(axis=0))]
