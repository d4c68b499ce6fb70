"""Every kind of figure that the command line draws. Its help names them, so nothing heavy is imported."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from validation.showing.subject import Subject


@dataclass(frozen=True, eq=False)
class Order:
    """What is to be drawn.

    Attributes
    ----------
    subject : Subject
        The pictures and their analysis.
    pair : int
        Which pair.
    colours : str
        `even` or `paper`.
    other : Subject, optional
        What is set beside it.
    """

    subject: "Subject"
    pair: int
    colours: str = "even"
    other: "Subject | None" = None


@dataclass(frozen=True)
class Kind:
    """A kind of figure: what it shows, and what draws it."""

    about: str
    draw: "Callable[[Order], Figure]"


def draw_figure(kind: str, order: Order) -> "Figure":
    """Draw one of `KINDS`.

    Raises
    ------
    RunFolderError
        It is none of them, or needs what was not given.
    ScoreError
        It needs the truth, and there is none.
    """
    require_kind(kind)
    return KINDS[kind].draw(order)


def require_kind(kind: str) -> None:
    """Refuse a kind of figure that there is not.

    Raises
    ------
    RunFolderError
        It is none of `KINDS`.
    """
    from validation.manifest import RunFolderError

    if kind not in KINDS:
        raise RunFolderError(f"{kind!r}: no such kind of figure: allowed are {', '.join(KINDS)}")


def _picture(order: Order) -> "Figure":
    from soft.figures import picture_figure

    frame = int(order.subject.flow["first_frame"][order.pair])
    scale = order.subject.flow.attrs.get("metres_per_pixel")
    picture = order.subject.picture(order.pair)
    return picture_figure(picture, metres_per_pixel=scale, title=f"{order.subject.name}, frame {frame}")


def _measured(name: str, *, interface: bool = True, **options: str) -> "Callable[[Order], Figure]":
    """Draw by a function of `soft.figures` that takes a flow and a picture."""

    def draw(order: Order) -> "Figure":
        from soft import figures, shear_interface_of

        subject, pair = order.subject, order.pair
        line = {"interface": shear_interface_of(subject.flow, pair=pair)} if interface else {}
        make = getattr(figures, name)
        return make(subject.flow, subject.picture(pair), pair=pair, colours=order.colours, **line, **options)

    return draw


def _sift(order: Order) -> "Figure":
    import numpy as np

    from soft import cross_validate, segments_figure

    subject = order.subject
    part = subject.flow[["u", "v", "valid", "soil"]].isel(pair=order.pair).load()
    second = subject.material.sequence[int(subject.flow["second_frame"][order.pair])]
    first = subject.picture(order.pair)
    displacement = np.stack([part["u"].to_numpy(), part["v"].to_numpy()], axis=-1)
    soil, valid = part["soil"].to_numpy(), part["valid"].to_numpy()
    compared = cross_validate(first, second, displacement, valid, mask=soil)
    scale = subject.flow.attrs.get("metres_per_pixel")
    return segments_figure(compared, first, metres_per_pixel=scale, colours=order.colours)


def _average(order: Order) -> "Figure":
    from soft import average_figure, average_flow
    from soft.shear_interface import shear_interface_of_mean

    flow, picture = order.subject.flow, order.subject.picture(order.pair)
    mean = average_flow(flow)
    line = shear_interface_of_mean(mean, seed=int(flow.attrs.get("seed", 0)))
    interface = line if line.lines else None
    return average_figure(flow, mean, picture, pair=order.pair, interface=interface, colours=order.colours)


def _gain(order: Order) -> "Figure":
    from soft import average_flow, gain_figure

    return gain_figure(average_flow(order.subject.flow))


def _compare(order: Order) -> "Figure":
    from soft import comparison_figure, shear_interface_of
    from validation.manifest import RunFolderError

    if order.other is None:
        raise RunFolderError("compare: needs what to set beside: give --with PATH")
    order.other.require_pair(order.pair)
    both = (order.subject, order.other)
    runs = [(f"{one.name}, pair {order.pair}", one.flow, one.picture(order.pair)) for one in both]
    lines = [shear_interface_of(one.flow, pair=order.pair) for one in both]
    return comparison_figure(runs, pair=order.pair, interfaces=lines, colours=order.colours)


def _truth(order: Order) -> "Figure":
    from validation.figures.truth import truth_figure

    view = order.subject.view(order.pair)
    return truth_figure(view, order.subject.method.name, colours=order.colours)


def _error(order: Order) -> "Figure":
    from validation.figures.truth import error_figure

    view = order.subject.view(order.pair)
    return error_figure(view, order.subject.method.name, colours=order.colours)


def _distribution(order: Order) -> "Figure":
    from validation.figures.distribution import distribution_figure
    from validation.published import read_published
    from validation.scoring.score_table import is_published_rotation

    view, name = order.subject.view(order.pair), order.subject.method.name
    published = {}
    if is_published_rotation(order.subject.run):
        rows = read_published("rotation")
        published = {"median": rows["median"].value, "95 %": rows["p95"].value}
    return distribution_figure(view.measured[name], view.strata, name=name, published=published)


KINDS = {
    "picture": Kind("what the camera saw", _picture),
    "speed": Kind("speed and shear interface (Fig. 10)", _measured("speed_figure")),
    "direction": Kind("direction and colour wheel (Fig. 19)", _measured("direction_figure")),
    "motion": Kind("speed above direction (Fig. 4)", _measured("motion_figure")),
    "bucket": Kind("where a tool pushes soil, with arrows (Fig. 20)", _measured("bucket_figure")),
    "sift": Kind("motion at key points against SIFT (Fig. 11)", _sift),
    "average": Kind("one pair above the average of all (Figs. 12, 13)", _average),
    "gain": Kind("what averaging gains, beside the square root of N", _gain),
    "compare": Kind("two runs beside each other (Figs. 18, 19); --with PATH", _compare),
    "shear": Kind("shear rate", _measured("deformation_figure", quantity="shear")),
    "rotation": Kind("rotation rate", _measured("deformation_figure", quantity="rotation")),
    "dilation": Kind("dilation rate, the divergence", _measured("deformation_figure", quantity="dilation")),
    "streamlines": Kind("lines along which soil moves", _measured("streamlines_figure")),
    "profile": Kind("velocity over depth below the wheel", _measured("profile_figure", interface=False)),
    "truth": Kind("truth beside measurement (Fig. 6)", _truth),
    "error": Kind("error at each pixel (Fig. 7)", _error),
    "distribution": Kind("error by magnitude, with its bounds (Figs. 8, 9)", _distribution),
}
