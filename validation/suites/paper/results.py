"""What the suite `paper` leaves beside what every suite does: its verdicts, and a page of its own."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from synth.disk import written_whole
from validation.suites.execution import Failure
from validation.suites.paper.conclusion import Conclusion, write_verdicts
from validation.suites.paper.found import Found
from validation.suites.paper.report import write_paper_report
from validation.suites.plan import Suite

PAGE, VERDICTS = "paper.html", "paper-verdicts.csv"


def conclude(suite: Suite, out: Path, failures: Sequence[Failure], *, command: str) -> dict[str, Any]:
    """Write `paper-verdicts.csv` and `paper.html`; return what the suite's JSON says of them."""
    with Found.of(suite, out) as found:
        conclusion = Conclusion.of(found)
        write_verdicts(conclusion.rows, out / VERDICTS)
        with written_whole(out / PAGE) as draft:
            write_paper_report(draft, found, conclusion, failures, command=command)
    return conclusion.to_dict()
