"""How samples lie in memory: those of a pixel together, and some of its rows in one step of a kernel.

A buffer of samples is a table (H, W, S, S): pixel's row and column, then the sample's within the pixel.
Kernels that take scalars see it as it is. Those that must be fast take groups of whole rows of a pixel as
vectors, of which the compiler makes the processor's wide instructions, as it does of no loop of taichi's.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

_MOST_LANES = 36
"""Samples in a group: more take long to compile."""


def rows_at_once(sampling: int) -> int:
    """Rows of a pixel's samples in a group: as many as divide them evenly and are not too many samples."""
    fitting = (rows for rows in range(1, sampling + 1) if sampling % rows == 0)
    return max((rows for rows in fitting if rows * sampling <= _MOST_LANES), default=1)


def in_groups(samples: "np.ndarray") -> "np.ndarray":
    """The same buffer (H, W, S, S) as a table of groups (H, W, groups, samples in a group)."""
    height, width, sampling, _ = samples.shape
    lanes = rows_at_once(sampling) * sampling
    return samples.reshape(height, width, sampling * sampling // lanes, lanes)
