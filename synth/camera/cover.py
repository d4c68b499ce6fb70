"""What covers every sample and every pixel's centre of a frame."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from synth.camera.implement_face import ImplementFace, face_of
from synth.camera.samples import in_groups
from synth.camera.tiles import TILE, TiledGrains, sort_into_tiles
from synth.camera.view import View

if TYPE_CHECKING:
    import numpy as np

    from synth.camera.hiding import Hiders
    from synth.camera.motion import Placement
    from synth.camera.texture import MicroGrains
    from synth.recording import Recording
    from synth.scene import Scene

VOID_REACH = 3
"""px; a void that a disc of this radius fits in is no longer the soil's: it is air."""


@dataclass(frozen=True, eq=False)
class Cover:
    """What is in front at a frame.

    Attributes
    ----------
    view : View
    tiled : TiledGrains
    face : ImplementFace or None
    samples : (H + 2 margin, W + 2 margin, S, S) int32
        Every pixel's samples, by row and column: key of the foremost micro-grain,
        `cover_kernels.IMPLEMENT` or `cover_kernels.NOTHING`.
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
    tiled: TiledGrains
    face: ImplementFace | None
    samples: "np.ndarray"
    centres: "np.ndarray"
    soil: "np.ndarray"
    sampling: int
    margin: int


def cover(
    scene: "Scene",
    recording: "Recording",
    grains: "MicroGrains",
    placement: "Placement",
    *,
    hiders: "Hiders | None" = None,
    reuse: Cover | None = None,
    picture: int | None = None,
) -> Cover:
    """Put micro-grains and implement in front of each other at a frame.

    Parameters
    ----------
    hiders : Hiders, optional
        As in `sort_into_tiles`: makes it faster, and changes nothing that is seen.
    reuse : Cover, optional
        One of the same scene that is not needed any more: its samples are overwritten.
    picture : int, optional
        As in `View.of`.
    """
    import numpy as np

    from synth.camera import cover_kernels

    view = View.of(scene, recording, placement.frame, picture=picture)
    face = face_of(scene, recording, placement.frame, view)
    margin = max(math.ceil(4 * scene.lens.blur) + 1, VOID_REACH)
    sampling = scene.camera.supersampling
    tiled = sort_into_tiles(grains, placement, view, sampling, margin, hiders=hiders)
    shape = view.height + 2 * margin, view.width + 2 * margin
    samples = np.empty((*shape, sampling, sampling), np.int32) if reuse is None else reuse.samples
    centres = np.empty(shape, np.int32)
    cover_kernels.cover_by_grains(sampling)(
        tiled.first, tiled.columns, tiled.place, tiled.key, TILE, in_groups(samples), centres
    )
    if face is not None:
        numbers = cover_kernels.projection.numbers(view.numbers)
        cover_kernels.cover_by_implement(
            face.x, face.y, face.parts, numbers, sampling, margin, face.box(margin), samples, centres
        )
    centres = centres[margin:-margin, margin:-margin].copy()
    soil = _soil(centres)
    return Cover(view, tiled, face, samples, centres, soil, sampling, margin)


def _soil(centres: "np.ndarray") -> "np.ndarray":
    """Pixels whose centres show a grain, and the voids between grains and implement; (H, W) bool."""
    import cv2
    import numpy as np

    from synth.camera import cover_kernels

    implement = centres == cover_kernels.IMPLEMENT
    filled = (centres != cover_kernels.NOTHING).view(np.uint8)
    side = 2 * VOID_REACH + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    return cv2.morphologyEx(filled, cv2.MORPH_CLOSE, disc).view(bool) & ~implement
