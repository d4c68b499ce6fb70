# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of the glass. Import only after `synth.devices.start_taichi`.

Coordinates and buffers as in `synth.camera.cover_kernels`.
"""

import taichi as ti

from synth.camera import projection_kernels as projection
from synth.camera.share_kernels import SHARES

_f64_table = ti.types.ndarray(dtype=ti.f64, ndim=2)
_f32_table = ti.types.ndarray(dtype=ti.f32, ndim=2)


@ti.kernel
def put_glass_before(
    view: projection.numbers,
    scratches: _f64_table,
    smudges: _f64_table,
    lamps: _f64_table,
    scratch: ti.f64,
    smudge: ti.f64,
    reflection: ti.f64,
    haze: ti.f64,
    sampling: ti.template(),
    margin: ti.i32,
    radiance: _f32_table,
):
    """Change the light of every sample by smudges, then scratches, then reflections.

    Smudges and reflections are smooth: one value serves a pixel's samples. Marks are those of
    `synth.camera.glass.Glass`; `scratch`, `smudge` and `reflection` are severities, `haze` is a smudge's
    own light.
    """
    for share in range((radiance.shape[0] // sampling) * SHARES):
        if share % SHARES != 0:
            continue
        j = share // SHARES
        for i in range(radiance.shape[1] // sampling):
            column, row = ti.cast(i - margin, ti.f64), ti.cast(j - margin, ti.f64)
            at = _to_world(view, column, row)
            clear, glow = 1.0, 0.0
            for s in range(smudges.shape[0]):
                square = ((at[0] - smudges[s, 0]) ** 2 + (at[1] - smudges[s, 1]) ** 2) / smudges[s, 2] ** 2
                if square < 20.0:
                    clear *= 1.0 - smudge * smudges[s, 3] * ti.exp(-0.5 * square)
            for s in range(lamps.shape[0]):
                square = ((column - lamps[s, 0]) / lamps[s, 2]) ** 2 + (
                    (row - lamps[s, 1]) / lamps[s, 3]
                ) ** 2
                if square < 20.0:
                    glow += reflection * ti.exp(-0.5 * square)
            for b in range(sampling):
                for a in range(sampling):
                    before = radiance[j * sampling + b, i * sampling + a]
                    after = clear * before + (1.0 - clear) * haze + glow
                    radiance[j * sampling + b, i * sampling + a] = ti.cast(after, ti.f32)
            reach = 1.5 / view[0]  # a pixel and a half, m
            for s in range(scratches.shape[0]):
                if _away(at[0], at[1], s, scratches) < reach:
                    for b in range(sampling):
                        for a in range(sampling):
                            p = column + (a + 0.5) / sampling - 0.5
                            q = row + (b + 0.5) / sampling - 0.5
                            there = _to_world(view, p, q)
                            if _away(there[0], there[1], s, scratches) < 0.0:
                                light = ti.cast(scratch * scratches[s, 5], ti.f32)
                                radiance[j * sampling + b, i * sampling + a] += light


@ti.func
def _to_world(view, column, row):
    """World position (m) of image coordinates (px)."""
    at = projection.undistorted(view, column, row)
    return ti.Vector([(at[0] - view[3]) / view[0] + view[1], view[2] - (at[1] - view[4]) / view[0]])


@ti.func
def _away(x, z, s, scratches: ti.template()):
    """Distance of a point to scratch `s`, m; negative on it."""
    ax, az = scratches[s, 0], scratches[s, 1]
    ex, ez = scratches[s, 2] - ax, scratches[s, 3] - az
    along = ((x - ax) * ex + (z - az) * ez) / ti.max(ex * ex + ez * ez, 1e-18)
    along = ti.max(0.0, ti.min(1.0, along))
    dx, dz = x - ax - along * ex, z - az - along * ez
    return ti.sqrt(dx * dx + dz * dz) - scratches[s, 4]
