"""A film of a measurement with the truth, where that is known."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from validation.showing.subject import Subject

if TYPE_CHECKING:
    import numpy as np

    from soft import ImageSequence
    from soft.figures.film import Shot
    from soft.figures.units import Units
    from synth import Footage
    from validation.material import Material
    from validation.pair_view import PairView


def film(
    subject: Subject,
    path: Path,
    *,
    colours: str = "even",
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write a film: picture, measured speed, true speed and error; without truth picture, speed, direction.

    The shear interface is drawn over speed and direction, the measured one and that in the true speeds.

    Parameters
    ----------
    subject : Subject
        An analysis and its pictures.
    path : Path
        `.mp4` (VP9, for browsers) or `.gif`.
    colours : str, optional
        `even` or `paper`.
    progress : callable, optional
        Called with the pairs done and in all.
    """
    from soft.figures.colours import find_colours
    from soft.figures.film import Panel, flow_film, speed_panel, write_film
    from soft.figures.units import Units
    from validation.figures.maps import ERROR_RANGE

    sequence = subject.material.sequence
    if not subject.material.has_truth:
        flow_film(subject.flow, sequence, path, colours=colours, progress=progress)
        return
    chosen, units = find_colours(colours), Units.of_flow(subject.flow)
    low, high = ERROR_RANGE
    measured = speed_panel(subject.flow, chosen, units, title=f"Measured speed ({subject.method.name})")
    panels = [
        Panel("Picture"),
        measured,
        Panel("True speed", measured.colours, measured.label, measured.low, measured.high),
        Panel("Error", chosen.error, "end-point error [px]", low, high, logarithmic=True),
    ]
    write_film(
        path, panels, _shots(subject), shape=sequence.shape, units=units,
        rate=sequence.frame_rate, count=subject.pair_count, colours=chosen, progress=progress,
    )  # fmt: skip


def truth_film(
    material: "Material", path: Path, *, progress: Callable[[int, int], None] | None = None
) -> None:
    """Write a film of pictures that nobody has measured: picture, true speed, true direction."""
    import synth
    from soft.figures.colours import find_colours
    from soft.figures.film import Panel, direction_panel, write_film
    from soft.figures.units import Units
    from soft.figures.view import top_of
    from validation.pair_view import true_motion

    sequence, chosen = material.sequence, find_colours("even")
    units = Units.of(metres_per_pixel=sequence.metres_per_pixel, frame_rate=sequence.frame_rate)
    with synth.Footage.open(material.folder) as footage:
        count = footage.pair_count
        top = units.speed * top_of(true_motion(footage.truth((count - 1) // 2)).speed)
        speed = Panel("True speed", chosen.speed, f"speed [{units.speed_name}]", 0.0, top)
        write_film(
            path, [Panel("Picture"), speed, direction_panel(chosen, title="True direction")],
            _true_shots(footage, sequence, units), shape=sequence.shape, units=units,
            rate=sequence.frame_rate, count=count, colours=chosen, progress=progress,
        )  # fmt: skip


def _true_shots(footage: "Footage", sequence: "ImageSequence", units: "Units") -> "Iterator[Shot]":
    from soft.figures.film import Shot, label_of
    from soft.figures.view import reduced, smoothed, stride_of
    from validation.pair_view import true_motion
    from validation.scoring.truth_pass import TruePair

    stride = stride_of(sequence.shape)
    for pair in range(footage.pair_count):
        true = TruePair(footage.truth(pair).load())
        motion = true_motion(true.data, true.strata)
        maps = (None, reduced(units.speed * motion.speed, stride), reduced(motion.shown_direction, stride))
        picture, lines = smoothed(sequence[pair], stride), true.interface.lines
        yield Shot(label_of(footage.truths, pair), picture, maps, ((), lines, lines))


def _shots(subject: Subject) -> "Iterator[Shot]":
    from soft import shear_interface_of
    from soft.figures.film import Shot, label_of
    from soft.figures.view import smoothed, stride_of

    for pair in range(subject.pair_count):
        true = subject.true_pair(pair)
        view = subject.view(pair, true=true)
        picture = smoothed(view.picture, stride_of(view.picture.shape))
        maps = (None, *_maps(view, subject.method.name))
        lines = ((), shear_interface_of(subject.flow, pair=pair).lines, true.interface.lines)
        yield Shot(label_of(subject.flow, pair), picture, maps, lines)


def _maps(view: "PairView", name: str) -> "Iterator[np.ndarray]":
    """Measured speed, true speed in the unit of the page, and the error, px."""
    from soft.figures.view import reduced, stride_of
    from validation.figures.maps import ERROR_RANGE

    measured, stride = view.measured[name], stride_of(view.picture.shape)
    yield reduced(view.units.speed * measured.motion.speed, stride)
    yield reduced(view.units.speed * view.truth.speed, stride)
    yield reduced(measured.shown(measured.error).clip(ERROR_RANGE[0], None), stride)
