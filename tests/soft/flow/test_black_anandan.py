"""`black-anandan` on pictures whose motion is known by formula, and its parts against their definitions."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from soft.devices import start_taichi
from soft.flow import FlowError, estimate_flow, read_flo
from soft.flow.black_anandan.energy import Energy
from soft.flow.black_anandan.pyramid import carried, levels
from soft.flow.black_anandan.settings import PRESETS, Stage
from soft.flow.black_anandan.system import System

METHOD = "black-anandan"
SHAPE = (72, 96)
INNER = np.s_[10:-10, 10:-10]


def errors(field, truth):
    return np.hypot(*np.moveaxis(field.displacement - truth, 2, 0))


@pytest.mark.parametrize("preset", sorted(PRESETS))
@pytest.mark.parametrize(
    ("shift", "matrix"),
    [
        ((2.3, -1.4), ((1, 0), (0, 1))),
        ((0.6, 1.2), ((0.9996, -0.0294), (0.0294, 0.9996))),
        ((0.0, 0.5), ((1.0, 0.03), (0.0, 1.0))),
    ],
    ids=["translation", "rotation", "shear"],
)
def test_known_motion(moved, preset, shift, matrix):
    first, second, truth = moved(shift=shift, matrix=matrix, shape=SHAPE)
    field = estimate_flow(first, second, method=METHOD, preset=preset, warp_count=3)
    error = errors(field, truth)[INNER]
    assert field.valid[INNER].all()
    assert np.median(error) < 0.05 and np.quantile(error, 0.95) < 0.12


@pytest.mark.parametrize(("name", "limit"), [("RubberWhale", 0.085), ("Grove2", 0.16)])
def test_middlebury(real_data, name, limit):
    folder = real_data / "middlebury" / name
    first, second = (cv2.imread(str(folder / f"frame{k}.png"), 0) for k in (10, 11))
    field = estimate_flow(first, second, method=METHOD, forward_backward=False)  # of every pixel
    error = errors(field, read_flo(folder / "flow10.flo"))
    assert field.valid.mean() > 0.95 and np.nanmean(error) < limit


def test_thirty_px_a_frame(moved):
    first, second, truth = moved(shift=(30.0, 4.0), shape=(100, 160))
    field = estimate_flow(first, second, method=METHOD, warp_count=3)
    inner = np.s_[10:-10, 10:-40]
    assert field.valid[inner].mean() > 0.97 and np.nanquantile(errors(field, truth)[inner], 0.95) < 0.1


def energy_of(equation, flow, stage):
    """The energy by its definition, in double precision; no mask."""
    a, b, c, usable = np.moveaxis(equation.astype(float), 2, 0)

    def penalty(z, sigma):
        quadratic = z**2 / (2 * sigma**2)
        return stage.convex * quadratic + (1 - stage.convex) * np.log1p(quadratic)

    data = usable * penalty(a * flow[..., 0] + b * flow[..., 1] + c, stage.data_width)
    steps = sum(penalty(np.diff(flow, axis=k), stage.step_width).sum() for k in (0, 1))
    return data.sum() + stage.smoothness * steps


@pytest.fixture
def energy_at(moved):
    """A level's energy, made linear around rest, and a random motion."""
    start_taichi()

    def make(convex):
        first, second, _ = moved(shift=(0.4, -0.3), shape=(24, 30))
        stage = Stage(convex, 2.0, 1, 0.1, 6.3, 0.1)
        mask = np.ones(first.shape, bool)
        level = next(levels(first, second, first, mask, spacing=2.0, most=1, margin=1, blur=0.7))
        energy = Energy(level, stage)
        energy.linearize(np.zeros((*first.shape, 2), np.float32))
        random = np.random.default_rng(0)
        return energy, stage, random.normal(0, 0.2, (*first.shape, 2)).astype(np.float32)

    return make


@pytest.mark.parametrize("convex", [1.0, 0.5, 0.0])
def test_slopes_of_the_penalties_are_those_of_the_energy(energy_at, convex):
    energy, stage, flow = energy_at(convex)
    energy.weigh(flow)
    for row, column, k in [(0, 0, 0), (5, 7, 1), (23, 29, 0), (12, 0, 1), (11, 16, 0)]:
        two = [flow.astype(float), flow.astype(float)]
        two[0][row, column, k] -= 1e-5
        two[1][row, column, k] += 1e-5
        slope = np.subtract(*(energy_of(energy.equation, f, stage) for f in two)) / 2e-5
        assert energy.system.right[row + 1, column + 1, k] == pytest.approx(slope, rel=1e-3, abs=1e-3)


@pytest.mark.parametrize("convex", [1.0, 0.5, 0.0])
def test_the_energy_goes_down_to_where_it_is_stationary(energy_at, convex):
    energy, stage, flow = energy_at(convex)
    energy.weigh(flow)
    before, steep = energy_of(energy.equation, flow, stage), np.linalg.norm(energy.system.right)
    for _ in range(60):
        flow = energy.lowered(flow, 1e-3)
        now = energy_of(energy.equation, flow, stage)
        assert now <= before * (1 + 1e-5)
        before = now
    energy.weigh(flow)
    assert np.linalg.norm(energy.system.right) < 1e-3 * steep


def test_equations_are_solved_to_the_tolerance_asked_for():
    start_taichi()
    random, shape = np.random.default_rng(0), (37, 53)
    system, inner = System(shape), np.s_[1:-2, 1:-2]
    slopes = random.normal(0, 1, (*shape, 2))
    system.tensor[inner] = np.stack([slopes[..., 0] ** 2, slopes.prod(-1), slopes[..., 1] ** 2], -1)
    system.links[inner] = 5 / (1 + random.exponential(3, (*shape, 4)) ** 2)
    system.links[1:-2, -3, :2] = system.links[-3, 1:-2, 2:] = 0
    system.links[10, 1:-2, 2:] = 0  # cut
    system.right[inner] = asked = random.normal(0, 1, (*shape, 2))
    system.prepare()
    solution = system.solve(1e-4).astype(float)
    left = asked - left_hand_side(system.tensor[inner], system.links[inner], solution)
    assert np.linalg.norm(left) < 2e-4 * np.linalg.norm(asked)


def left_hand_side(tensor, links, x):
    result = np.stack([tensor[..., 0] * x[..., 0] + tensor[..., 1] * x[..., 1],
                       tensor[..., 1] * x[..., 0] + tensor[..., 2] * x[..., 1]], -1)  # fmt: skip
    across = links[:, :-1, :2] * np.diff(x, axis=1)
    down = links[:-1, :, 2:] * np.diff(x, axis=0)
    result[:, :-1] -= across
    result[:, 1:] += across
    result[:-1] -= down
    result[1:] += down
    return result


def test_stages_go_from_quadratic_to_narrower_lorentzians():
    stages = PRESETS["soft-2014"].stages
    assert [stage.convex for stage in stages] == [1, 0, 0]
    assert [(stage.level_count, stage.spacing) for stage in stages] == [(4, 2.0), (2, 1.25), (2, 1.25)]
    for preset in PRESETS.values():
        wide, narrow = preset.stages[1:]
        assert narrow.data_width < wide.data_width and narrow.step_width < wide.step_width


def test_robust_stages_ignore_what_does_not_fit(moved):
    """A patch that changes otherwise pulls the quadratic stage, and the Lorentzian ones less."""
    first, second, truth = moved(shift=(0.8, 0.3), shape=SHAPE)
    second[33:38, 44:50] = 255 - second[33:38, 44:50]
    ring = np.zeros(SHAPE, bool)
    ring[25:45, 35:60] = True
    ring[32:39, 43:51] = False
    off = {}
    robust = PRESETS["soft-2014"]
    for name, settings in {"quadratic": replace(robust, stages=robust.stages[:1]), "all": robust}.items():
        with pytest.MonkeyPatch.context() as patch:
            patch.setitem(PRESETS, "soft-2014", settings)
            field = estimate_flow(first, second, method=METHOD, preset="soft-2014", forward_backward=False)
            off[name] = errors(field, truth)[ring].mean()
    assert off["all"] < 0.5 * off["quadratic"]


def broken_pair(moved, jump):
    """The upper half moves by + jump / 2, the lower one by - jump / 2, along x."""
    first, upper, _ = moved(shift=(jump / 2, 0.0), shape=SHAPE)
    second = moved(shift=(-jump / 2, 0.0), shape=SHAPE)[1]
    half = SHAPE[0] // 2
    second[:half] = upper[:half]
    mask = np.zeros(SHAPE, bool)
    mask[:half] = True
    return first, second, mask


@pytest.mark.parametrize("preset", sorted(PRESETS))
def test_motion_does_not_leak_through_the_edge_of_a_mask(moved, preset):
    first, second, mask = broken_pair(moved, 4.0)
    field = estimate_flow(first, second, method=METHOD, preset=preset, mask=mask, warp_count=3)
    assert np.array_equal(field.valid[2:, 10:-10], mask[2:, 10:-10])
    rim = np.s_[SHAPE[0] // 2 - 6 : SHAPE[0] // 2, 10:-10]
    assert np.quantile(errors(field, np.array([2.0, 0.0]))[rim], 0.95) < 0.05


def test_the_first_picture_outside_of_the_mask_is_never_used(moved):
    first, second, mask = broken_pair(moved, 1.0)
    other = np.where(mask, first, np.random.default_rng(0).uniform(0, 255, SHAPE)).astype(np.float32)
    # Texture is looked for in the whole picture; none is missing here.
    one, two = (estimate_flow(f, second, method=METHOD, mask=mask, warp_count=1) for f in (first, other))
    assert np.array_equal(one.displacement, two.displacement, equal_nan=True)


def test_motion_is_carried_to_another_size_by_both_ratios():
    flow = np.full((20, 40, 2), (3.0, 2.0), np.float32)
    mask = np.ones((20, 40), bool)
    mask[:, 20:] = False
    flow[~mask] = 99
    np.testing.assert_allclose(carried(flow, mask, (10, 50)), np.broadcast_to((3.75, 1.0), (10, 50, 2)))


def test_uncertainty_grows_with_noise_and_where_texture_is_weak(moved):
    first, second, _ = moved(shift=(0.7, 0.2), shape=SHAPE)
    first[:, 48:] = 128 + (first[:, 48:] - 128) / 8
    second[:, 48:] = 128 + (second[:, 48:] - 128) / 8
    random, sigma = np.random.default_rng(0), {}
    for noise in (0.5, 3.0):
        noisy = [np.clip(p + random.normal(0, noise, SHAPE), 0, 255) for p in (first, second)]
        sigma[noise] = estimate_flow(*noisy, method=METHOD, preset="soft-2014").uncertainty
    strong, weak = np.s_[10:-10, 10:40], np.s_[10:-10, 58:-10]
    assert np.median(sigma[3.0][strong]) > 2 * np.median(sigma[0.5][strong])
    assert np.median(sigma[3.0][weak]) > 1.1 * np.median(sigma[3.0][strong])


@pytest.mark.parametrize("preset", sorted(PRESETS))
def test_nothing_to_measure(moved, preset):
    flat = np.full((40, 50), 99, np.uint8)
    assert not estimate_flow(flat, flat, method=METHOD, preset=preset).valid.any()
    first, second, _ = moved(shape=(40, 50))
    assert not estimate_flow(first, second, method=METHOD, mask=np.zeros((40, 50), bool)).valid.any()


def test_small_pictures(moved):
    first, second, truth = moved(shift=(0.4, 0.2), shape=(16, 40))
    field = estimate_flow(first, second, method=METHOD)
    assert np.nanmedian(errors(field, truth)) < 0.15
    with pytest.raises(FlowError, match="needs at least 16 px"):
        estimate_flow(first[:, :1], second[:, :1], method=METHOD)


@pytest.mark.parametrize(
    ("option", "says"),
    [
        ({"preset": "slow"}, "preset: 'slow': allowed are accurate, soft-2014"),
        ({"warp_count": 0}, "warp_count: 0: must be a whole number from 1 to 1000"),
        ({"sweeps": 3}, "unknown option sweeps: allowed are preset, warp_count"),
        ({"device": "tpu"}, "runs on cpu, cuda"),
    ],
)
def test_bad_options_are_named(option, says):
    picture = np.zeros(SHAPE, np.uint8)
    with pytest.raises(FlowError, match=says):
        estimate_flow(picture, picture, method=METHOD, **option)


_DIGEST = """
import hashlib, sys
import cv2, numpy as np
from soft.flow import estimate_flow
random = np.random.default_rng(0)
first = cv2.GaussianBlur(random.uniform(0, 255, (150, 180)).astype(np.float32), (0, 0), 1.0)
second = np.roll(first, (1, 2), (0, 1))
second[75:] = np.roll(first, (0, -1), (0, 1))[75:]
field = estimate_flow(first, second, method="black-anandan", warp_count=2, threads=int(sys.argv[1]))
print(hashlib.sha256(field.displacement.tobytes() + field.uncertainty.tobytes()).hexdigest())
"""


def test_same_bytes_on_one_and_two_threads(printed_on):
    assert len(printed_on(_DIGEST, (1, 2))) == 1
