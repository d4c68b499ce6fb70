"""Predict a run that the law was not fitted to, and lay it beside what the grains did."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from synth.rover.law.interface import PlacedWheel
from synth.rover.law.rft import ResistiveForceLaw, ResistiveSoil
from synth.rover.law.single_wheel import Paths, WheelRecord, lead
from synth.scene import SoilBinScene
from validation.identification.runs import Forces

_AVERAGED = 0.02
"""Time over which both are averaged / length of the run: grains make forces noisy."""
Row = dict[str, float | str]


@dataclass(frozen=True)
class Foretold:
    """A run and its prediction, over the run's own times, averaged alike; each of shape (n,)."""

    label: str
    load: float
    radius: float
    time: NDArray
    travel: NDArray
    measured: dict[str, NDArray]
    predicted: dict[str, NDArray]


@dataclass(frozen=True)
class Phase:
    """A part of a run that is told by its means."""

    name: str
    start: float
    end: float


def foretell(label: str, scene: SoilBinScene, forces: Forces, soil: ResistiveSoil) -> Foretold:
    """Lead a wheel under the law along the run's path."""
    wheel = scene.implement
    radius, width = wheel.radius, wheel.width  # type: ignore[union-attr]
    paths, time = Paths.of_scene(scene)
    record = lead(ResistiveForceLaw(soil), [PlacedWheel(label, label, radius, width)], paths)
    window = max(1, round(_AVERAGED * forces.time.size))
    measured = {name: _averaged(getattr(forces, name), window) for name in _NAMES}
    predicted = {
        name: _averaged(np.interp(forces.time, time, values), window)
        for name, values in _columns(record).items()
    }
    load = wheel.normal_load  # type: ignore[union-attr]
    return Foretold(label, load, radius, forces.time, forces.travel, measured, predicted)


def phases(scene: SoilBinScene) -> list[Phase]:
    """The parts of a run's program, at full load, told apart by what the wheel does."""
    program = scene.program
    end = (scene.timing.frame_count - 1) / scene.timing.frame_rate
    knots = np.append(program.time[program.time < end], end)
    found = []
    for start, stop in pairwise(knots):
        (speed, _, spin, load), (later, _, _, _) = program.at(start + 1e-9), program.at(stop - 1e-9)
        if load < 0.999 or abs(speed - later) > 1e-6 * (abs(speed) + 1e-9) or stop - start < 0.2:
            continue
        name = (
            "rolls"
            if speed > 0 and spin
            else "slides"
            if speed > 0
            else "is pushed"
            if speed < 0
            else "rests"
        )
        # The second half: what it comes to, not how it gets there.
        found.append(Phase(name, (start + stop) / 2, stop))
    return found


def phase_rows(foretold: Foretold, scene: SoilBinScene) -> list[Row]:
    """Means of both over each phase's second half."""
    rows: list[Row] = []
    for number, phase in enumerate(phases(scene), start=1):
        during = (foretold.time >= phase.start) & (foretold.time <= phase.end)
        row: Row = {"run": foretold.label, "phase": f"{number} {phase.name}"}
        for name in _NAMES:
            row[name] = float(foretold.measured[name][during].mean())
            row[f"{name}_law"] = float(foretold.predicted[name][during].mean())
        rows.append(row)
    return rows


_NAMES = ("sinkage", "force_x", "torque")


def _columns(record: WheelRecord) -> dict[str, NDArray]:
    return {
        "sinkage": record.sinkage[:, 0],
        "force_x": record.force_x[:, 0],
        "torque": -record.torque[:, 0],
    }


def _averaged(values: NDArray, window: int) -> NDArray:
    """Running mean; at the ends over what there is."""
    kernel = np.ones(window)
    return np.convolve(values, kernel, "same") / np.convolve(np.ones_like(values), kernel, "same")
