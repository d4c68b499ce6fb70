"""The kernels for several rigid wheels in one bin, each led along a path of its own.

As `synth.dem.kernels`, whose arrays these take: `tool` holds one record of `TOOL_SIZE` entries a wheel, and a
wheel is the part of its number, a disc about its axle. Import only after `synth.devices.start_taichi`.
"""

import taichi as ti

from synth.dem.kernels import (
    PART_RADIUS,
    RADIUS,
    ROLL,
    SHEAR,
    STEPS_UNROLLED,
    TIME_STEP,
    TOOL_ANGLE,
    TOOL_FRICTION,
    TOOL_PM,
    TOOL_PX,
    TOOL_PZ,
    TOOL_SIZE,
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
    greatest_shift_and_speed,
    pair_forces,
    rows,
    step_grain,
)
from synth.dem.step_kernels import Ref, Team, take_steps

__all__ = ["STEPS_UNROLLED", "advance", "greatest_shift_and_speed"]


@ti.func
def wheel_force(i, c, soil: Ref):
    """Force and moment on grain `i` of its contact `c` with a wheel; what that feels goes to `reaction`."""
    motion, body, tool, memory = ti.static(soil.motion, soil.body, soil.tool, soil.tool_memory)
    wheel = soil.tool_parts[c]
    first = wheel * TOOL_SIZE
    dx, dz = tool[first + TOOL_X] - motion[i][X], tool[first + TOOL_Z] - motion[i][Z]
    square, reach = dx * dx + dz * dz, body[i][RADIUS] + soil.parts[wheel][PART_RADIUS]
    fx, fz, turning, moment, spring, about_axle = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if square < reach * reach:
        distance = ti.sqrt(square)
        nx, nz, overlap = dx / distance, dz / distance, reach - distance
        arm = body[i][RADIUS] - 0.5 * overlap
        # where they touch, seen from the axle
        lx, lz = arm * nx - dx, arm * nz - dz
        spin = tool[first + TOOL_SPIN]
        fx, fz, turning, moment, spring = boundary_force(
            i,
            overlap,
            nx,
            nz,
            tool[first + TOOL_VX] - spin * lz,
            tool[first + TOOL_VZ] + spin * lx,
            spin,
            soil.constants[TOOL_FRICTION],
            memory[c][SHEAR],
            memory[c][ROLL],
            soil,
        )
        about_axle = lz * fx - lx * fz - moment
    memory[c][SHEAR], memory[c][ROLL] = spring, moment
    soil.reaction[c][0], soil.reaction[c][1], soil.reaction[c][2] = -fx, -fz, about_axle
    return ti.Vector([fx, fz, turning])


@ti.func
def move_grain(i, soil: Ref):
    """As `synth.dem.kernels.move_grain`, among wheels."""
    load = grain_load(i, soil)
    near = soil.near_tool[i]
    if near >= 0:
        for c in range(soil.first_tool_contact[near], soil.first_tool_contact[near + 1]):
            load += wheel_force(i, c, soil)
    step_grain(i, load, soil)


@ti.func
def move_wheels(soil: Ref):
    """Sum what the grains do to every wheel, in a fixed order; then one step of their motion, as told."""
    tool, reaction = ti.static(soil.tool, soil.reaction)
    dt = soil.constants[TIME_STEP]
    for c in range(soil.tool_contact_count):
        first = soil.tool_parts[c] * TOOL_SIZE
        tool[first + TOOL_PX] = tool[first + TOOL_PX] + dt * reaction[c][0]
        tool[first + TOOL_PZ] = tool[first + TOOL_PZ] + dt * reaction[c][1]
        tool[first + TOOL_PM] = tool[first + TOOL_PM] + dt * reaction[c][2]
    for wheel in range(soil.parts.shape[0]):
        first = wheel * TOOL_SIZE
        tool[first + TOOL_X] = tool[first + TOOL_X] + dt * tool[first + TOOL_VX]
        tool[first + TOOL_Z] = tool[first + TOOL_Z] + dt * tool[first + TOOL_VZ]
        tool[first + TOOL_ANGLE] = tool[first + TOOL_ANGLE] + dt * tool[first + TOOL_SPIN]


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
    """As `synth.dem.kernels.advance`."""
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
    take_steps(team, pair_forces, move_grain, move_wheels, soil)
