"""The page of the suite `paper`: experiment by experiment, published beside ours."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from validation.page import Panel, write_page
from validation.suites.execution import Failure
from validation.suites.paper.conclusion import Conclusion, experiments
from validation.suites.paper.experiment import Experiment
from validation.suites.paper.found import Found
from validation.suites.paper.verdict import JUDGED, Row, number, our_words, published_words
from validation.suites.report import how_made

_MARKS = {"reproduced": "yes", "differs": "no", "not measured": "open"}


@dataclass(frozen=True)
class Line:
    """A published number as the page shows it.

    Attributes
    ----------
    says, where, unit, published, ours, truth : str
        `truth` is empty where there is none to tell.
    verdict, mark, reason : str
        `mark` is a class of the page.
    beside : list of (str, str)
        The same by other methods, or on clean pictures.
    """

    says: str
    where: str
    unit: str
    published: str
    ours: str
    truth: str
    verdict: str
    mark: str
    reason: str
    beside: list[tuple[str, str]]


@dataclass(frozen=True)
class Section:
    """An experiment as the page shows it."""

    name: str
    title: str
    figures: str
    about: str
    lines: list[Line]
    findings: list[str]
    panels: list[Panel]

    @property
    def score(self) -> str:
        """How many numbers are reproduced."""
        return f"{sum(line.mark == 'yes' for line in self.lines)} of {len(self.lines)}"


def write_paper_report(
    path: Path,
    found: Found,
    conclusion: Conclusion,
    failures: Sequence[Failure],
    *,
    command: str,
) -> None:
    """Write the page from the measurements that are there.

    Parameters
    ----------
    path : Path
        The page to write.
    command : str
        What a person types to get all of it again.
    """
    sections = [_section(experiment, found, conclusion) for experiment in experiments()]
    content = _content(sections, found, conclusion) | how_made(failures, command)
    write_page(path, "paper.html.j2", content)


def _content(sections: list[Section], found: Found, conclusion: Conclusion) -> dict[str, Any]:
    quick = any(look.realisation.motion.quick for look in found.looks)
    facts = {
        "motions": str(len({look.realisation.motion for look in found.looks})),
        "sets of pictures": str(len({look.realisation for look in found.looks})),
        "size": "quick: smaller and coarser, a look and no measurement" if quick else "full",
    }
    return {
        "title": "The paper, again",
        "description": (
            "Every published number of the soil optical flow technique (Skonieczny et al., Journal of "
            "Field Robotics 31(5), 2014) beside ours, from pictures whose true motion is known."
        ),
        "facts": facts,
        "sentence": conclusion.sentence,
        "judged": JUDGED,
        "sections": [section for section in sections if section.lines],
    }


def _section(experiment: Experiment, found: Found, conclusion: Conclusion) -> Section:
    rows = [row for row in conclusion.judged if row.experiment == experiment.name]
    return Section(
        experiment.name,
        experiment.title,
        experiment.figures,
        experiment.about,
        [_line(row, conclusion) for row in rows],
        experiment.find(found) if rows else [],
        experiment.draw(found) if rows else [],
    )


def _line(row: Row, conclusion: Conclusion) -> Line:
    published = row.published
    return Line(
        says=f"{row.case}: {published.says}" if row.case else published.says,
        where=published.where,
        unit="" if published.unit == "1" else published.unit,
        published=published_words(published),
        ours=our_words(row.ours),
        truth="" if np.isnan(row.truth) else number(row.truth),
        verdict=row.verdict,
        mark=_MARKS[row.verdict],
        reason=row.reason,
        beside=[
            (f"{other.variant.method}, {other.variant.severity}", our_words(other.ours))
            for other in conclusion.beside(row)
        ],
    )
