"""A recording without a simulation: a scene's bed, moved by a formula that resembles soil under a wheel."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from synth import Recording
    from synth.scene import SoilBinScene

_SINKAGE = 0.15
"""Of the wheel / its radius."""
_DECAY = 0.2
"""Depth below the rim over which the soil's motion fades / the wheel's radius."""
_DRAG = 0.5
"""Speed of the soil at the rim / the rim's."""


def rolling_field(scene: "SoilBinScene", frame_count: int) -> "Recording":
    """Particles of the scene's size around its wheel; those near the rim follow it, the less the deeper.

    Pictures of it cost what pictures of a simulation cost: the same particles, micro-grains and motion of the
    camera, and a share of the soil that deforms.
    """
    from synth.drive import Rolling
    from synth.implements import RigidWheel
    from synth.recording import VARIABLES, Recording

    assert isinstance(scene.implement, RigidWheel)
    assert isinstance(scene.drive, Rolling)
    wheel, step = scene.implement.radius, 1 / scene.timing.frame_rate
    x, z, radius = _particles(scene)
    axle_z = scene.bed.depth + (1 - _SINKAGE) * wheel
    start = scene.drive.start + scene.drive.run_in
    outside = np.hypot(x - start, z - axle_z) > wheel + radius
    x, z, radius = x[outside], z[outside], radius[outside]
    sizes = {"frame": frame_count, "particle": len(x), "sample": 0}
    arrays = {name: np.zeros([sizes[dim] for dim in dims]) for name, (dims, _, _) in VARIABLES.items()}
    arrays["radius"][:] = radius
    frames = np.arange(frame_count)
    arrays["time"][:] = frames * step
    arrays["carriage_x"][:] = arrays["implement_x"][:] = start + frames * step * scene.drive.carriage_speed
    arrays["implement_z"][:] = axle_z
    arrays["implement_angle"][:] = -frames * step * scene.drive.rim_speed / wheel
    for frame in frames:
        arrays["position_x"][frame], arrays["position_z"][frame] = x, z
        x, z = _moved(x, z, (arrays["implement_x"][frame], axle_z), wheel, step * scene.drive.rim_speed)
    return Recording.from_arrays(arrays, {"simulation_hash": "", "surface_height": scene.bed.depth})


def _particles(scene: "SoilBinScene") -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shaken rows of touching particles over the scene's bed: x, z, radius (m)."""
    bed, generator = scene.bed, np.random.default_rng(scene.seed)
    diameter = bed.grain_diameter
    across, up = np.arange(0, bed.width, diameter), np.arange(0, bed.depth, 0.9 * diameter)
    x, z = np.meshgrid(across, up)
    x = x + 0.5 * diameter * (np.arange(len(up)) % 2)[:, None]
    shake = generator.normal(0, 0.05 * diameter, (2, x.size))
    spread = generator.uniform(1 - bed.polydispersity, 1 + bed.polydispersity, x.size)
    return x.ravel() + shake[0], z.ravel() + shake[1], 0.5 * diameter * spread


def _moved(
    x: np.ndarray, z: np.ndarray, axle: tuple[float, float], wheel: float, rim_step: float
) -> tuple[np.ndarray, np.ndarray]:
    """Places one frame later: turned clockwise about the axle, the less the deeper below the rim."""
    off_x, off_z = x - axle[0], z - axle[1]
    away = np.hypot(off_x, off_z)
    turn = _DRAG * rim_step / wheel * np.exp(-np.maximum(away - wheel, 0) / (_DECAY * wheel))
    cosine, sine = np.cos(turn), np.sin(turn)
    return axle[0] + cosine * off_x + sine * off_z, axle[1] - sine * off_x + cosine * off_z
