"""VTK's XML files, as ParaView reads them: lines (`.vtp`), images (`.vti`), series in time (`.pvd`).

After "VTK XML file formats" of the VTK documentation: arrays are inline, base64 of a 64-bit byte count and
the values, little-endian; those of images are compressed.
"""

import base64
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

_IMAGE_TYPES = {"u1": ("UInt8", "u1"), "f4": ("Float32", "<f4"), "f8": ("Float64", "<f8")}
_COMPRESSION = 1
_TYPES = {"f": ("Float64", "<f8"), "i": ("Int64", "<i8")}


def write_polydata(
    path: Path,
    points: np.ndarray,
    *,
    point_data: Mapping[str, np.ndarray] | None = None,
    lines: Iterable[np.ndarray] | None = None,
    cell_data: Mapping[str, np.ndarray] | None = None,
) -> None:
    """Write points, or lines through them.

    Parameters
    ----------
    path : Path
        A `.vtp`.
    points : ndarray, shape (N, 3)
    point_data : dict of ndarray, shape (N,) or (N, 3)
        Named values.
    lines : iterable of ndarray of int, optional
        Indices of the points along each line; without, every point stands for itself.
    cell_data : dict of ndarray, shape (lines,) or (lines, 3)
        Named values of the lines.
    """
    root = _root("PolyData")
    cells = [np.array([index]) for index in range(len(points))] if lines is None else list(lines)
    kind = "Verts" if lines is None else "Lines"
    counts = {"NumberOfPoints": len(points), f"NumberOf{kind}": len(cells)}
    poly = ElementTree.SubElement(root, "PolyData")
    piece = ElementTree.SubElement(poly, "Piece", {name: str(count) for name, count in counts.items()})
    _add_array(ElementTree.SubElement(piece, "Points"), "Points", np.asarray(points, float))
    cell = ElementTree.SubElement(piece, kind)
    _add_array(cell, "connectivity", np.concatenate([np.zeros(0, int), *cells]))
    _add_array(cell, "offsets", np.cumsum([len(indices) for indices in cells], dtype=int))
    for kind, arrays in (("PointData", point_data), ("CellData", cell_data)):
        data = ElementTree.SubElement(piece, kind)
        for name, values in (arrays or {}).items():
            _add_array(data, name, values)
    _write(root, path)


def write_image(path: Path, point_data: Mapping[str, np.ndarray], *, spacing: float) -> None:
    """Write values at the pixels of an image; bytes, 32-bit and 64-bit floats keep their type.

    Parameters
    ----------
    path : Path
        A `.vti`.
    point_data : dict of ndarray, shape (H, W) or (H, W, 3)
        Named values, the lowest row first.
    spacing : float
        From a pixel's centre to the next; the centre of the lowest one to the left is the origin.
    """
    height, width = next(iter(point_data.values())).shape[:2]
    root = _root("ImageData")
    root.set("compressor", "vtkZLibDataCompressor")
    extent = f"0 {width - 1} 0 {height - 1} 0 0"
    place = {"WholeExtent": extent, "Origin": "0 0 0", "Spacing": f"{spacing!r} {spacing!r} {spacing!r}"}
    piece = ElementTree.SubElement(ElementTree.SubElement(root, "ImageData", place), "Piece", Extent=extent)
    data = ElementTree.SubElement(piece, "PointData")
    for name, values in point_data.items():
        kind, form = _IMAGE_TYPES[values.dtype.str[1:]]
        components = values.shape[2] if values.ndim == 3 else 1
        content = np.ascontiguousarray(values, form).tobytes()
        packed = zlib.compress(content, _COMPRESSION)
        # Of one block: how many, its length, that of a shorter last one (none), packed length.
        header = np.array([1, len(content), 0, len(packed)], "<u8").tobytes()
        array = ElementTree.SubElement(
            data, "DataArray", type=kind, Name=name, NumberOfComponents=str(components), format="binary"
        )
        array.text = base64.b64encode(header).decode("ascii") + base64.b64encode(packed).decode("ascii")
    _write(root, path)


def write_series(path: Path, times: Iterable[float], files: Iterable[str]) -> None:
    """Write a `.pvd`: files beside it, and their times in s."""
    root = _root("Collection")
    collection = ElementTree.SubElement(root, "Collection")
    for time, file in zip(times, files, strict=True):
        ElementTree.SubElement(collection, "DataSet", timestep=repr(float(time)), part="0", file=file)
    _write(root, path)


def _root(kind: str) -> ElementTree.Element:
    return ElementTree.Element(
        "VTKFile", type=kind, version="1.0", byte_order="LittleEndian", header_type="UInt64"
    )


def _add_array(parent: ElementTree.Element, name: str, values: np.ndarray) -> None:
    kind, form = _TYPES[values.dtype.kind]
    components = 1 if values.ndim == 1 else values.shape[1]
    array = ElementTree.SubElement(
        parent, "DataArray", type=kind, Name=name, NumberOfComponents=str(components), format="binary"
    )
    content = np.ascontiguousarray(values, form).tobytes()
    array.text = base64.b64encode(np.array(len(content), "<u8").tobytes() + content).decode("ascii")


def _write(root: ElementTree.Element, path: Path) -> None:
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
