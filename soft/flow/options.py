"""Options of an estimator: a frozen dataclass each, built from keywords, unknown ones refused."""

from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Any

from soft.flow.field import FlowError


def build_options(kind: type, method: str, options: Mapping[str, object]) -> Any:
    """`kind(**options)`, where an unknown or missing option is a FlowError that lists what is allowed."""
    allowed = {field.name: field for field in fields(kind)}
    unknown = sorted(set(options) - set(allowed))
    if unknown:
        known = ", ".join(allowed) or "none"
        raise FlowError(f"method {method!r}: unknown option {', '.join(unknown)}: allowed are {known}")
    missing = [n for n, field in allowed.items() if field.default is MISSING and n not in options]
    if missing:
        raise FlowError(f"method {method!r}: option {', '.join(missing)} must be given")
    return kind(**options)


def require_count(name: str, value: object, *, least: int, most: int | None = None) -> None:
    """Refuse `value` unless it is a whole number from `least` to `most`."""
    whole = isinstance(value, int) and not isinstance(value, bool)
    if not (whole and least <= value and (most is None or value <= most)):  # type: ignore[operator]
        span = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise FlowError(f"{name}: {value!r}: must be a whole number {span}")


def require_number(name: str, value: object, *, above: float, below: float = float("inf")) -> None:
    """Refuse `value` unless it is a number strictly between `above` and `below`."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not (number and above < value < below):  # type: ignore[operator]
        span = f"above {above:g}" if below == float("inf") else f"between {above:g} and {below:g}"
        raise FlowError(f"{name}: {value!r}: must be a number {span}")


def require_finite(name: str, value: object) -> None:
    """Refuse `value` unless it is a finite number."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not (number and abs(value) < float("inf")):  # type: ignore[arg-type]
        raise FlowError(f"{name}: {value!r}: must be a number")


def require_choice(name: str, value: object, allowed: tuple[object, ...]) -> None:
    """Refuse `value` unless it is one of `allowed`."""
    if value not in allowed:
        raise FlowError(f"{name}: {value!r}: allowed are {', '.join(map(str, allowed))}")


def require_flag(name: str, value: object) -> None:
    """Refuse `value` unless it is true or false."""
    if not isinstance(value, bool):
        raise FlowError(f"{name}: {value!r}: must be true or false")
