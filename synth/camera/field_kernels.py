# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of the particles' motion. Import this module only after `synth.devices.start_taichi`.

World coordinates throughout: m, z up. Particles are sorted by square cells; `first` holds each cell's first
particle, with one entry more than there are cells. `grid` holds the cells' left, bottom and size, `shape`
their columns and rows. `affine` holds what a particle says of the motion around it: its x and z, its
displacement along both, and the displacement gradient row by row. Every thread gathers for its own points.
"""

import taichi as ti

from synth.camera.shares import SHARES

_f64 = ti.types.ndarray(dtype=ti.f64, ndim=1)
_f64_table = ti.types.ndarray(dtype=ti.f64, ndim=2)
_f64_block = ti.types.ndarray(dtype=ti.f64, ndim=3)
_f64_eights = ti.types.ndarray(dtype=ti.types.vector(8, ti.f64), ndim=1)
_f64_fours = ti.types.ndarray(dtype=ti.types.vector(4, ti.f64), ndim=2)
_f32 = ti.types.ndarray(dtype=ti.f32, ndim=1)
_i32 = ti.types.ndarray(dtype=ti.i32, ndim=1)
_i32_table = ti.types.ndarray(dtype=ti.i32, ndim=2)
_u8 = ti.types.ndarray(dtype=ti.u8, ndim=1)
_u8_table = ti.types.ndarray(dtype=ti.u8, ndim=2)
grid_vector = ti.types.vector(3, ti.f64)
shape_vector = ti.types.vector(2, ti.i32)

NOWHERE, FREE, CLOSE, BESIDE, INNER = 0, 1, 2, 3, 4
"""A node without a particle near, one with, one with a particle so close that every point around the node has
it near, one beside the implement, whose value holds on its side only, and a close one with all around it free
or close."""


@ti.func
def _cells_around(x, z, reach, grid, shape):
    """Columns and rows, first and last, of the cells within reach."""
    low = ti.Vector([x - reach - grid[0], z - reach - grid[1]]) / grid[2]
    high = ti.Vector([x + reach - grid[0], z + reach - grid[1]]) / grid[2]
    top = ti.Vector([shape[0] - 1, shape[1] - 1])
    low_i = ti.min(ti.max(int(ti.floor(low[0])), 0), top[0])
    low_j = ti.min(ti.max(int(ti.floor(low[1])), 0), top[1])
    high_i = ti.min(ti.max(int(ti.floor(high[0])), 0), top[0])
    high_j = ti.min(ti.max(int(ti.floor(high[1])), 0), top[1])
    return ti.Vector([low_i, high_i, low_j, high_j])


@ti.func
def _to_segment(px, pz, ax, az, bx, bz):
    """From a point to the nearest point of a line from a to b."""
    ex, ez = bx - ax, bz - az
    length = ex * ex + ez * ez
    along = 0.0
    if length > 0.0:
        along = ti.max(0.0, ti.min(1.0, ((px - ax) * ex + (pz - az) * ez) / length))
    return ti.Vector([ax + along * ex - px, az + along * ez - pz])


@ti.func
def _outside(x, z, parts: ti.template()):
    """A point, or the nearest point of the implement's outline where it lies inside, and its distance before.

    `parts` are the implement's capsules in the world: both ends and the radius, m.
    """
    nearest, to_x, to_z, radius = ti.math.inf, 0.0, 0.0, 0.0
    for c in range(parts.shape[0]):
        to = _to_segment(x, z, parts[c, 0], parts[c, 1], parts[c, 2], parts[c, 3])
        if to.norm() - parts[c, 4] < nearest:
            nearest, to_x, to_z, radius = to.norm() - parts[c, 4], to[0], to[1], parts[c, 4]
    out_x, out_z = x, z
    if nearest < 0.0:
        length = ti.max(nearest + radius, 1e-12)
        out_x, out_z = x + to_x - to_x / length * radius, z + to_z - to_z / length * radius
    return ti.Vector([out_x, out_z, nearest])


@ti.func
def _behind(px, pz, qx, qz, parts: ti.template()):
    """Whether a line passes a capsule's axis nearer than half its radius: goes through the implement."""
    hidden = False
    for c in range(parts.shape[0]):
        ax, az, bx, bz = parts[c, 0], parts[c, 1], parts[c, 2], parts[c, 3]
        core = 0.5 * parts[c, 4]
        side_a = (qx - px) * (az - pz) - (qz - pz) * (ax - px)
        side_b = (qx - px) * (bz - pz) - (qz - pz) * (bx - px)
        side_p = (bx - ax) * (pz - az) - (bz - az) * (px - ax)
        side_q = (bx - ax) * (qz - az) - (bz - az) * (qx - ax)
        crossing = side_a * side_b < 0.0 and side_p * side_q < 0.0
        near = ti.min(
            _to_segment(ax, az, px, pz, qx, qz).norm(),
            _to_segment(bx, bz, px, pz, qx, qz).norm(),
        )
        hidden = hidden or crossing or near < core
    return hidden


@ti.func
def _sees(eye, reach, x, z, parts: ti.template()):
    """Whether the implement does not hide a point, within reach, from where `_outside` put the eye."""
    return eye[2] >= reach or not _behind(eye[0], eye[1], x, z, parts)


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
        eye = _outside(x[p], z[p], parts)
        box = _cells_around(x[p], z[p], reach, grid, shape)
        for r in range(box[2], box[3] + 1):
            for q in range(first[r * shape[0] + box[0]], first[r * shape[0] + box[1] + 1]):
                away = ti.Vector([x[q] - x[p], z[q] - z[p]])
                square = away.norm_sqr() / (reach * reach)
                if square < 1.0 and q != p and _sees(eye, reach, x[q], z[q], parts):
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
            box = _cells_around(x[p], z[p], reach, grid, shape)
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
        eye = _outside(x[p], z[p], parts)
        box = _cells_around(x[p], z[p], reach, grid, shape)
        for r in range(box[2], box[3] + 1):
            for q in range(first[r * shape[0] + box[0]], first[r * shape[0] + box[1] + 1]):
                away = ti.Vector([x[q] - x[p], z[q] - z[p]])
                square = away.norm_sqr() / (reach * reach)
                seen = square < 1.0 and q != p and loose[q] == 0
                if seen and _sees(eye, reach, x[q], z[q], parts):
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


@ti.func
def _blend(
    at_x,
    at_z,
    affine: ti.template(),
    first: ti.template(),
    grid,
    shape,
    reach,
    parts: ti.template(),
):
    """Displacement, turn and strain at a place, the nearest particle (-1: none), and two distances.

    A partition of unity over the affine motions of the particles within reach that the implement does not
    hide. The weights are Wendland's C2 function of the distance. The two distances are the nearest particle's
    and the implement's.
    """
    eye, per_reach = _outside(at_x, at_z, parts), 1.0 / reach
    blended, stretch = ti.Vector.zero(ti.f64, 2), ti.Vector.zero(ti.f64, 4)
    weight_sum, closest, nearest, beside = 0.0, reach * reach, -1, eye[2] < reach
    box = _cells_around(at_x, at_z, reach, grid, shape)
    for r in range(box[2], box[3] + 1):
        for p in range(first[r * shape[0] + box[0]], first[r * shape[0] + box[1] + 1]):
            own = affine[p]
            away_x, away_z = at_x - own[0], at_z - own[1]
            square = away_x * away_x + away_z * away_z
            # No branch: which particles are within reach cannot be foreseen. Those beyond weigh nothing.
            ratio = ti.min(ti.sqrt(square) * per_reach, 1.0)
            rest = (1.0 - ratio) * (1.0 - ratio)
            weight = rest * rest * (1.0 + 4.0 * ratio)
            if beside and weight > 0.0:
                weight = 0.0 if _behind(eye[0], eye[1], own[0], own[1], parts) else weight
            blended[0] += weight * (own[2] + own[4] * away_x + own[5] * away_z)
            blended[1] += weight * (own[3] + own[6] * away_x + own[7] * away_z)
            for n in ti.static(range(4)):
                stretch[n] += weight * own[4 + n]
            weight_sum += weight
            near = weight > 0.0 and square < closest
            closest, nearest = ti.select(near, square, closest), ti.select(near, p, nearest)
    turn, strain = 0.0, 0.0
    if weight_sum > 1e-12:
        blended /= weight_sum
        stretch /= weight_sum
        # The rotation in F = I + grad u (polar decomposition); half the curl where it is small.
        turn = ti.atan2(stretch[2] - stretch[1], 2.0 + stretch[0] + stretch[3])
        strain = _shear_strain(stretch)
    else:
        nearest = -1
    return ti.Vector(
        [blended[0], blended[1], turn, strain, ti.cast(nearest, ti.f64), ti.sqrt(closest), eye[2]]
    )


@ti.kernel
def blend_at_nodes(
    affine: _f64_eights,
    first: _i32,
    grid: grid_vector,
    shape: shape_vector,
    reach: ti.f64,
    parts: _f64_table,
    left: ti.f64,
    bottom: ti.f64,
    spacing: ti.f64,
    value: _f64_fours,
    nearest: _i32_table,
    state: _u8_table,
):
    """Motion at the nodes of a square grid, `spacing` apart: displacement, turn and strain."""
    for share in range(state.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        j = share // SHARES
        for i in range(state.shape[1]):
            found = _blend(
                left + i * spacing,
                bottom + j * spacing,
                affine,
                first,
                grid,
                shape,
                reach,
                parts,
            )
            value[j, i] = ti.Vector([found[0], found[1], found[2], found[3]])
            nearest[j, i] = int(found[4])
            state[j, i] = ti.u8(NOWHERE)
            if nearest[j, i] >= 0:
                state[j, i] = ti.u8(FREE)
                if found[5] + spacing < reach:
                    state[j, i] = ti.u8(CLOSE)
            if found[6] < 3.0 * spacing:
                state[j, i] = ti.u8(BESIDE)


@ti.kernel
def find_inner(state: _u8_table):
    """Mark the close nodes between free ones; a thread's own mark does not change what others find."""
    for share in range((state.shape[0] - 2) * SHARES):
        if share % SHARES != 0:
            continue
        j = 1 + share // SHARES
        for i in range(1, state.shape[1] - 1):
            free = True
            for n in ti.static(range(9)):
                around = state[j + n // 3 - 1, i + n % 3 - 1]
                free = free and around != NOWHERE and around != BESIDE
            if free and state[j, i] == CLOSE:
                state[j, i] = ti.u8(INNER)


@ti.func
def _rounded(number):
    """Nearest integer; unlike `ti.round`, no call."""
    return ti.cast(ti.floor(number + 0.5), ti.i32)


@ti.func
def _spline(s, t, i, j, inner, value: ti.template(), nearest: ti.template()):
    """Quadratic B-splines over the nodes around (i, j) that have a particle near, at (s, t) in spacings."""
    a, b = s - i, t - j
    across = ti.Vector([0.5 * (0.5 - a) * (0.5 - a), 0.75 - a * a, 0.5 * (0.5 + a) * (0.5 + a)])
    upwards = ti.Vector([0.5 * (0.5 - b) * (0.5 - b), 0.75 - b * b, 0.5 * (0.5 + b) * (0.5 + b)])
    blended = ti.Vector.zero(ti.f64, 4)
    if inner:
        for n in ti.static(range(3)):
            row = ti.Vector.zero(ti.f64, 4)
            for m in ti.static(range(3)):
                row += across[m] * value[j + n - 1, i + m - 1]
            blended += upwards[n] * row
    else:
        whole = 0.0
        for n in ti.static(range(3)):
            for m in ti.static(range(3)):
                if nearest[j + n - 1, i + m - 1] >= 0:
                    weight = across[m] * upwards[n]
                    whole += weight
                    blended += weight * value[j + n - 1, i + m - 1]
        if whole > 0.0:
            blended /= whole
    return blended


@ti.func
def _nearest_of(p, q, s, t, affine: ti.template(), nearest: ti.template(), reach):
    """Nearest to a point of the particles that are nearest to the four nodes around it; -1: none in reach."""
    closest, near, last = reach * reach, -1, -1
    low_i, low_j = int(ti.floor(s)), int(ti.floor(t))
    for n in ti.static(range(4)):
        candidate = nearest[low_j + n // 2, low_i + n % 2]
        if candidate >= 0 and candidate != last:
            square = (p - affine[candidate][0]) ** 2 + (q - affine[candidate][1]) ** 2
            if square < closest:
                closest, near = square, candidate
        last = candidate
    return near


@ti.kernel
def carry(
    at_x: _f64,
    at_z: _f64,
    angle: _f64,
    alive: _u8,
    affine: _f64_eights,
    first: _i32,
    grid: grid_vector,
    shape: shape_vector,
    reach: ti.f64,
    parts: _f64_table,
    left: ti.f64,
    bottom: ti.f64,
    spacing: ti.f64,
    value: _f64_fours,
    nearest: _i32_table,
    state: _u8_table,
    next_x: _f64,
    next_z: _f64,
    next_angle: _f64,
    next_alive: _u8,
):
    """Move points by quadratic B-splines over nodes; beside the implement, by the particles themselves.

    Nodes without a particle near do not count. A point without one is lost.
    """
    per_spacing = 1.0 / spacing
    for g in range(at_x.shape[0]):
        p, q = at_x[g], at_z[g]
        u, v, turn, lives = 0.0, 0.0, 0.0, False
        s, t = (p - left) * per_spacing, (q - bottom) * per_spacing
        i, j = _rounded(s), _rounded(t)
        if alive[g] == 1 and 1 <= i < state.shape[1] - 1 and 1 <= j < state.shape[0] - 1:
            kind = state[j, i]
            if kind == BESIDE:
                found = _blend(p, q, affine, first, grid, shape, reach, parts)
                u, v, turn, lives = found[0], found[1], found[2], found[4] >= 0.0
            else:
                blended = _spline(s, t, i, j, kind == INNER, value, nearest)
                u, v, turn = blended[0], blended[1], blended[2]
                lives = kind != FREE and kind != NOWHERE
                if not lives:
                    lives = _nearest_of(p, q, s, t, affine, nearest, reach) >= 0
        if not lives:
            u, v, turn = 0.0, 0.0, 0.0
        next_x[g], next_z[g], next_angle[g] = p + u, q + v, angle[g] + turn
        next_alive[g] = ti.cast(lives, ti.u8)


@ti.kernel
def look_around(
    at_x: _f64,
    at_z: _f64,
    chosen: _i32,
    affine: _f64_eights,
    first: _i32,
    order: _i32,
    grid: grid_vector,
    shape: shape_vector,
    reach: ti.f64,
    parts: _f64_table,
    left: ti.f64,
    bottom: ti.f64,
    spacing: ti.f64,
    value: _f64_fours,
    nearest: _i32_table,
    state: _u8_table,
    strain: _f32,
    particle: _i32,
):
    """Strain at chosen points, and the nearest particle (-1: none), as `carry` takes them."""
    per_spacing = 1.0 / spacing
    for c in range(chosen.shape[0]):
        p, q = at_x[chosen[c]], at_z[chosen[c]]
        strained, near = 0.0, -1
        s, t = (p - left) * per_spacing, (q - bottom) * per_spacing
        i, j = _rounded(s), _rounded(t)
        if 1 <= i < state.shape[1] - 1 and 1 <= j < state.shape[0] - 1:
            kind = state[j, i]
            if kind == BESIDE:
                found = _blend(p, q, affine, first, grid, shape, reach, parts)
                strained, near = found[3], int(found[4])
            else:
                strained = _spline(s, t, i, j, kind == INNER, value, nearest)[3]
                near = _nearest_of(p, q, s, t, affine, nearest, reach)
        strain[c], particle[c] = ti.cast(strained, ti.f32), -1
        if near >= 0:
            particle[c] = order[near]


@ti.func
def _shear_strain(gradient):
    """Equivalent shear strain sqrt(2 e:e), e the deviator of the symmetric gradient, given row by row."""
    stretch = gradient[0] - gradient[3]
    shear = gradient[1] + gradient[2]
    return ti.sqrt(stretch * stretch + shear * shear)
