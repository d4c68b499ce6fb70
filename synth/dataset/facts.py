"""What is known of a sequence: a hash of its values, and statistics of motion and grey levels."""

import hashlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

    from synth.footage import Footage

EDGES = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
"""px, of the bins of displacement; a last bin is beyond."""
GREY_BINS = 64
"""Of grey levels, from black to full scale."""
PAIRS_LOOKED_AT = 5
"""Pairs of a sequence, evenly spread, that statistics are of."""


def sequence_facts(footage: "Footage") -> dict[str, Any]:
    """Read footage back, all of it: a hash over its values, and statistics of some pairs.

    Returns
    -------
    dict
        JSON. `digest`: SHA-256 over the pictures, then pair by pair over the camera's motion and every
        variable of the truth, in the order in which `synth.truth` names them. `displacement`: valid soil
        pixels by their motion in the inertial frame, in the bins of `EDGES`. `grey`: soil pixels by grey
        level, in `GREY_BINS`. `moving`, `complex`, `mixed`: shares of the valid soil, as strata are defined.
        `soil`, `valid`: shares of the picture.
    """
    import numpy as np

    from synth.truth import CAMERA_VARIABLES, VARIABLES

    looked_at = set(np.linspace(0, footage.pair_count - 1, PAIRS_LOOKED_AT).round().astype(int).tolist())
    digest, tally = hashlib.sha256(), _Tally()
    for frame in range(footage.frame_count):
        picture = footage.picture(frame)
        digest.update(repr((picture.shape, picture.dtype.str)).encode() + picture.tobytes())
    for pair in range(footage.pair_count):
        truth = footage.truth(pair)
        for name in (*CAMERA_VARIABLES, *VARIABLES):
            digest.update(truth[name].values.tobytes())
        if pair in looked_at:
            tally.add(footage.picture(pair), truth)
    height, width = picture.shape
    return {
        "digest": digest.hexdigest(),
        "frame_count": footage.frame_count,
        "width": width,
        "height": height,
        "bits": 8 * picture.dtype.itemsize,
        **tally.to_dict(),
    }


class _Tally:
    """Sums over pairs."""

    def __init__(self) -> None:
        self._counts = dict.fromkeys(("pixels", "soil", "valid", "all", "moving", "complex", "mixed"), 0)
        self._displacement: np.ndarray | int = 0
        self._grey: np.ndarray | int = 0

    def add(self, picture: "np.ndarray", truth: Any) -> None:
        import numpy as np

        from synth.strata import find_strata

        strata = find_strata(truth)
        known, soil = strata.masks["all"], truth["soil"].values
        self._counts["pixels"] += known.size
        self._counts["soil"] += int(soil.sum())
        self._counts["valid"] += int(truth["valid"].values.sum())
        for name in ("all", "moving", "complex", "mixed"):
            self._counts[name] += int(strata.masks[name].sum())
        speed = strata.speed[known]
        self._displacement = self._displacement + np.histogram(speed, [*EDGES, np.inf])[0]
        full_scale = np.iinfo(picture.dtype).max + 1
        self._grey = self._grey + np.histogram(picture[soil], GREY_BINS, (0, full_scale))[0]

    def to_dict(self) -> dict[str, Any]:
        """JSON; shares are of the pixels, or of known soil, 0 where there is none."""
        import numpy as np

        counts = self._counts
        shares = {name: counts[name] / counts["pixels"] for name in ("soil", "valid")}
        known = max(counts["all"], 1)
        shares |= {name: counts[name] / known for name in ("moving", "complex", "mixed")}
        return {
            **shares,
            "displacement": np.asarray(self._displacement).tolist(),
            "grey": np.asarray(self._grey).tolist(),
        }
