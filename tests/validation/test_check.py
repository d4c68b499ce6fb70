"""Every kind of damage is found and named."""

import json
import shutil

import cv2
import h5py
import numpy as np
import pytest


@pytest.fixture
def run(finished_run, tmp_path):
    return shutil.copytree(finished_run, tmp_path / "run")


@pytest.fixture
def footage(finished_run, tmp_path):
    return shutil.copytree(finished_run / "footage", tmp_path / "footage")


def faults(softbed, folder):
    """Faults by file."""
    status, output, _ = softbed("check", folder, "--json")
    document = json.loads(output)
    assert document["schema_version"] == 1
    assert status == (0 if document["passed"] else 1)
    return {fault["file"]: fault["fault"] for fault in document["faults"]}


def cut(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def edit_truth(path):
    with h5py.File(path, "r+") as file:
        file["u"][0, 5, 7] += 0.25


def edit_pixel(path):
    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    picture[3, 4] ^= 1
    cv2.imwrite(str(path), picture)


def test_what_is_whole_is_whole(softbed, finished_run):
    assert faults(softbed, finished_run) == {}
    assert faults(softbed, finished_run / "footage") == {}
    status, output, _ = softbed("check", finished_run)
    assert status == 0 and "13 files: whole" in output


def test_a_person_reads_what_is_wrong(softbed, footage):
    (footage / "frames/000001.png").unlink()
    status, output, _ = softbed("check", footage)
    assert status == 1
    assert "frames/000001.png: missing" in output and "5 files: 1 fault" in output


@pytest.mark.parametrize(
    ("name", "harm", "says"),
    [
        ("frames/000001.png", lambda path: path.unlink(), "missing"),
        ("frames/000001.png", cut, "not readable"),
        ("frames/000001.png", lambda path: path.write_bytes(b""), "empty"),
        ("frames/000000.png", edit_pixel, "edited"),
        ("truth.nc", cut, "not readable"),
        ("truth.nc", edit_truth, "edited"),
        ("truth.nc", lambda path: path.unlink(), "missing"),
        (
            "sequence.toml",
            lambda path: path.write_text(path.read_text().replace("0.0002", "0.0003")),
            "edited",
        ),
        ("README.md", lambda path: path.write_text("mine"), "edited"),
    ],
)
def test_damage_is_named_in_a_run_and_in_footage(softbed, run, footage, name, harm, says):
    harm(run / "footage" / name)
    harm(footage / name)
    found = faults(softbed, run)
    assert says in found.pop(f"footage/{name}")
    # A run may name what does not work because of it, too, but nothing else.
    assert set(found) <= {"footage"}
    found = faults(softbed, footage)
    assert set(found) == {name} and says in found[name]


@pytest.mark.parametrize(
    ("name", "harm", "says"),
    [
        ("recording.nc", cut, "not readable"),
        ("analysis/dis.nc", cut, "not readable"),
        ("scores.json", lambda path: path.write_text(path.read_text().replace("0.", "1.", 1)), "edited"),
        ("report.html", lambda path: path.unlink(), "missing"),
        ("scene.toml", lambda path: path.write_text(path.read_text() + "\n"), "edited"),
        ("manifest.json", cut, "not a manifest"),
    ],
)
def test_damage_of_a_runs_own_files_is_named(softbed, run, name, harm, says):
    harm(run / name)
    found = faults(softbed, run)
    assert says in found[name]
    assert set(found) == {name}


def with_hashes_made_good(run, *names):
    """Write the manifest anew, as whoever edits a file on purpose would."""
    import hashlib

    manifest = json.loads((run / "manifest.json").read_text())
    for name in names:
        manifest["files"][name] = hashlib.sha256((run / name).read_bytes()).hexdigest()
    (run / "manifest.json").write_text(json.dumps(manifest))


def test_the_form_is_checked_besides_the_hashes(softbed, run):
    with h5py.File(run / "footage" / "truth.nc", "r+") as file:
        file["u"].attrs["units"] = "m"
    text = (run / "scene.toml").read_text()
    (run / "scene.toml").write_text(text.replace("0.02944", "0.03944"))
    with h5py.File(run / "analysis" / "dis.nc", "r+") as file:
        del file["valid"]
    (run / "scores.json").write_text('{"schema_version": 1}')
    names = ("footage/truth.nc", "scene.toml", "analysis/dis.nc", "scores.json")
    with_hashes_made_good(run, *names)
    found = faults(softbed, run)
    assert found["footage"] == "truth.nc: variable u: units m: must be px"
    assert "another hash" in found["scene.toml"]
    assert "valid is missing" in found["analysis/dis.nc"]
    assert "not scores" in found["scores.json"]
    assert len(found) == 4


def test_a_wrong_picture_is_found_without_checksums(softbed, footage):
    (footage / "SHA256SUMS").unlink()
    status, output, _ = softbed("check", footage)
    assert status == 0 and "no SHA256SUMS" in output
    cv2.imwrite(str(footage / "frames/000001.png"), np.zeros((7, 9), np.uint8))
    assert "9 x 7 px" in faults(softbed, footage)["."]


def test_strangers_are_remarked_and_no_fault(softbed, run):
    (run / "notes.txt").write_text("mine")
    status, output, _ = softbed("check", run)
    assert status == 0 and "notes.txt: not of this run" in output


def test_checksums_that_are_none_are_named(softbed, footage):
    (footage / "SHA256SUMS").write_text("nonsense\n")
    assert "line 1" in faults(softbed, footage)["SHA256SUMS"]


@pytest.mark.parametrize("folder", [".", "nowhere"])
def test_other_folders_are_bad_input(softbed, tmp_path, folder):
    status, _, error = softbed("check", tmp_path / folder)
    assert status == 2
    assert error.splitlines()[-1].startswith("softbed: ") and "manifest.json" in error


@pytest.mark.parametrize(
    ("folder", "says"),
    [("nowhere", "no such folder: needed is one with {} or {}"), (".", "holds neither {} nor {}")],
)
def test_what_a_folder_lacks_is_one_sentence(softbed, tmp_path, folder, says):
    _, _, error = softbed("check", tmp_path / folder)
    told = says.format("manifest.json (a run folder or a data set)", "sequence.toml (footage)")
    assert error.splitlines()[-1] == f"softbed: {tmp_path / folder}: {told}"
