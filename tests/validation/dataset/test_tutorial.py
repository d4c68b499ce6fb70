"""The sweep file that docs/datasets.md shows is what the page says; tests/documents runs the rest of it."""

import re
from pathlib import Path

from synth.dataset.members import members_of
from synth.dataset.sweep import load_sweep

PAGE = (Path(__file__).parents[3] / "docs" / "datasets.md").read_text(encoding="utf-8")


def test_the_sweep_file_is_one(tmp_path):
    (block,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "wheels.toml").write_text(block)
    found = members_of(*load_sweep(tmp_path / "wheels.toml"))
    assert len(found.members) == 64 and not found.impossible
    seeds = {member.scene.seed for member in found.members}
    assert seeds == set(range(8))  # "eight beds": of each density
    assert len({member.bed for member in found.members}) == 8 * 3
