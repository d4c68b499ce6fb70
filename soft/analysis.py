"""The pipeline: from a sequence of pictures to soil flow (Fig. 3)."""

import json
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from soft.flow import DEFAULT, FlowError, FlowField, FlowFiles, estimate_flow, find_estimator, resolve_options
from soft.flow.files import PREFIX
from soft.inertial import to_inertial
from soft.masks import grown
from soft.segmentation import SOIL_CHOICES, moving_mask, soil_mask
from soft.sequence import ImageSequence
from soft.soilflow import SCHEMA_VERSION
from soft.soilflow_writer import FileWriter, MemoryWriter, SoilFlowWriter
from soft.velocity import to_velocity

if TYPE_CHECKING:
    import xarray

# Distributions whose version may change a number in the result; OpenCV's is told by the library itself.
_DISTRIBUTIONS = ("softbed", "numpy", "scikit-image", "scikit-learn", "taichi", "xarray", "h5netcdf")

SOIL_RIM = 2
"""Px around soil that a method which keeps to a mask measures as well."""


@dataclass(frozen=True)
class _PairRecord:
    """What one pair gives: values by variable name, seconds spent on flow, remarks in words."""

    values: Mapping[str, Any]
    seconds: float
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class _Settings:
    """How each pair is analyzed."""

    method: str | Callable
    options: dict[str, object]
    soil: str
    vertical: bool
    seed: int
    threads: int | None
    device: str
    keeps_to_mask: bool


def analyze(
    sequence: ImageSequence,
    *,
    method: str | Callable = DEFAULT,
    options: Mapping[str, object] | None = None,
    soil: str = "bright",
    vertical: bool = False,
    seed: int = 0,
    threads: int | None = None,
    device: str = "cpu",
    progress: Callable[[int, int], None] | None = None,
    path: str | Path | None = None,
) -> "xarray.Dataset":
    """Measure soil flow between consecutive pictures.

    For each pair: displacement (section 2.3), soil by grey level, camera motion as the median horizontal
    displacement over soil, inertial displacement, moving region by its magnitude, velocity where the sequence
    is calibrated (section 2.2). Whether a pixel is soil is told apart from whether its motion could be
    measured: displacement is measured over the whole picture or, by a method that keeps to a mask, over soil
    and 2 px around it, so that the implement's motion does not leak in.

    Parameters
    ----------
    sequence : ImageSequence
        The pictures.
    method : str or callable, optional
        As in `estimate_flow`; `files:FOLDER` needs one file for each pair.
    options : mapping, optional
        Options of the method.
    soil : str, optional
        `bright`, `dark` or `all`, as in `soil_mask`.
    vertical : bool, optional
        Take the vertical camera motion out too, as in `to_inertial`; by default it is left as measured.
    seed : int, optional
        Of the clustering.
    threads : int, optional
        Threads of OpenCV for the flow.
    device : str, optional
        Where the flow is computed.
    progress : callable, optional
        Called with (pairs done, pairs in all), at the start and after each pair.
    path : str or Path, optional
        A netCDF-4 file to write to, pair by pair, so that memory holds one pair however long the sequence. A
        failure leaves a part of it: give a name aside and rename. Without it the result is in memory.

    Returns
    -------
    xarray.Dataset
        A SoilFlow; opened from `path`, if that is given, and then to be closed by the caller.

    Raises
    ------
    FlowError, SequenceError
        If the method or its options are refused, or a picture cannot be read.
    ValueError
        If `soil` is another word.
    """
    estimator = find_estimator(method)
    keeps = estimator.keeps_to_mask
    settings = _Settings(method, dict(options or {}), soil, vertical, seed, threads, device, keeps)
    recorded = _resolved_options(settings, len(sequence.pairs))
    writer = _writer(sequence, path, gridded=estimator.gridded)
    try:
        seconds, remarks = _analyze_pairs(sequence, settings, writer, progress)
        attributes = _attributes(sequence, settings, recorded, float(np.mean(seconds)), remarks)
        return writer.finish(attributes)
    except BaseException:
        writer.abandon()
        raise


def _writer(sequence: ImageSequence, path: str | Path | None, *, gridded: bool) -> SoilFlowWriter:
    sizes = {"pair": len(sequence.pairs), "y": sequence.shape[0], "x": sequence.shape[1]}
    form = {
        "calibrated": sequence.calibrated,
        "gridded": gridded,
        "timed": sequence.frame_rate is not None,
    }
    return MemoryWriter(sizes, **form) if path is None else FileWriter(path, sizes, **form)


def _analyze_pairs(
    sequence: ImageSequence,
    settings: _Settings,
    writer: SoilFlowWriter,
    progress: Callable[[int, int], None] | None,
) -> tuple[list[float], list[str]]:
    seconds: list[float] = []
    remarks: list[str] = []
    count = len(sequence.pairs)
    if progress:
        progress(0, count)
    for k, (first, second) in enumerate(sequence.picture_pairs()):
        record = _analyze_pair(first, second, k, sequence, settings)
        writer.put(k, record.values)
        seconds.append(record.seconds)
        remarks += [f"pair {k}: {remark}" for remark in record.remarks]
        if progress:
            progress(k + 1, count)
    return seconds, remarks


def _analyze_pair(
    first: np.ndarray, second: np.ndarray, pair: int, sequence: ImageSequence, settings: _Settings
) -> _PairRecord:
    soil = soil_mask(first, soil=settings.soil, seed=settings.seed)
    field, seconds = _timed_flow(first, second, soil.mask, pair, settings)
    inertial = to_inertial(field.displacement, soil.mask, vertical=settings.vertical)
    speed = np.hypot(inertial.displacement[:, :, 0], inertial.displacement[:, :, 1])
    moving = moving_mask(speed, soil.mask, seed=settings.seed)
    values = _field_values(field) | {
        "soil": soil.mask,
        "moving": moving.mask,
        "camera_u": inertial.camera_u,
        "camera_v": inertial.camera_v,
        "inertial_u": inertial.displacement[:, :, 0],
        "inertial_v": inertial.displacement[:, :, 1],
    }
    values |= _velocity_values(inertial.displacement, sequence) | _when(pair, sequence)
    return _PairRecord(values, seconds, (soil.remark, moving.remark))


def _timed_flow(
    first: np.ndarray, second: np.ndarray, soil: np.ndarray, pair: int, settings: _Settings
) -> tuple[FlowField, float]:
    mask = around(soil) if settings.keeps_to_mask else None
    began = time.perf_counter()
    field = estimate_flow(
        first,
        second,
        method=settings.method,
        mask=mask,
        device=settings.device,
        threads=settings.threads,
        **_options_for(settings, pair),
    )
    return field, time.perf_counter() - began


def around(soil: np.ndarray) -> np.ndarray | None:
    """Soil and a rim of a few px, within which its outline is known: what to measure. None: everything."""
    return grown(soil, SOIL_RIM) if soil.any() else None


def _options_for(settings: _Settings, pair: int) -> dict[str, Any]:
    return dict(settings.options) | ({"pair": pair} if _is_files(settings.method) else {})


def _is_files(method: str | Callable) -> bool:
    return isinstance(method, str) and method.startswith(PREFIX)


def _field_values(field: FlowField) -> dict[str, Any]:
    values = {"u": field.displacement[:, :, 0], "v": field.displacement[:, :, 1], "valid": field.valid}
    if field.uncertainty is not None:
        values |= {"uncertainty_u": field.uncertainty[:, :, 0], "uncertainty_v": field.uncertainty[:, :, 1]}
    if field.nodes is not None:
        values |= {"node_x": field.nodes[:, :, 0], "node_y": field.nodes[:, :, 1]}
    return values


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


def _resolved_options(settings: _Settings, pair_count: int) -> dict[str, object]:
    """Refuse what cannot work before any picture is read, and spell out every option."""
    if settings.soil not in SOIL_CHOICES:
        raise ValueError(f"soil: {settings.soil!r}: allowed are {', '.join(SOIL_CHOICES)}")
    if isinstance(settings.method, str) and _is_files(settings.method):
        if "pair" in settings.options:
            raise FlowError(f"method {settings.method!r}: pair: is not to be given here")
        FlowFiles(settings.method.removeprefix(PREFIX)).require_pairs(pair_count)
        return resolve_options(settings.method, settings.options | {"pair": 0})
    return resolve_options(settings.method, settings.options)


def _attributes(
    sequence: ImageSequence,
    settings: _Settings,
    options: Mapping[str, object],
    seconds_per_pair: float,
    remarks: list[str],
) -> dict[str, object]:
    attributes: dict[str, object] = {
        "schema_version": SCHEMA_VERSION,
        "method": find_estimator(settings.method).name,
        "options": json.dumps(options, sort_keys=True),
        "versions": json.dumps(_versions(), sort_keys=True),
        "seconds_per_pair": seconds_per_pair,
        "camera": _camera_rule(settings),
        "soil": settings.soil,
        "seed": settings.seed,
        "device": settings.device,
        "frames": json.dumps(sequence.names),
        "remarks": json.dumps(remarks),
    }
    for name in ("metres_per_pixel", "frame_rate"):
        if (value := getattr(sequence, name)) is not None:
            attributes[name] = value
    return attributes


def _camera_rule(settings: _Settings) -> str:
    vertical = "median taken out too" if settings.vertical else "left as measured"
    return f"median horizontal displacement over soil taken out, vertical {vertical}"


def _versions() -> dict[str, str]:
    import cv2

    found = {"python": platform.python_version(), "opencv": cv2.__version__}
    for name in _DISTRIBUTIONS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found
