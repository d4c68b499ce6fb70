"""Carry a study out: every case through the chain, then its table, its figure and its line of conclusion."""

import csv
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.scene import AnyScene, SoilBinScene
from validation import chain
from validation.manifest import key_of
from validation.run_folder import RunFolder
from validation.studies.picture_errors import PictureStudy
from validation.studies.study import Findings, Row, Run, Study
from validation.terminal import Terminal
from validation.versions import package_version

if TYPE_CHECKING:
    from rich.table import Table

SCHEMA_VERSION = 1
RUNS = "runs"
"""Folder below a study's with a run folder for each case."""
_MEASURED = "measured-{study}-{label}.json"
"""Rows of a measurement that is done."""


def carry_out(
    name: str,
    study: Study,
    scene: AnyScene,
    out: Path,
    *,
    quick: bool = False,
    given: Mapping[str, Path] | None = None,
    resume: bool = True,
    overwrite: bool = False,
    work: chain.Work,
    terminal: Terminal,
) -> dict[str, Any]:
    """Simulate what is missing, look into the recordings, and write NAME.csv, NAME.png and NAME.json.

    Parameters
    ----------
    out : Path
        The study's folder; below it, `runs` has a run folder for each case. Carried out again, cases whose
        recordings are there are skipped, and one that was killed goes on from its checkpoint.
    given : mapping, optional
        Run folders elsewhere that cases are in, by label.
    resume, overwrite : bool
        As of `chain.simulate`.

    Returns
    -------
    dict
        What NAME.json holds.

    Raises
    ------
    ValueError
        A scene without grains.
    """
    if not isinstance(scene, SoilBinScene):
        raise ValueError(f"{scene.name}: kind = {scene.kind!r}: a study needs soil in a bin")
    cases = study.cases(scene, quick=quick)
    with RunFolder.create(out) as folder:
        runs, digests = [], {}
        for number, case in enumerate(cases, start=1):
            terminal.say(f"study {name}: case {number} of {len(cases)}: {case.label}")
            place = (given or {}).get(case.label, out / RUNS / case.label)
            with RunFolder.create(place) as run:
                options = {"resume": resume, "overwrite": overwrite}
                chain.simulate(run, case.scene, work=work, terminal=terminal, **options)
                digests[case.label] = run.manifest.steps["simulate"].facts["digest"]
                runs.append(Run(case, run.recording))
        key = key_of(
            step=f"study {name}",
            made_by=package_version("softbed"),
            recordings=digests,
            scenes={case.label: case.scene.hash for case in cases},
            **study.inputs,
        )
        if folder.why_do(f"study {name}", key) is not None:
            labels = {"study": name, "scene": scene.name, "seed": scene.seed, "quick": quick}
            if isinstance(study, PictureStudy):
                findings = study.findings(_measured(folder, name, key, study, runs, terminal))
            else:
                findings = study.find(runs)
            _write(folder, name, key, labels, study, findings)
    return json.loads((out / f"{name}.json").read_text(encoding="utf-8"))


def _measured(
    folder: RunFolder, name: str, key: str, study: PictureStudy, runs: Sequence[Run], terminal: Terminal
) -> list[Row]:
    """Rows of all measurements of a study; those that are on disk are read."""
    rows: list[Row] = []
    several = study.measurements(runs)
    with terminal.progress(f"study {name}: pictures taken and measured") as advance:
        for number, one in enumerate(several):
            advance(number, len(several))
            step, file = f"study {name}: {one.label}", _MEASURED.format(study=name, label=one.label)
            if folder.why_do(step, key) is not None:
                taken = one.take()
                with folder.writing(step, key) as draft:
                    (draft.folder / file).write_text(json.dumps(taken, indent=1) + "\n", encoding="utf-8")
            rows += json.loads((folder.path / file).read_text(encoding="utf-8"))
        advance(len(several), len(several))
    return rows


def _write(
    folder: RunFolder, name: str, key: str, labels: dict[str, Any], study: Study, findings: Findings
) -> None:
    from validation.figures import to_png

    with folder.writing(f"study {name}", key) as draft:
        _write_table(draft.folder / f"{name}.csv", study, findings)
        (draft.folder / f"{name}.png").write_bytes(to_png(study.draw(findings)))
        document = {"schema_version": SCHEMA_VERSION, **labels, **_told(study, findings)}
        text = json.dumps(document, indent=1, allow_nan=False)
        (draft.folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")


def _write_table(path: Path, study: Study, findings: Findings) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([f"{name} [{unit}]" if unit else name for name, unit in study.columns.items()])
        writer.writerows([_spelt(row[name]) for name in study.columns] for row in findings.rows)


def _spelt(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"


def _told(study: Study, findings: Findings) -> dict[str, Any]:
    """Findings as JSON can hold them: what is not a number is null."""
    rows = [
        {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in row.items()
        }
        for row in findings.rows
    ]
    return {"columns": dict(study.columns), "rows": rows, "conclusion": findings.conclusion}


def study_table(document: Mapping[str, Any]) -> "Table":
    """The table of a study for a terminal."""
    from rich.table import Table

    table = Table(title=f"{document['study']}: {document['scene']}", title_justify="left")
    for name, unit in document["columns"].items():
        label = name.replace("_", " ")
        title, side = (f"{label}\n[{unit}]", "right") if unit else (label, "left")
        table.add_column(title, justify=side, overflow="fold")  # type: ignore[arg-type]
    for row in document["rows"]:
        values = (row[name] for name in document["columns"])
        table.add_row(*("-" if v is None else v if isinstance(v, str) else f"{v:.4g}" for v in values))
    return table
