"""What a figure or a film is made of: pictures, what one method measured, and the truth if it is known."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from validation.manifest import RunFolderError
from validation.methods import DEFAULT, Method

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from validation.material import Material
    from validation.pair_view import PairView
    from validation.run_folder import RunFolder
    from validation.scoring.truth_pass import TruePair


@dataclass(frozen=True, eq=False)
class Subject:
    """One analysis and its pictures.

    Attributes
    ----------
    name : str
        Of the folder that was given.
    run : RunFolder
        Where the analysis is.
    material : Material
        The pictures.
    method : Method
        Which analysis.
    flow : xarray.Dataset
        The SoilFlow, read as it is used.
    """

    name: str
    run: "RunFolder"
    material: "Material"
    method: Method
    flow: "xr.Dataset"

    @property
    def pair_count(self) -> int:
        """Number of picture pairs."""
        return int(self.flow.sizes["pair"])

    def require_pair(self, pair: int | None) -> int:
        """The number of a pair: as given, counted from the end if negative, else the one in the middle.

        Raises
        ------
        RunFolderError
            There is none of this number.
        """
        from validation.pair_view import middle_pair

        count = self.pair_count
        if pair is None:
            return middle_pair(count)
        if not -count <= pair < count:
            raise RunFolderError(f"--pair: {pair}: {self.name} has {count} pairs, 0 to {count - 1}")
        return pair % count

    def picture(self, pair: int) -> "np.ndarray":
        """The first picture of a pair, (H, W) grey 0-255."""
        return self.material.sequence[int(self.flow["first_frame"][pair])]

    def true_pair(self, pair: int) -> "TruePair":
        """The truth of a pair.

        Raises
        ------
        ScoreError
            There is none.
        """
        from validation import chain
        from validation.pair_view import read_true_pair

        chain.require_truth(self.material)
        return read_true_pair(self.material, pair)

    def view(self, pair: int, *, true: "TruePair | None" = None) -> "PairView":
        """A pair with its truth, which is read unless it was read before.

        Raises
        ------
        ScoreError
            There is none.
        """
        from validation.pair_view import view_pair

        return view_pair(self.run, self.material, [self.method], pair, true=true or self.true_pair(pair))


@contextmanager
def opened_subject(
    path: Path, run: "RunFolder", material: "Material", *, method: str | None = None
) -> Iterator[Subject]:
    """Open an analysis of pictures.

    Parameters
    ----------
    path : Path
        What was asked for.
    method : str, optional
        Which analysis; without it the default method's, or the first there is.

    Raises
    ------
    RunFolderError
        There is no such analysis, or it is of other pictures.
    """
    import soft

    chosen = _chosen(path, run, method)
    record = run.manifest.steps.get(f"analyze {chosen.slug}")
    measured_in = record.facts.get("picture_files") if record else None
    if measured_in not in (None, material.files_digest):
        raise RunFolderError(f"{run.analysis(chosen.slug)}: not of the pictures in {material.folder}")
    with soft.read_soil_flow(run.analysis(chosen.slug)) as flow:
        height, width = material.sequence.shape
        if (flow.sizes["y"], flow.sizes["x"]) != (height, width) or _last_frame(flow) >= len(
            material.sequence
        ):
            raise RunFolderError(f"{run.analysis(chosen.slug)}: not of the pictures in {material.folder}")
        yield Subject(path.resolve().name, run, material, chosen, flow)


def _last_frame(flow: "xr.Dataset") -> int:
    return int(flow["second_frame"].max())


def _chosen(path: Path, run: "RunFolder", method: str | None) -> Method:
    there = sorted(file.stem for file in (run.path / "analysis").glob("*.nc"))
    if method is not None:
        wanted = Method(method)
        if wanted.slug not in there:
            told = f"analyzed with {', '.join(there)}" if there else "not analyzed yet"
            raise RunFolderError(
                f"--method: {method}: {run.path} is {told}: "
                f"run `softbed analyze {path} --method {method}` first"
            )
        return wanted
    if not there:
        raise RunFolderError(f"{run.path}: not analyzed yet: run `softbed analyze {path}` first")
    return Method(DEFAULT if DEFAULT in there else there[0])
