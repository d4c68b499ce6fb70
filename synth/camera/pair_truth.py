"""The truth of one pair of frames, from what covers the first one and how the grains move to the second."""

import math
from typing import TYPE_CHECKING

from synth.camera.discontinuities import discontinuities
from synth.camera.tiles import TILE
from synth.truth import MIXED_LIMIT, VARIABLES, PairTruth

if TYPE_CHECKING:
    import numpy as np

    from synth.camera.cover import Cover
    from synth.camera.implement_face import ImplementFace
    from synth.camera.motion import Motion, Placement
    from synth.camera.view import View
    from synth.recording import Recording
    from synth.scene import Scene


def pair_truth(
    scene: "Scene",
    recording: "Recording",
    covered: "Cover",
    motion: "Motion",
    placement: "Placement",
    next_placement: "Placement",
    *,
    arrays: "dict[str, np.ndarray] | None" = None,
) -> PairTruth:
    """Truth from the frame of `covered` and `placement` to that of `next_placement`.

    Parameters
    ----------
    arrays : dict, optional
        The variables of `VARIABLES`, (H, W) each, to be overwritten and used for the result.
    """
    import numpy as np

    from synth.camera.implement_face import face_of
    from synth.camera.view import View

    first, second = placement.frame, next_placement.frame
    next_view = View.of(scene, recording, second)
    next_face = face_of(scene, recording, second, next_view)
    moved, spread = _grain_motions(covered, placement, next_placement, next_view)
    if arrays is None:
        shape = covered.centres.shape
        arrays = {name: np.empty(shape, dtype) for name, (dtype, _, _) in VARIABLES.items()}
    _fill_in_soil(arrays, covered, motion, placement, second, moved)
    if covered.face is not None and next_face is not None:
        add_implement(arrays, covered.face, next_face)
    _find_mixed(arrays, covered, moved, spread, next_face)
    discontinuities(arrays["u"], arrays["v"], arrays["implement"], found=arrays)
    if second - first != 1:
        arrays["strain_rate"] /= abs(second - first)
        arrays["rotation"] /= second - first
    return PairTruth(first, second, arrays, _camera_motion(covered.view, next_view))


def _camera_motion(view: "View", next_view: "View") -> dict[str, float]:
    """Where the point that was on the optical axis has gone to, by the camera's motion alone."""
    axis = view.axis_x, view.axis_z
    before, after = view.to_ideal(*axis), next_view.to_ideal(*axis)
    return {"camera_u": after[0] - before[0], "camera_v": after[1] - before[1]}


def _grain_motions(
    covered: "Cover", placement: "Placement", other: "Placement", next_view: "View"
) -> "tuple[np.ndarray, np.ndarray]":
    """Motion of every tiled grain, (n, 4) float32, and its spread in blocks: see `motion_kernels.py`."""
    import numpy as np

    from synth.camera import motion_kernels
    from synth.camera.exchange import still_there

    tiled, across = covered.tiled, TILE // motion_kernels.BLOCK
    blocks = (len(tiled.first) - 1) // tiled.columns * across, tiled.columns * across
    motion, spread = np.empty((len(tiled.grain), 4), np.float32), np.empty(blocks, np.float32)
    scratch = np.empty((2, *blocks, 4), np.float32)
    motion_kernels.grain_motions(
        tiled.first,
        tiled.columns,
        tiled.grain,
        tiled.place,
        *(placement.x, placement.z, placement.angle),
        *(other.x, other.z, other.angle, still_there(placement, other)),
        motion_kernels.projection.numbers(covered.view.numbers),
        motion_kernels.projection.numbers(next_view.numbers),
        TILE,
        covered.sampling,
        0.99 * MIXED_LIMIT,
        motion,
        *scratch,
        spread,
    )
    return motion, spread


def _fill_in_soil(
    arrays: "dict[str, np.ndarray]",
    covered: "Cover",
    motion: "Motion",
    placement: "Placement",
    second: int,
    moved: "np.ndarray",
) -> None:
    """Fill in the truth where soil is seen; what is an implement's is still to be filled in."""
    import numpy as np

    from synth.camera import cover_kernels, motion_kernels

    filled, off, seen = filled_voids(covered)
    around = motion.surroundings(placement, second, covered.tiled.grain, seen)
    names = ("u", "v", "rotation", "strain_rate", "particle_id")
    motion_kernels.soil_motion(
        filled,
        off,
        moved,
        around.strain,
        around.particle,
        *(arrays[name] for name in names),
        arrays["valid"].view(np.uint8),
    )
    arrays["soil"][:] = covered.soil
    np.equal(covered.centres, cover_kernels.IMPLEMENT, out=arrays["implement"])
    arrays["distance_to_implement"].fill(np.inf)


def filled_voids(covered: "Cover") -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
    """Tiled grain at every pixel centre or, in a void, beside it (-1: none), (H, W); more see below.

    The pixel's centre from the grain's, px, (H, W, 2); and which tiled grains these are, (seen,).
    """
    import numpy as np

    from synth.camera import void_kernels
    from synth.camera.cover import VOID_REACH

    filled, seen = np.empty_like(covered.centres), np.zeros(len(covered.tiled.grain), np.uint8)
    off = np.empty((*filled.shape, 2), np.float32)
    void_kernels.fill_voids(
        covered.centres,
        covered.soil.view(np.uint8),
        covered.samples,
        covered.tiled.place,
        TILE,
        covered.tiled.index_mask,
        covered.sampling,
        covered.margin,
        float(VOID_REACH),
        filled,
        off,
        seen,
    )
    return filled, off, np.flatnonzero(seen.view(bool)).astype(np.int32)


def add_implement(arrays: "dict[str, np.ndarray]", face: "ImplementFace", next_face: "ImplementFace") -> None:
    """Fill in the implement's own motion at its pixels, and the distance to it everywhere."""
    import numpy as np

    from synth.camera import motion_kernels

    motion_kernels.implement_motion(
        arrays["implement"].view(np.uint8),
        motion_kernels.body_vector((face.x, face.y, *_rigid_motion(face, next_face))),
        next_face.angle - face.angle,
        _bending(face, next_face, arrays["implement"]),
        motion_kernels.projection.numbers(face.view.numbers),
        motion_kernels.projection.numbers(next_face.view.numbers),
        *(arrays[name] for name in ("u", "v", "rotation", "strain_rate")),
        arrays["valid"].view(np.uint8),
    )
    face.distance(arrays["distance_to_implement"])


def _bending(face: "ImplementFace", next_face: "ImplementFace", mask: "np.ndarray") -> "np.ndarray":
    """What an elastic rim adds to the rigid motion where the mask is, px, (H, W, 2); (1, 1, 2) if rigid."""
    import numpy as np

    from synth.camera import rim_face

    if len(face.rim) == 1:
        return np.zeros((1, 1, 2))
    rows, columns = np.nonzero(mask)
    off_x, off_y = np.subtract(face.view.undistorted(columns, rows), ((face.x,), (face.y,)))
    points = _turned(np.stack([off_x, off_y], axis=1), -face.angle)
    following = rim_face.deformed_points(next_face.rim, rim_face.material_points(face.rim, points))
    bent = np.zeros((*mask.shape, 2))
    bent[rows, columns] = _turned(following - points, next_face.angle)
    return bent


def _turned(points: "np.ndarray", angle: float) -> "np.ndarray":
    """Points (n, 2) turned from x towards y."""
    import numpy as np

    sine, cosine = np.sin(angle), np.cos(angle)
    return points @ np.array([[cosine, sine], [-sine, cosine]])


def _rigid_motion(face: "ImplementFace", next_face: "ImplementFace") -> tuple[float, float, float, float]:
    """Displacement of the axle (px), cos - 1 and sin of the turn."""
    turn = next_face.angle - face.angle
    return next_face.x - face.x, next_face.y - face.y, -2 * math.sin(turn / 2) ** 2, math.sin(turn)


def _find_mixed(
    arrays: "dict[str, np.ndarray]",
    covered: "Cover",
    moved: "np.ndarray",
    spread: "np.ndarray",
    next_face: "ImplementFace | None",
) -> None:
    import numpy as np

    from synth.camera import mixed_kernels

    face = covered.face
    body = (0.0,) * 6
    if face is not None and next_face is not None:
        body = (face.x, face.y, *_rigid_motion(face, next_face))
    mixed_kernels.find_mixed(
        covered.samples,
        covered.tiled.place,
        moved,
        spread,
        arrays["distance_to_implement"],
        mixed_kernels.body_vector(body),
        mixed_kernels.projection.numbers(covered.view.numbers),
        TILE,
        covered.tiled.index_mask,
        covered.sampling,
        covered.margin,
        MIXED_LIMIT,
        arrays["mixed"].view(np.uint8),
    )
