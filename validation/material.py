"""What is analyzed: pictures of a run, of a footage folder, or a user's own."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.manifest import RunFolderError, file_digest, key_of
from validation.run_folder import is_run_folder

if TYPE_CHECKING:
    from soft import AnalysisSettings, ImageSequence

TRUTH_FILE = "truth.nc"
SEQUENCE_FILE = "sequence.toml"


@dataclass(frozen=True, eq=False)
class Material:
    """Pictures to analyze.

    Attributes
    ----------
    folder : Path
        Where they lie, or a video; never written to.
    sequence : soft.ImageSequence
        The pictures.
    digest : str
        SHA-256 over the pictures' files, their time step, their scale, and what of them is used, and how.
    files_digest : str
        SHA-256 over the pictures' files alone.
    """

    folder: Path
    sequence: "ImageSequence"
    digest: str
    files_digest: str

    @classmethod
    def open(cls, folder: Path, settings: "AnalysisSettings | None" = None) -> "Material":
        """Open a folder of pictures, or a video.

        Parameters
        ----------
        settings : soft.AnalysisSettings, optional
            Which pictures are used, and how they are calibrated and masked.

        Raises
        ------
        soft.SequenceError, soft.CalibrationError
            Pictures that cannot be used, or not so.
        """
        from soft import AnalysisSettings, open_sequence

        settings = settings or AnalysisSettings()
        sequence = open_sequence(folder, settings)
        pictures = list(zip(_names(folder, sequence), map(file_digest, sequence.files), strict=True))
        digest = key_of(
            pictures=pictures,
            metres_per_pixel=sequence.metres_per_pixel,
            frame_rate=sequence.frame_rate,
            **_view(settings),
        )
        return cls(folder, sequence, digest, key_of(pictures=pictures))

    @property
    def truth(self) -> Path:
        """Where the truth about the pictures is, if it is known."""
        return self.folder / TRUTH_FILE

    @property
    def has_truth(self) -> bool:
        """Whether there is something to score against."""
        return self.truth.is_file() and (self.folder / SEQUENCE_FILE).is_file()


def _names(folder: Path, sequence: "ImageSequence") -> list[str]:
    """Names of what is read: of pictures within their folder, of others their own."""
    inside = (folder in file.parents for file in sequence.files)
    return [
        file.relative_to(folder).as_posix() if is_inside else file.name
        for file, is_inside in zip(sequence.files, inside, strict=True)
    ]


def _view(settings: "AnalysisSettings") -> dict[str, Any]:
    """What of the pictures is used, and how, where that is not all as it is.

    The pixel size and the frame rate are told by the sequence, masks by their files.
    """
    from soft import AnalysisSettings

    chosen, plain = (
        {
            "frames": one.frames.model_dump(exclude={"frame_rate"}),
            "calibration": one.calibration.model_dump(mode="json", exclude={"metres_per_pixel", "lens"}),
            "region": None if one.region is None else one.region.model_dump(),
        }
        for one in (settings, AnalysisSettings())
    )
    view: dict[str, Any] = {} if chosen == plain else {"view": chosen}
    lens = settings.calibration.lens
    return view if lens is None else view | {"lens": file_digest(lens)}


def results_folder(path: Path, out: Path | None) -> Path:
    """Where results about `path` go: into a run folder itself, for anything else into `out`.

    Parameters
    ----------
    path : Path
        A run folder, a footage folder, a folder of pictures, or a video.
    out : Path or None
        What the user asked for; None means `./<name>-softbed`.

    Raises
    ------
    RunFolderError
        There is no such folder or video, or the results would lie inside a folder that is never written to.
    """
    from soft.sequence.video import VIDEO_SUFFIXES, is_video

    if not path.is_dir() and not is_video(path):
        what = (
            "is a file, a folder of pictures or a video is needed"
            if path.exists()
            else f"no such {'video' if path.suffix in VIDEO_SUFFIXES else 'folder'}"
        )
        raise RunFolderError(f"{path}: {what}")
    if out is None and is_run_folder(path):
        return path
    chosen = out or Path(f"{(path.resolve().name if path.is_dir() else path.stem)}-softbed")
    if chosen.resolve().is_relative_to(path.resolve()):
        raise RunFolderError(
            f"{chosen}: lies inside {path}, which is never written to: choose a folder elsewhere with --out"
        )
    return chosen
