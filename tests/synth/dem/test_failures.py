"""What goes wrong is said: which grain, where, and what to change."""

from dataclasses import replace

import numpy as np
import pytest

from synth import simulate
from synth.dem.failures import (
    SimulationError,
    check_bin,
    check_implement,
    check_inside,
    check_numbers,
    check_overlaps,
)
from synth.dem.grains import Grains
from synth.dem.tool import Tool
from synth.implements import Shape
from synth.scene import parse_scene


@pytest.fixture
def grains():
    return Grains.at_rest(np.array([[0.05, 0.06, 0.07], [0.01, 0.01, 0.01]]), np.full(3, 2e-3), 2000.0)


@pytest.fixture
def wheel(tiny_wheel):
    return Tool(tiny_wheel.implement.shape, x=0.05, z=0.061, heaves=True)


def moved(grains, index, x, z):
    position = grains.position.copy()
    position[:, index] = x, z
    return replace(grains, position=position)


def test_sound_grains_pass(grains, wheel, tiny_wheel):
    check_numbers(grains)
    check_bin(grains, tiny_wheel, wheel)
    check_overlaps(grains, np.array([[0], [1]]), np.array([0.01]), tiny_wheel)
    check_implement(wheel, tiny_wheel, wheel)


def test_not_a_number(grains):
    with pytest.raises(SimulationError, match=r"grain 2 at .* no longer a number: take contact.steps"):
        check_numbers(moved(grains, 2, np.nan, 0.01))


@pytest.mark.parametrize(
    ("x", "z", "words"),
    [
        (0.05, -1e-3, "through the floor: take contact.normal_stiffness higher"),
        (-1e-3, 0.01, "through the left end wall"),
        (0.161, 0.01, "through the right end wall"),
        (0.05, 0.2, "thrown out of the bin: take timing.speed_up"),
    ],
)
def test_grain_that_leaves_the_bin(grains, wheel, tiny_wheel, x, z, words):
    with pytest.raises(SimulationError, match=f"grain 1 at x = {x:.4g} m, z = {z:.4g} m .*{words}"):
        check_bin(moved(grains, 1, x, z), tiny_wheel, wheel)


def test_grains_in_each_other(grains, tiny_wheel):
    with pytest.raises(SimulationError, match=r"grain 1 at .* and grain 2 overlap by 30 % .*normal_stiff"):
        check_overlaps(grains, np.array([[0, 1], [1, 2]]), np.array([0.01, 0.3]), tiny_wheel)


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        ({"z": 0.031}, "sunk to the floor: take bed.depth"),
        ({"z": 0.09}, "shot up by 29 mm: take timing.speed_up lower"),
        ({"x": 0.14}, "run into an end wall: take bed.width"),
        ({"z": np.nan}, "no longer a number"),
    ],
)
def test_stuck_implement(wheel, tiny_wheel, pose, words):
    with pytest.raises(SimulationError, match=words):
        check_implement(replace(wheel, **pose), tiny_wheel, wheel)


def test_a_grain_inside_a_solid_implement(grains, tiny_wheel):
    solid = Tool(Shape.outline(np.array([[0, 0], [0.02, 0], [0.02, 0.01], [0, 0.01]])), x=0.065, z=0.02)
    check_inside(grains, solid, tiny_wheel)
    with pytest.raises(SimulationError, match=r"grain 1 at x = 0.07 m, z = 0.025 m is inside the implement"):
        check_inside(moved(grains, 1, 0.07, 0.025), solid, tiny_wheel)
    turned = replace(solid, angle=np.pi / 2)  # now from 0.055 to 0.065 m, and up to 0.04 m
    check_inside(moved(grains, 1, 0.07, 0.025), turned, tiny_wheel)
    with pytest.raises(SimulationError, match="is inside the implement"):
        check_inside(moved(grains, 1, 0.06, 0.035), turned, tiny_wheel)


def test_what_was_recorded_comes_with_the_error(tiny_wheel):
    tables = tiny_wheel.to_dict()
    tables["implement"]["normal_load"] = 400.0
    with pytest.raises(
        SimulationError, match=r"stopped at t = .* s in the laboratory: grain \d+ .*(moved|overlap)"
    ) as stop:
        simulate(parse_scene(tables))
    recording = stop.value.recording
    assert recording.data.sizes["sample"] > 0
    assert recording.data.attrs["stopped"] == str(stop.value)
    assert recording.frame_count < tiny_wheel.timing.frame_count


def test_steps_too_coarse_for_the_wheel_name_a_grain(tiny_wheel, monkeypatch):
    """A time step twenty times too long, which no scene can ask for."""
    from synth.dem import run

    largest = run.time_step_of
    monkeypatch.setattr(run, "time_step_of", lambda *args: 20 * largest(*args))
    with pytest.raises(SimulationError, match=r"stopped at t = .* laboratory: grain \d+ .*: take "):
        simulate(tiny_wheel)
