# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of what voids between grains are seen by. Import only after `synth.devices.start_taichi`.

Coordinates and buffers as in `synth.camera.cover_kernels`.
"""

import taichi as ti

from synth.camera.cover_kernels import IMPLEMENT, NOTHING, quotient, remainder
from synth.camera.share_kernels import ROWS, SHARES, dealt

_f32_table = ti.types.ndarray(dtype=ti.f32, ndim=2)
_f32_pairs = ti.types.ndarray(dtype=ti.types.vector(2, ti.f32), ndim=2)
_i32_samples = ti.types.ndarray(dtype=ti.i32, ndim=4)
_i32_table = ti.types.ndarray(dtype=ti.i32, ndim=2)
_u8 = ti.types.ndarray(dtype=ti.u8, ndim=1)
_u8_table = ti.types.ndarray(dtype=ti.u8, ndim=2)


@ti.kernel
def fill_voids(
    centres: _i32_table,
    soil: _u8_table,
    samples: _i32_samples,
    place: _f32_table,
    tile: ti.template(),
    index_mask: ti.i32,
    sampling: ti.template(),
    margin: ti.i32,
    reach: ti.f32,
    filled: _i32_table,
    off: _f32_pairs,
    seen: _u8,
):
    """Grain at every pixel centre, as its place among the tiled ones, or -1.

    In a soil's void it is the visible grain whose rim is nearest: rings of samples around the pixel are
    searched outwards until none can be nearer, or `reach` px. `off` is the pixel's centre from the grain's,
    px; `seen` becomes 1 for every grain of the table.
    """
    for share in range(centres.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        j = dealt(share // SHARES, centres.shape[0], ROWS)
        for i in range(centres.shape[1]):
            key = centres[j, i]
            found, off_x, off_y = -1, ti.f32(0.0), ti.f32(0.0)
            if key != NOTHING and key != IMPLEMENT:
                found = key & index_mask
                at = _off_centre(j + margin, i + margin, j + margin, i + margin, found, place, tile, sampling)
                off_x, off_y = at[1], at[2]
            elif key == NOTHING and soil[j, i] == 1:
                found, off_x, off_y = _nearest_visible(
                    i + margin, j + margin, samples, place, tile, index_mask, sampling, margin, reach
                )
            filled[j, i] = found
            off[j, i] = ti.Vector([off_x, off_y]) * ti.f32(1.0 / sampling)
            if found >= 0:
                seen[found] = ti.u8(1)


@ti.func
def _nearest_visible(
    i,
    j,
    samples: ti.template(),
    place: ti.template(),
    tile: ti.template(),
    index_mask,
    sampling: ti.template(),
    margin,
    reach,
):
    """The nearest of the grains seen around a pixel of the buffer (-1: none), and how far off its centre is.

    Its place among the tiled grains; then the pixel's centre from the grain's, along x and y, in samples.
    First the pixel's own samples are looked at, then rings around it.
    """
    nearest = ti.Vector([reach * ti.f32(1.0 * sampling), ti.f32(0.0), ti.f32(0.0)])
    found, last, ring = -1, -1, 1
    for b in range(sampling):
        for a in range(sampling):
            key = samples[j, i, b, a]
            if key != NOTHING and key != IMPLEMENT and key & index_mask != last:
                last = key & index_mask
                off = _off_centre(j, i, j, i, last, place, tile, sampling)
                if off[0] < nearest[0]:
                    nearest, found = off, last
    while ti.cast(ring, ti.f32) < nearest[0] and ring <= margin * sampling:
        size = sampling + 2 * ring
        for n in range(size - 1):
            for edge in ti.static(range(4)):
                b, a = j * sampling - ring, i * sampling - ring
                if ti.static(edge == 0):
                    a += n
                elif ti.static(edge == 1):
                    a, b = a + size - 1, b + n
                elif ti.static(edge == 2):
                    a, b = a + size - 1 - n, b + size - 1
                else:
                    b += size - 1 - n
                row, column = quotient(b, sampling), quotient(a, sampling)
                key = samples[row, column, remainder(b, sampling), remainder(a, sampling)]
                if key != NOTHING and key != IMPLEMENT and key & index_mask != last:
                    last = key & index_mask
                    off = _off_centre(j, i, row, column, last, place, tile, sampling)
                    if off[0] < nearest[0]:
                        nearest, found = off, last
        ring += 1
    return found, nearest[1], nearest[2]


@ti.func
def _off_centre(j, i, row, column, k, place: ti.template(), tile: ti.template(), sampling: ti.template()):
    """From rim, then from centre of a grain tiled with a pixel, to pixel (j, i)'s centre, in samples."""
    middle = ti.f32(0.5 * (sampling - 1))
    x = (i - quotient(column, tile) * tile) * sampling
    y = (j - quotient(row, tile) * tile) * sampling
    off_x, off_y = ti.cast(x, ti.f32) + middle - place[k, 0], ti.cast(y, ti.f32) + middle - place[k, 1]
    return ti.Vector([ti.sqrt(off_x * off_x + off_y * off_y) - place[k, 2], off_x, off_y])
