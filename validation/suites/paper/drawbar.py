"""Drawbar pull of the rover, rolling and push-rolling (section 4.1.1, Fig. 17); where a rover is there."""

from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from synth.text_files import read_json_object
from validation.statistics import Interval
from validation.suites.paper.experiment import Experiment
from validation.suites.paper.found import Found
from validation.suites.paper.verdict import JUDGED, Told, Variant

COMMAND = "validation.cli.drawbar"
"""The module of the command that drives the rover."""
FILE = "drawbar/drawbar.json"
"""What `softbed drawbar OUT/drawbar` leaves in the suite's folder OUT."""
LAW = "rft"
"""The command's own choice of how soil resists wheels."""
GAITS, WHEELS = ("rolling", "inching"), ("rigid", "pneumatic")


def experiments() -> tuple[Experiment, ...]:
    """The experiment, if this version has a rover that can pull; none before."""
    return (EXPERIMENT,) if find_spec(COMMAND) is not None else ()


def _tell(found: Found, variant: Variant) -> list[Told]:
    path = found.out / FILE
    if variant != JUDGED or not path.is_file():  # no pictures, no method: told once
        return []
    return told_by(read_maxima(path))


def read_maxima(path: Path) -> dict[str, float]:
    """Largest drawbar pull / weight of every gait on every wheel, where travel reduction reached 90 %.

    Raises
    ------
    ValueError
        Not what `softbed drawbar` writes.
    """
    try:
        return {
            f"{curve['gait']}_{curve['wheel']}": float(curve["maximum"])
            for curve in read_json_object(path)["curves"]
            if curve["law"] == LAW and curve.get("maximum_reached", True)
        }
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{path}: not what softbed drawbar writes: {error}") from None


def told_by(maxima: Mapping[str, float]) -> list[Told]:
    """Maxima, and what push-rolling gains."""
    told = [Told(name, _point(value)) for name, value in maxima.items()]
    for wheel in WHEELS:
        rolling, inching = (maxima.get(f"{gait}_{wheel}") for gait in GAITS)
        if rolling and inching:
            told.append(Told(f"gain_{wheel}", _point(inching / rolling)))
    return told


def _point(value: float) -> Interval:
    return Interval(value, np.nan, np.nan, 1, 0)


EXPERIMENT = Experiment(
    name="drawbar",
    title="Drawbar pull of a rover",
    figures="Fig. 17, section 4.1.1",
    about=(
        "The rover pulls a load as it rolls, and as it push-rolls. From the file drawbar/drawbar.json of "
        "this folder, which `softbed drawbar OUT/drawbar` leaves."
    ),
    table="paper_drawbar",
    quantities=(
        *(f"{gait}_{wheel}" for wheel in WHEELS for gait in GAITS),
        *(f"gain_{wheel}" for wheel in WHEELS),
    ),
    tell=_tell,
    draw=lambda _: [],
)
