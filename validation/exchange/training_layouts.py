"""Data sets laid out as MPI-Sintel and KITTI 2015 have it, so that flow networks' own loaders read them.

Each split is a root of its own, since those layouts have no truth in their test part: give `OUT/train` to a
loader and ask it for its training part. Pictures are 8 bit, the three colours equal.

- Sintel (Butler, Wulff, Stanley, Black, ECCV 2012): `SPLIT/Sintel/training/clean/SEQUENCE/frame_0001.png`,
  `flow/SEQUENCE/frame_0001.flo`, `invalid/SEQUENCE/frame_0001.png` (white: not known).
- KITTI 2015 (Menze and Geiger, CVPR 2015): `SPLIT/KittiFlow/training/image_2/000000_10.png` and `_11.png`,
  `flow_occ/000000_10.png` (16 bit); `pairs.csv` tells which pair of which sequence a number is.
"""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from synth.dataset.sweep import SPLITS

if TYPE_CHECKING:
    from synth.dataset.loading import DataSet, FlowPair, SequenceOfPairs

Progress = Callable[[int, int], None]


def write_training_layout(
    data: "DataSet", layout: str, folder: Path, *, progress: Progress | None = None
) -> None:
    """Write all pairs of a data set.

    Parameters
    ----------
    layout : str
        A key of `LAYOUTS`.
    folder : Path
        Where to; must exist.
    progress : callable, optional
        Called with the sequences done and the sequences in all.

    Raises
    ------
    soft.FlowError
        A displacement that the format cannot hold.
    """
    done, total = 0, len(data.sequences)
    for split in SPLITS:
        sequences = data.split(split)
        if not sequences:
            continue
        write = LAYOUTS[layout](folder / split)
        for sequence in sequences:
            write(sequence)
            done += 1
            if progress is not None:
                progress(done, total)


class _Sintel:
    def __init__(self, root: Path) -> None:
        self._root = root / "Sintel" / "training"

    def __call__(self, sequence: "SequenceOfPairs") -> None:
        from soft.flow.flo import write_flo

        clean, flow, invalid = (self._folder(kind, sequence) for kind in ("clean", "flow", "invalid"))
        for index, pair in enumerate(sequence.pairs()):
            name = f"frame_{index + 1:04d}"
            _write_picture(clean / f"{name}.png", pair.first)
            write_flo(flow / f"{name}.flo", pair.flow)
            _write_grey(invalid / f"{name}.png", np.where(pair.valid, 0, 255).astype(np.uint8))
        _write_picture(clean / f"frame_{sequence.frame_count:04d}.png", pair.second)

    def _folder(self, kind: str, sequence: "SequenceOfPairs") -> Path:
        folder = self._root / kind / sequence.name
        folder.mkdir(parents=True)
        return folder


class _Kitti:
    def __init__(self, root: Path) -> None:
        self._root = root / "KittiFlow" / "training"
        for kind in ("image_2", "flow_occ"):
            (self._root / kind).mkdir(parents=True)
        self._number = 0
        with self._index.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerow(["number", "sequence", "pair"])

    @property
    def _index(self) -> Path:
        return self._root / "pairs.csv"

    def __call__(self, sequence: "SequenceOfPairs") -> None:
        with self._index.open("a", newline="", encoding="utf-8") as file:
            table = csv.writer(file, lineterminator="\n")
            for index, pair in enumerate(sequence.pairs()):
                self._write(pair)
                table.writerow([f"{self._number:06d}", sequence.name, index])
                self._number += 1

    def _write(self, pair: "FlowPair") -> None:
        from soft.flow.kitti import write_kitti

        name = f"{self._number:06d}"
        _write_picture(self._root / "image_2" / f"{name}_10.png", pair.first)
        _write_picture(self._root / "image_2" / f"{name}_11.png", pair.second)
        write_kitti(self._root / "flow_occ" / f"{name}_10.png", pair.flow)


LAYOUTS: dict[str, Callable[[Path], Callable[["SequenceOfPairs"], None]]] = {
    "sintel": _Sintel,
    "kitti-flow": _Kitti,
}


def _write_picture(path: Path, picture: np.ndarray) -> None:
    """Write grey levels in three equal colours: what these loaders expect."""
    levels = picture if picture.dtype == np.uint8 else np.rint(picture / 257).astype(np.uint8)
    _write_grey(path, np.repeat(levels[:, :, None], 3, axis=2))


def _write_grey(path: Path, picture: np.ndarray) -> None:
    import cv2

    if not cv2.imwrite(str(path), picture):
        raise OSError(f"{path}: cannot be written")
