"""Data sets made by sweeps, and recordings and footage in the formats of others."""

from typing import TYPE_CHECKING

from synth.lazy_names import lazy_names

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

__getattr__, __dir__ = lazy_names(__name__, _HOMES)
