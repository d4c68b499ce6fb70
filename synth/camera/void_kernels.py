# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of what voids between grains are seen by. Import only after `synth.devices.start_taichi`.

Coordinates and buffers as in `synth.camera.cover_kernels`.
"""

import taichi as ti

from synth.camera.cover_kernels import IMPLEMENT, NOTHING
from synth.camera.shares import SHARES

_f32_table = ti.types.ndarray(dtype=ti.f32, ndim=2)
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
    seen: _u8,
):
    """Grain at every pixel centre, as its place among the tiled ones, or -1.

    In a soil's void it is the visible grain whose rim is nearest: rings of samples around the pixel are
    searched outwards until none can be nearer, or `reach` px. `seen` becomes 1 for every grain of the table.
    """
    for share in range(centres.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        j = share // SHARES
        for i in range(centres.shape[1]):
            found = -1
            if centres[j, i] != NOTHING and centres[j, i] != IMPLEMENT:
                found = centres[j, i] & index_mask
            if centres[j, i] == NOTHING and soil[j, i] == 1:
                found = _nearest_visible(
                    i + margin, j + margin, samples, place, tile, index_mask, sampling, margin, reach
                )
            filled[j, i] = found
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
    """Place among the tiled grains of the nearest one seen around a pixel of the buffer; -1: none."""
    corner_j, corner_i = j * sampling, i * sampling
    middle = ti.f32(0.5 * (sampling - 1))
    at_x, at_y = ti.cast(corner_i, ti.f32) + middle, ti.cast(corner_j, ti.f32) + middle
    side = tile * sampling
    nearest = reach * ti.f32(1.0 * sampling)
    found, last, ring = -1, -1, -((sampling - 1) // 2)  # from the pixel's middle
    while ti.cast(ring, ti.f32) < nearest and ring <= margin * sampling:
        top, left = corner_j - ring, corner_i - ring
        size = sampling + 2 * ring
        for n in range(size):
            for edge in ti.static(range(4)):
                a, b = top, left
                if ti.static(edge == 0):
                    b += n
                elif ti.static(edge == 1):
                    a, b = a + size - 1, b + n
                elif ti.static(edge == 2):
                    a += n
                else:
                    a, b = a + n, b + size - 1
                key = samples[a // sampling, b // sampling, a % sampling, b % sampling]
                if key != NOTHING and key != IMPLEMENT and key & index_mask != last:
                    k = last = key & index_mask
                    off_x = at_x - (place[k, 0] + ti.cast(b // side * side, ti.f32))
                    off_y = at_y - (place[k, 1] + ti.cast(a // side * side, ti.f32))
                    gap = ti.sqrt(off_x * off_x + off_y * off_y) - place[k, 2]
                    if gap < nearest:
                        nearest, found = gap, k
        ring += 1
    return found
