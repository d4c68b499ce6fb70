"""One pair of pictures: what is soil, how it moves, and what of that is the camera's motion."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from soft.between_nodes import between_nodes
from soft.flow import FlowField, estimate_flow
from soft.flow.files import PREFIX
from soft.flow_store import FlowStore, MeasuredFlow, flow_key
from soft.inertial import InertialMotion, to_inertial
from soft.masks import grown
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


@dataclass(frozen=True)
class PairRecord:
    """What one pair gives: values by variable name, seconds spent on flow, remarks in words."""

    values: Mapping[str, Any]
    seconds: float
    remarks: tuple[str, ...]


def analyze_pair(
    first: np.ndarray,
    second: np.ndarray,
    pair: int,
    sequence: ImageSequence,
    settings: PairSettings,
    store: FlowStore | None = None,
) -> PairRecord:
    """Analyze one pair of a sequence.

    Parameters
    ----------
    first, second : (H, W) float32 array
        Its pictures.
    pair : int
        Its number.
    store : FlowStore, optional
        Where its flow may be, and is kept.
    """
    found = soil_mask(first, soil=settings.soil, seed=settings.seed)
    soil = found.mask & sequence.usable(sequence.pairs[pair][0])
    flow = _flow(first, second, around(soil) if settings.keeps_to_mask else None, pair, settings, store)
    field = flow.field.where(_both_seen(flow.field, sequence.seen))
    inertial = to_inertial(field.displacement, soil, vertical=settings.vertical, camera=settings.camera)
    moving = _moving(inertial.displacement, field.nodes, soil, settings.seed)
    values = _field_values(field) | {"soil": soil, "moving": moving.mask} | _inertial_values(inertial)
    values |= _velocity_values(inertial.displacement, sequence) | _when(pair, sequence)
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
    first: np.ndarray,
    second: np.ndarray,
    mask: np.ndarray | None,
    pair: int,
    settings: PairSettings,
    store: FlowStore | None,
) -> MeasuredFlow:
    if store is None:
        return _measured(first, second, mask, pair, settings)
    key = flow_key(settings.identity, first, second, mask)
    kept = store.find(key)
    if kept is None:
        kept = _measured(first, second, mask, pair, settings)
        store.keep(key, kept)
    return kept


def _measured(
    first: np.ndarray, second: np.ndarray, mask: np.ndarray | None, pair: int, settings: PairSettings
) -> MeasuredFlow:
    options = dict(settings.options) | ({"pair": pair} if is_files(settings.method) else {})
    began = time.perf_counter()
    field = estimate_flow(
        first,
        second,
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


def _velocity_values(displacement: np.ndarray, sequence: ImageSequence) -> dict[str, Any]:
    if sequence.metres_per_pixel is None or sequence.pair_time is None:
        return {}
    velocity_x, velocity_z = to_velocity(
        displacement, metres_per_pixel=sequence.metres_per_pixel, time_step=sequence.pair_time
    )
    return {"velocity_x": velocity_x, "velocity_z": velocity_z}


def _when(pair: int, sequence: ImageSequence) -> dict[str, Any]:
    first, second = sequence.pairs[pair]
    return {"first_frame": first, "second_frame": second, "time": first * (sequence.time_step or 1.0)}
