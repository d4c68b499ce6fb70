# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of the particles' motion as a field. Import only after `synth.devices.start_taichi`.

Coordinates and cells as in `synth.camera.sight_kernels`. `affine` holds what a particle says of the motion
around it: its x and z, its displacement along both, and the displacement gradient row by row. Every thread
gathers for its own points.
"""

import taichi as ti

from synth.camera.share_kernels import SHARES, dealt
from synth.camera.sight_kernels import behind, cells_around, grid_vector, outside, shape_vector

_f64 = ti.types.ndarray(dtype=ti.f64, ndim=1)
_f64_table = ti.types.ndarray(dtype=ti.f64, ndim=2)
_f64_eights = ti.types.ndarray(dtype=ti.types.vector(8, ti.f64), ndim=1)
_f64_fours = ti.types.ndarray(dtype=ti.types.vector(4, ti.f64), ndim=2)
_f32 = ti.types.ndarray(dtype=ti.f32, ndim=1)
_i32 = ti.types.ndarray(dtype=ti.i32, ndim=1)
_i32_table = ti.types.ndarray(dtype=ti.i32, ndim=2)
_u8 = ti.types.ndarray(dtype=ti.u8, ndim=1)
_u8_table = ti.types.ndarray(dtype=ti.u8, ndim=2)

NOWHERE, FREE, CLOSE, BESIDE, INNER = 0, 1, 2, 3, 4
"""A node without a particle near, one with, one with a particle so close that every point around the node has
it near, one beside the implement, whose value holds on its side only, and a close one with all around it free
or close."""
_RUN = 1024
"""Points that a thread moves one after the other."""


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
    eye, per_reach = outside(at_x, at_z, parts), 1.0 / reach
    blended, stretch = ti.Vector.zero(ti.f64, 2), ti.Vector.zero(ti.f64, 4)
    weight_sum, closest, nearest, beside = 0.0, reach * reach, -1, eye[2] < reach
    box = cells_around(at_x, at_z, reach, grid, shape)
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
                weight = 0.0 if behind(eye[0], eye[1], own[0], own[1], parts) else weight
            blended[0] += weight * (own[2] + own[4] * away_x + own[5] * away_z)
            blended[1] += weight * (own[3] + own[6] * away_x + own[7] * away_z)
            for n in ti.static(range(4)):
                stretch[n] += weight * own[4 + n]
            weight_sum += weight
            near = (weight > 0.0) & (square < closest)
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
        j = dealt(share // SHARES, state.shape[0], 1)
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
    closest, near = reach * reach, -1
    low_i, low_j = int(ti.floor(s)), int(ti.floor(t))
    for n in ti.static(range(4)):
        # No branch: which node's particle is the nearest cannot be foreseen.
        candidate = nearest[low_j + n // 2, low_i + n % 2]
        own = affine[ti.max(candidate, 0)]
        square = (p - own[0]) ** 2 + (q - own[1]) ** 2
        nearer = (candidate >= 0) & (square < closest)
        closest, near = ti.select(nearer, square, closest), ti.select(nearer, candidate, near)
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
    per_spacing, runs = 1.0 / spacing, (at_x.shape[0] + _RUN - 1) // _RUN
    for share in range(runs * SHARES):
        if share % SHARES != 0:
            continue
        start = dealt(share // SHARES, runs, 1) * _RUN
        for g in range(start, ti.min(start + _RUN, at_x.shape[0])):
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
    point: _i32,
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
    """Strain at points, and the nearest particle (-1: none), as `carry` takes them.

    `point` lists the points, `chosen` the places in this list that are looked at.
    """
    per_spacing = 1.0 / spacing
    for c in range(chosen.shape[0]):
        k = chosen[c]
        p, q = at_x[point[k]], at_z[point[k]]
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
        strain[k], particle[k] = ti.cast(strained, ti.f32), -1
        if near >= 0:
            particle[k] = order[near]


@ti.func
def _shear_strain(gradient):
    """Equivalent shear strain sqrt(2 e:e), e the deviator of the symmetric gradient, given row by row."""
    stretch = gradient[0] - gradient[3]
    shear = gradient[1] + gradient[2]
    return ti.sqrt(stretch * stretch + shear * shear)
