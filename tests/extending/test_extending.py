"""An implement, a soil, an estimator, an experiment and a study: each is one small file and one registration.

The files beside this one are put into a copy of the packages, and used there as a user would.
"""

import csv
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
FILES = {
    "wedge.py": "synth/implements",
    "quartz.toml": "scenes/soils",
    "wedge_in_quartz.toml": "scenes",
    "phase_shift.py": "soft/flow",
    "wedge_angle.py": "validation/studies",
}
"""Where each goes. A soil and an experiment are registered by lying there."""
REGISTRATIONS = {
    "synth/implements/__init__.py": [
        ("from synth.implements.shape import Shape\n", "from synth.implements.wedge import Wedge\n"),
        ("Implement = Annotated[\n    ", "Wedge | "),
    ],
    "soft/flow/registry.py": [("BUILT_IN = {\n", '    "phase-shift": "soft.flow.phase_shift",\n')],
    "validation/studies/__init__.py": [
        ("STUDIES = {\n", '    "wedge-angle": "forces on a wedge against its angle",\n')
    ],
}
"""What is written after which words of which file."""


@pytest.fixture(scope="module")
def extended(tmp_path_factory):
    """The packages with all five added."""
    root = tmp_path_factory.mktemp("extended")
    for room in ("soft", "synth", "validation", "scenes"):
        left_out = shutil.ignore_patterns("__pycache__", "clips", "measured")
        shutil.copytree(ROOT / room, root / room, ignore=left_out)
    for name, folder in FILES.items():
        shutil.copy(HERE / name, root / folder)
    for name, insertions in REGISTRATIONS.items():
        text = (root / name).read_text()
        for after, inserted in insertions:
            assert text.count(after) == 1, (name, after)
            text = text.replace(after, after + inserted)
        (root / name).write_text(text)
    return root


@pytest.fixture(scope="module")
def softbed(extended):
    """Run a command of the extended packages; standard output."""

    def run(*arguments):
        done = subprocess.run(
            [sys.executable, "-c", "from validation.cli import main; main()", *map(str, arguments)],
            env=os.environ | {"PYTHONPATH": str(extended)},
            cwd=extended,
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def test_each_file_is_small():
    lines = {name: len((HERE / name).read_text().splitlines()) for name in FILES}
    assert max(lines.values()) < 70, lines


def test_help_tells_of_the_estimator(softbed):
    told = softbed("run", "--help"), softbed("gate", "--help")
    assert all("phase-shift" in one for one in told)


def test_the_experiment_runs_with_its_implement_its_soil_and_the_estimator(softbed, extended):
    out = extended / "out"
    softbed("run", "wedge_in_quartz", out, "--quick", "--threads", "1", "--method", "phase-shift")
    scene = (out / "scene.toml").read_text()
    assert 'kind = "wedge"' in scene and 'name = "quartz"' in scene
    strata = json.loads((out / "scores.json").read_text())["methods"]["phase-shift"]["strata"]
    assert strata["all"]["pixel_count"] > 5000 and strata["all"]["coverage"] > 0.9
    # Most of the soil rests, and moves by 6.25 px in the picture of a camera that travels with the wedge.
    assert strata["quiet"]["median"] < 0.625
    with (out / "forces.csv").open() as file:
        forces = [row for row in csv.reader(file) if row]
    column = [name.partition(" ")[0] for name in forces[0]].index("force_x")
    assert sum(float(row[column]) for row in forces[1:]) < 0  # soil resists the wedge


def test_the_study_is_carried_out(softbed, extended):
    out = extended / "study"
    document = json.loads(softbed("study", "wedge-angle", out, "--quick", "--threads", "1", "--json"))
    assert [row["angle"] for row in document["rows"]] == [30, 60]
    assert all(row["force_x"] < 0 for row in document["rows"])  # soil resists
    assert document["conclusion"].startswith("Draught from ") and (out / "wedge-angle.png").is_file()
