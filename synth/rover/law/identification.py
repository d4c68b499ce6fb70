"""Find a soil's constants from what a single wheel met at steady slip."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from synth.rover.law.interface import PlacedWheel
from synth.rover.law.response import SoilError
from synth.rover.law.rft import ResistiveForceLaw, ResistiveSoil
from synth.rover.law.rim_law import RimLaw
from synth.rover.law.single_wheel import Paths, lead

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

TOLERANCE: Mapping[str, float] = {"sinkage": 0.1, "drawbar_pull": 0.05, "torque": 0.05}
"""What counts as one in a misfit: of the mean sinkage; of the load; of load x radius."""
BOUNDS: Mapping[str, tuple[float, float]] = {
    "scale": (1e4, 1e9),
    "surface_friction": (0.05, 1.0),
    "stiffness": (1e4, 1e10),
    "shear_share": (1e-3, 10.0),
    "hardening": (0.1, 10.0),
}
"""Where constants are looked for."""
FIRST_SHEAR_SHARE = 0.06
"""Where a fit begins; far from what it finds on the real wheel."""
_STEPS = 600
_EVALUATIONS = 30
_DIFFERENCE = 0.03
"""Of a constant's logarithm, to take a derivative over: elements make the law a little rough."""


@dataclass(frozen=True)
class Trial:
    """A wheel rolling steadily.

    Attributes
    ----------
    slip : float
        Skid where negative, -1 locked.
    load, radius, width : float
        N, m, m.
    sinkage, drawbar_pull, torque : float
        m, N, N m; the torque is what drives the wheel. NaN: not measured.
    travel : float
        Of the axle from touch-down to the end, / radius.
    averaged : float
        Share of the travel, its end, that the means are of.
    """

    slip: float
    load: float
    radius: float
    width: float
    sinkage: float = float("nan")
    drawbar_pull: float = float("nan")
    torque: float = float("nan")
    travel: float = 1.2
    averaged: float = 0.25


@dataclass(frozen=True)
class Estimate:
    """A constant found, and the ends of its 95 % confidence interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Identification:
    """What was found.

    Attributes
    ----------
    soil : ResistiveSoil
    estimates : dict of Estimate
        Of the constants that were fitted.
    predictions : list of Trial
        What the law gives for the trials fitted to.
    misfit : float
        Root mean square of what is left over, in units of `TOLERANCE`.
    """

    soil: ResistiveSoil
    estimates: dict[str, Estimate]
    predictions: list[Trial]
    misfit: float


def predict(law: RimLaw, trials: Sequence[Trial]) -> list[Trial]:
    """What a law gives for trials, all at once."""
    wheels = [PlacedWheel(f"{k}", f"{k}", one.radius, one.width) for k, one in enumerate(trials)]
    slip, load, radius, travel, averaged = (
        np.array([getattr(one, name) for one in trials])
        for name in ("slip", "load", "radius", "travel", "averaged")
    )
    paths = Paths.at_slip(slip, load, radius, travel=travel * radius, step_count=_STEPS)
    steady = lead(law, wheels, paths).mean(averaged)
    return [
        replace(one, sinkage=float(sinkage), drawbar_pull=float(pull), torque=float(-torque))
        for one, sinkage, pull, torque in zip(
            trials, steady.sinkage, steady.force_x, steady.torque, strict=True
        )
    ]


def identify(
    trials: Sequence[Trial],
    start: ResistiveSoil,
    *,
    fitted: Sequence[str] = ("scale", "surface_friction", "shear_share"),
    progress: Callable[[int], None] | None = None,
) -> Identification:
    """Fit constants of a soil to trials by least squares on their logarithms.

    The confidence intervals take what is left over as the trials' errors, independent of one another.

    Parameters
    ----------
    fitted : sequence of str
        Names of constants of `ResistiveSoil`. A stiffness that is not fitted keeps its ratio to the scale.
    progress : callable, optional
        Called with how often the law was evaluated.

    Raises
    ------
    SoilError
        There are not more measurements than constants, or a name is none of theirs.
    """
    strangers = set(fitted) - set(BOUNDS)
    if strangers:
        raise SoilError(f"fitted = {', '.join(sorted(strangers))}: allowed are {', '.join(BOUNDS)}")
    from scipy.optimize import least_squares

    measured = misfits(trials, trials).size
    if measured <= len(fitted):
        raise SoilError(f"trials: {measured} measurements, more than {len(fitted)} are needed to fit as many")
    evaluations = 0

    def residual(logarithms: NDArray) -> NDArray:
        nonlocal evaluations
        evaluations += 1
        if progress is not None:
            progress(evaluations)
        return misfits(trials, predict(ResistiveForceLaw(_soil_of(start, fitted, logarithms)), trials))

    first = np.log([getattr(start, name) for name in fitted])
    low, high = np.log([BOUNDS[name] for name in fitted]).T
    found = least_squares(
        residual,
        first,
        bounds=(low, high),
        diff_step=_DIFFERENCE,
        xtol=1e-3,
        ftol=1e-4,
        max_nfev=_EVALUATIONS,
    )
    soil = _soil_of(start, fitted, found.x)
    return Identification(
        soil,
        _estimates(fitted, found),
        predict(ResistiveForceLaw(soil), trials),
        float(np.sqrt(np.mean(found.fun**2))),
    )


def misfits(measured: Sequence[Trial], given: Sequence[Trial]) -> NDArray:
    """What is given less what was measured, in units of `TOLERANCE`; what was not measured is left out."""
    depth = np.nanmean([one.sinkage for one in measured])
    apart = [
        (
            (other.sinkage - one.sinkage) / (TOLERANCE["sinkage"] * depth),
            (other.drawbar_pull - one.drawbar_pull) / (TOLERANCE["drawbar_pull"] * one.load),
            (other.torque - one.torque) / (TOLERANCE["torque"] * one.load * one.radius),
        )
        for one, other in zip(measured, given, strict=True)
    ]
    flat: NDArray = np.array(apart, float).ravel()
    return flat[[not np.isnan(value) for one in measured for value in _told(one)]]


def _told(trial: Trial) -> tuple[float, float, float]:
    return trial.sinkage, trial.drawbar_pull, trial.torque


def _soil_of(start: ResistiveSoil, names: Sequence[str], logarithms: NDArray) -> ResistiveSoil:
    values = dict(zip(names, np.exp(logarithms).tolist(), strict=True))
    if "stiffness" not in values:
        values["stiffness"] = start.stiffness * values.get("scale", start.scale) / start.scale
    return replace(start, **values, damping_time=0.0)


def _estimates(names: Sequence[str], found: "OptimizeResult") -> dict[str, Estimate]:
    """Intervals after the linearized misfit and Student's distribution, cut off at `BOUNDS`."""
    from scipy.stats import t

    freedom = found.fun.size - found.x.size
    variance = found.fun @ found.fun / freedom
    covariance = variance * np.linalg.pinv(found.jac.T @ found.jac)
    reach = t.ppf(0.975, freedom) * np.sqrt(np.diag(covariance))
    return {
        name: Estimate(
            *np.exp(np.clip([centre, centre - half, centre + half], *np.log(BOUNDS[name]))).tolist()
        )
        for name, centre, half in zip(names, found.x, reach, strict=True)
    }
