"""What a sweep would take, as a table."""

from typing import TYPE_CHECKING

from validation.terminal import duration

if TYPE_CHECKING:
    from rich.table import Table

    from synth.dataset.forecast import Forecast


def forecast_table(found: "Forecast") -> "Table":
    """Show a forecast to a person."""
    from rich.table import Table

    table = Table(title="sweep, not carried out", title_justify="left", show_header=False)
    for label, value in _lines(found):
        table.add_row(label, value)
    return table


def _lines(found: "Forecast") -> list[tuple[str, str]]:
    splits = ", ".join(f"{count} {split}" for split, count in found.split_counts.items())
    workers = f"{found.workers} worker{'s' * (found.workers > 1)}"
    lines = [
        ("sequences", f"{found.member_count} ({splits})"),
        ("there already", str(found.made_count)),
        ("beds to settle", str(found.bed_count)),
        ("motions to simulate", str(found.simulation_count)),
        ("pictures to render", str(found.frame_count)),
        *((f"time of a core, {name}", duration(value)) for name, value in found.core_seconds.items()),
        (f"time of {workers}", f"{duration(found.seconds)}, by {found.basis}"),
        ("size of what is missing", f"{found.bytes / 1e9:.3g} GB"),
    ]
    if found.empty_splits:
        lines.append(("splits without a member", f"{', '.join(found.empty_splits)}: too few simulations"))
    if found.repeated_count:
        lines.append(("points that repeat another", f"{found.repeated_count}, left out"))
    if found.impossible_count:
        lines.append(("points that are no scene", f"{found.impossible_count}: {found.reasons[0]}"))
    return lines
