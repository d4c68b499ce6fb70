"""Why flow is wrong where it is: what the truth tells about a pixel."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

NEAR_IMPLEMENT = 3.0
"""px."""
NEAR_BREAK = 4.0
"""px."""
RETURNS_WITHIN = 0.3
"""px; what was seen at a pixel and is seen in the second picture comes back to it as near."""


def causes_in(folder: Path, threads: int | None = None) -> dict[str, np.ndarray]:
    """Masks (H, W) bool by cause, of the middle picture pair of a run folder; a pixel may have several.

    Parameters
    ----------
    folder : Path
        With footage, recording and scene.
    """
    from synth import load_scene
    from synth.footage import Footage
    from synth.recording import Recording
    from synth.truth import true_motion

    with Footage.open(folder / "footage") as footage:
        pair = footage.pair_count // 2
        truth = footage.truth(pair).load()
    recording, scene = Recording.read(folder / "recording.nc"), load_scene(folder / "scene.toml")
    back = true_motion(recording, scene, pair + 1, pair, threads=threads)
    return {
        f"within {NEAR_IMPLEMENT:g} px of the implement": (
            truth["distance_to_implement"].values <= NEAR_IMPLEMENT
        ),
        f"within {NEAR_BREAK:g} px of a break": truth["distance_to_discontinuity"].values <= NEAR_BREAK,
        "mixed": truth["mixed"].values,
        "hidden in the second picture": hidden(truth, back),
    }


def hidden(truth: "xr.Dataset", back: "xr.Dataset") -> np.ndarray:
    """Pixels whose grain is not what the second picture shows where it has gone: (H, W) bool.

    Parameters
    ----------
    truth, back : xarray.Dataset
        `u`, `v` (px) over `y, x`: from the first picture to the second on the first one's pixels, and from
        the second to the first on the second one's.
    """
    u, v = truth["u"].values, truth["v"].values
    height, width = u.shape
    y, x = np.mgrid[:height, :width]
    column = np.clip(np.nan_to_num(np.rint(x + u)), 0, width - 1).astype(int)
    row = np.clip(np.nan_to_num(np.rint(y + v)), 0, height - 1).astype(int)
    off_u, off_v = u + back["u"].values[row, column], v + back["v"].values[row, column]
    return ~(np.hypot(off_u, off_v) <= RETURNS_WITHIN)
