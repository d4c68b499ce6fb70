"""Cut a window and some frames out of footage: small enough to be shipped, whole enough to be scored."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from soft import Region

if TYPE_CHECKING:
    import xarray as xr

    from synth import Footage

_STEPS_PER_UNIT = {
    "distance_to_implement": 16,
    "distance_to_discontinuity": 16,
}
_OTHER_STEPS_PER_UNIT = 4096
_ENCODING = {"zlib": True, "complevel": 9, "shuffle": True}

_CARD = """\
# A clip of the footage of the scene `{scene}`

Frames {first} to {last}, {width} x {height} px from column {x} and row {y} on, of footage with the scene hash
{scene_hash}, seed {seed}. Nothing in here was photographed or measured.

`truth.nc` has the true motion between consecutive frames as the footage has it, but for two things: what
moves out of the window is not `valid`, and numbers are rounded so that they take less room, distances to a
sixteenth of a px, all else to 1/4096 of its unit (displacements by 0.00012 px at most). `SHA256SUMS` has the
SHA-256 of every file: `softbed check .`.

Licence of this data: {licence}.
"""


class ClipError(ValueError):
    """Frames that footage does not have, or a folder that may not be written; the message is one line."""


def parse_frames(text: str) -> tuple[int, int]:
    """Read `FIRST:LAST`.

    Raises
    ------
    ClipError
        It is none.
    """
    first, separator, last = text.partition(":")
    if not separator or not (first.strip().isdecimal() and last.strip().isdecimal()):
        raise ClipError(f"frames {text!r}: FIRST:LAST are needed, whole numbers from 0")
    return int(first), int(last)


def clip_footage(footage: "Footage", out: Path, *, region: Region, first: int, last: int) -> None:
    """Write a part of `footage` as footage of its own.

    Parameters
    ----------
    footage : synth.Footage
        Where it is cut from.
    out : Path
        A folder that does not exist yet; it appears when it is whole.
    region : soft.Region
        What of every picture.
    first, last : int
        The first and the last frame.

    Raises
    ------
    ClipError
        The footage has no such frames, or `out` exists.
    soft.SequenceError
        Its pictures are smaller than the region.
    """
    _require(footage, region, first, last)
    if out.exists():
        raise ClipError(f"{out}: exists: a clip is written to a new folder")
    out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}-") as draft:
        folder = Path(draft) / out.name
        _write(footage, folder, region, first, last)
        folder.rename(out)


def _require(footage: "Footage", region: Region, first: int, last: int) -> None:
    if not 0 <= first < last < footage.frame_count:
        raise ClipError(
            f"frames {first} to {last}: two or more of 0 to {footage.frame_count - 1} are needed "
            f"({footage.folder})"
        )
    sizes = footage.truths.sizes
    region.require_within((sizes["y"], sizes["x"]), name=str(footage.folder))


def _write(footage: "Footage", folder: Path, region: Region, first: int, last: int) -> None:
    from synth.checksums import write_checksums
    from synth.footage import frame_name, write_picture, write_sequence

    (folder / frame_name(0)).parent.mkdir(parents=True)
    write_sequence(folder, footage.frame_rate, footage.metres_per_pixel, last - first + 1)
    for number, frame in enumerate(range(first, last + 1)):
        picture = footage.picture(frame)[region.rows, region.columns]
        write_picture(folder / frame_name(number), np.ascontiguousarray(picture))
    truth = _truth(footage, region, first, last)
    encoding = {name: _ENCODING for name, variable in truth.data_vars.items() if variable.ndim == 3}
    truth.to_netcdf(folder / "truth.nc", engine="h5netcdf", encoding=encoding)
    _write_card(truth, folder, region, first, last)
    write_checksums(folder)


def _truth(footage: "Footage", region: Region, first: int, last: int) -> "xr.Dataset":
    part = {"pair": slice(first, last), "y": region.rows, "x": region.columns}
    truth = footage.truths.isel(part).load()
    for name, variable in truth.data_vars.items():
        if variable.ndim == 3 and variable.dtype.kind == "f":
            steps = _STEPS_PER_UNIT.get(str(name), _OTHER_STEPS_PER_UNIT)
            truth[name] = variable.copy(data=_rounded(variable.values, steps))
        truth[name].encoding = {}
    truth["valid"] = truth["valid"].copy(data=truth["valid"].values & _stays(truth))
    pairs = np.arange(last - first, dtype=np.int32)
    truth["first_frame"] = truth["first_frame"].copy(data=pairs)
    truth["second_frame"] = truth["second_frame"].copy(data=pairs + 1)
    truth.attrs["clip"] = (
        f"frames {first} to {last}, columns from {region.x}, rows from {region.y}; rounded: distances to "
        f"1/16 px, all else to 1/{_OTHER_STEPS_PER_UNIT} of its unit"
    )
    return truth


def _stays(truth: "xr.Dataset") -> np.ndarray:
    """Whether what is seen is within the region in the second picture, too."""
    height, width = truth.sizes["y"], truth.sizes["x"]
    x = truth["u"].values + np.arange(width, dtype=np.float32)
    y = truth["v"].values + np.arange(height, dtype=np.float32)[:, np.newaxis]
    return (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)


def _rounded(values: np.ndarray, steps: int) -> np.ndarray:
    """Round to 1 / `steps`, a power of two, so that values stay exact in float32; NaN and infinity stay."""
    return (np.rint(values * np.float32(steps)) / np.float32(steps)).astype(values.dtype)


def _write_card(truth: "xr.Dataset", folder: Path, region: Region, first: int, last: int) -> None:
    from synth.data_card import CARD_FILE

    told = truth.attrs
    card = _CARD.format(
        scene=told["scene"],
        scene_hash=told["scene_hash"],
        seed=told["seed"],
        licence=told["license"],
        first=first,
        last=last,
        x=region.x,
        y=region.y,
        width=region.width,
        height=region.height,
    )
    (folder / CARD_FILE).write_text(card, encoding="utf-8")
