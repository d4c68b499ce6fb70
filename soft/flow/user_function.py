"""A user's own flow function, given as a callable or as `package.module:function`."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from traceback import extract_tb

import numpy as np

from soft.flow.estimator import Estimator
from soft.flow.field import FlowError, FlowField


@dataclass(frozen=True)
class NoOptions:
    """A user's function takes none: bind settings with `functools.partial`."""


def from_function(function: Callable, name: str | None = None) -> Estimator:
    """Make an estimator from `f(first, second, mask) -> (H, W, 2)` displacement in px.

    The function gets copies, grey (H, W) float32 0-255 and a bool mask (True = use), and says by NaN where it
    could not measure.
    """
    name = name or _name_of(function)

    def solve(first: np.ndarray, second: np.ndarray, mask: np.ndarray, options: NoOptions) -> FlowField:
        try:
            output = function(first.copy(), second.copy(), mask.copy())
        except Exception as error:
            said = f"{type(error).__name__}: {error}, in {_place(error)}"
            raise FlowError(f"method {name!r} failed: {said}") from error
        return FlowField(_checked(output, first.shape, name), mask)

    return Estimator(name, NoOptions, solve, own_texture=True, forward_backward=False)


def from_import_path(path: str) -> Estimator:
    """Make an estimator from `package.module:function`.

    Raises
    ------
    FlowError
        If the module cannot be imported or holds no such function.
    """
    module_name, _, function_name = path.partition(":")
    try:
        module = import_module(module_name)
    except Exception as error:
        raise FlowError(f"method {path!r}: cannot import {module_name!r}: {error}") from error
    function = getattr(module, function_name, None)
    if not callable(function):
        raise FlowError(f"method {path!r}: {module_name!r} has no function {function_name!r}")
    return from_function(function, path)


def _name_of(function: Callable) -> str:
    module = getattr(function, "__module__", type(function).__module__)
    return f"{module}:{getattr(function, '__qualname__', type(function).__qualname__)}"


def _place(error: Exception) -> str:
    """File and line that raised: the first thing its author looks for."""
    innermost = extract_tb(error.__traceback__)[-1]
    return f"{innermost.filename}, line {innermost.lineno}"


def _checked(output: object, shape: tuple[int, ...], name: str) -> np.ndarray:
    field = np.asarray(output)
    expected = (*shape, 2)
    if field.shape != expected:
        raise FlowError(f"method {name!r} returned shape {field.shape}: must be {expected}")
    if field.dtype.kind not in "fiu":
        raise FlowError(f"method {name!r} returned type {field.dtype}: must be real numbers")
    return field
