"""The kernels: forces of contacts, then motion of grains, then motion of the implement.

Every number has one writer: a pair's force is computed once and stored, then each grain gathers its own in a
fixed order, so results are the same bytes on any number of threads. Two dimensions, plane strain; all per
metre of width; rotations counter-clockwise positive in the (x, z) plane. Import only after
`synth.devices.start_taichi`.
"""

import taichi as ti

# rows of `motion`
X, Z, VX, VZ, ANGLE, SPIN = range(6)
# rows of `body`
RADIUS, MASS, INERTIA = range(3)
# columns of `pair_load`: force on the first grain, moments on both
PAIR_FX, PAIR_FZ, PAIR_M1, PAIR_M2 = range(4)
# columns of `pair_memory`, and rows per boundary of `boundary_memory`
SHEAR, ROLL = range(2)
FLOOR, LEFT, RIGHT, IMPLEMENT = range(4)
BOUNDARY_COUNT = 4
# entries of `constants`, which do not change during a run
KN, KT, DAMPING_N, DAMPING_T, FRICTION, WALL_FRICTION, TOOL_FRICTION, ROLLING_FRICTION, ROLLING_STIFFNESS = (
    range(9)
)
TIME_STEP, GRAVITY_X, GRAVITY_Z, WIDTH, DRAG = range(9, 14)
CONSTANT_COUNT = 14
# columns of `pair_body`: what a pair's two grains make together
ROOT_MASS, REACH = range(2)
# entries of `tool`: its pose and motion, what drives it, and the impulse the grains gave it since last asked
TOOL_X, TOOL_Z, TOOL_ANGLE, TOOL_VX, TOOL_VZ, TOOL_SPIN = range(6)
TOOL_RADIUS, TOOL_MASS, TOOL_LOAD, TOOL_PX, TOOL_PZ, TOOL_PM = range(6, 12)
TOOL_SIZE = 12

FAR = 1e30
"""Further squared, m2, than a grain can be."""
STEPS_PER_LAUNCH = 8
"""A launch costs as much as a tenth of a step of 10 000 grains: several steps share one."""

Ref = ti.template()  # an array handed on to a function
Pair = ti.types.vector(2, ti.f64)
Row = ti.types.ndarray(ti.f64, ndim=1)
Table = ti.types.ndarray(ti.f64, ndim=2)
Index = ti.types.ndarray(ti.i32, ndim=1)
IndexTable = ti.types.ndarray(ti.i32, ndim=2)


@ti.func
def limited(value, limit):
    """The value, cut at plus and minus the limit."""
    return ti.max(-limit, ti.min(limit, value))


@ti.func
def contact(overlap, approach, sliding, rolling, root_mass, reach, friction, shear, roll, constants: Ref):
    """Force law of one contact.

    `approach`, `sliding` and `rolling` are the relative velocities along the normal (towards each other
    positive), along the tangent and in rotation; `root_mass` is the root of the reduced mass, `reach` the
    reduced radius; `shear` and `roll` are the spring force and the rolling moment of the step before. Returns
    normal force, tangential force, rolling moment, and the spring force to remember (the moment is remembered
    as it is).
    """
    dt = constants[TIME_STEP]
    normal = ti.max(0.0, constants[KN] * overlap + constants[DAMPING_N] * root_mass * approach)
    # Only a spring within the Coulomb limit is remembered: sliding does not wind it up.
    limit = friction * normal
    spring = shear - constants[KT] * sliding * dt
    tangential = limited(spring - constants[DAMPING_T] * root_mass * sliding, limit)
    stiffness = constants[ROLLING_STIFFNESS] * reach * reach
    moment = limited(roll - stiffness * rolling * dt, constants[ROLLING_FRICTION] * reach * normal)
    return normal, tangential, moment, limited(spring, limit)


@ti.func
def pair_forces(
    p, constants: Ref, pairs: Ref, pair_body: Ref, motion: Ref, body: Ref, pair_memory: Ref, pair_load: Ref
):
    """Force between the grains of pair `p`, kept in `pair_load`; its memory is forgotten when they part."""
    i, j = pairs[0, p], pairs[1, p]
    dx, dz = motion[X, j] - motion[X, i], motion[Z, j] - motion[Z, i]
    ri, rj = body[RADIUS, i], body[RADIUS, j]
    square = dx * dx + dz * dz
    fx, fz, moment_i, moment_j, spring, moment = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if square < (ri + rj) * (ri + rj):
        distance = ti.sqrt(square)
        nx, nz = dx / distance, dz / distance
        overlap = ri + rj - distance
        arm_i, arm_j = ri - 0.5 * overlap, rj - 0.5 * overlap
        vx, vz = motion[VX, i] - motion[VX, j], motion[VZ, i] - motion[VZ, j]
        wi, wj = motion[SPIN, i], motion[SPIN, j]
        normal, shear, moment, spring = contact(
            overlap,
            vx * nx + vz * nz,
            vz * nx - vx * nz + wi * arm_i + wj * arm_j,
            wi - wj,
            pair_body[p, ROOT_MASS],
            pair_body[p, REACH],
            constants[FRICTION],
            pair_memory[p, SHEAR],
            pair_memory[p, ROLL],
            constants,
        )
        fx, fz = -normal * nx - shear * nz, -normal * nz + shear * nx
        moment_i, moment_j = shear * arm_i + moment, shear * arm_j - moment
    pair_load[p, PAIR_FX], pair_load[p, PAIR_FZ] = fx, fz
    pair_load[p, PAIR_M1], pair_load[p, PAIR_M2] = moment_i, moment_j
    pair_memory[p, SHEAR], pair_memory[p, ROLL] = spring, moment


@ti.func
def boundary_force(
    i,
    boundary,
    overlap,
    nx,
    nz,
    surface,
    spin,
    arm,
    friction,
    constants: Ref,
    motion: Ref,
    body: Ref,
    memory: Ref,
):
    """Force (fx, fz), moment on grain `i`, and moment on the boundary, from one that is in contact.

    (nx, nz) points from the grain into the boundary; `surface` is the boundary's velocity at its centre,
    `spin` its rotation and `arm` the contact's distance from that centre (a plane: no spin, no arm).
    """
    own_arm = body[RADIUS, i] - 0.5 * overlap
    vx, vz = motion[VX, i] - surface[0], motion[VZ, i] - surface[1]
    wi = motion[SPIN, i]
    normal, shear, moment, spring = contact(
        overlap,
        vx * nx + vz * nz,
        vz * nx - vx * nz + wi * own_arm + spin * arm,
        wi - spin,
        ti.sqrt(body[MASS, i]),
        body[RADIUS, i],
        friction,
        memory[2 * boundary + SHEAR, i],
        memory[2 * boundary + ROLL, i],
        constants,
    )
    memory[2 * boundary + SHEAR, i] = spring
    memory[2 * boundary + ROLL, i] = moment
    return ti.Vector(
        [-normal * nx - shear * nz, -normal * nz + shear * nx, shear * own_arm + moment, shear * arm - moment]
    )


@ti.func
def forget(i, boundary, memory: Ref):
    """A contact that has ended."""
    memory[2 * boundary + SHEAR, i] = 0.0
    memory[2 * boundary + ROLL, i] = 0.0


@ti.func
def wall_forces(i, constants: Ref, motion: Ref, body: Ref, memory: Ref):
    """Force and moment of floor and end walls on grain `i`."""
    total = ti.Vector([0.0, 0.0, 0.0, 0.0])
    still = ti.Vector([0.0, 0.0])
    r, x, z = body[RADIUS, i], motion[X, i], motion[Z, i]
    overlaps = ti.Vector([r - z, r - x, x + r - constants[WIDTH]])
    for wall in ti.static(range(3)):
        nx = ti.static((0.0, -1.0, 1.0)[wall])
        nz = ti.static((-1.0, 0.0, 0.0)[wall])
        if overlaps[wall] > 0.0:
            total += boundary_force(
                i,
                wall,
                overlaps[wall],
                nx,
                nz,
                still,
                0.0,
                0.0,
                constants[WALL_FRICTION],
                constants,
                motion,
                body,
                memory,
            )
        else:
            forget(i, wall, memory)
    return total


@ti.func
def tool_force(i, constants: Ref, tool: Ref, motion: Ref, body: Ref, memory: Ref):
    """Force and moment of the wheel on grain `i`, and the moment of the grain about the axle."""
    load = ti.Vector([0.0, 0.0, 0.0, 0.0])
    dx, dz = tool[TOOL_X] - motion[X, i], tool[TOOL_Z] - motion[Z, i]
    reach = body[RADIUS, i] + tool[TOOL_RADIUS]
    square = dx * dx + dz * dz
    if square < reach * reach:
        distance = ti.sqrt(square)
        overlap = reach - distance
        load = boundary_force(
            i,
            IMPLEMENT,
            overlap,
            dx / distance,
            dz / distance,
            ti.Vector([tool[TOOL_VX], tool[TOOL_VZ]]),
            tool[TOOL_SPIN],
            tool[TOOL_RADIUS] - 0.5 * overlap,
            constants[TOOL_FRICTION],
            constants,
            motion,
            body,
            memory,
        )
    else:
        forget(i, IMPLEMENT, memory)
    return load


@ti.func
def move_grain(
    i,
    constants: Ref,
    motion: Ref,
    body: Ref,
    tool: Ref,
    first_contact: Ref,
    contacts: Ref,
    pair_load: Ref,
    memory: Ref,
    near_wall: Ref,
    near_slot: Ref,
    reaction: Ref,
):
    """Gather the forces on grain `i` in the order of its contacts, then one step of its motion."""
    load = ti.Vector([0.0, 0.0, 0.0, 0.0])
    if near_wall[i] != 0:
        load = wall_forces(i, constants, motion, body, memory)
    for c in range(first_contact[i], first_contact[i + 1]):
        p = contacts[c] // 2
        if contacts[c] % 2 == 0:
            load[0] += pair_load[p, PAIR_FX]
            load[1] += pair_load[p, PAIR_FZ]
            load[2] += pair_load[p, PAIR_M1]
        else:
            load[0] -= pair_load[p, PAIR_FX]
            load[1] -= pair_load[p, PAIR_FZ]
            load[2] += pair_load[p, PAIR_M2]
    slot = near_slot[i]
    if slot >= 0:
        push = tool_force(i, constants, tool, motion, body, memory)
        load += push
        reaction[0, slot] = -push[0]
        reaction[1, slot] = -push[1]
        reaction[2, slot] = push[3]
    dt, mass, drag = constants[TIME_STEP], body[MASS, i], constants[DRAG]
    motion[VX, i] += dt * (load[0] / mass + constants[GRAVITY_X] - drag * motion[VX, i])
    motion[VZ, i] += dt * (load[1] / mass + constants[GRAVITY_Z] - drag * motion[VZ, i])
    motion[SPIN, i] += dt * (load[2] / body[INERTIA, i] - drag * motion[SPIN, i])
    motion[X, i] += dt * motion[VX, i]
    motion[Z, i] += dt * motion[VZ, i]
    motion[ANGLE, i] += dt * motion[SPIN, i]


@ti.func
def move_tool(dt, tool: Ref, reaction: Ref, near_count):
    """Sum what the grains do to the implement, in a fixed order; then one step of its motion.

    It travels and turns as it is told, and rises and sinks under its load.
    """
    fx, fz, moment = 0.0, 0.0, 0.0
    for k in range(near_count):
        fx += reaction[0, k]
        fz += reaction[1, k]
        moment += reaction[2, k]
    tool[TOOL_PX] += dt * fx
    tool[TOOL_PZ] += dt * fz
    tool[TOOL_PM] += dt * moment
    tool[TOOL_VZ] += dt * (fz - tool[TOOL_LOAD]) / tool[TOOL_MASS]
    tool[TOOL_X] += dt * tool[TOOL_VX]
    tool[TOOL_Z] += dt * tool[TOOL_VZ]
    tool[TOOL_ANGLE] += dt * tool[TOOL_SPIN]


@ti.kernel
def advance(
    steps: ti.template(),
    constants: Row,
    grain_count: ti.i32,
    pair_count: ti.i32,
    near_count: ti.i32,
    motion: Table,
    body: Table,
    pairs: IndexTable,
    pair_body: Table,
    pair_memory: Table,
    pair_load: Table,
    first_contact: Index,
    contacts: Index,
    boundary_memory: Table,
    near_wall: Index,
    near_slot: Index,
    reaction: Table,
    tool: Row,
):
    """So many steps in one launch, unrolled: each loop below is a parallel task of its own."""
    for _ in ti.static(range(steps)):
        for p in range(pair_count):
            pair_forces(p, constants, pairs, pair_body, motion, body, pair_memory, pair_load)
        for i in range(grain_count):
            move_grain(
                i,
                constants,
                motion,
                body,
                tool,
                first_contact,
                contacts,
                pair_load,
                boundary_memory,
                near_wall,
                near_slot,
                reaction,
            )
        ti.loop_config(serialize=True)
        for _only in range(1):
            move_tool(constants[TIME_STEP], tool, reaction, near_count)


@ti.kernel
def greatest_shift_and_speed(grain_count: ti.i32, motion: Table, listed: Table) -> Pair:
    """Greatest squared distance (m2) of a grain from where it was when its neighbours were listed, and speed.

    A grain that is no longer a number counts as infinitely far.
    """
    shift, speed = 0.0, 0.0
    for i in range(grain_count):
        dx, dz = motion[X, i] - listed[0, i], motion[Z, i] - listed[1, i]
        square = dx * dx + dz * dz
        if not square < FAR:
            square = FAR
        ti.atomic_max(shift, square)
        ti.atomic_max(speed, motion[VX, i] * motion[VX, i] + motion[VZ, i] * motion[VZ, i])
    return Pair(shift, speed)
