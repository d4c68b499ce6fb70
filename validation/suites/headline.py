"""What a suite says: each method's errors in each scene and stratum with intervals, and who is better."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any

import numpy as np

from validation.statistics import (
    LEVEL,
    Interval,
    StatisticsError,
    block_bootstrap,
    holm,
    paired_difference,
)
from validation.suites.table import Line

BLOCK = 4
"""Picture pairs a block: soil under a wheel has moved on by a grain or more until then."""
QUANTITIES = ("median", "p95", "wrong_0.3", "wrong_1.0")
COMPARED = "wrong_0.3"
"""The quantity by which methods are compared."""
GROUP = ("scene", "label", "severity", "stride")
"""What lines of one headline have in common, besides method and stratum."""


@dataclass(frozen=True)
class Headline:
    """Errors of one method in one stratum of one scene.

    Attributes
    ----------
    scene, label, severity : str
    stride : int
    stratum, method : str
    pixel_share : float
        Pixels of the stratum / those of all soil.
    errors : dict
        An `Interval` for each of QUANTITIES that there is.
    seconds : float
        Of the analysis a picture pair.
    """

    scene: str
    label: str
    severity: str
    stride: int
    stratum: str
    method: str
    pixel_share: float
    errors: dict[str, Interval]
    seconds: float


@dataclass(frozen=True)
class Comparison:
    """How two methods differ in one stratum of one scene, by the share of wrong pixels.

    Attributes
    ----------
    scene, label, severity : str
    stride : int
    stratum : str
    first, second : str
        The methods.
    difference : Interval
        Of first less second, on the picture pairs that both saw.
    p : float
        Probability of so large a difference if there were none, corrected for all pairs of methods in this
        stratum of this scene (Holm).
    better : str or None
        The method with the smaller error; None: no difference that could be told.
    """

    scene: str
    label: str
    severity: str
    stride: int
    stratum: str
    first: str
    second: str
    difference: Interval
    p: float
    better: str | None


def headlines(lines: Sequence[Line]) -> list[Headline]:
    """One for each scene, stratum and method, in the order of the lines."""
    pixels = _pixels(lines)
    found = []
    for key, own in grouped(lines, (*GROUP, "stratum", "method")).items():
        errors = {}
        for quantity in QUANTITIES:
            try:
                errors[quantity] = block_bootstrap(_realisations(own, quantity), block_length=BLOCK)
            except StatisticsError:  # a stratum without pixels
                continue
        if errors:
            share = pixels[key[:-1]] / pixels[(*key[: len(GROUP)], "all")]
            seconds = float(np.mean([line["seconds"] for line in own]))
            found.append(Headline(**_named(key), pixel_share=share, errors=errors, seconds=seconds))
    return found


def comparisons(lines: Sequence[Line]) -> list[Comparison]:
    """Every pair of methods in every scene and stratum, each on the picture pairs that both of them saw."""
    found = []
    for key, own in grouped(lines, (*GROUP, "stratum")).items():
        methods = {method: part for (method,), part in grouped(own, ("method",)).items()}
        told = []
        for first, second in combinations(methods, 2):
            try:
                told.append((first, second, *_difference(methods[first], methods[second])))
            except StatisticsError:  # a stratum without pixels, or no picture that both saw
                continue
        corrected = holm([p for *_, p in told])
        found += [
            Comparison(**_named(key), first=a, second=b, difference=d, p=p, better=_better(a, b, d, p))
            for (a, b, d, _), p in zip(told, corrected, strict=True)
        ]
    return found


def _difference(first: Sequence[Line], second: Sequence[Line]) -> tuple[Interval, float]:
    common = {_picture(line) for line in first} & {_picture(line) for line in second}
    errors = (
        _realisations([line for line in lines if _picture(line) in common], COMPARED)
        for lines in (first, second)
    )
    return paired_difference(*errors, block_length=BLOCK)


def _better(first: str, second: str, difference: Interval, p: float) -> str | None:
    if p >= 1 - LEVEL:
        return None
    return first if difference.value < 0 else second


def headline_document(headlines: Iterable[Headline], comparisons: Iterable[Comparison]) -> dict[str, Any]:
    """As it stands in NAME.json: what is not a number is null."""
    return {
        "headlines": [_without_nan(asdict(one)) for one in headlines],
        "comparisons": [_without_nan(asdict(one)) for one in comparisons],
    }


def group_title(scene: str, label: str, severity: str, stride: int) -> str:
    """What a group of lines is called: the scene, and what is not as usual."""
    told = (scene, label, "" if severity == "clean" else severity, f"stride {stride}" if stride != 1 else "")
    return ", ".join(part for part in told if part)


def grouped(lines: Iterable[Line], names: Sequence[str]) -> dict[tuple[Any, ...], list[Line]]:
    """Lines by their values of `names`, in order."""
    found: dict[tuple[Any, ...], list[Line]] = {}
    for line in lines:
        found.setdefault(tuple(line[name] for name in names), []).append(line)
    return found


def _named(key: tuple[Any, ...]) -> dict[str, Any]:
    """The values of a group of lines by name; a shorter key is of the first names."""
    return dict(zip((*GROUP, "stratum", "method"), key, strict=False))


def _picture(line: Line) -> tuple[Any, ...]:
    return line["seed"], line["picture_seed"], line["pair"]


def _realisations(lines: Iterable[Line], quantity: str) -> list[np.ndarray]:
    by_pictures = grouped(lines, ("seed", "picture_seed")).values()
    return [np.array([line[quantity] for line in own], np.float64) for own in by_pictures]


def _pixels(lines: Iterable[Line]) -> dict[tuple[Any, ...], float]:
    """Mean number of pixels of each stratum of each scene."""
    return {
        key: float(np.mean([line["pixel_count"] for line in own]))
        for key, own in grouped(lines, (*GROUP, "stratum")).items()
    }


def _without_nan(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_nan(one) for key, one in value.items()}
    return None if isinstance(value, float) and np.isnan(value) else value
