"""Motion over the exposure: a picture is the mean of the light at instants while the shutter is open."""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from synth.camera.nuisance import states_at

if TYPE_CHECKING:
    from synth.camera.motion import Motion, Placement
    from synth.recording import Recording

_INSTANTS = 8
"""While the shutter is open: half a pixel apart where it moves by 4 px meanwhile."""


def instants(
    recording: "Recording",
    motion: "Motion",
    placement: "Placement",
    previous: "Placement | None",
    exposure: float,
) -> "Iterator[tuple[Recording, Placement]]":
    """States in the middle of equal parts of an exposure, half of which lies before and half after the frame.

    Between frames everything moves on straight lines, before the first and after the last one as beside them.
    Each placement's frame is the number of its state in the recording beside it.

    Parameters
    ----------
    previous : Placement or None
        One frame earlier; None in the first frame.
    exposure : float
        Time the shutter is open / time between two frames.
    """
    shift = exposure * ((np.arange(_INSTANTS) + 0.5) / _INSTANTS - 0.5)
    states = states_at(recording, placement.frame + shift)
    after = motion.advance(placement) if placement.frame + 1 < recording.frame_count else None
    for k, share in enumerate(shift):
        earlier, later = previous or placement, after or placement
        if after is None or (share < 0 and previous is not None):
            start, end = earlier, placement
        else:
            start, end = placement, later
        x, z, angle = (
            getattr(placement, name) + share * (getattr(end, name) - getattr(start, name))
            for name in ("x", "z", "angle")
        )
        yield states, replace(placement, frame=k, x=x, z=z, angle=angle)
