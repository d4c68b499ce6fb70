"""Pictures of a vehicle on its soil, drawn without a display."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import mujoco

    from synth.rover.law.interface import WheelForces
    from synth.rover.ride import Ride
    from synth.rover.vehicle import Vehicle

_LEVEL_SCALE, _UPRIGHT_SCALE = 300.0, 1200.0
"""N a metre of an arrow: level ones are drawn longer, for they are what the gaits differ in."""
_THRUST, _RESISTANCE, _NORMAL, _CABLE = (
    (0.10, 0.55, 0.20, 1.0),
    (0.85, 0.20, 0.15, 1.0),
    (0.35, 0.45, 0.65, 0.8),
    (0.1, 0.1, 0.1, 1.0),
)
_LEAST_FORCE = 8.0  # N; shorter arrows are not drawn
_BESIDE = 0.13  # m, of arrows from the middle of the wheel, so that they are seen
_RUT_STEP = 0.03  # m
_RUT_COLOUR = (0.47, 0.42, 0.34, 1.0)


@dataclass(frozen=True)
class Size:
    """Of a picture, px."""

    width: int = 960
    height: int = 540


_STANCE_SIZE = Size(width=560, height=480)


def draw_without_display() -> None:
    """Let MuJoCo draw by EGL, which works on processors alone, where there is no display.

    MuJoCo looks when it is imported first: later this does nothing. What `MUJOCO_GL` says already stands.
    """
    if not os.environ.get("DISPLAY"):
        os.environ.setdefault("MUJOCO_GL", "egl")


@contextmanager
def camera_on(vehicle: "Vehicle", size: Size | None = None) -> "Iterator[SceneCamera]":
    """Open a renderer for a vehicle's model, closed at the end; `draw_without_display` comes before."""
    import mujoco

    size = size or Size()
    model = vehicle.model
    model.vis.global_.offwidth = max(model.vis.global_.offwidth, size.width)
    model.vis.global_.offheight = max(model.vis.global_.offheight, size.height)
    renderer = mujoco.Renderer(model, size.height, size.width)
    try:
        yield SceneCamera(renderer, vehicle)
    finally:
        renderer.close()


class SceneCamera:
    """Looks at a vehicle from its right side; made by `camera_on`."""

    def __init__(self, renderer: "mujoco.Renderer", vehicle: "Vehicle") -> None:
        import mujoco

        self._renderer, self._vehicle = renderer, vehicle
        self._camera = mujoco.MjvCamera()
        self._camera.azimuth, self._camera.elevation, self._camera.distance = 90.0, -7.0, 3.1

    def picture(self, data: "mujoco.MjData", *, at: float, ride: "Ride | None" = None) -> NDArray:
        """The vehicle as it is, the camera at x = `at`, m; with a ride, its ruts and forces.

        Returns
        -------
        ndarray, shape (H, W, 3)
            Red, green, blue, uint8.
        """
        self._camera.lookat[:] = at, 0.0, 0.42
        self._renderer.update_scene(data, self._camera)
        if ride is not None:
            self._draw_rut(ride, at)
            self._draw_forces(ride, ride.forces)
        return self._renderer.render()

    def _draw_forces(self, ride: "Ride", forces: "WheelForces") -> None:
        data, rear = ride.data, set(ride.vehicle.rear_wheels)
        for index, wheel in enumerate(ride.vehicle.wheels):
            hub = data.xpos[wheel.body].copy()
            if wheel.placed.track != "right":  # the side that is looked at
                continue
            hub[1] -= _BESIDE
            ground = hub - (
                0.0,
                0.0,
                wheel.placed.radius - 0.07,
            )  # above the soil, which hides the rim's lowest part
            force_x = float(forces.force_x[index])
            self._arrow(ground, (force_x, 0, 0), _THRUST if force_x > 0 else _RESISTANCE)
            self._arrow(ground, (0, 0, float(forces.force_z[index])), _NORMAL)
            if index in rear:
                self._arrow(hub, (-ride.pull / len(rear), 0, 0), _CABLE)

    def _draw_rut(self, ride: "Ride", at: float) -> None:
        surface = ride.law.rut("right")
        seen = np.arange(at - 2.2, at + 2.2, _RUT_STEP)
        height = np.interp(seen, surface[:, 0], surface[:, 1])
        hidden = np.array([wheel.placed.width for wheel in ride.vehicle.wheels]).max() / 2
        y = -max(abs(float(ride.data.xpos[wheel.body, 1])) for wheel in ride.vehicle.wheels) - hidden - 0.02
        for x, z, x_next, z_next in zip(seen[:-1], height[:-1], seen[1:], height[1:], strict=True):
            self._bar((x, y, z), (x_next, y, z_next))

    def _arrow(self, start: NDArray, force: tuple[float, float, float], colour: tuple[float, ...]) -> None:
        import mujoco

        if np.abs(force).max() < _LEAST_FORCE:
            return
        end = start + np.asarray(force) / (_LEVEL_SCALE, 1.0, _UPRIGHT_SCALE)
        self._connect(mujoco.mjtGeom.mjGEOM_ARROW, 0.018, start, end, colour)

    def _bar(self, start: tuple[float, ...], end: tuple[float, ...]) -> None:
        import mujoco

        capsule = mujoco.mjtGeom.mjGEOM_CAPSULE
        self._connect(capsule, 0.006, np.array(start), np.array(end), _RUT_COLOUR)

    def _connect(
        self, kind: int, width: float, start: NDArray, end: NDArray, colour: tuple[float, ...]
    ) -> None:
        import mujoco

        scene = self._renderer.scene
        if scene.ngeom >= scene.maxgeom:
            return
        geom = scene.geoms[scene.ngeom]
        none = np.zeros(3)
        mujoco.mjv_initGeom(geom, kind, none, none, np.eye(3).ravel(), np.array(colour, np.float32))
        mujoco.mjv_connector(geom, kind, width, start, end)
        scene.ngeom += 1


def stances_picture(vehicle: "Vehicle") -> NDArray:
    """The stances that a model comes with, side by side, (H, W, 3) uint8."""
    import mujoco

    pictures = []
    with camera_on(vehicle, _STANCE_SIZE) as camera:
        for stance in vehicle.keyframes or ("",):
            data = mujoco.MjData(vehicle.model)
            if stance:
                mujoco.mj_resetDataKeyframe(vehicle.model, data, vehicle.model.key(stance).id)
            mujoco.mj_forward(vehicle.model, data)
            pictures.append(camera.picture(data, at=0.0))
    return np.concatenate(pictures, axis=1)
