"""What is exported comes back with the same values."""

import json
import shutil
import subprocess

import cv2
import numpy as np
import pytest
import xarray as xr

import soft
import synth
from synth.scene import parse_scene
from validation.cli import run_command
from validation.exchange import FORMATS, motion_colours

METHODS = ("dis", "farneback")


@pytest.fixture(scope="module")
def exported(finished_run, tmp_path_factory):
    """A copy of the finished run with every format."""
    out = tmp_path_factory.mktemp("exported") / "run"
    shutil.copytree(finished_run, out)
    for file_format in FORMATS:
        assert run_command(["export", str(out), "--format", file_format]) == 0
    return out


def expected(run, name):
    """u and v of the only pair where they are valid, else NaN: (H, W, 2)."""
    if name == "truth":
        with synth.Footage.open(run / "footage") as footage:
            data = footage.truth(0)
    else:
        with soft.read_soil_flow(run / "analysis" / f"{name}.nc") as flow:
            data = flow.isel(pair=0).load()
    values = np.stack([data.u.values, data.v.values], -1)
    return np.where(data.valid.values[..., None], values, np.float32(np.nan))


@pytest.mark.parametrize("name", ["truth", *METHODS])
def test_flo_comes_back_exactly(exported, name):
    flow = soft.read_flo(exported / "flo" / name / "000000.flo")
    assert np.isfinite(flow).any()
    np.testing.assert_array_equal(flow, expected(exported, name))


@pytest.mark.parametrize("name", ["truth", *METHODS])
def test_kitti_comes_back_within_its_quantum(exported, name):
    flow, true = soft.read_kitti(exported / "kitti" / name / "000000.png"), expected(exported, name)
    np.testing.assert_array_equal(np.isnan(flow), np.isnan(true))
    assert np.nanmax(np.abs(flow - true)) <= 1 / 128


@pytest.mark.parametrize("name", ["truth", *METHODS])
def test_csv_comes_back_exactly(exported, name):
    path = exported / "csv" / name / "000000.csv"
    assert path.read_text().splitlines()[0] == "x [px],y [px],u [px],v [px]"
    x, y, u, v = np.loadtxt(path, delimiter=",", skiprows=1).T
    true = expected(exported, name)
    back = np.full(true.shape, np.nan, np.float32)
    back[y.astype(int), x.astype(int)] = np.stack([u, v], -1)
    np.testing.assert_array_equal(back, true)


@pytest.mark.parametrize("name", ["truth", *METHODS])
def test_netcdf_comes_back_exactly(exported, name):
    with xr.open_dataset(exported / "netcdf" / f"{name}.nc", engine="h5netcdf") as data:
        assert data.attrs["Conventions"].startswith("CF-")
        assert (data.u.dtype, data.valid.dtype) == (np.float32, bool)
        assert data.u.attrs["units"] == "px" and data.u.attrs["long_name"]
        assert data.u.encoding["chunksizes"][0] == 1
        values = np.stack([data.u.values[0], data.v.values[0]], -1)
        values[~data.valid.values[0]] = np.nan
        assert int(data.second_frame[0]) == 1
        np.testing.assert_array_equal(data.x, np.arange(96))
    np.testing.assert_array_equal(values, expected(exported, name))


def test_netcdf_has_the_pictures(exported):
    with (
        xr.open_dataset(exported / "netcdf" / "pictures.nc", engine="h5netcdf") as data,
        synth.Footage.open(exported / "footage") as footage,
    ):
        assert data.picture.dtype == np.uint8
        np.testing.assert_array_equal(data.picture[1], footage.picture(1))


def test_videos_show_pictures_and_motion(exported):
    for name, count in (("pictures", 2), ("truth", 1), ("dis", 1)):
        video = cv2.VideoCapture(str(exported / "mp4" / f"{name}.mp4"))
        frames = []
        while (read := video.read())[0]:
            frames.append(read[1])
        assert len(frames) == count
        assert frames[0].shape == (80, 96, 3)
    video = cv2.VideoCapture(str(exported / "mp4" / "pictures.mp4"))
    with synth.Footage.open(exported / "footage") as footage:
        near = np.corrcoef(video.read()[1][..., 0].ravel(), footage.picture(0).ravel())[0, 1]
    assert near > 0.9  # a lossy codec: for looking at only


def test_colours_tell_direction_and_speed():
    motion = np.array([[[2.0, 0], [0, 2.0], [-2.0, 0], [0, -2.0]], [[1.0, 0], [0, 0], [np.nan, 0], [9.0, 0]]])
    blue_green_red = motion_colours(motion, top=2.0).tolist()
    assert blue_green_red[0] == [[0, 0, 255], [0, 255, 127], [255, 255, 0], [255, 0, 128]]
    assert blue_green_red[1] == [[0, 0, 128], [0, 0, 0], [96, 96, 96], [0, 0, 255]]


def test_an_exported_folder_is_a_method(softbed, exported):
    files = f"files:{exported / 'flo' / 'dis'}"
    status, _, error = softbed("score", exported, "--method", files, "--method", "dis")
    assert status == 0, error
    methods = json.loads((exported / "scores.json").read_text())["methods"]
    assert methods[files]["strata"] == methods["dis"]["strata"]


def test_export_again_is_skipped_and_follows_a_new_analysis(softbed, finished_run, tmp_path):
    out = tmp_path / "run"
    shutil.copytree(finished_run, out)
    assert softbed("export", out, "--format", "flo")[0] == 0
    assert "skipped" in softbed("export", out, "--format", "flo")[2]
    assert softbed("analyze", out, "--method", "dis", "--soil", "all")[0] == 0
    assert "doing it again" in softbed("export", out, "--format", "flo")[2]


def test_footage_alone_can_be_exported(softbed, finished_run, tmp_path):
    footage = tmp_path / "footage"
    shutil.copytree(finished_run / "footage", footage)
    status, output, error = softbed("export", footage, "--format", "flo", "--out", tmp_path / "out", "--json")
    assert status == 0, error
    assert json.loads(output)["steps"]["export flo"]["files"] == ["flo/truth/000000.flo"]


def test_the_data_card_lists_every_variable(finished_run):
    card = (finished_run / "footage" / "README.md").read_text()
    with xr.open_dataset(finished_run / "footage" / "truth.nc", engine="h5netcdf") as truth:
        for name, variable in truth.variables.items():
            (row,) = (line for line in card.splitlines() if line.startswith(f"| `{name}` |"))
            cells = [cell.strip() for cell in row.strip("|").split("|")]
            assert cells[2:5] == [str(variable.dtype), variable.attrs["units"], variable.attrs["long_name"]]
            assert int(cells[5]) == variable.nbytes
        for name in ("u", "particle_id"):  # lazy, chunked by pair, compressed
            encoding = truth[name].encoding
            assert encoding["chunksizes"] == (1, 80, 96) and encoding["zlib"]
    assert "Licence of this data: CC-BY-4.0." in card and "tiny" in card


def test_whoever_renders_chooses_the_licence(tmp_path):
    tables = synth.load_scene("sand_rotation", quick=True).to_dict()
    scene = parse_scene({**tables, "data_licence": "LicenseRef-our-lab-only"})
    with synth.render(synth.simulate(scene), scene, tmp_path / "footage") as footage:
        assert footage.attributes["license"] == "LicenseRef-our-lab-only"
    assert "Licence of this data: LicenseRef-our-lab-only." in (tmp_path / "footage/README.md").read_text()
    with pytest.raises(synth.SceneError, match="data_licence = "):
        parse_scene({**tables, "data_licence": "two\nlines"})


def test_checksums_are_those_of_common_tools(finished_run):
    command = ["sha256sum", "--check", "--strict", "SHA256SUMS"]
    if shutil.which("sha256sum") is None:
        pytest.skip("no sha256sum on this machine")
    assert subprocess.run(command, cwd=finished_run / "footage", capture_output=True).returncode == 0
