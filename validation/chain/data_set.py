"""What is done with a whole data set: written in layouts of others."""

import shutil
import tempfile
from pathlib import Path

from validation.exchange.training_layouts import write_training_layout
from validation.manifest import RunFolderError
from validation.run_folder import PARTIAL_PREFIX
from validation.terminal import Terminal


def export_data_set(folder: Path, layout: str, out: Path | None, *, terminal: Terminal) -> Path:
    """Write a data set in one of `LAYOUTS`, whole or not at all; default: `./<name>-<layout>`.

    Returns
    -------
    Path
        The folder written.

    Raises
    ------
    RunFolderError
        There is something there already, or it lies within the data set.
    synth.dataset.DataSetError
        No data set.
    """
    from synth.dataset import load_data_set

    data = load_data_set(folder)
    chosen = out or Path(f"{folder.resolve().name}-{layout}")
    if chosen.exists() and (not chosen.is_dir() or any(chosen.iterdir())):
        raise RunFolderError(f"{chosen}: there already: choose another folder with --out, or remove it")
    if chosen.resolve().is_relative_to(folder.resolve()):
        raise RunFolderError(f"{chosen}: lies inside the data set: choose a folder elsewhere with --out")
    chosen.parent.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=PARTIAL_PREFIX, dir=chosen.parent))
    try:
        draft = aside / chosen.name
        draft.mkdir()
        with terminal.progress(f"export {layout}") as progress:
            write_training_layout(data, layout, draft, progress=progress)
        if chosen.exists():
            chosen.rmdir()
        draft.rename(chosen)
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return chosen
