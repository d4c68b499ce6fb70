"""The page a person reads about a suite: one file that needs nothing else."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.page import Panel, write_page
from validation.scoring.modulation import resolved_period, response
from validation.scoring.strata import MEANINGS
from validation.statistics import Interval
from validation.suites.execution import Failure
from validation.suites.figures import draw_cost, draw_heat_map, draw_profiles, draw_response, draw_worst
from validation.suites.gathered import Gathered
from validation.suites.headline import Comparison, Headline, headlines
from validation.suites.leaderboard import STRATA, Standing, is_usual, standings, usual
from validation.suites.plan import Look, Suite
from validation.versions import machine, package_version, package_versions

if TYPE_CHECKING:
    import xarray as xr

_PROFILE = ("count_", "unmeasured_", "sums_")
_PROFILES = (
    ("median", "Median error", "Half of the pixels of a bin are nearer to the truth."),
    ("wrong", "Share of wrong pixels", "Not measured counts as wrong."),
    (
        "bias",
        "Bias",
        "Mean error along the true motion, of soil that moves by 0.1 px at least: below zero, a method tells "
        "less motion than there is.",
    ),
    ("random", "Random error", "Standard deviation of the error along the true motion."),
)


@dataclass(frozen=True)
class Board:
    """Everything told of one severity, all scenes together.

    Attributes
    ----------
    severity : str
    rows : list of (method, cells)
    overview, profiles, resolution : list of Panel
    """

    severity: str
    rows: list[tuple[str, list[str]]]
    overview: list[Panel]
    profiles: list[Panel]
    resolution: list[Panel]


@dataclass(frozen=True)
class Seen:
    """A scene at one severity, or seen otherwise.

    Attributes
    ----------
    name : str
    rows : list of (method, cells)
    remarks : list of str
        Which differences between methods can be told.
    """

    name: str
    rows: list[tuple[str, list[str]]]
    remarks: list[str]


@dataclass(frozen=True)
class ScenePage:
    """What the page shows of one scene.

    Attributes
    ----------
    name : str
    seen : list of Seen
    worst : list of Panel
        Where each method fails most.
    """

    name: str
    seen: list[Seen]
    worst: list[Panel]


def write_suite_report(
    path: Path,
    suite: Suite,
    gathered: Gathered,
    comparisons: Sequence[Comparison],
    failures: Sequence[Failure],
    *,
    command: str,
) -> None:
    """Write the report of a suite from the measurements that are there.

    Parameters
    ----------
    path : Path
        The page to write.
    gathered : Gathered
        What was measured.
    command : str
        What a person types to get all of it again.
    """
    told = headlines(gathered.lines)
    severities = dict.fromkeys(line["severity"] for line in gathered.lines if is_usual(line))
    write_page(
        path,
        "suite.html.j2",
        {
            "title": f"suite {suite.name}",
            "description": suite.about,
            "facts": _facts(suite, gathered.looks),
            "boards": [_board(severity, gathered, told, comparisons) for severity in severities],
            "strata": MEANINGS,
            "scenes": _scene_pages(gathered, told, comparisons),
            **how_made(failures, command),
        },
    )


def how_made(failures: Sequence[Failure], command: str) -> dict[str, Any]:
    """What any suite's page says of its making; `command` is what a person types to get all of it again."""
    return {
        "failures": failures,
        "commands": [command],
        "versions": package_versions(),
        "machine": machine(),
        "program": package_version("softbed"),
    }


def _facts(suite: Suite, looks: Sequence[Look]) -> dict[str, str]:
    motions = {look.realisation.motion for look in looks}
    return {
        "motions": str(len(motions)),
        "sets of pictures": str(len({look.realisation for look in looks})),
        "measured": f"{len(looks)} of {len(suite.looks)}",
    }


def _board(
    severity: str, gathered: Gathered, told: Sequence[Headline], comparisons: Sequence[Comparison]
) -> Board:
    standing = standings(usual(gathered.lines, severity), comparisons)
    methods = [one.method for one in standing]
    own = [one for one in told if one.severity == severity and not one.label and one.stride == 1]
    return Board(
        severity,
        [(one.method, _board_cells(one)) for one in standing],
        _overview(own, standing, methods),
        _profile_panels(_ordered(gathered.summed(severity, _PROFILE), methods)),
        _resolution_panels(_ordered(gathered.summed(severity, "response_"), methods)),
    )


def _ordered(found: "Mapping[str, xr.Dataset]", methods: Sequence[str]) -> "dict[str, xr.Dataset]":
    return {method: found[method] for method in methods if method in found}


def _board_cells(standing: Standing) -> list[str]:
    def told(intervals: Mapping[str, Interval], stratum: str, form: str) -> str:
        return intervals[stratum].told(form) if stratum in intervals else "-"

    return [
        *(told(standing.wrong, stratum, ".1%") for stratum in reversed(STRATA)),
        *(told(standing.median, stratum, ".3f") for stratum in ("complex", "all")),
        f"{standing.better} / {standing.worse}",
        f"{standing.seconds:.2f}",
        str(standing.scene_count),
    ]


def _overview(
    headlines: Sequence[Headline], board: Sequence[Standing], methods: Sequence[str]
) -> list[Panel]:
    scenes = list(dict.fromkeys(one.scene for one in headlines))
    shares = {stratum: np.full((len(scenes), len(methods)), np.nan) for stratum in STRATA}
    for one in headlines:
        if one.stratum in shares:
            place = scenes.index(one.scene), methods.index(one.method)
            shares[one.stratum][place] = one.errors["wrong_0.3"].value
    hard = {
        one.method: (one.seconds, 100 * share.value, 100 * share.low, 100 * share.high)
        for one in board
        if (share := one.decisive)
    }
    return [
        Panel.of(
            "Wrong pixels",
            "Share of pixels wrong by more than 0.3 px, or not measured: mean over realisations. White: no "
            "such soil in the scene, or not looked at.",
            draw_heat_map(shares, scenes, methods),
        ),
        Panel.of(
            "Error against time",
            "Mean over scenes; bars are 95 % intervals over simulations.",
            draw_cost(hard, label="wrong by more than 0.3 px in complex flow [%]"),
        ),
    ]


def _profile_panels(profiles: "Mapping[str, xr.Dataset]") -> list[Panel]:
    if not profiles:
        return []
    return [Panel.of(title, caption, draw_profiles(profiles, name)) for name, title, caption in _PROFILES]


def _resolution_panels(sums: "Mapping[str, xr.Dataset]") -> list[Panel]:
    if not sums:
        return []
    told = "; ".join(f"{method} {_resolved(one)}" for method, one in sums.items())
    caption = f"Rows that move up and down. Half and nine tenths of the amplitude are told from: {told}."
    return [Panel.of("Spatial resolution", caption, draw_response(sums))]


def _resolved(sums: "xr.Dataset") -> str:
    half, most = (resolved_period(response(sums), share) for share in (0.5, 0.9))
    return " and ".join("none shown" if np.isnan(one) else f"{one:.0f} px" for one in (half, most))


def _scene_pages(
    gathered: Gathered, told: Sequence[Headline], comparisons: Sequence[Comparison]
) -> list[ScenePage]:
    worst = _worst(gathered)
    pages = []
    for scene in dict.fromkeys(one.scene for one in told):
        own = [one for one in told if one.scene == scene]
        names = dict.fromkeys(_name(one) for one in own)
        compared = [one for one in comparisons if one.scene == scene and one.stratum == "complex"]
        seen = [
            Seen(
                name,
                _rows([one for one in own if _name(one) == name]),
                _remarks([one for one in compared if _name(one) == name]),
            )
            for name in names
        ]
        pages.append(ScenePage(scene, seen, worst.get(scene, [])))
    return pages


def _name(one: Headline | Comparison) -> str:
    """How a scene was seen."""
    told = (one.severity, one.label, f"stride {one.stride}" if one.stride != 1 else "")
    return ", ".join(part for part in told if part)


def _rows(headlines: Sequence[Headline]) -> list[tuple[str, list[str]]]:
    """A line for each method, the best in complex flow (else of all soil) first."""
    by_method: dict[str, dict[str, Headline]] = {}
    for one in headlines:
        by_method.setdefault(one.method, {})[one.stratum] = one
    hard = "complex" if any("complex" in strata for strata in by_method.values()) else "all"
    order = sorted(by_method.items(), key=lambda item: _wrong_share(item[1].get(hard)))
    return [(method, _cells(strata)) for method, strata in order]


def _wrong_share(headline: Headline | None) -> float:
    return np.inf if headline is None else headline.errors["wrong_0.3"].value


def _cells(strata: Mapping[str, Headline]) -> list[str]:
    found = [_cell(strata, stratum, "wrong_0.3", ".1%") for stratum in ("complex", "moving", "quiet", "all")]
    found += [_cell(strata, "complex", quantity, ".3f") for quantity in ("median", "p95")]
    found.append(_cell(strata, "all", "median", ".3f"))
    return [*found, str(strata["all"].errors["wrong_0.3"].realisation_count)]


def _cell(strata: Mapping[str, Headline], stratum: str, quantity: str, form: str) -> str:
    errors = strata[stratum].errors if stratum in strata else {}
    return errors[quantity].told(form) if quantity in errors else "-"


def _remarks(comparisons: Sequence[Comparison]) -> list[str]:
    """Differences in complex flow, in words; those that cannot be told as such."""
    told = [
        f"{one.better} is better than {one.second if one.better == one.first else one.first} by "
        f"{100 * abs(one.difference.value):.1f} points (p = {one.p:.2g})"
        for one in comparisons
        if one.better
    ]
    alike = [f"{one.first} and {one.second}" for one in comparisons if not one.better]
    return told + ([f"no difference that could be told: {'; '.join(alike)}"] if alike else [])


def _worst(gathered: Gathered) -> dict[str, list[Panel]]:
    """For each scene, where each method fails most, over all of its pictures."""
    panels: dict[str, list[Panel]] = {}
    for (scene, method), place in gathered.worst.items():
        panels.setdefault(scene, []).append(_worst_panel(method, place.attrs, place))
    return panels


def _worst_panel(method: str, told: Mapping[str, Any], place: "xr.Dataset") -> Panel:
    x, y = (int(k) for k in told["worst_at"])
    caption = (
        f"At x = {x}, y = {y} px, wrong by {told['worst_mean']:.1f} px on average: {told['worst_because']}."
    )
    speed = place["worst_speed"].values
    top = max(float(np.nanmax(speed)), 1.0) if np.isfinite(speed).any() else 1.0
    return Panel.of(method, caption, draw_worst(place, top=top))
