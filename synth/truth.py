"""The motion at every pixel: what is seen at a pixel's centre in one frame, and where it goes to in another.

What a pixel shows is the micro-grain that covers its centre, and that moves as a rigid body. A void between
grains is seen by the grains around it: its pixels have the motion of the visible grain whose rim is nearest.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from synth.camera.motion import Motion, Placement
    from synth.camera.texture import MicroGrains
    from synth.recording import Recording
    from synth.scene import AnyScene, Scene

SCHEMA_VERSION = 1
MIXED_LIMIT = 0.1
"""px; a pixel that holds motions further apart is mixed."""
JUMP_LIMIT = 0.5
"""px; neighbouring pixels whose motions differ by more have a discontinuity between them."""

# name: (data type, unit, meaning)
VARIABLES = {
    "u": (
        "float32",
        "px",
        "displacement to the right of what is seen at the pixel's centre, first to second frame",
    ),
    "v": (
        "float32",
        "px",
        "displacement downwards of what is seen at the pixel's centre, first to second frame",
    ),
    "valid": (
        "bool",
        "1",
        "could be measured: soil or implement, not lost before the second frame, and in that picture still",
    ),
    "soil": ("bool", "1", "the pixel's centre shows soil or a void in it"),
    "implement": ("bool", "1", "the pixel's centre shows the implement"),
    "mixed": ("bool", "1", f"the pixel holds motions more than {MIXED_LIMIT} px apart"),
    "particle_id": (
        "int32",
        "1",
        "simulated particle that the micro-grain moves with or is nearest to; -1: none",
    ),
    "distance_to_implement": (
        "float32",
        "px",
        "from the pixel's centre; 0 on the implement, infinite without one",
    ),
    "distance_to_discontinuity": (
        "float32",
        "px",
        f"from the pixel's centre to the nearest neighbours that move more than {JUMP_LIMIT} px apart, or of "
        "which one is the implement; infinite where there are none",
    ),
    "discontinuity_jump": (
        "float32",
        "px",
        "difference of motion at the nearest discontinuity; NaN without one",
    ),
    "strain_rate": (
        "float32",
        "1/frame",
        "equivalent shear strain sqrt(2 e:e) of the particles' motion a frame, e the deviator of the "
        "symmetric displacement gradient: gamma for simple shear, 0 for a rigid rotation",
    ),
    "rotation": (
        "float32",
        "rad/frame",
        "rotation a frame of what is seen, from x (right) to y (down): positive is clockwise in the picture",
    ),
}

# name: (unit, meaning); one value a pair
CAMERA_VARIABLES = {
    "camera_u": ("px", "displacement to the right that the camera's own motion gives to what rests"),
    "camera_v": ("px", "displacement downwards that the camera's own motion gives to what rests"),
}


@dataclass(frozen=True)
class PairTruth:
    """The truth of one pair of frames.

    Attributes
    ----------
    first, second : int
        Frames.
    arrays : dict
        The variables of `VARIABLES`, (H, W) each.
    camera : dict
        The variables of `CAMERA_VARIABLES`.
    """

    first: int
    second: int
    arrays: "dict[str, np.ndarray]"
    camera: dict[str, float]


def true_motion(
    recording: "Recording",
    scene: "AnyScene",
    first: int,
    second: int,
    *,
    device: str = "cpu",
    threads: int | None = None,
) -> "xr.Dataset":
    """Truth between any two frames of a recording, forwards or backwards, on the first one's pixels.

    Parameters
    ----------
    recording : Recording
    scene : AnyScene
        The scene the recording was made with; its seed makes the texture.
    first, second : int
        Different frames, 0 to `recording.frame_count - 1`.
    device, threads
        As in `synth.devices.start_taichi`.

    Returns
    -------
    xarray.Dataset
        The variables of `VARIABLES` over y and x; scalar coordinates first_frame, second_frame and time.

    Raises
    ------
    ValueError
        A frame that is not recorded, or twice the same one.
    """
    from synth.camera.cover import cover
    from synth.camera.exchange import grains_at
    from synth.camera.nuisance import as_seen
    from synth.camera.pair_truth import pair_truth
    from synth.devices import start_taichi
    from synth.scene import AnalyticScene

    for frame in (first, second):
        if not 0 <= frame < recording.frame_count:
            raise ValueError(f"frame = {frame}: allowed are 0 to {recording.frame_count - 1}")
    if first == second:
        raise ValueError(f"second = {second}: another frame than the first is needed")
    if isinstance(scene, AnalyticScene):
        from synth.analytic.truth import analytic_truth

        return _dataset(analytic_truth(scene, first, second), recording, scene)
    start_taichi(device, threads)
    recording = as_seen(recording, scene)
    grains, motion = grains_and_motion(recording, scene)
    placements = _placements(motion, {first, second})
    covered = cover(scene, recording, grains_at(grains, placements[first]), placements[first])
    truth = pair_truth(scene, recording, covered, motion, placements[first], placements[second])
    return _dataset(truth, recording, scene)


def grains_and_motion(recording: "Recording", scene: "Scene") -> "tuple[MicroGrains, Motion]":
    """Micro-grains of a recording's first frame and the way they move. Taichi must have been started."""
    from synth.camera.motion import motion_of
    from synth.camera.soil_region import first_region
    from synth.camera.texture import strew

    grains = strew(scene, first_region(recording, scene))
    return grains, motion_of(scene, recording, grains)


def _placements(motion: "Motion", frames: set[int]) -> "dict[int, Placement]":
    placement = motion.start()
    kept = {}
    while True:
        if placement.frame in frames:
            kept[placement.frame] = placement
        if len(kept) == len(frames):
            return kept
        placement = motion.advance(placement)


def _dataset(truth: PairTruth, recording: "Recording", scene: "AnyScene") -> "xr.Dataset":
    import xarray as xr

    variables: dict[str, Any] = {
        name: (("y", "x"), truth.arrays[name], {"units": unit, "long_name": meaning})
        for name, (_, unit, meaning) in VARIABLES.items()
    }
    for name, (unit, meaning) in CAMERA_VARIABLES.items():
        variables[name] = ((), truth.camera[name], {"units": unit, "long_name": meaning})
    coordinates = {
        "first_frame": truth.first,
        "second_frame": truth.second,
        "time": float(recording.data["time"].values[truth.first]),
    }
    return xr.Dataset(variables, coordinates, file_attributes(scene))


def file_attributes(scene: "AnyScene") -> dict[str, Any]:
    """Attributes that a stranger needs to read the truth without the scene."""
    return {
        "schema_version": SCHEMA_VERSION,
        "title": f"True displacement at every pixel of the footage of the scene {scene.name!r}",
        "scene": scene.name,
        "scene_hash": scene.hash,
        "seed": scene.seed,
        "quick": int(scene.quick),
        "license": scene.data_licence,
        "frame_rate": scene.timing.frame_rate,
        "metres_per_pixel": scene.camera.metres_per_pixel,
        "frame": "x right, y down, integer at pixel centres; displacements forward, on the first frame",
    }
