"""The folder of a data set: the names in it, and how what is made in it comes to be whole."""

import shutil
from collections.abc import Iterator, Set
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from synth.disk import written_whole
from synth.locks import locked

SWEEP_FILE = "sweep.toml"
BASE_FILE = "base.toml"
MANIFEST_FILE = "manifest.json"
MEMBERS_FILE = "members.csv"
FAILURES_FILE = "failures.csv"
CARD_FILE = "data_card.md"
FACTS_FILE = "facts.json"
CHECKPOINT = "checkpoint"
_WORK = ".work"
_LOCK = "lock"


class DataSetError(ValueError):
    """A data set's folder that cannot be used as asked; the message is one line."""


@dataclass(frozen=True)
class DataSetFolder:
    """Where everything of a data set is.

    Under a final name nothing is ever half-written: it is made in a work folder and renamed. A work folder
    has a lock, so that what two processes want is made by one of them, be they of different clusters.

    Attributes
    ----------
    path : Path
    """

    path: Path

    def recording(self, simulation: str) -> Path:
        """Recording of a simulation."""
        return self.path / "recordings" / f"{simulation}.nc"

    def sequence(self, name: str) -> Path:
        """Footage of a member, with its scene and what is known of it."""
        return self.path / "sequences" / name

    def is_made(self, name: str) -> bool:
        """Whether a member's sequence is there."""
        return (self.sequence(name) / FACTS_FILE).is_file()

    @contextmanager
    def sole_user(self) -> Iterator[None]:
        """Keep others from working on the data set; what they left half-made stays until `clear_work`.

        Raises
        ------
        DataSetError
            Another process does already, or the folder holds something else.
        """
        self._refuse_foreign()
        with locked(self.path / _WORK / _LOCK, wait=False) as handle:
            if handle is None:
                raise DataSetError(f"{self.path}: another softbed works on it: wait for it to end")
            yield

    @contextmanager
    def making(self, name: str) -> Iterator[Path]:
        """A folder to make something in, for one process at a time; others wait.

        It may hold what one that was killed has left.
        """
        place = self.path / _WORK / name
        with locked(place / _LOCK, wait=True):
            yield place

    def clear_work(self, *, keep: Set[str] = frozenset()) -> None:
        """Remove what killed processes left half-made; `keep` names work whose checkpoints stay."""
        for place in sorted((self.path / _WORK).iterdir()):
            if place.is_dir():
                with locked(place / _LOCK, wait=False) as handle:
                    if handle is not None:
                        _clear(place, checkpoint=place.name not in keep)

    def remove_work(self) -> None:
        """Remove the work folder, which needs its sole user; work of another cluster stays."""
        self.clear_work()
        if not any(entry.is_dir() for entry in (self.path / _WORK).iterdir()):
            shutil.rmtree(self.path / _WORK)

    def write(self, name: str, content: str | bytes) -> None:
        """Write a file whole, or leave it as it was."""
        with written_whole(self.path / name, draft=self.path / _WORK / f"{name}.new") as draft:
            draft.write_bytes(content.encode() if isinstance(content, str) else content)

    def _refuse_foreign(self) -> None:
        if self.path.exists() and not self.path.is_dir():
            raise DataSetError(f"{self.path}: is a file: a folder is needed")
        names = {entry.name for entry in self.path.iterdir()} if self.path.exists() else set()
        if names - {_WORK} and SWEEP_FILE not in names:
            raise DataSetError(
                f"{self.path}: neither empty nor a data set (it holds {min(names - {_WORK})!r} and no "
                f"{SWEEP_FILE}): nothing is overwritten, choose another"
            )


def _clear(place: Path, *, checkpoint: bool) -> None:
    """Empty a work folder; remove it, its lock last, where no checkpoint stays in it."""
    kept = {_LOCK} if checkpoint else {_LOCK, CHECKPOINT}
    for entry in place.iterdir():
        if entry.name not in kept:
            shutil.rmtree(entry) if entry.is_dir() else entry.unlink()
    if not (place / CHECKPOINT).exists():
        shutil.rmtree(place)
