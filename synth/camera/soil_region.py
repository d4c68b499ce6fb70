"""Which part of the glass is soil at first: the particles' discs, pores closed, outline smoothed."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from synth.camera.view import View

if TYPE_CHECKING:
    import numpy as np

    from synth.camera.implement_face import ImplementFace
    from synth.recording import Recording
    from synth.scene import Scene

_PORE = 0.75
"""Pores up to this radius, in mean particle diameters, hold soil that is finer than the particles."""
_SMOOTHING = 1.5
"""Deviation, in mean particle diameters, of the Gaussian that takes the particles' bumps off the outline."""


@dataclass(frozen=True)
class SoilRegion:
    """A part of the world on a raster.

    Attributes
    ----------
    view : View
        Where the raster's pixels lie.
    mask : (H, W) bool
        True in the soil.
    """

    view: View
    mask: "np.ndarray"

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top of the raster, m."""
        return self.view.bounds()

    def contains(self, x: "np.ndarray", z: "np.ndarray") -> "np.ndarray":
        """Whether positions (m), within the bounds, lie in the soil; same shape."""
        import numpy as np

        column, row = self.view.to_image(x, z)
        column = np.clip(np.rint(column).astype(np.int32), 0, self.view.width - 1)
        row = np.clip(np.rint(row).astype(np.int32), 0, self.view.height - 1)
        return self.mask[row, column]


def first_region(recording: "Recording", scene: "Scene") -> SoilRegion:
    """Soil of the first frame that any frame shows, to be strewn with micro-grains."""
    if recording.data.sizes["particle"] == 0:
        return _plate_region(recording, scene)
    seen = _ever_seen(recording, scene)
    return _region_of(seen, recording, scene)


def _plate_region(recording: "Recording", scene: "Scene") -> SoilRegion:
    """On a plate, soil is everywhere: the circle about the pin that holds every picture, as its square."""
    import numpy as np

    pin_x = float(recording.data["implement_x"].values[0])
    pin_z = float(recording.data["implement_z"].values[0])
    reach = 0.0
    for frame in range(recording.frame_count):
        left, right, bottom, top = View.of(scene, recording, frame).bounds(_margin(scene))
        corners = [math.hypot(x - pin_x, z - pin_z) for x in (left, right) for z in (bottom, top)]
        reach = max(reach, *corners)
    view = _view_over((pin_x - reach, pin_x + reach, pin_z - reach, pin_z + reach), scene)
    return SoilRegion(view, np.ones((view.height, view.width), bool))


def _margin(scene: "Scene") -> float:
    """How far outside the picture a grain's centre may lie and still be seen, blurred, at its edge; m."""
    return scene.soil.grain_sizes.largest / 2 + (4 * scene.lens.blur + 2) * scene.camera.metres_per_pixel


def _ever_seen(recording: "Recording", scene: "Scene") -> "np.ndarray":
    """Particles that come close to the picture in some frame; (particle,) bool."""
    import numpy as np

    margin = _margin(scene) + 2 * particle_diameter(recording)
    seen = np.zeros(recording.data.sizes["particle"], bool)
    for frame in range(recording.frame_count):
        left, right, bottom, top = View.of(scene, recording, frame).bounds(margin)
        x, z = recording.states("position_x", frame), recording.states("position_z", frame)
        seen |= (x > left) & (x < right) & (z > bottom) & (z < top)
    return seen


def _region_of(seen: "np.ndarray", recording: "Recording", scene: "Scene") -> SoilRegion:
    from synth.camera.implement_face import face_of

    if not seen.any():
        raise ValueError("no particle of the recording is ever in the camera's view: see [camera]")
    x, z = recording.states("position_x", 0)[seen], recording.states("position_z", 0)[seen]
    margin = 2 * particle_diameter(recording)
    view = _view_over((x.min() - margin, x.max() + margin, z.min() - margin, z.max() + margin), scene)
    smooth = scene.texture.motion == "interpolated"
    return SoilRegion(view, _outlined(recording, view, face_of(scene, recording, 0, view), seen, smooth))


def _view_over(bounds: tuple[float, float, float, float], scene: "Scene") -> View:
    left, right, bottom, top = bounds
    pixel = scene.camera.metres_per_pixel
    width, height = math.ceil((right - left) / pixel), math.ceil((top - bottom) / pixel)
    return View(width, height, pixel, (left + right) / 2, (bottom + top) / 2)


def particle_diameter(recording: "Recording") -> float:
    """Median diameter of the simulated particles, m: that of the finest where a bed is graded."""
    return 2 * float(recording.data["radius"].median())


def _outlined(
    recording: "Recording", view: View, face: "ImplementFace | None", chosen: "np.ndarray", smooth: bool
) -> "np.ndarray":
    """Union of the first frame's discs and the implement, pores closed, less the implement; (H, W) bool.

    The implement takes part: the gaps between the round particles and its rim are pores, too. Where soil is
    finer than the particles, its outline is smooth on their scale: that where a Gaussian blur of it falls to
    a half, which keeps straight outlines in place and cuts as much off bumps as it fills of dents. Only what
    is close to particles is soil.
    """
    import cv2
    import numpy as np

    diameter = view.length_to_image(particle_diameter(recording))
    pad = math.ceil(4 * _SMOOTHING * diameter) + 2
    wide = view.padded(pad)
    mask = _discs(recording, 0, wide, chosen)
    near = _distance_to(mask) <= _PORE * diameter
    outside = np.ones_like(mask)
    if face is not None:
        outside = face.padded(pad).distance() > 0
        mask |= ~outside
    mask = _closing(mask, _PORE * diameter)
    if smooth:
        blurred = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), _SMOOTHING * diameter)
        mask = (blurred > 0.5) & near
    return (mask & outside)[pad:-pad, pad:-pad]


def _discs(recording: "Recording", frame: int, view: View, chosen: "np.ndarray") -> "np.ndarray":
    import numpy as np

    from synth.camera import cover_kernels

    column, row = view.to_image(
        recording.states("position_x", frame)[chosen].astype(np.float64),
        recording.states("position_z", frame)[chosen].astype(np.float64),
    )
    radius = view.length_to_image(recording.data["radius"].values[chosen].astype(np.float64))
    mask = np.zeros((view.height, view.width), np.uint8)
    cover_kernels.fill_discs(column, row, radius, mask)
    return mask.astype(bool)


def _closing(mask: "np.ndarray", reach: float) -> "np.ndarray":
    """Dilate, then erode by the same reach (px), by distances good to 2 %."""
    if not mask.any():
        return mask
    return mask | (_distance_to(_distance_to(mask) > reach) > reach)


def _distance_to(mask: "np.ndarray") -> "np.ndarray":
    """Distance of every pixel to the nearest one of a mask, px; good to 2 %."""
    import cv2
    import numpy as np

    return cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
