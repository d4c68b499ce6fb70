"""Tables of docs/flow.md: methods side by side, on noisy pictures."""

from collections.abc import Callable, Sequence
from statistics import mean

from kept import Row, distinct, having

from validation.markdown_tables import markdown_table
from validation.suites.kept import SHIPPED, read_kept

NOISY = {
    "robust-affine": "`robust-affine`",
    "robust-affine-fast": "its `fast`",
    "dis": "DIS medium",
    "dis-full": "DIS full",
    "farneback": "Farnebäck",
    "tvl1": "TV-L1",
    "ilk": "iter. Lucas-Kanade",
}
"""What the suite calls them."""
NOISY_SCENES = (
    "rolling_wheel",
    "pushed_wheel",
    "grouser_wheel",
    "compliant_wheel",
    "bucket",
    "fillite_wheel",
)
_LEAST = 1000
"""Px; less soil tells little."""


def noisy() -> str:
    """Median error and share wrong at the severity `paper`, where soil moves and where it is complex."""
    every = [line for line in read_kept(SHIPPED).lines if _is_told(line)]
    table = []
    for scene, where in distinct(every, "scene", "stratum"):
        seen = [having(every, scene=scene, stratum=where, method=method) for method in NOISY]
        medians = [mean(line["median"] for line in lines) for lines in seen]
        wrong = [100 * mean(line["wrong_0.3"] for line in lines) for lines in seen]
        cells = zip(
            _lowest_in_bold(medians, "{:.3f}".format), _lowest_in_bold(wrong, "{:.1f}".format), strict=True
        )
        table.append([f"`{scene}`", where, *(" / ".join(pair) for pair in cells)])
    return markdown_table(["pictures", "where", *NOISY.values()], table, words=2)


def _is_told(line: Row) -> bool:
    """Of the first pictures of each simulation, regions that are large enough."""
    of_these = line["scene"] in NOISY_SCENES and line["stratum"] in ("moving", "complex")
    as_shipped = line["label"] == "" and line["stride"] == 1 and line["picture_seed"] == 0
    return of_these and as_shipped and line["severity"] == "paper" and line["pixel_count"] >= _LEAST


def _lowest_in_bold(values: Sequence[float], form: Callable[[float], str]) -> list[str]:
    """Spelt out; bold are those that read as the lowest does."""
    spelt = [form(value) for value in values]
    lowest = form(min(values))
    return [f"**{told}**" if told == lowest else told for told in spelt]


TABLES = {"flow-noisy": noisy}
