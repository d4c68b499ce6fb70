"""The virtual soil bin: scenes in, pictures and the truth about them out."""

from typing import TYPE_CHECKING

from synth.lazy_names import lazy_names

if TYPE_CHECKING:
    from synth.analytic.pair import PicturePair, picture_pair
    from synth.footage import Footage
    from synth.recording import Recording
    from synth.rendering import render
    from synth.scene import AnalyticScene, AnyScene, Scene, SceneError, load_scene
    from synth.scene_files import scene_names
    from synth.simulation import simulate
    from synth.truth import true_motion

_HOMES = {
    "AnalyticScene": "synth.scene",
    "AnyScene": "synth.scene",
    "Footage": "synth.footage",
    "PicturePair": "synth.analytic.pair",
    "Recording": "synth.recording",
    "Scene": "synth.scene",
    "SceneError": "synth.scene",
    "load_scene": "synth.scene",
    "picture_pair": "synth.analytic.pair",
    "render": "synth.rendering",
    "scene_names": "synth.scene_files",
    "simulate": "synth.simulation",
    "true_motion": "synth.truth",
}
__all__ = [
    "AnalyticScene",
    "AnyScene",
    "Footage",
    "PicturePair",
    "Recording",
    "Scene",
    "SceneError",
    "load_scene",
    "picture_pair",
    "render",
    "scene_names",
    "simulate",
    "true_motion",
]

__getattr__, __dir__ = lazy_names(__name__, _HOMES)
