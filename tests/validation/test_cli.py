import hashlib
import json
import resource
import shutil
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest
import tomli_w
import typer
import xarray as xr
from PIL import Image

import soft
import synth
from validation.cli import app
from validation.cli.bench import refuse_foreign_options
from validation.run_folder import PARTIAL_PREFIX
from validation.scoring.nodes import truth_at

WHOLE = {
    "analysis/dis.nc",
    "analysis/farneback.nc",
    "footage/README.md",
    "footage/SHA256SUMS",
    "footage/frames/000000.png",
    "footage/frames/000001.png",
    "footage/sequence.toml",
    "footage/truth.nc",
    "forces.csv",
    "manifest.json",
    "recording.nc",
    "report.html",
    "scene.toml",
    "scores.json",
}


def tree(folder):
    """Bytes of every file below a folder."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in Path(folder).rglob("*")
        if path.is_file()
    }


def assert_one_line(error, *words):
    assert error.count("\n") == 1, error
    assert error.startswith("softbed: ")
    assert "Traceback" not in error
    for word in words:
        assert word in error


def test_run_makes_a_whole_run_folder(finished_run):
    files = tree(finished_run)
    assert set(files) == WHOLE
    manifest = json.loads((finished_run / "manifest.json").read_text())
    files.pop("manifest.json")
    assert manifest["files"] == files
    assert manifest["scene"] == "tiny"


def test_scores_are_good_on_a_rotation(finished_run):
    scores = json.loads((finished_run / "scores.json").read_text())
    assert set(scores["methods"]) == {"dis", "farneback"}
    for method in scores["methods"].values():
        assert method["seconds_per_pair"] > 0
        assert method["strata"]["all"]["median"] < 0.3
        # A turn of 0.03 rad takes about a pixel and a half of every side out of the picture.
        assert 0.95 * 96 * 80 < method["strata"]["all"]["pixel_count"] < 96 * 80
        assert method["strata"]["complex"]["median"] is None


def test_run_again_does_nothing(softbed, finished_run, tiny_scene):
    before = tree(finished_run)
    status, output, error = softbed(
        "run", tiny_scene, finished_run, "--method", "dis", "--method", "farneback"
    )
    assert status == 0
    assert error.count("skipped") == len(error.splitlines()) == 7 - 1
    assert tree(finished_run) == before
    assert "published (Skonieczny et al. 2014" in output and "0.15 px" in output


def test_damage_is_repaired_and_only_that(softbed, finished_run, tiny_scene, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(finished_run, out)
    flow = out / "analysis" / "dis.nc"
    flow.write_bytes(flow.read_bytes()[:1000])
    status, _, error = softbed("run", tiny_scene, out, "--method", "dis")
    assert status == 0
    assert "analyze dis: analysis/dis.nc is damaged or was changed: doing it again" in error
    assert "simulate: done before" in error and "render: done before" in error


def test_another_seed_is_done_again_if_that_is_meant(softbed, finished_run, tiny_scene, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(finished_run, out)
    before = tree(out)
    status, _, error = softbed("run", tiny_scene, out, "--seed", 7)
    assert status == 2
    assert_one_line(error, "holds another simulation", "seed 0", "--overwrite")
    assert tree(out) == before
    status, _, error = softbed("run", tiny_scene, out, "--seed", 7, "--overwrite", "--method", "dis")
    assert status == 0
    assert "render: what it depends on has changed: doing it again" in error
    assert json.loads((out / "scores.json").read_text())["seed"] == 7
    # The other method's flow is of other pictures now, and must not be scored with them.
    status, _, error = softbed("score", out)
    assert status == 0
    assert "analyze farneback: of other pictures than these: left out" in error
    assert set(json.loads((out / "scores.json").read_text())["methods"]) == {"dis"}


def test_steps_one_by_one(softbed, finished_run, tiny_scene, tmp_path):
    out = tmp_path / "out"
    status, _, error = softbed("render", out)
    assert status == 2
    assert_one_line(error, "no such folder")
    assert softbed("simulate", tiny_scene, out)[0] == 0
    status, _, error = softbed("analyze", out)
    assert status == 2
    assert_one_line(error, "render: not done yet", f"softbed render {out}")
    assert softbed("render", out)[0] == 0
    assert softbed("analyze", out, "--method", "dis")[0] == 0
    assert softbed("score", out)[0] == 0
    first, second = (
        json.loads((f / "scores.json").read_text())["methods"]["dis"] for f in (out, finished_run)
    )
    assert first["strata"] == second["strata"]


def test_another_scene_in_the_same_folder_makes_the_old_footage_stale(softbed, finished_run, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(finished_run, out)
    resolved = synth.load_scene(out / "scene.toml").to_dict()
    resolved["implement"]["rotation"] = 0.02
    (tmp_path / "other.toml").write_text(tomli_w.dumps(resolved))
    assert softbed("simulate", tmp_path / "other.toml", out, "--overwrite")[0] == 0
    status, _, error = softbed("score", out)
    assert status == 2
    assert_one_line(error, "render: what it depends on has changed", f"softbed render {out}")


@pytest.mark.parametrize("command", ["simulate", "run"])
def test_a_folder_of_something_else_is_never_touched(softbed, tiny_scene, tmp_path, command):
    (tmp_path / "notes.txt").write_text("mine")
    status, _, error = softbed(command, tiny_scene, tmp_path)
    assert status == 2
    assert_one_line(error, "neither empty nor a run folder", "notes.txt")
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "no_such_scene", "OUT"], ["no_such_scene", "rolling_wheel"]),
        (["run", "no_such.toml", "OUT"], ["no_such.toml", "no such file"]),
        (["run", "plate_rotation", "OUT", "--method", "magic"], ["magic", "dis"]),
        (["run", "plate_rotation", "OUT", "--method", "no.such:function"], ["no.such"]),
        (["run", "plate_rotation", "OUT", "--method", "files:nowhere"], ["files:nowhere"]),
        (["run", "plate_rotation", "OUT", "--method", "files:a/f", "--method", "files:b/f"], ["files-f"]),
        (["suite", "smoke", "OUT", "--method", "magic"], ["magic", "dis"]),
        (["suite", "smoke", "OUT", "--method", "no.such:function"], ["no.such"]),
        (["suite", "smoke", "OUT", "--method", "DIS"], ["DIS"]),
        (["bench", "flow", "--grains", "1000"], ["--grains", "bench flow", "only for dem"]),
        (["bench", "dem", "--run", "OUT"], ["--run", "bench dem", "only for flow"]),
        (["bench", "dem", "--openpiv", "python"], ["--openpiv", "only for flow"]),
        (["bench", "render", "--photograph", "FILE"], ["--photograph", "only for flow"]),
        (["bench", "dem", "--limits"], ["--limits", "only for flow"]),
        (["bench", "sweep", "--threads", "2"], ["--threads", "only for dem, render, flow"]),
        (["run", "plate_rotation", "OUT", "--seed", "minus"], ["--seed"]),
        (["run", "plate_rotation", "OUT", "--seed", "-1"], ["--seed", "0"]),
        (["run", "plate_rotation", "OUT", "--device", "tpu"], ["--device", "tpu"]),
        (["run", "plate_rotation"], ["OUT"]),
        (["render", "OUT"], ["no such folder"]),
        (["score", "OUT"], ["no such folder"]),
        (["analyze", "OUT"], ["no such folder"]),
        (["fly"], ["fly"]),
        (["run", "--fast"], ["--fast"]),
    ],
)
def test_bad_usage_is_one_line_and_makes_nothing(softbed, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    status, output, error = softbed(*arguments)
    assert status == 2
    assert output == ""
    assert_one_line(error, *words)
    assert list(tmp_path.iterdir()) == []


def test_a_bench_may_be_told_of_another_ones_peers_by_the_environment(monkeypatch):
    monkeypatch.setenv("SOFTBED_OPENPIV", "python")
    context = typer.main.get_command(app).commands["bench"].make_context("bench", ["dem"])
    assert context.params["openpiv"] == "python"
    refuse_foreign_options(context, "dem")


def test_an_impossible_value_names_file_and_key(softbed, tiny_scene, tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(tiny_scene.read_text().replace("width = 96", "width = -3"))
    status, _, error = softbed("run", scene, tmp_path / "out")
    assert status == 2
    assert_one_line(error, str(scene), "camera.width", "-3")
    assert not (tmp_path / "out").exists()


def test_debug_gives_the_traceback(tmp_path):
    command = [sys.executable, "-c", "from validation.cli import main; main()", "run", "no_such_scene", "OUT"]
    plain = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    full = subprocess.run([*command, "--debug"], capture_output=True, text=True, cwd=tmp_path)
    assert plain.returncode == 2 and "Traceback" not in plain.stderr
    assert full.returncode != 0 and "Traceback" in full.stderr and "SceneError" in full.stderr


def test_json_is_one_document(softbed, finished_run, tiny_scene):
    status, output, error = softbed("scenes", "--json")
    assert status == 0 and error == ""
    assert {row["name"] for row in json.loads(output)["scenes"]} == set(synth.scene_names())
    status, output, _ = softbed(
        "run", tiny_scene, finished_run, "--json", "--method", "dis", "--method", "farneback"
    )
    assert json.loads(output) == json.loads((finished_run / "scores.json").read_text())
    status, output, error = softbed("run", "no_such_scene", "x", "--json")
    assert status == 2
    assert_one_line(error)
    assert "no_such_scene" in json.loads(output)["error"]


def test_json_stays_pure_when_a_method_prints(tmp_path, finished_run):
    (tmp_path / "chatty.py").write_text(
        textwrap.dedent("""
            import os
            import numpy as np

            print("imported")

            def flow(first, second, mask):
                print("measuring")
                os.write(1, b"from compiled code\\n")
                return np.zeros((*first.shape, 2))
        """)
    )
    command = [sys.executable, "-c", "from validation.cli import main; main()"]
    arguments = ["score", str(finished_run / "footage"), "--method", "chatty:flow", "--json"]
    done = subprocess.run([*command, *arguments], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert set(json.loads(done.stdout)["methods"]) == {"chatty:flow"}
    for words in ("imported", "measuring", "from compiled code"):
        assert words in done.stderr


def test_bare_footage_is_scored_beside_itself(softbed, finished_run, tmp_path, monkeypatch):
    footage = tmp_path / "footage"
    shutil.copytree(finished_run / "footage", footage)
    before = tree(footage)
    monkeypatch.chdir(tmp_path)
    assert softbed("score", footage, "--method", "dis")[0] == 0
    assert tree(footage) == before
    scores = [
        json.loads((f / "scores.json").read_text()) for f in (tmp_path / "footage-softbed", finished_run)
    ]
    assert scores[0]["methods"]["dis"]["strata"] == scores[1]["methods"]["dis"]["strata"]
    assert (tmp_path / "footage-softbed" / "report.html").is_file()


def test_results_inside_the_pictures_are_refused(softbed, finished_run, tmp_path, monkeypatch):
    footage = tmp_path / "footage"
    shutil.copytree(finished_run / "footage", footage)
    monkeypatch.chdir(footage)
    before = tree(footage)
    status, _, error = softbed("analyze", ".")
    assert status == 2
    assert_one_line(error, "never written to", "--out")
    assert tree(footage) == before


def test_flow_from_files(softbed, finished_run, tmp_path):
    flows = tmp_path / "flows"
    flows.mkdir()
    with synth.Footage.open(finished_run / "footage") as footage:
        truth = footage.truth(0)
    exact = np.stack([truth["u"].values, truth["v"].values], axis=-1)
    soft.write_flo(flows / "0.flo", exact + np.float32([0.3, -0.4]))
    out = tmp_path / "results"
    arguments = ["score", finished_run / "footage", "--out", out, "--method", f"files:{flows}"]
    status, _, error = softbed(*arguments)
    assert status == 0, error
    method = json.loads((out / "scores.json").read_text())["methods"][f"files:{flows}"]
    assert method["seconds_per_pair"] is None
    summary = method["strata"]["all"]
    assert summary["median"] == pytest.approx(0.5, abs=1e-5)
    assert (summary["bias_u"], summary["bias_v"]) == (
        pytest.approx(0.3, abs=1e-5),
        pytest.approx(-0.4, abs=1e-5),
    )
    # What leaves the picture is not measured, whatever a file says of it.
    missed = 1 - summary["coverage"]
    assert summary["wrong_share"] == pytest.approx({"0.3": 1.0, "0.56": missed, "1.0": missed})
    assert (out / "analysis" / "files-flows.nc").is_file()
    soft.write_flo(flows / "0.flo", exact)
    status, _, error = softbed(*arguments)
    assert "what it depends on has changed" in error
    assert (
        json.loads((out / "scores.json").read_text())["methods"][f"files:{flows}"]["strata"]["all"]["p95"]
        < 1e-5
    )


def test_flow_from_grids(softbed, finished_run, tmp_path):
    """A perfect grid between the pixels is perfect, and its shares are of its nodes."""
    grids = tmp_path / "grids"
    grids.mkdir()
    with synth.Footage.open(finished_run / "footage") as footage:
        truth = footage.truth(0)
    shape = truth["u"].shape
    exact = np.stack([truth["u"].values, truth["v"].values], axis=-1)
    x, y = (
        a.ravel() for a in np.meshgrid(np.arange(20.25, shape[1] - 20, 12), np.arange(20, shape[0] - 20, 12))
    )
    vectors = truth_at(exact, np.stack([x, y], axis=1))
    rows = np.column_stack([x + 1, y + 1, vectors])
    np.savetxt(grids / "0.csv", rows, delimiter=",", header="x,y,u,v")
    (grids / "grid.toml").write_text("origin = 1\n")
    out = tmp_path / "results"
    arguments = ["score", finished_run / "footage", "--out", out, "--method", f"files:{grids}"]
    status, _, error = softbed(*arguments)
    assert status == 0, error
    summary = json.loads((out / "scores.json").read_text())["methods"][f"files:{grids}"]["strata"]["all"]
    assert summary["node_count"] == len(x) == 20
    assert summary["coverage"] < 0.01 < summary["coverage"] * 12**2
    assert summary["p95"] < 1e-5
    assert summary["wrong_share"]["0.3"] < 0.05
    assert "fills its cell" in (out / "report.html").read_text()
    (grids / "grid.toml").write_text("origin = 5\n")
    status, _, error = softbed(*arguments)
    assert "what it depends on has changed" in error
    table = json.loads((out / "scores.json").read_text())["methods"][f"files:{grids}"]["strata"]["all"]
    assert table["p95"] > 0.01


def test_own_photographs(softbed, finished_run, tmp_path, monkeypatch):
    photographs = tmp_path / "photographs"
    shutil.copytree(finished_run / "footage" / "frames", photographs)
    monkeypatch.chdir(tmp_path)
    before = tree(photographs)
    calibration = ["--metres-per-pixel", "0.0002", "--frame-rate", "2"]
    status, output, error = softbed("analyze", photographs, *calibration, "--soil", "all", "--json")
    assert status == 0, error
    assert tree(photographs) == before
    out = tmp_path / "photographs-softbed"
    assert json.loads(output)["steps"]["analyze robust-affine"]["files"] == ["analysis/robust-affine.nc"]
    with xr.open_dataset(out / "analysis" / "robust-affine.nc", engine="h5netcdf") as flow:
        assert "velocity_x" in flow
    assert list((out / "figures").rglob("*.png"))
    status, _, error = softbed("score", photographs)
    assert status == 2
    assert_one_line(error.splitlines()[-1] + "\n", "nothing to score against")


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda folder: (folder / "000001.png").unlink(), ["at least 2"]),
        (lambda folder: (folder / "000001.png").write_bytes(b"not a picture"), ["000001.png"]),
        (lambda folder: Image.new("L", (30, 20)).save(folder / "odd.png"), ["odd.png", "30 x 20"]),
        (lambda folder: [path.unlink() for path in folder.iterdir()], ["no picture"]),
    ],
    ids=["lone frame", "unreadable", "odd size", "empty"],
)
def test_pictures_that_cannot_be_used(softbed, finished_run, tmp_path, monkeypatch, spoil, words):
    photographs = tmp_path / "photographs"
    shutil.copytree(finished_run / "footage" / "frames", photographs)
    spoil(photographs)
    monkeypatch.chdir(tmp_path)
    status, _, error = softbed("analyze", photographs)
    assert status == 2
    assert_one_line(error, *words)
    assert not (tmp_path / "photographs-softbed").exists()


def test_scale_of_a_run_is_its_own(softbed, finished_run):
    status, _, error = softbed("analyze", finished_run, "--frame-rate", "3")
    assert status == 2
    assert_one_line(error, "--frame-rate")


def test_new_scene(softbed, tmp_path):
    file = tmp_path / "my wheel.toml"
    assert softbed("new-scene", file)[0] == 0
    assert file.read_text().count("#") > 20
    assert synth.load_scene(file).name == "my_wheel"
    status, _, error = softbed("new-scene", file)
    assert status == 2
    assert_one_line(error, "exists already")
    status, _, error = softbed("new-scene", tmp_path / "b.toml", "--from", "nothing")
    assert status == 2
    assert_one_line(error, "nothing", "plate_rotation")
    assert softbed("new-scene", tmp_path / "b.toml", "--from", "plate_rotation")[0] == 0


def test_an_interrupted_run_leaves_nothing_half_written(tmp_path, tiny_scene):
    (tmp_path / "slow.py").write_text(
        textwrap.dedent("""
            import time

            def flow(first, second, mask):
                print("measuring", flush=True)
                time.sleep(3600)
        """)
    )
    out = tmp_path / "out"
    command = [sys.executable, "-c", "from validation.cli import main; main()"]
    process = subprocess.Popen(
        [*command, "run", str(tiny_scene), str(out), "--method", "slow:flow"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        # A shell's background jobs ignore interrupts, and hand that down.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert process.stdout.readline() == "measuring\n"
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=300)
    assert process.returncode == 130
    assert "Traceback" not in error
    assert error.splitlines()[-1].startswith("softbed: interrupted")
    assert not (out / "analysis").exists()
    assert not [path for path in out.iterdir() if path.name.startswith(PARTIAL_PREFIX)]
    assert (out / "footage" / "truth.nc").is_file()


def test_version(softbed):
    status, output, _ = softbed("--version")
    assert status == 0
    assert output.startswith("softbed ")


def test_help_is_instant():
    command = [sys.executable, "-c", "from validation.cli import main; main()", "--help"]
    times = []
    for _ in range(5):
        before = _processor_time_of_children()
        subprocess.run(command, capture_output=True, check=True)
        times.append(_processor_time_of_children() - before)
    assert min(times) < 0.5


def _processor_time_of_children():
    """Seconds; unlike the clock on the wall, it does not tell what else the machine is doing."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime
