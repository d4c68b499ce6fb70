"""Curves measured in parallel processes, one each; what is there already is not measured again."""

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from multiprocessing import get_context
from multiprocessing.managers import SyncManager
from pathlib import Path
from queue import Empty
from typing import TYPE_CHECKING, Any

from synth.disk import written_whole
from synth.text_files import read_json_object
from validation.drawbar.curve import GRAINS, Curve, CurveOrder
from validation.drawbar.interrupted import Begun, find_begun, keep_begun
from validation.drawbar.variation import find_variation
from validation.processes import end_with_parent, worker_processes
from validation.run_folder import RunFolder
from validation.terminal import Terminal
from validation.versions import package_version

if TYPE_CHECKING:
    from synth.rover.law.interface import WheelSoilLaw
    from synth.scene import SoilBinScene

CURVES = "curves"
"""Folder with one JSON file for each curve, forces on the wheels with it."""
GRAIN_SCENE = "studies/rover_bin"
"""Whose bin and soil the grains are of."""
_MADE_BY = ("softbed", "mujoco", "numpy")
_EXPECTED = 30
"""Points of a curve, for the progress."""
_POLL = 1.0  # s


def carry_out(
    orders: Sequence[CurveOrder],
    out: Path,
    *,
    processes: int | None = None,
    overwrite: bool = False,
    terminal: Terminal,
) -> list[Curve]:
    """Measure what is missing of some curves: `OUT/curves/NAME.json`.

    A curve that was interrupted is gone on with after its last load (grains: begun anew).

    Parameters
    ----------
    orders : sequence of CurveOrder
    out : Path
        Made where there is none.
    processes : int, optional
        Default: one a core.
    overwrite : bool
        Measure also what is there.

    Returns
    -------
    list of Curve
        In the order of `orders`.

    Raises
    ------
    RunFolderError
        The folder holds something else, or another process works in it.
    VehicleError, ValueError
        An order cannot be carried out; none is begun then.
    """
    for order in orders:
        _require(order)
    with RunFolder.create(out):
        folder = out / CURVES
        folder.mkdir(exist_ok=True)
        missing = [order for order in orders if overwrite or found_curve(folder, order) is None]
        if missing:
            _tell_begun(missing, folder, overwrite, terminal)
            count = min(processes or os.cpu_count() or 1, len(missing))
            with terminal.progress(f"drawbar, {count} processes") as progress:
                _in_parallel(_longest_first(missing), folder, count, progress)
        return [curve for order in orders if (curve := found_curve(folder, order)) is not None]


def measure(order: CurveOrder, begun: Begun | None = None) -> Iterator[Begun]:
    """Measure a curve, or go on with one; given after each point, as far as it is."""
    from synth.rover.drawbar import CYCLES, DrawbarTest
    from synth.rover.gaits import make_gait
    from synth.rover.vehicle import load_vehicle

    vehicle = load_vehicle(order.vehicle)
    if order.variation:
        variation = find_variation(order.variation)
        variation.on_vehicle(vehicle)
        gait = variation.gait(order.gait, vehicle, order.rim_speed)
    else:
        gait = make_gait(order.gait, vehicle, speed=order.rim_speed)
    cycles = 1 if order.law == GRAINS else CYCLES  # a bin has an end
    test = DrawbarTest(vehicle, law_of(order), gait, time_step=order.time_step, cycles=cycles)
    points = [] if begun is None else list(begun.curve.points)
    if begun is not None:
        test.restore(begun.state)
    for point in test.points(order.steps, done=tuple(points)):
        points.append(point)
        state = {} if order.law == GRAINS else test.state()
        yield Begun(Curve(order, vehicle.weight, tuple(points)), state)


def _require(order: CurveOrder) -> None:
    """Raise where an order cannot be carried out: before processes are started."""
    from synth.rover.gaits import make_gait
    from synth.rover.vehicle import load_vehicle

    make_gait(order.gait, load_vehicle(order.vehicle), speed=order.speed)
    if order.law != GRAINS:
        law_of(order)
    elif order.wheel != "rigid":
        raise ValueError(f"wheel = {order.wheel!r}: grains (--soil dem) are for rigid wheels")


def law_of(order: CurveOrder) -> "WheelSoilLaw":
    """The wheel-soil law of an order, with its soil; or the grains themselves."""
    if order.law == GRAINS:
        return _grains()
    from synth.rover.law.catalogue import make_law, read_soil

    soil = None if order.soil is None else read_soil(order.soil)
    if order.variation:
        soil = find_variation(order.variation).soil()
    return make_law(order.law, wheel=order.wheel, soil=soil)  # type: ignore[arg-type]


def _grains() -> "WheelSoilLaw":
    """The granular simulator, on one thread: curves are measured side by side."""
    from synth.dem.bed import settled_bed
    from synth.devices import start_taichi
    from synth.rover.grains.granular_soil import GranularSoil

    start_taichi(threads=1)
    scene = _grain_scene()
    return GranularSoil(scene, settled_bed(scene))


def _grain_scene() -> "SoilBinScene":
    from synth.scene import SoilBinScene, load_scene

    scene = load_scene(GRAIN_SCENE)
    assert isinstance(scene, SoilBinScene)
    return scene


def _longest_first(orders: Sequence[CurveOrder]) -> list[CurveOrder]:
    """What is varied or repeated comes after the rest, both gaits of a variation together."""

    def rank(order: CurveOrder) -> int:
        return 2 if order.variation or order.repeat else int(order.gait != "inching")

    return sorted(orders, key=rank)


def _in_parallel(
    orders: Sequence[CurveOrder], folder: Path, processes: int, progress: Callable[[int, int], None]
) -> None:
    manager = SyncManager(ctx=get_context("spawn"))
    manager.start(initializer=end_with_parent)
    with manager, worker_processes(processes) as pool:
        told = manager.Queue()
        _watch([pool.submit(_carry_out_one, order, folder, told) for order in orders], told, progress)


def _watch(futures: Sequence[Future[None]], told: Any, progress: Callable[[int, int], None]) -> None:
    waiting, points = set(futures), 0
    while waiting:
        done, waiting = wait(waiting, timeout=_POLL, return_when=FIRST_COMPLETED)
        for future in done:
            future.result()
        while True:
            try:
                points += told.get_nowait()
            except Empty:
                break
        finished = (len(futures) - len(waiting)) * _EXPECTED
        total = len(futures) * _EXPECTED
        progress(min(max(points, finished), total - bool(waiting)), total)


def _carry_out_one(order: CurveOrder, folder: Path, told: Any) -> None:
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    by, path = made_by(order), _begun_path(folder, order)
    so_far, _ = find_begun(path, order, by)
    for begun in measure(order, so_far):
        so_far = begun
        if so_far.state:
            keep_begun(path, so_far, by)
        told.put(1)
    assert so_far is not None
    document = so_far.curve.to_dict() | {"made_by": by}
    with written_whole(folder / f"{order.name}.json") as draft:
        draft.write_text(json.dumps(document, indent=1), encoding="utf-8")
    path.unlink(missing_ok=True)


def _begun_path(folder: Path, order: CurveOrder) -> Path:
    return folder / f".begun-{order.name}.npz"


def _tell_begun(orders: Sequence[CurveOrder], folder: Path, overwrite: bool, terminal: Terminal) -> None:
    """Say which curves are gone on with and which are not, and why; with `overwrite`, none is."""
    for order in orders:
        path = _begun_path(folder, order)
        if overwrite:
            path.unlink(missing_ok=True)
        begun, unfit = find_begun(path, order, made_by(order))
        if begun is not None:
            terminal.say(f"{order.name}: goes on, {len(begun.curve.points)} of its points measured")
        elif unfit:
            terminal.say(unfit)


def found_curve(folder: Path, order: CurveOrder) -> Curve | None:
    """The curve, if it is there, whole, and was made from the same by the same."""
    path = folder / f"{order.name}.json"
    if not path.is_file():
        return None
    try:
        told = read_json_object(path)
        by, curve = told.pop("made_by"), Curve.from_dict(told)
    except (ValueError, KeyError, TypeError, AttributeError):  # somebody has changed it
        return None
    return curve if by == made_by(order) and curve.order == order else None


def made_by(order: CurveOrder) -> dict[str, str]:
    """What a curve depends on besides its order: versions, the vehicle's files, the soil's constants."""
    from synth.rover.vehicle import load_vehicle

    digest = hashlib.sha256()
    for path in sorted(load_vehicle(order.vehicle).path.parent.glob("*.xml")):
        digest.update(path.read_bytes())
    versions = {name: package_version(name) for name in _MADE_BY}
    soil = _grain_scene() if order.law == GRAINS else getattr(law_of(order), "soil", None)
    return versions | {"vehicle": digest.hexdigest(), "soil": repr(soil)}
