"""A real single-wheel rig: a law fitted to its driven half predicts its braked half."""

from collections import defaultdict
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from soft.flow.mat_file import read_mat
from synth.rover.law.catalogue import loose_grc1
from synth.rover.law.identification import FIRST_SHEAR_SHARE, Identification, Trial, identify, predict
from synth.rover.law.response import published_scale
from synth.rover.law.rft import ResistiveForceLaw
from synth.rover.law.steady import SteadyForces, steady_forces

RADIUS, WIDTH = 0.058, 0.05
"""m, of the rig's smooth wheel."""
DENSITY, REPOSE = 1330.0, 29.0
"""kg/m3, and deg: the angle of repose stands for that of internal friction."""
_BRAKED = -0.05
"""Slip below which a wheel counts as braked."""


class RigError(ValueError):
    """A file that is not the rig's; the message names it and what is needed."""


@dataclass(frozen=True)
class RigComparison:
    """What was measured, the law fitted to driven trials, and what it gives for all of them.

    `at_sinkage` are its steady forces on a wheel held at the measured sinkage: they tell whether it is the
    drag that is off, or how deep the wheel sinks.
    """

    measured: list[Trial]
    identification: Identification
    predicted: list[Trial]
    unfitted: list[Trial]
    at_sinkage: list[SteadyForces]

    def is_braked(self, index: int) -> bool:
        """Whether a trial is one that the law was not fitted to."""
        return self.measured[index].slip < _BRAKED


def read_trials(path: Path) -> list[Trial]:
    """Straight trials, those of one commanded rim speed averaged, from skid to slip.

    Slip is that of the measured rim speed: the commanded one is off by 8 % at one setting.

    Raises
    ------
    RigError
        The file does not hold what the rig recorded.
    """
    if not path.is_file():
        raise RigError(f"{path}: no such file")
    try:
        straight = [one for one in np.ravel(read_mat(path)["all_results"]) if one["beta"].item() == 0]
    except (KeyError, ValueError, IndexError, TypeError, AttributeError):
        raise RigError(f"{path}: a MATLAB file with the struct array 'all_results' is needed") from None
    if not straight:
        raise RigError(f"{path}: no trial with beta = 0")
    groups: dict[float, list[Any]] = defaultdict(list)
    for one in straight:
        groups[one["Vry"].item()].append(one)
    return [_trial(groups[speed]) for speed in sorted(groups)]


def compare_with_rig(trials: list[Trial]) -> RigComparison:
    """Fit scale, surface friction and shear stiffness to the driven trials, predict all.

    `unfitted` is the law with the scale published for the sand's density and friction, where the fit begins.
    """
    scale = published_scale(density=DENSITY, friction_angle=REPOSE)
    grains = loose_grc1(shear_share=FIRST_SHEAR_SHARE)
    ratio = grains.stiffness / grains.scale
    start = replace(grains, scale=scale, stiffness=ratio * scale, damping_time=0.0)
    found = identify([one for one in trials if one.slip >= _BRAKED], start)
    return RigComparison(
        trials,
        found,
        predict(ResistiveForceLaw(found.soil), trials),
        predict(ResistiveForceLaw(start), trials),
        [
            steady_forces(found.soil, slip=one.slip, sinkage=one.sinkage, radius=one.radius, width=one.width)
            for one in trials
        ],
    )


def _trial(repeats: list[Any]) -> Trial:
    rim, travel, pull, load, height = (
        float(np.mean([one[name].item() for one in repeats]))
        for name in ("avg_Vry", "avg_Vx", "avg_Fy", "avg_Fz", "avg_Z")
    )
    slip = 1 - travel / rim if rim > travel else rim / travel - 1
    return Trial(slip, -load, RADIUS, WIDTH, sinkage=-height / 1000, drawbar_pull=-pull)
