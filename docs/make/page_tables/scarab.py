"""Tables of docs/scarab.md: what `softbed drawbar` measured."""

from collections.abc import Iterable, Sequence

from kept import Row, distinct, document, having, rows, the_one

from validation.markdown_tables import markdown_table

GAITS = ("rolling", "inching")
WHEELS = ("rigid", "pneumatic")
REDUCTIONS = ("0.1", "0.2", "0.4")
STANDING = {"expand": "rear", "contract": "front"}
"""Axle that stands in each phase of an inching cycle."""


def result() -> str:
    """Pull over weight of both gaits on both wheels, and the published maxima."""
    curves = [
        the_one(document("drawbar.json")["curves"], gait=g, wheel=w, law="rft") for w in WHEELS for g in GAITS
    ]
    head = ["travel reduction"]
    for wheel in WHEELS:
        head += [*(f"{gait}, {wheel}" for gait in GAITS), "ratio"]
    table = [
        [_percent(name), *_with_ratios([one["at_travel_reduction"][name] for one in curves])]
        for name in REDUCTIONS
    ]
    maxima, published = ([one[key] for one in curves] for key in ("maximum", "published_maximum"))
    table.append(["maximum (90 %)", *_with_ratios(maxima, bold=True)])
    table.append(["published maximum", *_with_ratios(published, form=".2f")])
    off = [f"{100 * (own / other - 1):+.0f} %" for own, other in zip(maxima, published, strict=True)]
    table.append(["difference", *off[:2], "", *off[2:], ""])
    return markdown_table(head, table, words=1)


def _with_ratios(pulls: Sequence[float | None], form: str = ".3f", *, bold: bool = False) -> list[str]:
    """Rolling, inching, and their ratio, of one wheel after the other."""
    cells = []
    for rolling, inching in zip(pulls[::2], pulls[1::2], strict=True):
        ratio = f"{inching / rolling:.2f}" if rolling and inching else ""
        mark = "**" if bold and ratio else ""
        cells += [_pull(rolling, form), _pull(inching, form), f"{mark}{ratio}{mark}"]
    return cells


def laws() -> str:
    """Pull over weight of both gaits by the other laws."""
    told = document("drawbar-laws.json")["curves"]
    greatest = max(point["drawbar_pull_ratio"] for one in told for point in one["points"])
    table = []
    for (law,) in distinct(told, "law"):
        both = [the_one(told, law=law, gait=gait)["at_travel_reduction"] for gait in GAITS]
        pulls = [one[at] for at in REDUCTIONS for one in both]
        table.append([f"`{law}`", *(f"above {greatest:g}" if p is None else f"{p:.3f}" for p in pulls)])
    head = ["law"]
    for at in REDUCTIONS:
        head += [f"rolling at {_percent(at)}", "inching"]
    return markdown_table(head, table, words=1)


def grains() -> str:
    """Travel reduction and sinkage with the grains themselves, and by the law found in the bin."""
    by_grains = rows("drawbar-grains.csv") + rows("drawbar-grains-more.csv")
    by_law = rows("drawbar-identified.csv")
    head = ["pull / weight", "rolling, TR: grains", "law", "inching, TR: grains", "law"]
    head += ["sinkage front, rear, rolling [mm]: grains", "law"]
    table = []
    for load in sorted({row["drawbar_pull_ratio"] for row in by_grains}):
        cells = [f"{load:g}"]
        for gait in GAITS:
            cells += [
                _reduction(having(every, gait=gait, drawbar_pull_ratio=load)) for every in (by_grains, by_law)
            ]
        cells += [
            _sinkage(having(every, gait="rolling", drawbar_pull_ratio=load)) for every in (by_grains, by_law)
        ]
        table.append(cells)
    return markdown_table(head, table, words=0)


def _reduction(point: list[Row]) -> str:
    if not point:
        return ""
    reduction = point[0]["travel_reduction"]
    return f"{100 * reduction:.0f} %" + (": pulled back" if reduction > 1 else "")


def _sinkage(point: list[Row]) -> str:
    axles = [[row["sinkage_m"] for row in _of_axle(point, axle)] for axle in ("front", "rear")]
    return ", ".join(f"{1000 * sum(several) / len(several):.0f}" for several in axles if several)


def grains_axles() -> str:
    """What each axle thrusts when inching: grains at two loads, and the law at the first."""
    cases = {
        "grains, at 0.24": rows("drawbar-grains.csv", gait="inching", drawbar_pull_ratio=0.24),
        "grains, at 0.4": rows("drawbar-grains-more.csv", gait="inching", drawbar_pull_ratio=0.4),
        "law, at 0.24": rows("drawbar-identified.csv", gait="inching", drawbar_pull_ratio=0.24),
    }
    head = ["inching, force / load", "rear stands", "front rolls", "front stands", "rear rolls"]
    table = []
    for told, point in cases.items():
        cells = []
        for phase, stands in STANDING.items():
            during, rolls = having(point, phase=phase), "front" if stands == "rear" else "rear"
            cells += [_thrust_over_load(_of_axle(during, axle)) for axle in (stands, rolls)]
        table.append([told, *cells])
    return markdown_table(head, table, words=1)


def _of_axle(several: Iterable[Row], axle: str) -> list[Row]:
    return [row for row in several if row["wheel"].startswith(axle)]


def _thrust_over_load(wheels: list[Row]) -> str:
    return f"{sum(one['force_x_N'] for one in wheels) / sum(one['force_z_N'] for one in wheels):.2f}"


def glass() -> str:
    """Soil motion through the glass, as measured and in truth."""
    table = []
    for row in rows("drawbar-glass.csv"):
        measured = row["way"] == "measured"
        shares = [f"{row[name]:.2f}" for name in ("along_thrust", "across_thrust", "resultant")]
        thrust = f"{row['thrust_over_load']:.2f}" if measured else ""
        table.append(
            [row["wheel"] if measured else "", row["way"], *shares, f"{row['depth_mm']:.0f}", thrust]
        )
    head = ["wheel", "", "motion energy along thrust", "across", "resultant of directions"]
    return markdown_table([*head, "depth [mm]", "thrust / load"], table, words=2)


def _percent(reduction: str) -> str:
    return f"{100 * float(reduction):.0f} %"


def _pull(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


TABLES = {
    "drawbar": result,
    "drawbar-laws": laws,
    "drawbar-grains": grains,
    "drawbar-grains-axles": grains_axles,
    "drawbar-glass": glass,
}
