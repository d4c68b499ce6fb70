"""What a person does with sweeps and data sets on the command line."""

import json
import shutil

import h5py
import numpy as np
import pytest
import tomli_w

from soft.flow.flo import read_flo
from soft.flow.kitti import QUANTUM, read_kitti
from synth.dataset import load_data_set
from synth.dataset.forecast import START_SECONDS, forecast
from synth.dataset.stage_seconds import bed_step_count, grain_count, step_count
from synth.scene import changed_scene, load_scene


def test_a_dry_run_says_how_many_how_long_how_large_and_writes_nothing(softbed, sand_sweep, tmp_path):
    status, output, _ = softbed(
        "sweep", sand_sweep, tmp_path / "out", "--dry-run", "--json", "--workers", "4"
    )
    found = json.loads(output)
    assert status == 0 and not (tmp_path / "out").exists()
    assert (found["member_count"], found["simulation_count"], found["bed_count"]) == (2, 2, 0)
    assert found["frame_count"] == 6 and found["split_counts"] == {"train": 1, "validation": 0, "test": 1}
    assert found["empty_splits"] == []  # none was to be filled that is empty
    assert found["seconds"] == pytest.approx(START_SECONDS + sum(found["core_seconds"].values()) / 4)
    assert found["bytes"] == pytest.approx(6 * 96 * 64 * 11)
    status, output, _ = softbed("sweep", sand_sweep, tmp_path / "out", "--dry-run")
    assert status == 0 and "2 (1 train, 0 validation, 1 test)" in output and "by stated rates" in output


def test_a_dry_run_counts_what_is_there_and_rests_on_it(softbed, sand_sweep, sand_set, tmp_path):
    copy = shutil.copytree(sand_set, tmp_path / "copy")
    shutil.rmtree(next((copy / "sequences").iterdir()))
    found = json.loads(softbed("sweep", sand_sweep, copy, "--dry-run", "--json")[1])
    assert (found["made_count"], found["frame_count"], found["simulation_count"]) == (1, 3, 0)
    assert found["basis"] == "1 members that are there"
    facts = next((copy / "sequences").glob("*/facts.json"))
    took = json.loads(facts.read_text())["seconds"]["pictures"]
    assert found["core_seconds"]["pictures"] == pytest.approx(took)


def test_grains_and_steps_are_foretold_about_as_they_came():
    scene = load_scene("studies/rolling_60mm")
    assert grain_count(scene) == pytest.approx(7936, rel=0.1)  # of its settled bed, docs/simulator.md
    assert step_count(scene) == pytest.approx(1.43e6, rel=0.03)
    # Counted while they settled: soft contacts of a bed, and of one whose own are hardly harder.
    for name, diameter, counted in (("rolling_wheel", 2.2e-3, 58_515), ("bucket", 3e-3, 35_454)):
        scene = changed_scene(load_scene(name, quick=True), {"bed.grain_diameter": diameter})
        assert bed_step_count(scene) == pytest.approx(counted, rel=0.05)


def test_the_bench_s_sweep_is_foretold_as_it_was_timed(tmp_path):
    from validation.bench.sweep import CASE

    tables = {"schema_version": 1, "name": "bench", "design": {"kind": "grid"}, **CASE}
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(tables))
    for workers, timed in ((1, 140), (2, 66)):  # two quiet cores, docs/datasets.md
        found = forecast(tmp_path / "sweep.toml", tmp_path / "out", workers=workers)
        assert found.seconds == pytest.approx(timed, rel=0.15)
    assert (found.bed_count, found.simulation_count, found.member_count) == (2, 4, 8)


def test_without_dask_it_says_how_to_install_it(softbed, sand_sweep, tmp_path, monkeypatch):
    import importlib.util

    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *rest: None if name == "distributed" else found(name, *rest)
    )
    status, _, error = softbed("sweep", sand_sweep, tmp_path / "out")
    assert status == 2
    assert error.splitlines()[-1].endswith("pip install 'softbed[cluster]'")


def test_bad_input_is_one_line(softbed, sand_sweep, tmp_path):
    bad = tmp_path / "bad.toml"
    bad.write_text(sand_sweep.read_text().replace("motion.angle", "motion.angel"))
    for options in ([], ["--dry-run"]):
        status, _, error = softbed("sweep", bad, tmp_path / "out", *options)
        assert status == 2 and "motion.angel = 0.01: unknown key" in error.splitlines()[-1]
    status, _, error = softbed("sweep", sand_sweep, tmp_path, "--scheduler", "tcp://h:1", "--workers", "2")
    assert status == 2 and "--workers" in error


def test_check_finds_what_is_wrong_in_a_data_set(softbed, sand_set, tmp_path):
    status, output, _ = softbed("check", sand_set)
    assert status == 0 and "data set" in output and output.rstrip().endswith("whole")
    copy = shutil.copytree(sand_set, tmp_path / "copy")
    first, second = sorted((copy / "sequences").iterdir())
    with h5py.File(first / "truth.nc", "r+") as file:
        file["u"][0, 5, 7] += 0.25
    (second / "frames" / "000001.png").unlink()
    (copy / "notes.txt").touch()
    document = json.loads(softbed("check", copy, "--json")[1])
    faults = {fault["file"]: fault["fault"] for fault in document["faults"]}
    assert document["kind"] == "data set" and not document["passed"]
    assert faults[f"sequences/{first.name}/truth.nc"] == "edited: other content than was written"
    assert faults[f"sequences/{second.name}/frames/000001.png"] == "missing"
    assert "notes.txt: not of this data set" in document["remarks"]
    assert any("softbed sweep" in remark for remark in document["remarks"])


def test_what_is_removed_is_made_again_with_the_same_values(softbed, sand_sweep, sand_set, tmp_path):
    copy = shutil.copytree(sand_set, tmp_path / "copy")
    shutil.rmtree(sorted((copy / "sequences").iterdir())[0])
    shutil.rmtree(copy / "recordings")
    status, output, _ = softbed("sweep", sand_sweep, copy, "--workers", "1", "--json")
    assert status == 0
    assert json.loads(output)["digest"] == json.loads((sand_set / "manifest.json").read_text())["digest"]


def test_a_sequence_is_footage_to_every_command(softbed, sand_set, tmp_path):
    sequence = sorted((sand_set / "sequences").iterdir())[0]
    assert softbed("check", sequence)[0] == 0
    status, output, _ = softbed("analyze", sequence, "--method", "dis", "--out", tmp_path / "dis", "--json")
    assert status == 0, output
    status, output, _ = softbed("score", sequence, "--out", tmp_path / "dis", "--json")
    assert status == 0 and json.loads(output)["methods"]["dis"]["strata"]["all"]["median"] < 0.5


def test_export_as_sintel_and_kitti(softbed, sand_set, tmp_path):
    data = load_data_set(sand_set)
    for layout in ("sintel", "kitti-flow"):
        assert softbed("export", sand_set, "--format", layout, "--out", tmp_path / layout)[0] == 0
        assert {path.name for path in (tmp_path / layout).iterdir()} == {"train", "test"}
    sequence = data.split("train")[0]
    pair = sequence.pair(1)
    training = tmp_path / "sintel/train/Sintel/training"
    flow = read_flo(training / "flow" / sequence.name / "frame_0002.flo")
    np.testing.assert_array_equal(flow, pair.flow)
    assert len(list((training / "clean" / sequence.name).iterdir())) == 3
    kitti = tmp_path / "kitti-flow/test/KittiFlow/training"
    assert (kitti / "pairs.csv").read_text().splitlines()[2] == f"000001,{data.split('test')[0].name},1"
    known = data.split("test")[0].pair(1)
    flow = read_kitti(kitti / "flow_occ/000001_10.png")
    np.testing.assert_allclose(flow, known.flow, atol=QUANTUM / 2 * 1.001)
    status, _, error = softbed("export", sand_set, "--format", "sintel", "--out", tmp_path / "sintel")
    assert status == 2 and "there already" in error
    status, _, error = softbed("export", sand_set, "--format", "sintel", "--out", sand_set / "sintel")
    assert status == 2 and "inside the data set" in error


def test_torchvision_reads_the_exports(softbed, sand_set, tmp_path):
    datasets = pytest.importorskip("torchvision.datasets")
    pairs = load_data_set(sand_set).pairs("train")
    for layout in ("sintel", "kitti-flow"):
        assert softbed("export", sand_set, "--format", layout, "--out", tmp_path / layout)[0] == 0
    sintel = datasets.Sintel(tmp_path / "sintel/train", split="train", pass_name="clean")
    kitti = datasets.KittiFlow(tmp_path / "kitti-flow/train", split="train")
    assert len(sintel) == len(kitti) == len(pairs) == 2
    for index, pair in enumerate(pairs):
        first, second, flow, *_ = sintel[index]
        np.testing.assert_array_equal(np.asarray(first)[..., 0], pair.first)
        np.testing.assert_array_equal(np.asarray(second)[..., 2], pair.second)
        np.testing.assert_array_equal(flow.transpose(1, 2, 0)[pair.valid], pair.flow[pair.valid])
        first, second, flow, valid = kitti[index]
        np.testing.assert_array_equal(np.asarray(second)[..., 1], pair.second)
        np.testing.assert_array_equal(valid, pair.valid)
        np.testing.assert_allclose(flow.transpose(1, 2, 0)[valid], pair.flow[valid], atol=QUANTUM / 2 * 1.001)
