"""`README.md` of footage: what a stranger must know to use the data."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

    from synth.footage import Footage
    from synth.scene import AnalyticScene, AnyScene

CARD_FILE = "README.md"

_CARD = """\
# Footage of the scene `{scene}`

{description}.

{count} synthetic grey pictures of {width} x {height} px and {bits} bit in `frames/`, and for each consecutive
pair the true motion at every pixel in `truth.nc` (netCDF-4). Seed {seed}{quick}. Nothing in here was
photographed or measured.

- {rate:g} pictures a second, {scale:g} mm/px (`sequence.toml`).
- Image frame: x right, y down, integer coordinates at pixel centres. Displacements (u, v) are px, forward
  from the first picture to the second, on the first picture's pixels.
- {truth}
- Scene hash {scene_hash}.
- `SHA256SUMS` has the SHA-256 of every file: `softbed check .`, or `sha256sum --check SHA256SUMS`.

Licence of this data: {licence}.

## Variables of `truth.nc`

Values are not scaled, compressed without loss (gzip), in chunks of {chunk}, so that one pair is read without
the others: `xarray.open_dataset("truth.nc").isel(pair=0)`. Bytes are those in memory; the file takes
{file_bytes} bytes.

| variable | shape | type | unit | meaning | bytes |
| --- | --- | --- | --- | --- | ---: |
{rows}

`sequence.toml` names the pictures in order (`frames`), pictures a second (`frame_rate`) and the size of a
pixel on the glass in m (`metres_per_pixel`).
"""

_RENDERED = """\
What a pixel shows is the micro-grain that covers its centre, and that moves as a rigid body: its motion is
  the truth there."""
_ANALYTIC = """\
Grains are round and their centres follow a formula; the truth is that formula at the pixel's centre. A
  rigid motion is met exactly. Where soil is strained, what is seen at the distance d (px) from a grain's
  centre differs from it by at most d times the largest principal strain (px/px)."""
_SCORED = """
- Only pixels within {radius:g} px of the picture's middle are `valid`."""


def write_data_card(footage: "Footage", scene: "AnyScene") -> None:
    """Write `README.md` into a footage folder."""
    from synth.scene import AnalyticScene

    camera, timing = scene.camera, scene.timing
    card = _CARD.format(
        scene=scene.name,
        description=scene.description.rstrip("."),
        count=footage.frame_count,
        width=camera.width,
        height=camera.height,
        bits=scene.sensor.bits,
        seed=scene.seed,
        quick=", the quick version: smaller and coarser" if scene.quick else "",
        rate=timing.frame_rate,
        scale=1000 * camera.metres_per_pixel,
        truth=_analytic(scene) if isinstance(scene, AnalyticScene) else _RENDERED,
        scene_hash=scene.hash,
        licence=scene.data_licence,
        chunk=f"1 x {camera.height} x {camera.width}",
        file_bytes=(footage.folder / "truth.nc").stat().st_size,
        rows="\n".join(_row(name, variable) for name, variable in footage.variables.items()),
    )
    Path(footage.folder / CARD_FILE).write_text(card, encoding="utf-8")


def _analytic(scene: "AnalyticScene") -> str:
    radius = scene.camera.scored_radius
    return _ANALYTIC if radius is None else _ANALYTIC + _SCORED.format(radius=radius)


def _row(name: str, variable: "xr.Variable") -> str:
    shape = " x ".join(f"{size} {dim}" for dim, size in variable.sizes.items())
    told = variable.attrs
    size = variable.size * variable.dtype.itemsize
    return f"| `{name}` | {shape} | {variable.dtype} | {told['units']} | {told['long_name']} | {size} |"
