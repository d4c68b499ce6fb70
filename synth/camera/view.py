"""Between the world (m, z up) and the picture (px, y down): the one place that flips y."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from synth.camera.settings import Camera

if TYPE_CHECKING:
    from synth.recording import Recording


@dataclass(frozen=True)
class View:
    """Where a picture's pixels lie in the world.

    Integer image coordinates are at pixel centres; the optical axis is at ((width - 1) / 2,
    (height - 1) / 2). Every method takes and returns scalars or arrays alike.

    Attributes
    ----------
    width, height : int
        Size of the picture, px.
    metres_per_pixel : float
    axis_x, axis_z : float
        Where the optical axis meets the glass, m.
    """

    width: int
    height: int
    metres_per_pixel: float
    axis_x: float
    axis_z: float

    @classmethod
    def of(cls, camera: Camera, recording: "Recording", frame: int) -> "View":
        """View of a scene's camera at a frame: one that follows the carriage travels with it."""
        travel = float(recording.data["carriage_x"].values[frame]) if camera.follows == "carriage" else 0.0
        return cls(
            camera.width, camera.height, camera.metres_per_pixel, travel + camera.centre_x, camera.centre_z
        )

    def to_image(self, x: Any, z: Any) -> tuple[Any, Any]:
        """Image coordinates (px) of a world position (m)."""
        column = (x - self.axis_x) / self.metres_per_pixel + (self.width - 1) / 2
        row = (self.axis_z - z) / self.metres_per_pixel + (self.height - 1) / 2
        return column, row

    def to_world(self, column: Any, row: Any) -> tuple[Any, Any]:
        """World position (m) of image coordinates (px)."""
        x = (column - (self.width - 1) / 2) * self.metres_per_pixel + self.axis_x
        z = self.axis_z - (row - (self.height - 1) / 2) * self.metres_per_pixel
        return x, z

    def angle_to_image(self, angle: Any) -> Any:
        """Angle from x towards y in the picture (clockwise as seen) of a counter-clockwise angle, rad."""
        return -angle

    def length_to_image(self, length: Any) -> Any:
        """Length in px of a length in m."""
        return length / self.metres_per_pixel

    def bounds(self, margin: float = 0.0) -> tuple[float, float, float, float]:
        """World left, right, bottom and top (m) of the picture, wider by `margin` (m) on every side."""
        left, top = self.to_world(-0.5, -0.5)
        right, bottom = self.to_world(self.width - 0.5, self.height - 0.5)
        return left - margin, right + margin, bottom - margin, top + margin
