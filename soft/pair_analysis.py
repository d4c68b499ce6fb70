"""One pair of pictures: what is soil, how it moves, and what of that is the camera's motion."""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from soft.between_nodes import between_nodes
from soft.flow import FlowField, estimate_flow
from soft.flow.files import PREFIX
from soft.flow_store import FlowStore, MeasuredFlow, flow_key
from soft.growth import grown
from soft.inertial import InertialMotion, to_inertial
from soft.segmentation import MovingRegion, moving_mask, soil_mask
from soft.sequence import ImageSequence
from soft.velocity import to_velocity

SOIL_RIM = 2
"""Px around soil that a method which keeps to a mask measures as well."""


@dataclass(frozen=True)
class PairSettings:
    """How each pair is analyzed.

    Attributes
    ----------
    method : str or callable
    options : dict
        As given.
    soil, camera : str
        As in `soft.soil_mask` and `soft.to_inertial`.
    vertical : bool
    seed : int
    threads : int or None
    device : str
    keeps_to_mask : bool
        Whether the method measures within a mask only.
    identity : dict
        What flow depends on besides the pictures: method, options spelt out, versions.
    metres_per_pixel : float or None
    pair_time : float or None
        Seconds from a pair's first picture to its second.
    """

    method: str | Callable
    options: dict[str, object]
    soil: str
    camera: str
    vertical: bool
    seed: int
    threads: int | None
    device: str
    keeps_to_mask: bool
    identity: dict[str, object]
    metres_per_pixel: float | None
    pair_time: float | None


@dataclass(frozen=True, eq=False)
class PairPictures:
    """One pair of a sequence.

    Attributes
    ----------
    number : int
        Among the pairs.
    frames : tuple of int
        First and second.
    time : float
        Of the first, s; frames where the rate is unknown.
    first, second : (H, W) float32
    usable : (H, W) bool
        Pixels of the first that the camera saw and the user's mask leaves.
    seen : (H, W) bool
        Pixels that the camera saw, in every frame.
    """

    number: int
    frames: tuple[int, int]
    time: float
    first: np.ndarray
    second: np.ndarray
    usable: np.ndarray
    seen: np.ndarray


@dataclass(frozen=True)
class PairRecord:
    """What one pair gives: values by variable name, seconds spent on flow, remarks in words."""

    values: Mapping[str, Any]
    seconds: float
    remarks: tuple[str, ...]


def pairs_of(sequence: ImageSequence) -> Iterator[PairPictures]:
    """Every pair of a sequence, in order; no more than two frames are decoded at a time."""
    for number, (first, second) in enumerate(sequence.picture_pairs()):
        frames = sequence.pairs[number]
        time_of_first = frames[0] * (sequence.time_step or 1.0)
        usable = sequence.usable(frames[0])
        yield PairPictures(number, frames, time_of_first, first, second, usable, sequence.seen)


def analyze_pair(pair: PairPictures, settings: PairSettings, store: FlowStore | None = None) -> PairRecord:
    """Analyze one pair.

    Parameters
    ----------
    pair : PairPictures
    settings : PairSettings
    store : FlowStore, optional
        Where its flow may be, and is kept.
    """
    found = soil_mask(pair.first, soil=settings.soil, seed=settings.seed)
    soil = found.mask & pair.usable
    flow = _flow(pair, around(soil) if settings.keeps_to_mask else None, settings, store)
    field = flow.field.where(_both_seen(flow.field, pair.seen))
    inertial = to_inertial(field.displacement, soil, vertical=settings.vertical, camera=settings.camera)
    moving = _moving(inertial.displacement, field.nodes, soil, settings.seed)
    first, second = pair.frames
    values = _field_values(field) | {"soil": soil, "moving": moving.mask} | _inertial_values(inertial)
    values |= _velocity_values(inertial.displacement, settings)
    values |= {"first_frame": first, "second_frame": second, "time": pair.time}
    return PairRecord(values, flow.seconds, (found.remark, moving.remark))


def around(soil: np.ndarray) -> np.ndarray | None:
    """Soil and a rim of a few px, within which its outline is known: what to measure. None: everything."""
    return grown(soil, SOIL_RIM) if soil.any() else None


def is_files(method: str | Callable) -> bool:
    """Whether flow is read from files rather than measured."""
    return isinstance(method, str) and method.startswith(PREFIX)


def is_own_function(method: str | Callable) -> bool:
    """Whether flow is measured by a user's function, whose code may have changed since it was last run."""
    return not isinstance(method, str) or (":" in method and not is_files(method))


def _flow(
    pair: PairPictures, mask: np.ndarray | None, settings: PairSettings, store: FlowStore | None
) -> MeasuredFlow:
    if store is None:
        return _measured(pair, mask, settings)
    key = flow_key(settings.identity, pair.first, pair.second, mask)
    kept = store.find(key)
    if kept is None:
        kept = _measured(pair, mask, settings)
        store.keep(key, kept)
    return kept


def _measured(pair: PairPictures, mask: np.ndarray | None, settings: PairSettings) -> MeasuredFlow:
    options = dict(settings.options) | ({"pair": pair.number} if is_files(settings.method) else {})
    began = time.perf_counter()
    field = estimate_flow(
        pair.first,
        pair.second,
        method=settings.method,
        mask=mask,
        device=settings.device,
        threads=settings.threads,
        **options,  # type: ignore[arg-type]
    )
    return MeasuredFlow(field, time.perf_counter() - began)


def _moving(displacement: np.ndarray, nodes: np.ndarray | None, soil: np.ndarray, seed: int) -> MovingRegion:
    """What moves; of a grid by motion linear between its nodes, which alone form no region."""
    reach = 0.0
    if nodes is not None:
        filled = between_nodes(displacement, nodes, soil)
        displacement, reach = filled.displacement, filled.spacing
    speed = np.hypot(displacement[:, :, 0], displacement[:, :, 1])
    return moving_mask(speed, soil, seed=seed, reach=reach)


def _both_seen(field: FlowField, seen: np.ndarray) -> np.ndarray:
    """Pixels that the camera saw in the first picture, and again where they go to in the second."""
    if seen.all():
        return seen
    height, width = seen.shape
    y, x = np.indices(seen.shape, dtype=np.float32)
    gone = np.nan_to_num(field.displacement)
    column = np.clip(np.rint(x + gone[:, :, 0]), 0, width - 1).astype(np.intp)
    row = np.clip(np.rint(y + gone[:, :, 1]), 0, height - 1).astype(np.intp)
    return seen & seen[row, column]


def _field_values(field: FlowField) -> dict[str, Any]:
    values = {"u": field.displacement[:, :, 0], "v": field.displacement[:, :, 1], "valid": field.valid}
    if field.uncertainty is not None:
        values |= {"uncertainty_u": field.uncertainty[:, :, 0], "uncertainty_v": field.uncertainty[:, :, 1]}
    if field.nodes is not None:
        values |= {"node_x": field.nodes[:, :, 0], "node_y": field.nodes[:, :, 1]}
    return values


def _inertial_values(inertial: InertialMotion) -> dict[str, Any]:
    camera = ("camera_u", "camera_v", "camera_u_low", "camera_u_high", "camera_v_low", "camera_v_high")
    return {name: getattr(inertial, name) for name in camera} | {
        "inertial_u": inertial.displacement[:, :, 0],
        "inertial_v": inertial.displacement[:, :, 1],
    }


def _velocity_values(displacement: np.ndarray, settings: PairSettings) -> dict[str, Any]:
    if settings.metres_per_pixel is None or settings.pair_time is None:
        return {}
    velocity_x, velocity_z = to_velocity(
        displacement, metres_per_pixel=settings.metres_per_pixel, time_step=settings.pair_time
    )
    return {"velocity_x": velocity_x, "velocity_z": velocity_z}
