import json
import os
import signal
import subprocess
import sys
import textwrap

import pytest

from validation.manifest import Manifest, RunFolderError, file_digest
from validation.run_folder import PARTIAL_PREFIX, RunFolder


def write_step(run, *, step="simulate", key="key", text="recorded", name="recording.nc"):
    with run.writing(step, key) as draft:
        path = draft.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def partials(folder):
    return [path.name for path in folder.iterdir() if path.name.startswith(PARTIAL_PREFIX)]


def test_a_new_folder_says_what_it_is(tmp_path):
    with RunFolder.create(tmp_path / "a" / "out") as run:
        write_step(run)
    manifest = json.loads((tmp_path / "a" / "out" / "manifest.json").read_text())
    assert manifest["schema_version"] == 1
    assert manifest["files"] == {"recording.nc": file_digest(run.recording)}
    assert manifest["steps"]["simulate"]["key"] == "key"
    assert manifest["versions"]["numpy"] and manifest["machine"]["cores"] >= 1


def test_what_is_there_and_whole_need_not_be_done(tmp_path):
    with RunFolder.create(tmp_path / "out") as run:
        assert run.why_do("simulate", "key") == "not done yet"
        write_step(run)
    with RunFolder.open(tmp_path / "out") as run:
        assert run.why_do("simulate", "key") is None
        assert "changed" in run.why_do("simulate", "another key")


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda path: path.unlink(), "recording.nc is missing"),
        (lambda path: path.write_text("record"), "recording.nc is damaged"),
        (lambda path: path.write_text("Recorded"), "recording.nc is damaged"),
    ],
    ids=["missing", "truncated", "changed"],
)
def test_damage_is_seen(tmp_path, damage, words):
    with RunFolder.create(tmp_path / "out") as run:
        write_step(run)
        damage(run.recording)
        assert words in run.why_do("simulate", "key")


def test_a_failure_leaves_the_former_result(tmp_path):
    with RunFolder.create(tmp_path / "out") as run:
        write_step(run, name="footage/frames/0.png", text="old")
        with pytest.raises(KeyboardInterrupt), run.writing("simulate", "new") as draft:
            (draft.folder / "footage").mkdir()
            (draft.folder / "footage" / "half").write_text("half")
            raise KeyboardInterrupt
        assert (run.footage / "frames" / "0.png").read_text() == "old"
        assert run.why_do("simulate", "key") is None
        assert not (run.footage / "half").exists()
        assert partials(run.path) == []


def test_a_folder_is_replaced_as_a_whole(tmp_path):
    with RunFolder.create(tmp_path / "out") as run:
        write_step(run, name="footage/frames/9.png")
        write_step(run, name="footage/frames/0.png", key="new")
        assert [path.name for path in (run.footage / "frames").iterdir()] == ["0.png"]
        assert list(run.manifest.files) == ["footage/frames/0.png"]


def test_methods_share_the_analysis_folder(tmp_path):
    with RunFolder.create(tmp_path / "out") as run:
        write_step(run, step="analyze a", name="analysis/a.nc")
        write_step(run, step="analyze b", name="analysis/b.nc")
        assert run.why_do("analyze a", "key") is None
        assert run.why_do("analyze b", "key") is None


def test_a_stranger_s_folder_is_refused_and_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(RunFolderError, match="neither empty nor a run folder"), RunFolder.create(tmp_path):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_stranger_s_manifest_is_refused(tmp_path):
    (tmp_path / "manifest.json").write_text('{"manifest_version": 3, "name": "browser extension"}')
    with pytest.raises(RunFolderError, match="schema_version = None"), RunFolder.create(tmp_path):
        pass
    (tmp_path / "manifest.json").write_text('{"schema_version": 1, "name": "browser extension"}')
    with pytest.raises(RunFolderError, match="not a manifest of this program"), RunFolder.create(tmp_path):
        pass


def test_a_file_or_nothing_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RunFolderError, match="is a file"), RunFolder.create(tmp_path / "file"):
        pass
    with pytest.raises(RunFolderError, match="no such folder"), RunFolder.open(tmp_path / "nothing"):
        pass
    (tmp_path / "empty").mkdir()
    with pytest.raises(RunFolderError, match="not a run folder"), RunFolder.open(tmp_path / "empty"):
        pass


def test_one_process_at_a_time(tmp_path):
    with (
        RunFolder.create(tmp_path / "out"),
        pytest.raises(RunFolderError, match="another softbed"),
        RunFolder.create(tmp_path / "out"),
    ):
        pass


def test_a_killed_run_leaves_nothing_half_written(tmp_path):
    code = textwrap.dedent("""
        import sys, time
        from validation.run_folder import RunFolder
        with RunFolder.create(sys.argv[1]) as run, run.writing("simulate", "key") as draft:
            (draft.folder / "recording.nc").write_text("half")
            print("writing", flush=True)
            time.sleep(60)
    """)
    out = tmp_path / "out"
    process = subprocess.Popen([sys.executable, "-c", code, str(out)], stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"writing\n"
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    process.stdout.close()
    assert not (out / "recording.nc").exists()
    assert partials(out)
    with RunFolder.create(out) as run:
        assert partials(out) == []
        assert run.why_do("simulate", "key") == "not done yet"


def test_manifest_round_trip(tmp_path):
    manifest = Manifest(scene="a", seed=3, files={"a": "b"})
    (tmp_path / "manifest.json").write_text(manifest.to_json())
    assert Manifest.read(tmp_path) == manifest
