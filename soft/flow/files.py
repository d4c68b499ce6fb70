"""Flow measured elsewhere: a folder of files, in order of name, read instead of measured.

Middlebury `.flo`, one a picture pair, has motion at every pixel. `.csv`, `.txt` (one a pair) and `.mat` (one
or several pairs each) have it at the nodes of a grid; what their numbers mean is told by options or by a file
`grid.toml` in the folder.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from soft.flow.estimator import Estimator
from soft.flow.field import FlowError, FlowField
from soft.flow.flo import read_flo
from soft.flow.grid import GridConventions, to_field
from soft.flow.grid_mat import count_grids, read_mat_grid
from soft.flow.grid_text import read_text_grid
from soft.flow.options import build_options, require_count
from soft.natural_order import natural_key
from soft.toml_file import read_toml

PREFIX = "files:"
KINDS = (".flo", ".csv", ".txt", ".mat")
CONVENTIONS_FILE = "grid.toml"
_MATLAB_ORIGIN = 1.0


@dataclass(frozen=True)
class FilesOptions:
    """`pair` is the index of the pair that is wanted, from 0; the rest as in `GridConventions`.

    What is None is taken from the folder's `grid.toml` or, where that is silent, is `forward`, `down` and 0
    (of `.mat` files 1).
    """

    pair: int
    convention: str | None = None
    y: str | None = None
    origin: float | None = None

    def __post_init__(self) -> None:
        require_count("pair", self.pair, least=0)

    @property
    def told(self) -> dict[str, object]:
        """Conventions that are given."""
        return {name: value for name, value in asdict(self).items() if name != "pair" and value is not None}


class FlowFiles:
    """The flow files of a folder, sorted by name with numbers in order of value.

    Parameters
    ----------
    folder : str or Path
        Where they lie.

    Raises
    ------
    FlowError
        If the folder is missing, holds no such file or several kinds of them.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise FlowError(f"{PREFIX}{self.folder}: no such folder")
        found = {kind: sorted(self.folder.glob(f"*{kind}"), key=natural_key) for kind in KINDS}
        kinds = [kind for kind, paths in found.items() if paths]
        if not kinds:
            raise FlowError(f"{PREFIX}{self.folder}: holds no {', '.join(KINDS[:-1])} or {KINDS[-1]} file")
        if len(kinds) > 1:
            raise FlowError(f"{PREFIX}{self.folder}: holds {' and '.join(kinds)} files: must be of one kind")
        self.kind = kinds[0]
        self.paths = found[self.kind]
        self._places = [(path, k) for path in self.paths for k in range(self._pairs_in(path))]

    def __len__(self) -> int:
        return len(self._places)

    @property
    def gridded(self) -> bool:
        """Whether they tell of nodes of a grid."""
        return self.kind != ".flo"

    @property
    def sources(self) -> list[Path]:
        """Every file that the flow depends on."""
        told = self.folder / CONVENTIONS_FILE
        return self.paths + ([told] if self.gridded and told.is_file() else [])

    def conventions(self, told: Mapping[str, object]) -> GridConventions | None:
        """What a grid's numbers mean: as told, as `grid.toml` has it, or by default; None for `.flo`.

        Raises
        ------
        FlowError
            Something is told of `.flo` files, which have one meaning only, or is not possible.
        """
        if not self.gridded:
            if told:
                raise FlowError(f"{PREFIX}{self.folder}: {', '.join(told)}: not for .flo files")
            return None
        values: dict[str, object] = {"origin": _MATLAB_ORIGIN} if self.kind == ".mat" else {}
        values |= self._written() | dict(told)
        return build_options(GridConventions, f"{PREFIX}{self.folder}", values)

    def read(self, pair: int, shape: tuple[int, int], **told: object) -> FlowField:
        """Flow of one pair; `shape` is the pictures' (H, W), `told` as in `GridConventions`.

        Raises
        ------
        FlowError
            If there is none for this pair, its size is not the pictures', or the file is not right.
        """
        conventions = self.conventions(told)
        if pair >= len(self):
            raise FlowError(f"{PREFIX}{self.folder}: {self._held()}: none for pair {pair}")
        path, index = self._places[pair]
        if conventions is None:
            return _read_dense(path, shape)
        grid = read_mat_grid(path, index) if self.kind == ".mat" else read_text_grid(path)
        return to_field(grid, conventions, shape, name=str(path))

    def require_pairs(self, count: int) -> None:
        """Refuse the folder unless it has exactly one field for each of `count` pairs."""
        if len(self) != count:
            raise FlowError(f"{PREFIX}{self.folder}: {self._held()} for {count} pairs: one each is needed")

    def _pairs_in(self, path: Path) -> int:
        return count_grids(path) if self.kind == ".mat" else 1

    def _held(self) -> str:
        pairs = f" with {len(self)} pairs" if self.kind == ".mat" else ""
        return f"{len(self.paths)} {self.kind} files{pairs}"

    def _written(self) -> dict[str, object]:
        path = self.folder / CONVENTIONS_FILE
        if not path.is_file():
            return {}
        try:
            return read_toml(path)
        except (OSError, ValueError) as error:
            raise FlowError(f"{path}: not readable TOML: {error}") from error


def _read_dense(path: Path, shape: tuple[int, int]) -> FlowField:
    flow = read_flo(path)
    if flow.shape[:2] != shape:
        raise FlowError(
            f"{path}: {flow.shape[1]} x {flow.shape[0]} px, but the pictures have {shape[1]} x {shape[0]} px"
        )
    return FlowField(flow, np.ones(shape, bool))


def from_files(method: str) -> Estimator:
    """Make an estimator that reads instead of measuring, from `files:FOLDER`."""
    files = FlowFiles(method.removeprefix(PREFIX))

    def solve(first: np.ndarray, second: np.ndarray, mask: np.ndarray, options: FilesOptions) -> FlowField:
        return files.read(options.pair, (first.shape[0], first.shape[1]), **options.told).where(mask)

    def resolved(options: FilesOptions) -> dict[str, object]:
        conventions = files.conventions(options.told)
        return {} if conventions is None else asdict(conventions)

    return Estimator(
        method,
        FilesOptions,
        solve,
        resolved=resolved,
        own_texture=True,
        forward_backward=False,
        gridded=files.gridded,
        reversible=False,
    )
