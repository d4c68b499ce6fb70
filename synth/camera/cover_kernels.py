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


@ti.kernel
def cover_by_grains(
    first: _i32,
    columns: ti.i32,
    place: _f32_table,
    key: _i32,
    sampling: ti.template(),
    margin: ti.i32,
    tile: ti.template(),
    samples: _i32_table,
    centres: _i32_table,
):
    """Clear every tile, and put its grains' discs into its samples and pixel centres."""
    side = tile * sampling
    per_pixel, middle = ti.f32(1.0 / sampling), ti.f32(0.5 * (sampling - 1))
    for share in range((first.shape[0] - 1) * SHARES):
        if share % SHARES != 0:
            continue
        t = share // SHARES
        row, column = (t // columns) * side, (t % columns) * side
        height, width = ti.min(side, samples.shape[0] - row), ti.min(side, samples.shape[1] - column)
        above, left = margin - (t // columns) * tile, margin - (t % columns) * tile
        for j in range(height):
            for i in range(width):
                samples[row + j, column + i] = NOTHING
        for j in range(ti.max(above, 0), ti.min(tile, centres.shape[0] + above)):
            for i in range(ti.max(left, 0), ti.min(tile, centres.shape[1] + left)):
                centres[j - above, i - left] = NOTHING
        for k in range(first[t], first[t + 1]):
            x, y, radius = place[k, 0], place[k, 1], place[k, 2]
            square, depth = radius * radius, key[k]
            low_i = ti.max(ti.cast(ti.ceil(x - radius), ti.i32), 0)
            high_i = ti.min(ti.cast(ti.floor(x + radius), ti.i32), width - 1) + 1
            low_j = ti.max(ti.cast(ti.ceil(y - radius), ti.i32), 0)
            high_j = ti.min(ti.cast(ti.floor(y + radius), ti.i32), height - 1) + 1
            for j in range(low_j, high_j):
                down = ti.cast(j, ti.f32) - y
                rest = square - down * down
                for i in range(low_i, high_i):
                    across = ti.cast(i, ti.f32) - x
                    # Without a branch: which samples lie in a disc is too irregular to be foreseen.
                    own = ti.select(across * across <= rest, depth, NOTHING)
                    samples[row + j, column + i] = ti.min(samples[row + j, column + i], own)
            # The same for pixel centres, which lie at `middle` + n S of the samples.
            low_i = ti.max(ti.cast(ti.ceil((x - radius - middle) * per_pixel), ti.i32), 0, left)
            high_i = ti.min(
                ti.cast(ti.floor((x + radius - middle) * per_pixel), ti.i32),
                tile - 1,
                centres.shape[1] - 1 + left,
            )
            low_j = ti.max(ti.cast(ti.ceil((y - radius - middle) * per_pixel), ti.i32), 0, above)
            high_j = ti.min(
                ti.cast(ti.floor((y + radius - middle) * per_pixel), ti.i32),
                tile - 1,
                centres.shape[0] - 1 + above,
            )
            for j in range(low_j, high_j + 1):
                down = ti.cast(j * sampling, ti.f32) + middle - y
                for i in range(low_i, high_i + 1):
                    across = ti.cast(i * sampling, ti.f32) + middle - x
                    if across * across + down * down <= square and centres[j - above, i - left] > depth:
                        centres[j - above, i - left] = depth


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
    samples: _i32_table,
    centres: _i32_table,
):
    """Put an implement's side in front of everything.

    The distance to it changes by no more than one goes: pixels further from its outline than their corners
    need one look, not one a sample.
    """
    corner = 1.0  # px; half a pixel's diagonal, and what distortion stretches it by
    for share in range((samples.shape[0] // sampling) * SHARES):
        if share % SHARES != 0:
            continue
        j = share // SHARES
        for i in range(samples.shape[1] // sampling):
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
