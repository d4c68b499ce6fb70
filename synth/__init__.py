"""The virtual soil bin: scenes in, pictures and the truth about them out."""

import importlib
from typing import TYPE_CHECKING, Any

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


def __getattr__(name: str) -> Any:
    """Import a public name on its first use: heavy libraries load only where needed."""
    if name not in _HOMES:
        raise AttributeError(f"module 'synth' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    """Public names, imported or not yet."""
    return sorted([*globals(), *__all__])
