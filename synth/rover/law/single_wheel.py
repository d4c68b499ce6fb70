"""Single-wheel rig: wheels led along given paths, rising and sinking freely under their loads.

Quasi-static: a path has no speed, only steps, and a wheel's height follows its load without inertia.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from synth.rover.law.interface import PlacedWheel, WheelForces, WheelStates
from synth.rover.law.rim_law import RimLaw

if TYPE_CHECKING:
    from synth.scene import SoilBinScene

_GREATEST_FALL = 1e-3
"""Of an axle in a step / radius."""
_SHALLOWEST = 0.01
"""Sinkage / radius that a wheel's stiffness on the ground is reckoned with, at least."""
_LONGEST_STEP = 1e-4
"""m, of a scene's wheel or its rim."""
_PERSISTENCE, _RESPONSE = 0.8, 0.4
"""Share of an axle's last step that it keeps, and of what the load lacks that it follows."""


@dataclass(frozen=True)
class Paths:
    """Where wheels are led; arrays of shape (step_count, wheel_count).

    Attributes
    ----------
    x : ndarray
        Of the axle, m.
    angle : ndarray
        Of the rim, rad, positive as it turns when it drives towards +x.
    load : ndarray
        N, downwards.
    """

    x: NDArray
    angle: NDArray
    load: NDArray

    @classmethod
    def at_slip(
        cls, slip: NDArray, load: NDArray, radius: NDArray, *, travel: NDArray, step_count: int
    ) -> "Paths":
        """Steady slip (skid below 0) over `travel` (m) of the axle; the load grows over its tenth."""
        done = np.linspace(0, 1, step_count)[:, None]
        rim = np.where(slip >= 0, 1 / (1 - np.maximum(slip, 0)), 1 + np.minimum(slip, 0))
        return cls(done * travel, done * travel * rim / radius, np.minimum(10 * done, 1) * load)

    @classmethod
    def of_scene(cls, scene: "SoilBinScene") -> tuple["Paths", NDArray]:
        """The path of a scene's wheel in steps of at most a tenth of a millimetre, and their times (s)."""
        program, wheel = scene.program, scene.implement
        radius = wheel.radius  # type: ignore[union-attr]
        fastest = max(np.abs(program.velocity_x).max(), np.abs(program.spin).max() * radius)
        end = (scene.timing.frame_count - 1) / scene.timing.frame_rate
        time = np.arange(program.time[0], end, _LONGEST_STEP / fastest)
        speed, spin, share = (
            np.interp(time, program.time, one) for one in (program.velocity_x, program.spin, program.load)
        )
        step = time[1] - time[0]
        paths = cls(
            step * np.cumsum(speed)[:, None],
            -step * np.cumsum(spin)[:, None],
            share[:, None] * wheel.normal_load,  # type: ignore[union-attr]
        )
        return paths, time


@dataclass(frozen=True)
class WheelRecord:
    """What the rig records; arrays of shape (step_count, wheel_count).

    Attributes
    ----------
    x, sinkage : ndarray
        m.
    force_x, force_z : ndarray
        Of the soil on the wheel, N; `force_x` is the drawbar pull.
    torque : ndarray
        Of the soil on the wheel in the sense of `spin`, N m: a wheel that drives meets a negative one.
    """

    x: NDArray
    sinkage: NDArray
    force_x: NDArray
    force_z: NDArray
    torque: NDArray

    def mean(self, share: float | NDArray) -> "WheelRecord":
        """Means over the last `share` (wheel_count,) of the steps, each of shape (wheel_count,)."""
        counts = np.arange(len(self.x))[:, None] >= (1 - np.asarray(share)) * len(self.x)
        counts = np.broadcast_to(counts, self.x.shape)
        return WheelRecord(
            *(np.mean(one, axis=0, where=counts) for one in (self.x, self.sinkage, *self.forces))
        )

    @property
    def forces(self) -> tuple[NDArray, NDArray, NDArray]:
        """`force_x`, `force_z` and `torque`."""
        return self.force_x, self.force_z, self.torque


def lead(law: RimLaw, wheels: Sequence[PlacedWheel], paths: Paths) -> WheelRecord:
    """Place wheels on fresh soil and lead them along their paths, one a column; a step takes a second."""
    law.place(wheels)
    radius, width = (np.array([getattr(wheel, one) for wheel in wheels]) for one in ("radius", "width"))
    step_x, step_angle = (np.diff(one, axis=0, prepend=one[:1]) for one in (paths.x, paths.angle))
    z, fall = radius.copy(), np.zeros_like(radius)
    lifted = np.zeros_like(radius)
    records = []
    for x, angle, load, by_x, by_angle in zip(
        paths.x, paths.angle, paths.load, step_x, step_angle, strict=True
    ):
        depth = np.maximum(radius - z, _SHALLOWEST * radius)
        stiffness = law.soil.stiffness * width * 2 * np.sqrt(2 * radius * depth)
        fall = _PERSISTENCE * fall + _RESPONSE * (load - lifted) / stiffness
        fall = np.clip(fall, -_GREATEST_FALL * radius, _GREATEST_FALL * radius)
        z = z - fall
        forces: WheelForces = law.advance(WheelStates(x, z, by_x, -fall, angle, by_angle), 1.0)
        lifted = forces.force_z
        records.append((x, radius - z, forces.force_x, forces.force_z, forces.torque))
    return WheelRecord(*np.array(records).transpose(1, 0, 2))
