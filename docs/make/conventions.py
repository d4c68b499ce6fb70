"""The drawing of docs/conventions.md: python docs/make/conventions.py FILE.png."""

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, Rectangle

SOIL, WHEEL, INK, FIRST, SECOND = "#d9c4a0", "#5b6670", "#222222", "#1f6fb2", "#c2571a"
ARROW = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.4, "shrinkA": 0, "shrinkB": 0}
# Numbers of the drawing alone: a bin of 4.2 by 1.3, a wheel of radius 0.62.
SURFACE, AXLE, RADIUS = 1.3, (1.55, 1.78), 0.62


def arrow(axes: Axes, tail: tuple[float, float], tip: tuple[float, float], **style: object) -> None:
    """From tail to tip, in the axes' coordinates."""
    axes.annotate("", xy=tip, xytext=tail, arrowprops=ARROW | style)


def draw_world(axes: Axes) -> None:
    """The bin's frame, the wheel's signs, the forces, the camera's view."""
    axes.add_patch(Rectangle((0, 0), 4.2, SURFACE, facecolor=SOIL))
    axes.add_patch(Circle(AXLE, RADIUS, facecolor=WHEEL, edgecolor=INK, alpha=0.85))
    axes.plot([0, 0, 4.2, 4.2], [2.6, 0, 0, 2.6], color=INK, linewidth=2)
    arrow(axes, (0, 0), (0.62, 0), linewidth=2.2)
    arrow(axes, (0, 0), (0, 0.62), linewidth=2.2)
    axes.text(0.68, 0.06, "x [m], along the bin", va="bottom")
    axes.text(0.07, 0.6, "z [m], up", va="center")
    axes.text(-0.05, -0.07, "(0, 0): left end wall, floor", va="top")
    draw_wheel(axes)
    axes.add_patch(Rectangle((0.85, 0.55), 2.9, 1.5, fill=False, linestyle="--", edgecolor=FIRST))
    axes.plot(2.3, 1.3, "+", color=FIRST)
    axes.text(3.72, 0.6, "picture; + centre_x, centre_z", ha="right", va="bottom", color=FIRST)
    axes.set(xlim=(-0.25, 4.35), ylim=(-0.3, 2.95), title="World: metres, seconds, newtons, radians")


def draw_wheel(axes: Axes) -> None:
    """Turning and travelling to the right, and what the soil does to it."""
    x, z = AXLE
    axes.plot(x, z, "o", color="white", markersize=4)
    axes.add_patch(Arc(AXLE, 0.72, 0.72, theta1=40, theta2=140, color="white", linewidth=1.6))
    turned = np.radians(40)
    tip = (x + 0.36 * np.cos(turned), z + 0.36 * np.sin(turned))
    arrow(axes, (tip[0] - 0.03, tip[1] + 0.035), (tip[0] + 0.02, tip[1] - 0.03), color="white")
    axes.text(x, z + 0.16, "ω < 0", ha="center", color="white")
    arrow(axes, (x, z - 0.08), (x + 0.5, z - 0.08), color="white")
    axes.text(x + 0.1, z - 0.2, "v > 0", color="white", va="center")
    axes.text(2.2, 2.62, "slip = 1 − v / (r |ω|) > 0 drives,  < 0 is skid: r |ω| / v − 1", ha="center")
    lowest = z - RADIUS
    axes.plot([x, x + 1.0], [lowest, lowest], color=INK, linewidth=0.8)
    arrow(axes, (x + 0.9, SURFACE), (x + 0.9, lowest), arrowstyle="<|-|>", mutation_scale=7)
    axes.text(x + 0.96, (SURFACE + lowest) / 2, "sinkage > 0", va="center")
    arrow(axes, (x - 0.05, lowest), (x + 0.45, lowest - 0.0), color=SECOND)
    axes.text(x + 0.2, lowest - 0.05, "force_x > 0 pulls", va="top", color=SECOND)
    arrow(axes, (x - 0.05, lowest - 0.5), (x - 0.05, lowest), color=SECOND)
    axes.text(x - 0.1, lowest - 0.35, "force_z > 0\nbears", ha="right", color=SECOND)
    axes.add_patch(Arc(AXLE, 1.66, 1.66, theta1=125, theta2=165, color=SECOND, linewidth=1.4))
    end = np.radians(165)
    foot = (x + 0.83 * np.cos(end), z + 0.83 * np.sin(end))
    arrow(axes, (foot[0] + 0.01, foot[1] + 0.04), (foot[0] - 0.01, foot[1] - 0.03), color=SECOND)
    axes.text(0.72, 2.25, "torque > 0\nresists", ha="right", va="center", color=SECOND)


def draw_pixels(axes: Axes) -> None:
    """Where a picture's pixels are."""
    for y in range(3):
        for x in range(4):
            axes.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor="#f3ecdd", edgecolor="#9a9a9a"))
            axes.plot(x, y, ".", color=INK, markersize=5)
            axes.text(x, y + 0.14, f"({x}, {y})", ha="center", va="top", fontsize=8)
    arrow(axes, (0, 0), (0.82, 0), color=FIRST, linewidth=2)
    arrow(axes, (0, 0), (0, 0.82), color=FIRST, linewidth=2)
    axes.text(0.6, -0.12, "x, u", color=FIRST, ha="center")
    axes.text(-0.08, 0.62, "y, v", color=FIRST, ha="right", va="center")
    axes.plot(-0.5, -0.5, "s", color=SECOND, markersize=6, clip_on=False)
    axes.text(-0.5, -0.66, "corner (−0.5, −0.5)", color=SECOND, va="bottom")
    axes.plot(1.5, 1, "+", color=SECOND, markersize=11, markeredgewidth=2)
    axes.text(1.55, 0.93, "middle of\nthe picture", color=SECOND, fontsize=8, va="bottom")
    axes.set(xlim=(-0.8, 3.7), ylim=(2.75, -1.05), title="Picture: whole numbers at pixel centres")


def draw_displacement(axes: Axes) -> None:
    """A grain in both pictures, and where its displacement is kept."""
    for edge in np.arange(-0.5, 5):
        axes.plot([edge, edge], [-0.5, 3.5], color="#c8c8c8", linewidth=0.8)
        if edge < 4:
            axes.plot([-0.5, 4.5], [edge, edge], color="#c8c8c8", linewidth=0.8)
    first, second = (1.0, 1.0), (3.4, 2.3)
    axes.add_patch(Rectangle((0.5, 0.5), 1, 1, facecolor=FIRST, alpha=0.18))
    axes.add_patch(Circle((0.9, 0.93), 0.42, fill=False, edgecolor=FIRST, linewidth=1.8))
    axes.add_patch(Circle((3.3, 2.23), 0.42, fill=False, edgecolor=SECOND, linewidth=1.8, linestyle="--"))
    arrow(axes, first, second, linewidth=2)
    axes.plot([1, 3.4, 3.4], [1, 1, 2.3], color=INK, linewidth=0.8, linestyle=":")
    axes.text(2.3, 0.93, "u = +2.4 px", ha="center", va="bottom")
    axes.text(3.46, 1.45, "v = +1.3 px", va="center", fontsize=9)
    axes.text(-0.4, 0.35, "grain in the first picture:\nkept at pixel (1, 1)", color=FIRST, va="bottom")
    axes.text(4.45, 2.75, "the same grain\nin the second picture", color=SECOND, ha="right", va="top")
    axes.plot(2.2, 1.65, "x", color="#999999", markersize=9, markeredgewidth=2)
    axes.text(2.1, 1.85, "not here\n(mid-point)", color="#777777", ha="right", va="top")
    axes.set(xlim=(-0.7, 4.75), ylim=(3.75, -0.75), title="Displacement: forward, on the first picture")


def draw_senses(axes: Axes) -> None:
    """Which way angles are counted, and what a travelling camera sees."""
    rows = (
        (2.55, FIRST, True, "implement_angle, ω, torque, direction:\ncounter-clockwise, as seen; up is +π/2"),
        (1.35, SECOND, False, "truth's rotation, from x to y:\nclockwise, as seen"),
    )
    for height, colour, counter, words in rows:
        axes.add_patch(Arc((0.55, height), 0.8, 0.8, theta1=-60, theta2=200, color=colour, linewidth=2))
        angle, sense = (np.radians(200), 1) if counter else (np.radians(-60), -1)
        tip = np.array([0.55 + 0.4 * np.cos(angle), height + 0.4 * np.sin(angle)])
        along = sense * np.array([-np.sin(angle), np.cos(angle)])
        arrow(axes, tuple(tip - 0.06 * along), tuple(tip + 0.08 * along), color=colour, linewidth=2)
        axes.text(1.2, height, words, va="center", color=colour)
    axes.add_patch(Rectangle((0.2, 0.12), 0.5, 0.36, facecolor=WHEEL))
    arrow(axes, (0.7, 0.3), (1.1, 0.3))
    axes.text(1.2, 0.3, "a camera that travels right sees resting\nsoil go left: camera_u < 0", va="center")
    axes.set(xlim=(0, 4.6), ylim=(-0.15, 3.2), title="Senses of rotation, and the camera")


def drawing() -> Figure:
    """All four parts on one page."""
    figure = Figure(figsize=(11.6, 7.7), layout="constrained")
    parts = figure.subplots(2, 2, width_ratios=(1.25, 1))
    for draw, axes in zip((draw_world, draw_pixels, draw_displacement, draw_senses), parts.flat, strict=True):
        draw(axes)
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_title(axes.get_title(), fontsize=12, fontweight="bold")
    return figure


if __name__ == "__main__":
    drawing().savefig(Path(sys.argv[1]), dpi=100)
