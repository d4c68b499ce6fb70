"""The report's figures: each a `matplotlib.figure.Figure` of its own, no global state."""

import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.pair_view import Measured, Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH = 6.4
_DOTS_PER_INCH = 150
_DIRECTION_ABOVE = 0.3
"""px a frame; slower soil has no direction worth a colour."""
_ERROR_RANGE = (0.03, 3.0)
_MISSED = "#d62aa5"
_STRATUM_COLOURS = {"quiet": "#4c78a8", "moving": "#54a24b", "complex": "#e45756"}


def to_png(figure: "Figure") -> bytes:
    """Encode a figure as PNG."""
    buffer = io.BytesIO()
    # Without the date and the version: equal figures, equal bytes.
    figure.savefig(buffer, format="png", dpi=_DOTS_PER_INCH, metadata={"Software": None})
    return buffer.getvalue()


def draw_picture(picture: np.ndarray) -> "Figure":
    """Show the picture as the camera took it; (H, W) grey levels 0-255."""
    figure, axes = _map_figure(picture.shape)
    axes.imshow(picture, cmap="gray", vmin=0, vmax=255)
    return figure


def draw_speed(motion: Motion, picture: np.ndarray, *, top: float) -> "Figure":
    """Speed in the inertial frame over the picture, from 0 to `top` px a frame."""
    from cmcrameri import cm

    figure, axes = _map_figure(picture.shape)
    _show_faint(axes, picture)
    image = axes.imshow(motion.speed, cmap=cm.batlow, vmin=0, vmax=top)
    _colour_bar(figure, axes, image, "speed [px/frame]", extend="max")
    return figure


def draw_direction(motion: Motion, picture: np.ndarray) -> "Figure":
    """Direction in the inertial frame over the picture, where soil moves at all."""
    from cmcrameri import cm

    with np.errstate(invalid="ignore"):
        shown = np.where(motion.speed > _DIRECTION_ABOVE, motion.direction, np.nan)
    figure, axes = _map_figure(picture.shape)
    _show_faint(axes, picture)
    image = axes.imshow(shown, cmap=cm.romaO, vmin=-np.pi, vmax=np.pi)
    bar = _colour_bar(figure, axes, image, "direction")
    bar.set_ticks([-np.pi, -np.pi / 2, 0, np.pi / 2, np.pi], labels=["left", "down", "right", "up", "left"])
    return figure


def draw_strata(strata: Mapping[str, np.ndarray], picture: np.ndarray) -> "Figure":
    """Which pixels are quiet, moving, and complex; (H, W) bool masks."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    figure, axes = _map_figure(picture.shape)
    _show_faint(axes, picture)
    for name, colour in _STRATUM_COLOURS.items():
        axes.imshow(np.where(strata[name], 1.0, np.nan), cmap=ListedColormap([colour]))
    patches = [Patch(color=colour, label=name) for name, colour in _STRATUM_COLOURS.items()]
    figure.legend(handles=patches, loc="outside upper right", ncols=3, frameon=False, fontsize=9)
    return figure


def draw_error(measured: Measured, picture: np.ndarray) -> "Figure":
    """End-point error over true soil on a logarithmic scale; what was not measured is magenta."""
    from cmcrameri import cm
    from matplotlib.colors import ListedColormap, LogNorm

    figure, axes = _map_figure(picture.shape)
    _show_faint(axes, picture)
    low, high = _ERROR_RANGE
    image = axes.imshow(
        measured.shown(measured.error).clip(low, None),
        cmap=cm.lajolla_r,
        norm=LogNorm(low, high),
    )
    if measured.missed.any():
        missed = measured.shown(np.where(measured.missed, 1.0, np.nan))
        axes.imshow(missed, cmap=ListedColormap([_MISSED]))
    bar = _colour_bar(figure, axes, image, "end-point error [px]", extend="both")
    bar.set_ticks([0.03, 0.1, 0.3, 1, 3], labels=["0.03", "0.1", "0.3", "1", "3"])
    return figure


def draw_histogram(
    measured: Measured, strata: Mapping[str, np.ndarray], *, published: Mapping[str, float] | None = None
) -> "Figure":
    """Distribution of the error in each stratum, with the median and 95 % of all.

    Parameters
    ----------
    measured : Measured
        One method on one pair.
    strata : mapping
        (H, W) bool masks.
    published : mapping, optional
        Published errors in px by name, drawn beside.
    """
    figure, axes = _figure(height=0.62 * _WIDTH)
    axes.set_xscale("log")
    edges = np.geomspace(0.003, 30, 81)
    for name, colour in _STRATUM_COLOURS.items():
        error = measured.error[strata[name]]
        error = error[np.isfinite(error)].clip(edges[0], edges[-1])
        if error.size:
            share, _ = np.histogram(error, edges)
            axes.stairs(100 * share / error.size, edges, color=colour, label=name, linewidth=1.8)
    _mark_percentiles(axes, measured.error)
    for name, value in (published or {}).items():
        axes.axvline(value, color="black", linestyle=":", label=f"published {name} {value:.2f} px")
    axes.set_xlim(edges[0], edges[-1])
    axes.set_xlabel("end-point error [px]")
    axes.set_ylabel("pixels of the stratum [%]")
    axes.legend(frameon=False, fontsize=9)
    return figure


def _mark_percentiles(axes: "Axes", error: np.ndarray) -> None:
    known = error[np.isfinite(error)]
    if not known.size:
        return
    for name, percent, style in (("median", 50, "-"), ("95 %", 95, "--")):
        value = np.percentile(known, percent)
        label = f"{name} of all {value:.2f} px"
        axes.axvline(value, color="black", linestyle=style, linewidth=1.2, label=label)


def draw_forces(forces: Mapping[str, np.ndarray], *, marked: float | None = None) -> "Figure":
    """Slip, sinkage, drawbar pull and normal force over time.

    Parameters
    ----------
    forces : mapping
        (N,) arrays `time` (s), `slip` (1), `sinkage` (m), `force_x`, `force_z` (N).
    marked : float, optional
        Time of the pair that is shown, s.
    """
    from matplotlib.figure import Figure

    rows: Sequence[tuple[str, str, float]] = (
        ("slip", "slip [%]", 100.0),
        ("sinkage", "sinkage [mm]", 1000.0),
        ("force_x", "drawbar pull [N]", 1.0),
        ("force_z", "normal force [N]", 1.0),
    )
    figure = Figure(figsize=(1.5 * _WIDTH, 0.9 * _WIDTH), layout="constrained")
    grid = figure.subplots(2, 2, sharex=True).ravel()
    for axes, (name, label, scale), colour in zip(
        grid, rows, ("#4c78a8", "#b07d2b", "#e45756", "#54a24b"), strict=True
    ):
        values = scale * forces[name]
        axes.plot(forces["time"], values, color=colour, linewidth=1.4)
        axes.set_ylabel(label)
        axes.set_ylim(*_around(values))
        if marked is not None:
            axes.axvline(marked, color="grey", linewidth=0.8, linestyle=":")
        _plain(axes)
    for axes in grid[2:]:
        axes.set_xlabel("time [s]")
    return figure


def _around(values: np.ndarray) -> tuple[float, float]:
    """Limits that show 0, and do not blow up what is constant."""
    low, high = min(0.0, float(np.nanmin(values))), max(0.0, float(np.nanmax(values)))
    room = 0.08 * (high - low) or 1.0
    return low - (room if low < 0 else 0), high + room


def _figure(*, height: float) -> "tuple[Figure, Axes]":
    from matplotlib.figure import Figure

    figure = Figure(figsize=(_WIDTH, height), layout="constrained")
    axes = figure.subplots()
    _plain(axes)
    return figure, axes


def _plain(axes: "Axes") -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)


def _map_figure(shape: tuple[int, ...]) -> "tuple[Figure, Axes]":
    from matplotlib.figure import Figure

    height = min(max(_WIDTH * 0.84 * shape[0] / shape[1] + 0.5, 2.2), 1.2 * _WIDTH)
    figure = Figure(figsize=(_WIDTH, height), layout="constrained")
    axes = figure.subplots()
    axes.set_xlabel("x [px]")
    axes.set_ylabel("y, down [px]")
    return figure, axes


def _show_faint(axes: "Axes", picture: np.ndarray) -> None:
    # Bright, so that colours stand out and what is not soil stays recognizable.
    axes.imshow(picture, cmap="gray", vmin=-500, vmax=255)


def _colour_bar(figure: "Figure", axes: "Axes", image: Any, label: str, *, extend: str = "neither") -> Any:
    return figure.colorbar(image, ax=axes, label=label, extend=extend, fraction=0.046, pad=0.02, aspect=18)
