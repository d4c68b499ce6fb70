# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of the picture. Import this module only after `synth.devices.start_taichi`.

Image coordinates throughout: px, y down, integer at pixel centres; angles from x towards y. Samples lie S x S
to a pixel in a buffer that is wider than the picture by a margin of whole pixels: sample (j, i) is at the
image coordinates ((i + 0.5) / S - 0.5 - margin, (j + 0.5) / S - 0.5 - margin).

A buffer of samples holds depths: `IMPLEMENT` in front of everything, the depth of the foremost micro-grain,
or `NOTHING`. The least depth wins whatever the order of writing is, so every result is the same on any number
of threads.
"""

import math

import taichi as ti

NOTHING = 2**31 - 1
IMPLEMENT = -1
RIM = 0.05
"""Height of a grain's rim / its radius: keeps the normal of a half sphere defined all the way out."""

_f64 = ti.types.ndarray(dtype=ti.f64)
_f32 = ti.types.ndarray(dtype=ti.f32)
_i32 = ti.types.ndarray(dtype=ti.i32)
_u8 = ti.types.ndarray(dtype=ti.u8)


@ti.kernel
def fill_discs(x: _f64, y: _f64, radius: _f64, mask: _u8):
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
def _put(buffer: ti.template(), j, i, depth):
    # Reading first spares most atomics; a value read too early is only larger than the true one.
    if buffer[j, i] > depth:
        ti.atomic_min(buffer[j, i], depth)


@ti.kernel
def cover_by_grains(
    x: _f64,
    y: _f64,
    radius: _f64,
    alive: _u8,
    depth: _i32,
    sampling: ti.i32,
    margin: ti.i32,
    samples: _i32,
    centres: _i32,
):
    """Put every grain's disc into the samples and into the pixel centres."""
    offset = 0.5 + margin
    for g in range(x.shape[0]):
        if alive[g] == 1:
            top, bottom = y[g] - radius[g], y[g] + radius[g]
            for j in range(
                ti.max(int(ti.ceil((top + offset) * sampling - 0.5)), 0),
                ti.min(int(ti.floor((bottom + offset) * sampling - 0.5)), samples.shape[0] - 1) + 1,
            ):
                off = (j + 0.5) / sampling - offset - y[g]
                half = ti.sqrt(ti.max(radius[g] ** 2 - off * off, 0.0))
                for i in range(
                    ti.max(int(ti.ceil((x[g] - half + offset) * sampling - 0.5)), 0),
                    ti.min(int(ti.floor((x[g] + half + offset) * sampling - 0.5)), samples.shape[1] - 1) + 1,
                ):
                    _put(samples, j, i, depth[g])
            for j in range(
                ti.max(int(ti.ceil(top)), 0), ti.min(int(ti.floor(bottom)), centres.shape[0] - 1) + 1
            ):
                half = ti.sqrt(ti.max(radius[g] ** 2 - (j - y[g]) ** 2, 0.0))
                for i in range(
                    ti.max(int(ti.ceil(x[g] - half)), 0),
                    ti.min(int(ti.floor(x[g] + half)), centres.shape[1] - 1) + 1,
                ):
                    _put(centres, j, i, depth[g])


@ti.func
def _away(off_x, off_y, parts: ti.template()):
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
def distance_to_implement(x: ti.f64, y: ti.f64, parts: _f64, distance: _f32):
    """Distance of every pixel's centre to the implement, px, 0 on it."""
    for j, i in distance:
        distance[j, i] = ti.cast(ti.max(_away(i - x, j - y, parts), 0.0), ti.f32)


@ti.kernel
def cover_by_implement(
    x: ti.f64,
    y: ti.f64,
    parts: _f64,
    reach: ti.f64,
    sampling: ti.i32,
    margin: ti.i32,
    samples: _i32,
    centres: _i32,
):
    """Put an implement's side, which ends within `reach` px, in front of everything."""
    for j, i in samples:
        off_x, off_y = (i + 0.5) / sampling - 0.5 - margin - x, (j + 0.5) / sampling - 0.5 - margin - y
        near = off_x * off_x + off_y * off_y <= reach * reach
        if near and _away(off_x, off_y, parts) <= 0.0:
            samples[j, i] = IMPLEMENT
    for j, i in centres:
        if _away(i - x, j - y, parts) <= 0.0:
            centres[j, i] = IMPLEMENT


# --- radiance -------------------------------------------------------------------------------------


@ti.kernel
def turn_faces(angle: _f64, slope_x: _f32, slope_y: _f32, turned_x: _f32, turned_y: _f32):
    """Slopes of the grains' faces after they turned by `angle`."""
    for g in range(angle.shape[0]):
        cosine, sine = ti.cast(ti.cos(angle[g]), ti.f32), ti.cast(ti.sin(angle[g]), ti.f32)
        turned_x[g] = cosine * slope_x[g] - sine * slope_y[g]
        turned_y[g] = sine * slope_x[g] + cosine * slope_y[g]


@ti.kernel
def grain_radiance(
    samples: _i32,
    by_depth: _i32,
    x: _f64,
    y: _f64,
    radius: _f64,
    brightness: _f32,
    slope_x: _f32,
    slope_y: _f32,
    sampling: ti.i32,
    margin: ti.i32,
    roundness: ti.f64,
    intensity: ti.f32,
    ambient: ti.f32,
    lamp_side: ti.f32,
    lamp_front: ti.f32,
    radiance: _f32,
):
    """Light of every sample that a grain covers; the other samples keep what they hold.

    A grain is a flattened half sphere with a tilted face; the lamps' directions are (-+lamp_side, 0,
    lamp_front), the last towards the camera. Places are in f64, light in f32.
    """
    zero, one, rim = ti.f32(0.0), ti.f32(1.0), ti.f32(RIM)
    for j in range(samples.shape[0]):
        last = NOTHING
        off_x, off_y, step, face_x, face_y, bright = zero, zero, zero, zero, zero, zero
        for i in range(samples.shape[1]):
            depth = samples[j, i]
            if depth != NOTHING and depth != IMPLEMENT:
                if depth == last:
                    off_x += step
                else:
                    g = by_depth[depth]
                    scale = roundness / radius[g]
                    off_x = ti.cast(((i + 0.5) / sampling - 0.5 - margin - x[g]) * scale, ti.f32)
                    off_y = ti.cast(((j + 0.5) / sampling - 0.5 - margin - y[g]) * scale, ti.f32)
                    step = ti.cast(scale / sampling, ti.f32)
                    face_x, face_y, bright = slope_x[g], slope_y[g], intensity * brightness[g]
                height = ti.sqrt(ti.max(one - off_x * off_x - off_y * off_y, zero)) + rim
                across, down = off_x + face_x, off_y + face_y
                front, side = height * lamp_front, across * lamp_side
                lamps = ti.max(front - side, zero) + ti.max(front + side, zero)
                length = ti.sqrt(across * across + down * down + height * height)
                radiance[j, i] = bright * (ambient + (one - ambient) * lamps / length)
            last = depth


@ti.kernel
def implement_radiance(
    samples: _i32,
    x: ti.f64,
    y: ti.f64,
    wheel_radius: ti.f64,
    angle: ti.f64,
    grain: ti.f64,
    sampling: ti.i32,
    margin: ti.i32,
    light: ti.f64,
    radiance: _f32,
):
    """Light of the implement's side, marked with blotches of `grain` px; a wheel has rim, hub and spokes.

    These are smooth over a pixel, so one value serves all of a pixel's samples; its outline does not.
    """
    cosine, sine = ti.cos(angle), ti.sin(angle)
    for j, i in ti.ndrange(samples.shape[0] // sampling, samples.shape[1] // sampling):
        seen = False
        for b, a in ti.ndrange(sampling, sampling):
            seen = seen or samples[j * sampling + b, i * sampling + a] == IMPLEMENT
        if seen:
            off_x, off_y = i - margin - x, j - margin - y
            body_x, body_y = cosine * off_x + sine * off_y, cosine * off_y - sine * off_x
            pattern = 1.0
            if wheel_radius > 0.0:
                pattern = _wheel_pattern(body_x / wheel_radius, body_y / wheel_radius)
            blotch = _blotch(body_x / grain, body_y / grain) + 0.5 * _blotch(
                2.3 * body_x / grain + 31.0, 2.3 * body_y / grain
            )
            value = ti.cast(light * (pattern + 0.25 * blotch), ti.f32)
            for b, a in ti.ndrange(sampling, sampling):
                if samples[j * sampling + b, i * sampling + a] == IMPLEMENT:
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


@ti.kernel
def filter_rows(radiance: _f32, taps: _f32, start: ti.i32, sampling: ti.i32, filtered: _f32):
    """Blur along x and integrate over the pixels' width: one output a pixel, rows still at sample spacing."""
    for j, i in ti.ndrange(filtered.shape[0], filtered.shape[1]):
        total = ti.f32(0.0)
        for k in range(taps.shape[0]):
            total += taps[k] * radiance[j, start + i * sampling + k]
        filtered[j, i] = total


@ti.kernel
def filter_columns(filtered: _f32, taps: _f32, start: ti.i32, sampling: ti.i32, picture: _f32):
    """Blur along y and integrate over the pixels' height."""
    for j, i in ti.ndrange(picture.shape[0], picture.shape[1]):
        total = ti.f32(0.0)
        for k in range(taps.shape[0]):
            total += taps[k] * filtered[start + j * sampling + k, i]
        picture[j, i] = total
