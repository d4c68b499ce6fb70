import hashlib

import numpy as np
import pytest

from synth import Footage, render
from synth.devices import thread_count
from synth.truth import VARIABLES, true_motion


def digest(footage):
    values = hashlib.sha256()
    for frame in range(footage.frame_count):
        values.update(footage.picture(frame).tobytes())
    for pair in range(footage.pair_count):
        truth = footage.truth(pair)
        for name in VARIABLES:
            values.update(truth[name].values.tobytes())
    return values.hexdigest()


def test_the_same_bytes_with_one_thread_with_more_and_again(
    taichi, cases, rendered_on_one_thread, render_apart, tmp_path
):
    def rendered_here(folder):
        case = cases.swirl()
        render(case.recording, case.scene, folder).close()
        return folder

    several = rendered_here if thread_count() > 1 else lambda folder: render_apart(folder, 2)
    digests = []
    for out in (rendered_on_one_thread, several(tmp_path / "several"), rendered_here(tmp_path / "again")):
        with Footage.open(out) as footage:
            digests.append(digest(footage))
            assert (footage.truth(0).implement.values.any(), footage.pair_count) == (True, 2)
    assert digests[0] == digests[1] == digests[2]


@pytest.fixture(scope="module")
def turning(cases, fields):
    return cases.case(fields["rotation"](0.02), frames=3, sensor={"bits": 16})


@pytest.fixture(scope="module")
def footage(turning, tmp_path_factory):
    calls = []
    folder = tmp_path_factory.mktemp("footage") / "new"
    with render(turning.recording, turning.scene, folder, progress=lambda *x: calls.append(x)) as footage:
        assert calls == [(1, 3), (2, 3), (3, 3)]
        yield footage


def test_footage_holds_every_frame_and_pair(footage, cases):
    assert (footage.frame_count, footage.pair_count) == (3, 2)
    assert footage.metres_per_pixel == cases.pixel
    assert footage.picture(2).shape == cases.size
    assert footage.picture(2).dtype == np.uint16
    assert footage.picture(2).std() > 2000


def test_the_file_holds_the_truth_of_the_recording(footage, turning):
    expected = true_motion(turning.recording, turning.scene, 1, 2)
    stored = footage.truth(1)
    for name, (dtype, unit, _) in VARIABLES.items():
        assert stored[name].dtype == dtype, name
        assert stored[name].attrs["units"] == unit
        assert stored[name].attrs["long_name"]
        assert np.array_equal(stored[name], expected[name], equal_nan=dtype == "float32"), name
    for name in ("first_frame", "second_frame", "time"):
        assert float(stored[name]) == float(expected[name])
    assert stored.attrs["scene_hash"] == turning.scene.hash


@pytest.mark.parametrize("key", ["seed", "picture_seed"])
def test_another_seed_is_another_texture_and_the_same_motion(footage, turning, tmp_path, key):
    scene = turning.scene.model_copy(update={key: 9})
    with render(turning.recording, scene, tmp_path / "other") as other:
        assert not np.array_equal(other.picture(0), footage.picture(0))
        assert np.abs(other.truth(0).u - footage.truth(0).u).max() < 1e-4


def test_a_folder_that_holds_something_is_refused(turning, tmp_path):
    (tmp_path / "precious.txt").write_text("mine")
    with pytest.raises(ValueError, match="an empty folder is needed"):
        render(turning.recording, turning.scene, tmp_path)


def test_one_lone_frame_is_refused(cases, fields, tmp_path):
    case = cases.case(fields["rest"], frames=1)
    with pytest.raises(ValueError, match="frame_count = 1: two frames are needed"):
        render(case.recording, case.scene, tmp_path)
