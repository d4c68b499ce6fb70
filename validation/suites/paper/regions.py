"""Moving soil of a pair: as measured, by another camera motion, and in truth."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from validation.pair_view import true_motion
from validation.scoring.nodes import stacked

if TYPE_CHECKING:
    import xarray as xr

    from synth import Footage

WAYS = ("measured", "mode", "true")
"""By the camera's motion as the paper finds it (median over soil), by what most soil shares, and in truth."""


@dataclass(frozen=True, eq=False)
class MovingSoil:
    """Inertial motion of soil.

    Attributes
    ----------
    displacement : (H, W, 2) array
        Px, x right and y down; NaN where there is no soil or it is not known.
    soil, moving : (H, W) bool array
    """

    displacement: np.ndarray
    soil: np.ndarray
    moving: np.ndarray


def moving_soil(footage: "Footage", flow: "xr.Dataset") -> Iterator[dict[str, MovingSoil]]:
    """Moving soil of every pair, in each of WAYS; all cluster speeds alike (section 2.3)."""
    for pair in range(flow.sizes["pair"]):
        found = flow.isel(pair=pair).load()
        yield {
            "measured": _measured(found),
            "mode": _by_mode(found),
            "true": _true(footage.truth(pair)),
        }


def _measured(found: "xr.Dataset") -> MovingSoil:
    from soft import motion_of_pair

    motion = motion_of_pair(found.expand_dims("pair"))
    return MovingSoil(motion.displacement, motion.soil, motion.moving)


def _by_mode(found: "xr.Dataset") -> MovingSoil:
    from soft import to_inertial

    soil = found["soil"].values.astype(bool) & found["valid"].values.astype(bool)
    return _clustered(to_inertial(stacked(found, "u", "v"), soil, camera="mode").displacement, soil)


def _true(truth: "xr.Dataset") -> MovingSoil:
    motion = true_motion(truth)
    return _clustered(np.stack([motion.u, motion.v], axis=-1), np.isfinite(motion.u))


def _clustered(displacement: np.ndarray, soil: np.ndarray) -> MovingSoil:
    from soft import moving_mask

    displacement = np.where(soil[..., np.newaxis], displacement, np.nan)
    moving = moving_mask(np.hypot(displacement[..., 0], displacement[..., 1]), soil)
    return MovingSoil(displacement, soil, moving.mask)
