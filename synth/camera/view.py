"""Between the world (m, z up) and the picture (px, y down): the one place that flips y."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from synth.recording import Recording
    from synth.scene import Scene


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
        On the optical axis.
    axis_x, axis_z : float
        Where the optical axis meets the glass, m.
    distortion : float
        Radial, of the lens: what an ideal lens shows at r from the axis is at r (1 + distortion (r / R)^2), R
        half the picture's diagonal (Brown's model, first term): positive is a pincushion.
    """

    width: int
    height: int
    metres_per_pixel: float
    axis_x: float
    axis_z: float
    distortion: float = 0.0

    @classmethod
    def of(cls, scene: "Scene", recording: "Recording", frame: int, *, picture: int | None = None) -> "View":
        """View of a scene's camera at a frame: one that follows the carriage travels and shakes with it.

        Parameters
        ----------
        picture : int, optional
            The picture whose vibration it has; default: the frame's.
        """
        from synth.camera.nuisance import vibration

        camera = scene.camera
        travels = camera.follows == "carriage"
        travel = float(recording.data["carriage_x"].values[frame]) if travels else 0.0
        shake_x, shake_z = vibration(scene, frame if picture is None else picture) if travels else (0.0, 0.0)
        return cls(
            camera.width,
            camera.height,
            camera.metres_per_pixel,
            travel + camera.centre_x + shake_x,
            camera.centre_z + shake_z,
            scene.nuisance.distortion,
        )

    def padded(self, pad: int) -> "View":
        """The same with `pad` px more on every side."""
        width, height = self.width + 2 * pad, self.height + 2 * pad
        distortion = self.bend * (width**2 + height**2) / 4
        return replace(self, width=width, height=height, distortion=distortion)

    @property
    def middle(self) -> tuple[float, float]:
        """Image coordinates of the optical axis."""
        return (self.width - 1) / 2, (self.height - 1) / 2

    @property
    def bend(self) -> float:
        """Distortion over the square of half the diagonal, 1/px2."""
        return 4 * self.distortion / (self.width**2 + self.height**2)

    @property
    def numbers(self) -> tuple[float, ...]:
        """What `projection_kernels.py` needs: pixels_per_metre, axis_x, axis_z, middle, bend."""
        return (1 / self.metres_per_pixel, self.axis_x, self.axis_z, *self.middle, self.bend)

    def to_image(self, x: Any, z: Any) -> tuple[Any, Any]:
        """Image coordinates (px) of a world position (m)."""
        return self.distorted(*self.to_ideal(x, z))

    def to_ideal(self, x: Any, z: Any) -> tuple[Any, Any]:
        """Image coordinates (px) that a world position (m) would have without distortion."""
        column = (x - self.axis_x) / self.metres_per_pixel + (self.width - 1) / 2
        row = (self.axis_z - z) / self.metres_per_pixel + (self.height - 1) / 2
        return column, row

    def to_world(self, column: Any, row: Any) -> tuple[Any, Any]:
        """World position (m) of image coordinates (px)."""
        column, row = self.undistorted(column, row)
        x = (column - (self.width - 1) / 2) * self.metres_per_pixel + self.axis_x
        z = self.axis_z - (row - (self.height - 1) / 2) * self.metres_per_pixel
        return x, z

    def distorted(self, column: Any, row: Any) -> tuple[Any, Any]:
        """Where the lens puts what an ideal one would put at the given image coordinates (px)."""
        if self.distortion == 0:
            return column, row
        middle_x, middle_y = self.middle
        x, y = column - middle_x, row - middle_y
        factor = 1 + self.bend * (x * x + y * y)
        return middle_x + factor * x, middle_y + factor * y

    def undistorted(self, column: Any, row: Any) -> tuple[Any, Any]:
        """The inverse of `distorted`, by Newton's method on the distance from the axis."""
        import numpy as np

        if self.distortion == 0:
            return column, row
        middle_x, middle_y = self.middle
        x, y = column - middle_x, row - middle_y
        seen = np.hypot(x, y)
        ideal = np.asarray(seen, float)
        for _ in range(8):
            square = self.bend * ideal**2
            ideal = ideal - (ideal * (1 + square) - seen) / (1 + 3 * square)
        factor = 1 / (1 + self.bend * ideal**2)
        return middle_x + factor * x, middle_y + factor * y

    def angle_to_image(self, angle: Any) -> Any:
        """Angle from x towards y in the picture (clockwise as seen) of a counter-clockwise angle, rad."""
        return -angle

    def length_to_image(self, length: Any) -> Any:
        """Length in px, on the optical axis, of a length in m."""
        return length / self.metres_per_pixel

    def bounds(self, margin: float = 0.0) -> tuple[float, float, float, float]:
        """World left, right, bottom and top (m) of the picture, wider by `margin` (m) on every side."""
        right, bottom = self.width - 0.5, self.height - 0.5
        middle_x, middle_y = self.middle
        # Under distortion it is the corners that see furthest, or the middles of the sides.
        edge = [self.to_world(x, y) for x in (-0.5, middle_x, right) for y in (-0.5, middle_y, bottom)]
        x, z = zip(*edge, strict=True)
        return (
            float(min(x)) - margin,
            float(max(x)) + margin,
            float(min(z)) - margin,
            float(max(z)) + margin,
        )
