"""The kernels of spheres in a slab: as `synth.dem.kernels`, in three dimensions.

The same two passes and the same order of sums. The implement is the discs' one, extruded along y: what is
nearest to a grain is found in the (x, z) plane, and it moves in that plane alone. Six contacts with a grain
are possible beside those with others: floor, end walls, the glass at y = 0, the slab's other face, implement.
Forces in N, for the slab as a whole. Import only after `synth.devices.start_taichi`.
"""

import taichi as ti

from synth.dem.kernels import (
    COHESION,
    COHESIVE,
    CONSTANT_COUNT,
    DAMPING,
    DRAG,
    FAR,
    FIRST,
    FIRST_END,
    FIRST_RADIUS,
    FRICTION,
    GRAVITY_X,
    GRAVITY_Z,
    INERTIA,
    KN,
    KT,
    MASS,
    PART_RADIUS,
    RADIUS,
    REACH,
    ROLLING_FRICTION,
    SECOND,
    SECOND_END,
    SECOND_RADIUS,
    TIME_STEP,
    TOOL_FRICTION,
    TOOL_SPIN,
    TOOL_VX,
    TOOL_VZ,
    TOOL_X,
    TOOL_Z,
    WALL_DAMPING,
    WALL_FRICTION,
    WIDTH,
    Index,
    Row,
    Soil,
    Two,
    increase,
    move_tool,
    nearest_on_part,
    rows,
)
from synth.dem.step_kernels import Ref, Team, take_steps

# components of `motion`
X, Y, Z, VX, VY, VZ, ANGLE, WX, WY, WZ = range(10)
# where the vectors of `contact_load` begin: force and moment on the grain whose contact it is
FORCE, MOMENT = 0, 3
LOAD = 6
# where the vectors of `pair_memory`, `tool_memory` and `wall_memory` begin; a grain has five rows of the last
SHEAR, ROLL = 0, 3
MEMORY = 6
WALL_COUNT = 5
# entries of `constants` beyond those of discs; with Hertz, KN and KT are the moduli E* and G*
WALL_KN, WALL_KT, GLASS_FRICTION, BACK_FRICTION, THICKNESS = range(CONSTANT_COUNT, CONSTANT_COUNT + 5)
SPHERE_CONSTANT_COUNT = CONSTANT_COUNT + 5
# what a kernel is compiled for, beside COHESIVE
HERTZIAN = 2

STEPS_UNROLLED = 1
"""In one launch of ordinary loops: several would be long to compile."""

Three = ti.types.vector(3, ti.f64)


@ti.func
def three(rows: Ref, i, start: ti.template()):
    """Three numbers of record `i`, from `start` on."""
    return ti.Vector([rows[i][start], rows[i][start + 1], rows[i][start + 2]])


@ti.func
def keep(rows: Ref, i, start: ti.template(), value):
    """Write three numbers into record `i`."""
    for k in ti.static(range(3)):
        rows[i][start + k] = value[k]


@ti.func
def shortened(value, limit):
    """The vector, no longer than the limit."""
    length = value.norm()
    factor = 1.0
    if length > limit:
        factor = limit / length
    return factor * value


@ti.func
def turned_into(value, normal):
    """The vector laid into the plane across `normal`, as long as it was: memory turns with its contact."""
    flat = value - value.dot(normal) * normal
    length, before = flat.norm(), value.norm()
    factor = 0.0
    if length > 1e-12 * before:
        factor = before / length
    return factor * flat


@ti.func
def contact(
    overlap,
    normal,
    velocity,
    spin,
    damping,
    reach,
    kn,
    kt,
    friction,
    rolling_friction,
    shear,
    roll,
    soil: Ref,
):
    """Force law of one contact; `normal` points from the grain to what it touches.

    `velocity` and `spin` are the grain's against the other, where they touch; `shear` and `roll` the force
    and the moment that are remembered. Returns the normal force, the tangential force and the rolling moment
    on the grain, and the tangential force to remember.
    """
    dt = soil.constants[TIME_STEP]
    stiffness, tangent = kn, kt
    spring_force = kn * overlap
    if ti.static(soil.features & HERTZIAN):
        patch = ti.sqrt(reach * overlap)
        stiffness, tangent = 2.0 * kn * patch, 8.0 * kt * patch
        spring_force = 2.0 / 3.0 * stiffness * overlap
    approach = velocity.dot(normal)
    sliding = velocity - approach * normal
    pressing = ti.max(0.0, spring_force + damping * ti.sqrt(stiffness) * approach)
    limit = friction * pressing
    spring = turned_into(shear, normal) - tangent * dt * sliding
    tangential = shortened(spring - damping * ti.sqrt(tangent) * sliding, limit)
    rolling = spin - spin.dot(normal) * normal
    lever = rolling_friction * reach
    turning = turned_into(roll, normal) - 2.25 * stiffness * lever * lever * dt * rolling
    return pressing, tangential, shortened(turning, lever * pressing), shortened(spring, limit)


@ti.func
def pair_forces(p, soil: Ref):
    """Force between the grains of pair `p`, kept for each of them; its memory is forgotten when they part."""
    constants, motion, pairs, pair_body = ti.static(soil.constants, soil.motion, soil.pairs, soil.pair_body)
    i, j = pairs[p][FIRST], pairs[p][SECOND]
    branch = three(motion, j, X) - three(motion, i, X)
    ri, rj = pair_body[p][FIRST_RADIUS], pair_body[p][SECOND_RADIUS]
    square = branch.norm_sqr()
    if square < (ri + rj) * (ri + rj):
        distance = ti.sqrt(square)
        normal = branch / distance
        overlap = ri + rj - distance
        arm_i, arm_j = ri - 0.5 * overlap, rj - 0.5 * overlap
        wi, wj = three(motion, i, WX), three(motion, j, WX)
        velocity = three(motion, i, VX) - three(motion, j, VX) + (arm_i * wi + arm_j * wj).cross(normal)
        pressing, tangential, turning, spring = contact(
            overlap,
            normal,
            velocity,
            wi - wj,
            pair_body[p][DAMPING],
            pair_body[p][REACH],
            constants[KN],
            constants[KT],
            constants[FRICTION],
            constants[ROLLING_FRICTION],
            three(soil.pair_memory, p, SHEAR),
            three(soil.pair_memory, p, ROLL),
            soil,
        )
        if ti.static(soil.features & COHESIVE):
            pressing -= constants[COHESION] * pair_body[p][REACH]
        twist = normal.cross(tangential)
        force = tangential - pressing * normal
        keep_pair(p, force, arm_i * twist + turning, arm_j * twist - turning, spring, turning, soil)
        soil.touched[p] = 1
    elif soil.touched[p] != 0:
        nothing = ti.Vector([0.0, 0.0, 0.0])
        keep_pair(p, nothing, nothing, nothing, nothing, nothing, soil)
        soil.touched[p] = 0


@ti.func
def keep_pair(p, force, moment_i, moment_j, spring, rolling, soil: Ref):
    """Keep the force on the first grain of pair `p`, the moments on both, and what it remembers."""
    one, other = soil.pairs[p][FIRST_END], soil.pairs[p][SECOND_END]
    keep(soil.contact_load, one, FORCE, force)
    keep(soil.contact_load, one, MOMENT, moment_i)
    keep(soil.contact_load, other, FORCE, -force)
    keep(soil.contact_load, other, MOMENT, moment_j)
    keep(soil.pair_memory, p, SHEAR, spring)
    keep(soil.pair_memory, p, ROLL, rolling)


@ti.func
def boundary_force(i, overlap, normal, surface, spin, friction, rolling_friction, memory: Ref, m, soil: Ref):
    """Force, moment and rolling moment on grain `i` from a boundary it touches; its memory is record `m`.

    `normal` points from the grain into the boundary, whose surface moves at `surface` and turns at `spin`.
    """
    constants, motion, body = ti.static(soil.constants, soil.motion, soil.body)
    arm, w = body[i][RADIUS] - 0.5 * overlap, three(motion, i, WX)
    pressing, tangential, turning, spring = contact(
        overlap,
        normal,
        three(motion, i, VX) + arm * w.cross(normal) - surface,
        w - spin,
        body[i][WALL_DAMPING],
        body[i][RADIUS],
        constants[WALL_KN],
        constants[WALL_KT],
        friction,
        rolling_friction,
        three(memory, m, SHEAR),
        three(memory, m, ROLL),
        soil,
    )
    keep(memory, m, SHEAR, spring)
    keep(memory, m, ROLL, turning)
    return tangential - pressing * normal, arm * normal.cross(tangential) + turning, turning


@ti.func
def wall_at(wall, r, x, y, z, constants: Ref):
    """Overlap with a wall, normal into it, friction there: floor, left, right, glass, opposite face."""
    overlap, normal, friction = r - z, ti.Vector([0.0, 0.0, -1.0]), constants[WALL_FRICTION]
    if wall == 1:
        overlap, normal = r - x, ti.Vector([-1.0, 0.0, 0.0])
    elif wall == 2:
        overlap, normal = x + r - constants[WIDTH], ti.Vector([1.0, 0.0, 0.0])
    elif wall == 3:
        overlap, normal, friction = r - y, ti.Vector([0.0, -1.0, 0.0]), constants[GLASS_FRICTION]
    elif wall == 4:
        overlap, friction = y + r - constants[THICKNESS], constants[BACK_FRICTION]
        normal = ti.Vector([0.0, 1.0, 0.0])
    return overlap, normal, friction


@ti.func
def wall_forces(i, soil: Ref):
    """Force and moment of all walls on grain `i`.

    Nothing holds a grain from rolling on glass more strongly than friction holds it there.
    """
    constants, motion, body = ti.static(soil.constants, soil.motion, soil.body)
    force, moment, nothing = (
        ti.Vector([0.0, 0.0, 0.0]),
        ti.Vector([0.0, 0.0, 0.0]),
        ti.Vector([0.0, 0.0, 0.0]),
    )
    for wall in range(WALL_COUNT):
        m = WALL_COUNT * i + wall
        overlap, normal, friction = wall_at(
            wall, body[i][RADIUS], motion[i][X], motion[i][Y], motion[i][Z], constants
        )
        if overlap > 0.0:
            rolling_friction = constants[ROLLING_FRICTION]
            if wall >= 3:
                rolling_friction = ti.min(rolling_friction, friction)
            pushed, turned, _rolling = boundary_force(
                i,
                overlap,
                normal,
                nothing,
                nothing,
                friction,
                rolling_friction,
                soil.wall_memory,
                m,
                soil,
            )
            force += pushed
            moment += turned
        else:
            keep(soil.wall_memory, m, SHEAR, nothing)
            keep(soil.wall_memory, m, ROLL, nothing)
    return force, moment


@ti.func
def tool_force(i, c, soil: Ref):
    """Force and moment on grain `i` of its tool contact `c`; what the tool feels goes to `reaction`.

    Counter-clockwise in the (x, z) plane, which is how the tool counts, is about -y.
    """
    constants, motion, body, tool = ti.static(soil.constants, soil.motion, soil.body, soil.tool)
    parts, memory, reaction = ti.static(soil.parts, soil.tool_memory, soil.reaction)
    part = soil.tool_parts[c]
    x, z = motion[i][X], motion[i][Z]
    qx, qz, foreign = nearest_on_part(part, x, z, soil)
    dx, dz = qx - x, qz - z
    square, reach = dx * dx + dz * dz, body[i][RADIUS] + parts[part][PART_RADIUS]
    nothing = ti.Vector([0.0, 0.0, 0.0])
    force, moment, about_axle = nothing, nothing, 0.0
    if square < reach * reach and square > 0.0 and not foreign:
        distance = ti.sqrt(square)
        normal, overlap = ti.Vector([dx / distance, 0.0, dz / distance]), reach - distance
        arm = body[i][RADIUS] - 0.5 * overlap
        # where they touch, seen from the tool's reference point
        lx, lz = x + arm * normal[0] - tool[TOOL_X], z + arm * normal[2] - tool[TOOL_Z]
        spin = tool[TOOL_SPIN]
        pushed, turned, rolling = boundary_force(
            i,
            overlap,
            normal,
            ti.Vector([tool[TOOL_VX] - spin * lz, 0.0, tool[TOOL_VZ] + spin * lx]),
            ti.Vector([0.0, -spin, 0.0]),
            constants[TOOL_FRICTION],
            constants[ROLLING_FRICTION],
            memory,
            c,
            soil,
        )
        force, moment = pushed, turned
        about_axle = lz * force[0] - lx * force[2] + rolling[1]
    else:
        keep(memory, c, SHEAR, nothing)
        keep(memory, c, ROLL, nothing)
    reaction[c][0], reaction[c][1], reaction[c][2] = -force[0], -force[2], about_axle
    return force, moment


@ti.func
def move_grain(i, soil: Ref):
    """Gather the forces on grain `i` in the order of its contacts, then one step of its motion."""
    constants, motion, body = ti.static(soil.constants, soil.motion, soil.body)
    force, moment = ti.Vector([0.0, 0.0, 0.0]), ti.Vector([0.0, 0.0, 0.0])
    if soil.near_wall[i] != 0:
        force, moment = wall_forces(i, soil)
    for c in range(soil.first_contact[i], soil.first_contact[i + 1]):
        force += three(soil.contact_load, c, FORCE)
        moment += three(soil.contact_load, c, MOMENT)
    near = soil.near_tool[i]
    if near >= 0:
        for c in range(soil.first_tool_contact[near], soil.first_tool_contact[near + 1]):
            pushed, turned = tool_force(i, c, soil)
            force += pushed
            moment += turned
    dt, drag = constants[TIME_STEP], constants[DRAG]
    gravity = ti.Vector([constants[GRAVITY_X], 0.0, constants[GRAVITY_Z]])
    velocity, spin = three(motion, i, VX), three(motion, i, WX)
    velocity += dt * (force / body[i][MASS] + gravity - drag * velocity)
    spin += dt * (moment / body[i][INERTIA] - drag * spin)
    keep(motion, i, VX, velocity)
    keep(motion, i, WX, spin)
    keep(motion, i, X, three(motion, i, X) + dt * velocity)
    increase(motion, i, ANGLE, -dt * spin[1])


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
    motion: rows(10),
    body: rows(4),
    pairs: rows(4, ti.i32),
    pair_body: rows(4),
    pair_memory: rows(MEMORY),
    touched: Index,
    contact_load: rows(LOAD),
    first_contact: Index,
    near_wall: Index,
    wall_memory: rows(MEMORY),
    near_tool: Index,
    first_tool_contact: Index,
    tool: Row,
    parts: rows(6),
    tool_contact_count: ti.i32,
    tool_parts: Index,
    tool_memory: rows(MEMORY),
    reaction: rows(3),
):
    """The steps of one launch, as of discs."""
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
def greatest_shift_and_speed(grain_count: ti.i32, motion: rows(10), listed: rows(3)) -> Two:
    """Greatest squared distance (m2) of a grain from where it was when its neighbours were listed, and speed.

    A grain that is no longer a number counts as infinitely far.
    """
    shift, speed = 0.0, 0.0
    for i in range(grain_count):
        square = (three(motion, i, X) - three(listed, i, 0)).norm_sqr()
        if not square < FAR:
            square = FAR
        ti.atomic_max(shift, square)
        ti.atomic_max(speed, three(motion, i, VX).norm_sqr())
    return ti.Vector([shift, speed])
