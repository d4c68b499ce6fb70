"""What covers every sample and every pixel's centre of a frame."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from synth.camera.implement_face import ImplementFace, face_of
from synth.camera.soil_region import soil_in_view
from synth.camera.view import View

if TYPE_CHECKING:
    import numpy as np

    from synth.camera.motion import Placement
    from synth.camera.texture import MicroGrains
    from synth.recording import Recording
    from synth.scene import Scene

VOID_REACH = 3
"""px; a void this far from every visible grain is no longer the soil's: it is air."""


@dataclass(frozen=True)
class PlacedGrains:
    """Micro-grains at a frame in the picture's coordinates; shape (grain,) each.

    Attributes
    ----------
    x, y : float64
        Centre, px.
    angle : float64
        From x towards y of the picture since the first frame, rad.
    radius : float64
        px.
    alive : uint8
    """

    x: "np.ndarray"
    y: "np.ndarray"
    angle: "np.ndarray"
    radius: "np.ndarray"
    alive: "np.ndarray"


@dataclass(frozen=True)
class Cover:
    """What is in front at a frame.

    Attributes
    ----------
    view : View
    grains : PlacedGrains
    face : ImplementFace or None
    samples : (S (H + 2 margin), S (W + 2 margin)) int32
        Depth of the foremost micro-grain, `kernels.IMPLEMENT` or `kernels.NOTHING`.
    centres : (H, W) int32
        The same at the pixels' centres, exactly.
    soil : (H, W) bool
        Where the glass shows soil or the voids in it.
    sampling : int
        Samples along each side of a pixel.
    margin : int
        px around the picture.
    """

    view: View
    grains: PlacedGrains
    face: ImplementFace | None
    samples: "np.ndarray"
    centres: "np.ndarray"
    soil: "np.ndarray"
    sampling: int
    margin: int


def place(grains: "MicroGrains", placement: "Placement", view: View) -> PlacedGrains:
    """Micro-grains in a view's coordinates."""
    x, y = view.to_image(placement.x, placement.z)
    radius = view.length_to_image(grains.diameter / 2)
    return PlacedGrains(x, y, view.angle_to_image(placement.angle), radius, placement.alive)


def cover(scene: "Scene", recording: "Recording", grains: "MicroGrains", placement: "Placement") -> Cover:
    """Put micro-grains and implement in front of each other at a frame."""
    import numpy as np

    from synth.camera import kernels

    frame = placement.frame
    view = View.of(scene.camera, recording, frame)
    face = face_of(scene, recording, frame, view)
    placed = place(grains, placement, view)
    margin = max(math.ceil(4 * scene.lens.blur) + 1, VOID_REACH)
    sampling = scene.camera.supersampling
    shape = sampling * (view.height + 2 * margin), sampling * (view.width + 2 * margin)
    samples = np.full(shape, kernels.NOTHING, np.int32)
    centres = np.full((view.height, view.width), kernels.NOTHING, np.int32)
    kernels.cover_by_grains(
        placed.x, placed.y, placed.radius, placed.alive, grains.depth, sampling, margin, samples, centres
    )
    if face is not None:
        kernels.cover_by_implement(face.x, face.y, face.parts, face.reach, sampling, margin, samples, centres)
    soil = _soil(soil_in_view(recording, frame, view, face), centres)
    return Cover(view, placed, face, samples, centres, soil, sampling, margin)


def _soil(region: "np.ndarray", centres: "np.ndarray") -> "np.ndarray":
    """Pixels whose centres show a grain, and the voids of the region close to one; (H, W) bool."""
    import cv2
    import numpy as np

    from synth.camera import kernels

    grain = (centres != kernels.NOTHING) & (centres != kernels.IMPLEMENT)
    if not grain.any():
        return grain
    away = cv2.distanceTransform((~grain).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return grain | (region & (centres == kernels.NOTHING) & (away < VOID_REACH))
