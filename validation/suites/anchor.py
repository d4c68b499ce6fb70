"""The severity `paper`: as much noise as gives `soft-2014` the error that its authors published.

Tuned on the controlled rotation alone, the one experiment with a published error, and on seeds of its own;
then frozen in `validation/reference/paper_severity.toml` and used everywhere. Only so do errors in complex
flow speak of the published technique. Noise of the sensor stands for all that disturbed the authors'
pictures: in a clean picture it gives errors spread as theirs are (95 % at about twice the median).
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from synth.disk import written_whole
from validation.published import read_published
from validation.suites.plan import Motion, Realisation, Suite
from validation.suites.table import Line

METHOD = "soft-2014"
SEEDS = (11, 12)
"""None that a suite reports on."""
LEVELS = (300.0, 400.0, 500.0)
"""electrons, of the read noise."""
FILE = "paper_severity.toml"

_HEADER = """\
# Severity `paper`: read noise at which {method} shows the published median error of {median:g} px on
# `plate_rotation`. Made by `softbed suite anchor OUT`, seeds {seeds}:
# median {told} px at {levels} electrons.
"""


class AnchorError(ValueError):
    """Measurements that no severity can be told from; the message is one line."""


class AnchorSuite(Suite):
    """Leaves the severity's file behind."""

    def write_more(self, lines: Sequence[Line], out: Path) -> None:
        """Write OUT/paper_severity.toml."""
        with written_whole(out / FILE) as draft:
            write_anchor(lines, draft)


def anchor_suite(quick: bool) -> Suite:
    """The rotation of the plate at several levels of noise."""
    pictures = tuple(
        Realisation(
            Motion("plate_rotation", seed, quick),
            pair_count=1,
            label=f"noise-{level:g}",
            changes=(("sensor", "read_noise", level),),
        )
        for seed in SEEDS
        for level in LEVELS
    )
    return AnchorSuite("anchor", "noise that gives soft-2014 its published error", pictures, (METHOD,))


def write_anchor(lines: Sequence[Line], path: Path) -> float:
    """Write the severity's file, and return the read noise, electrons.

    Raises
    ------
    AnchorError
        The published median lies outside of what was measured.
    """
    levels, medians = _medians(lines)
    target = read_published("rotation")["median"].value
    if len(levels) < 2 or not medians[0] <= target <= medians[-1]:
        told = ", ".join(f"{median:.3f}" for median in medians)
        raise AnchorError(f"anchor: medians of {told} px do not enclose the published {target:g} px")
    noise = float(np.exp(np.interp(np.log(target), np.log(medians), np.log(levels))))
    header = _HEADER.format(
        method=METHOD,
        median=target,
        seeds=", ".join(map(str, SEEDS)),
        told=", ".join(f"{median:.3f}" for median in medians),
        levels=", ".join(f"{level:g}" for level in levels),
    )
    path.write_text(f"{header}\n[sensor]\nread_noise = {noise:.0f}.0\n", encoding="utf-8")
    return noise


def _medians(lines: Sequence[Line]) -> tuple[list[float], list[float]]:
    """Levels of noise, and the mean over seeds of the median error at each."""
    by_level: dict[float, list[float]] = {}
    for line in lines:
        if line["method"] == METHOD and line["stratum"] == "all":
            by_level.setdefault(float(line["label"].removeprefix("noise-")), []).append(line["median"])
    levels = sorted(by_level)
    return levels, [float(np.mean(by_level[level])) for level in levels]
