"""The motion at every pixel: what is seen at a pixel's centre in one frame, and where it goes to in another.

What a pixel shows is the micro-grain that covers its centre, and that moves as a rigid body. A void between
grains is seen by the grains around it: its pixels have the motion of the visible grain whose rim is nearest.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from synth.camera.cover import Cover
    from synth.camera.implement_face import ImplementFace
    from synth.camera.motion import Motion, Placement, Surroundings
    from synth.camera.texture import MicroGrains
    from synth.camera.view import View
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
    truth = pair_truth(scene, recording, grains, covered, motion, placements[first], placements[second])
    return _dataset(truth, recording, scene)


def grains_and_motion(recording: "Recording", scene: "Scene") -> "tuple[MicroGrains, Motion]":
    """Micro-grains of a recording's first frame and the way they move. Taichi must have been started."""
    from synth.camera.motion import motion_of
    from synth.camera.soil_region import first_region
    from synth.camera.texture import strew

    grains = strew(scene, first_region(recording, scene))
    return grains, motion_of(scene, recording, grains)


def pair_truth(
    scene: "Scene",
    recording: "Recording",
    grains: "MicroGrains",
    covered: "Cover",
    motion: "Motion",
    placement: "Placement",
    next_placement: "Placement",
) -> PairTruth:
    """Truth from the frame of `covered` and `placement` to that of `next_placement`."""
    import numpy as np

    from synth.camera.exchange import still_there
    from synth.camera.implement_face import face_of
    from synth.camera.view import View

    first, second = placement.frame, next_placement.frame
    view, next_view = covered.view, View.of(scene, recording, second)
    next_face = face_of(scene, recording, second, next_view)
    there = still_there(placement, next_placement)
    moved = _rigid_motions(covered, grains.diameter, _states(placement, next_placement, there), next_view)
    filled = _filled_voids(covered)
    seen = np.zeros(grains.count, np.uint8)
    seen[covered.tiled.grain[filled[filled >= 0]]] = 1
    around = motion.surroundings(placement, second, seen)
    arrays = _motion_arrays(covered, placement, moved, next_face, filled, around)
    arrays["mixed"] = _mixed(covered, moved, next_face, arrays["distance_to_implement"])
    arrays.update(_discontinuities(arrays))
    arrays["strain_rate"] /= abs(second - first)
    arrays["rotation"] /= second - first
    return PairTruth(first, second, arrays, _camera_motion(view, next_view))


def _states(placement: "Placement", other: "Placement", there: "np.ndarray") -> "tuple[np.ndarray, ...]":
    """What kernels need of the grains: where they are, where they will be, and whether they still are."""
    return (placement.x, placement.z, placement.angle, other.x, other.z, other.angle, there)


def _camera_motion(view: "View", next_view: "View") -> dict[str, float]:
    """Where the point that was on the optical axis has gone to, by the camera's motion alone."""
    axis = view.axis_x, view.axis_z
    before, after = view.to_ideal(*axis), next_view.to_ideal(*axis)
    return {"camera_u": after[0] - before[0], "camera_v": after[1] - before[1]}


def _placements(motion: "Motion", frames: set[int]) -> "dict[int, Placement]":
    placement = motion.start()
    kept = {}
    while True:
        if placement.frame in frames:
            kept[placement.frame] = placement
        if len(kept) == len(frames):
            return kept
        placement = motion.advance(placement)


def _rigid_motions(
    covered: "Cover", diameter: "np.ndarray", states: "tuple[np.ndarray, ...]", next_view: "View"
) -> "np.ndarray":
    """Motion of every grain, (grain, 4) float32: see `truth_kernels.rigid_motions`."""
    import numpy as np

    from synth.camera import truth_kernels

    motion = np.empty((len(diameter), 4), np.float32)
    truth_kernels.rigid_motions(
        diameter,
        *states,
        truth_kernels.projection.numbers(covered.view.numbers),
        truth_kernels.projection.numbers(next_view.numbers),
        motion,
    )
    return motion


def _motion_arrays(
    covered: "Cover",
    placement: "Placement",
    motion: "np.ndarray",
    next_face: "ImplementFace | None",
    filled: "np.ndarray",
    surroundings: "Surroundings",
) -> "dict[str, np.ndarray]":
    import numpy as np

    from synth.camera import cover_kernels, truth_kernels

    shape = covered.centres.shape
    arrays: dict[str, np.ndarray] = {
        name: np.empty(shape, np.float32) for name in ("u", "v", "rotation", "strain_rate")
    }
    arrays["particle_id"] = np.empty(shape, np.int32)
    truth_kernels.grain_motion(
        filled,
        covered.tiled.grain,
        placement.x,
        placement.z,
        motion,
        truth_kernels.projection.numbers(covered.view.numbers),
        surroundings.strain,
        surroundings.particle,
        arrays["u"],
        arrays["v"],
        arrays["rotation"],
        arrays["strain_rate"],
        arrays["particle_id"],
    )
    arrays["soil"] = covered.soil
    arrays["implement"] = covered.centres == cover_kernels.IMPLEMENT
    arrays["distance_to_implement"] = np.full(shape, np.inf, np.float32)
    if covered.face is not None and next_face is not None:
        _add_implement(arrays, covered.face, next_face)
    arrays["valid"] = _lands_inside(arrays["u"], arrays["v"])
    return arrays


def _lands_inside(u: "np.ndarray", v: "np.ndarray") -> "np.ndarray":
    """Whether a motion ends between the outermost pixel centres of the second picture; False for NaN."""
    import numpy as np

    height, width = u.shape
    x, y = np.arange(width, dtype=np.float32) + u, np.arange(height, dtype=np.float32)[:, None] + v
    return (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)


def _filled_voids(covered: "Cover") -> "np.ndarray":
    """Place among the tiled grains of the one at every pixel centre or, in a void, beside it; -1: none."""
    import numpy as np

    from synth.camera import truth_kernels
    from synth.camera.cover import VOID_REACH
    from synth.camera.tiles import TILE

    filled = np.empty_like(covered.centres)
    truth_kernels.fill_voids(
        covered.centres,
        covered.soil.view(np.uint8),
        covered.samples,
        covered.tiled.place,
        covered.tiled.columns,
        TILE,
        covered.tiled.index_mask,
        covered.sampling,
        covered.margin,
        float(VOID_REACH),
        filled,
    )
    return filled


def _add_implement(
    arrays: "dict[str, np.ndarray]", face: "ImplementFace", next_face: "ImplementFace"
) -> None:
    """Fill in the implement's own motion at its pixels, and the distance to it everywhere."""
    import numpy as np

    mask = arrays["implement"]
    rows, columns = np.nonzero(mask)
    ideal_x, ideal_y = face.view.undistorted(columns, rows)
    off_x, off_y = ideal_x - face.x, ideal_y - face.y
    move_x, move_y, cosine_less_one, sine = _rigid_motion(face, next_face)
    bent_x, bent_y = _bending(face, next_face, off_x, off_y)
    to_x = ideal_x + move_x + cosine_less_one * off_x - sine * off_y + bent_x
    to_y = ideal_y + move_y + sine * off_x + cosine_less_one * off_y + bent_y
    to_x, to_y = next_face.view.distorted(to_x, to_y)
    arrays["u"][mask], arrays["v"][mask] = to_x - columns, to_y - rows
    arrays["rotation"][mask] = next_face.angle - face.angle
    arrays["strain_rate"][mask] = 0
    arrays["distance_to_implement"] = face.distance()


def _bending(
    face: "ImplementFace", next_face: "ImplementFace", off_x: "np.ndarray", off_y: "np.ndarray"
) -> "np.ndarray":
    """What an elastic rim adds to the rigid motion at offsets from the axle, px, shape (2, n)."""
    import numpy as np

    from synth.camera import rim_face

    if len(face.rim) == 1:
        return np.zeros((2, 1))
    points = _turned(np.stack([off_x, off_y], axis=1), -face.angle)
    following = rim_face.deformed_points(next_face.rim, rim_face.material_points(face.rim, points))
    return _turned(following - points, next_face.angle).T


def _turned(points: "np.ndarray", angle: float) -> "np.ndarray":
    """Points (n, 2) turned from x towards y."""
    import numpy as np

    sine, cosine = np.sin(angle), np.cos(angle)
    return points @ np.array([[cosine, sine], [-sine, cosine]])


def _rigid_motion(face: "ImplementFace", next_face: "ImplementFace") -> tuple[float, float, float, float]:
    """Displacement of the axle (px), cos - 1 and sin of the turn."""
    import math

    turn = next_face.angle - face.angle
    return next_face.x - face.x, next_face.y - face.y, -2 * math.sin(turn / 2) ** 2, math.sin(turn)


def _mixed(
    covered: "Cover", motion: "np.ndarray", next_face: "ImplementFace | None", outside: "np.ndarray"
) -> "np.ndarray":
    import numpy as np

    from synth.camera import truth_kernels
    from synth.camera.tiles import TILE

    tiled, face = covered.tiled, covered.face
    body = (0.0,) * 6
    if face is not None and next_face is not None:
        body = (face.x, face.y, *_rigid_motion(face, next_face))
    mixed = np.empty(covered.centres.shape, np.uint8)
    truth_kernels.find_mixed(
        covered.samples,
        tiled.place,
        tiled.grain,
        motion,
        _spread_in_blocks(covered, motion),
        outside,
        truth_kernels.body_vector(body),
        truth_kernels.projection.numbers(covered.view.numbers),
        TILE,
        tiled.index_mask,
        covered.sampling,
        covered.margin,
        MIXED_LIMIT,
        mixed,
    )
    return mixed.view(bool)


def _spread_in_blocks(covered: "Cover", motion: "np.ndarray") -> "np.ndarray":
    """See `truth_kernels.spread_in_blocks`."""
    import numpy as np

    from synth.camera import truth_kernels
    from synth.camera.tiles import TILE

    tiled, across = covered.tiled, TILE // truth_kernels.BLOCK
    rows = (len(tiled.first) - 1) // tiled.columns
    spread = np.empty((rows * across, tiled.columns * across), np.float32)
    scratch = np.empty((2, spread.size, 4), np.float32)
    truth_kernels.spread_in_blocks(
        tiled.first,
        tiled.columns,
        tiled.grain,
        tiled.place,
        motion,
        TILE,
        covered.sampling,
        scratch[0],
        scratch[1],
        spread,
    )
    return spread


def _discontinuities(arrays: "dict[str, np.ndarray]") -> "dict[str, np.ndarray]":
    """Distance to the nearest discontinuity, and the jump there.

    A discontinuity lies half-way between two pixels, half a pixel from each.
    """
    import numpy as np

    from synth.camera import discontinuity_kernels

    shape = arrays["u"].shape
    jump = np.empty(shape, np.float32)
    discontinuity_kernels.find_jumps(
        arrays["u"], arrays["v"], arrays["implement"].view(np.uint8), JUMP_LIMIT, jump
    )
    row = np.empty(shape, np.int32)
    discontinuity_kernels.nearest_in_column(jump, row)
    distance = np.full(shape, np.inf, np.float32)
    nearest_jump = np.full(shape, np.nan, np.float32)
    discontinuity_kernels.nearest_in_picture(
        row, jump, np.empty(shape, np.int32), np.empty(shape, np.float64), distance, nearest_jump
    )
    return {"distance_to_discontinuity": distance + np.float32(0.5), "discontinuity_jump": nearest_jump}


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
