# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of what covers what. Import only after `synth.devices.start_taichi`.

Image coordinates throughout: px, y down, integer at pixel centres. Samples lie S x S to a pixel in a buffer
that is wider than the picture by a margin of whole pixels: sample (j, i) is at the image coordinates
((i + 0.5) / S - 0.5 - margin, (j + 0.5) / S - 0.5 - margin).

A buffer of samples holds keys (`synth.camera.tiles`): `IMPLEMENT` in front of everything, the foremost
micro-grain's, or `NOTHING`. Every tile has one writer, and the least key wins whatever the order of writing:
results are the same on any number of threads.
"""

import taichi as ti

from synth.camera import projection_kernels as projection
from synth.camera.shares import SHARES

NOTHING = 2**31 - 1
IMPLEMENT = -1

_f64_table = ti.types.ndarray(dtype=ti.f64, ndim=2)
_f64 = ti.types.ndarray(dtype=ti.f64, ndim=1)
_f32_table = ti.types.ndarray(dtype=ti.f32, ndim=2)
_i32_table = ti.types.ndarray(dtype=ti.i32, ndim=2)
_i32 = ti.types.ndarray(dtype=ti.i32, ndim=1)
_u8_table = ti.types.ndarray(dtype=ti.u8, ndim=2)
box_vector = ti.types.vector(4, ti.i32)
"""The box of `implement_radiance` and `cover_by_implement`."""


@ti.func
def remainder(n, divisor: ti.template()):
    """N % divisor of what is not negative; cheaper than the remainder that minds the sign."""
    return ti.cast(ti.cast(n, ti.u32) % ti.u32(divisor), ti.i32)


@ti.kernel
def fill_discs(x: _f64, y: _f64, radius: _f64, mask: _u8_table):
    """Set the pixels whose centres lie in a disc."""
    for p in range(x.shape[0]):
        for j in range(
            ti.max(int(ti.ceil(y[p] - radius[p])), 0),
            ti.min(int(ti.floor(y[p] + radius[p])), mask.shape[0] - 1) + 1,
        ):
            half = ti.sqrt(ti.max(radius[p] ** 2 - (j - y[p]) ** 2, 0.0))
            for i in range(
                ti.max(int(ti.ceil(x[p] - half)), 0),
                ti.min(int(ti.floor(x[p] + half)), mask.shape[1] - 1) + 1,
            ):
                mask[j, i] = ti.u8(1)


@ti.func
def _cover_window(
    samples: ti.template(), start, stride, height, width, x, y, radius, depth, size: ti.template()
):
    """Put a disc that `size` samples in a row and as many rows hold into a tile that starts at `start`.

    The square of samples around it is shifted into the tile. Neither loop nor branch: which samples lie in
    a small disc is too irregular to be foreseen.
    """
    low_i = ti.max(ti.min(ti.cast(ti.ceil(x - radius), ti.i32), width - size), 0)
    low_j = ti.max(ti.min(ti.cast(ti.ceil(y - radius), ti.i32), height - size), 0)
    at = start + low_j * stride + low_i
    off_x, off_y, square = ti.cast(low_i, ti.f32) - x, ti.cast(low_j, ti.f32) - y, radius * radius
    for b in ti.static(range(size)):
        down = off_y + ti.cast(b, ti.f32)
        rest = square - down * down
        for a in ti.static(range(size)):
            across = off_x + ti.cast(a, ti.f32)
            own = ti.select(across * across <= rest, depth, NOTHING)
            samples[at + a] = ti.min(samples[at + a], own)
        at += stride


@ti.func
def _cover_box(samples: ti.template(), start, stride, height, width, x, y, radius, depth):
    """Put a disc of any size into a tile that starts at `start`."""
    low_j = ti.max(ti.cast(ti.ceil(y - radius), ti.i32), 0)
    high_j = ti.min(ti.cast(ti.floor(y + radius), ti.i32), height - 1) + 1
    for j in range(low_j, high_j):
        down = ti.cast(j, ti.f32) - y
        half = ti.sqrt(ti.max(radius * radius - down * down, ti.f32(0.0)))
        low_i = ti.max(ti.cast(ti.ceil(x - half), ti.i32), 0)
        high_i = ti.min(ti.cast(ti.floor(x + half), ti.i32), width - 1) + 1
        at = start + j * stride
        for i in range(at + low_i, at + high_i):
            samples[i] = ti.min(samples[i], depth)


@ti.func
def _cover_centres(centres: ti.template(), start, stride, box, x, y, radius, depth):
    """Put a disc into the pixel centres of a tile: x, y and radius in px from the tile's first centre.

    `box` holds the first and last column and row of the tile that are the picture's; `start` is the place of
    the tile's first centre.
    """
    square = radius * radius
    if radius < ti.f32(0.5):  # one centre at most, the nearest: no branch
        i = ti.max(ti.min(ti.cast(ti.floor(x + ti.f32(0.5)), ti.i32), box[1]), box[0])
        j = ti.max(ti.min(ti.cast(ti.floor(y + ti.f32(0.5)), ti.i32), box[3]), box[2])
        across, down = ti.cast(i, ti.f32) - x, ti.cast(j, ti.f32) - y
        own = ti.select(across * across + down * down <= square, depth, NOTHING)
        centres[start + j * stride + i] = ti.min(centres[start + j * stride + i], own)
    else:
        low_i = ti.max(ti.cast(ti.ceil(x - radius), ti.i32), box[0])
        high_i = ti.min(ti.cast(ti.floor(x + radius), ti.i32), box[1])
        low_j = ti.max(ti.cast(ti.ceil(y - radius), ti.i32), box[2])
        high_j = ti.min(ti.cast(ti.floor(y + radius), ti.i32), box[3])
        for j in range(low_j, high_j + 1):
            down = ti.cast(j, ti.f32) - y
            for i in range(low_i, high_i + 1):
                across = ti.cast(i, ti.f32) - x
                own = ti.select(across * across + down * down <= square, depth, NOTHING)
                centres[start + j * stride + i] = ti.min(centres[start + j * stride + i], own)


@ti.kernel
def cover_by_grains(
    first: _i32,
    columns: ti.i32,
    place: _f32_table,
    key: _i32,
    sampling: ti.template(),
    margin: ti.i32,
    tile: ti.template(),
    sample_columns: ti.i32,
    pixel_columns: ti.i32,
    samples: _i32,
    centres: _i32,
):
    """Clear every tile, and put its grains' discs into its samples and pixel centres.

    `samples` and `centres` are the tables, flat, of rows as long as told.
    """
    side = tile * sampling
    per_pixel, middle = ti.f32(1.0 / sampling), ti.f32(0.5 * (sampling - 1))
    sample_rows, pixel_rows = samples.shape[0] // sample_columns, centres.shape[0] // pixel_columns
    for share in range((first.shape[0] - 1) * SHARES):
        if share % SHARES != 0:
            continue
        t = share // SHARES
        row, column = (t // columns) * side, (t % columns) * side
        height, width = ti.min(side, sample_rows - row), ti.min(side, sample_columns - column)
        start = row * sample_columns + column
        for j in range(height):
            for i in range(width):
                samples[start + j * sample_columns + i] = NOTHING
        # Columns and rows of the tile's pixels that are the picture's, not the margin's.
        above, left = margin - (t // columns) * tile, margin - (t % columns) * tile
        box = ti.Vector(
            [
                ti.max(left, 0),
                ti.min(tile, pixel_columns + left) - 1,
                ti.max(above, 0),
                ti.min(tile, pixel_rows + above) - 1,
            ]
        )
        in_picture = box[0] <= box[1] and box[2] <= box[3]
        corner = -above * pixel_columns - left
        for j in range(box[2], box[3] + 1):
            for i in range(box[0], box[1] + 1):
                centres[corner + j * pixel_columns + i] = NOTHING
        for k in range(first[t], first[t + 1]):
            x, y, radius, depth = place[k, 0], place[k, 1], place[k, 2], key[k]
            # The grains of a tile come by size, mostly: these branches can be foreseen.
            if radius < ti.f32(1.0):
                _cover_window(samples, start, sample_columns, height, width, x, y, radius, depth, 2)
            elif radius < ti.f32(1.5):
                _cover_window(samples, start, sample_columns, height, width, x, y, radius, depth, 3)
            elif radius < ti.f32(2.0):
                _cover_window(samples, start, sample_columns, height, width, x, y, radius, depth, 4)
            elif radius < ti.f32(3.0) and ti.min(height, width) >= 6:
                _cover_window(samples, start, sample_columns, height, width, x, y, radius, depth, 6)
            else:
                _cover_box(samples, start, sample_columns, height, width, x, y, radius, depth)
            if in_picture:
                _cover_centres(
                    centres,
                    corner,
                    pixel_columns,
                    box,
                    (x - middle) * per_pixel,
                    (y - middle) * per_pixel,
                    radius * per_pixel,
                    depth,
                )


@ti.func
def away(off_x, off_y, parts: ti.template()):
    """Distance of a point, given from the reference point, to the nearest of an implement's capsules, px.

    Not positive inside of a closed outline, which a line from there crosses an odd number of times.
    """
    nearest, inside = ti.math.inf, False
    for c in range(parts.shape[0]):
        ex, ey = parts[c, 2] - parts[c, 0], parts[c, 3] - parts[c, 1]
        px, py = off_x - parts[c, 0], off_y - parts[c, 1]
        length = ex * ex + ey * ey
        along = 0.0
        if length > 0.0:
            along = ti.max(0.0, ti.min(1.0, (px * ex + py * ey) / length))
        dx, dy = px - along * ex, py - along * ey
        nearest = ti.min(nearest, ti.sqrt(dx * dx + dy * dy) - parts[c, 4])
        if parts[c, 5] != 0.0 and (py < 0.0) != (py < ey) and px < py / ey * ex:
            inside = not inside
    return -ti.abs(nearest) if inside else nearest


@ti.kernel
def distance_to_implement(
    x: ti.f64, y: ti.f64, parts: _f64_table, view: projection.numbers, distance: _f32_table
):
    """Distance of every pixel's centre to the implement, px of an ideal lens, 0 on it."""
    for share in range(distance.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        j = share // SHARES
        for i in range(distance.shape[1]):
            at = projection.undistorted(view, ti.cast(i, ti.f64), ti.cast(j, ti.f64))
            distance[j, i] = ti.cast(ti.max(away(at[0] - x, at[1] - y, parts), 0.0), ti.f32)


@ti.kernel
def cover_by_implement(
    x: ti.f64,
    y: ti.f64,
    parts: _f64_table,
    view: projection.numbers,
    sampling: ti.template(),
    margin: ti.i32,
    box: box_vector,
    samples: _i32_table,
    centres: _i32_table,
):
    """Put an implement's side in front of everything.

    `box` holds the first column, the row, and those after the last, of the buffer's pixels that it may be at.

    The distance to it changes by no more than one goes: pixels further from its outline than their corners
    need one look, not one a sample.
    """
    corner = 1.0  # px; half a pixel's diagonal, and what distortion stretches it by
    for share in range((box[3] - box[1]) * SHARES):
        if share % SHARES != 0:
            continue
        j = box[1] + share // SHARES
        for i in range(box[0], box[2]):
            at = projection.undistorted(view, ti.cast(i - margin, ti.f64), ti.cast(j - margin, ti.f64))
            outline = away(at[0] - x, at[1] - y, parts)
            if outline <= corner:
                for b in range(sampling):
                    for a in range(sampling):
                        inside = outline < -corner
                        if not inside:
                            p = (a + 0.5) / sampling - 0.5 + i - margin
                            q = (b + 0.5) / sampling - 0.5 + j - margin
                            at = projection.undistorted(view, p, q)
                            inside = away(at[0] - x, at[1] - y, parts) <= 0.0
                        if inside:
                            samples[j * sampling + b, i * sampling + a] = IMPLEMENT
                if (
                    outline <= 0.0
                    and margin <= j < margin + centres.shape[0]
                    and margin <= i < margin + centres.shape[1]
                ):
                    centres[j - margin, i - margin] = IMPLEMENT
