"""A vehicle: any MJCF model whose wheels are named."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from synth.rover.law.interface import PlacedWheel
from synth.scene_files import scenes_folder

if TYPE_CHECKING:
    import mujoco

WHEEL_SUFFIX = "_wheel"
LEFT, RIGHT = "left", "right"


class VehicleError(ValueError):
    """A model that cannot be driven as a vehicle; the message names the file and what is missing."""


@dataclass(frozen=True)
class VehicleWheel:
    """A wheel of a model.

    Attributes
    ----------
    placed : PlacedWheel
        What a wheel-soil law is told of it.
    body, joint : int
        In the model.
    actuator : int
        The servo of its joint; -1 where it turns freely.
    is_rear : bool
        Its axle is the rearmost of its track: the cable pulls here.
    """

    placed: PlacedWheel
    body: int
    joint: int
    actuator: int
    is_rear: bool

    @property
    def name(self) -> str:
        """As in the model."""
        return self.placed.name


@dataclass(frozen=True)
class Vehicle:
    """A model and its wheels.

    Attributes
    ----------
    path : Path
    model : mujoco.MjModel
    wheels : tuple of VehicleWheel
        In the order of the model's bodies.
    """

    path: Path
    model: "mujoco.MjModel"
    wheels: tuple[VehicleWheel, ...]

    @cached_property
    def weight(self) -> float:
        """N."""
        return float(self.model.body_mass.sum() * np.linalg.norm(self.model.opt.gravity))

    @cached_property
    def wheel_bodies(self) -> NDArray:
        """Body of every wheel, shape (wheel_count,)."""
        return np.array([wheel.body for wheel in self.wheels])

    @cached_property
    def rear_wheels(self) -> NDArray:
        """Which of the wheels are the rear ones, at whose hubs the cable pulls."""
        return np.flatnonzero([wheel.is_rear for wheel in self.wheels])

    @cached_property
    def main_body(self) -> int:
        """The body that carries all others; travel is measured on it."""
        return int(self.model.body_rootid[self.wheels[0].body])

    @property
    def keyframes(self) -> tuple[str, ...]:
        """Names of the stances that the model comes with."""
        return tuple(self.model.key(index).name for index in range(self.model.nkey))

    def actuator(self, name: str) -> int:
        """Index of a servo by its name.

        Raises
        ------
        VehicleError
            There is none.
        """
        names = [self.model.actuator(index).name for index in range(self.model.nu)]
        if name not in names:
            raise VehicleError(f"{self.path}: no actuator {name!r}; it has {', '.join(names) or 'none'}")
        return names.index(name)


def shipped_vehicle_path(name: str) -> Path:
    """The scene of a shipped vehicle, such as `scarab`."""
    return scenes_folder() / name / "scene.xml"


def load_vehicle(path: str | Path) -> Vehicle:
    """Load an MJCF model.

    A wheel is a body whose name ends in `_wheel`, on one hinge about y, with a cylinder geom: its rim.
    Wheels with y > 0 run in the left rut, the others in the right one. Contacts of the model are switched
    off: the soil's force comes from a law.

    Parameters
    ----------
    path : str or Path
        MJCF file, or the name of a shipped vehicle.

    Raises
    ------
    VehicleError
        The file is none, is no valid model, or has no such wheels.
    """
    import mujoco

    given = Path(path)
    file = shipped_vehicle_path(given.name) if not given.suffix and not given.exists() else given
    if not file.is_file():
        raise VehicleError(f"{path}: neither an MJCF file nor a shipped vehicle")
    try:
        model = mujoco.MjModel.from_xml_path(str(file))
    except ValueError as error:
        raise VehicleError(f"{file}: not a model that MuJoCo loads: {error}") from error
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    return Vehicle(file, model, _find_wheels(file, model))


def _find_wheels(file: Path, model: "mujoco.MjModel") -> tuple[VehicleWheel, ...]:
    import mujoco

    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)  # places are 0 until then
    bodies = [index for index in range(model.nbody) if model.body(index).name.endswith(WHEEL_SUFFIX)]
    if not bodies:
        raise VehicleError(f"{file}: no body's name ends in {WHEEL_SUFFIX!r}")
    rearmost: dict[str, float] = {}
    for body in bodies:
        x, y, _ = data.xpos[body]
        rearmost[_track(y)] = min(rearmost.get(_track(y), np.inf), float(x))
    return tuple(_wheel(file, model, body, data.xpos[body], rearmost) for body in bodies)


def _track(y: float) -> str:
    return LEFT if y > 0 else RIGHT


def _wheel(
    file: Path, model: "mujoco.MjModel", body: int, place: NDArray, rearmost: dict[str, float]
) -> VehicleWheel:
    name, joint = model.body(body).name, int(model.body_jntadr[body])
    if model.body_jntnum[body] != 1 or not _turns_about_y(model, joint):
        raise VehicleError(f"{file}: wheel {name!r} needs one hinge about y and nothing else")
    radius, width = _rim(file, model, body)
    track = _track(place[1])
    placed = PlacedWheel(name=name, track=track, radius=radius, width=width)
    return VehicleWheel(placed, body, joint, _servo(model, joint), bool(place[0] <= rearmost[track] + 1e-6))


def _turns_about_y(model: "mujoco.MjModel", joint: int) -> bool:
    import mujoco

    return model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE and np.allclose(
        model.jnt_axis[joint], (0, 1, 0)
    )


def _rim(file: Path, model: "mujoco.MjModel", body: int) -> tuple[float, float]:
    """Radius and width of a wheel's first cylinder, m."""
    import mujoco

    first = int(model.body_geomadr[body])
    for geom in range(first, first + int(model.body_geomnum[body])):
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CYLINDER:
            return float(model.geom_size[geom, 0]), float(2 * model.geom_size[geom, 1])
    raise VehicleError(f"{file}: wheel {model.body(body).name!r} needs a cylinder geom, its rim")


def _servo(model: "mujoco.MjModel", joint: int) -> int:
    import mujoco

    driven = (model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT) & (model.actuator_trnid[:, 0] == joint)
    return int(np.flatnonzero(driven)[0]) if driven.any() else -1
