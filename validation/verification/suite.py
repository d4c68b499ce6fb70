"""All cases by name, and how they are run and shown."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from validation.verification.balances import (
    angular_momentum,
    energy,
    momentum_with_implement,
    weight_on_walls,
)
from validation.verification.biaxial import biaxial, sphere_biaxial
from validation.verification.cohesion import held_pair, standing_column
from validation.verification.collisions import (
    elastic_contact,
    gross_sliding,
    rebound_between_discs,
    rebound_from_floor,
    rolling_impact,
)
from validation.verification.column_collapse import column_collapse, sphere_column_collapse
from validation.verification.comparison import Comparison, Progress
from validation.verification.impacts import (
    damped_normal_impact,
    elastic_normal_impact,
    oblique_impact,
    oblique_impact_on_plane,
    spinning_spheres,
)
from validation.verification.precision import slow_creep, sphere_creep, threads
from validation.verification.repose import repose, sphere_repose
from validation.verification.silo import janssen, sphere_janssen
from validation.verification.sliding_and_rolling import (
    block_on_incline,
    disc_on_incline,
    sliding_to_rolling,
    tangential_spring,
)
from validation.verification.sphere_balances import sphere_angular_momentum, sphere_momentum, sphere_weight

if TYPE_CHECKING:
    from rich.table import Table

SCHEMA_VERSION = 1

FAST: dict[str, Callable[[], list[Comparison]]] = {
    "rebound": rebound_between_discs,
    "floor-rebound": rebound_from_floor,
    "elastic-contact": elastic_contact,
    "gross-sliding": gross_sliding,
    "rolling-impact": rolling_impact,
    "block-on-incline": block_on_incline,
    "disc-on-incline": disc_on_incline,
    "sliding-to-rolling": sliding_to_rolling,
    "tangential-spring": tangential_spring,
    "energy": energy,
    "angular-momentum": angular_momentum,
    "implement-momentum": momentum_with_implement,
    "weight": weight_on_walls,
    "creep": slow_creep,
    "threads": threads,
    "impact-1-2": elastic_normal_impact,
    "impact-3": damped_normal_impact,
    "impact-4": oblique_impact,
    "impact-5-6": oblique_impact_on_plane,
    "impact-7-8": spinning_spheres,
    "sphere-momentum": sphere_momentum,
    "sphere-angular-momentum": sphere_angular_momentum,
    "sphere-weight": sphere_weight,
    "sphere-creep": sphere_creep,
    "cohesion": held_pair,
    "cohesive-column": standing_column,
}
"""Cases of a few seconds at most."""

SLOW: dict[str, Callable[[Progress], list[Comparison]]] = {
    "janssen": janssen,
    "biaxial": biaxial,
    "repose": repose,
    "column-collapse": column_collapse,
    "sphere-janssen": sphere_janssen,
    "sphere-biaxial": sphere_biaxial,
    "sphere-repose": sphere_repose,
    "sphere-column-collapse": sphere_column_collapse,
}
"""Cases of a minute or two each, with thousands of grains."""

CASES = (*FAST, *SLOW)
_SLOW_SHARE = 20
"""Progress that a slow case counts for; a fast one counts for one."""


@dataclass(frozen=True)
class CaseResult:
    """What a case gave."""

    case: str
    comparisons: list[Comparison]

    @property
    def passed(self) -> bool:
        """Whether every limit is kept."""
        return all(comparison.passed for comparison in self.comparisons)


def choose_cases(names: Sequence[str], *, quick: bool) -> tuple[str, ...]:
    """Those named, in the suite's order; without a name all, or the fast ones if `quick`.

    Raises
    ------
    ValueError
        There is no such case.
    """
    unknown = [name for name in names if name not in CASES]
    if unknown:
        raise ValueError(f"case = {unknown[0]!r}: allowed are {', '.join(CASES)}")
    if names:
        return tuple(name for name in CASES if name in names)
    return tuple(FAST) if quick else CASES


def verify_dem(cases: Sequence[str] = CASES, *, progress: Progress | None = None) -> list[CaseResult]:
    """Run cases by their names.

    `synth.devices.start_taichi` must have been called.
    """
    weights = [_SLOW_SHARE if name in SLOW else 1 for name in cases]
    total, before = 100 * sum(weights), 0
    results = []
    for name, weight in zip(cases, weights, strict=True):
        results.append(CaseResult(name, _run(name, _part(progress, before, 100 * weight, total))))
        before += 100 * weight
        if progress is not None:
            progress(before, total)
    return results


def _run(name: str, progress: Progress) -> list[Comparison]:
    return SLOW[name](progress) if name in SLOW else FAST[name]()


def _part(progress: Progress | None, before: int, share: int, total: int) -> Progress:
    """Progress of one case as progress of the suite."""

    def advance(done: int, of: int) -> None:
        if progress is not None:
            progress(before + share * done // of, total)

    return advance


def verify_document(results: Sequence[CaseResult]) -> dict[str, Any]:
    """The JSON document of `softbed verify`."""
    rows = [{"case": result.case, **row.to_dict()} for result in results for row in result.comparisons]
    return {"schema_version": SCHEMA_VERSION, "rows": rows}


def verify_table(results: Sequence[CaseResult]) -> "Table":
    """The same for a terminal; sources are left to the document."""
    from rich.table import Table

    table = Table(title="verification of the grain solver", title_justify="left")
    table.add_column("case", no_wrap=True)
    table.add_column("quantity")
    for column in ("reference", "measured", "error", "limit"):
        table.add_column(column, justify="right", no_wrap=True)
    table.add_column("verdict")
    for result in results:
        for number, row in enumerate(result.comparisons):
            table.add_row(
                result.case if number == 0 else "",
                row.quantity,
                f"{row.reference:.5g}",
                f"{row.measured:.5g}",
                f"{row.relative_error:.2g}",
                f"{row.limit:.2g}",
                "passed" if row.passed else "FAILED",
            )
        table.add_section()
    return table
