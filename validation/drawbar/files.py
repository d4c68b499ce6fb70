"""What a drawbar test leaves in its folder."""

import csv
import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from validation.drawbar.curve import Curve
from validation.drawbar.document import drawbar_document, write_table
from validation.drawbar.figure import balance_figure, travel_reduction_figure
from validation.drawbar.variation import range_rows
from validation.terminal import Terminal


def write_results(
    curves: Sequence[Curve],
    out: Path,
    *,
    film: bool = False,
    glass: Mapping[str, Path] | None = None,
    terminal: Terminal,
) -> list[Path]:
    """Write figures, table and document; the film of an inching cycle where it is asked for.

    Parameters
    ----------
    glass : mapping, optional
        Run folders of a rolling and of a pushed wheel by `runs_by_wheel`, to be looked at beside the forces.

    Returns
    -------
    list of Path
        The files.
    """
    from soft.figures.page import save_figure

    files = [
        save_figure(travel_reduction_figure(curves), out / "drawbar.png"),
        save_figure(balance_figure(curves), out / "balance.png"),
    ]
    document, table = out / "drawbar.json", out / "drawbar.csv"
    document.write_text(json.dumps(drawbar_document(curves), indent=1, allow_nan=False), encoding="utf-8")
    write_table(curves, table)
    files += [document, table]
    if glass:
        from validation.drawbar.glass import glass_figure, look, write_glass_table

        views = {wheel: look(run) for wheel, run in glass.items()}
        write_glass_table(views, out / "glass.csv")
        files += [save_figure(glass_figure(views, curves), out / "glass.png"), out / "glass.csv"]
    if film:
        from validation.drawbar.film import film_of_a_cycle

        files.append(film_of_a_cycle(curves, out / "inching.mp4", terminal=terminal))
    return files


def write_range(curves: Sequence[Curve], path: Path) -> Path:
    """Write what the gaits pull over the range of what is assumed, one line a variation."""
    rows = range_rows(curves)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    return path
