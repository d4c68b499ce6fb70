"""The page a person reads about a suite: one file that needs nothing else."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.modulation import resolved_period, response
from validation.page import Panel, write_page
from validation.strata import MEANINGS
from validation.suites.execution import Failure, is_measured
from validation.suites.figures import draw_cost, draw_heat_map, draw_profiles, draw_response, draw_worst
from validation.suites.headline import Comparison, Headline, group_title, headlines
from validation.suites.leaderboard import STRATA, Standing, standings
from validation.suites.plan import Look, Suite
from validation.suites.table import Line, open_measurement
from validation.versions import machine, package_version, package_versions

if TYPE_CHECKING:
    import xarray as xr

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
class ScenePage:
    """What the page shows of one scene.

    Attributes
    ----------
    name : str
    rows : list of (stratum, method, cells)
    remarks : list of str
        Which differences between methods can be told.
    worst : list of Panel
        Where each method fails most.
    """

    name: str
    rows: list[tuple[str, str, list[str]]]
    remarks: list[str]
    worst: list[Panel]


def write_suite_report(
    path: Path,
    suite: Suite,
    out: Path,
    lines: Sequence[Line],
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
    out : Path
        The suite's folder.
    lines : sequence of dict
        Its table.
    command : str
        What a person types to get all of it again.
    """
    told = headlines(lines)
    board = standings(lines, comparisons)
    methods = [standing.method for standing in board]
    looks = [look for look in suite.looks if is_measured(out, look)]
    write_page(
        path,
        "suite.html.j2",
        {
            "title": f"suite {suite.name}",
            "description": suite.about,
            "facts": _facts(suite, looks),
            "board": [(one.method, _board_cells(one)) for one in board],
            "strata": MEANINGS,
            "overview": _overview(told, board, methods),
            "profiles": _profile_panels(out, looks, methods),
            "resolution": _resolution_panels(out, looks, methods),
            "scenes": _scene_pages(out, looks, told, comparisons),
            "failures": failures,
            "commands": [command],
            "versions": package_versions(),
            "machine": machine(),
            "program": package_version("softbed"),
        },
    )


def _facts(suite: Suite, looks: Sequence[Look]) -> dict[str, str]:
    motions = {look.realisation.motion for look in looks}
    return {
        "motions": str(len(motions)),
        "sets of pictures": str(len({look.realisation for look in looks})),
        "measured": f"{len(looks)} of {len(suite.looks)}",
    }


def _board_cells(standing: Standing) -> list[str]:
    shares = [standing.wrong[stratum].told(".1%") if stratum in standing.wrong else "-" for stratum in STRATA]
    told = f"{standing.better} / {standing.worse}"
    return [
        standing.median.told(".3f"),
        *shares,
        told,
        f"{standing.seconds:.2f}",
        str(standing.scene_count),
    ]


def _overview(
    headlines: Sequence[Headline], board: Sequence[Standing], methods: Sequence[str]
) -> list[Panel]:
    scenes = list(dict.fromkeys(_scene(one) for one in headlines))
    shares = {stratum: np.full((len(scenes), len(methods)), np.nan) for stratum in STRATA}
    for one in headlines:
        if one.stratum in shares:
            place = scenes.index(_scene(one)), methods.index(one.method)
            shares[one.stratum][place] = one.errors["wrong_0.3"].value
    hard = {
        one.method: (one.seconds, 100 * share.value, 100 * share.low, 100 * share.high)
        for one in board
        if (share := one.wrong.get("complex", one.wrong["all"]))
    }
    return [
        Panel.of(
            "Wrong pixels",
            "Share of pixels wrong by more than 0.3 px, or not measured: mean over realisations.",
            draw_heat_map(shares, scenes, methods),
        ),
        Panel.of(
            "Error against time",
            "Mean over scenes; bars are 95 % intervals over realisations.",
            draw_cost(hard, label="wrong by more than 0.3 px in complex flow [%]"),
        ),
    ]


def _scene(one: Headline | Comparison) -> str:
    return group_title(one.scene, one.label, one.severity, one.stride)


def _profile_panels(out: Path, looks: Sequence[Look], methods: Sequence[str]) -> list[Panel]:
    profiles = _summed(out, looks, methods, ("count_", "unmeasured_", "sums_"))
    if not profiles:
        return []
    return [Panel.of(title, caption, draw_profiles(profiles, name)) for name, title, caption in _PROFILES]


def _resolution_panels(out: Path, looks: Sequence[Look], methods: Sequence[str]) -> list[Panel]:
    sums = _summed(out, looks, methods, ("response_",))
    if not sums:
        return []
    told = "; ".join(f"{method} {_resolved(one)}" for method, one in sums.items())
    caption = f"Rows that move up and down. Half and nine tenths of the amplitude are told from: {told}."
    return [Panel.of("Spatial resolution", caption, draw_response(sums))]


def _resolved(sums: "xr.Dataset") -> str:
    half, most = (resolved_period(response(sums), share) for share in (0.5, 0.9))
    return f"{half:.0f} and {most:.0f} px"


def _summed(
    out: Path, looks: Sequence[Look], methods: Sequence[str], prefixes: tuple[str, ...]
) -> "dict[str, xr.Dataset]":
    """Variables of these prefixes, added up over everything that a method has looked at."""
    found: dict[str, xr.Dataset] = {}
    for look in looks:
        with open_measurement(out, look) as measured:
            wanted = [str(name) for name in measured.data_vars if str(name).startswith(prefixes)]
            if wanted:
                one = measured[wanted].load()
                found[look.method] = found[look.method] + one if look.method in found else one
    return {method: found[method] for method in methods if method in found}


def _scene_pages(
    out: Path, looks: Sequence[Look], told: Sequence[Headline], comparisons: Sequence[Comparison]
) -> list[ScenePage]:
    worst = _worst(out, looks)
    return [
        ScenePage(
            name,
            [
                (one.stratum, one.method, _cells(one))
                for stratum in MEANINGS
                for one in told
                if _scene(one) == name and one.stratum == stratum
            ],
            _remarks([one for one in comparisons if _scene(one) == name and one.stratum == "complex"]),
            worst.get(name.split(",")[0], []),
        )
        for name in dict.fromkeys(_scene(one) for one in told)
    ]


def _cells(headline: Headline) -> list[str]:
    forms = {"median": ".3f", "p95": ".3f", "wrong_0.3": ".1%", "wrong_1.0": ".1%"}
    found = [f"{headline.pixel_share:.1%}"]
    found += [headline.errors[q].told(form) if q in headline.errors else "-" for q, form in forms.items()]
    return [*found, str(headline.errors["wrong_0.3"].realisation_count)]


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


def _worst(out: Path, looks: Sequence[Look]) -> dict[str, list[Panel]]:
    """For each scene, where each method fails most, over all of its pictures."""
    found: dict[tuple[str, str], xr.Dataset] = {}
    for look in looks:
        with open_measurement(out, look) as measured:
            key = look.realisation.motion.scene, look.method
            if "worst_error" not in measured:
                continue
            place = measured[["worst_picture", "worst_speed", "worst_error"]].load()
        if key not in found or place.attrs["worst_mean"] > found[key].attrs["worst_mean"]:
            found[key] = place
    panels: dict[str, list[Panel]] = {}
    for (scene, method), place in found.items():
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
