"""Flow methods side by side on the same pictures: how wrong, and how fast.

The analytic scenes at their own seeds, and any runs that are given. Own methods as users get them; peers as
their libraries give them, without the check of the way back and the uncertainty that `estimate_flow` adds;
grids at their nodes. No constant of ours was tuned on them: that was done at seed 101.
"""

from collections.abc import Callable, Sequence

from validation.bench.flow_case import CaseSource
from validation.bench.flow_contender import CONTENDERS, Subject
from validation.bench.flow_measure import measured
from validation.bench.rows import BenchRow


def bench_flow(
    cases: Sequence[CaseSource],
    *,
    subjects: Sequence[Subject] | None = None,
    repeats: int = 5,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[BenchRow]:
    """Errors and seconds a pair of every method on every case, in turn.

    Parameters
    ----------
    cases : sequence of callable
        Each makes a `Case`: `analytic_cases()`, `run_cases(folders)` and others, joined.
    subjects : sequence of Subject, optional
        The methods; by default `CONTENDERS`.
    repeats : int
        Of the timing, at most; rows give the median. Results do not change.
    threads : int, optional
        Default: every core.
    """
    rows: list[BenchRow] = []
    asked = CONTENDERS if subjects is None else subjects
    for done, source in enumerate(cases, start=1):
        case = source()
        for subject in asked:
            rows += measured(case, subject, repeats, threads)
        if progress is not None:
            progress(done, len(cases))
    return rows
