"""Carry an identification out: every run through the simulator, the fit, the predictions, their files."""

import csv
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from synth.rover.law.catalogue import loose_grc1
from synth.rover.law.identification import FIRST_SHEAR_SHARE, Identification, Trial, identify, predict
from synth.rover.law.rft import ResistiveForceLaw
from synth.scene import SoilBinScene
from validation import chain
from validation.identification.foretelling import Foretold, Row, foretell, phase_rows
from validation.identification.plan import Case, cases
from validation.identification.runs import Forces, SteadyRun
from validation.identification.wheel_rig import RigComparison, compare_with_rig, read_trials
from validation.manifest import key_of
from validation.run_folder import RunFolder
from validation.terminal import Terminal
from validation.versions import package_version

SCHEMA_VERSION = 1
RUNS = "runs"
_STEP = "identify"


@dataclass(frozen=True)
class Found:
    """All that an identification tells."""

    identification: Identification
    steady: list[SteadyRun]
    foretold: list[Foretold]
    phases: list[Row]
    rover: tuple[SteadyRun, Trial] | None
    rig: RigComparison | None


def carry_out(
    scene: SoilBinScene,
    out: Path,
    *,
    quick: bool,
    rover_wheel: bool,
    rig: Path | None,
    work: chain.Work,
    terminal: Terminal,
    resume: bool = True,
) -> dict[str, Any]:
    """Simulate what is missing; write identification.json, .csv, .png, and rig.png of a rig's file.

    Every run is a run folder below `out`/runs: carried out again, those that are there are skipped.

    Returns
    -------
    dict
        What identification.json holds.
    """
    rig_trials = None if rig is None else read_trials(rig)
    several = cases(scene, quick=quick, rover_wheel=rover_wheel)
    with RunFolder.create(out) as folder:
        digests = _simulate(several, out / RUNS, work=work, terminal=terminal, resume=resume)
        key = key_of(
            step=_STEP,
            made_by=package_version("softbed"),
            recordings=digests,
            scenes={case.label: case.scene.hash for case in several},
            rig=None if rig_trials is None else _without_nan([asdict(one) for one in rig_trials]),
        )
        if folder.why_do(_STEP, key) is not None:
            found = find(several, out / RUNS, rig_trials, terminal)
            with folder.writing(_STEP, key) as draft:
                _write(found, draft.folder)
    return json.loads((out / "identification.json").read_text(encoding="utf-8"))


def _simulate(
    several: Sequence[Case], runs: Path, *, work: chain.Work, terminal: Terminal, resume: bool
) -> dict[str, str]:
    """Digest of each recording by its label."""
    digests = {}
    for number, case in enumerate(several, start=1):
        terminal.say(f"identify: run {number} of {len(several)}: {case.label}")
        with RunFolder.create(runs / case.label) as run:
            chain.simulate(run, case.scene, work=work, terminal=terminal, resume=resume)
            digests[case.label] = run.manifest.steps["simulate"].facts["digest"]
    return digests


def find(several: Sequence[Case], runs: Path, rig_trials: list[Trial] | None, terminal: Terminal) -> Found:
    """Fit to the steady runs, predict the others."""
    files = {case.label: runs / case.label / "forces.csv" for case in several}
    steady = [SteadyRun.read(case.label, case.scene, files[case.label]) for case in several if case.fitted]
    with terminal.progress("fit the law") as progress:
        identification = identify(
            [one.trial for one in steady],
            loose_grc1(shear_share=FIRST_SHEAR_SHARE),
            progress=lambda done: progress(min(done, 30), 30),
        )
    soil = identification.soil
    moving = [case for case in several if not case.fitted and case.scene.drive.kind != "rolling"]
    foretold = [foretell(case.label, case.scene, Forces.read(files[case.label]), soil) for case in moving]
    rows = [row for one, case in zip(foretold, moving, strict=True) for row in phase_rows(one, case.scene)]
    rover = None
    for case in several:
        if not case.fitted and case.scene.drive.kind == "rolling":
            run = SteadyRun.read(case.label, case.scene, files[case.label])
            rover = run, predict(ResistiveForceLaw(soil), [run.trial])[0]
    comparison = None if rig_trials is None else compare_with_rig(rig_trials)
    return Found(identification, steady, foretold, rows, rover, comparison)


def _write(found: Found, folder: Path) -> None:
    from validation.figures import to_png
    from validation.identification.figure import identification_figure, rig_figure

    document = identification_document(found)
    (folder / "identification.json").write_text(
        json.dumps(document, indent=1, allow_nan=False) + "\n", "utf-8"
    )
    with (folder / "identification.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(document["steady"][0]))
        writer.writeheader()
        writer.writerows(document["steady"])
    figure = identification_figure(found.steady, found.identification.predictions, found.foretold)
    (folder / "identification.png").write_bytes(to_png(figure))
    if found.rig is not None:
        (folder / "rig.png").write_bytes(to_png(rig_figure(found.rig)))


def identification_document(found: Found) -> dict[str, Any]:
    """All of it as JSON can hold it, SI units; what is not a number is null."""
    identification = found.identification
    steady = [
        _beside(one, given) for one, given in zip(found.steady, identification.predictions, strict=True)
    ]
    document: dict[str, Any] = {
        "schema_version": SCHEMA_VERSION,
        "soil": asdict(identification.soil),
        "estimates": {name: asdict(one) for name, one in identification.estimates.items()},
        "misfit": identification.misfit,
        "steady": steady,
        "foretold": found.phases,
        "rover_wheel": None if found.rover is None else _beside(*found.rover),
        "rig": None if found.rig is None else _rig_document(found.rig),
    }
    return _without_nan(document)


def _beside(run: SteadyRun, given: Trial) -> Row:
    row: Row = {"run": run.label, "slip": run.trial.slip, "load": run.trial.load, "radius": run.trial.radius}
    for name in ("sinkage", "drawbar_pull", "torque"):
        row[name] = getattr(run.trial, name)
        row[f"{name}_error"] = getattr(run.standard_error, name)
        row[f"{name}_law"] = getattr(given, name)
    return row


def _rig_document(rig: RigComparison) -> dict[str, Any]:
    rows = []
    for k, one in enumerate(rig.measured):
        row: Row = {"slip": one.slip, "load": one.load, "fitted": "no" if rig.is_braked(k) else "yes"}
        for name in ("sinkage", "drawbar_pull"):
            row[name] = getattr(one, name)
            row[f"{name}_law"] = getattr(rig.predicted[k], name)
            row[f"{name}_unfitted_law"] = getattr(rig.unfitted[k], name)
        row["load_at_sinkage_law"] = rig.at_sinkage[k].force_z
        row["drawbar_pull_at_sinkage_law"] = rig.at_sinkage[k].force_x
        rows.append(row)
    estimates = {name: asdict(one) for name, one in rig.identification.estimates.items()}
    return {"estimates": estimates, "misfit": rig.identification.misfit, "trials": rows}


def _without_nan(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_nan(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_without_nan(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
