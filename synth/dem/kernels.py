"""The kernels: forces of contacts, then motion of grains, then motion of the implement.

Every number has one writer: a pair's force is computed once and stored, then each grain gathers its own in a
fixed order, so results are the same bytes on any number of threads. Two dimensions, plane strain; all per
metre of width; rotations counter-clockwise positive in the (x, z) plane. Import only after
`synth.devices.start_taichi`.
"""

from typing import Any, NamedTuple

import taichi as ti

from synth.dem.step_kernels import Ref, Team, take_steps

# components of `motion`
X, Z, VX, VZ, ANGLE, SPIN = range(6)
# components of `body`
RADIUS, MASS, INERTIA, WALL_DAMPING = range(4)
# components of `pairs`: its grains, and where what it does to each stands in `contact_load`
FIRST, SECOND, FIRST_END, SECOND_END = range(4)
# components of `contact_load`: force and moment on the grain whose contact it is
LOAD_X, LOAD_Z, LOAD_MOMENT = range(3)
# components of `pair_memory` and `tool_memory`, and of each wall in `wall_memory`
SHEAR, ROLL = range(2)
WALL_COUNT = 3
# entries of `constants`, which do not change during a run
KN, KT, ROOT_KN, ROOT_KT, FRICTION, WALL_FRICTION, TOOL_FRICTION, ROLLING_FRICTION, ROLLING_STIFFNESS = range(
    9
)
TIME_STEP, GRAVITY_X, GRAVITY_Z, WIDTH, DRAG, COHESION = range(9, 15)
CONSTANT_COUNT = 15
# components of `pair_body`: what a pair's two grains make together (damping at walls is in `body`); radii
DAMPING, REACH, FIRST_RADIUS, SECOND_RADIUS = range(4)
# what a kernel is compiled for
COHESIVE = 1
# entries of `tool`: its pose and motion, what drives it, and the impulse the grains gave it since last asked
TOOL_X, TOOL_Z, TOOL_ANGLE, TOOL_COS, TOOL_SIN, TOOL_VX, TOOL_VZ, TOOL_SPIN = range(8)
TOOL_MASS, TOOL_LOAD, TOOL_HEAVES, TOOL_PX, TOOL_PZ, TOOL_PM = range(8, 14)
TOOL_SIZE = 14
# components of `parts`: ends of a capsule in the tool's frame, its radius, whether it continues another
PART_AX, PART_AZ, PART_BX, PART_BZ, PART_RADIUS, PART_CONTINUES = range(6)

FAR = 1e30
"""Further squared, m2, than a grain can be."""
STEPS_UNROLLED = 4
"""In one launch of ordinary loops: a launch costs as much as a tenth of a step of 10 000 grains."""

Two = ti.types.vector(2, ti.f64)
Row = ti.types.ndarray(ti.f64, ndim=1)
Index = ti.types.ndarray(ti.i32, ndim=1)


def rows(size, dtype=ti.f64):
    """An array of records of so many numbers, each record in one piece of memory."""
    return ti.types.ndarray(ti.types.vector(size, dtype), ndim=1)


class Soil(NamedTuple):
    """The arrays that grains, pairs and implement stand in, held together while a kernel is compiled.

    `synth.dem.layout` and the solver say what they hold; the last three are an elastic rim's.
    """

    features: int
    constants: Any
    motion: Any
    body: Any
    pairs: Any
    pair_body: Any
    pair_memory: Any
    touched: Any
    contact_load: Any
    first_contact: Any
    near_wall: Any
    wall_memory: Any
    near_tool: Any
    first_tool_contact: Any
    tool: Any
    parts: Any
    tool_contact_count: Any
    tool_parts: Any
    tool_memory: Any
    reaction: Any
    ring: Any = None
    rim: Any = None
    node_force: Any = None


@ti.func
def increase(records: Ref, i, k: ti.template(), by):
    """Add to an entry of record `i`, of which the caller is the only writer.

    `+=` would be atomic, which is slow, where taichi cannot see that.
    """
    records[i][k] = records[i][k] + by


@ti.func
def increase_entry(row: Ref, k: ti.template(), by):
    """Add to an entry of a row, of which the caller is the only writer."""
    row[k] = row[k] + by


@ti.func
def limited(value, limit):
    """The value, cut at plus and minus the limit."""
    # Not `min` and `max`, which take three instructions each to heed what is not a number.
    below = ti.select(value < limit, value, limit)
    return ti.select(below > -limit, below, -limit)


@ti.func
def contact(overlap, approach, sliding, rolling, damping, reach, friction, shear, roll, constants: Ref):
    """Force law of one contact.

    `approach`, `sliding` and `rolling` are the relative velocities along the normal (towards each other
    positive), along the tangent and in rotation; `damping` is the dashpot's constant / root of the stiffness
    (`contact_law.contact_damping`), `reach` the reduced radius; `shear` and `roll` are the spring force and
    the rolling moment of the step before. Returns normal force, tangential force, rolling moment, and the
    spring force to remember (the moment is remembered as it is).
    """
    dt = constants[TIME_STEP]
    normal = ti.max(0.0, constants[KN] * overlap + constants[ROOT_KN] * damping * approach)
    # Only a spring within the Coulomb limit is remembered: sliding does not wind it up.
    limit = friction * normal
    spring = shear - constants[KT] * sliding * dt
    tangential = limited(spring - constants[ROOT_KT] * damping * sliding, limit)
    stiffness = constants[ROLLING_STIFFNESS] * reach * reach
    moment = limited(roll - stiffness * rolling * dt, constants[ROLLING_FRICTION] * reach * normal)
    return normal, tangential, moment, limited(spring, limit)


@ti.func
def pair_forces(p, soil: Ref):
    """Force between the grains of pair `p`, kept for each of them; its memory is forgotten when they part."""
    constants, motion, pairs, pair_body = ti.static(soil.constants, soil.motion, soil.pairs, soil.pair_body)
    i, j = pairs[p][FIRST], pairs[p][SECOND]
    dx, dz = motion[j][X] - motion[i][X], motion[j][Z] - motion[i][Z]
    ri, rj = pair_body[p][FIRST_RADIUS], pair_body[p][SECOND_RADIUS]
    square = dx * dx + dz * dz
    if square < (ri + rj) * (ri + rj):
        distance = ti.sqrt(square)
        inverse = 1.0 / distance
        nx, nz = dx * inverse, dz * inverse
        overlap = ri + rj - distance
        arm_i, arm_j = ri - 0.5 * overlap, rj - 0.5 * overlap
        vx, vz = motion[i][VX] - motion[j][VX], motion[i][VZ] - motion[j][VZ]
        wi, wj = motion[i][SPIN], motion[j][SPIN]
        normal, shear, moment, spring = contact(
            overlap,
            vx * nx + vz * nz,
            vz * nx - vx * nz + wi * arm_i + wj * arm_j,
            wi - wj,
            pair_body[p][DAMPING],
            pair_body[p][REACH],
            constants[FRICTION],
            soil.pair_memory[p][SHEAR],
            soil.pair_memory[p][ROLL],
            constants,
        )
        if ti.static(soil.features & COHESIVE):
            normal -= constants[COHESION]
        fx, fz = -normal * nx - shear * nz, -normal * nz + shear * nx
        keep_pair(p, fx, fz, shear * arm_i + moment, shear * arm_j - moment, spring, moment, soil)
        soil.touched[p] = 1
    elif soil.touched[p] != 0:
        keep_pair(p, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, soil)
        soil.touched[p] = 0


@ti.func
def keep_pair(p, fx, fz, moment_i, moment_j, spring, rolling, soil: Ref):
    """Keep the force on the first grain of pair `p`, the moments on both, and what it remembers."""
    load, memory = ti.static(soil.contact_load, soil.pair_memory)
    one, other = soil.pairs[p][FIRST_END], soil.pairs[p][SECOND_END]
    load[one][LOAD_X], load[one][LOAD_Z], load[one][LOAD_MOMENT] = fx, fz, moment_i
    load[other][LOAD_X], load[other][LOAD_Z], load[other][LOAD_MOMENT] = -fx, -fz, moment_j
    memory[p][SHEAR], memory[p][ROLL] = spring, rolling


@ti.func
def boundary_force(i, overlap, nx, nz, surface_x, surface_z, spin, friction, shear, roll, soil: Ref):
    """Force (fx, fz) and moment on grain `i` from a boundary it touches, rolling moment, spring to remember.

    (nx, nz) points from the grain into the boundary, whose surface moves at (surface_x, surface_z) where they
    touch, and turns at `spin`.
    """
    motion, body = ti.static(soil.motion, soil.body)
    arm = body[i][RADIUS] - 0.5 * overlap
    vx, vz = motion[i][VX] - surface_x, motion[i][VZ] - surface_z
    normal, tangential, moment, spring = contact(
        overlap,
        vx * nx + vz * nz,
        vz * nx - vx * nz + motion[i][SPIN] * arm,
        motion[i][SPIN] - spin,
        body[i][WALL_DAMPING],
        body[i][RADIUS],
        friction,
        shear,
        roll,
        soil.constants,
    )
    fx, fz = -normal * nx - tangential * nz, -normal * nz + tangential * nx
    return fx, fz, tangential * arm + moment, moment, spring


@ti.func
def wall_forces(i, soil: Ref):
    """Force and moment of floor, left and right wall on grain `i`."""
    memory = ti.static(soil.wall_memory)
    total = ti.Vector([0.0, 0.0, 0.0])
    r, x, z = soil.body[i][RADIUS], soil.motion[i][X], soil.motion[i][Z]
    overlaps = ti.Vector([r - z, r - x, x + r - soil.constants[WIDTH]])
    for wall in ti.static(range(WALL_COUNT)):
        spring, moment = 0.0, 0.0
        if overlaps[wall] > 0.0:
            fx, fz, turning, moment, spring = boundary_force(
                i,
                overlaps[wall],
                ti.static((0.0, -1.0, 1.0)[wall]),
                ti.static((-1.0, 0.0, 0.0)[wall]),
                0.0,
                0.0,
                0.0,
                soil.constants[WALL_FRICTION],
                memory[i][2 * wall + SHEAR],
                memory[i][2 * wall + ROLL],
                soil,
            )
            total += ti.Vector([fx, fz, turning])
        memory[i][2 * wall + SHEAR] = spring
        memory[i][2 * wall + ROLL] = moment
    return total


@ti.func
def nearest_on_part(part, x, z, soil: Ref):
    """Nearest point of a part's line to (x, z), in the world, and whether another part owns it."""
    tool, parts = ti.static(soil.tool, soil.parts)
    cosine, sine = tool[TOOL_COS], tool[TOOL_SIN]
    # the grain in the tool's frame
    dx, dz = x - tool[TOOL_X], z - tool[TOOL_Z]
    px, pz = cosine * dx + sine * dz, -sine * dx + cosine * dz
    ax, az = parts[part][PART_AX], parts[part][PART_AZ]
    ex, ez = parts[part][PART_BX] - ax, parts[part][PART_BZ] - az
    length = ex * ex + ez * ez
    along = 0.0
    if length > 0.0:
        along = ti.max(0.0, ti.min(1.0, ((px - ax) * ex + (pz - az) * ez) / length))
    qx, qz = ax + along * ex, az + along * ez
    foreign = along == 0.0 and parts[part][PART_CONTINUES] != 0.0
    return tool[TOOL_X] + cosine * qx - sine * qz, tool[TOOL_Z] + sine * qx + cosine * qz, foreign


@ti.func
def tool_force(i, c, soil: Ref):
    """Force and moment on grain `i` of its tool contact `c`; what the tool feels goes to `reaction`."""
    constants, motion, body, tool = ti.static(soil.constants, soil.motion, soil.body, soil.tool)
    parts, tool_parts, memory = ti.static(soil.parts, soil.tool_parts, soil.tool_memory)
    reaction = ti.static(soil.reaction)
    part = tool_parts[c]
    x, z = motion[i][X], motion[i][Z]
    qx, qz, foreign = nearest_on_part(part, x, z, soil)
    dx, dz = qx - x, qz - z
    square, reach = dx * dx + dz * dz, body[i][RADIUS] + parts[part][PART_RADIUS]
    fx, fz, turning, moment, spring, about_axle = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if square < reach * reach and square > 0.0 and not foreign:
        distance = ti.sqrt(square)
        nx, nz, overlap = dx / distance, dz / distance, reach - distance
        arm = body[i][RADIUS] - 0.5 * overlap
        # where they touch, seen from the tool's reference point
        lx, lz = x + arm * nx - tool[TOOL_X], z + arm * nz - tool[TOOL_Z]
        fx, fz, turning, moment, spring = boundary_force(
            i,
            overlap,
            nx,
            nz,
            tool[TOOL_VX] - tool[TOOL_SPIN] * lz,
            tool[TOOL_VZ] + tool[TOOL_SPIN] * lx,
            tool[TOOL_SPIN],
            constants[TOOL_FRICTION],
            memory[c][SHEAR],
            memory[c][ROLL],
            soil,
        )
        about_axle = lz * fx - lx * fz - moment
    memory[c][SHEAR], memory[c][ROLL] = spring, moment
    reaction[c][0], reaction[c][1], reaction[c][2] = -fx, -fz, about_axle
    return ti.Vector([fx, fz, turning])


@ti.func
def move_grain(i, soil: Ref):
    """Gather the forces on grain `i` in the order of its contacts, then one step of its motion."""
    load = grain_load(i, soil)
    near = soil.near_tool[i]
    if near >= 0:
        for c in range(soil.first_tool_contact[near], soil.first_tool_contact[near + 1]):
            load += tool_force(i, c, soil)
    step_grain(i, load, soil)


@ti.func
def grain_load(i, soil: Ref):
    """Force and moment on grain `i` of walls, then of other grains in the order of its contacts."""
    load = ti.Vector([0.0, 0.0, 0.0])
    if soil.near_wall[i] != 0:
        load = wall_forces(i, soil)
    for c in range(soil.first_contact[i], soil.first_contact[i + 1]):
        for k in ti.static(range(3)):
            load[k] += soil.contact_load[c][k]
    return load


@ti.func
def step_grain(i, load, soil: Ref):
    """One step of a grain's motion under a force and a moment."""
    constants, motion, body = ti.static(soil.constants, soil.motion, soil.body)
    dt, mass, drag = constants[TIME_STEP], body[i][MASS], constants[DRAG]
    vx, vz, spin = motion[i][VX], motion[i][VZ], motion[i][SPIN]
    vx += dt * (load[0] / mass + constants[GRAVITY_X] - drag * vx)
    vz += dt * (load[1] / mass + constants[GRAVITY_Z] - drag * vz)
    spin += dt * (load[2] / body[i][INERTIA] - drag * spin)
    x, z, angle = motion[i][X] + dt * vx, motion[i][Z] + dt * vz, motion[i][ANGLE] + dt * spin
    motion[i][X], motion[i][Z], motion[i][ANGLE] = x, z, angle
    motion[i][VX], motion[i][VZ], motion[i][SPIN] = vx, vz, spin


@ti.func
def move_tool(soil: Ref):
    """Sum what the grains do to the implement, in a fixed order; then one step of its motion.

    It travels and turns as it is told, and rises and sinks as it is told, or under its load.
    """
    tool, reaction = ti.static(soil.tool, soil.reaction)
    dt = soil.constants[TIME_STEP]
    fx, fz, moment = 0.0, 0.0, 0.0
    for c in range(soil.tool_contact_count):
        fx += reaction[c][0]
        fz += reaction[c][1]
        moment += reaction[c][2]
    increase_entry(tool, TOOL_PX, dt * fx)
    increase_entry(tool, TOOL_PZ, dt * fz)
    increase_entry(tool, TOOL_PM, dt * moment)
    if tool[TOOL_HEAVES] != 0.0:
        increase_entry(tool, TOOL_VZ, dt * (fz - tool[TOOL_LOAD]) / tool[TOOL_MASS])
    increase_entry(tool, TOOL_X, dt * tool[TOOL_VX])
    increase_entry(tool, TOOL_Z, dt * tool[TOOL_VZ])
    increase_entry(tool, TOOL_ANGLE, dt * tool[TOOL_SPIN])
    tool[TOOL_COS], tool[TOOL_SIN] = ti.cos(tool[TOOL_ANGLE]), ti.sin(tool[TOOL_ANGLE])


@ti.kernel
def advance(
    unrolled: ti.template(),
    features: ti.template(),
    grain_count: ti.i32,
    pair_count: ti.i32,
    workers: ti.i32,
    steps: ti.i32,
    grain_bounds: Index,
    pair_bounds: Index,
    pair_order: Index,
    board: Index,
    constants: Row,
    motion: rows(6),
    body: rows(4),
    pairs: rows(4, ti.i32),
    pair_body: rows(4),
    pair_memory: rows(2),
    touched: Index,
    contact_load: rows(3),
    first_contact: Index,
    near_wall: Index,
    wall_memory: rows(2 * WALL_COUNT),
    near_tool: Index,
    first_tool_contact: Index,
    tool: Row,
    parts: rows(6),
    tool_contact_count: ti.i32,
    tool_parts: Index,
    tool_memory: rows(2),
    reaction: rows(3),
):
    """The steps of one launch."""
    team = ti.static(
        Team(unrolled, grain_count, pair_count, workers, steps, grain_bounds, pair_bounds, pair_order, board)
    )
    soil = ti.static(
        Soil(
            features,
            constants,
            motion,
            body,
            pairs,
            pair_body,
            pair_memory,
            touched,
            contact_load,
            first_contact,
            near_wall,
            wall_memory,
            near_tool,
            first_tool_contact,
            tool,
            parts,
            tool_contact_count,
            tool_parts,
            tool_memory,
            reaction,
        )
    )
    take_steps(team, pair_forces, move_grain, move_tool, soil)


@ti.kernel
def greatest_shift_and_speed(grain_count: ti.i32, motion: rows(6), listed: rows(2)) -> Two:
    """Greatest squared distance (m2) of a grain from where it was when its neighbours were listed, and speed.

    A grain that is no longer a number counts as infinitely far.
    """
    shift, speed = 0.0, 0.0
    for i in range(grain_count):
        dx, dz = motion[i][X] - listed[i][X], motion[i][Z] - listed[i][Z]
        square = dx * dx + dz * dz
        if not square < FAR:
            square = FAR
        ti.atomic_max(shift, square)
        ti.atomic_max(speed, motion[i][VX] * motion[i][VX] + motion[i][VZ] * motion[i][VZ])
    return ti.Vector([shift, speed])
