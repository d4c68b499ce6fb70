"""The pipeline: from a sequence of pictures to soil flow (Fig. 3)."""

import json
import os
import platform
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from soft.flow import DEFAULT, FlowError, FlowFiles, find_estimator, resolve_options
from soft.flow.files import PREFIX
from soft.flow_store import FlowStore
from soft.inertial import CAMERA_CHOICES
from soft.pair_analysis import (
    PairPictures,
    PairRecord,
    PairSettings,
    analyze_pair,
    is_files,
    is_own_function,
    pairs_of,
)
from soft.segmentation import SOIL_CHOICES
from soft.sequence import ImageSequence
from soft.soilflow import SCHEMA_VERSION
from soft.soilflow_writer import FileWriter, MemoryWriter, SoilFlowWriter
from soft.travel import CameraSpeed

if TYPE_CHECKING:
    import xarray

# Distributions whose version may change a number in the result; OpenCV's is told by the library itself.
_DISTRIBUTIONS = ("softbed", "numpy", "scikit-image", "scikit-learn", "taichi", "xarray", "h5netcdf")
_AHEAD = 2
"""Pairs a core that an executor is given before the first of them is asked for: memory holds as many."""


@dataclass(frozen=True)
class _Told:
    """What all pairs tell together, for the attributes."""

    seconds: list[float]
    remarks: list[str]
    camera: CameraSpeed


def analyze(
    sequence: ImageSequence,
    *,
    method: str | Callable = DEFAULT,
    options: Mapping[str, object] | None = None,
    soil: str = "bright",
    camera: str = "median",
    vertical: bool = False,
    seed: int = 0,
    threads: int | None = None,
    device: str = "cpu",
    progress: Callable[[int, int], None] | None = None,
    path: str | Path | None = None,
    keep: str | Path | None = None,
    executor: Executor | None = None,
) -> "xarray.Dataset":
    """Measure soil flow between the pictures of every pair.

    For each pair: displacement (section 2.3), soil by grey level where the user's mask leaves it, camera
    motion as the median horizontal displacement over soil, inertial displacement, moving region by its
    magnitude, velocity where the sequence is calibrated (section 2.2). Whether a pixel is soil is told apart
    from whether its motion could be measured: displacement is measured over the whole picture or, by a method
    that keeps to a mask, over soil and 2 px around it, so that the implement's motion does not leak in.

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
    camera : str, optional
        `median`, `mode` or `far`, as in `to_inertial`.
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
    keep : str or Path, optional
        A folder that holds the flow of each pair as soon as it is measured. Called again with it after a
        stop, only what is missing, or depends on other pictures or settings, is measured, and the result has
        the same values. It is yours to remove once the result is safe. Nothing is kept of a function of your
        own, whose code may have changed.
    executor : concurrent.futures.Executor, optional
        Takes pairs, several at a time, each with `threads` threads: processes on this machine
        (`ProcessPoolExecutor`, of the context "spawn"), or whatever else is one. Everything that it is given
        must be picklable, a function of your own too. Results do not depend on it.

    Returns
    -------
    xarray.Dataset
        A SoilFlow; opened from `path`, if that is given, and then to be closed by the caller.

    Raises
    ------
    FlowError, SequenceError
        If the method or its options are refused, or a picture cannot be read.
    ValueError
        If `soil` or `camera` is another word.
    """
    _require_words(soil, camera)
    estimator = find_estimator(method)
    recorded = _resolved_options(method, dict(options or {}), len(sequence.pairs))
    settings = PairSettings(
        method=method,
        options=dict(options or {}),
        soil=soil,
        camera=camera,
        vertical=vertical,
        seed=seed,
        threads=threads,
        device=device,
        keeps_to_mask=estimator.keeps_to_mask,
        identity={
            "method": estimator.name, "options": recorded, "device": device, "versions": _versions(),
        },
        metres_per_pixel=sequence.metres_per_pixel,
        pair_time=sequence.pair_time,
    )  # fmt: skip
    keeps = keep is not None and not is_own_function(method) and not is_files(method)
    store = FlowStore(Path(keep)) if keep is not None and keeps else None
    writer = _writer(sequence, path, gridded=estimator.gridded)
    try:
        records = _records(pairs_of(sequence), settings, store, executor)
        told = _put_all(records, sequence, settings, writer, progress)
        return writer.finish(_attributes(sequence, settings, told))
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


def _records(
    pairs: Iterator[PairPictures],
    settings: PairSettings,
    store: FlowStore | None,
    executor: Executor | None,
) -> Iterator[PairRecord]:
    """What every pair gives, in their order."""
    if executor is None:
        yield from (analyze_pair(pair, settings, store) for pair in pairs)
        return
    ahead = _AHEAD * (os.cpu_count() or 1)
    waiting: deque[Future[PairRecord]] = deque()
    for pair in pairs:
        waiting.append(executor.submit(analyze_pair, pair, settings, store))
        if len(waiting) == ahead:
            yield waiting.popleft().result()
    while waiting:
        yield waiting.popleft().result()


def _put_all(
    records: Iterator[PairRecord],
    sequence: ImageSequence,
    settings: PairSettings,
    writer: SoilFlowWriter,
    progress: Callable[[int, int], None] | None,
) -> _Told:
    seconds: list[float] = []
    remarks: list[str] = []
    camera: list[tuple[float, float]] = []
    count = len(sequence.pairs)
    if progress:
        progress(0, count)
    for k, record in enumerate(records):
        writer.put(k, record.values)
        seconds.append(record.seconds)
        remarks += [f"pair {k}: {remark}" for remark in record.remarks]
        camera.append((record.values["camera_u"], record.values["camera_v"]))
        if progress:
            progress(k + 1, count)
    return _Told(seconds, remarks, _camera_speed(np.array(camera), sequence, settings))


def _camera_speed(camera: np.ndarray, sequence: ImageSequence, settings: PairSettings) -> CameraSpeed:
    scale = None
    if sequence.metres_per_pixel is not None and sequence.pair_time is not None:
        scale = sequence.metres_per_pixel / sequence.pair_time
    vertical = camera[:, 1] if settings.vertical else None
    return CameraSpeed.of(camera[:, 0], vertical, metres_per_second=scale)


def _require_words(soil: str, camera: str) -> None:
    """Refuse before any picture is read."""
    for name, word, allowed in (("soil", soil, SOIL_CHOICES), ("camera", camera, CAMERA_CHOICES)):
        if word not in allowed:
            raise ValueError(f"{name}: {word!r}: allowed are {', '.join(allowed)}")


def _resolved_options(
    method: str | Callable, options: dict[str, object], pair_count: int
) -> dict[str, object]:
    """Refuse what cannot work before any picture is read, and spell out every option."""
    if isinstance(method, str) and is_files(method):
        if "pair" in options:
            raise FlowError(f"method {method!r}: pair: is not to be given here")
        FlowFiles(method.removeprefix(PREFIX)).require_pairs(pair_count)
        return resolve_options(method, options | {"pair": 0})
    return resolve_options(method, options)


def _attributes(sequence: ImageSequence, settings: PairSettings, told: _Told) -> dict[str, object]:
    attributes: dict[str, object] = {
        "schema_version": SCHEMA_VERSION,
        "method": find_estimator(settings.method).name,
        "options": json.dumps(settings.identity["options"], sort_keys=True),
        "versions": json.dumps(settings.identity["versions"], sort_keys=True),
        "seconds_per_pair": float(np.mean(told.seconds)),
        "calibration": sequence.calibration,
        "camera": _camera_rule(settings),
        "camera_speed": str(told.camera),
        "vertical": int(settings.vertical),
        "soil": settings.soil,
        "masks": "none" if sequence.masks is None else "moving" if sequence.masks.moving else "static",
        "seed": settings.seed,
        "device": settings.device,
        "frames": json.dumps(sequence.names),
        "remarks": json.dumps([*filter(None, [sequence.remark]), *told.remarks]),
    }
    for name in ("metres_per_pixel", "frame_rate"):
        if (value := getattr(sequence, name)) is not None:
            attributes[name] = value
    # Pixel (0, 0) here is this one of the whole picture.
    region = sequence.region
    attributes["region_x"], attributes["region_y"] = (0, 0) if region is None else (region.x, region.y)
    return attributes


def _camera_rule(settings: PairSettings) -> str:
    found = {
        "median": "median",
        "mode": "mode (Lorentzian location around it)",
        "far": "far (what motion tends to far from the fastest soil)",
    }[settings.camera]
    vertical = "taken out too" if settings.vertical else "left as measured"
    return f"{found} of horizontal displacement over soil taken out, vertical {vertical}"


def _versions() -> dict[str, str]:
    import cv2

    found = {"python": platform.python_version(), "opencv": cv2.__version__}
    for name in _DISTRIBUTIONS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found
