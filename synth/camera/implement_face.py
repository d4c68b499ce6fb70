"""The implement as the camera sees it: its side against the glass."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from synth.camera.view import View
from synth.implements import RigidWheel

if TYPE_CHECKING:
    import numpy as np

    from synth.recording import Recording
    from synth.scene import Scene


@dataclass(frozen=True)
class ImplementFace:
    """A wheel's side in the picture.

    Attributes
    ----------
    x, y : float
        Axle, px.
    radius : float
        px.
    angle : float
        From x towards y of the picture, rad.
    """

    x: float
    y: float
    radius: float
    angle: float

    def moved(self, x: float, y: float) -> "ImplementFace":
        """Shift by `x`, `y` px."""
        return replace(self, x=self.x + x, y=self.y + y)

    def distance(self, width: int, height: int) -> "np.ndarray":
        """Distance of every pixel's centre to the implement, px: (H, W) float32, 0 on it."""
        import numpy as np

        column = np.arange(width, dtype=np.float64) - self.x
        row = np.arange(height, dtype=np.float64) - self.y
        distance = np.sqrt(column[None, :] ** 2 + row[:, None] ** 2) - self.radius
        return np.maximum(distance, 0).astype(np.float32)


def face_of(scene: "Scene", recording: "Recording", frame: int, view: View) -> ImplementFace | None:
    """Side of a scene's implement at a frame; None where it cannot be seen, as a plate under its soil."""
    if not isinstance(scene.implement, RigidWheel):
        return None
    data = recording.data
    x, y = view.to_image(float(data["implement_x"].values[frame]), float(data["implement_z"].values[frame]))
    angle = view.angle_to_image(float(data["implement_angle"].values[frame]))
    return ImplementFace(x, y, view.length_to_image(scene.implement.radius), angle)
