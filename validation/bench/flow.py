"""Flow methods side by side on the same pictures: how wrong, and how fast.

The analytic scenes at their own seeds, and any runs that are given. No constant of ours was tuned on them:
that was done on analytic scenes, `rolling_wheel` and `bucket` at seed 101.
"""

from collections.abc import Callable, Sequence

from validation.bench.flow_case import CaseSource
from validation.bench.flow_contender import CONTENDERS, Contender
from validation.bench.flow_measure import measured
from validation.bench.rows import BenchRow


def bench_flow(
    cases: Sequence[CaseSource],
    *,
    contenders: Sequence[Contender] = CONTENDERS,
    repeats: int = 5,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[BenchRow]:
    """Errors and seconds a pair of every method on every case, in turn.

    Parameters
    ----------
    cases : sequence of callable
        Each makes a `Case`: `analytic_cases()`, `run_cases(folders)` and others, joined.
    contenders : sequence of Contender
        The methods.
    repeats : int
        Of the timing; rows give the median. Results do not change.
    threads : int, optional
        Default: every core.
    """
    rows: list[BenchRow] = []
    for done, source in enumerate(cases, start=1):
        case = source()
        for contender in contenders:
            rows += measured(case, contender, repeats, threads)
        if progress is not None:
            progress(done, len(cases))
    return rows
