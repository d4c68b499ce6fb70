"""A film of one inching cycle, the forces of the soil drawn at the wheels."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from validation.drawbar.curve import Curve, CurveOrder
from validation.drawbar.experiment import law_of
from validation.drawbar.scene_picture import SceneCamera, Size, camera_on
from validation.terminal import Progress, Terminal

if TYPE_CHECKING:
    from synth.rover.ride import Ride

_RATE = 25.0  # pictures a second
_HASTE = 3.0  # seconds of the vehicle in one of the film
_BEFORE = 1.0  # s at rest
_LETTERS = 0.58
_TOLD = {"expand": "expanding: front rolls, rear pushes", "contract": "contracting: rear rolls, front pushes"}


def film_of_a_cycle(curves: Sequence[Curve], path: Path, *, terminal: Terminal) -> Path:
    """Film the second inching cycle at half the maximum pull of the first inching curve.

    Raises
    ------
    ValueError
        No curve is of the inching gait.
    """
    inching = [curve for curve in curves if curve.order.gait == "inching"]
    if not inching:
        raise ValueError("--film shows an inching cycle: --gait inching is needed")
    curve = inching[0]
    with terminal.progress("film") as progress:
        film_order(curve.order, path, pull=0.5 * curve.maximum, progress=progress)
    return path


def film_order(order: CurveOrder, path: Path, *, pull: float, progress: Progress | None = None) -> None:
    """Film the second cycle of an order's gait at a drawbar pull over weight of `pull`.

    Parameters
    ----------
    path : Path
        `.mp4` or `.gif`.
    """
    from soft.figures.film_file import film_file

    with film_file(path, rate=_RATE) as film:
        for picture in _pictures(order, pull, progress):
            film.add(picture)


def _pictures(order: CurveOrder, pull: float, progress: Progress | None) -> Iterator[NDArray]:
    from synth.rover.gaits import make_gait
    from synth.rover.ride import Ride
    from synth.rover.vehicle import load_vehicle

    vehicle = load_vehicle(order.vehicle)
    gait = make_gait(order.gait, vehicle, speed=order.speed)
    ride = Ride(vehicle, law_of(order), stance=gait.stance)
    cycle = gait.cycle or 10.0
    apart = round(_HASTE / _RATE / ride.time_step)
    first, last = round((_BEFORE + cycle) / ride.time_step), round((_BEFORE + 2 * cycle) / ride.time_step)
    with camera_on(vehicle, Size()) as camera:
        at = 0.0
        for step in range(last):
            time = max(0.0, ride.time - _BEFORE)
            ride.pull = pull * vehicle.weight * min(1.0, time / _BEFORE)
            ride.step(gait.command(time))
            if step == first:
                at = ride.travel + 0.2
            if step >= first and (step - first) % apart == 0:
                yield _labelled(camera, ride, at, _TOLD.get(gait.phase(time), gait.phase(time)), pull)
            if progress and step % 1000 == 0:
                progress(step, last)


def _labelled(camera: SceneCamera, ride: "Ride", at: float, phase: str, pull: float) -> NDArray:
    import cv2

    picture = np.ascontiguousarray(camera.picture(ride.data, at=at, ride=ride))
    front, rear = _axle_shares(ride)
    lines = (
        phase,
        f"cable {pull:.2f} of the weight; soil on front axle {front:+.2f}, on rear axle {rear:+.2f}",
        "green: thrust, red: resistance, black: cable; blue: load, drawn to a quarter of their scale",
    )
    for row, line in enumerate(lines):
        place = (18, 32 + 26 * row)
        cv2.putText(picture, line, place, cv2.FONT_HERSHEY_SIMPLEX, _LETTERS, (30, 30, 30), 1, cv2.LINE_AA)
    return picture


def _axle_shares(ride: "Ride") -> tuple[float, float]:
    """Horizontal force of the soil on the front and the rear axle over the vehicle's weight."""
    shares = ride.forces.force_x / ride.vehicle.weight
    rear = np.zeros(shares.size, bool)
    rear[ride.vehicle.rear_wheels] = True
    return float(shares[~rear].sum()), float(shares[rear].sum())
