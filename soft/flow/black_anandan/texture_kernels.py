"""Kernels: smooth structure by total variation, after Chambolle (J. Math. Imaging Vision 20, 2004).

Every number has one writer, so results are the same bytes on any number of threads. Import only after
`soft.devices.start_taichi`.
"""

import taichi as ti

Picture = ti.types.ndarray(ti.f32, ndim=2)
Channels = ti.types.ndarray(ti.f32, ndim=3)


@ti.kernel
def primal(picture: Picture, dual: Channels, theta: ti.f32, structure: Picture):
    """Structure that belongs to the dual field: the picture and theta times the field's divergence."""
    for row, column in ti.ndrange(picture.shape[0], picture.shape[1]):
        divergence = dual[row, column, 0] + dual[row, column, 1]
        if column > 0:
            divergence -= dual[row, column - 1, 0]
        if row > 0:
            divergence -= dual[row - 1, column, 1]
        structure[row, column] = picture[row, column] + theta * divergence


@ti.kernel
def ascend(structure: Picture, step: ti.f32, dual: Channels):
    """Step of the dual field up the structure's slopes, and back to vectors of length one at most."""
    height, width = structure.shape[0], structure.shape[1]
    for row, column in ti.ndrange(height, width):
        here, right, down = structure[row, column], ti.f32(0.0), ti.f32(0.0)
        if column + 1 < width:
            right = dual[row, column, 0] + step * (structure[row, column + 1] - here)
        if row + 1 < height:
            down = dual[row, column, 1] + step * (structure[row + 1, column] - here)
        length = ti.max(1, ti.sqrt(right * right + down * down))
        dual[row, column, 0], dual[row, column, 1] = right / length, down / length
