# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of the particles' motion. Import this module only after `synth.devices.start_taichi`.

World coordinates throughout: m, z up. Particles are sorted by square cells; `first` holds each cell's first
particle, with one entry more than there are cells. Every thread gathers for its own points.
"""

import taichi as ti

_f64 = ti.types.ndarray(dtype=ti.f64)
_f32 = ti.types.ndarray(dtype=ti.f32)
_i32 = ti.types.ndarray(dtype=ti.i32)
_u8 = ti.types.ndarray(dtype=ti.u8)


@ti.func
def _cell(position, origin, size, count):
    return ti.min(ti.max(int(ti.floor((position - origin) / size)), 0), count - 1)


@ti.kernel
def fit_gradients(
    x: _f64,
    z: _f64,
    moved_x: _f64,
    moved_z: _f64,
    first: _i32,
    columns: ti.i32,
    rows: ti.i32,
    left: ti.f64,
    bottom: ti.f64,
    cell: ti.f64,
    reach: ti.f64,
    floor: ti.f64,
    gradient: _f64,
):
    """Displacement gradient at every particle by weighted least squares over its neighbours within `reach`.

    Particles are sorted by cell (`first` holds each cell's first). Directions in which the neighbours spread
    less than `floor` (m2) count as if they spread that much: the gradient fades there instead of blowing up.
    """
    ring = int(ti.ceil(reach / cell))
    for p in range(x.shape[0]):
        spread = ti.Matrix.zero(ti.f64, 2, 2)
        cross = ti.Matrix.zero(ti.f64, 2, 2)
        weight_sum = 1.0
        column, row = _cell(x[p], left, cell, columns), _cell(z[p], bottom, cell, rows)
        for r in range(ti.max(row - ring, 0), ti.min(row + ring, rows - 1) + 1):
            begin = first[r * columns + ti.max(column - ring, 0)]
            end = first[r * columns + ti.min(column + ring, columns - 1) + 1]
            for q in range(begin, end):
                away = ti.Vector([x[q] - x[p], z[q] - z[p]])
                square = away.norm_sqr() / (reach * reach)
                if square < 1.0 and q != p:
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


@ti.kernel
def blend_motion(
    point_x: _f64,
    point_z: _f64,
    alive: _u8,
    x: _f64,
    z: _f64,
    moved_x: _f64,
    moved_z: _f64,
    gradient: _f64,
    first: _i32,
    columns: ti.i32,
    rows: ti.i32,
    left: ti.f64,
    bottom: ti.f64,
    cell: ti.f64,
    reach: ti.f64,
    displacement: _f64,
    turn: _f64,
    strain: _f32,
    nearest: _i32,
):
    """Motion of points by a partition of unity over the affine motions of the particles within `reach`.

    The weights are Wendland's C2 function of the distance, normalised to one. `nearest` is -1 where no
    particle is within reach.
    """
    ring = int(ti.ceil(reach / cell))
    for g in range(point_x.shape[0]):
        nearest[g] = -1
        if alive[g] == 1:
            blended = ti.Vector.zero(ti.f64, 2)
            stretch = ti.Matrix.zero(ti.f64, 2, 2)
            weight_sum = 0.0
            closest = 1.0
            column, row = _cell(point_x[g], left, cell, columns), _cell(point_z[g], bottom, cell, rows)
            for r in range(ti.max(row - ring, 0), ti.min(row + ring, rows - 1) + 1):
                begin = first[r * columns + ti.max(column - ring, 0)]
                end = first[r * columns + ti.min(column + ring, columns - 1) + 1]
                for p in range(begin, end):
                    away = ti.Vector([point_x[g] - x[p], point_z[g] - z[p]])
                    if away.norm_sqr() < reach * reach:
                        ratio = away.norm() / reach
                        weight = (1.0 - ratio) ** 4 * (1.0 + 4.0 * ratio)
                        local = ti.Matrix(
                            [[gradient[p, 0, 0], gradient[p, 0, 1]], [gradient[p, 1, 0], gradient[p, 1, 1]]]
                        )
                        blended += weight * (ti.Vector([moved_x[p], moved_z[p]]) + local @ away)
                        stretch += weight * local
                        weight_sum += weight
                        if ratio < closest:
                            closest = ratio
                            nearest[g] = p
            if weight_sum > 1e-12:
                blended /= weight_sum
                stretch /= weight_sum
                displacement[g, 0], displacement[g, 1] = blended[0], blended[1]
                # The rotation in F = I + grad u (polar decomposition); half the curl where it is small.
                turn[g] = ti.atan2(stretch[1, 0] - stretch[0, 1], 2.0 + stretch[0, 0] + stretch[1, 1])
                strain[g] = ti.cast(_shear_strain(stretch), ti.f32)


@ti.func
def _shear_strain(gradient):
    """Equivalent shear strain sqrt(2 e:e), e the deviator of the symmetric gradient."""
    stretch = gradient[0, 0] - gradient[1, 1]
    shear = gradient[0, 1] + gradient[1, 0]
    return ti.sqrt(stretch * stretch + shear * shear)
