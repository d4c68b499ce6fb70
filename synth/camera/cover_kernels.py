# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of what covers what. Import only after `synth.devices.start_taichi`.

Image coordinates throughout: px, y down, integer at pixel centres. Samples lie S x S to a pixel in a buffer
that is wider than the picture by a margin of whole pixels (`synth.camera.samples`): sample (j, i, b, a) is at
the image coordinates (i - margin + (a + 0.5) / S - 0.5, j - margin + (b + 0.5) / S - 0.5).

A buffer of samples holds keys (`synth.camera.tiles`): `IMPLEMENT` in front of everything, the foremost
micro-grain's, or `NOTHING`. Every tile has one writer, and the least key wins whatever the order of writing:
results are the same on any number of threads.
"""

from functools import cache

import taichi as ti

from synth.camera import projection_kernels as projection
from synth.camera.samples import rows_at_once
from synth.camera.share_kernels import SHARES, TILES, dealt

NOTHING = 2**31 - 1
IMPLEMENT = -1

_f64_table = ti.types.ndarray(dtype=ti.f64, ndim=2)
_f64 = ti.types.ndarray(dtype=ti.f64, ndim=1)
_f32_table = ti.types.ndarray(dtype=ti.f32, ndim=2)
_i32_table = ti.types.ndarray(dtype=ti.i32, ndim=2)
_i32_samples = ti.types.ndarray(dtype=ti.i32, ndim=4)
_i32 = ti.types.ndarray(dtype=ti.i32, ndim=1)
_u8_table = ti.types.ndarray(dtype=ti.u8, ndim=2)
box_vector = ti.types.vector(4, ti.i32)
"""The box of `implement_radiance` and `cover_by_implement`."""


@ti.func
def remainder(n, divisor: ti.template()):
    """N % divisor of what is not negative; cheaper than the remainder that minds the sign."""
    return ti.cast(ti.cast(n, ti.u32) % ti.u32(divisor), ti.i32)


@ti.func
def quotient(n, divisor: ti.template()):
    """N // divisor of what is not negative; cheaper, too."""
    return ti.cast(ti.cast(n, ti.u32) // ti.u32(divisor), ti.i32)


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


@cache
def cover_by_grains(sampling: int):
    """Kernel that covers samples, S x S to a pixel, and pixel centres by grains: see `_cover_tile`.

    Its arguments: the tiles' first grains, tiles in a row, the grains' places and keys, the side of a tile
    in px, the samples in groups (`synth.camera.samples`), and the pixels' centres, margin and all.
    """
    rows = rows_at_once(sampling)
    groups = ti.types.ndarray(dtype=ti.types.vector(rows * sampling, ti.i32), ndim=3)

    @ti.kernel
    def kernel(
        first: _i32,
        columns: ti.i32,
        place: _f32_table,
        key: _i32,
        tile: ti.template(),
        samples: groups,
        centres: _i32_table,
    ):
        for share in range((first.shape[0] - 1) * SHARES):
            if share % SHARES == 0:
                t = dealt(share // SHARES, first.shape[0] - 1, TILES)
                _cover_tile(t, first, columns, place, key, tile, samples, centres, sampling, rows)

    return kernel


@ti.func
def _cover_tile(
    t,
    first: ti.template(),
    columns,
    place: ti.template(),
    key: ti.template(),
    tile: ti.template(),
    samples: ti.template(),
    centres: ti.template(),
    sampling: ti.template(),
    rows: ti.template(),
):
    """Clear a tile, and put its grains' discs into its samples and pixel centres.

    A disc is put into every group of samples that it may touch, a box, without a look at which it holds.
    """
    groups = ti.static(sampling // rows)
    row, column = (t // columns) * tile, (t % columns) * tile
    height, width = ti.min(tile, centres.shape[0] - row), ti.min(tile, centres.shape[1] - column)
    for j, i in ti.ndrange((row, row + height), (column, column + width)):
        centres[j, i] = NOTHING
        for q in range(groups):
            samples[j, i, q] = ti.Vector([NOTHING] * ti.static(rows * sampling))
    per_group, per_pixel = ti.f32(1.0 / rows), ti.f32(1.0 / sampling)
    for k in range(first[t], first[t + 1]):
        x, y, reach = place[k, 0], place[k, 1], place[k, 2]
        # A group and a pixel reach half a sample further than their outermost samples.
        x_edge, y_edge = x + ti.f32(0.5), y + ti.f32(0.5)
        low_i = ti.max(ti.cast(ti.floor((x_edge - reach) * per_pixel), ti.i32), 0)
        high_i = ti.min(ti.cast(ti.floor((x_edge + reach) * per_pixel), ti.i32), width - 1)
        low_j = ti.max(ti.cast(ti.floor((y_edge - reach) * per_group), ti.i32), 0)
        high_j = ti.min(ti.cast(ti.floor((y_edge + reach) * per_group), ti.i32), height * groups - 1)
        for n in range(low_j, high_j + 1):
            j, q = row + quotient(n, groups), remainder(n, groups)
            down = ti.cast(n * rows, ti.f32) - y
            for i in range(low_i, high_i + 1):
                across = ti.cast(i * sampling, ti.f32) - x
                at = column + i
                samples[j, at, q] = _nearer(samples[j, at, q], across, down, reach, key[k], sampling, rows)
                if q == ti.static(sampling // 2 // rows):  # the group that the pixel's centre is in
                    middle = ti.static(0.5 * (sampling - 1) - (sampling // 2 // rows) * rows)
                    off_x = across + ti.f32(0.5 * (sampling - 1))
                    off_y = down + ti.f32(middle)
                    own = ti.select(off_x * off_x + off_y * off_y <= reach * reach, key[k], NOTHING)
                    centres[j, at] = ti.min(centres[j, at], own)


@ti.func
def _nearer(keys, across, down, radius, key, sampling: ti.template(), rows: ti.template()):
    """Keys of a group after a disc was put in, from whose centre its first sample is (across, down) away."""
    for n in ti.static(range(rows * sampling)):
        off_x, off_y = across + ti.f32(1.0 * (n % sampling)), down + ti.f32(1.0 * (n // sampling))
        own = ti.select(off_x * off_x + off_y * off_y <= radius * radius, key, NOTHING)
        keys[n] = ti.min(keys[n], own)
    return keys


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
    samples: _i32_samples,
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
        j = box[1] + dealt(share // SHARES, box[3] - box[1], 1)
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
                            samples[j, i, b, a] = IMPLEMENT
                if outline <= 0.0:
                    centres[j, i] = IMPLEMENT
