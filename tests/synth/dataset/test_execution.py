"""Whatever happens to workers, to the client and to the disk: nothing lost, nothing half-written."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from contextlib import nullcontext, suppress
from types import SimpleNamespace

import pytest

import synth
from synth.checksums import file_digest, read_checksums
from synth.dataset.facts import sequence_facts
from synth.dataset.folder import DataSetError, DataSetFolder
from synth.dataset.members import Failure
from synth.dataset.summary import read_facts
from synth.dataset.tasks import Order, photograph, settle, simulate
from synth.dataset.versions import decisive_versions
from synth.dem.failures import SimulationError
from synth.disk import system_complaint
from synth.footage import Footage
from synth.scene import changed_scene, load_scene
from tests.waiting import PATIENCE, wait_for

distributed = pytest.importorskip("distributed")

NOBODY = SimpleNamespace(dashboard_link="")
CLIENT = "from validation.cli import main; main()"
# Runs in every worker: checkpoints as often as can be, said in a file.
PRELOAD = """
import logging, os
logging.basicConfig(filename=os.environ["WORKER_LOG"])
logging.getLogger("synth.dataset.tasks").setLevel(logging.INFO)
if "OFTEN" in os.environ:
    from synth.dem import checkpoint
    checkpoint.CHECKPOINT_INTERVAL = 0.0
"""


@pytest.fixture
def start(tmp_path):
    """Start `softbed sweep` in a process of its own, its workers prepared by environment variables."""
    preload = tmp_path / "prepare_worker.py"
    preload.write_text(PRELOAD)
    started = []

    def start(sweep, out, *options, **environment):
        environment |= {"WORKER_LOG": str(tmp_path / "worker.log")}
        environment |= {"DASK_DISTRIBUTED__WORKER__PRELOAD": json.dumps([str(preload)])}
        process = subprocess.Popen(
            [sys.executable, "-c", CLIENT, "sweep", sweep, out, "--workers", "1", *options],
            env={**os.environ, **environment},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            # A shell's background jobs ignore interrupts, and hand that down.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()


@pytest.fixture
def worker_log(tmp_path):
    def read():
        path = tmp_path / "worker.log"
        return path.read_text() if path.is_file() else ""

    return read


def manifest_of(out):
    return json.loads((out / "manifest.json").read_text())


def table_of(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def workers_of(process):
    """Processes that a client has started, its workers among them."""
    import psutil

    alive = (one for one in psutil.Process(process.pid).children(recursive=True) if is_alive(one))
    return [one for one in alive if "spawn_main" in str(one.cmdline())]


def is_alive(process):
    """Neither gone nor waiting to be buried."""
    import psutil

    return process.is_running() and process.status() != psutil.STATUS_ZOMBIE


def assert_whole(out):
    """Every file is what it must be, every sequence opens, and nothing half-made is left."""
    sums = read_checksums(out)
    files = {p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file()} - {"SHA256SUMS"}
    assert files == set(sums)
    assert all(file_digest(out / name) == digest for name, digest in sums.items())
    for row in table_of(out / "members.csv"):
        folder = out / "sequences" / row["name"]
        assert row["status"] == "made"
        assert load_scene(folder / "scene.toml").hash.startswith(row["name"])
        Footage.open(folder).close()


def test_a_data_set_says_all_of_itself(sand_set):
    assert_whole(sand_set)
    manifest, rows = manifest_of(sand_set), table_of(sand_set / "members.csv")
    assert manifest["complete"] and manifest["pair_count"] == 12 and manifest["simulation_count"] == 3
    assert manifest["split_counts"] == {"train": 2, "validation": 2, "test": 2}
    assert manifest["versions"]["numpy"] and manifest["versions"]["distributed"]
    assert [float(row["motion.angle"]) for row in rows] == [0.01, 0.01, 0.02, 0.02, 0.03, 0.03]
    by_motion = {}
    for row in rows:
        by_motion.setdefault(row["simulation"], set()).add(row["split"])
    assert sorted(split for (split,) in by_motion.values()) == ["test", "train", "validation"]
    card = (sand_set / "data_card.md").read_text()
    for words in ("CC-BY-4.0", manifest["digest"], "rad", "`lens.blur` | 0.5, 1 |", "| train | 1 | 2 | 4 |"):
        assert words in card
    facts = json.loads((sand_set / "sequences" / rows[0]["name"] / "facts.json").read_text())
    # 0.01 rad about the middle: up to 0.58 px in the corners.
    assert sum(facts["displacement"][:7]) == sum(facts["displacement"]) > 0
    assert facts["soil"] == 1 and 0.9 < facts["valid"] < 1 and facts["moving"] == 0


def test_again_it_does_nothing_and_one_worker_makes_the_same(sand_sweep, sand_set, start, tmp_path):
    made = {path: path.stat().st_mtime_ns for path in (sand_set / "sequences").rglob("*")}
    process = start(sand_sweep, sand_set, "--json")
    output, error = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0 and "dashboard" not in error
    assert json.loads(output)["digest"] == manifest_of(sand_set)["digest"]
    assert made == {path: path.stat().st_mtime_ns for path in (sand_set / "sequences").rglob("*")}
    # From the sweep that the data set carries, in another folder, by one worker instead of two.
    process = start(sand_set / "sweep.toml", tmp_path / "again")
    assert "http://127.0.0.1" in process.communicate(timeout=PATIENCE)[1]
    assert process.returncode == 0
    assert manifest_of(tmp_path / "again")["digest"] == manifest_of(sand_set)["digest"]


def test_a_full_disk_is_told_leaves_nothing_and_is_made_good(
    sweep_of, sand_tables, start, small_disk, tmp_path
):
    disk, enlarge = small_disk(560)
    vary = {**sand_tables["vary"], "camera.width": [64, 512], "motion.angle": [0.02]}
    sweep, out = sweep_of(tmp_path / "given", **{**sand_tables, "vary": vary}), disk / "out"
    process = start(sweep, out)
    error = process.communicate(timeout=PATIENCE)[1]
    assert process.returncode == 1, error
    failures = table_of(out / "failures.csv")
    assert [(row["camera.width"], row["stage"]) for row in failures] == [("512", "pictures")] * 2
    for row in failures:
        assert row["reason"].endswith("No space left on device") and ".work" in row["reason"]
        assert f"failed: {row['name']}: pictures: {row['reason']}" in error.splitlines()
    assert [row["status"] for row in table_of(out / "members.csv")] == ["made", "failed"] * 2
    assert len(list((out / "sequences").iterdir())) == 2 and not list((out / ".work").rglob("*.png"))
    assert "**It is not complete: 2 of 4 sequences are missing.**" in (out / "data_card.md").read_text()
    kept = {path: path.stat().st_mtime_ns for path in (out / "sequences").rglob("*.*")}
    enlarge()
    vary["lens.blur"] = [0.5, 1.0, 1.5]  # more points of the same design are welcome
    sweep = sweep_of(tmp_path / "given", **{**sand_tables, "vary": vary})
    assert start(sweep, out).wait(PATIENCE) == 0
    assert_whole(out)
    assert manifest_of(out)["made_count"] == 6
    assert table_of(out / "failures.csv") == [] and not (out / ".work").exists()
    assert all(path.stat().st_mtime_ns == when for path, when in kept.items())


def test_what_is_said_of_a_data_set_is_written_whole_or_not_at_all(small_disk):
    disk, enlarge = small_disk(560)
    folder = DataSetFolder(disk)
    folder.write("members.csv", "name\n")
    with pytest.raises(OSError, match="No space left") as raised:
        folder.write("members.csv", b"x" * 600_000)
    assert system_complaint(raised.value) == f"{disk / 'members.csv'}: No space left on device"
    assert (disk / "members.csv").read_text() == "name\n" and not list((disk / ".work").iterdir())
    enlarge()
    folder.write("members.csv", b"x" * 600_000)
    assert (disk / "members.csv").stat().st_size == 600_000


def test_a_killed_worker_and_a_killed_client_lose_nothing(sweep_of, sand_tables, start, tmp_path):
    vary = {
        **sand_tables["vary"],
        "timing.frame_count": [40],
        "motion.angle": [0.001, 0.002],
        "lens.blur": [1.0],
    }
    sweep, out = sweep_of(tmp_path / "given", **{**sand_tables, "vary": vary}), tmp_path / "out"

    def half_made(since=0.0):
        with suppress(FileNotFoundError):  # removed while we looked
            return [p for p in out.glob(".work/*/*/frames/000002.png") if p.stat().st_mtime > since]

    # Starting a worker again takes longer than dask waits on a busy machine: here, as if it always did.
    process = start(sweep, out, DASK_DISTRIBUTED__DEPLOY__LOST_WORKER_TIMEOUT="1 ms")
    wait_for(lambda: workers_of(process))
    killed = workers_of(process)
    wait_for(half_made)
    for worker in killed:
        worker.kill()
    when = time.time()
    assert half_made() and not list(out.glob("sequences/*"))
    wait_for(lambda: any(worker not in killed for worker in workers_of(process)))
    wait_for(lambda: list(out.glob("sequences/*")))
    workers = workers_of(process)
    wait_for(lambda: half_made(since=when))
    process.kill()
    process.wait()
    wait_for(lambda: not any(map(is_alive, workers)))
    assert half_made() and len(list(out.glob("sequences/*"))) == 1
    assert start(sweep, out).wait(PATIENCE) == 0
    assert_whole(out)
    assert not (out / ".work").exists()
    for row in table_of(out / "members.csv"):
        assert (
            digest_in_this_process(out, row["name"], tmp_path)
            == read_facts(DataSetFolder(out), row["name"])["digest"]
        )


def test_an_interrupt_ends_the_workers_and_leaves_nothing_half_written(
    sweep_of, sand_tables, start, tmp_path
):
    vary = {**sand_tables["vary"], "timing.frame_count": [400], "motion.angle": [0.001], "lens.blur": [1.0]}
    sweep, out = sweep_of(tmp_path / "given", **{**sand_tables, "vary": vary}), tmp_path / "out"
    process = start(sweep, out)
    wait_for(lambda: list(out.glob(".work/*/*/frames/000002.png")))
    workers = workers_of(process)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does it: the workers are told, too
    error = process.communicate(timeout=PATIENCE)[1]
    assert process.returncode == 130 and "the same command goes on" in error.splitlines()[-1]
    assert "Traceback" not in error
    wait_for(lambda: not any(map(is_alive, workers)))
    assert not list(out.glob("sequences/*"))


def digest_in_this_process(out, name, tmp_path):
    """Hash of a member's values, made once more without a cluster."""
    scene = load_scene(out / "sequences" / name / "scene.toml")
    with synth.render(synth.simulate(scene), scene, tmp_path / name) as footage:
        return sequence_facts(footage)["digest"]


@pytest.mark.slow
def test_a_killed_worker_s_simulation_goes_on_from_its_checkpoint(wheel_sweep, start, worker_log, tmp_path):
    undisturbed, out = tmp_path / "undisturbed", tmp_path / "out"
    assert start(wheel_sweep, undisturbed).wait(PATIENCE) == 0
    process = start(wheel_sweep, out, OFTEN="1")
    wait_for(lambda: list(out.glob(".work/*/checkpoint/state.npz")))
    for worker in workers_of(process):
        worker.kill()
    wait_for(lambda: "checkpoint: goes on after" in worker_log())
    workers = workers_of(process)
    wait_for(lambda: list(out.glob(".work/*/*/frames/000001.png")))
    process.kill()
    process.wait()
    wait_for(lambda: not any(map(is_alive, workers)))
    assert len(list(out.glob("sequences/*"))) < 4
    assert start(wheel_sweep, out).wait(PATIENCE) == 0
    assert_whole(out)
    assert manifest_of(out)["digest"] == manifest_of(undisturbed)["digest"]
    recordings = [
        {path.name: file_digest(path) for path in (folder / "recordings").iterdir()}
        for folder in (out, undisturbed)
    ]
    assert recordings[0] == recordings[1] and len(recordings[0]) == 2


@pytest.mark.slow
def test_a_simulation_that_must_stop_is_a_failure_and_leaves_nothing(tiny_wheel, tmp_path):
    heavy = changed_scene(tiny_wheel, {"implement.normal_load": 400.0})
    folder = DataSetFolder(tmp_path)
    folder.write("sweep.toml", "")
    order = Order(folder, "cpu", decisive_versions())
    failure = simulate(order, heavy, settle(order, heavy))
    assert failure.stage == "simulation" and "grain" in failure.reason and "\n" not in failure.reason
    assert photograph(order, heavy, failure) is failure
    assert not (tmp_path / "recordings").exists() and not list((tmp_path / ".work").iterdir())


def test_a_stage_s_failure_is_handed_on_and_leaves_nothing(quick_sand, tmp_path, monkeypatch):
    def stop(*_, checkpoint, **__):
        checkpoint.mkdir(parents=True)
        raise SimulationError("grain 7 left the bin", "lower timing.speed_up")

    monkeypatch.setattr(synth, "simulate", stop)
    folder = DataSetFolder(tmp_path)
    folder.write("sweep.toml", "")
    order = Order(folder, "cpu", decisive_versions())
    failure = simulate(order, quick_sand)
    assert failure == Failure("simulation", "grain 7 left the bin: lower timing.speed_up")
    assert photograph(order, quick_sand, failure) is failure
    assert not (tmp_path / "recordings").exists() and not list((tmp_path / ".work").iterdir())


def test_workers_of_another_kind_are_refused(quick_sand, tmp_path):
    folder = DataSetFolder(tmp_path)
    order = Order(folder, "cpu", decisive_versions())
    assert "a shared file system is needed" in simulate(order, quick_sand).reason
    folder.write("sweep.toml", "")
    other = Order(folder, "cpu", {**decisive_versions(), "scipy": "0.1"})
    assert "scipy" in simulate(other, quick_sand).reason


def test_another_sweep_s_folder_and_a_stranger_s_are_refused(sweep_of, sand_tables, sand_set, tmp_path):
    from synth.dataset.execution import make_data_set

    other = sweep_of(tmp_path / "other", **{**sand_tables, "seed": 4})
    with pytest.raises(DataSetError, match="not of this sweep"):
        make_data_set(other, sand_set)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").touch()
    with pytest.raises(DataSetError, match=r"thesis\.tex"):
        make_data_set(other, tmp_path / "full")
    assert tomllib.loads((sand_set / "sweep.toml").read_text())["seed"] == 3


def test_a_scheduler_of_the_user_s_own_makes_the_same(sand_sweep, sand_set, tmp_path):
    from synth.dataset.execution import make_data_set

    with distributed.LocalCluster(n_workers=1, threads_per_worker=2, dashboard_address=None) as cluster:
        manifest = make_data_set(sand_sweep, tmp_path / "out", scheduler=cluster.scheduler_address)
    assert manifest["digest"] == manifest_of(sand_set)["digest"]


def test_a_task_that_kills_its_workers_is_a_failure_with_its_stage():
    from synth.dataset.execution import _failure

    error = distributed.KilledWorker("bed-0123-abcd", SimpleNamespace(address="tcp://h:1"), 3)
    failure = _failure(error)
    assert (
        failure.stage == "bed" and "4 workers died of it" in failure.reason and "tcp://h:1" in failure.reason
    )


def test_a_scheduler_that_is_not_there_is_named(sand_sweep, tmp_path, monkeypatch):
    from synth.dataset import cluster
    from synth.dataset.execution import make_data_set

    monkeypatch.setattr(cluster, "_CONNECT_SECONDS", 1)
    with pytest.raises(cluster.ClusterError, match=r"tcp://127\.0\.0\.1:9"):
        make_data_set(sand_sweep, tmp_path / "out", scheduler="tcp://127.0.0.1:9")


def test_two_at_once_are_told_apart(sand_sweep, sand_set):
    from synth.dataset.execution import make_data_set
    from synth.dataset.folder import DataSetFolder

    with (
        DataSetFolder(sand_set).sole_user(),
        pytest.raises(DataSetError, match="another softbed works on it"),
    ):
        make_data_set(sand_sweep, sand_set)
    DataSetFolder(sand_set).remove_work()


def test_splits_that_stay_empty_are_told(sweep_of, sand_tables, tmp_path, monkeypatch):
    """Of three motions, none is for the validation; all of one split fail."""
    from synth.dataset.execution import make_data_set

    def carry_out(client, order, missing, total, failures, *rest):
        failures.update({one.name: Failure("pictures", "no") for one in missing})

    monkeypatch.setattr("synth.dataset.execution.cluster_client", lambda **_: nullcontext(NOBODY))
    monkeypatch.setattr("synth.dataset.execution._carry_out", carry_out)
    split = {"train": 0.9, "validation": 0.1, "test": 0.0}
    said = []
    make_data_set(sweep_of(tmp_path, **{**sand_tables, "split": split}), tmp_path / "out", say=said.append)
    assert [line for line in said if line.startswith("warning")] == [
        "warning: no member in the split 'validation': simulations are dealt out whole, and are too few",
        "warning: no member of the split 'train' could be made: it is empty",
    ]
