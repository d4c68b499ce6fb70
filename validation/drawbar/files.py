"""What a drawbar test leaves in its folder."""

import json
from collections.abc import Sequence
from pathlib import Path

from validation.drawbar.curve import Curve
from validation.drawbar.document import drawbar_document, write_table
from validation.drawbar.figure import balance_figure, travel_reduction_figure
from validation.terminal import Terminal


def write_results(
    curves: Sequence[Curve], out: Path, *, film: bool = False, terminal: Terminal
) -> list[Path]:
    """Write figures, table and document, and the film of an inching cycle where it is asked for.

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
    if film:
        from validation.drawbar.film import film_of_a_cycle

        files.append(film_of_a_cycle(curves, out / "inching.mp4", terminal=terminal))
    return files
