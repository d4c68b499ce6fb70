# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of affine fits to the particles' motion. Import only after `synth.devices.start_taichi`.

Coordinates and cells as in `synth.camera.sight_kernels`. Every thread gathers for its own particles.
"""

import taichi as ti

from synth.camera.sight_kernels import cells_around, grid_vector, outside, sees, shape_vector

_f64 = ti.types.ndarray(dtype=ti.f64, ndim=1)
_f64_table = ti.types.ndarray(dtype=ti.f64, ndim=2)
_f64_block = ti.types.ndarray(dtype=ti.f64, ndim=3)
_i32 = ti.types.ndarray(dtype=ti.i32, ndim=1)
_u8 = ti.types.ndarray(dtype=ti.u8, ndim=1)


@ti.kernel
def fit_neighbours(
    x: _f64,
    z: _f64,
    moved_x: _f64,
    moved_z: _f64,
    first: _i32,
    grid: grid_vector,
    shape: shape_vector,
    reach: ti.f64,
    parts: _f64_table,
    floor: ti.f64,
    expected: _f64_table,
):
    """Displacement of every particle that its neighbours within `reach` lead to expect: columns 0 and 1.

    It is that of an affine motion fitted to the neighbours alone, those on its side of the implement.
    NaN where there are fewer than six, or they spread less than `floor` (m2) in a direction.
    """
    for p in range(x.shape[0]):
        weight_sum, count = 0.0, 0
        middle, shift = ti.Vector.zero(ti.f64, 2), ti.Vector.zero(ti.f64, 2)
        spread, cross = ti.Matrix.zero(ti.f64, 2, 2), ti.Matrix.zero(ti.f64, 2, 2)
        eye = outside(x[p], z[p], parts)
        box = cells_around(x[p], z[p], reach, grid, shape)
        for r in range(box[2], box[3] + 1):
            for q in range(first[r * shape[0] + box[0]], first[r * shape[0] + box[1] + 1]):
                away = ti.Vector([x[q] - x[p], z[q] - z[p]])
                square = away.norm_sqr() / (reach * reach)
                if square < 1.0 and q != p and sees(eye, reach, x[q], z[q], parts):
                    weight = (1.0 - square) ** 2
                    relative = ti.Vector([moved_x[q] - moved_x[p], moved_z[q] - moved_z[p]])
                    weight_sum += weight
                    count += 1
                    middle += weight * away
                    shift += weight * relative
                    spread += weight * away.outer_product(away)
                    cross += weight * relative.outer_product(away)
        expected[p, 0] = expected[p, 1] = ti.math.nan
        if count >= 6:
            middle, shift = middle / weight_sum, shift / weight_sum
            spread = spread / weight_sum - middle.outer_product(middle)
            cross = cross / weight_sum - shift.outer_product(middle)
            mean, half = 0.5 * (spread[0, 0] + spread[1, 1]), 0.5 * (spread[0, 0] - spread[1, 1])
            if mean - ti.sqrt(half * half + spread[0, 1] * spread[0, 1]) >= floor:
                found = shift - cross @ _floored_inverse(spread, floor) @ middle
                expected[p, 0], expected[p, 1] = moved_x[p] + found[0], moved_z[p] + found[1]


@ti.kernel
def find_loose(
    x: _f64,
    z: _f64,
    moved_x: _f64,
    moved_z: _f64,
    expected: _f64_table,
    first: _i32,
    grid: grid_vector,
    shape: shape_vector,
    reach: ti.f64,
    ratio: ti.f64,
    least: ti.f64,
    loose: _u8,
):
    """Particles further from what is expected than `ratio` times their neighbours' median, plus `least`.

    The normalised median test of Westerweel and Scarano, Experiments in Fluids 39, 2005, with residuals of
    affine fits in place of those of medians: a gradient is no outlier.
    """
    for p in range(x.shape[0]):
        loose[p] = ti.u8(0)
        own = ti.sqrt((moved_x[p] - expected[p, 0]) ** 2 + (moved_z[p] - expected[p, 1]) ** 2)
        if own > least:  # NaN is not
            count, below = 0, 0
            box = cells_around(x[p], z[p], reach, grid, shape)
            limit = (own - least) / ratio
            for r in range(box[2], box[3] + 1):
                for q in range(first[r * shape[0] + box[0]], first[r * shape[0] + box[1] + 1]):
                    square = (x[q] - x[p]) ** 2 + (z[q] - z[p]) ** 2
                    if square < reach * reach and q != p:
                        other = ti.sqrt(
                            (moved_x[q] - expected[q, 0]) ** 2 + (moved_z[q] - expected[q, 1]) ** 2
                        )
                        if other >= 0.0:
                            count += 1
                            below += int(other < limit)
            # The median is below the limit where more than half of the neighbours are.
            if count >= 4 and 2 * below > count:
                loose[p] = ti.u8(1)


@ti.kernel
def fit_gradients(
    x: _f64,
    z: _f64,
    moved_x: _f64,
    moved_z: _f64,
    loose: _u8,
    first: _i32,
    grid: grid_vector,
    shape: shape_vector,
    reach: ti.f64,
    parts: _f64_table,
    floor: ti.f64,
    gradient: _f64_block,
):
    """Displacement gradient at every particle by weighted least squares over its neighbours within `reach`.

    Loose neighbours do not count. Directions in which the others spread less than `floor` (m2) count as if
    they spread that much: the gradient fades there instead of blowing up.
    """
    for p in range(x.shape[0]):
        spread = ti.Matrix.zero(ti.f64, 2, 2)
        cross = ti.Matrix.zero(ti.f64, 2, 2)
        weight_sum = 1.0
        eye = outside(x[p], z[p], parts)
        box = cells_around(x[p], z[p], reach, grid, shape)
        for r in range(box[2], box[3] + 1):
            for q in range(first[r * shape[0] + box[0]], first[r * shape[0] + box[1] + 1]):
                away = ti.Vector([x[q] - x[p], z[q] - z[p]])
                square = away.norm_sqr() / (reach * reach)
                seen = square < 1.0 and q != p and loose[q] == 0
                if seen and sees(eye, reach, x[q], z[q], parts):
                    weight = (1.0 - square) ** 2
                    relative = ti.Vector([moved_x[q] - moved_x[p], moved_z[q] - moved_z[p]])
                    spread += weight * away.outer_product(away)
                    cross += weight * relative.outer_product(away)
                    weight_sum += weight
        fitted = cross @ _floored_inverse(spread / weight_sum, floor) / weight_sum
        for i in ti.static(range(2)):
            for j in ti.static(range(2)):
                gradient[p, i, j] = fitted[i, j]


@ti.func
def _floored_inverse(matrix, floor):
    """Inverse of a symmetric 2 x 2 matrix whose eigenvalues are lifted to `floor`."""
    mean = 0.5 * (matrix[0, 0] + matrix[1, 1])
    half = 0.5 * (matrix[0, 0] - matrix[1, 1])
    radius = ti.sqrt(half * half + matrix[0, 1] * matrix[0, 1])
    large, small = ti.max(mean + radius, floor), ti.max(mean - radius, floor)
    cosine, sine = 1.0, 0.0  # of twice the angle of the larger eigenvalue's direction
    if radius > 0.0:
        cosine, sine = half / radius, matrix[0, 1] / radius
    inverse_mean, inverse_half = 0.5 * (1.0 / large + 1.0 / small), 0.5 * (1.0 / large - 1.0 / small)
    return ti.Matrix(
        [
            [inverse_mean + inverse_half * cosine, inverse_half * sine],
            [inverse_half * sine, inverse_mean - inverse_half * cosine],
        ]
    )
