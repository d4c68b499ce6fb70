"""A full disk is an error that names the file, and never the end of the process."""

import numpy as np
import pytest

from synth.disk import naming, require_space, system_complaint, written_whole
from synth.recording import VARIABLES, Recording
from synth.scene import load_scene
from synth.truth import CAMERA_VARIABLES, PairTruth
from synth.truth import VARIABLES as TRUTH
from synth.truth_file import TruthWriter

HDF5 = (
    "Can't close file (file write failed: time = Thu\n, filename = 'a/truth.nc', file descriptor = 18, "
    "errno = 28, error message = 'No space left on device', buf = 0x7e, total write size = 2048)"
)


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (OSError(28, HDF5), "a/truth.nc: No space left on device"),
        (RuntimeError(HDF5), "a/truth.nc: No space left on device"),
        (RuntimeError("errno = 122, error message = 'quota'"), "Disk quota exceeded"),
        (FileNotFoundError(2, "No such file or directory", "b"), "b: No such file or directory"),
        (OSError(5, "Input/output error"), "Input/output error"),
        (OSError("in words alone"), None),
        (ValueError("no"), None),
    ],
)
def test_what_the_system_says_is_one_line(error, line):
    assert system_complaint(error) == line


def test_a_file_changes_when_all_of_it_is_written(tmp_path):
    path = tmp_path / "new" / "a.txt"
    for text in ("first", "second"):
        with written_whole(path) as draft:
            draft.write_text(text)
            assert (draft.parent, draft.suffix) == (path.parent, path.suffix)
            assert not path.exists() or path.read_text() == "first"
        assert path.read_text() == text
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize("end", [KeyboardInterrupt, OSError(28, "No space left on device")])
def test_what_is_not_written_to_the_end_leaves_the_file_as_it_was(tmp_path, end):
    path, draft = tmp_path / "a.txt", tmp_path / "work" / "a.new"
    path.write_text("before")
    with pytest.raises(BaseException) as raised, written_whole(path, draft=draft) as told:
        assert told == draft
        draft.write_text("half")
        raise end
    assert path.read_text() == "before" and not draft.exists()
    assert not isinstance(raised.value, OSError) or raised.value.filename == str(path)


def test_what_cannot_be_begun_is_told_of_the_file_and_not_of_its_draft(tmp_path):
    path = tmp_path / "a.txt"
    with pytest.raises(FileNotFoundError) as raised, written_whole(path):
        pass  # nothing is written
    assert raised.value.filename == str(path)
    with pytest.raises(FileNotFoundError) as raised, written_whole(path):
        (tmp_path / "other").read_text()
    assert raised.value.filename == str(tmp_path / "other")


def test_the_file_that_is_written_is_named(tmp_path):
    with pytest.raises(OSError, match="No space") as raised, naming(tmp_path / "a"):
        raise OSError(28, "No space left on device")
    assert raised.value.filename == str(tmp_path / "a")


def test_truth_that_does_not_fit_is_refused(small_disk):
    disk, _ = small_disk(2000)
    scene = load_scene("plate_rotation", quick=True)
    shape, rng = (scene.camera.height, scene.camera.width), np.random.default_rng(0)
    arrays = {name: rng.random(shape, np.float32) for name in TRUTH}
    camera = dict.fromkeys(CAMERA_VARIABLES, 0.0)
    with (
        TruthWriter(disk / "truth.nc", scene, np.arange(4) / 8) as writer,
        pytest.raises(OSError, match="No space left on device") as raised,
    ):
        for pair in range(3):
            writer.write(pair, PairTruth(pair, pair + 1, arrays, camera))
    assert raised.value.filename == str(disk / "truth.nc")
    require_space(disk / "more", 0)  # closing it had room, and took little


def test_a_recording_that_does_not_fit_is_refused(small_disk):
    disk, enlarge = small_disk(400)
    sizes = {"frame": 3, "particle": 5000, "sample": 1}
    arrays = {name: np.zeros([sizes[d] for d in dims]) for name, (dims, _, _) in VARIABLES.items()}
    recording = Recording.from_arrays(arrays, {})
    with pytest.raises(OSError, match="No space left on device"):
        recording.write(disk / "recording.nc")
    assert not any(disk.iterdir())
    enlarge()
    recording.write(disk / "recording.nc")
