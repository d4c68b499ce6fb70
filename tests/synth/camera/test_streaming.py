"""A recording of any length is photographed frame by frame: it is never whole in memory."""

import numpy as np
import pytest
import xarray as xr

from synth import Recording, render
from synth.recording import VARIABLES

OF_PARTICLES = [name for name, (dims, _, _) in VARIABLES.items() if dims == ("frame", "particle")]


@pytest.fixture
def case(cases, fields):
    return lambda **tables: cases.case(fields["rotation"](0.02), frames=4, **tables)


@pytest.mark.parametrize("tables", [{}, {"nuisance": {"exposure": 0.5}}, {"texture": {"motion": "carried"}}])
def test_pictures_of_a_recording_on_disk_are_those_of_one_in_memory(case, tmp_path, tables):
    case = case(**tables)
    case.recording.write(tmp_path / "recording.nc")
    with Recording.open(tmp_path / "recording.nc") as streamed:
        folders = []
        for name, recording in (("streamed", streamed), ("whole", case.recording)):
            folders.append(tmp_path / name)
            render(recording, case.scene, folders[-1]).close()
        assert not any(streamed.data[name].variable._in_memory for name in OF_PARTICLES)
    one, other = (sorted((folder / "frames").iterdir()) for folder in folders)
    assert [path.read_bytes() for path in one] == [path.read_bytes() for path in other]
    with xr.open_dataset(folders[0] / "truth.nc") as truth, xr.open_dataset(folders[1] / "truth.nc") as same:
        assert truth.identical(same)


def test_a_frame_is_a_chunk(case, tmp_path):
    recording = case().recording
    recording.write(tmp_path / "recording.nc")
    with xr.open_dataset(tmp_path / "recording.nc", engine="h5netcdf") as data:
        assert data["position_x"].encoding["chunksizes"] == (1, recording.data.sizes["particle"])
    with Recording.open(tmp_path / "recording.nc") as streamed:
        assert np.array_equal(streamed.states("angle", 2), recording.data["angle"].values[2])
        assert streamed.digest == recording.digest


def test_what_is_no_recording_is_refused(tmp_path):
    (tmp_path / "recording.nc").write_bytes(b"nothing")
    with (
        pytest.raises(ValueError, match=r"recording\.nc: not a recording"),
        Recording.open(tmp_path / "recording.nc"),
    ):
        pass
