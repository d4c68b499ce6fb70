"""Pictures of a data card: a sheet of sequences, and the distributions of motion and grey levels."""

import io
import math
from typing import TYPE_CHECKING, Any

from synth.dataset.facts import EDGES, GREY_BINS
from synth.dataset.folder import DataSetFolder
from synth.dataset.members import Member
from synth.dataset.sweep import SPLITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHEET_FILE = "picture_sheet.jpg"
STATISTICS_FILE = "statistics.png"
_MOST_SHOWN = 12
_COLUMNS = 3
_CELL = (3.6, 2.2)
"""Inches, of a picture on the sheet with its title."""
_DOTS_PER_INCH = 110
_TITLE_LINES = 3
_COLOURS = {"train": "#0b5394", "validation": "#d98200", "test": "#6a994e"}


def draw_sheet(folder: DataSetFolder, members: list[Member]) -> bytes:
    """A JPEG with the middle picture of up to twelve members, evenly spread over the design."""
    from matplotlib.figure import Figure

    from synth.footage import Footage

    shown = members[:: math.ceil(len(members) / _MOST_SHOWN)]
    columns = min(_COLUMNS, len(shown))
    rows = math.ceil(len(shown) / columns)
    figure = Figure(figsize=(columns * _CELL[0], rows * _CELL[1]), dpi=_DOTS_PER_INCH, layout="constrained")
    places = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in places:
        axes.axis("off")
    for axes, member in zip(places, shown, strict=False):
        with Footage.open(folder.sequence(member.name)) as footage:
            picture = footage.picture(footage.frame_count // 2)
        top = 2 ** (8 * picture.dtype.itemsize) - 1
        axes.imshow(picture, cmap="gray", vmin=0, vmax=top, interpolation="antialiased")
        axes.set_title(_title(member), fontsize=6.5, loc="left", pad=2)
    return _bytes(figure, "jpeg", pil_kwargs={"quality": 80})


def draw_statistics(members: list[Member], facts: dict[str, Any]) -> bytes:
    """A PNG with the distributions of displacement and of grey level in each split."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 3), dpi=_DOTS_PER_INCH, layout="constrained")
    motion, grey = figure.subplots(1, 2)
    for split in SPLITS:
        own = [facts[member.name] for member in members if member.split == split]
        if own:
            _steps(motion, [one["displacement"] for one in own], split)
            _steps(grey, [one["grey"] for one in own], split)
    labels = [f"{low:g}" for low in EDGES]
    motion.set_xticks([k - 0.5 for k in range(len(labels))], labels, fontsize=7)
    motion.set_xlabel("displacement of soil, inertial frame [px]")
    shares = (0, 0.25, 0.5, 0.75, 1)
    grey.set_xticks([s * GREY_BINS - 0.5 for s in shares], [f"{100 * s:g}" for s in shares])
    grey.set_xlabel("grey level of soil [% of full scale]")
    for axes in (motion, grey):
        axes.set_ylabel("share of pixels [%]")
        axes.set_ylim(bottom=0)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=8)
    return _bytes(figure, "png")


def _steps(axes: "Axes", histograms: list[list[int]], split: str) -> None:
    total = [sum(bins) for bins in zip(*histograms, strict=True)]
    shares = [100 * count / max(sum(total), 1) for count in total]
    edges = [k - 0.5 for k in range(len(shares) + 1)]
    axes.stairs(shares, edges, label=split, color=_COLOURS[split], linewidth=1.4)


def _title(member: Member) -> str:
    """Name, split and what was varied, in at most three lines."""
    values = [f"{key.rpartition('.')[2]} {_short(value)}" for key, value in member.values.items()]
    lines, line = [f"{member.name}, {member.split}"], ""
    for value in values:
        if line and len(line) + len(value) > 46:
            lines.append(line)
            line = ""
        line = f"{line}, {value}" if line else value
    return "\n".join([*lines, line][:_TITLE_LINES])


def _short(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def _bytes(figure: "Figure", kind: str, **options: Any) -> bytes:
    content = io.BytesIO()
    figure.savefig(content, format=kind, **options)
    return content.getvalue()
