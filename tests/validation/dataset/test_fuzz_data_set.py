"""What a data set that somebody sent holds is refused in words, and leads to no file outside of it."""

import csv
import io
import json
import shutil

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synth.dataset import DataSetError, load_data_set
from synth.dataset.folder import DataSetFolder
from synth.dataset.summary import read_facts
from synth.footage import Footage
from validation.check import check_folder

WORDS = st.text(st.characters(exclude_categories=["Cs"]), max_size=6)
VALUES = st.none() | st.booleans() | st.integers(-(2**70), 2**70) | st.floats() | WORDS
VALUES = st.recursive(VALUES, lambda v: st.lists(v, max_size=3) | st.dictionaries(WORDS, v, max_size=2))
ODD = st.sampled_from(["", "../../x", "/etc", "-1", "0", "1e9", "x", "made", "\0", '"', "9" * 400]) | WORDS


@pytest.fixture(scope="module")
def given_set(sand_set, tmp_path_factory):
    """A copy that every test leaves as it was."""
    return shutil.copytree(sand_set, tmp_path_factory.mktemp("given") / "sand")


def read_with(folder, path, content):
    """Load a data set with another content of one of its files."""
    before = path.read_bytes()
    try:
        path.write_bytes(content)
        data = load_data_set(folder)
        for sequence in data.sequences:
            assert sequence.folder.parent == folder / "sequences"
            if sequence.folder.is_dir() and sequence.pair_count < 10:
                sequence.pair(sequence.pair_count - 1)
                read_facts(DataSetFolder(folder), sequence.name)
    except DataSetError as error:
        assert str(folder) in str(error) and "\n" not in str(error).strip()
    finally:
        path.write_bytes(before)


@given(st.data())
@settings(max_examples=40)
def test_manifests_and_facts(given_set, data):
    path = data.draw(
        st.sampled_from([given_set / "manifest.json", *given_set.glob("sequences/*/facts.json")])
    )
    tables = json.loads(path.read_text())
    key = data.draw(st.sampled_from(sorted(tables)))
    tables[key] = data.draw(VALUES)
    if data.draw(st.booleans()):
        del tables[key]
    read_with(given_set, path, json.dumps(data.draw(VALUES) if key == "kind" else tables).encode())


@given(st.integers(0, 1), st.integers(0, 11), ODD, st.sampled_from(["cell", "header", "short"]))
@settings(max_examples=40)
def test_members(given_set, line, column, value, kind):
    path = given_set / "members.csv"
    rows = list(csv.reader(io.StringIO(path.read_text())))
    chosen = rows[0] if kind == "header" else rows[1 + line]
    if kind == "short":
        del chosen[column % len(chosen) :]
    else:
        chosen[column % len(chosen)] = value
    text = io.StringIO()
    csv.writer(text).writerows(rows)
    read_with(given_set, path, text.getvalue().encode())


@given(st.data())
@settings(max_examples=20)
def test_truth_and_pictures(given_set, data):
    path = data.draw(
        st.sampled_from(sorted([*given_set.glob("sequences/*/truth.nc"), *given_set.rglob("*.png")]))
    )
    content = path.read_bytes()
    read_with(given_set, path, content[: data.draw(st.integers(0, len(content) - 1))])


@pytest.mark.parametrize("name", ["../../outside", "/tmp/outside", "a/../../b"])
def test_names_do_not_lead_outside(softbed, given_set, tmp_path, name):
    data = shutil.copytree(given_set, tmp_path / "inner" / "data")
    first = sorted(path.name for path in (data / "sequences").iterdir())[0]
    sums = data / "SHA256SUMS"
    sums.write_text(sums.read_text().replace(f"  sequences/{first}/frames/", f"  {name}/"))
    assert any("not inside the folder" in fault.fault for fault in check_folder(data).faults)
    members = data / "members.csv"
    members.write_text(members.read_text().replace(first, name))
    status, _, error = softbed("export", data, "--format", "sintel", "--out", tmp_path / "inner" / "out")
    assert status == 2 and f"name = {name!r}" in error
    frames = data / "sequences" / first / "sequence.toml"
    frames.write_text(frames.read_text().replace("frames/000001.png", f"{name}.png"))
    with pytest.raises(ValueError, match="must lie inside the folder"):
        Footage.open(frames.parent)
    assert {path.name for path in tmp_path.iterdir()} == {"inner"}
    assert {path.name for path in (tmp_path / "inner").iterdir()} == {"data"}


def test_a_damaged_data_set_is_checked_to_the_end(given_set, tmp_path):
    data = shutil.copytree(given_set, tmp_path / "data")
    (data / "failures.csv").write_bytes(b"name\n\xff")
    next(data.glob("sequences/*/facts.json")).write_text("[]")
    (data / "SHA256SUMS").unlink()
    findings = check_folder(data)
    assert any("not what is known of a sequence" in fault.fault for fault in findings.faults)
    assert any("not a table of failures" in remark for remark in findings.remarks)
