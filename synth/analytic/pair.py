"""A picture pair in memory, for those who develop a method."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from synth.scene import AnalyticScene


@dataclass(frozen=True, eq=False)
class PicturePair:
    """Two pictures and what happened between them.

    Attributes
    ----------
    first, second : (H, W) array
        uint8 or uint16; float64 grey levels of 0-255 where light without noise was asked for.
    displacement : (H, W, 2) float32 array
        True motion, px, forward, on the first picture's pixels; known everywhere.
    valid : (H, W) bool array
        Where it is scored: what stays in the picture, and within the scene's `scored_radius`.
    """

    first: np.ndarray
    second: np.ndarray
    displacement: np.ndarray
    valid: np.ndarray


def picture_pair(
    scene: "AnalyticScene | str | Path",
    *,
    seed: int | None = None,
    quick: bool = False,
    first: int = 0,
    second: int | None = None,
    clean: bool = False,
) -> PicturePair:
    """Take two pictures of an analytic scene.

    Parameters
    ----------
    scene : AnalyticScene, str or Path
        A scene, or what `synth.load_scene` takes.
    seed : int, optional
        Another realisation of grains and noise.
    quick : bool
        Of a name or file: its smaller version.
    first, second : int
        Frames; by default the first two. Any whole number: a formula does not end with the recording, but
        soil that comes into view after the scene's last frame is missing.
    clean : bool
        Light without change of light, noise, rounding and clipping, instead of the sensor's grey levels.

    Raises
    ------
    ValueError
        A scene of another kind.
    """
    from synth.analytic.picture import expose, light_of, strew
    from synth.analytic.truth import displacement_of, scored
    from synth.scene import AnalyticScene, load_scene

    chosen = load_scene(scene, quick=quick) if isinstance(scene, str | Path) else scene
    if not isinstance(chosen, AnalyticScene):
        raise ValueError(f"{chosen.name}: kind = {chosen.kind!r}: an analytic scene is needed")
    if seed is not None:
        chosen = chosen.model_copy(update={"seed": seed})
    frames = first, first + 1 if second is None else second
    grains = strew(chosen)
    before, after = (light_of(chosen, grains, frame) for frame in frames)
    if not clean:
        before, after = expose(chosen, before, frames[0]), expose(chosen, after, frames[1])
    displacement = displacement_of(chosen, *frames)
    return PicturePair(before, after, displacement, scored(chosen, displacement))
