"""What is exported comes back with the same values."""

import base64
import json
import shutil
import subprocess
import zlib
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
import xarray as xr

import soft
import synth
from synth.scene import parse_scene
from validation.cli import run_command
from validation.exchange import FORMATS, Field, write_fields

METHODS = ("dis", "farneback")


@pytest.fixture(scope="module")
def exported(finished_run, tmp_path_factory):
    """A copy of the finished run with every format."""
    out = tmp_path_factory.mktemp("exported") / "run"
    shutil.copytree(finished_run, out)
    for file_format in (*FORMATS, "mp4"):
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


def test_films_show_each_method(exported):
    assert {path.name for path in (exported / "mp4").iterdir()} == {f"{name}.mp4" for name in METHODS}
    video = cv2.VideoCapture(str(exported / "mp4" / "dis.mp4"))
    assert int(video.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little") == b"VP90"
    assert video.read()[0] and not video.read()[0], "one pair, one picture"


def test_pictures_that_nobody_measured_make_a_film_of_the_truth(softbed, finished_run, tmp_path):
    footage = tmp_path / "footage"
    shutil.copytree(finished_run / "footage", footage)
    assert softbed("export", footage, "--format", "mp4", "--out", tmp_path / "out")[0] == 0
    (film,) = (tmp_path / "out" / "mp4").iterdir()
    assert film.name == "truth.mp4"
    read, picture = cv2.VideoCapture(str(film)).read()
    assert read and picture.std() > 20


@pytest.mark.parametrize("name", ["truth", *METHODS])
def test_grid_comes_back_exactly(exported, name):
    grid = soft.flow.FlowFiles(exported / "grid" / name).read(0, (80, 96))
    true = expected(exported, name)[8::16, 8::16]
    np.testing.assert_array_equal(grid.displacement[8::16, 8::16], true)
    assert grid.valid.sum() == np.isfinite(true[..., 0]).sum()
    lines = (exported / "grid" / name / "000000.csv").read_text().splitlines()
    assert lines[0] == "x [px],y [px],u [px],v [px],flags"
    assert len(lines) == 1 + 5 * 6, "nodes without motion are there, too"
    for line in lines[1:]:
        x, y, u, v, flags = line.split(",")
        known = np.isfinite(expected(exported, name)[int(y), int(x), 0])
        assert (flags, u == "nan", v == "nan") == (("0", False, False) if known else ("1", True, True))


def test_a_method_s_own_grid_is_exported_at_its_nodes(tmp_path):
    node = np.full((1, 4, 6), np.nan)
    node[0, 1, 2], node[0, 3, 4] = 2.25, 4.5
    u = np.where(np.isfinite(node), 1.5, np.nan)
    u[0, 3, 4] = np.nan
    names = {"u": u, "v": -u, "valid": np.isfinite(u), "node_x": node, "node_y": node - 1}
    data = xr.Dataset({name: (("pair", "y", "x"), values) for name, values in names.items()})
    write_fields([Field("piv", data)], None, "grid", tmp_path)
    rows = (tmp_path / "piv" / "000000.csv").read_text().splitlines()[1:]
    assert rows == ["2.25,1.25,1.5,-1.5,0", "4.5,3.5,nan,nan,1"]


def test_fewer_pixels_by_stride(softbed, finished_run, tmp_path):
    out = tmp_path / "run"
    shutil.copytree(finished_run, out)
    assert softbed("export", out, "--format", "csv", "--stride", 5)[0] == 0
    x, y, u, v = np.loadtxt(out / "csv" / "dis" / "000000.csv", delimiter=",", skiprows=1).T
    assert set(x % 5) == set(y % 5) == {2}
    true = expected(out, "dis")[y.astype(int), x.astype(int)]
    np.testing.assert_array_equal(np.stack([u, v], -1).astype(np.float32), true)
    status, _, error = softbed("export", out, "--format", "flo", "--stride", 5)
    assert status == 2 and "--stride: flo has every pixel: only for csv, grid" in error


def read_image(path):
    """Arrays of a `.vti` by name, and its spacing, by the rules of VTK's format."""
    root = ElementTree.parse(path).getroot()
    image = root.find("ImageData")
    _, right, _, top, _, _ = (int(number) for number in image.get("WholeExtent").split())
    arrays = {}
    for array in root.iter("DataArray"):
        header = np.frombuffer(base64.b64decode(array.text[:44]), "<u8")
        assert header[0] == 1 and header[2] == 0
        content = zlib.decompress(base64.b64decode(array.text[44:]))
        assert len(content) == header[1] and len(base64.b64decode(array.text[44:])) == header[3]
        form = {"Float32": "<f4", "UInt8": "u1"}[array.get("type")]
        shape = (top + 1, right + 1, int(array.get("NumberOfComponents")))
        arrays[array.get("Name")] = np.frombuffer(content, form).reshape(shape)
    return arrays, [float(number) for number in image.get("Spacing").split()]


@pytest.mark.parametrize("name", ["truth", *METHODS])
def test_vti_comes_back_exactly_with_up_upwards(exported, name):
    arrays, spacing = read_image(exported / "vti" / name / "000000.vti")
    true = expected(exported, name)[::-1]
    np.testing.assert_array_equal(arrays["displacement"][..., 0], true[..., 0])
    np.testing.assert_array_equal(arrays["displacement"][..., 1], -true[..., 1])
    np.testing.assert_array_equal(arrays["valid"][..., 0], np.isfinite(true[..., 0]))
    assert spacing[0] == soft.ImageSequence.open(exported / "footage").metres_per_pixel
    series = ElementTree.parse(exported / "vti" / f"{name}.pvd").getroot()
    assert [part.get("file") for part in series.iter("DataSet")] == [f"{name}/000000.vti"]


def test_vtk_itself_reads_the_same(exported):
    vtk = pytest.importorskip("vtk", reason="the toolkit of ParaView is not installed")
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkXMLImageDataReader()
    reader.SetFileName(str(exported / "vti" / "dis" / "000000.vti"))
    reader.Update()
    image = reader.GetOutput()
    assert image.GetDimensions() == (96, 80, 1)
    values = vtk_to_numpy(image.GetPointData().GetArray("displacement")).reshape(80, 96, 3)
    true = expected(exported, "dis")
    np.testing.assert_array_equal(values[::-1, :, :2] * [1, -1], true)


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
