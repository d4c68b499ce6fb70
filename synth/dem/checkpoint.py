"""Checkpoints: all of a run on disk now and then, so that a killed one goes on as if nothing had been.

A folder: `state.npz`, and one file a frame, written once. Each file is written aside and renamed, the state
last, so whatever `state.npz` speaks of is there. Zip archives carry a checksum of every array, by which
damage is seen. No pickle is written or read.
"""

import hashlib
import json
import shutil
import time
import zipfile
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from synth.dem.log import RunLog
from synth.dem.solver import Solver
from synth.disk import written_whole
from synth.npz_files import UNREADABLE

CHECKPOINT_INTERVAL = 30.0
"""Wall time between two checkpoints, s: what a kill can cost."""
_FORMAT = 3
_LIBRARIES = ("numpy", "scipy", "taichi")
"""Those whose numbers a recording is made of."""
_STATE_FILE = "state.npz"
_SOLVER = "solver."


class _UnfitError(Exception):
    """A checkpoint that is damaged or of another run; the message says which."""


class Checkpoint:
    """The place of one run's checkpoint.

    Parameters
    ----------
    folder : Path
        Nothing else may be in it.
    run : dict of str
        What the run's result depends on, a word each: a checkpoint is taken up only where all are the same.
    say : callable, optional
        Told in one line what was done with a checkpoint that was there.
    """

    def __init__(
        self, folder: Path, run: dict[str, str], *, say: Callable[[str], None] | None = None
    ) -> None:
        self._folder = folder
        made_by = {"program version": version("softbed")}
        made_by |= {f"{library} version": version(library) for library in _LIBRARIES}
        self._run = {"format": str(_FORMAT), **made_by, **run}
        self._say = say or (lambda line: None)
        self._written = time.monotonic()
        self._frames_written = 0

    def resume(self, solver: Solver, log: RunLog) -> int:
        """Bring solver and log to where the checkpoint was written.

        One that is damaged or of another run is said, removed, and changes nothing.

        Returns
        -------
        int
            Intervals done then; 0 without a checkpoint.
        """
        if not (self._folder / _STATE_FILE).is_file():
            self.remove()
            return 0
        try:
            state, frames = self._read()
        except _UnfitError as unfit:
            self._say(f"checkpoint: {unfit}: not used, starting anew")
            self.remove()
            return 0
        solver.restore_state({k.removeprefix(_SOLVER): v for k, v in state.items() if k.startswith(_SOLVER)})
        log.restore(state["samples"], frames, float(state["greatest_overlap"]))
        self._frames_written = len(frames)
        done = int(state["intervals"])
        self._say(f"checkpoint: goes on after {done} intervals and {len(frames)} frames")
        return done

    def write_if_due(self, intervals: int, solver: Solver, log: RunLog) -> None:
        """Write a checkpoint where the last one is `CHECKPOINT_INTERVAL` old; costs nothing else."""
        if time.monotonic() - self._written >= CHECKPOINT_INTERVAL:
            self.write(intervals, solver, log)
            self._written = time.monotonic()

    def write(self, intervals: int, solver: Solver, log: RunLog) -> None:
        """Write where the run stands after so many intervals."""
        self._folder.mkdir(parents=True, exist_ok=True)
        for index in range(self._frames_written, len(log.frames)):
            _save(self._frame_file(index), log.frames[index].to_arrays())
        self._frames_written = len(log.frames)
        state = {f"{_SOLVER}{name}": array for name, array in solver.save_state().items()}
        state |= {
            "run": np.array(json.dumps(self._run)),
            "intervals": np.array(intervals),
            "frame_count": np.array(len(log.frames)),
            "samples": np.array(log.samples, float),
            "greatest_overlap": np.array(log.greatest_overlap),
        }
        _save(self._folder / _STATE_FILE, state)

    def remove(self) -> None:
        """Remove the checkpoint, if there is one."""
        remove_checkpoint(self._folder)

    def _read(self) -> tuple[dict[str, np.ndarray], list[dict[str, np.ndarray]]]:
        state = _load(self._folder / _STATE_FILE)
        self._refuse_another_run(state)
        try:
            count = int(state["frame_count"])
        except KeyError:
            raise _UnfitError(f"{_STATE_FILE} is damaged") from None
        return state, [_load(self._frame_file(index)) for index in range(count)]

    def _refuse_another_run(self, state: dict[str, np.ndarray]) -> None:
        try:
            run: dict[str, Any] = json.loads(str(state["run"]))
            differs = [name for name in self._run if run.get(name) != self._run[name]]
        except (KeyError, ValueError, AttributeError):
            raise _UnfitError(f"{_STATE_FILE} is damaged") from None
        if differs:
            name = differs[0]
            raise _UnfitError(
                f"of another {name} ({_short(run.get(name))}, this is {_short(self._run[name])})"
            )

    def _frame_file(self, index: int) -> Path:
        return self._folder / f"frame-{index:06d}.npz"


def remove_checkpoint(folder: Path) -> None:
    """Remove a checkpoint's folder, if there is one; its state first, so that no half of it is taken up."""
    (folder / _STATE_FILE).unlink(missing_ok=True)
    if folder.is_dir() and not folder.is_symlink():
        shutil.rmtree(folder)


def digest_of(*arrays: np.ndarray) -> str:
    """SHA-256 over the values of arrays, hexadecimal."""
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _save(path: Path, arrays: dict[str, np.ndarray]) -> None:
    with written_whole(path) as draft:
        np.savez(draft, allow_pickle=False, **arrays)  # type: ignore[arg-type]


def _load(path: Path) -> dict[str, np.ndarray]:
    try:
        with zipfile.ZipFile(path) as archive:
            if archive.testzip() is not None:
                raise _UnfitError(f"{path.name} is damaged")
        with np.load(path, allow_pickle=False) as stored:
            return dict(stored.items())
    except FileNotFoundError:
        raise _UnfitError(f"{path.name} is missing") from None
    except UNREADABLE:
        raise _UnfitError(f"{path.name} is damaged") from None


def _short(word: Any) -> str:
    """A word, a hash by its beginning."""
    return str(word)[:12]
