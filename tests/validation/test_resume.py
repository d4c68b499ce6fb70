"""`kill -9` at any moment, run again: the same bytes as an undisturbed run."""

import json
import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr

from validation.run_folder import CHECKPOINT, RunFolder

OFTEN = """
from synth.dem import checkpoint
checkpoint.CHECKPOINT_INTERVAL = 0.02
from validation.cli import main
main()
"""


def digest_in(out):
    return json.loads((out / "manifest.json").read_text())["steps"]["simulate"]["facts"]["digest"]


@pytest.fixture(scope="module")
def undisturbed(tiny_wheel_scene, tmp_path_factory):
    """In a process of its own, which leaves compiled kernels behind: one that is killed leaves none."""
    folder = tmp_path_factory.mktemp("undisturbed")
    assert start(tiny_wheel_scene, folder / "out", folder / "log").wait() == 0
    return folder / "out"


def start(scene, out, log):
    command = [sys.executable, "-c", OFTEN, "simulate", str(scene), str(out)]
    return subprocess.Popen(command, stderr=log.open("a"), stdout=subprocess.DEVNULL)


def checkpoint_age(out):
    state = out / CHECKPOINT / "state.npz"
    return state.stat().st_mtime_ns if state.is_file() else 0


def kill_after(process, out, checkpoints, delay):
    """Kill once so many more checkpoints have been written, and a little later."""
    last = checkpoint_age(out)
    while checkpoints and process.poll() is None:
        now = checkpoint_age(out)
        checkpoints -= now != last
        last = now
        time.sleep(1e-3)
    time.sleep(delay)
    process.kill()
    process.wait()


def test_killed_at_random_moments_it_ends_with_the_same_bytes(tiny_wheel_scene, undisturbed, tmp_path):
    rng, out, log = np.random.default_rng(), tmp_path / "out", tmp_path / "log"
    kills = [(int(rng.integers(1, 9)), rng.uniform(0, 0.03)) for _ in range(3)]
    for checkpoints, delay in kills:
        kill_after(start(tiny_wheel_scene, out, log), out, checkpoints, delay)
    assert start(tiny_wheel_scene, out, log).wait() == 0, log.read_text()
    said = log.read_text()
    assert "checkpoint: goes on after" in said and "not used" not in said, (kills, said)
    assert digest_in(out) == digest_in(undisturbed), kills
    assert not (out / CHECKPOINT).exists()
    assert (out / "forces.csv").read_bytes() == (undisturbed / "forces.csv").read_bytes()


def leave_checkpoint(scene, out, tmp_path):
    log = tmp_path / "first.log"
    kill_after(start(scene, out, log), out, 2, 0.0)
    assert (out / CHECKPOINT / "state.npz").is_file(), log.read_text()


def test_no_resume_starts_anew(softbed, tiny_wheel_scene, undisturbed, tmp_path):
    out = tmp_path / "out"
    leave_checkpoint(tiny_wheel_scene, out, tmp_path)
    status, _, error = softbed("simulate", tiny_wheel_scene, out, "--no-resume")
    assert status == 0
    assert "checkpoint" not in error
    assert digest_in(out) == digest_in(undisturbed)
    assert not (out / CHECKPOINT).exists()


def test_a_damaged_checkpoint_is_said(softbed, tiny_wheel_scene, undisturbed, tmp_path):
    out = tmp_path / "out"
    leave_checkpoint(tiny_wheel_scene, out, tmp_path)
    state = out / CHECKPOINT / "state.npz"
    state.write_bytes(state.read_bytes()[:1000])
    status, _, error = softbed("simulate", tiny_wheel_scene, out)
    assert status == 0
    assert error.count("checkpoint: state.npz is damaged: not used, starting anew") == 1
    assert digest_in(out) == digest_in(undisturbed)


def test_a_checkpoint_is_no_stranger_and_no_artefact(tmp_path):
    (tmp_path / "out" / CHECKPOINT).mkdir(parents=True)
    with RunFolder.create(tmp_path / "out") as run:
        assert run.checkpoint.is_dir()
        assert run.why_do("simulate", "key") == "not done yet"


def test_soundness_is_said_and_kept(softbed, undisturbed, tiny_wheel_scene, tmp_path):
    status, output, error = softbed("simulate", tiny_wheel_scene, tmp_path / "out", "--json")
    assert status == 0
    soundness = json.loads(output)["steps"]["simulate"]["soundness"]
    assert {"inertial_number_p95", "stiffness_ratio", "overlap_p99", "steps_per_contact"} <= set(soundness)
    carrying = "inertial number of soil that carries the load, 95 %"
    for words in (carrying, "contact stiffness / mean pressure", "overlap / diameter, 99 %"):
        assert words in error
    # The tiny wheel is driven twenty times as fast as in the laboratory, which is too fast.
    assert f"warning: {carrying}" in error and "timing.speed_up" in error
    with xr.open_dataset(tmp_path / "out" / "recording.nc", engine="h5netcdf") as recording:
        assert recording.attrs["inertial_number_p95"] == soundness["inertial_number_p95"]


def test_a_simulation_that_must_stop_says_so_in_one_line(softbed, tiny_wheel_scene, tmp_path):
    scene, out = tmp_path / "heavy.toml", tmp_path / "out"
    scene.write_text(tiny_wheel_scene.read_text().replace("normal_load = 4.0", "normal_load = 400.0"))
    status, _, error = softbed("simulate", scene, out)
    assert status == 2
    assert "Traceback" not in error
    line = error.splitlines()[-1]
    for words in ("softbed: stopped at t = ", "in the laboratory: grain ", "timing.speed_up"):
        assert words in line
    assert str(out / "recording-stopped.nc") in line
    assert not (out / "recording.nc").exists() and not (out / CHECKPOINT).exists()
    with xr.open_dataset(out / "recording-stopped.nc", engine="h5netcdf") as stopped:
        assert "in the laboratory: grain " in stopped.attrs["stopped"]
        assert stopped.sizes["sample"] > 0
    assert softbed("simulate", tiny_wheel_scene, out)[0] == 0
    assert not (out / "recording-stopped.nc").exists()


def test_export_for_paraview(softbed, undisturbed):
    status, output, error = softbed("export", undisturbed, "--format", "vtk", "--json")
    assert status == 0, error
    files = json.loads(output)["steps"]["export vtk"]["files"]
    assert len(files) == 2 * (4 + 1) and all((undisturbed / name).is_file() for name in files)
    assert "skipped" in softbed("export", undisturbed)[2]
    status, _, error = softbed("export", undisturbed, "--format", "stl")
    assert status == 2
    assert "stl" in error and "vtk" in error and error.count("\n") == 1
