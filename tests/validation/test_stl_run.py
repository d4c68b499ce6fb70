"""A scene with an STL goes through the chain, and its run folder needs the file no more."""

import tomllib

import numpy as np
import pytest
import tomli_w
import trimesh
import xarray as xr


@pytest.fixture
def blade_scene(tmp_path, tiny_wheel_scene):
    """A plate of 3 mm x 30 mm, upright, cut out of a body in mm; its lower left corner is driven."""
    trimesh.creation.box(bounds=[[0, 0, 0], [3, 50, 30]]).export(tmp_path / "blade.stl")
    tables = tomllib.loads(tiny_wheel_scene.read_text())
    tables["implement"] = {"kind": "stl", "file": "blade.stl", "scale": 1e-3, "slice": 0.02, "width": 0.05}
    tables["drive"] = {"kind": "cutting", "speed": 0.01, "depth": 0.01, "start": 0.05, "run_in": 0.02}
    tables["camera"] |= {"follows": "bin", "centre_x": 0.075, "centre_z": 0.03, "height": 240}
    path = tmp_path / "blade.toml"
    path.write_text(tomli_w.dumps(tables))
    return path


def test_pictures_and_truth_show_the_section_and_its_motion(softbed, blade_scene, tmp_path):
    out = tmp_path / "out"
    status, _, error = softbed("simulate", blade_scene, out)
    assert status == 0, error
    (tmp_path / "blade.stl").unlink()
    status, _, error = softbed("render", out)
    assert status == 0, error
    status, _, error = softbed("export", out)
    assert status == 0, error
    with xr.open_dataset(out / "footage" / "truth.nc", engine="h5netcdf") as truth:
        pair = truth.isel(pair=0)
        implement, u, v = (pair[name].values for name in ("implement", "u", "v"))
        ahead = pair["soil"].values & (pair["distance_to_implement"].values < 10)
    pixel, rate = 0.2e-3, 8.0
    assert implement.sum() == pytest.approx(3e-3 * 30e-3 / pixel**2, rel=0.02)
    rows, columns = np.nonzero(implement)
    assert (np.ptp(rows) + 1, np.ptp(columns) + 1) == pytest.approx((150, 15), abs=1)
    np.testing.assert_allclose(u[implement], 0.01 / rate / pixel, rtol=1e-3)  # +x is right, and forward
    np.testing.assert_allclose(v[implement], 0, atol=1e-3)
    ahead[:, : columns.max()] = False
    assert np.nanmean(u[ahead]) > 1
    status, _, error = softbed("simulate", blade_scene, tmp_path / "again")
    assert status == 2 and "implement.file = 'blade.stl': no such file" in error
