import cv2
import numpy as np
import pytest

from soft import moving_mask, soil_mask
from soft.illumination import flatten_illumination
from soft.segmentation import coherence, largest_region, two_means

SHAPE = (300, 500)


def disc(centre, radius):
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return np.hypot(x - centre[0], y - centre[1]) < radius


def sand(level=180.0, contrast=25.0, seed=0):
    grain = cv2.GaussianBlur(np.random.default_rng(seed).normal(size=SHAPE), (0, 0), 1.2)
    return (level + contrast * grain / grain.std()).astype(np.float32)


def iou(a, b):
    return (a & b).sum() / (a | b).sum()


def test_two_means_finds_a_small_class():
    values = np.concatenate([np.full(50_000, 1.0), np.full(1_000, 9.0)])
    classes = two_means(values, seed=0)
    assert (classes.low, classes.high, classes.threshold) == pytest.approx((1.0, 9.0, 5.0))


def test_two_means_is_the_best_of_all_partings():
    """Tried by hand, on speeds that fall off gradually: what random starts come near to only."""
    values = np.random.default_rng(5).gamma(1.2, 1.0, 400)
    ordered = np.sort(values)
    cost = [part[:k].var() * k + part[k:].var() * (400 - k) for part in (ordered,) for k in range(1, 400)]
    k = 1 + int(np.argmin(cost))
    classes = two_means(values, seed=0)
    assert classes.low == pytest.approx(ordered[:k].mean()) and classes.high == pytest.approx(
        ordered[k:].mean()
    )
    assert ordered[k - 1] <= classes.threshold <= ordered[k]


def test_two_means_of_one_heap_are_not_apart():
    rng = np.random.default_rng(0)
    for heap in (rng.normal(size=30_000), rng.uniform(size=30_000), rng.rayleigh(size=30_000), np.ones(9)):
        assert two_means(heap, seed=0).separation < 2.0
    assert two_means(np.array([]), seed=0).separation == 0.0


@pytest.mark.parametrize("soil", ["bright", "dark"])
def test_implement_and_background_are_left_out(soil):
    truth = ~disc((250, 90), 80)
    truth[:60] = False
    picture = np.where(truth, sand(), 20.0)
    picture[40:45, 100:110] = 200.0  # a glint on the background
    picture = np.clip(picture, 0, 255).astype(np.float32)
    if soil == "dark":
        picture = 255 - picture
    region = soil_mask(picture, soil=soil)
    assert region.found
    assert iou(region.mask, truth) > 0.98
    assert not region.mask[42, 105]


def test_a_small_tool_under_light_that_falls_off():
    """As in the T-bar photographs: the light alone spans more grey levels than soil and tool do."""
    tool = disc((200, 130), 35)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    light = 1.0 - 0.55 * (((x - 250) / 250) ** 2 + ((y - 150) / 150) ** 2) / 2
    picture = np.clip(np.where(tool, 25.0, sand(215, 15)) * light, 0, 255).astype(np.float32)
    region = soil_mask(picture)
    assert "illumination" in region.remark
    assert iou(~region.mask, tool) > 0.9


def test_soil_alone_is_soil_and_says_so():
    region = soil_mask(np.clip(sand(), 0, 255))
    assert region.mask.all()
    assert not region.found
    assert "no two classes" in region.remark
    assert not soil_mask(np.full(SHAPE, 90.0, np.float32)).found


def test_asked_for_all_and_for_nonsense():
    assert soil_mask(sand(), soil="all").mask.all()
    with pytest.raises(ValueError, match="soil: 'red': allowed are bright, dark, all"):
        soil_mask(sand(), soil="red")


def test_same_seed_same_mask():
    picture = np.clip(np.where(disc((250, 90), 80), 20.0, sand()), 0, 255).astype(np.float32)
    assert np.array_equal(soil_mask(picture, seed=3).mask, soil_mask(picture, seed=3).mask)


def test_largest_region_fills_gaps_and_drops_threads_and_islands():
    raw = disc((150, 150), 100)
    whole = raw.copy()
    raw[148:150, :250] = False  # a crack
    raw[200:204, 150:154] = False  # a hole
    raw[100, 250:480] = True  # a thread
    raw[95:130, 450:480] = True  # an island at its end
    assert iou(largest_region(raw, size=5), whole) > 0.99
    hole = disc((150, 150), 30)
    assert not largest_region(whole & ~hole, size=5)[150, 150]
    assert not largest_region(np.zeros(SHAPE, bool), size=5).any()
    assert largest_region(np.ones(SHAPE, bool), size=5).all()


def test_flattening_leaves_the_outlier_dark():
    x = np.broadcast_to(np.arange(SHAPE[1]), SHAPE)
    light = (200 - 80 * ((x - 250) / 250) ** 2).astype(np.float32)
    tool = disc((200, 130), 50)
    flat = flatten_illumination(np.where(tool, 0.1 * light, light))
    assert np.percentile(np.abs(flat[~tool] - 1), 99) < 0.03
    assert flat[tool].max() < 0.2


class TestMoving:
    def speeds(self, inside, noise=0.05):
        rng = np.random.default_rng(1)
        u, v = rng.normal(0, noise, (2, *SHAPE))
        u[disc((250, 120), 70)] += inside
        return np.hypot(u, v)

    def test_moving_mass_is_found(self):
        soil = np.ones(SHAPE, bool)
        speed = self.speeds(4.0)
        speed[100:110, 240:250] = np.nan
        region = moving_mask(speed, soil)
        assert region.found
        assert iou(region.mask, disc((250, 120), 70)) > 0.97

    def test_stays_on_soil(self):
        soil = ~disc((250, 120), 40)
        region = moving_mask(self.speeds(4.0), soil)
        assert region.found
        assert not (region.mask & ~soil).any()

    @pytest.mark.parametrize("noise", [0.0, 0.05, 0.3])
    def test_nothing_moves(self, noise):
        region = moving_mask(self.speeds(0.0, noise), np.ones(SHAPE, bool))
        assert not region.found
        assert not region.mask.any()
        assert "no moving region" in region.remark

    def test_scattered_errors_are_no_mass(self):
        speed = self.speeds(0.0)
        speed[np.random.default_rng(2).uniform(size=SHAPE) < 0.02] = 9.0
        region = moving_mask(speed, np.ones(SHAPE, bool))
        assert not region.found
        assert "scattered" in region.remark

    @pytest.mark.parametrize("correlation", [0, 2, 5, 8])
    def test_pure_noise_is_no_mass_however_large(self, correlation):
        u, v = np.random.default_rng(7).normal(size=(2, *SHAPE))
        if correlation:
            u, v = (cv2.GaussianBlur(noise, (0, 0), correlation) for noise in (u, v))
        region = moving_mask(2 * np.hypot(u, v) / u.std(), np.ones(SHAPE, bool))
        assert not region.found and not region.mask.any() and np.isnan(region.threshold)
        assert "scattered" in region.remark

    def test_everything_moves_alike(self):
        region = moving_mask(5.0 + self.speeds(0.0), np.ones(SHAPE, bool))
        assert not region.found
        assert "speeds differ by" in region.remark

    def test_two_speeds_and_the_line_between(self):
        region = moving_mask(self.speeds(4.0), np.ones(SHAPE, bool))
        assert region.threshold == pytest.approx(2.0, abs=0.1)
        assert "all speeds between" not in region.remark

    def test_speeds_that_fall_off_gradually_are_said_to(self):
        y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
        region = moving_mask(np.clip(4 - np.hypot(x - 250, y - 120) / 40, 0, None), np.ones(SHAPE, bool))
        assert region.found
        assert (
            f"all speeds between: the line is where the speed is {region.threshold:.2f} px" in region.remark
        )

    def test_a_few_wild_vectors_do_not_hide_the_mass(self):
        speed = self.speeds(1.5)
        speed[200:204, 20:50] = 60.0
        region = moving_mask(speed, np.ones(SHAPE, bool))
        assert region.found
        assert iou(region.mask, disc((250, 120), 70)) > 0.97
        assert "set aside" in region.remark
        assert not moving_mask(np.where(speed > 50, speed, 0.1), np.ones(SHAPE, bool)).found

    @pytest.mark.parametrize("joined", [True, False])
    def test_two_masses_both_move_whether_or_not_a_thread_joins_them(self, joined):
        """As soil ahead of a wheel and behind it; a third is too small to count."""
        ahead, behind, small = disc((330, 120), 70), disc((150, 120), 60), disc((450, 250), 15)
        thread = np.zeros(SHAPE, bool)
        thread[110:130, 200:270] = joined
        noise = np.random.default_rng(1).normal(0, 0.05, (2, *SHAPE))
        speed = np.hypot(noise[0] + 4.0 * (ahead | behind | small | thread), noise[1])
        region = moving_mask(speed, np.ones(SHAPE, bool))
        assert iou(region.mask, ahead | behind | thread) > 0.97
        assert not (region.mask & small).any()

    def test_the_implements_speed_that_leaks_over_the_outline_does_not_shift_the_classes(self):
        soil = ~disc((250, 60), 50)
        speed = self.speeds(2.0)
        clean = moving_mask(speed, soil)
        speed[disc((250, 60), 52)] = 9.0
        assert moving_mask(speed, soil).threshold == pytest.approx(clean.threshold, abs=1e-6)

    def test_a_mean_shows_what_a_pair_does_not(self):
        speed = self.speeds(0.3, noise=0.01)
        assert not moving_mask(speed, np.ones(SHAPE, bool)).found
        region = moving_mask(speed, np.ones(SHAPE, bool), least_step=0.1)
        assert iou(region.mask, disc((250, 120), 70)) > 0.97

    def test_coherence(self):
        everywhere = np.ones(SHAPE, bool)
        half = np.zeros(SHAPE, bool)
        half[:, 250:] = True
        # Of the columns 10 px apart, 10 of 490 pairs have just one end in the fast half.
        across = 1 - (0.5 * 10 / 245) / 0.5
        assert coherence(half, everywhere, 10) == pytest.approx((across + 1) / 2, abs=0.01)
        assert coherence(everywhere, everywhere, 10) == 1.0
        chance = np.random.default_rng(0).uniform(size=SHAPE) < 0.3
        assert coherence(chance, everywhere, 10) == pytest.approx(0.0, abs=0.02)

    def test_no_soil_and_nothing_measured(self):
        assert not moving_mask(self.speeds(4.0), np.zeros(SHAPE, bool)).found
        assert not moving_mask(np.full(SHAPE, np.nan), np.ones(SHAPE, bool)).found


def test_tbar_soil_leaves_out_the_dark_tool(real_data):
    """At a quarter of the size: the tool, black at its centre, is out; soil in bright and dim light is in."""
    picture = cv2.imread(str(real_data / "tbar" / "IMG_1062.jpg"), cv2.IMREAD_GRAYSCALE)
    small = cv2.resize(picture, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    region = soil_mask(small.astype(np.float32))
    assert region.found
    dark = cv2.medianBlur(small, 9) < 50
    assert dark.mean() == pytest.approx(0.04, abs=0.01)
    assert (region.mask & dark).sum() < 0.03 * dark.sum()
    assert region.mask[~dark].mean() > 0.99
