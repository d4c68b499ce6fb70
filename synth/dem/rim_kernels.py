"""The kernels for a wheel with an elastic rim: contacts with moving bars, and the rim's own motion.

As in `synth.dem.kernels`, every number has one writer, and sums have a fixed order. A contact's force on a
bar is shared by its two nodes so that force, moment and power are kept: by the lever rule, and as a couple
what does not act on the line between them. Import only after `synth.devices.start_taichi`.
"""

import taichi as ti

from synth.dem.kernels import (
    PART_RADIUS,
    RADIUS,
    ROLL,
    SHEAR,
    TIME_STEP,
    TOOL_ANGLE,
    TOOL_COS,
    TOOL_FRICTION,
    TOOL_HEAVES,
    TOOL_LOAD,
    TOOL_MASS,
    TOOL_PM,
    TOOL_PX,
    TOOL_PZ,
    TOOL_SIN,
    TOOL_SPIN,
    TOOL_VX,
    TOOL_VZ,
    TOOL_X,
    TOOL_Z,
    WALL_COUNT,
    Index,
    Row,
    Soil,
    X,
    Z,
    boundary_force,
    grain_load,
    increase,
    increase_entry,
    pair_forces,
    rows,
    step_grain,
)
from synth.dem.step_kernels import Ref, Team, take_steps

# components of `rim`: a node in the world, what acts on it, and where it is unloaded in the hub's frame
NODE_X, NODE_Z, NODE_VX, NODE_VZ, NODE_FX, NODE_FZ, REST_X, REST_Z = range(8)
NODE_SIZE = 8
# entries of `ring`: its constants, and the impulse it gave the hub since the start
NODE_MASS, RADIAL, TANGENTIAL, DAMPING, HOOP, BENDING, BAR_LENGTH, HINGE_ANGLE, HUB_PX, HUB_PZ, HUB_PM = (
    range(11)
)
RING_SIZE = 11
# components of `node_force`: what a contact does to the first and the second node of its bar
FIRST_FX, FIRST_FZ, SECOND_FX, SECOND_FZ = range(4)


@ti.func
def _owns(rim: Ref, a, b, x, z):
    """Whether a point is between the bisectors at both ends of the bar from node `a` to node `b`.

    So one bar alone is touched, also where the rim is hollow, and it changes where both are equally near.
    """
    count = rim.shape[0]
    before, after = (a + count - 1) % count, (b + 1) % count
    along_x, along_z = _direction(rim, a, b)
    last_x, last_z = _direction(rim, before, a)
    next_x, next_z = _direction(rim, b, after)
    into = (x - rim[a][NODE_X]) * (along_x + last_x) + (z - rim[a][NODE_Z]) * (along_z + last_z)
    beyond = (x - rim[b][NODE_X]) * (along_x + next_x) + (z - rim[b][NODE_Z]) * (along_z + next_z)
    return into >= 0.0 and beyond < 0.0


@ti.func
def _direction(rim: Ref, a, b):
    """Unit vector from one node to another."""
    x, z = rim[b][NODE_X] - rim[a][NODE_X], rim[b][NODE_Z] - rim[a][NODE_Z]
    length = ti.sqrt(x * x + z * z)
    return x / length, z / length


@ti.func
def bar_force(i, c, soil: Ref):
    """Force and moment on grain `i` of its contact `c` with a bar of the rim; what the bar feels is kept."""
    constants, motion, body, tool = ti.static(soil.constants, soil.motion, soil.body, soil.tool)
    parts, memory, reaction = ti.static(soil.parts, soil.tool_memory, soil.reaction)
    rim, node_force = ti.static(soil.rim, soil.node_force)
    a = soil.tool_parts[c]
    b = (a + 1) % rim.shape[0]
    x, z = motion[i][X], motion[i][Z]
    ax, az = rim[a][NODE_X], rim[a][NODE_Z]
    ex, ez = rim[b][NODE_X] - ax, rim[b][NODE_Z] - az
    square_length = ex * ex + ez * ez
    share = ti.max(0.0, ti.min(1.0, ((x - ax) * ex + (z - az) * ez) / square_length))
    qx, qz = ax + share * ex, az + share * ez
    dx, dz = qx - x, qz - z
    square, reach = dx * dx + dz * dz, body[i][RADIUS] + parts[a][PART_RADIUS]
    fx, fz, turning, moment, spring, about_axle, couple = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if square < reach * reach and square > 0.0 and _owns(rim, a, b, x, z):
        distance = ti.sqrt(square)
        nx, nz, overlap = dx / distance, dz / distance, reach - distance
        arm = body[i][RADIUS] - 0.5 * overlap
        # where they touch, seen from the nearest point of the bar's line
        lx, lz = x + arm * nx - qx, z + arm * nz - qz
        vx, vz = rim[b][NODE_VX] - rim[a][NODE_VX], rim[b][NODE_VZ] - rim[a][NODE_VZ]
        spin = (ex * vz - ez * vx) / square_length
        fx, fz, turning, moment, spring = boundary_force(
            i,
            overlap,
            nx,
            nz,
            rim[a][NODE_VX] + share * vx - spin * lz,
            rim[a][NODE_VZ] + share * vz + spin * lx,
            spin,
            constants[TOOL_FRICTION],
            memory[c][SHEAR],
            memory[c][ROLL],
            soil,
        )
        couple = (lz * fx - lx * fz - moment) / square_length
        hx, hz = qx + lx - tool[TOOL_X], qz + lz - tool[TOOL_Z]
        about_axle = hz * fx - hx * fz - moment
    memory[c][SHEAR], memory[c][ROLL] = spring, moment
    reaction[c][0], reaction[c][1], reaction[c][2] = -fx, -fz, about_axle
    node_force[c][FIRST_FX] = -(1.0 - share) * fx + couple * ez
    node_force[c][FIRST_FZ] = -(1.0 - share) * fz - couple * ex
    node_force[c][SECOND_FX] = -share * fx - couple * ez
    node_force[c][SECOND_FZ] = -share * fz + couple * ex
    return ti.Vector([fx, fz, turning])


@ti.func
def _load_by_grains(soil: Ref):
    """What the grains do to every node, instead of what was there; and to the wheel in all."""
    tool, rim, reaction, node_force = ti.static(soil.tool, soil.rim, soil.reaction, soil.node_force)
    count, dt = rim.shape[0], soil.constants[TIME_STEP]
    for k in range(count):
        rim[k][NODE_FX], rim[k][NODE_FZ] = 0.0, 0.0
    fx, fz, moment = 0.0, 0.0, 0.0
    for c in range(soil.tool_contact_count):
        a = soil.tool_parts[c]
        b = (a + 1) % count
        increase(rim, a, NODE_FX, node_force[c][FIRST_FX])
        increase(rim, a, NODE_FZ, node_force[c][FIRST_FZ])
        increase(rim, b, NODE_FX, node_force[c][SECOND_FX])
        increase(rim, b, NODE_FZ, node_force[c][SECOND_FZ])
        fx += reaction[c][0]
        fz += reaction[c][1]
        moment += reaction[c][2]
    increase_entry(tool, TOOL_PX, dt * fx)
    increase_entry(tool, TOOL_PZ, dt * fz)
    increase_entry(tool, TOOL_PM, dt * moment)


@ti.func
def _load_by_hub(tool: Ref, ring: Ref, rim: Ref):
    """Add the springs and dashpots between nodes and hub; returns force and moment on the hub."""
    cosine, sine = tool[TOOL_COS], tool[TOOL_SIN]
    hub = ti.Vector([0.0, 0.0, 0.0])
    for k in range(rim.shape[0]):
        rx = cosine * rim[k][REST_X] - sine * rim[k][REST_Z]
        rz = sine * rim[k][REST_X] + cosine * rim[k][REST_Z]
        inverse = 1.0 / ti.sqrt(rx * rx + rz * rz)
        ox, oz = rx * inverse, rz * inverse
        px, pz = rim[k][NODE_X] - tool[TOOL_X], rim[k][NODE_Z] - tool[TOOL_Z]
        radial = ring[RADIAL] * ((px - rx) * ox + (pz - rz) * oz)
        along = ring[TANGENTIAL] * ((pz - rz) * ox - (px - rx) * oz)
        # velocity as seen from the turning hub
        vx = rim[k][NODE_VX] - tool[TOOL_VX] + tool[TOOL_SPIN] * pz
        vz = rim[k][NODE_VZ] - tool[TOOL_VZ] - tool[TOOL_SPIN] * px
        fx = -radial * ox + along * oz - ring[DAMPING] * vx
        fz = -radial * oz - along * ox - ring[DAMPING] * vz
        increase(rim, k, NODE_FX, fx)
        increase(rim, k, NODE_FZ, fz)
        hub -= ti.Vector([fx, fz, px * fz - pz * fx])
    return hub


@ti.func
def _load_by_neighbours(ring: Ref, rim: Ref):
    """Add the bars between neighbours and the hinges between bars."""
    count = rim.shape[0]
    for k in range(count):
        last, following = (k + count - 1) % count, (k + 1) % count
        bx, bz = rim[k][NODE_X] - rim[last][NODE_X], rim[k][NODE_Z] - rim[last][NODE_Z]
        ex, ez = rim[following][NODE_X] - rim[k][NODE_X], rim[following][NODE_Z] - rim[k][NODE_Z]
        square_before, square = bx * bx + bz * bz, ex * ex + ez * ez
        length = ti.sqrt(square)
        tension = ring[HOOP] * (length - ring[BAR_LENGTH]) / length
        turn = ti.atan2(bx * ez - bz * ex, bx * ex + bz * ez)
        moment = ring[BENDING] * (turn - ring[HINGE_ANGLE])
        # a moment on a bar is a couple at its ends
        before_x, before_z = -moment * bz / square_before, moment * bx / square_before
        after_x, after_z = -moment * ez / square, moment * ex / square
        increase(rim, last, NODE_FX, -before_x)
        increase(rim, last, NODE_FZ, -before_z)
        increase(rim, k, NODE_FX, before_x + after_x + tension * ex)
        increase(rim, k, NODE_FZ, before_z + after_z + tension * ez)
        increase(rim, following, NODE_FX, -(after_x + tension * ex))
        increase(rim, following, NODE_FZ, -(after_z + tension * ez))


@ti.func
def move_wheel(soil: Ref):
    """One step of rim and hub, which travels and turns as told, and rises and sinks by rim and load."""
    tool, ring, rim = ti.static(soil.tool, soil.ring, soil.rim)
    dt = soil.constants[TIME_STEP]
    _load_by_grains(soil)
    hub = _load_by_hub(tool, ring, rim)
    _load_by_neighbours(ring, rim)
    for k in range(rim.shape[0]):
        increase(rim, k, NODE_VX, dt * rim[k][NODE_FX] / ring[NODE_MASS])
        increase(rim, k, NODE_VZ, dt * rim[k][NODE_FZ] / ring[NODE_MASS])
        increase(rim, k, NODE_X, dt * rim[k][NODE_VX])
        increase(rim, k, NODE_Z, dt * rim[k][NODE_VZ])
    increase_entry(ring, HUB_PX, dt * hub[0])
    increase_entry(ring, HUB_PZ, dt * hub[1])
    increase_entry(ring, HUB_PM, dt * hub[2])
    if tool[TOOL_HEAVES] != 0.0:
        increase_entry(tool, TOOL_VZ, dt * (hub[1] - tool[TOOL_LOAD]) / tool[TOOL_MASS])
    increase_entry(tool, TOOL_X, dt * tool[TOOL_VX])
    increase_entry(tool, TOOL_Z, dt * tool[TOOL_VZ])
    increase_entry(tool, TOOL_ANGLE, dt * tool[TOOL_SPIN])
    tool[TOOL_COS], tool[TOOL_SIN] = ti.cos(tool[TOOL_ANGLE]), ti.sin(tool[TOOL_ANGLE])


@ti.func
def move_grain(i, soil: Ref):
    """As `synth.dem.kernels.move_grain`, among the bars of a rim."""
    load = grain_load(i, soil)
    near = soil.near_tool[i]
    if near >= 0:
        for c in range(soil.first_tool_contact[near], soil.first_tool_contact[near + 1]):
            load += bar_force(i, c, soil)
    step_grain(i, load, soil)


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
    ring: Row,
    rim: rows(NODE_SIZE),
    node_force: rows(4),
):
    """As `synth.dem.kernels.advance`; the rim takes its step where the implement does."""
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
            ring,
            rim,
            node_force,
        )
    )
    take_steps(team, pair_forces, move_grain, move_wheel, soil)
