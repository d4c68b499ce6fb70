"""A recording in the formats of other programs."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from synth.dataset.vtk import write_polydata, write_series
from synth.implements import Shape
from synth.recording import Recording
from synth.scene import AnyScene, SoilBinScene

_POINTS_AROUND = 64
"""Points of a capsule's outline."""


def export_vtk(
    recording: Recording,
    scene: AnyScene,
    folder: Path,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write grains and implement for ParaView: open `grains.pvd` and `implement.pvd`; and `contacts.pvd`.

    One `.vtp` a frame. Grains are points with `radius` (m), `velocity` (m/s, in laboratory time) and `angle`
    (rad); the implement is the outline of each of its capsules, or the edges of a solid. World frame: x along
    the bin, z up, y = 0.

    Where the recording has the forces between grains, they are lines from centre to centre with
    `normal_force` (pushes apart) and `tangential_force`, N per metre of width, and `force`, the vector on the
    second grain.

    Parameters
    ----------
    folder : Path
        Must exist.

    Raises
    ------
    ValueError
        A scene without grains.
    """
    if not isinstance(scene, SoilBinScene):
        raise ValueError(f"{scene.name}: kind = {scene.kind!r}: there are no grains to export")
    count, subjects = recording.frame_count, ["grains", "implement"]
    if recording.contacts(0) is not None:
        subjects.append("contacts")
    for frame in range(count):
        _write_grains(folder / _name("grains", frame), recording, frame)
        _write_implement(folder / _name("implement", frame), recording, frame, scene.implement.shape)
        if "contacts" in subjects:
            _write_contacts(folder / _name("contacts", frame), recording, frame)
        if progress is not None:
            progress(frame + 1, count)
    times = recording.data["time"].values
    for subject in subjects:
        write_series(folder / f"{subject}.pvd", times, [_name(subject, frame) for frame in range(count)])


def _name(subject: str, frame: int) -> str:
    return f"{subject}-{frame:06d}.vtp"


def _write_grains(path: Path, recording: Recording, frame: int) -> None:
    state = recording.data.isel(frame=frame)
    y = state["position_y"].values if "position_y" in state else 0.0
    speed_y = state["velocity_y"].values if "velocity_y" in state else 0.0
    points = _in_world(state["position_x"].values, state["position_z"].values, y)
    data = {
        "radius": state["radius"].values,
        "velocity": _in_world(state["velocity_x"].values, state["velocity_z"].values, speed_y),
        "angle": state["angle"].values,
    }
    write_polydata(path, points, point_data=data)


def _write_implement(path: Path, recording: Recording, frame: int, shape: Shape) -> None:
    state = recording.data.isel(frame=frame)
    shape = recording.section(shape, frame)
    around = capsule_outlines(shape.only(~shape.closed))
    edges = np.stack([shape.start, shape.end], axis=1)[shape.closed]
    x, z = np.concatenate([around.reshape(-1, 2), edges.reshape(-1, 2)]).T
    points = _in_world(x + float(state["implement_x"]), z + float(state["implement_z"]))
    index = np.arange(len(points))
    ring = index[: around[..., 0].size].reshape(around.shape[:2])
    lines = [*np.concatenate([ring, ring[:, :1]], axis=1), *index[ring.size :].reshape(-1, 2)]
    write_polydata(path, points, lines=lines)


def _write_contacts(path: Path, recording: Recording, frame: int) -> None:
    contacts, state = recording.contacts(frame), recording.data.isel(frame=frame)
    assert contacts is not None
    pairs = np.stack([contacts["contact_first"].values, contacts["contact_second"].values], axis=1)
    ends = _in_world(state["position_x"].values[pairs.ravel()], state["position_z"].values[pairs.ravel()])
    normal, tangential = (contacts[f"contact_{name}_force"].values for name in ("normal", "tangential"))
    branch = ends[1::2] - ends[::2]
    branch /= np.linalg.norm(branch, axis=1, keepdims=True)
    tangent = np.stack([-branch[:, 2], branch[:, 1], branch[:, 0]], axis=1)
    force = normal[:, None] * branch - tangential[:, None] * tangent
    forces = {"normal_force": normal, "tangential_force": tangential, "force": force}
    write_polydata(path, ends, lines=list(np.arange(len(ends)).reshape(-1, 2)), cell_data=forces)


def capsule_outlines(shape: Shape) -> np.ndarray:
    """Points around every capsule, counter-clockwise, m, shape (C, 64, 2)."""
    along = shape.end - shape.start
    heading = np.arctan2(along[:, 1], along[:, 0])
    quarter = np.pi / 2
    half_circle = np.linspace(-quarter, quarter, _POINTS_AROUND // 2)
    angle = heading[:, None] + np.concatenate([half_circle, half_circle + np.pi])
    centre = np.repeat(np.stack([shape.end, shape.start], axis=1), half_circle.size, axis=1)
    return centre + shape.radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=2)


def _in_world(x: np.ndarray, z: np.ndarray, y: "np.ndarray | float" = 0.0) -> np.ndarray:
    return np.stack([x, np.broadcast_to(y, x.shape), z], axis=1)
