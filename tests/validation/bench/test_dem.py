import json

import pytest

from validation.bench import dem
from validation.bench.lammps import Lammps, PeerError
from validation.bench.rows import BenchRow, bench_document


def test_bed_scene_has_about_as_many_grains_as_asked_for():
    scene = dem.bed_scene(20_000)
    area = scene.bed.width * scene.bed.depth * 0.8
    assert area / (3.14159 / 4 * scene.bed.grain_diameter**2) == pytest.approx(20_000, rel=0.01)
    assert scene.contact == dem.bed_scene(500).contact


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(
        dem, "_same_bytes", lambda count: BenchRow("", "", "", True, "same bytes", 1.0, "1", 2)
    )
    return {"grain_counts": [300], "repeats": 2, "steps": 80, "threads": 1}


def test_a_peer_that_is_missing_is_a_row_with_the_reason(monkeypatch, small):
    monkeypatch.setenv("PATH", "/nowhere")
    rows = dem.bench_dem(**small)
    own, peer, ratio = rows[:3]
    assert own.value > 0
    assert own.repeats == 2
    assert (peer.value, ratio.value) == (None, None)
    assert "lmp is not on the PATH" in peer.version


def test_lammps_runs_the_same_bed(small):
    try:
        Lammps.find()
    except PeerError as missing:
        pytest.skip(str(missing))
    own, peer, ratio = dem.bench_dem(**small)[:3]
    assert peer.value > 0
    assert ratio.value == pytest.approx(own.value / peer.value, rel=1)


def test_document_is_json_with_the_machine_and_every_row():
    rows = [BenchRow("bed", "softbed", "1", True, "particle-steps", 2.0, "1/s", 3)]
    document = json.loads(json.dumps(bench_document("dem", rows, threads=2, device="cpu")))
    assert document["machine"].keys() == {"cpu", "threads", "device"}
    assert document["rows"][0]["value"] == 2.0
    assert document["bench"] == "dem"
