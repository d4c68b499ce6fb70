"""Where a method's name leads: a built-in estimator, a user's function, a folder of files.

Nothing heavy is imported before a name is followed: the command line's help tells of all methods.
"""

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from soft.flow.estimator import Estimator

# Name and module of each built-in estimator; the module calls it ESTIMATOR.
BUILT_IN = {
    "black-anandan": "soft.flow.black_anandan.estimator",
    "dis": "soft.flow.dis",
    "farneback": "soft.flow.farneback",
    "ilk": "soft.flow.ilk",
    "robust-affine": "soft.flow.robust_affine.estimator",
    "tvl1": "soft.flow.tvl1",
}

# Methods with options settled, under names of their own: what a command line can ask for, and results name.
VARIANTS: dict[str, tuple[str, dict[str, object]]] = {
    "dis-full": ("dis", {"finest_scale": 0}),
    "robust-affine-fast": ("robust-affine", {"preset": "fast"}),
    "soft-2014": ("black-anandan", {"preset": "soft-2014"}),
}

# The distributions that some of them need and an installation may lack.
NEEDS = {"ilk": "scikit-image", "tvl1": "scikit-image"}


def method_names() -> list[str]:
    """Names of `BUILT_IN`, each followed by its variants."""
    variants = {
        name: [variant for variant, (base, _) in VARIANTS.items() if base == name] for name in BUILT_IN
    }
    return [one for name in BUILT_IN for one in (name, *variants[name])]


def installed() -> list[str]:
    """Built-in methods that can run here, sorted."""
    return sorted(name for name in BUILT_IN if name not in NEEDS or _is_installed(NEEDS[name]))


def _is_installed(distribution: str) -> bool:
    try:
        version(distribution)
    except PackageNotFoundError:
        return False
    return True


def find_estimator(method: str | Callable) -> "Estimator":
    """Find the estimator that `method` names.

    Parameters
    ----------
    method : str or callable
        A name of `BUILT_IN` or `VARIANTS`, `package.module:function`, `files:FOLDER`, or a function of the
        user's own.

    Raises
    ------
    FlowError
        If it names nothing.
    """
    from soft.flow.field import FlowError
    from soft.flow.files import PREFIX, from_files
    from soft.flow.user_function import from_function, from_import_path

    if callable(method):
        return from_function(method)
    if method in BUILT_IN:
        return import_module(BUILT_IN[method]).ESTIMATOR
    if method in VARIANTS:
        base, settled = VARIANTS[method]
        return replace(find_estimator(base), name=method, settled=settled)
    if method.startswith(PREFIX):
        return from_files(method)
    if ":" in method:
        return from_import_path(method)
    known = ", ".join(sorted({*BUILT_IN, *VARIANTS}))
    raise FlowError(f"method {method!r}: allowed are {known}, package.module:function and {PREFIX}FOLDER")
