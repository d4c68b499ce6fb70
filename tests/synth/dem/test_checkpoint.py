"""A run that goes on from a checkpoint is the run that was never disturbed."""

import shutil
import zipfile

import numpy as np
import pytest

from synth import simulate
from synth.dem import checkpoint
from synth.dem.log import Frame
from synth.scene import parse_scene


class StoppedError(Exception):
    pass


@pytest.fixture(scope="module")
def undisturbed(tiny_recording):
    return tiny_recording


def stop_at(share):
    """Progress that stops the run after this share of its intervals, the bed's progress left out."""

    def progress(done, total):
        if done >= total * (0.4 + 0.6 * share):
            raise StoppedError

    return progress


def interrupted_run(scene, folder, share):
    with pytest.raises(StoppedError):
        simulate(scene, checkpoint=folder, progress=stop_at(share))


@pytest.fixture
def at_every_interval(monkeypatch):
    monkeypatch.setattr(checkpoint, "CHECKPOINT_INTERVAL", 0.0)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.97], ids=["touching down", "running in", "recorded"])
def test_goes_on_as_if_nothing_had_been(tiny_wheel, undisturbed, tmp_path, at_every_interval, share):
    folder, said = tmp_path / "checkpoint", []
    interrupted_run(tiny_wheel, folder, share)
    recording = simulate(tiny_wheel, checkpoint=folder, say=said.append)
    assert recording.digest == undisturbed.digest
    assert recording.data.attrs == undisturbed.data.attrs
    assert len(said) == 1 and said[0].startswith("checkpoint: goes on after ")


def test_is_not_written_before_its_time(tiny_wheel, undisturbed, tmp_path):
    assert simulate(tiny_wheel, checkpoint=tmp_path / "checkpoint").digest == undisturbed.digest
    assert not (tmp_path / "checkpoint").exists()


@pytest.fixture(scope="module")
def late_checkpoint(tiny_wheel, tmp_path_factory):
    """What a run leaves that was stopped near its end; not to be changed."""
    folder = tmp_path_factory.mktemp("stopped") / "checkpoint"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(checkpoint, "CHECKPOINT_INTERVAL", 0.0)
        interrupted_run(tiny_wheel, folder, 0.95)
    return folder


@pytest.fixture
def left_behind(late_checkpoint, tmp_path, at_every_interval):
    """The same, each test's own."""
    return shutil.copytree(late_checkpoint, tmp_path / "checkpoint")


def flip_a_bit(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda folder: flip_a_bit(folder / "state.npz"), "state.npz is damaged"),
        (lambda folder: (folder / "state.npz").write_bytes(b""), "state.npz is damaged"),
        (lambda folder: np.savez(folder / "state.npz", run=np.array("5")), "state.npz is damaged"),
        (lambda folder: flip_a_bit(folder / "frame-000000.npz"), "frame-000000.npz is damaged"),
        (lambda folder: (folder / "frame-000001.npz").unlink(), "frame-000001.npz is missing"),
    ],
    ids=["flipped", "empty", "foreign", "frame flipped", "frame missing"],
)
def test_damage_is_said_and_nothing_of_it_used(tiny_wheel, undisturbed, left_behind, spoil, words):
    spoil(left_behind)
    said = []
    assert simulate(tiny_wheel, checkpoint=left_behind, say=said.append).digest == undisturbed.digest
    assert said == [f"checkpoint: {words}: not used, starting anew"]


def test_of_another_scene_is_said_and_not_used(tiny_wheel, left_behind):
    tables = tiny_wheel.to_dict()
    tables["timing"]["frame_count"] -= 1
    other, said = parse_scene(tables), []
    recording = simulate(other, checkpoint=left_behind, say=said.append)
    assert recording.frame_count == other.timing.frame_count
    assert "of another scene (" in said[0] and "starting anew" in said[0]


def test_of_another_version_is_said_and_not_used(tiny_wheel, left_behind, monkeypatch):
    monkeypatch.setattr(checkpoint, "version", lambda name: "99.0")
    said = []
    interrupted_run_at_once(tiny_wheel, left_behind, said)
    assert "of another program version (" in said[0] and "this is 99.0" in said[0]
    assert not left_behind.exists()


def interrupted_run_at_once(scene, folder, said):
    def progress(done, total):
        raise StoppedError

    with pytest.MonkeyPatch.context() as patch, pytest.raises(StoppedError):
        patch.setattr(checkpoint, "CHECKPOINT_INTERVAL", np.inf)
        simulate(scene, checkpoint=folder, say=said.append, progress=progress)


def test_holds_no_pickle(left_behind):
    for path in left_behind.iterdir():
        with zipfile.ZipFile(path) as archive:
            assert all(name.endswith(".npy") for name in archive.namelist())
        with np.load(path, allow_pickle=False) as stored:
            assert all(stored[name].dtype != object for name in stored.files)


def test_removal_is_whole_and_may_be_repeated(left_behind):
    shutil.copy(left_behind / "state.npz", left_behind / ".partial-1-state.npz")
    for _ in range(2):
        checkpoint.remove_checkpoint(left_behind)
        assert not left_behind.exists()


def test_frame_round_trip(tiny_wheel, left_behind):
    from synth.dem.bed import settled_bed
    from synth.dem.tool import Tool

    grains = settled_bed(tiny_wheel).grains
    tool = Tool(tiny_wheel.implement.shape, x=0.1, z=0.2, heaves=True)
    with np.load(left_behind / "frame-000000.npz") as stored:
        arrays = dict(stored)
    again = Frame.of_arrays(arrays, tool, grains).to_arrays()
    assert set(again) == set(arrays)
    for name, array in arrays.items():
        np.testing.assert_array_equal(again[name], array)
