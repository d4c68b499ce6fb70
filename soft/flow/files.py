"""Flow measured elsewhere: a folder of Middlebury `.flo` files, in order of name, one for each pair."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from soft.flow.estimator import Estimator
from soft.flow.field import FlowError, FlowField
from soft.flow.flo import read_flo
from soft.flow.options import require_count
from soft.natural_order import natural_key

PREFIX = "files:"


@dataclass(frozen=True)
class FilesOptions:
    """`pair` is the index of the pair whose file is wanted, from 0."""

    pair: int

    def __post_init__(self) -> None:
        require_count("pair", self.pair, least=0)


class FlowFiles:
    """The `.flo` files of a folder, sorted by name with numbers in order of value.

    Parameters
    ----------
    folder : str or Path
        Where they lie.

    Raises
    ------
    FlowError
        If the folder is missing or holds no `.flo` file.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise FlowError(f"{PREFIX}{self.folder}: no such folder")
        self.paths = sorted(self.folder.glob("*.flo"), key=natural_key)
        if not self.paths:
            raise FlowError(f"{PREFIX}{self.folder}: holds no .flo file")

    def __len__(self) -> int:
        return len(self.paths)

    def read(self, pair: int, shape: tuple[int, int]) -> np.ndarray:
        """Displacement (H, W, 2) float32 px of one pair; `shape` is the pictures' (H, W).

        Raises
        ------
        FlowError
            If there is no file for this pair, or its size is not the pictures'.
        """
        if pair >= len(self):
            raise FlowError(f"{PREFIX}{self.folder}: {len(self)} .flo files: none for pair {pair}")
        flow = read_flo(self.paths[pair])
        if flow.shape[:2] != shape:
            raise FlowError(
                f"{self.paths[pair]}: {flow.shape[1]} x {flow.shape[0]} px, but the pictures have "
                f"{shape[1]} x {shape[0]} px"
            )
        return flow

    def require_pairs(self, count: int) -> None:
        """Refuse the folder unless it has exactly one file for each of `count` pairs."""
        if len(self) != count:
            raise FlowError(
                f"{PREFIX}{self.folder}: {len(self)} .flo files for {count} pairs: one each is needed"
            )


def from_files(method: str) -> Estimator:
    """Make an estimator that reads instead of measuring, from `files:FOLDER`."""
    files = FlowFiles(method.removeprefix(PREFIX))

    def solve(first: np.ndarray, second: np.ndarray, mask: np.ndarray, options: FilesOptions) -> FlowField:
        return FlowField(files.read(options.pair, (first.shape[0], first.shape[1])), mask)

    return Estimator(method, FilesOptions, solve, own_texture=True, forward_backward=False, reversible=False)
