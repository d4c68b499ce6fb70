"""What an experiment of the paper is: its published numbers, ours, and the figures that show them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from validation.page import Panel
from validation.published import read_published
from validation.suites.paper.found import Found
from validation.suites.paper.verdict import Row, Told, Variant, judge, reason


@dataclass(frozen=True)
class Experiment:
    """One experiment.

    Attributes
    ----------
    name, title : str
    figures : str
        Of the paper.
    about : str
        What was done, there and here.
    table : str
        Of the published numbers, in `validation/reference`.
    quantities : tuple of str
        Those of the table that are measured, in order.
    tell : callable
        Our numbers by one variant.
    draw : callable
        Figures.
    find : callable
        Sentences about what only the truth can tell.
    causes : mapping
        As `validation.suites.paper.verdict.reason` takes them.
    """

    name: str
    title: str
    figures: str
    about: str
    table: str
    quantities: tuple[str, ...]
    tell: Callable[[Found, Variant], list[Told]]
    draw: Callable[[Found], list[Panel]]
    find: Callable[[Found], list[str]] = lambda _: []
    causes: Mapping[tuple[str, str], str] = field(default_factory=dict)

    def rows(self, found: Found, variant: Variant) -> list[Row]:
        """Every published number beside ours; without those that a variant has nothing to say of."""
        published = read_published(self.table)
        told = sorted(self.tell(found, variant), key=lambda one: self.quantities.index(one.quantity))
        rows = []
        for one in told:
            here = published[one.quantity]
            why = reason(here, one.interval, self.causes, one.truth)
            verdict = judge(here, one.interval)
            rows.append(Row(self.name, here, one.case, variant, one.interval, one.truth, verdict, why))
        return rows
