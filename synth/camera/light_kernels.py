# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of the light. Import only after `synth.devices.start_taichi`.

Coordinates and buffers as in `synth.camera.cover_kernels`.
"""

import math
from functools import cache

import taichi as ti

from synth.camera import projection_kernels as projection
from synth.camera.cover_kernels import IMPLEMENT, NOTHING, box_vector, remainder
from synth.camera.samples import rows_at_once
from synth.camera.share_kernels import SHARES, dealt

RIM = 0.05
"""Height of a grain's rim / its radius: keeps the normal of a half sphere defined all the way out."""
TILES_AT_ONCE = 4
"""In a row: wide enough to write long lines of light, and what they need fits a core's cache."""
_DEALT = 3
"""Of these dealt together: one by one, a thread might get the last of every row, which are smaller."""

_f64 = ti.types.ndarray(dtype=ti.f64, ndim=1)
_f64_table = ti.types.ndarray(dtype=ti.f64, ndim=2)
_f32 = ti.types.ndarray(dtype=ti.f32, ndim=1)
_f32_table = ti.types.ndarray(dtype=ti.f32, ndim=2)
_f32_eights = ti.types.ndarray(dtype=ti.types.vector(8, ti.f32), ndim=1)
_i32 = ti.types.ndarray(dtype=ti.i32, ndim=1)
_i32_samples = ti.types.ndarray(dtype=ti.i32, ndim=4)


@cache
def grain_radiance(sampling: int):
    """Kernel of the light of every sample: of the grain that covers it, or of what is behind the grains.

    A grain is a flattened half sphere with a tilted face; the lamps' directions are (-+lamp_side, 0,
    lamp_front), the last towards the camera, times the share of the light that is theirs.

    Its arguments: tiled grains, their angles and looks, the light, the light behind the grains of every
    pixel, the samples in groups (`synth.camera.samples`), scratch for the grains' faces, the radiance, row
    by row of samples, as a table of a pixel's samples in a row.
    """
    rows = rows_at_once(sampling)
    groups = ti.types.ndarray(dtype=ti.types.vector(rows * sampling, ti.i32), ndim=3)
    lines = ti.types.ndarray(dtype=ti.types.vector(sampling, ti.f32), ndim=2)

    @ti.kernel
    def kernel(
        first: _i32,
        columns: ti.i32,
        grain: _i32,
        place: _f32_table,
        tile: ti.template(),
        index_mask: ti.i32,
        angle: _f64,
        slope_x: _f32,
        slope_y: _f32,
        brightness: _f32,
        intensity: ti.f32,
        ambient: ti.f32,
        roundness: ti.f32,
        lamp_side: ti.f32,
        lamp_front: ti.f32,
        behind: _f32_table,
        samples: groups,
        face: _f32_eights,
        radiance: lines,
    ):
        across = (columns + TILES_AT_ONCE - 1) // TILES_AT_ONCE
        for share in range((first.shape[0] - 1) // columns * across * SHARES):
            if share % SHARES == 0:
                n = dealt(share // SHARES, (first.shape[0] - 1) // columns * across, _DEALT)
                row, left = n // across, n % across * TILES_AT_ONCE
                right = ti.min(left + TILES_AT_ONCE, columns)
                for k in range(first[row * columns + left], first[row * columns + right]):
                    g = grain[k]
                    turned = _turned_slope(slope_x[g], slope_y[g], ti.cast(angle[g], ti.f32))
                    face[k] = _face(
                        place[k, 0], place[k, 1], place[k, 2], roundness, turned, intensity * brightness[g]
                    )
                for j in range(row * tile, ti.min((row + 1) * tile, behind.shape[0])):
                    for i in range(left * tile, ti.min(right * tile, behind.shape[1])):
                        for q in range(sampling // rows):
                            keys, back = samples[j, i, q], behind[j, i]
                            down = j * sampling + q * rows
                            if keys.max() != IMPLEMENT and keys.min() != NOTHING:
                                light = _light_of_group(
                                    keys,
                                    face,
                                    index_mask,
                                    ti.cast(remainder(i, tile) * sampling, ti.f32),
                                    ti.cast(remainder(down, tile * sampling), ti.f32),
                                    ambient,
                                    lamp_side,
                                    lamp_front,
                                    back,
                                    sampling,
                                    rows,
                                )
                                for r in ti.static(range(rows)):
                                    radiance[down + r, i] = ti.Vector(
                                        [light[r * sampling + a] for a in range(sampling)]
                                    )
                            else:  # far and wide no grain
                                for r in ti.static(range(rows)):
                                    radiance[down + r, i] = ti.Vector([back] * sampling)

    return kernel


@ti.func
def _face(x, y, radius, roundness, turned, full):
    """All that the light of a grain's samples needs.

    Centre times bend along x and y, and the bend of a sample; slopes along x and y; light in full.
    """
    bend, nothing = roundness / radius, ti.f32(0.0)
    return ti.Vector([bend * x, bend * y, bend, turned[0], turned[1], full, nothing, nothing])


@ti.func
def _turned_slope(slope_x, slope_y, angle):
    """Slopes after a turn, which is counter-clockwise in the world: from y towards x of the picture."""
    direction = _direction(-angle)
    return ti.Vector(
        [
            direction[0] * slope_x - direction[1] * slope_y,
            direction[1] * slope_x + direction[0] * slope_y,
        ]
    )


@ti.func
def _direction(angle):
    """Cosine and sine; by their series, to rounding, where the angle is small, as it mostly is."""
    one, square = ti.f32(1.0), angle * angle
    a, b, c = ti.f32(1 / 2), ti.f32(1 / 12), ti.f32(1 / 30)
    d, e, f = ti.f32(1 / 6), ti.f32(1 / 20), ti.f32(1 / 42)
    result = ti.Vector(
        [
            one - a * square * (one - b * square * (one - c * square)),
            angle * (one - d * square * (one - e * square * (one - f * square))),
        ]
    )
    if square > ti.f32(0.1):
        result = ti.Vector([ti.cos(angle), ti.sin(angle)])
    return result


@ti.func
def _light_of_group(
    keys,
    face: ti.template(),
    index_mask,
    across_tile,
    down_tile,
    ambient,
    lamp_side,
    lamp_front,
    behind,
    sampling: ti.template(),
    rows: ti.template(),
):
    """Light of a group's samples, the first of which is at a place in its tile, in samples.

    Sample by sample without a branch: where one grain ends and another begins cannot be foreseen.
    """
    lanes = ti.static(rows * sampling)
    shown = ti.Matrix.zero(ti.f32, 6, lanes)
    if keys.min() == keys.max():  # one grain covers the group: a fifth of them and more
        own = face[keys[0] & index_mask]
        for n in ti.static(range(lanes)):
            for c in ti.static(range(6)):
                shown[c, n] = own[c]
    else:
        for n in ti.static(range(lanes)):
            grain = keys[n] != NOTHING and keys[n] != IMPLEMENT
            own = face[ti.select(grain, keys[n] & index_mask, 0)]
            for c in ti.static(range(6)):
                shown[c, n] = own[c]
    light = ti.Vector([behind] * lanes)
    for n in ti.static(range(lanes)):
        x, y = across_tile + ti.f32(1.0 * (n % sampling)), down_tile + ti.f32(1.0 * (n // sampling))
        off_x, off_y = x * shown[2, n] - shown[0, n], y * shown[2, n] - shown[1, n]
        front = ti.sqrt(ti.max(ti.f32(1.0) - off_x * off_x - off_y * off_y, ti.f32(0.0))) + ti.f32(RIM)
        across, down = off_x + shown[3, n], off_y + shown[4, n]
        lit, aside = front * lamp_front, ti.abs(across * lamp_side)
        # max(lit - aside, 0) + max(lit + aside, 0) of both lamps: lit is positive.
        lamps = lit + ti.max(lit, aside)
        own = shown[5, n] * (ambient + lamps / ti.sqrt(across * across + down * down + front * front))
        light[n] = ti.select(keys[n] != NOTHING and keys[n] != IMPLEMENT, own, behind)
    return light


@ti.kernel
def implement_radiance(
    samples: _i32_samples,
    x: ti.f64,
    y: ti.f64,
    wheel_radius: ti.f64,
    angle: ti.f64,
    rim: _f64_table,
    grain: ti.f64,
    view: projection.numbers,
    sampling: ti.template(),
    margin: ti.i32,
    light: ti.f64,
    box: box_vector,
    radiance: _f32_table,
):
    """Light of the implement's side, marked with blotches of `grain` px; a wheel has rim, hub and spokes.

    `rim` is the table of `synth.camera.rim_face`: marks stay on the material. `box` holds the first column,
    the row, and those after the last, of the buffer's pixels that it may be at.

    These are smooth over a pixel, so one value serves all of a pixel's samples; its outline does not.
    """
    cosine, sine = ti.cos(angle), ti.sin(angle)
    for share in range((box[3] - box[1]) * SHARES):
        if share % SHARES != 0:
            continue
        row = box[1] + dealt(share // SHARES, box[3] - box[1], 1)
        _implement_row(
            row,
            samples,
            x,
            y,
            wheel_radius,
            cosine,
            sine,
            rim,
            grain,
            view,
            sampling,
            margin,
            light,
            box,
            radiance,
        )


@ti.func
def _rim_displacement(rim: ti.template(), x, y):
    """How far the side at (x, y) is from where it is unloaded, px: see `synth.camera.rim_face`."""
    count = rim.shape[0]
    place = (ti.atan2(y, x) / (2.0 * math.pi) + 0.5) * count
    first = ti.cast(ti.floor(place), ti.i32)
    part, a, b = place - first, first % count, (first + 1) % count
    radius = (1.0 - part) * rim[a, 0] + part * rim[b, 0]
    hub = rim[a, 3]
    share = ti.min(ti.max((ti.sqrt(x * x + y * y) - hub) / (radius - hub), 0.0), 1.0)
    along, down = (1.0 - part) * rim[a, 1] + part * rim[b, 1], (1.0 - part) * rim[a, 2] + part * rim[b, 2]
    return ti.Vector([share * along, share * down])


@ti.func
def _implement_row(
    j,
    samples: ti.template(),
    x,
    y,
    wheel_radius,
    cosine,
    sine,
    rim: ti.template(),
    grain,
    view,
    sampling: ti.template(),
    margin,
    light,
    box,
    radiance: ti.template(),
):
    for i in range(box[0], box[2]):
        seen = 0
        for b, a in ti.ndrange(sampling, sampling):
            seen += ti.cast(samples[j, i, b, a] == IMPLEMENT, ti.i32)
        if seen > 0:
            at = projection.undistorted(view, ti.cast(i - margin, ti.f64), ti.cast(j - margin, ti.f64))
            off_x, off_y = at[0] - x, at[1] - y
            body_x, body_y = cosine * off_x + sine * off_y, cosine * off_y - sine * off_x
            if rim.shape[0] > 1:
                moved = _rim_displacement(rim, body_x, body_y)
                body_x, body_y = body_x - moved[0], body_y - moved[1]
            pattern = 1.0
            if wheel_radius > 0.0:
                pattern = _wheel_pattern(body_x / wheel_radius, body_y / wheel_radius)
            blotch = _blotch(body_x / grain, body_y / grain) + 0.5 * _blotch(
                2.3 * body_x / grain + 31.0, 2.3 * body_y / grain
            )
            value = ti.cast(light * (pattern + 0.25 * blotch), ti.f32)
            for b, a in ti.ndrange(sampling, sampling):
                if seen == sampling * sampling or samples[j, i, b, a] == IMPLEMENT:
                    radiance[j * sampling + b, i * sampling + a] = value


@ti.func
def _wheel_pattern(x, y):
    """Relative light over a wheel of radius one: 1 on rim, hub and six spokes, less between them."""
    away = ti.sqrt(x * x + y * y)
    spoke = 1.0
    for k in ti.static(range(3)):
        across, along = ti.static(math.sin(k * math.pi / 3), math.cos(k * math.pi / 3))
        spoke = ti.min(spoke, ti.abs(x * across - y * along))
    raised = ti.max(
        _step((away - 0.88) / 0.01), ti.max(_step((0.25 - away) / 0.01), _step((0.05 - spoke) / 0.01))
    )
    line = _step((0.006 - ti.abs(away - 0.96)) / 0.003)
    return 0.65 + 0.35 * raised + 0.4 * line - 0.5 * _step((0.08 - away) / 0.01)


@ti.func
def _step(t):
    """From 0 to 1 while t goes from -1 to 1, smoothly."""
    s = ti.min(ti.max(0.5 * (t + 1.0), 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s)


@ti.func
def _blotch(x, y):
    """Smooth noise in -1..1 with one independent value per unit cell."""
    column, row = ti.floor(x), ti.floor(y)
    s, t = x - column, y - row
    s, t = s * s * (3.0 - 2.0 * s), t * t * (3.0 - 2.0 * t)
    i, j = int(column), int(row)
    upper = _lattice_value(i, j) * (1.0 - s) + _lattice_value(i + 1, j) * s
    lower = _lattice_value(i, j + 1) * (1.0 - s) + _lattice_value(i + 1, j + 1) * s
    return upper * (1.0 - t) + lower * t


@ti.func
def _lattice_value(i, j):
    """Value in -1..1 from an integer hash of a lattice point; nothing is drawn."""
    h = ti.cast(i, ti.u32) * ti.u32(374761393) + ti.cast(j, ti.u32) * ti.u32(668265263)
    h = (h ^ (h >> 13)) * ti.u32(1274126177)
    h = h ^ (h >> 16)
    return ti.cast(h & ti.u32(0xFFFF), ti.f64) / 32767.5 - 1.0
