"""What is analyzed: pictures of a run, of a footage folder, or a user's own."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from validation.manifest import RunFolderError, file_digest, key_of
from validation.run_folder import is_run_folder

if TYPE_CHECKING:
    from soft import ImageSequence

TRUTH_FILE = "truth.nc"
SEQUENCE_FILE = "sequence.toml"


@dataclass(frozen=True, eq=False)
class Material:
    """Pictures to analyze.

    Attributes
    ----------
    folder : Path
        Where they lie; never written to.
    sequence : soft.ImageSequence
        The pictures.
    digest : str
        SHA-256 over the pictures' files, their time step and their scale.
    """

    folder: Path
    sequence: "ImageSequence"
    digest: str

    @classmethod
    def open(
        cls, folder: Path, *, metres_per_pixel: float | None = None, frame_rate: float | None = None
    ) -> "Material":
        """Open a folder of pictures.

        Raises
        ------
        soft.SequenceError
            Pictures that cannot be used.
        """
        from soft import ImageSequence

        sequence = ImageSequence.open(folder, metres_per_pixel=metres_per_pixel, frame_rate=frame_rate)
        digest = key_of(
            pictures=[(name, file_digest(folder / name)) for name in sequence.names],
            metres_per_pixel=sequence.metres_per_pixel,
            frame_rate=sequence.frame_rate,
        )
        return cls(folder, sequence, digest)

    @property
    def truth(self) -> Path:
        """Where the truth about the pictures is, if it is known."""
        return self.folder / TRUTH_FILE

    @property
    def has_truth(self) -> bool:
        """Whether there is something to score against."""
        return self.truth.is_file() and (self.folder / SEQUENCE_FILE).is_file()


def results_folder(path: Path, out: Path | None) -> Path:
    """Where results about `path` go: into a run folder itself, for anything else into `out`.

    Parameters
    ----------
    path : Path
        A run folder, a footage folder, or a folder of pictures.
    out : Path or None
        What the user asked for; None means `./<name>-softbed`.

    Raises
    ------
    RunFolderError
        There is no such folder, or the results would lie inside a folder that is never written to.
    """
    if not path.is_dir():
        what = "is a file, a folder of pictures is needed" if path.exists() else "no such folder"
        raise RunFolderError(f"{path}: {what}")
    if out is None and is_run_folder(path):
        return path
    chosen = out or Path(f"{path.resolve().name}-softbed")
    if chosen.resolve().is_relative_to(path.resolve()):
        raise RunFolderError(
            f"{chosen}: lies inside {path}, which is never written to: choose a folder elsewhere with --out"
        )
    return chosen
