"""Picture pairs of a data set for PyTorch; the only module that imports torch."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from synth.dataset.loading import load_data_set

try:
    import torch
    from torch.utils.data import Dataset
except ImportError as missing:
    raise ImportError("PyTorch is not installed: pip install torch") from missing

Sample = dict[str, Any]


class TorchPairs(Dataset):
    """Pairs of a split: `TorchPairs("OUT", "train")[0]`, and in a DataLoader with any number of workers.

    A sample is a dict of tensors: `first`, `second` (1, H, W) float32, 0 to 1; `flow` (2, H, W) float32, px,
    forward, 0 where not valid; `valid`, `soil`, `mixed` (H, W) bool.

    Parameters
    ----------
    folder : str or Path
        A data set.
    split : str
        `train`, `validation` or `test`.
    transform : callable, optional
        Given a sample, gives another: crops, flips; pictures of different sizes need one to be batched.

    Raises
    ------
    synth.dataset.folder.DataSetError
        No data set, or one of another schema version.
    """

    def __init__(
        self, folder: str | Path, split: str, transform: Callable[[Sample], Sample] | None = None
    ) -> None:
        self._pairs = load_data_set(folder).pairs(split)
        self._transform = transform

    def __len__(self) -> int:
        return len(self._pairs)

    def __getitem__(self, index: int) -> Sample:
        pair = self._pairs[index]
        sample: Sample = {name: _picture(getattr(pair, name)) for name in ("first", "second")}
        sample["flow"] = torch.from_numpy(np.nan_to_num(pair.flow, nan=0.0).transpose(2, 0, 1).copy())
        sample |= {name: torch.from_numpy(getattr(pair, name)) for name in ("valid", "soil", "mixed")}
        return sample if self._transform is None else self._transform(sample)


def _picture(picture: np.ndarray) -> "torch.Tensor":
    full_scale = np.float32(np.iinfo(picture.dtype).max)
    return torch.from_numpy(picture.astype(np.float32) / full_scale)[None]
