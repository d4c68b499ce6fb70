"""What the suite `complex` found, from its kept tables: Markdown tables of the README and the docs.

Docs hold a table between `<!-- findings: NAME -->` and `<!-- end -->` (`validation.markdown_tables`).
"""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path

from validation.markdown_tables import markdown_table, update_tables, with_tables
from validation.scoring.error_profile import CAUSES
from validation.scoring.modulation import resolved_period, response
from validation.statistics import Interval, StatisticsError
from validation.suites.complex_flow import BIN_SCENES, SOFT
from validation.suites.explained import Explained
from validation.suites.headline import GROUP, comparisons
from validation.suites.kept import Kept
from validation.suites.leaderboard import (
    STRATA,
    WRONG,
    difference_over_scenes,
    over_scenes,
    standings,
    usual,
)
from validation.suites.paper.verdict_table import KEPT as KEPT_VERDICTS
from validation.suites.paper.verdict_table import verdict_table
from validation.suites.severities import CLEAN, PAPER
from validation.suites.table import Line

INSTEAD = "robust-affine"
"""What to use instead of the published technique."""
_SIGNIFICANT = 0.05
_DISTINCT = 4
"""Of CAUSES, those told in a sentence."""


class FindingsError(ValueError):
    """Tables that nothing can be told of; the message is one line."""


def leaderboard(kept: Kept) -> str:
    """Methods at the severity `paper`, all scenes that were seen at it."""
    lines = usual(kept.lines, PAPER)
    compared = comparisons([line for line in lines if line["stratum"] == "complex"])
    head = ["", "method", *(f"wrong, {stratum}" for stratum in reversed(STRATA)), "median, complex [px]"]
    head += ["better / worse", "s a pair"]
    rows = [
        [
            str(place),
            f"`{one.method}`",
            *(_share(one.wrong.get(stratum)) for stratum in reversed(STRATA)),
            _px(one.median.get("complex")),
            f"{one.better} / {one.worse}",
            f"{one.seconds:.2f}",
        ]
        for place, one in enumerate(standings(lines, compared), start=1)
    ]
    return markdown_table(head, rows)


def answer(kept: Kept) -> str:
    """The answer in sentences, and what it rests on."""
    hard, quiet, clean = (
        [line for line in _wheels(kept, severity) if line["stratum"] == stratum]
        for severity, stratum in ((PAPER, "complex"), (PAPER, "quiet"), (CLEAN, "complex"))
    )
    soft, calm = (Explained.of(kept.profiles, SOFT, severity, BIN_SCENES) for severity in (PAPER, CLEAN))
    causes = [
        f"{cause} {_share(soft.share_wrong('cause', k))} (clean {_share(calm.share_wrong('cause', k))})"
        for k, cause in enumerate(CAUSES[:_DISTINCT])
    ]
    seen = list(dict.fromkeys(line["scene"] for line in hard))
    missing = [scene for scene in BIN_SCENES if scene not in seen]
    count, of = kept.about["measured"], kept.about["of"]
    told = [
        f"Pictures as noisy as the authors': `{SOFT}` is wrong by more than 0.3 px in "
        f"{_told(hard, SOFT, WRONG)} of complex flow and {_told(quiet, SOFT, WRONG)} of quiet soil, its "
        f"median error {_told(hard, SOFT, 'median')} and {_told(quiet, SOFT, 'median')} px.",
        f"Clean pictures: {_told(clean, SOFT, WRONG)} of complex flow, median error "
        f"{_told(clean, SOFT, 'median')} px.",
        f"Wrong, by cause: {'; '.join(causes)}.",
        f"`{INSTEAD}` is wrong in {_told(hard, INSTEAD, WRONG)} of complex flow on the noisy pictures. "
        f"`{SOFT}` less `{INSTEAD}`: {_difference(hard)}; clean: {_difference(clean)}.",
        f"Measured: {count} of {of} sets of pictures and methods; implements: {', '.join(seen)}"
        + (f"; not yet: {', '.join(missing)}." if missing else "."),
    ]
    return "\n".join(f"- {sentence}" for sentence in told)


def how_large(kept: Kept) -> str:
    """Errors of the published technique and of what to use instead, stratum by stratum."""
    head = ["pictures", "soil", *_of_both("median [px]", "95 % [px]", "> 0.3 px"), "difference of shares"]
    rows = []
    for severity in (PAPER, CLEAN):
        for stratum in ("quiet", "moving", "complex", "mixed"):
            lines = [line for line in _wheels(kept, severity) if line["stratum"] == stratum]
            told = [_told(lines, m, q) for q in ("median", "p95", WRONG) for m in _BOTH]
            rows.append([severity, stratum, *told, _difference(lines)])
    return markdown_table(head, rows)


def by_scene(kept: Kept) -> str:
    """Complex flow of every implement."""
    head = ["scene", "complex [% of soil]", *_of_both("median [px]", "> 0.3 px"), "difference of shares"]
    lines = [line for line in _wheels(kept, PAPER) if line["stratum"] == "complex"]
    scenes = list(dict.fromkeys(line["scene"] for line in lines))
    rows = []
    for scene in scenes:
        own = [line for line in lines if line["scene"] == scene]
        every = [one for one in _wheels(kept, PAPER) if one["scene"] == scene and one["stratum"] == "all"]
        share = sum(one["pixel_count"] for one in own) / max(sum(one["pixel_count"] for one in every), 1)
        told = [_told(own, method, quantity) for quantity in ("median", WRONG) for method in _BOTH]
        rows.append([f"`{scene}`", f"{100 * share:.1f}", *told, _difference(own)])
    return markdown_table(head, rows)


def by_cause(kept: Kept) -> str:
    """Where wrong pixels are: every pixel of complex flow has one cause, the first that applies."""
    soft, instead = (Explained.of(kept.profiles, m, PAPER, BIN_SCENES) for m in _BOTH)
    clean = Explained.of(kept.profiles, SOFT, CLEAN, BIN_SCENES)
    everything = range(len(CAUSES))
    head = ["cause", "share of soil", f"> 0.3 px, `{SOFT}`", f"clean, `{SOFT}`", f"> 0.3 px, `{INSTEAD}`"]
    head += [f"of all wrong pixels of `{SOFT}`", f"bias along the motion, `{SOFT}` [px]"]
    rows = [
        [
            cause,
            _share(soft.share_of("cause", k, everything)),
            *(_share(one.share_wrong("cause", k)) for one in (soft, clean, instead)),
            _share(soft.share_of("cause", k, everything, "wrong_count")),
            _px(soft.bias("cause", k)),
        ]
        for k, cause in enumerate(CAUSES)
    ]
    return markdown_table(head, rows)


def seen_otherwise(kept: Kept) -> str:
    """The rolling wheel's complex flow with strides, textures, exchange and particles of other kinds."""
    own = [
        line
        for line in kept.lines
        if line["scene"] == BIN_SCENES[0] and line["severity"] == PAPER and line["stratum"] == "complex"
    ]
    groups = list(dict.fromkeys((line["label"], line["stride"]) for line in own))
    base = [line for line in own if (line["label"], line["stride"]) == ("", 1)]
    head = ["seen", *_of_both("> 0.3 px", "change"), "difference of the two"]
    rows = []
    for label, stride in sorted(groups, key=lambda one: one != ("", 1)):
        lines = [line for line in own if (line["label"], line["stride"]) == (label, stride)]
        changes = ["" if lines == base else _change(lines, base, method) for method in _BOTH]
        rows.append(
            [_way(label, stride), *(_told(lines, m, WRONG) for m in _BOTH), *changes, _difference(lines)]
        )
    return markdown_table(head, rows)


def resolution(kept: Kept) -> str:
    """Shortest period of a strain that alternates of which half, and nine tenths, are told."""
    if "response_product" not in kept.profiles:
        raise FindingsError("no scene whose strain alternates was measured")
    head = ["method", *(f"{severity}: half / nine tenths told from [px]" for severity in (PAPER, CLEAN))]
    methods = dict.fromkeys(kept.profiles["method"].values.tolist())
    rows = [[f"`{m}`", *(_resolved(kept, m, severity) for severity in (PAPER, CLEAN))] for m in methods]
    return markdown_table(head, rows)


def _verdicts(_: Kept, *, path: Path) -> str:
    return verdict_table(path)


TABLES: dict[str, Callable[[Kept], str]] = {
    "leaderboard": leaderboard,
    "answer": answer,
    "how-large": how_large,
    "by-scene": by_scene,
    "by-cause": by_cause,
    "seen-otherwise": seen_otherwise,
    "resolution": resolution,
    # Of the suite `paper`, whose verdicts are kept in files of their own.
    **{name: partial(_verdicts, path=path) for name, path in KEPT_VERDICTS.items()},
}
_BOTH = (SOFT, INSTEAD)


def with_findings(text: str, kept: Kept) -> str:
    """A Markdown text whose tables say what the kept tables say.

    Raises
    ------
    UnknownTableError
        It names a table that does not exist.
    """
    return with_tables(text, "findings", _tables(kept))


def update_document(path: Path, kept: Kept) -> None:
    """Bring the tables of a Markdown file up to date; everything else in it stays."""
    update_tables(path, "findings", _tables(kept))


def _tables(kept: Kept) -> dict[str, Callable[[], str]]:
    return {name: partial(table, kept) for name, table in TABLES.items()}


def _of_both(*quantities: str) -> list[str]:
    return [f"{quantity}, `{method}`" for quantity in quantities for method in _BOTH]


def _wheels(kept: Kept, severity: str) -> list[Line]:
    return [line for line in usual(kept.lines, severity) if line["scene"] in BIN_SCENES]


def _told(lines: Iterable[Line], method: str, quantity: str) -> str:
    own = [line for line in lines if line["method"] == method]
    try:
        interval = over_scenes(own, own[0]["stratum"], quantity) if own else None
    except StatisticsError:
        interval = None
    return _share(interval) if quantity == WRONG else _px(interval)


def _difference(lines: Sequence[Line]) -> str:
    """Of the two methods' shares of wrong pixels, on the pictures that both saw."""
    soft, instead = ([line for line in lines if line["method"] == method] for method in _BOTH)
    return _told_difference(soft, instead, within=GROUP)


def _change(lines: Sequence[Line], base: Sequence[Line], method: str) -> str:
    now, former = ([line for line in some if line["method"] == method] for some in (lines, base))
    return _told_difference(now, former, within=("scene",))


def _told_difference(first: Sequence[Line], second: Sequence[Line], within: Sequence[str]) -> str:
    try:
        interval, p = difference_over_scenes(first, second, WRONG, within=within)
    except StatisticsError:
        return "-"
    points = f"{100 * interval.value:+.1f} points"
    if interval.low != interval.low:  # not a number
        return points
    told = f"{points} ({100 * interval.low:+.1f} to {100 * interval.high:+.1f})"
    return told if p < _SIGNIFICANT else f"no difference told: {told}"


def _resolved(kept: Kept, method: str, severity: str) -> str:
    looks = kept.profiles[["response_product", "response_square"]].isel(
        look=(kept.profiles["method"].values == method) & (kept.profiles["severity"].values == severity)
    )
    sums = looks.sum("look", min_count=1)
    half, most = (resolved_period(response(sums), share) for share in (0.5, 0.9))
    return f"{_period(half)} / {_period(most)}"


def _period(value: float) -> str:
    return "-" if value != value else f"{value:.0f}"


def _way(label: str, stride: int) -> str:
    if stride != 1:
        return f"every {stride}nd picture" if stride == 2 else f"every {stride}th picture"
    kind, _, amount = label.partition("-")
    ways = {
        "": "as everywhere",
        "carried": "texture carried by single particles",
        "exchange": f"share {amount} of the grains replaced a frame",
        "grains": f"particles {amount.removeprefix('x')} times as large",
    }
    return ways.get(kind, label)


def _share(interval: Interval | None) -> str:
    return (
        "-"
        if interval is None
        else _with_half(100 * interval.value, 100 * (interval.high - interval.low), " %")
    )


def _px(interval: Interval | None) -> str:
    return "-" if interval is None else _with_half(interval.value, interval.high - interval.low, "")


def _with_half(value: float, width: float, unit: str) -> str:
    form = ".1f" if unit else ".3f"
    half = "" if width != width else f" ± {width / 2:{form}}"
    return f"{value:{form}}{half}{unit}"
