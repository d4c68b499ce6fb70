"""A grid tells of motion at its nodes; between them it is taken as linear, and nowhere else."""

import numpy as np
import pytest

from soft import average_flow, motion_between_nodes, shear_interface_of
from soft.between_nodes import between_nodes
from soft.pair_analysis import _moving

SHAPE = (200, 320)
Y, X = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
SOIL = Y >= 20
LINEAR = np.stack([0.02 * X - 0.01 * Y, 0.5 + 0.03 * Y], axis=-1)


def on_grid(field, *, step=16, off=0.25):
    """A field at every 16th px, measured a quarter of a px beside the pixel's centre."""
    nodes = np.full((*SHAPE, 2), np.nan)
    held = np.zeros(SHAPE, bool)
    held[step // 2 :: step, step // 2 :: step] = True
    nodes[held] = np.stack([X, Y], axis=-1)[held] + off
    return np.where(held[:, :, None], field, np.nan), nodes


def test_linear_motion_comes_out_exactly():
    shifted = LINEAR + 0.25 * np.array([0.02 - 0.01, 0.03])
    found = between_nodes(*on_grid(shifted), SOIL)
    assert found.spacing == pytest.approx(16)
    known = np.isfinite(found.displacement).all(axis=2)
    # From the first row of nodes in soil, 24.25, to the last one; columns likewise.
    assert np.argwhere(known)[[0, -1]].tolist() == [[25, 9], [184, 312]]
    assert known[25:185, 9:313].all() and not known[:, 313:].any()
    np.testing.assert_allclose(found.displacement[known], LINEAR[known], atol=1e-5)


def test_a_node_that_was_not_measured_leaves_a_hole():
    displacement, nodes = on_grid(LINEAR)
    displacement[104, 152] = np.nan
    known = np.isfinite(between_nodes(displacement, nodes, SOIL).displacement).all(axis=2)
    assert not known[104, 152] and not known[100:108, 150:154].any()
    assert known[104, 170] and known[86, 152]


@pytest.mark.parametrize("count", [0, 3, 9])
def test_too_few_nodes_or_all_on_a_line(count):
    displacement, nodes = on_grid(LINEAR)
    displacement[:104] = displacement[105:] = np.nan
    displacement[:, 16 * count :] = np.nan
    found = between_nodes(displacement, nodes, SOIL)
    assert found.spacing == 0 and np.isnan(found.displacement).all()


@pytest.fixture
def grid_flow(soil_flow):
    """Soil above row 100 goes to the right by 4 px, by 0.1 px less each row further down."""
    u = np.clip(4 - 0.1 * (Y - 80), 0, 4)
    displacement, nodes = on_grid(np.stack([u, 0 * u], axis=-1), off=0.0)
    moving = _moving(displacement, nodes, SOIL, seed=0).mask
    two = [np.stack([one, one]) for one in (displacement[..., 0], displacement[..., 1], moving)]
    valid = np.isfinite(two[0])
    flow = soil_flow(two[0], two[1], valid=valid, soil=np.stack([SOIL, SOIL]), moving=two[2])
    places = {
        f"node_{axis}": (("pair", "y", "x"), np.stack(2 * [nodes[..., k]])) for k, axis in enumerate("xy")
    }
    return flow.assign(places)


def test_a_grid_has_a_moving_region_and_its_boundary(grid_flow):
    motion = motion_between_nodes(grid_flow)
    assert motion.moving[30:95, 20:300].all() and not motion.moving[110:].any()
    line = shear_interface_of(grid_flow)
    points = np.concatenate(line.lines)
    # Half of the greatest speed is at row 100. Beyond the outermost nodes no line is drawn.
    assert np.abs(points[:, 1] - 100).max() < 1.5
    assert np.ptp(points[:, 0]) > 280


def test_means_are_between_nodes_too(grid_flow):
    mean = average_flow(grid_flow)
    assert mean.spacing == 16 and mean.moving_region().found
    assert mean.u[100, 150] == pytest.approx(2.0, abs=0.05)


def test_noise_at_nodes_is_no_moving_mass():
    noise = np.random.default_rng(5).normal(0, 1.5, (*SHAPE, 2))
    displacement, nodes = on_grid(noise, step=32)
    assert not _moving(displacement, nodes, SOIL, seed=0).found
