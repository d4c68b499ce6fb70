"""One quantity that is known beforehand beside what the solver gave."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

Progress = Callable[[int, int], None]
"""Called with work done and work in all."""


@dataclass(frozen=True)
class Comparison:
    """A reference and a measurement.

    Attributes
    ----------
    quantity : str
        Name and unit.
    reference, measured : float
        In that unit.
    relative_error : float
        ``|measured - reference|`` / the reference, or the scale that `compare` was given.
    limit : float
        Of the relative error, fixed before measuring.
    source : str
        Where the reference comes from.
    low, high : float or None
        Bounds that the measurement has to keep within; None where the reference is a value of its own.
    """

    quantity: str
    reference: float
    measured: float
    relative_error: float
    limit: float
    source: str
    low: float | None = None
    high: float | None = None

    @property
    def passed(self) -> bool:
        """Whether the limit is kept; a measurement that is not a number keeps none."""
        return bool(self.relative_error <= self.limit)

    def headed(self, subject: str) -> "Comparison":
        """The same, with what it was measured on before its quantity."""
        return replace(self, quantity=f"{subject}: {self.quantity}")

    def to_dict(self) -> dict[str, Any]:
        """The fields and the verdict, for JSON."""
        return asdict(self) | {"passed": self.passed}


def part_of(progress: Progress, part: int, parts: int) -> Progress:
    """Progress of one of several equal parts as progress of the whole."""
    return lambda done, total: progress(part * total + done, parts * total)


def compare(
    quantity: str, *, reference: float, measured: float, limit: float, source: str, scale: float | None = None
) -> Comparison:
    """Compare a measurement with its reference.

    Parameters
    ----------
    scale : float, optional
        What the error is relative to; the reference, unless that is zero.
    """
    unit = abs(reference) if scale is None else scale
    error = abs(measured - reference) / unit
    return Comparison(quantity, float(reference), float(measured), float(error), limit, source)


def compare_with_bounds(
    quantity: str, *, low: float, high: float, measured: float, source: str
) -> Comparison:
    """Compare a measurement with bounds: their middle is the reference, half their distance the limit."""
    middle = (low + high) / 2
    limit = (high - low) / 2 / middle
    one = compare(quantity, reference=middle, measured=measured, limit=limit, source=source)
    return replace(one, low=float(low), high=float(high))
