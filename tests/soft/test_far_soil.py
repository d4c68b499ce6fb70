"""The camera's motion where no soil in view rests, but all moves the less the further off it is."""

import numpy as np
import pytest

from soft import to_inertial

SHAPE = (150, 300)
SOIL = np.ones(SHAPE, bool)
CAMERA = (-7.2, 0.4)


def falling_off(*, decay, core=40.0, top=4.0):
    """Away from the surface's middle; within the core, which moves as one, no faster than at its rim."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(np.float64)
    away = np.stack([x - 140, y - 10], axis=2)
    distance = np.linalg.norm(away, axis=2)[:, :, None]
    return top * away / np.maximum(distance, 1e-9) * (core / np.maximum(distance, core)) ** decay


def with_errors(flow, seed=0, deviation=0.02):
    rng = np.random.default_rng(seed)
    return flow + np.array(CAMERA) + rng.normal(0, deviation, flow.shape)


@pytest.mark.parametrize("decay", [1.0, 1.75, 2.0])
def test_soil_that_rests_nowhere_tells_the_camera(decay):
    flow = with_errors(falling_off(decay=decay))
    motion = to_inertial(flow, SOIL, vertical=True, camera="far")
    assert np.abs(np.median(flow[:, :, 1]) - CAMERA[1]) > 0.2, "soil that rests is the majority"
    # Exact for one decay; for the others, better by half than what soil moves by where it is stillest.
    stillest = np.quantile(np.linalg.norm(falling_off(decay=decay), axis=2), 0.05)
    allowed = 0.02 if decay == 1.75 else stillest / 2
    assert motion.camera_u == pytest.approx(CAMERA[0], abs=allowed)
    assert motion.camera_v == pytest.approx(CAMERA[1], abs=allowed)
    assert motion.camera_u_low < CAMERA[0] < motion.camera_u_high
    assert motion.camera_v_low < CAMERA[1] < motion.camera_v_high


def test_interval_grows_with_what_soil_disagrees_about():
    calm, wild = (
        to_inertial(with_errors(falling_off(decay=1.0, top=top)), SOIL, camera="far") for top in (0.0, 4.0)
    )
    assert calm.camera_u_high - calm.camera_u_low < 0.3 * (wild.camera_u_high - wild.camera_u_low)
    assert calm.camera_u == pytest.approx(CAMERA[0], abs=0.01)


def test_nodes_of_a_grid():
    flow = with_errors(falling_off(decay=1.75))
    nodes = np.full_like(flow, np.nan)
    nodes[4::8, 4::8] = flow[4::8, 4::8]
    assert to_inertial(nodes, SOIL, camera="far").camera_u == pytest.approx(CAMERA[0], abs=0.05)


def test_unmeasured_soil_and_what_is_no_soil_do_not_count():
    flow = with_errors(falling_off(decay=1.75))
    flow[:, 200:] += 30.0
    soil = SOIL.copy()
    soil[:, 200:250] = False
    flow[:, 250:] = np.nan
    assert to_inertial(flow, soil, camera="far").camera_u == pytest.approx(CAMERA[0], abs=0.03)


def test_too_little_soil_has_no_interval_and_none_no_motion():
    flow = with_errors(falling_off(decay=1.75))
    sliver = np.zeros(SHAPE, bool)
    sliver[100:110, 100:110] = True
    motion = to_inertial(flow, sliver, camera="far")
    assert np.isfinite(motion.camera_u)
    assert np.isnan([motion.camera_u_low, motion.camera_u_high]).all()
    thread = np.zeros(SHAPE, bool)
    thread[100, 100] = True
    assert to_inertial(flow, thread, camera="far").camera_u == pytest.approx(flow[100, 100, 0], abs=1e-4)
    assert np.isnan(to_inertial(flow, ~SOIL, camera="far").camera_u)
