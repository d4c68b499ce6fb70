"""What disturbs a real rig, drawn from the scene's seed: each with a severity of 0 in a clean scene."""

from typing import TYPE_CHECKING

from synth.camera.streams import Purpose, random_stream

if TYPE_CHECKING:
    import numpy as np

    from synth.recording import Recording
    from synth.scene import Scene

STATES = (
    "carriage_x",
    "implement_x",
    "implement_z",
    "implement_angle",
    "position_x",
    "position_z",
    "angle",
    "rim_x",
    "rim_z",
)
"""Variables of a recording that a picture shows; the last two where a wheel has an elastic rim."""


def vibration(scene: "Scene", frame: int) -> tuple[float, float]:
    """Where the carriage's vibration has moved the optical axis at a frame, m along x and z."""
    severity = scene.nuisance.vibration
    if severity == 0:
        return 0.0, 0.0
    x, z = random_stream(scene.seed_of_pictures, Purpose.VIBRATION, frame).normal(0, severity, 2)
    return float(x) * scene.camera.metres_per_pixel, float(z) * scene.camera.metres_per_pixel


def flicker(scene: "Scene", frame: int) -> float:
    """Light of a frame / that of a steady lamp."""
    severity = scene.nuisance.flicker
    if severity == 0:
        return 1.0
    stream = random_stream(scene.seed_of_pictures, Purpose.FLICKER, frame)
    return max(0.0, 1.0 + float(stream.normal(0, severity)))


def as_seen(recording: "Recording", scene: "Scene") -> "Recording":
    """The states at the instants the camera takes its pictures, of what is at the glass.

    They are linear between the recorded ones. The first and the last picture can be late and early only:
    nothing is recorded beyond them.
    """
    import numpy as np

    recording, severity = recording.at_glass(), scene.nuisance.jitter
    if severity == 0:
        return recording
    last = recording.frame_count - 1
    shift = random_stream(scene.seed_of_pictures, Purpose.JITTER).normal(0, severity, recording.frame_count)
    at = np.clip(np.arange(recording.frame_count) + np.clip(shift, -0.45, 0.45), 0, last)
    return states_at(recording, at)


def states_at(recording: "Recording", at: "np.ndarray") -> "Recording":
    """A recording's states at fractional frames: linear between them, and on as there beyond the ends."""
    import numpy as np
    import xarray as xr

    from synth.recording import RIM_VARIABLES, VARIABLES, Recording

    known = {name: kind for name, kind in (VARIABLES | RIM_VARIABLES).items() if name in recording.data}
    before = np.clip(np.floor(at).astype(int), 0, recording.frame_count - 2)
    first, last = before.min(), before.max() + 1  # of an exposure all but these need not be read
    data = recording.data.isel(frame=slice(first, last + 1))
    arrays = {name: data[name].values for name in known}
    for name in arrays.keys() & {"time", *STATES}:
        arrays[name] = _between(arrays[name], at - first)
    for name in ("velocity_x", "velocity_z"):  # no picture shows them
        arrays[name] = arrays[name][(at - first).round().astype(int).clip(0, last - first)]
    data = xr.Dataset({name: (known[name][0], array) for name, array in arrays.items()})
    return Recording(data.assign_attrs(recording.data.attrs))


def _between(states: "np.ndarray", at: "np.ndarray") -> "np.ndarray":
    import numpy as np

    before = np.clip(np.floor(at).astype(int), 0, len(states) - 2)
    share = (at - before).reshape(-1, *(1,) * (states.ndim - 1))
    return states[before] + share * (states[before + 1].astype(float) - states[before])
