"""The gate on its own clips: methods made worse on purpose fail, the same method passes."""

import json

import numpy as np
import pytest
import xarray as xr
from scipy.ndimage import gaussian_filter, map_coordinates

import soft
import synth
from validation.check import check_folder
from validation.gate.measurement import SHIPPED_CLIPS, Measurement, find_clips, pair_scores
from validation.gate.verdict import compare


@pytest.fixture(scope="module")
def measured():
    """What DIS measures on every pair of every clip: truth and displacement."""
    pairs = {}
    for folder in find_clips(SHIPPED_CLIPS):
        with synth.Footage.open(folder) as footage:
            pairs[folder.name] = [
                (footage.truth(k).load(), flow_of(footage, k)) for k in range(footage.pair_count)
            ]
    return pairs


def flow_of(footage, pair):
    first, second = (footage.picture(k).astype(np.float32) for k in (pair, pair + 1))
    return soft.estimate_flow(first, second, method="dis").displacement


def scored(measured, change):
    clips = {
        clip: [pair_scores(truth, as_flow(change(field))) for truth, field in pairs]
        for clip, pairs in measured.items()
    }
    return Measurement("a method", "digest", clips, {})


def as_flow(field):
    u, v = np.moveaxis(field, 2, 0)
    return xr.Dataset({"u": (("y", "x"), u), "v": (("y", "x"), v)})


@pytest.fixture(scope="module")
def baseline(measured):
    return scored(measured, lambda field: field)


def failed(baseline, measured, change):
    return {(row.stratum, row.quantity) for row in compare(baseline, scored(measured, change)) if row.worse}


def slightly_blurred(field):
    unknown = np.isnan(field)
    weight = np.maximum(gaussian_filter(1.0 - unknown, (4, 4, 0)), 1e-6)
    smooth = gaussian_filter(np.where(unknown, 0, field), (4, 4, 0)) / weight
    return np.where(unknown, np.nan, smooth)


def biased(field):
    return field + np.float32([0.05, 0])


def at_the_middle(field):
    """What a symmetric method tells: the motion of what is at a pixel half-way between the pictures."""
    y, x = np.indices(field.shape[:2], dtype=np.float32)
    known = np.nan_to_num(field)
    back = [y - known[:, :, 1] / 2, x - known[:, :, 0] / 2]
    moved = np.stack([map_coordinates(known[:, :, k], back, order=1, mode="nearest") for k in (0, 1)], axis=2)
    return np.where(np.isnan(field), np.nan, moved)


def flipped(field):
    return field * np.float32([1, -1])


def swapped(field):
    return field[:, :, ::-1]


def silent_where_hard(field):
    steep = np.abs(np.gradient(np.nan_to_num(field), axis=(0, 1))).max(axis=(0, 3)) > 0.1
    return np.where(steep[:, :, np.newaxis], np.nan, field)


@pytest.mark.parametrize(
    "change",
    [slightly_blurred, biased, at_the_middle, flipped, swapped, silent_where_hard],
    ids=lambda f: f.__name__,
)
def test_fails_on_a_method_made_worse(baseline, measured, change):
    assert failed(baseline, measured, change)


def test_tells_where_a_method_is_silent(baseline, measured):
    assert ("complex", "wrong_share") in failed(baseline, measured, silent_where_hard)


def test_passes_on_reruns(measured):
    """A method whose numbers differ from run to run."""

    def run(seed):
        random = np.random.default_rng(seed)
        return lambda field: field + random.normal(0, 0.02, field.shape).astype(np.float32)

    baseline = scored(measured, run(100))
    for seed in range(20):
        assert not failed(baseline, measured, run(seed))


def test_clips_are_whole():
    for folder in find_clips(SHIPPED_CLIPS):
        assert not check_folder(folder).faults


def test_command(softbed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_flow.py").write_text(
        "import numpy as np, pathlib, soft\n"
        "def flow(first, second, mask):\n"
        "    bias = float(pathlib.Path('bias').read_text())\n"
        "    field = soft.estimate_flow(first, second, method='farneback')\n"
        "    return field.displacement + np.float32([bias, 0])\n"
    )
    clips = tmp_path / "clips"
    clips.mkdir()
    for name in ("rolling_wheel", "plate_rotation"):
        (clips / name).symlink_to(SHIPPED_CLIPS / name)
    command = ["gate", "--method", "my_flow:flow", "--clips", clips, "--baseline", tmp_path / "b.json"]

    (tmp_path / "bias").write_text("0")
    status, _, err = softbed(*command)
    assert status == 2 and "no baseline there" in err
    assert softbed(*command, "--update")[0] == 0
    assert softbed(*command)[0] == 0

    (tmp_path / "bias").write_text("0.3")
    status, out, _ = softbed(*command, "--json")
    told = json.loads(out)
    assert status == 1 and not told["passed"]
    assert any(row["worse"] and row["quantity"] == "median" for row in told["rows"])
    status, out, _ = softbed(*command)
    assert status == 1 and "failed: worse is" in out
