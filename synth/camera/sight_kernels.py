# type: ignore  # taichi reads annotations and operators in its own way
"""What particles a point has around it, and sees past the implement. Import only after taichi was started.

World coordinates throughout: m, z up. Particles are sorted by square cells; `first` holds each cell's first
particle, with one entry more than there are cells. `grid` holds the cells' left, bottom and size, `shape`
their columns and rows. `parts` are the implement's capsules in the world: both ends and the radius, m.
"""

import taichi as ti

grid_vector = ti.types.vector(3, ti.f64)
shape_vector = ti.types.vector(2, ti.i32)


@ti.func
def cells_around(x, z, reach, grid, shape):
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
def outside(x, z, parts: ti.template()):
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
def behind(px, pz, qx, qz, parts: ti.template()):
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
def sees(eye, reach, x, z, parts: ti.template()):
    """Whether the implement does not hide a point, within reach, from where `outside` put the eye."""
    return eye[2] >= reach or not behind(eye[0], eye[1], x, z, parts)
