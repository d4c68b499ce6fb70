"""What docs/datasets.md shows is run as it stands, on a data set of sand instead of wheels."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from synth.dataset.members import members_of
from synth.dataset.sweep import load_sweep

PAGE = (Path(__file__).parents[3] / "docs" / "datasets.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", PAGE, re.DOTALL)
COMMANDS = [
    line.partition("#")[0].split()
    for kind, block in BLOCKS
    for line in block.splitlines()
    if kind == "sh" and line.startswith("softbed")
]
PROGRAMS = [block for kind, block in BLOCKS if kind == "python" and "SLURM" not in block]


@pytest.fixture
def place(sand_sweep, sand_set, tmp_path, monkeypatch):
    """A folder with `wheels.toml` and the data set `wheels`."""
    shutil.copy(sand_sweep, tmp_path / "wheels.toml")
    shutil.copytree(sand_set, tmp_path / "wheels")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_sweep_file_is_one(tmp_path):
    (block,) = (block for kind, block in BLOCKS if kind == "toml")
    (tmp_path / "wheels.toml").write_text(block)
    found = members_of(*load_sweep(tmp_path / "wheels.toml"))
    assert len(found.members) == 64 and not found.impossible
    seeds = {member.scene.seed for member in found.members}
    assert seeds == set(range(8))  # "eight beds": of each density
    assert len({member.bed for member in found.members}) == 8 * 3


def test_every_command_runs(softbed, place):
    assert len(COMMANDS) == 6
    for name, *arguments in COMMANDS:
        if "--scheduler" not in arguments:  # which has a test of its own
            status, _, error = softbed(*arguments)
            assert status == 0, (name, arguments, error)
    assert {path.name for path in (place / "wheels-kitti").iterdir()} == {"train", "test"}


@pytest.mark.parametrize("program", PROGRAMS)
def test_every_program_runs(program, place):
    if "torch" in program:
        pytest.importorskip("torch")
        program = f"if __name__ == '__main__':\n{re.sub('^', '    ', program, flags=re.MULTILINE)}"
    path = place / "program.py"
    path.write_text(program)
    done = subprocess.run([sys.executable, path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
