"""The implement as the camera sees it: its side against the glass."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from synth.camera import rim_face
from synth.camera.view import View
from synth.implements import CompliantWheel, Plate, RigidWheel, Shape

if TYPE_CHECKING:
    import numpy as np

    from synth.recording import Recording
    from synth.scene import Scene


@dataclass(frozen=True, eq=False)
class ImplementFace:
    """An implement's side in the picture.

    Attributes
    ----------
    x, y : float
        Its reference point (a wheel's axle), px.
    angle : float
        From x towards y of the picture, rad.
    parts : (C, 6) float64
        Its capsules, as they stand: both ends from the reference point, and the radius, px; then 1 for an
        edge of a closed outline, else 0.
    wheel_radius : float
        px; 0 for what is no wheel and has a plain side.
    view : View
        Whose image coordinates these are, had it an ideal lens.
    rim : (A, 4) float64
        How an elastic rim is deformed (`rim_face.rim_table`); one row of zeros for what is rigid.
    """

    x: float
    y: float
    angle: float
    parts: "np.ndarray"
    wheel_radius: float
    view: View
    rim: "np.ndarray"

    def padded(self, pad: int) -> "ImplementFace":
        """The same in a picture with `pad` px more on every side."""
        return replace(self, x=self.x + pad, y=self.y + pad, view=self.view.padded(pad))

    def box(self, margin: int) -> Any:
        """Pixels that the implement may be at, for kernels: first column and row, and those after the last.

        Counted from the first pixel of a buffer with `margin` px more than the picture on every side.
        """
        import numpy as np

        from synth.camera import cover_kernels

        width, height = self.view.width + 2 * margin, self.view.height + 2 * margin
        if self.view.distortion != 0:
            return cover_kernels.box_vector((0, 0, width, height))
        reach = self.parts[:, 4:5] + 2
        ends = self.parts[:, :4].reshape(-1, 2, 2) + np.array([self.x + margin, self.y + margin])
        low, high = (ends.min(axis=1) - reach).min(axis=0), (ends.max(axis=1) + reach).max(axis=0)
        low, high = (np.clip(edge, 0, (width, height)).astype(int) for edge in (low, high))
        return cover_kernels.box_vector((*low.tolist(), *high.tolist()))

    def distance(self, distance: "np.ndarray | None" = None) -> "np.ndarray":
        """Distance of every pixel's centre to the implement, px of an ideal lens: (H, W) float32, 0 on it.

        Parameters
        ----------
        distance : (H, W) float32, optional
            To be overwritten and returned.
        """
        import numpy as np

        from synth.camera import cover_kernels

        if distance is None:
            distance = np.empty((self.view.height, self.view.width), np.float32)
        numbers = cover_kernels.projection.numbers(self.view.numbers)
        cover_kernels.distance_to_implement(self.x, self.y, self.parts, numbers, distance)
        return distance


def face_of(scene: "Scene", recording: "Recording", frame: int, view: View) -> ImplementFace | None:
    """Side of a scene's implement at a frame; None where it cannot be seen, as a plate under its soil."""
    implement = scene.implement
    if isinstance(implement, Plate):
        return None
    data = recording.data
    at = float(data["implement_x"].values[frame]), float(data["implement_z"].values[frame])
    turn = float(data["implement_angle"].values[frame])
    x, y = view.to_ideal(*at)
    radius = implement.radius if isinstance(implement, RigidWheel) else 0.0
    parts = _parts_in_view(recording.section(implement.shape, frame), at, view)
    angle = view.angle_to_image(turn)
    rim = rim_face.rigid()
    if isinstance(implement, CompliantWheel):
        rim = _rim_in_view(parts, angle, implement.shape, view)
    return ImplementFace(x, y, angle, parts, view.length_to_image(radius), view, rim)


def _rim_in_view(parts: "np.ndarray", angle: float, unloaded: Shape, view: View) -> "np.ndarray":
    """Table of the deformed rim whose capsules are `parts`."""
    import numpy as np

    sine, cosine = np.sin(angle), np.cos(angle)
    nodes = parts[:, 0:2] @ np.array([[cosine, -sine], [sine, cosine]])  # into the wheel's frame
    before = _parts_in_view(unloaded, (0.0, 0.0), view)[:, 0:2]
    return rim_face.rim_table(nodes, before, float(parts[0, 4]))


def _parts_in_view(shape: Shape, at: tuple[float, float], view: View) -> "np.ndarray":
    import numpy as np

    axle = np.array(view.to_ideal(*at))
    ends = [np.stack(view.to_ideal(*(points + at).T), axis=1) - axle for points in (shape.start, shape.end)]
    return np.column_stack([*ends, view.length_to_image(shape.radius), shape.closed])
