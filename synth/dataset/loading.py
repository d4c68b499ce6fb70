"""A data set read: its sequences by split, and their picture pairs with the true motion, as NumPy arrays."""

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from synth.dataset.folder import MANIFEST_FILE, MEMBERS_FILE, DataSetError, DataSetFolder
from synth.dataset.summary import MADE, read_manifest
from synth.dataset.sweep import SPLITS
from synth.footage import Footage

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from synth.scene import AnyScene

_MASKS = ("valid", "soil", "implement", "mixed")
_FORMS = {
    "name": r"[0-9a-f]+",
    "simulation": r"[0-9a-f]+",
    "split": "|".join(SPLITS),
    "frames": r"[1-9]\d{0,5}",
}
"""Of what `members.csv` says; names are folders, which exports make, too."""
_OWN_COLUMNS = ("name", "split", "simulation", "status", "frames", "seconds", "bytes")


@dataclass(frozen=True, eq=False)
class FlowPair:
    """Two pictures and the true motion between them.

    Attributes
    ----------
    first, second : ndarray of uint8 or uint16, shape (H, W)
        Grey pictures.
    flow : ndarray of float32, shape (H, W, 2)
        Displacement (u, v), px, x right and y down, forward, on the first picture's pixels; NaN where not
        valid.
    valid, soil, implement, mixed : ndarray of bool, shape (H, W)
        Masks of the first picture, as `truth.nc` defines them.
    """

    first: "np.ndarray"
    second: "np.ndarray"
    flow: "np.ndarray"
    valid: "np.ndarray"
    soil: "np.ndarray"
    implement: "np.ndarray"
    mixed: "np.ndarray"


@dataclass(frozen=True)
class SequenceOfPairs:
    """One sequence of a data set; nothing of it is open.

    Attributes
    ----------
    name : str
    split : str
    simulation : str
        Sequences of one simulation show the same motion.
    values : dict of str
        What was varied, as `members.csv` spells it.
    folder : Path
        Footage, `scene.toml` and `facts.json`.
    frame_count : int
    """

    name: str
    split: str
    simulation: str
    values: dict[str, str]
    folder: Path
    frame_count: int

    @property
    def pair_count(self) -> int:
        """Number of consecutive pairs."""
        return self.frame_count - 1

    def scene(self) -> "AnyScene":
        """Every number that it was made from."""
        from synth.scene import load_scene

        return load_scene(self.folder / "scene.toml")

    def pair(self, index: int) -> FlowPair:
        """Read a pair: of the truth, only what is needed.

        Raises
        ------
        IndexError
            No such pair.
        DataSetError
            It is damaged.
        """
        if not 0 <= index < self.pair_count:
            raise IndexError(f"pair = {index}: allowed are 0 to {self.pair_count - 1}")
        try:
            return self._read(index)
        except Exception as error:  # HDF5's readers raise whatever the damage leads to
            raise DataSetError(f"{self.folder}: pair {index} is damaged: {error}") from error

    def _read(self, index: int) -> FlowPair:
        import h5netcdf
        import numpy as np

        from synth.footage import frame_name, read_picture

        first, second = (read_picture(self.folder / frame_name(index + step)) for step in (0, 1))
        with h5netcdf.File(self.folder / "truth.nc", "r") as truth:
            flow = np.stack([truth.variables[name][index] for name in ("u", "v")], axis=-1)
            masks = {name: truth.variables[name][index].astype(bool) for name in _MASKS}
        flow[~masks["valid"]] = np.nan
        return FlowPair(first, second, flow, **masks)

    def pairs(self) -> Iterator[FlowPair]:
        """All pairs, one after the other."""
        return (self.pair(index) for index in range(self.pair_count))

    def open(self) -> Footage:
        """The same as footage: pictures, and all of the truth as xarray. Close it, or use it in a `with`."""
        return Footage.open(self.folder)

    def to_xarray(self) -> "xr.Dataset":
        """Pictures and truth, read only where they are used: `picture` over `frame, y, x`; see `truth.nc`.

        Close it, or use it in a `with`.
        """
        from synth.dataset.lazy_pictures import lazy_pictures

        footage = self.open()
        pictures = lazy_pictures(footage)
        data = footage.truths.assign(picture=pictures)
        data.set_close(footage.close)
        return data


class Pairs(Sequence[FlowPair]):
    """Pairs of several sequences as one list: `pairs[17]` reads the eighteenth."""

    def __init__(self, sequences: "Sequence[SequenceOfPairs]") -> None:
        self._places = [(one, index) for one in sequences for index in range(one.pair_count)]

    def __len__(self) -> int:
        return len(self._places)

    @overload
    def __getitem__(self, index: int) -> FlowPair: ...
    @overload
    def __getitem__(self, index: slice) -> "list[FlowPair]": ...
    def __getitem__(self, index: "int | slice") -> "FlowPair | list[FlowPair]":
        if isinstance(index, slice):
            return [one.pair(number) for one, number in self._places[index]]
        one, number = self._places[index]
        return one.pair(number)

    def place(self, index: int) -> tuple[SequenceOfPairs, int]:
        """Which sequence a pair is of, and which of its pairs it is."""
        return self._places[index]


@dataclass(frozen=True)
class DataSet:
    """A data set on disk; sequences that could not be made are not in it.

    Attributes
    ----------
    folder : Path
    manifest : dict
        What `manifest.json` holds.
    sequences : tuple of SequenceOfPairs
    """

    folder: Path
    manifest: dict[str, Any]
    sequences: tuple[SequenceOfPairs, ...]

    def split(self, name: str) -> tuple[SequenceOfPairs, ...]:
        """Sequences of a split.

        Raises
        ------
        ValueError
            No such split.
        """
        if name not in SPLITS:
            raise ValueError(f"split = {name!r}: allowed are {', '.join(SPLITS)}")
        return tuple(one for one in self.sequences if one.split == name)

    def pairs(self, split: str) -> Pairs:
        """All pairs of a split."""
        return Pairs(self.split(split))


def load_data_set(folder: str | Path) -> DataSet:
    """Open a data set that `softbed sweep` made.

    Raises
    ------
    DataSetError
        There is none, or it is of another schema version; says what to do.
    """
    place = DataSetFolder(Path(folder))
    manifest = read_manifest(place)
    if manifest is None:
        raise DataSetError(f"{folder}: not a data set: it holds no {MANIFEST_FILE}")
    path = place.path / MEMBERS_FILE
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if row["status"] == MADE]
        return DataSet(place.path, manifest, tuple(_sequence(place, row) for row in rows))
    except OSError as error:
        raise DataSetError(f"{error.filename}: {error.strerror}") from None
    except (KeyError, TypeError, ValueError, csv.Error) as error:
        raise DataSetError(f"{path}: not a table of members: {error}") from None


def _sequence(place: DataSetFolder, row: dict[str, str]) -> SequenceOfPairs:
    for key, form in _FORMS.items():
        if not re.fullmatch(form, row[key]):
            raise ValueError(f"{key} = {row[key]!r}: must be of the form {form}")
    return SequenceOfPairs(
        name=row["name"],
        split=row["split"],
        simulation=row["simulation"],
        values={key: value for key, value in row.items() if key not in _OWN_COLUMNS},
        folder=place.sequence(row["name"]),
        frame_count=int(row["frames"]),
    )
