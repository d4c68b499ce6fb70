"""The folders that commands work on, and what is said when they are done."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer

from validation.terminal import Terminal


@contextmanager
def opened_material(path: Path, out: Path | None, settings: Any = None) -> Iterator[tuple[Any, Any]]:
    """Open the folder that results go to, and the pictures, as settings say if there are any."""
    from validation import chain
    from validation.material import TRUTH_FILE, Material, results_folder
    from validation.run_folder import RunFolder, is_run_folder

    chosen = results_folder(path, out)
    if chosen != path and (chosen / "recording.nc").is_file():
        raise typer.BadParameter(f"--out: {chosen} is the run folder of a simulation, not for other pictures")
    if is_run_folder(path):
        _refuse_scale(path, settings)
        with RunFolder.open(path) as source:
            material = chain.footage_of(source, settings)
            if chosen == path:
                yield source, material
                return
            with RunFolder.create(chosen) as results:
                yield results, material
        return
    if settings is None and not (path / TRUTH_FILE).is_file():
        settings = _settings_of_last_analysis(chosen)
    material = Material.open(path, settings)
    with RunFolder.create(chosen) as results:
        yield results, material


def _settings_of_last_analysis(folder: Path) -> Any:
    """How pictures were last analyzed into a folder, so that its results are of these pictures; else None."""
    from soft import AnalysisSettings
    from validation.manifest import Manifest
    from validation.run_folder import is_run_folder

    if not is_run_folder(folder):
        return None
    records = [record for step, record in Manifest.read(folder).steps.items() if step.startswith("analyze ")]
    told = [record.facts["settings"] for record in records if "settings" in record.facts]
    return AnalysisSettings.checked(told[-1], name=f"{folder}: settings") if told else None


def _refuse_scale(path: Path, settings: Any) -> None:
    """Refuse another time step or scale than the footage of a run tells."""
    if settings is None:
        return
    given = {
        "--frame-rate": settings.frames.frame_rate is not None,
        "--metres-per-pixel": settings.calibration.metres_per_pixel is not None,
        "calibration": settings.calibration != type(settings.calibration)(),
    }
    for what, is_given in given.items():
        if is_given:
            raise typer.BadParameter(f"{what}: {path} is a run folder, whose footage knows its own")


@contextmanager
def methods_of_this_folder() -> Iterator[None]:
    """Let a user's own `package.module:function` lie in the current folder."""
    here = str(Path.cwd())
    sys.path.insert(0, here)
    try:
        yield
    finally:
        sys.path.remove(here)


def step_document(run: Any, *steps: str) -> dict[str, Any]:
    """Say what steps did, as one JSON document."""
    done = {step: run.manifest.steps[step] for step in steps}
    return {
        "schema_version": 1,
        "folder": str(run.path),
        "steps": {
            step: {"seconds": record.seconds, "files": record.files, **record.facts}
            for step, record in done.items()
        },
    }


def show_scores(run: Any, scores: Any, terminal: Terminal) -> None:
    """Show scores as a table, beside published ones, or as JSON."""
    from validation.scoring.score_table import camera_lines, published_lines, region_table, score_table

    terminal.show(score_table(scores))
    if (regions := region_table(scores)) is not None:
        terminal.show(regions)
    for line in [*camera_lines(scores), *published_lines(run)]:
        terminal.show(line)
    terminal.show(f"scores: {run.scores}\nreport: {run.report}")
    terminal.give(scores.to_dict())
