"""The keys that docs/figures.md lists are those that the program writes."""

import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from soft import ImageSequence, analyze
from soft.soilflow import INTERVAL_VARIABLES, NODE_VARIABLES
from synth.scene import SoilBinScene
from validation.averaging import AveragingScore
from validation.camera import CameraScore
from validation.regions import RegionScore


@pytest.fixture(scope="module")
def told():
    """Every word in backquotes of the table."""
    text = (Path(__file__).parents[2] / "docs" / "figures.md").read_text(encoding="utf-8")
    return set(re.findall("`([^`]+)`", text.partition("## What this program's own files hold")[2]))


def test_of_scores(told):
    names = {one.name for score in (CameraScore, RegionScore) for one in fields(score)}
    averaging = AveragingScore((1,), (0.5,)).to_dict()
    assert names | set(averaging) | set(averaging["averaging"]) <= told


def test_of_a_soil_flow(told):
    pictures = np.random.default_rng(0).uniform(0, 255, (2, 64, 64)).astype(np.float32)
    flow = analyze(ImageSequence.from_arrays(list(pictures)), method="dis", soil="all")
    attributes = {"region_x", "region_y", "camera", "camera_speed", "vertical"}
    assert attributes <= flow.attrs.keys() and set(INTERVAL_VARIABLES) <= set(flow.data_vars)
    assert attributes | set(INTERVAL_VARIABLES) | set(NODE_VARIABLES) <= told


def test_of_a_scene(told):
    assert "picture_seed" in told and "picture_seed" in SoilBinScene.model_fields
