"""The identification without the simulator: runs written by the law itself."""

import json

import numpy as np
import pytest

from synth.rover.law.catalogue import read_soil
from synth.rover.law.interface import PlacedWheel
from synth.rover.law.response import SoilError
from synth.rover.law.rft import ResistiveForceLaw, ResistiveSoil
from synth.rover.law.single_wheel import Paths, lead
from synth.scene import load_scene
from validation.identification.carry_out import _write, find
from validation.identification.foretelling import phases
from validation.identification.plan import SCENE, altered, cases, rover_scene
from validation.identification.runs import Forces, SteadyRun
from validation.terminal import Terminal

SOIL = ResistiveSoil(
    scale=3e6, surface_friction=0.4, stiffness=1.5e7, shear_share=0.1, rut_share=0.5, damping_time=0.0
)
HEADER = "time [s],travel [m],slip [1],sinkage [m],force_x [N],force_z [N],torque [N m]"


@pytest.fixture(scope="module")
def several():
    return cases(load_scene(SCENE, quick=True), quick=True, rover_wheel=True)


def write_run(case, folder, noise=0.0):
    """What the simulator would have written, had the law made the forces."""
    wheel = case.scene.implement
    paths, time = Paths.of_scene(case.scene)
    record = lead(ResistiveForceLaw(SOIL), [PlacedWheel("", "", wheel.radius, wheel.width)], paths)
    rng = np.random.default_rng(1)
    columns = [time, paths.x[:, 0], 0 * time, record.sinkage[:, 0], record.force_x[:, 0]]
    table = np.stack([*columns, record.force_z[:, 0], -record.torque[:, 0]], axis=1)
    table[:, 4] += rng.normal(0, noise * wheel.normal_load, time.size)
    folder.mkdir(parents=True)
    np.savetxt(folder / "forces.csv", table, delimiter=",", header=HEADER, comments="")


def test_the_plan_has_fitted_and_foretold_runs(several):
    labels = [case.label for case in several]
    assert labels == [
        "roll-30N-00", "roll-30N-20", "roll-30N-60", "push", "push-rolled-in", "cycle", "rover-wheel"
    ]  # fmt: skip
    assert [case.fitted for case in several] == [True] * 3 + [False] * 4
    full = cases(load_scene(SCENE), quick=False, rover_wheel=False)
    steady = {(case.scene.implement.normal_load, case.scene.drive.slip) for case in full if case.fitted}
    assert steady == {(load, slip) for load in (30, 45) for slip in (0, 0.1, 0.2, 0.4, 0.6)}


def test_the_rovers_wheel_is_the_small_one_scaled():
    small = load_scene(SCENE)
    rover = rover_scene(small)
    scale = rover.implement.radius / small.implement.radius
    for name in ("width", "depth"):
        assert getattr(rover.bed, name) / getattr(small.bed, name) == pytest.approx(scale, rel=0.02)
    assert rover.bed.grain_diameter / small.bed.grain_diameter < 0.8 * scale


def test_phases_tell_what_a_wheel_does(several):
    scene = {case.label: case.scene for case in several}
    assert [one.name for one in phases(scene["push"])] == ["rests", "is pushed"]
    assert [one.name for one in phases(scene["cycle"])] == ["rolls", "rests", "is pushed", "rests", "rolls"]


def test_steady_runs_are_averaged_from_the_first_frame(several, tmp_path):
    write_run(several[1], tmp_path / "run", noise=0.2)
    run = SteadyRun.read("run", several[1].scene, tmp_path / "run" / "forces.csv")
    forces = Forces.read(tmp_path / "run" / "forces.csv")
    assert run.trial.drawbar_pull == pytest.approx(forces.force_x[forces.time > 0].mean())
    assert run.trial.slip == 0.2 and run.trial.load == 30
    assert 0 < run.standard_error.drawbar_pull < 0.2 * 30
    with pytest.raises(ValueError, match="no column 'torque'"):
        (tmp_path / "other.csv").write_text(
            "time [s],travel [m],sinkage [m],force_x [N],force_z [N]\n0,0,0,0,0\n"
        )
        Forces.read(tmp_path / "other.csv")


def test_the_laws_own_runs_give_back_its_soil_and_are_foretold(several, tmp_path):
    for case in several:
        write_run(case, tmp_path / case.label)
    found = find(several, tmp_path, None, Terminal(json=True))
    soil = found.identification.soil
    assert soil.scale == pytest.approx(SOIL.scale, rel=0.1)
    for row in found.phases:
        load = 30.0
        assert row["force_x_law"] == pytest.approx(row["force_x"], abs=0.05 * load), row
        assert row["sinkage_law"] == pytest.approx(row["sinkage"], rel=0.15), row
    run, given = found.rover
    assert given.drawbar_pull == pytest.approx(run.trial.drawbar_pull, abs=0.05 * run.trial.load)
    (tmp_path / "out").mkdir()
    _write(found, tmp_path / "out")
    document = json.loads((tmp_path / "out" / "identification.json").read_text())
    assert document["rig"] is None and len(document["steady"]) == 3
    assert read_soil(tmp_path / "out" / "identification.json") == soil
    assert (tmp_path / "out" / "identification.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("[]", "a JSON object is needed"),
        ("{}", "soil: missing"),
        ('{"soil": []}', "soil: a JSON object is needed"),
        ('{"soil": {"scale": 1}}', r"soil\.surface_friction: missing"),
        ('{"soil": {"scale": -1, "surface_friction": 1, "stiffness": 1}}', "soil: scale = -1.0: above 0"),
        (
            '{"soil": {"scale": 1, "surface_friction": 1, "stiffness": 1, "x": 1}}',
            r"soil\.x = 1: unknown key",
        ),
    ],
)
def test_a_soil_that_is_none_is_refused(tmp_path, content, told):
    (tmp_path / "a.json").write_text(content)
    with pytest.raises(SoilError, match=rf"the table 'soil' of softbed identify is needed: {told}"):
        read_soil(tmp_path / "a.json")


def test_altering_a_scene_moves_its_finest_grains():
    scene = load_scene(SCENE)
    moved = altered(scene, drive={"start": 0.2})
    assert moved.bed.fine.right > scene.bed.fine.right
    assert moved.drive == replace_drive(scene, start=0.2)


def replace_drive(scene, **values):
    return scene.drive.model_copy(update=values)
