"""The keys that docs/formats.md lists are those that the program writes."""

import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from soft import ImageSequence, analyze
from soft.soilflow import INTERVAL_VARIABLES, NODE_VARIABLES
from synth import recording, truth
from synth.scene import SoilBinScene
from validation.scoring.averaging import AveragingScore
from validation.scoring.camera import CameraScore
from validation.scoring.regions import RegionScore


@pytest.fixture(scope="module")
def page():
    return (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def told(page):
    """Every word in backquotes."""
    return set(re.findall("`([^`\n]+)`", page))


@pytest.fixture(scope="module")
def tabled(page):
    """Of every variable in a table: over what, and its unit."""
    rows = re.findall(r"^\| `(\w+)` \| ([^|]*) \| ([^|]*) \| [^|]+ \|$", page, re.MULTILINE)
    return {(name, over, unit) for name, over, unit in rows}


def test_of_scores(told):
    names = {one.name for score in (CameraScore, RegionScore) for one in fields(score)}
    averaging = AveragingScore((1,), (0.5,)).to_dict()
    assert names | set(averaging) | set(averaging["averaging"]) <= told


def test_of_a_soil_flow(told, tabled):
    pictures = np.random.default_rng(0).uniform(0, 255, (2, 64, 64)).astype(np.float32)
    sequence = ImageSequence.from_arrays(list(pictures), metres_per_pixel=2e-4, frame_rate=8.0)
    flow = analyze(sequence, method="dis", soil="all")
    attributes = {
        "method",
        "options",
        "versions",
        "region_x",
        "region_y",
        "camera",
        "camera_speed",
        "vertical",
    }
    assert attributes <= flow.attrs.keys() and set(INTERVAL_VARIABLES) <= set(flow.data_vars)
    assert attributes | set(NODE_VARIABLES) <= told
    written = {(str(name), ", ".join(one.dims), one.attrs["units"]) for name, one in flow.variables.items()}
    assert written <= tabled


def test_of_a_recording(tabled):
    for kind in ("VARIABLES", "RIM_VARIABLES", "SLAB_VARIABLES", "CONTACT_VARIABLES"):
        for name, (over, unit, _) in getattr(recording, kind).items():
            assert (name, ", ".join(over), unit) in tabled


def test_of_the_truth(tabled):
    assert {(name, "pair, y, x", unit) for name, (_, unit, _) in truth.VARIABLES.items()} <= tabled
    assert {(name, "pair", unit) for name, (unit, _) in truth.CAMERA_VARIABLES.items()} <= tabled


def test_of_a_scene(told):
    assert "picture_seed" in told and "picture_seed" in SoilBinScene.model_fields
