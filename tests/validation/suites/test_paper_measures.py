"""A measurement that is the truth itself gives the numbers that the truth was made with."""

from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr

import soft
from validation.suites.paper import averaging, bucket, rotation, shown, sift, speed, thrust

HEIGHT, WIDTH, PAIRS = 160, 240, 4
CAMERA = -5.0
"""px: soil at rest goes to the left."""
BLOCK = (slice(30, 100), slice(60, 180))
MOTION = (-4.0, 1.0)
"""px of the block against resting soil."""


@dataclass
class Known:
    """Pictures whose soil rests but for a block, as the measures see footage."""

    pair_count: int = PAIRS
    metres_per_pixel: float = 2e-4
    frame_rate: float = 8.0

    def truth(self, pair):
        return self.truths.isel(pair=pair)

    def picture(self, frame):
        generator = np.random.default_rng(0)
        texture = np.kron(generator.uniform(0, 255, (80, 200)), np.ones((2, 2)))
        start = 100 - round(CAMERA) * frame
        return texture[:, start : start + WIDTH].astype(np.uint8)

    @property
    def truths(self):
        shape = (PAIRS, HEIGHT, WIDTH)
        u, v = np.full(shape, CAMERA, np.float32), np.zeros(shape, np.float32)
        u[:, *BLOCK] += MOTION[0]
        v[:, *BLOCK] += MOTION[1]
        yes = np.ones(shape, bool)
        fields = {"u": u, "v": v, "valid": yes, "soil": yes, "mixed": ~yes}
        fields["distance_to_implement"] = np.full(shape, 99.0, np.float32)
        variables = {name: (("pair", "y", "x"), values) for name, values in fields.items()}
        camera = {"camera_u": np.full(PAIRS, CAMERA), "camera_v": np.zeros(PAIRS)}
        return xr.Dataset(variables | {name: ("pair", values) for name, values in camera.items()})


@pytest.fixture(scope="module")
def footage():
    return Known()


@pytest.fixture(scope="module")
def flow(footage):
    """The truth as a SoilFlow."""
    true = footage.truths
    moving = np.zeros((PAIRS, HEIGHT, WIDTH), bool)
    moving[:, *BLOCK] = True
    found = true[["u", "v", "valid", "soil", "camera_u", "camera_v"]].assign(
        inertial_u=true["u"] - CAMERA, inertial_v=true["v"], moving=(("pair", "y", "x"), moving)
    )
    frames = np.arange(PAIRS)
    return found.assign_coords(
        first_frame=("pair", frames), second_frame=("pair", frames + 1), time=("pair", frames / 8)
    ).assign_attrs(metres_per_pixel=2e-4, frame_rate=8.0, method="truth")


def test_thrust(footage, flow):
    told = thrust.measure(footage, flow)
    along = MOTION[0] ** 2 / (MOTION[0] ** 2 + MOTION[1] ** 2)
    for way in ("measured", "mode", "true"):
        assert told[f"thrust_{way}_along"].values == pytest.approx(along, abs=0.01)
        assert told[f"thrust_{way}_across"].values == pytest.approx(1 - along, abs=0.01)
        assert told[f"thrust_{way}_resultant"].values == pytest.approx(1, abs=0.01)
        assert told[f"thrust_{way}_depth"].values == pytest.approx(0.2 * 100, abs=0.5)
        assert told[f"thrust_{way}_directions"].values.sum(axis=1) == pytest.approx(1)


def test_bucket_and_speed(footage, flow):
    assert (bucket.measure(footage, flow)["bucket_measured_forward"] == 0).all()  # the block goes left
    told = speed.measure(footage, flow)
    assert told["speed_measured"].values == pytest.approx(CAMERA)
    assert told["speed_by_soil"].values == pytest.approx(CAMERA)
    assert told.attrs["speed_scale"] * -CAMERA == pytest.approx(0.8)  # cm/s


def test_averaging(footage, flow):
    told = averaging.measure(footage, flow)
    assert told["averaging_true_error"].values == pytest.approx(0, abs=1e-5)
    assert told["averaging_true_count"].values.tolist() == [1, 2, 4]
    top = float(np.hypot(*MOTION))
    for name in ("speed", "true_speed"):
        assert float(told[f"averaging_{name}"]) == pytest.approx(top, abs=0.01)
    assert told["averaging_found"].values.tolist() == [1.0] * PAIRS


def test_rotation_is_regressed_on_motion(footage, flow):
    off = flow.copy()
    motion = np.hypot(flow["u"], flow["v"])
    off["u"] = flow["u"] + 0.02 * motion
    told = rotation.measure(footage, off)
    assert told["rotation_slope"].values == pytest.approx(0.02, abs=1e-3)
    assert told["rotation_determination"].values == pytest.approx(1, abs=1e-3)
    assert told["rotation_counts"].sum() == PAIRS * HEIGHT * WIDTH


def test_sift_is_held_against_flow_and_truth(footage, flow):
    told = sift.measure(footage, flow)
    assert set(told["sift_pair"].values) == set(range(PAIRS))
    inside = told["sift_where"].values > 0
    # The pictures show no block: SIFT says that all rests, flow and truth agree with each other.
    wrong = np.hypot(*(told["sift_flow"] - told["sift_motion"]).values.T) > 0.56
    assert inside.any() and wrong[inside].mean() > 0.8 and wrong[~inside].mean() < 0.1
    assert told["sift_flow"].values == pytest.approx(told["sift_true"].values, abs=1e-5)


def test_shown_pair_comes_back_as_it_was(footage, flow):
    kept = shown.measure(footage, flow).assign_attrs(shown.measure(footage, flow).attrs | {"method": "truth"})
    again = shown.flow_of(kept)
    pair = PAIRS // 2
    assert int(again["first_frame"][0]) == pair and again.attrs["frame_rate"] == 8.0
    for name in ("inertial_u", "inertial_v", "moving"):
        assert np.allclose(again[name].values[0], flow[name].values[pair], atol=1e-3)
    view = shown.view_of(kept)
    assert np.nanmax(view.measured["truth"].error) < 1e-3
    assert soft.speed_figure(again, shown.picture_of(kept)).axes
