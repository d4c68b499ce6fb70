"""A curve that is not finished: its points, and where vehicle and soil are, so that it can go on."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from synth.disk import written_whole
from synth.npz_files import UNREADABLE
from validation.drawbar.curve import Curve, CurveOrder

_TOLD = "told"


@dataclass(frozen=True)
class Begun:
    """Of a curve, what was measured until it was left.

    Attributes
    ----------
    curve : Curve
    state : dict of ndarray
        See `synth.rover.drawbar.DrawbarTest.state`.
    """

    curve: Curve
    state: dict[str, NDArray]


def keep_begun(path: Path, begun: Begun, made_by: dict[str, str]) -> None:
    """Write it, a former one replaced at once."""
    told = json.dumps(begun.curve.to_dict() | {"made_by": made_by})
    with written_whole(path) as draft:
        np.savez(draft, **{_TOLD: np.array(told)}, **begun.state)  # type: ignore[arg-type]


def find_begun(path: Path, order: CurveOrder, made_by: dict[str, str]) -> tuple[Begun | None, str]:
    """What was begun of the same by the same, or None and why not: empty where there is nothing."""
    if not path.is_file():
        return None, ""
    try:
        with np.load(path) as file:
            arrays = dict(file)
        told = json.loads(str(arrays.pop(_TOLD)))
        same_makers = told.pop("made_by") == made_by
        curve = Curve.from_dict(told)
    except (*UNREADABLE, TypeError) as error:
        return None, f"{path.name}: cannot be read ({error}), begun anew"
    if not same_makers or curve.order != order:
        return None, f"{path.name}: of another version, soil or order, begun anew"
    return Begun(curve, arrays), ""
