import json
import tracemalloc
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest
import xarray

from soft import (
    FlowError,
    ImageSequence,
    Region,
    SoilFlowError,
    analyze,
    check_soil_flow,
    pair_analysis,
    read_soil_flow,
    write_flo,
)
from soft.sequence.resampling import Resampling


@pytest.fixture
def sequence(moved):
    """Three pictures of soil on the move by (1.5, -0.75) px, calibrated."""
    pictures = [moved(shift=(1.5 * k, -0.75 * k))[1] for k in range(3)]
    return ImageSequence.from_arrays(pictures, metres_per_pixel=2e-4, frame_rate=8)


def test_soil_flow_of_a_moving_camera(sequence):
    flow = analyze(sequence, soil="all")
    assert dict(flow.sizes) == {"pair": 2, "y": 160, "x": 220}
    inner = flow.isel(y=slice(20, -20), x=slice(20, -20))
    assert np.allclose(inner["u"].median(("y", "x")), 1.5, atol=0.1)
    assert np.allclose(inner["v"].median(("y", "x")), -0.75, atol=0.1)
    assert np.allclose(flow["camera_u"], 1.5, atol=0.1)
    assert (flow["camera_v"] == 0).all()
    assert abs(float(inner["inertial_u"].median())) < 0.05
    # Up in the picture is up in the world: 0.75 px at 0.2 mm and 8 frames a second.
    assert np.allclose(inner["velocity_z"].median(), 0.75 * 2e-4 * 8, rtol=0.1)
    assert flow["time"].values.tolist() == [0.0, 0.125]
    assert flow["first_frame"].values.tolist() == [0, 1]
    assert flow["second_frame"].values.tolist() == [1, 2]
    assert not flow["moving"].any()
    assert 0 < float(inner["uncertainty_u"].median()) < 0.1
    assert np.array_equal(flow["valid"], np.isfinite(flow["u"]))


def test_vertical_camera_motion_on_request(sequence):
    flow = analyze(sequence, soil="all", vertical=True)
    assert np.allclose(flow["camera_v"], -0.75, atol=0.1)
    assert abs(float(flow["inertial_v"].median())) < 0.05


def test_file_and_memory_agree(sequence, tmp_path):
    steps = []
    path = tmp_path / "dis.nc"
    in_memory = analyze(sequence, soil="all")
    with analyze(sequence, soil="all", path=path, progress=lambda *a: steps.append(a)) as on_disk:
        xarray.testing.assert_equal(in_memory, on_disk)
        assert set(in_memory.attrs) == set(on_disk.attrs)
        for name in in_memory.variables:
            assert in_memory[name].dtype == on_disk[name].dtype
            assert in_memory[name].attrs == on_disk[name].attrs
    assert steps == [(0, 2), (1, 2), (2, 2)]


def test_attributes_tell_what_was_done(sequence):
    attributes = analyze(sequence, method="farneback", options={"window_size": 9}, soil="all", seed=4).attrs
    assert attributes["schema_version"] == 1
    assert attributes["method"] == "farneback"
    options = json.loads(attributes["options"])
    assert options["window_size"] == 9
    assert options["pyramid_scale"] == 0.7, "defaults must be spelt out"
    assert json.loads(attributes["versions"])["opencv"] == cv2.__version__
    assert attributes["seconds_per_pair"] > 0
    assert (attributes["metres_per_pixel"], attributes["frame_rate"]) == (2e-4, 8.0)
    assert any("no moving region" in remark for remark in json.loads(attributes["remarks"]))


def test_recorded_options_can_be_given_again(sequence):
    options = json.loads(analyze(sequence, soil="all").attrs["options"])
    xarray.testing.assert_equal(analyze(sequence, soil="all", options=options), analyze(sequence, soil="all"))


def test_without_calibration(picture_folder):
    flow = analyze(ImageSequence.open(picture_folder), soil="all")
    assert "velocity_x" not in flow
    assert "metres_per_pixel" not in flow.attrs
    assert flow["time"].values.tolist() == [0.0, 1.0]
    assert flow["time"].attrs["units"] == "frame"
    check_soil_flow(flow)
    assert json.loads(flow.attrs["frames"]) == ["shot9.png", "shot10.png", "shot11.png"]


def test_moving_region_in_the_inertial_frame(moved):
    """A camera that sees resting soil pass by at -2 px, and a block of soil that goes right through it."""
    first, second, _ = moved(shift=(-2.0, 0.0))
    _, block, _ = moved(shift=(3.0, 0.0))
    second[50:120, 70:150] = block[50:120, 70:150]
    flow = analyze(ImageSequence.from_arrays([first, second]), soil="all")
    moving = flow["moving"].values[0]
    assert float(flow["camera_u"][0]) == pytest.approx(-2, abs=0.1)
    assert moving[60:110, 80:140].mean() > 0.95
    assert moving[:35].sum() == moving[140:].sum() == 0
    assert np.median(flow["inertial_u"].values[0][60:110, 80:140]) == pytest.approx(5, abs=0.2)


def test_flow_from_files(sequence, tmp_path):
    for k in range(2):
        write_flo(tmp_path / f"{k}.flo", np.full((160, 220, 2), (k + 1.0, 0.5)))
    flow = analyze(sequence, method=f"files:{tmp_path}", soil="all")
    assert flow["u"].max(("y", "x")).values.tolist() == [1.0, 2.0]
    (tmp_path / "1.flo").unlink()
    with pytest.raises(FlowError, match=r"1 \.flo files for 2 pairs"):
        analyze(sequence, method=f"files:{tmp_path}")


def test_vectors_of_a_grid_stay_at_their_nodes(sequence, tmp_path):
    grids = tmp_path / "grids"
    grids.mkdir()
    for k in range(2):
        (grids / f"{k}.csv").write_text(f"x,y,u,v,flags\n41.3,20,{k + 1},0.5,0\n90,100,3,1,1\n")
    path = tmp_path / "flow.nc"
    with analyze(sequence, method=f"files:{grids}", soil="all", path=path) as flow:
        assert flow["valid"].sum(("y", "x")).values.tolist() == [1, 1]
        assert flow["u"].values[:, 20, 41].tolist() == [1.0, 2.0]
        assert flow["node_x"].values[1, 20, 41] == pytest.approx(41.3)
        assert np.isfinite(flow["node_y"].values).sum() == 4
        assert json.loads(flow.attrs["options"])["convention"] == "forward"
    with analyze(sequence, method=f"files:{grids}", options={"y": "up"}, soil="all") as flow:
        assert flow["v"].values[0, 139, 41] == -0.5
    with pytest.raises(FlowError, match="pair: is not to be given here"):
        analyze(sequence, method=f"files:{grids}", options={"pair": 1})


def test_bad_requests_fail_before_a_file_is_made(sequence, tmp_path):
    path = tmp_path / "x.nc"
    for keywords, error in (
        ({"method": "nothing"}, FlowError),
        ({"options": {"nothing": 1}}, FlowError),
        ({"soil": "red"}, ValueError),
        ({"camera": "red"}, ValueError),
    ):
        with pytest.raises(error):
            analyze(sequence, path=path, **keywords)
    assert not path.exists()


def test_memory_does_not_grow_with_the_sequence(tmp_path):
    """Twelve pairs on disk must not take more than a few pairs in memory."""
    noise = np.random.default_rng(0).integers(60, 200, (256, 320)).astype(np.uint8)
    for k in range(13):
        cv2.imwrite(str(tmp_path / f"{k}.png"), noise)
    still = _still_soil
    peaks = []
    for count in (3, 13):
        sequence = ImageSequence.open(tmp_path)
        short = sequence.select(stop=count)
        analyze(short, method=still, soil="all", path=tmp_path / "warm.nc").close()
        tracemalloc.start()
        analyze(short, method=still, soil="all", path=tmp_path / "x.nc").close()
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0]


def _still_soil(first, second, mask):
    return np.zeros((*first.shape, 2))


class TestValidator:
    @pytest.fixture
    def flow(self, sequence):
        return analyze(sequence, method=_still_soil, soil="all")

    def test_other_versions_are_refused(self, flow, tmp_path):
        flow.attrs["schema_version"] = 2
        flow.to_netcdf(tmp_path / "x.nc", engine="h5netcdf")
        with pytest.raises(SoilFlowError, match=r"x\.nc: schema_version 2: this reads 1"):
            read_soil_flow(tmp_path / "x.nc")

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            (lambda f: f.drop_vars("soil"), "variable soil is missing"),
            (lambda f: f.drop_vars("camera_u_high"), "variable camera_u_high is missing"),
            (lambda f: f.drop_vars("velocity_z"), "variable velocity_z is missing"),
            (lambda f: f.drop_vars("time"), "variable time is missing"),
            (lambda f: f.assign(valid=f["valid"].astype(float)), "variable valid: type float64"),
            (lambda f: f.assign(u=f["u"].assign_attrs(units="m")), "variable u: units m: must be px"),
            (lambda f: f.assign(u=f["u"].isel(pair=0)), "variable u: dimensions"),
            (lambda f: f.assign_attrs(schema_version=None), "no schema_version"),
        ],
    )
    def test_wrong_forms_are_refused(self, flow, change, message):
        with pytest.raises(SoilFlowError, match=message):
            check_soil_flow(change(flow))

    def test_files_without_intervals_are_read_still(self, flow):
        check_soil_flow(flow.drop_vars([f"camera_{c}_{b}" for c in "uv" for b in ("low", "high")]))

    def test_no_file_and_no_netcdf(self, tmp_path):
        with pytest.raises(SoilFlowError, match="no such file"):
            read_soil_flow(tmp_path / "x.nc")
        (tmp_path / "x.nc").write_text("nothing")
        with pytest.raises(SoilFlowError, match="not a readable"):
            read_soil_flow(tmp_path / "x.nc")


def test_tbar_flow_is_plausible(real_data):
    """At a quarter of the size, where the 2 px, and 3.6 px (95 %) near the tool, are 0.5 and 0.9 px."""
    pictures = [
        cv2.resize(cv2.imread(str(path), 0), None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
        for path in sorted((real_data / "tbar").glob("*.jpg"))[:2]
    ]
    flow = analyze(ImageSequence.from_arrays(pictures))
    u, v = (flow[name].values[0] for name in ("u", "v"))
    speed = np.where(flow["soil"].values[0] & flow["valid"].values[0], np.hypot(u, v), np.nan)
    assert np.nanmedian(speed) == pytest.approx(0.5, abs=0.1)
    assert np.nanpercentile(speed[225:525, 225:725], 95) == pytest.approx(0.9, abs=0.15)
    assert np.nanmedian(v) > 0.4, "the soil goes towards the lower edge"


class TestPartsOfPictures:
    def test_region_tells_where_it_lies(self, sequence):
        part = sequence.crop(Region(x=30, y=20, width=150, height=100))
        flow = analyze(part, method="farneback", soil="all")
        assert (flow.sizes["x"], flow.sizes["y"]) == (150, 100)
        assert (flow.attrs["region_x"], flow.attrs["region_y"]) == (30, 20)
        whole = analyze(sequence, method="farneback", soil="all")
        there = whole["u"].values[:, 40:100, 60:140]
        assert np.abs(flow["u"].values[:, 20:80, 30:110] - there).max() < 0.1
        assert whole.attrs["region_x"] == 0

    def test_mask_takes_soil_away_and_nothing_else(self, sequence, tmp_path):
        mask = np.zeros((160, 220), np.uint8)
        mask[:, 100:] = 255
        cv2.imwrite(str(tmp_path / "mask.png"), mask)
        flow = analyze(sequence.mask(tmp_path / "mask.png"), method="farneback", soil="all")
        assert np.array_equal(flow["soil"].values[0], mask > 0)
        assert flow["valid"].values[0][:, :100].any()
        assert flow.attrs["masks"] == "static"

    def test_what_the_camera_did_not_see_is_not_measured(self, sequence):
        y, x = np.mgrid[:160, :220].astype(np.float32)
        resampling = Resampling(np.stack([x - 20, y], axis=2), (160, 220))
        flow = analyze(sequence.resample(resampling), method="farneback", soil="all")
        assert not flow["valid"].values[0][:, :20].any()
        assert not flow["soil"].values[0][:, :20].any()
        assert flow["valid"].values[0][20:-20, 40:-20].all()
        # Soil that goes to where nothing was seen is not measured either.
        back = ImageSequence.from_arrays([sequence[2], sequence[0]]).resample(resampling)
        assert not analyze(back, method="farneback", soil="all")["valid"].values[0][20:-20, 20:22].any()


class TestWithAnExecutor:
    def test_values_are_the_same_and_in_order(self, moved):
        pictures = [moved(shift=(0.5 * k * k, 0))[1] for k in range(6)]
        sequence = ImageSequence.from_arrays(pictures, metres_per_pixel=2e-4, frame_rate=8)
        alone = analyze(sequence, method="farneback", soil="all")
        with ThreadPoolExecutor(3) as executor:
            together = analyze(sequence, method="farneback", soil="all", executor=executor)
        xarray.testing.assert_equal(together, alone)
        assert (np.diff(alone["camera_u"]) > 0.5).all(), "every pair has a motion of its own"

    def test_no_more_is_given_to_it_than_fits_in_memory(self, moved, monkeypatch):
        monkeypatch.setattr("soft.analysis.os.cpu_count", lambda: 1)
        sequence = ImageSequence.from_arrays([moved(shift=(k, 0))[1] for k in range(9)])
        given = []

        class Counting(ThreadPoolExecutor):
            def submit(self, *arguments):
                given.append(super().submit(*arguments))
                return given[-1]

        def progress(done, _):
            assert len(given) <= done + 2

        with Counting(1) as executor:
            analyze(sequence, method="farneback", soil="all", executor=executor, progress=progress)
        assert len(given) == 8

    def test_an_error_is_told(self, sequence):
        with ThreadPoolExecutor(2) as executor, pytest.raises(FlowError, match="shape"):
            analyze(sequence, method=lambda first, second, mask: 0, soil="all", executor=executor)


class TestStoppedAndContinued:
    def analyze(self, sequence, folder, **options):
        return analyze(sequence, method="farneback", soil="all", keep=folder / "kept", **options)

    def test_goes_on_with_what_is_missing_and_ends_with_the_same_values(
        self, sequence, tmp_path, monkeypatch
    ):
        def stop(done, count):
            if done == 1:
                raise KeyboardInterrupt

        whole = analyze(sequence, method="farneback", soil="all")
        with pytest.raises(KeyboardInterrupt):
            self.analyze(sequence, tmp_path, progress=stop, path=tmp_path / "x.nc")
        measured = self._count(monkeypatch)
        with self.analyze(sequence, tmp_path, path=tmp_path / "x.nc") as flow:
            xarray.testing.assert_equal(whole, flow)
        assert len(measured) == 1, "the first pair was kept"

    def test_other_pictures_and_settings_are_measured_anew(self, sequence, tmp_path, monkeypatch):
        self.analyze(sequence, tmp_path)
        measured = self._count(monkeypatch)
        self.analyze(sequence, tmp_path, camera="mode", seed=3)
        assert not measured, "flow depends on neither"
        self.analyze(sequence, tmp_path, options={"window_size": 9})
        assert len(measured) == 2
        pictures = [sequence[0], sequence[1], np.minimum(sequence[2] + 1, 255)]
        self.analyze(ImageSequence.from_arrays(pictures), tmp_path)
        assert len(measured) == 3, "of the second pair only"

    def test_damaged_file_counts_as_not_there(self, sequence, tmp_path):
        whole = self.analyze(sequence, tmp_path)
        for k, file in enumerate(sorted((tmp_path / "kept").iterdir())):
            file.write_bytes(file.read_bytes()[:1000] if k else b"")
        xarray.testing.assert_equal(self.analyze(sequence, tmp_path), whole)

    def test_nothing_is_kept_of_a_function(self, sequence, tmp_path):
        analyze(sequence, method=_still_soil, soil="all", keep=tmp_path / "kept")
        assert not (tmp_path / "kept").exists()

    @staticmethod
    def _count(monkeypatch):
        measured = []
        estimate = pair_analysis.estimate_flow
        monkeypatch.setattr(
            pair_analysis, "estimate_flow", lambda *a, **k: measured.append(1) or estimate(*a, **k)
        )
        return measured
