"""Data sets made by sweeps, and recordings and footage in the formats of others."""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from synth.dataset.execution import make_data_set
    from synth.dataset.folder import DataSetError
    from synth.dataset.loading import DataSet, FlowPair, load_data_set
    from synth.dataset.torch_pairs import TorchPairs

_HOMES = {
    "DataSet": "synth.dataset.loading",
    "DataSetError": "synth.dataset.folder",
    "FlowPair": "synth.dataset.loading",
    "TorchPairs": "synth.dataset.torch_pairs",
    "load_data_set": "synth.dataset.loading",
    "make_data_set": "synth.dataset.execution",
}
__all__ = [
    "DataSet",
    "DataSetError",
    "FlowPair",
    "TorchPairs",
    "load_data_set",
    "make_data_set",
]


def __getattr__(name: str) -> Any:
    """Import a public name on its first use: dask, torch and others load only where needed."""
    if name not in _HOMES:
        raise AttributeError(f"module 'synth.dataset' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    """Public names, imported or not yet."""
    return sorted([*globals(), *__all__])
