"""How a method does on every pair of the gate's clips, and the baseline file that keeps it."""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ConfigDict, with_config

from synth.text_files import checked, read_json_object
from validation.manifest import file_digest, key_of
from validation.scoring.score import score_pair
from validation.scoring.strata import STRATA
from validation.scoring.truth_pass import TruePair

if TYPE_CHECKING:
    import xarray as xr

SCHEMA_VERSION = 1
SHIPPED_CLIPS = Path(__file__).parent / "clips"
WRONG_ABOVE = "0.3"
"""px, a key of `ErrorSummary.wrong_share`: the 95 % error of the published rotation test."""
LEAST_PIXELS = 200
"""A stratum with fewer pixels in a pair says nothing there."""


class GateError(ValueError):
    """A baseline or clips that cannot be used; the message is one line."""


@with_config(ConfigDict(extra="forbid", allow_inf_nan=False))
@dataclass(frozen=True)
class PairScore:
    """How wrong a method is in one stratum of one picture pair.

    Attributes
    ----------
    coverage : float
        Share of the pixels that was measured.
    median, p95 : float or None
        Of the end-point error over the measured pixels, px; None where nothing was measured.
    wrong_share : float
        Share of all pixels that is wrong by more than 0.3 px, or not measured.
    """

    coverage: float
    median: float | None
    p95: float | None
    wrong_share: float


PairScores = dict[str, PairScore]
"""By stratum; strata without enough pixels are left out."""


@dataclass(frozen=True)
class Measurement:
    """How a method does on every picture pair of every clip: the content of a baseline file.

    Attributes
    ----------
    method : str
        As it was asked for.
    clips_digest : str
        SHA-256 over the clips' pictures and truth.
    clips : dict
        For each clip's name, a `PairScores` for each of its pairs.
    versions : dict
        Of the packages that made it.
    """

    method: str
    clips_digest: str
    clips: dict[str, list[PairScores]]
    versions: dict[str, str]

    def write(self, path: Path) -> None:
        """Write a baseline file."""
        told = {"schema_version": SCHEMA_VERSION} | asdict(self)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(told, indent=1, allow_nan=False) + "\n", encoding="utf-8")

    @classmethod
    def read(cls, path: Path) -> "Measurement":
        """Read a baseline file.

        Raises
        ------
        GateError
            There is none, it is damaged, or of another schema version.
        """
        try:
            return checked(cls, read_json_object(path, schema_version=SCHEMA_VERSION))
        except FileNotFoundError:
            raise GateError(f"{path}: no baseline there: --update writes one") from None
        except ValueError as error:
            raise GateError(f"{path}: not a baseline: {error}") from None


def measure(
    method: str | Callable,
    clips: Path,
    *,
    threads: int | None = None,
    device: str = "cpu",
    progress: Callable[[int, int], None] | None = None,
) -> Measurement:
    """Analyze every clip with a method, and score it against the truth pair by pair.

    Parameters
    ----------
    method : str or callable
        As `soft.analyze` takes it.
    clips : Path
        A folder of footage folders.

    Raises
    ------
    GateError
        There are no clips.
    soft.FlowError
        The method is refused.
    """
    import soft
    import synth
    from validation.versions import package_versions

    folders = find_clips(clips)
    found: dict[str, list[PairScores]] = {}
    for done, folder in enumerate(folders):
        if progress:
            progress(done, len(folders))
        sequence = soft.ImageSequence.open(folder)
        flow = soft.analyze(sequence, method=method, threads=threads, device=device)
        with synth.Footage.open(folder) as footage:
            found[folder.name] = [
                pair_scores(footage.truth(pair), flow.isel(pair=pair)) for pair in range(footage.pair_count)
            ]
    if progress:
        progress(len(folders), len(folders))
    name = method if isinstance(method, str) else method.__name__
    return Measurement(name, clips_digest(folders), found, package_versions())


def find_clips(folder: Path) -> list[Path]:
    """Footage folders in a folder, by name.

    Raises
    ------
    GateError
        There are none.
    """
    found = sorted(path.parent for path in folder.glob("*/truth.nc"))
    if not found:
        raise GateError(f"{folder}: no footage folder in it (a folder with sequence.toml, frames, truth.nc)")
    return found


def clips_digest(folders: list[Path]) -> str:
    """SHA-256 over the files of clips, hexadecimal."""
    names = ("sequence.toml", "truth.nc")
    files = [
        (path.relative_to(folder.parent).as_posix(), file_digest(path))
        for folder in folders
        for path in (*(folder / name for name in names), *sorted(folder.glob("frames/*")))
    ]
    return key_of(files=files)


def pair_scores(truth: "xr.Dataset", flow: "xr.Dataset") -> PairScores:
    """How wrong a flow is in every stratum of one picture pair; both data sets over `y, x`."""
    summaries = score_pair(TruePair(truth), flow)
    return {
        stratum: PairScore(
            coverage=_rounded(summary.coverage) or 0.0,
            median=_rounded(summary.median),
            p95=_rounded(summary.p95),
            wrong_share=_rounded(summary.wrong_share[WRONG_ABOVE]) or 0.0,
        )
        for stratum in STRATA
        if (summary := summaries[stratum]).pixel_count >= LEAST_PIXELS
    }


def _rounded(value: float | None) -> float | None:
    """Six digits are more than any verdict needs, and keep the file's differences readable."""
    return None if value is None else float(f"{value:.6g}")
