import cv2
import numpy as np
import pytest

from soft.flow import (
    BUILT_IN,
    VARIANTS,
    FlowError,
    FlowField,
    estimate_flow,
    find_estimator,
    read_flo,
    resolve_options,
    write_flo,
)

INNER = np.s_[16:-16, 16:-16]
RUBBER_WHALE = {"black-anandan": 0.085, "dis": 0.23, "ilk": 0.28, "robust-affine": 0.11, "tvl1": 0.28}
"""Mean end-point errors that methods keep to, px; 0.33 for others."""


def errors(field: FlowField, truth: np.ndarray) -> np.ndarray:
    assert field.valid[INNER].all()
    return np.hypot(*np.moveaxis(field.displacement - truth, -1, 0))[INNER]


@pytest.mark.parametrize("method", sorted(BUILT_IN))
@pytest.mark.parametrize("shift", [(0.4, 0.0), (0.0, -0.4), (-2.3, 0.8), (6.7, -3.1), (0.0, 0.0)])
def test_known_shift(moved, method, shift):
    first, second, truth = moved(shift=shift)
    error = errors(estimate_flow(first, second, method=method), truth)
    assert np.median(error) < 0.08
    assert np.percentile(error, 95) < 0.15


@pytest.mark.parametrize("method", sorted(BUILT_IN))
def test_known_rotation_and_shear(moved, method):
    """Components that differ in every entry of the gradient catch swapped axes and signs."""
    first, second, truth = moved(matrix=((1.01, -0.03), (0.02, 0.99)), shift=(1.0, -2.0))
    field = estimate_flow(first, second, method=method)
    error = errors(field, truth)
    assert np.median(error) < 0.06
    assert np.percentile(error, 95) < 0.2


@pytest.mark.parametrize("method", sorted(BUILT_IN))
def test_middlebury(real_data, method):
    folder = real_data / "middlebury" / "RubberWhale"
    first, second = (cv2.imread(str(folder / f"frame{k}.png"), 0) for k in (10, 11))
    truth = read_flo(folder / "flow10.flo")
    field = estimate_flow(first, second, method=method, forward_backward=False)  # of every pixel
    error = np.hypot(*np.moveaxis(field.displacement - truth, -1, 0))
    assert field.valid.mean() > 0.95
    assert np.nanmean(error) < RUBBER_WHALE.get(method, 0.33)
    # Standing still would be this wrong: the axes and signs are right on real pictures too.
    assert np.nanmean(np.hypot(*np.moveaxis(truth, -1, 0))) > 3 * np.nanmean(error)


@pytest.mark.parametrize("name", sorted(VARIANTS))
def test_variants_are_their_method_with_options(moved, name):
    method, options = VARIANTS[name]
    first, second, _ = moved(matrix=((1.01, -0.03), (0.02, 0.99)), shift=(1.0, -2.0))
    own, same = (
        estimate_flow(first, second, method=name),
        estimate_flow(first, second, method=method, **options),
    )
    np.testing.assert_array_equal(own.displacement, same.displacement)
    assert not np.array_equal(own.displacement, estimate_flow(first, second, method=method).displacement)
    assert find_estimator(name).name == name
    assert resolve_options(name, {}) == resolve_options(method, options)


def test_valid_and_nan_are_one(moved):
    first, second, _ = moved(shift=(3.0, 0.0))
    mask = np.ones(first.shape, bool)
    mask[:40] = False
    field = estimate_flow(first, second, mask=mask)
    assert np.array_equal(field.valid, np.isfinite(field.displacement).all(axis=2))
    assert np.isnan(field.displacement[~field.valid]).all()
    assert not field.valid[:40].any()
    assert field.valid[60:-20, 20:-20].all()


def test_motion_out_of_the_picture_is_not_valid(moved):
    first, second, _ = moved(shift=(8.0, 0.0))
    field = estimate_flow(first, second)
    assert not field.valid[20:-20, -6:].any()
    assert field.valid[20:-20, 20:-20].all()


@pytest.mark.parametrize("method", sorted(BUILT_IN))
def test_no_texture_is_not_valid(moved, method):
    first, second, _ = moved(shift=(1.0, 0.0))
    first[40:120, 80:160] = second[40:120, 80:160] = 30.0
    field = estimate_flow(first, second, method=method)
    assert not field.valid[48:112, 88:152].any()
    assert field.valid[60:100, 20:60].all()


@pytest.mark.parametrize("method", sorted(BUILT_IN))
def test_constant_pictures_and_nothing_to_use_give_nothing(moved, method):
    grey = np.full((40, 50), 99, np.uint8)
    assert not estimate_flow(grey, grey, method=method).valid.any()
    first, second, _ = moved()
    field = estimate_flow(first, second, method=method, mask=np.zeros(first.shape, bool))
    assert not field.valid.any()
    assert np.isnan(field.displacement).all()


def test_farneback_uses_the_fractions_of_deep_pictures_and_dis_cannot(moved):
    first, second, _ = moved(shift=(0.6, -0.3))
    for method, same in (("dis", True), ("farneback", False)):
        deep = estimate_flow(first, second, method=method).displacement
        rounded = estimate_flow(np.rint(first), np.rint(second), method=method).displacement
        assert np.array_equal(deep, rounded, equal_nan=True) is same


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        (
            np.zeros((40, 50)),
            np.zeros((50, 40)),
            r"second picture: shape \(50, 40\): the first has \(40, 50\)",
        ),
        (np.zeros((40, 50, 3)), np.zeros((40, 50, 3)), r"first picture: shape \(40, 50, 3\): must be grey"),
        (np.full((40, 50), np.nan), np.zeros((40, 50)), "first picture: 2000 values are not finite"),
        (np.zeros((40, 50)), np.full((40, 50), 300.0), "second picture: grey levels 300 to 300"),
        (np.zeros((40, 50)), np.full((40, 50), "a"), "second picture: type"),
        (np.zeros((0, 50)), np.zeros((0, 50)), "first picture: shape"),
    ],
)
def test_impossible_pictures(first, second, message):
    with pytest.raises(FlowError, match=message):
        estimate_flow(first, second)


@pytest.mark.parametrize("method", sorted(BUILT_IN))
@pytest.mark.parametrize("shape", [(1, 600), (600, 1), (8, 8), (12, 200), (15, 3000)])
def test_pictures_too_small_are_refused_and_do_not_crash(method, shape):
    picture = np.random.default_rng(0).uniform(0, 255, shape)
    with pytest.raises(FlowError, match="at least 16"):
        estimate_flow(picture, picture, method=method)


@pytest.mark.parametrize("shape", [(32, 3000), (3000, 32), (33, 47), (64, 64)])
@pytest.mark.parametrize("preset", ["ultrafast", "fast", "medium"])
def test_smallest_pictures_do_not_crash(shape, preset):
    picture = np.random.default_rng(0).uniform(0, 255, shape)
    assert np.nanmax(np.abs(estimate_flow(picture, picture, method="dis", preset=preset).displacement)) < 0.5


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"method": "raft"}, "method 'raft': allowed are black-anandan, dis, dis-full, farneback"),
        ({"method": "dis", "window_size": 3}, "unknown option window_size: allowed are preset, finest_scale"),
        ({"method": "dis", "preset": "slow"}, "preset: 'slow': allowed are ultrafast, fast, medium"),
        ({"method": "dis", "patch_stride": 0}, "patch_stride: 0: must be a whole number from 1"),
        ({"method": "dis", "patch_size": 8.0}, r"patch_size: 8\.0"),
        ({"method": "dis", "use_mean_normalization": 1}, "must be true or false"),
        ({"method": "dis", "finest_scale": 3, "coarsest_scale": 2}, "must be at least finest_scale"),
        ({"method": "dis", "finest_scale": 5}, "needs at least 256 px"),
        (
            {"method": "farneback", "pyramid_scale": 1.0},
            "pyramid_scale: 1.0: must be a number between 0 and 1",
        ),
        ({"method": "tvl1", "attachment": 0}, "attachment: 0: must be a number above 0"),
        ({"method": "tvl1", "num_warp": 3}, "unknown option num_warp: allowed are attachment, tightness"),
        ({"method": "ilk", "radius": 0}, "radius: 0: must be a whole number from 1"),
        ({"method": "soft-2014", "preset": "accurate"}, "option preset is 'soft-2014' by its name"),
        ({"method": "dis", "device": "cuda"}, "device 'cuda': method 'dis' runs on cpu"),
        ({"threads": 0}, "threads: 0: must be a whole number"),
        ({"mask": np.ones((3, 3), bool)}, "mask: bool of shape"),
        ({"mask": np.ones((160, 220))}, "mask: float64"),
    ],
)
def test_impossible_requests(moved, keywords, message):
    first, second, _ = moved()
    with pytest.raises(FlowError, match=message):
        estimate_flow(first, second, **keywords)


@pytest.mark.parametrize(
    ("method", "options"),
    [
        ("dis", {"preset": "ultrafast"}),
        ("dis", {"finest_scale": 0}),
        ("dis", {"patch_size": 12}),
        ("dis", {"patch_stride": 5}),
        ("dis", {"coarsest_scale": 1}),
        ("dis", {"gradient_descent_iterations": 3}),
        ("dis", {"variational_refinement_iterations": 0}),
        ("dis", {"variational_refinement_alpha": 5.0}),
        ("dis", {"variational_refinement_delta": 1.0}),
        ("dis", {"variational_refinement_gamma": 1.0}),
        ("dis", {"use_mean_normalization": False}),
        ("dis", {"use_spatial_propagation": False}),
        ("farneback", {"pyramid_scale": 0.5}),
        ("farneback", {"level_count": 1}),
        ("farneback", {"window_size": 9}),
        ("farneback", {"iteration_count": 1}),
        ("farneback", {"polynomial_size": 7}),
        ("farneback", {"polynomial_sigma": 1.5}),
        ("farneback", {"gaussian_window": False}),
        ("tvl1", {"attachment": 5.0}),
        ("tvl1", {"tightness": 0.1}),
        ("tvl1", {"warp_count": 2}),
        ("tvl1", {"iteration_count": 3}),
        ("tvl1", {"tolerance": 0.1}),
        ("tvl1", {"prefilter": True}),
        ("ilk", {"radius": 4}),
        ("ilk", {"warp_count": 2}),
        ("ilk", {"gaussian_window": True}),
        ("ilk", {"prefilter": True}),
    ],
)
def test_every_option_does_something(moved, method, options):
    first, second, _ = moved(matrix=((1.0, -0.05), (0.05, 1.0)), shift=(9.0, 0.0))
    plain = estimate_flow(first, second, method=method).displacement
    other = estimate_flow(first, second, method=method, **options).displacement
    assert not np.array_equal(plain, other, equal_nan=True)


@pytest.mark.parametrize("method", sorted(BUILT_IN))
def test_threads_are_restored_and_change_nothing(moved, method):
    first, second, _ = moved(shift=(1.2, 0.7))
    before = cv2.getNumThreads()
    fields = [estimate_flow(first, second, method=method, threads=n).displacement for n in (1, 2, 5)]
    assert cv2.getNumThreads() == before
    assert all(np.array_equal(fields[0], field, equal_nan=True) for field in fields)


class TestUserFunction:
    def test_callable_gets_the_contract(self, moved):
        seen = {}

        def own(first, second, mask):
            seen.update(first=first, second=second, mask=mask)
            flow = np.zeros((*first.shape, 2))
            flow[..., 0] = 1.5
            flow[5, 7] = np.nan
            first[:] = 0
            return flow

        first, second, _ = moved()
        before = first.copy()
        field = estimate_flow(first, second, method=own)
        assert seen["first"].dtype == seen["second"].dtype == np.float32
        assert seen["mask"].dtype == bool
        assert seen["mask"].all()
        assert np.array_equal(first, before)
        assert field.displacement.dtype == np.float32
        assert not field.valid[5, 7]
        assert field.valid[50, 50]
        assert np.array_equal(field.displacement[50, 50], [1.5, 0.0])

    def test_import_path(self, tmp_path, monkeypatch, moved):
        (tmp_path / "own_flow_of_mine.py").write_text(
            "import numpy as np\ndef still(first, second, mask):\n    return np.zeros(first.shape + (2,))\n"
        )
        monkeypatch.syspath_prepend(tmp_path)
        first, second, _ = moved()
        assert estimate_flow(first, second, method="own_flow_of_mine:still").valid.all()
        with pytest.raises(FlowError, match="has no function 'nothing'"):
            estimate_flow(first, second, method="own_flow_of_mine:nothing")
        with pytest.raises(FlowError, match="cannot import 'no_such_module_here'"):
            estimate_flow(first, second, method="no_such_module_here:f")

    @pytest.mark.parametrize(
        ("answer", "message"),
        [
            (lambda a, b, m: a, r"returned shape \(160, 220\): must be \(160, 220, 2\)"),
            (lambda a, b, m: np.zeros((*a.shape, 2), complex), "returned type complex128"),
            (lambda a, b, m: None, "returned shape"),
            (lambda a, b, m: 1 / 0, r"failed: ZeroDivisionError: .*, in .*test_estimate.py, line \d+$"),
        ],
    )
    def test_wrong_answers(self, moved, answer, message):
        first, second, _ = moved()
        with pytest.raises(FlowError, match=message):
            estimate_flow(first, second, method=answer)

    def test_takes_no_options(self, moved):
        first, second, _ = moved()
        with pytest.raises(FlowError, match="unknown option a: allowed are none"):
            estimate_flow(first, second, method=lambda a, b, m: None, a=1)


class TestFiles:
    @pytest.fixture
    def folder(self, tmp_path):
        for k in (1, 2, 10):
            write_flo(tmp_path / f"{k}.flo", np.full((160, 220, 2), k / 10))
        return tmp_path

    def test_sorted_one_a_pair(self, folder, moved):
        first, second, _ = moved()
        for pair, value in enumerate((0.1, 0.2, 1.0)):
            field = estimate_flow(first, second, method=f"files:{folder}", pair=pair)
            assert np.nanmax(field.displacement) == pytest.approx(value)

    def test_errors(self, folder, moved):
        first, second, _ = moved()
        with pytest.raises(FlowError, match="option pair must be given"):
            estimate_flow(first, second, method=f"files:{folder}")
        with pytest.raises(FlowError, match="none for pair 3"):
            estimate_flow(first, second, method=f"files:{folder}", pair=3)
        with pytest.raises(FlowError, match="220 x 160 px, but the pictures have 219 x 160 px"):
            estimate_flow(first[:, 1:], second[:, 1:], method=f"files:{folder}", pair=0)
        with pytest.raises(FlowError, match="no such folder"):
            estimate_flow(first, second, method="files:/nowhere", pair=0)
