import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from synth.devices import cache_folder
from synth.scene_files import scene_names, scenes_folder
from validation.published import REFERENCE_FOLDER

ROOT = Path(__file__).parents[2]
SMALL = """
schema_version = 1
name = "small"
base = "sand_rotation"
[camera]
width = 128
height = 96
[timing]
frame_count = 3
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    options = ["--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check", "--quiet"]
    subprocess.run([sys.executable, "-m", "pip", "wheel", *options, "-w", folder, ROOT], check=True)
    return next(folder.glob("softbed-*.whl"))


def test_wheel_carries_its_data(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    shipped = {path.relative_to(scenes_folder()).as_posix() for path in scenes_folder().rglob("*.toml")}
    assert {f"synth/scenes/{name}" for name in shipped} <= names
    assert {f"validation/reference/{path.name}" for path in REFERENCE_FOLDER.glob("*.csv")} <= names
    assert {"validation/templates/report.html.j2", "soft/py.typed"} <= names
    assert not [name for name in names if name.startswith(("tests", "scenes"))]


def test_wheel_does_the_main_job_outside_the_checkout(wheel, tmp_path):
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    (tmp_path / "small.toml").write_text(SMALL)
    code = (
        "import synth; print(synth.__file__, *synth.scene_names()); from validation.cli import main; main()"
    )
    found = subprocess.run(
        [sys.executable, "-c", code, "run", "small.toml", "out", "--method", "dis"],
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path / "site"), "PATH": "", "SOFTBED_CACHE": str(cache_folder())},
    )
    place, *names = found.stdout.splitlines()[0].split()
    assert place.startswith(str(tmp_path))
    assert names == scene_names()
    assert "<html" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_constraints_are_names_and_versions_only():
    for line in (ROOT / "constraints.txt").read_text().splitlines():
        assert line.startswith("#") or (line.count("==") == 1 and "/" not in line and " " not in line)
