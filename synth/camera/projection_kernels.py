# type: ignore  # taichi reads annotations and operators in its own way
"""The view inside kernels: the same formulas as `synth.camera.view.View`, tested against it."""

import taichi as ti

numbers = ti.types.vector(6, ti.f64)
"""`View.numbers`: pixels_per_metre, axis_x, axis_z, middle_x, middle_y, bend."""


@ti.func
def to_image(view, x, z):
    """Image coordinates (px) of a world position (m)."""
    off_x, off_y = (x - view[1]) * view[0], (view[2] - z) * view[0]
    factor = 1.0 + view[5] * (off_x * off_x + off_y * off_y)
    return ti.Vector([view[3] + factor * off_x, view[4] + factor * off_y])


@ti.func
def magnification(view, x, z):
    """Size of a small disc at a world position / its size on the axis: the root of the change of area."""
    off_x, off_y = (x - view[1]) * view[0], (view[2] - z) * view[0]
    square = view[5] * (off_x * off_x + off_y * off_y)
    return ti.sqrt(ti.max((1.0 + square) * (1.0 + 3.0 * square), 0.1))


@ti.func
def distorted(view, column, row):
    """Image coordinates of what an ideal lens would put at the given ones."""
    off_x, off_y = column - view[3], row - view[4]
    factor = 1.0 + view[5] * (off_x * off_x + off_y * off_y)
    return ti.Vector([view[3] + factor * off_x, view[4] + factor * off_y])


@ti.func
def undistorted(view, column, row):
    """Image coordinates that an ideal lens would give."""
    off_x, off_y = column - view[3], row - view[4]
    factor = 1.0
    if view[5] != 0.0:
        seen = ti.sqrt(off_x * off_x + off_y * off_y)
        ideal = seen
        for _ in range(8):
            square = view[5] * ideal * ideal
            ideal -= (ideal * (1.0 + square) - seen) / (1.0 + 3.0 * square)
        factor = 1.0 / (1.0 + view[5] * ideal * ideal)
    return ti.Vector([view[3] + factor * off_x, view[4] + factor * off_y])
