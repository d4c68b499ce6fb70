"""What tests of every room use."""

import subprocess
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# The same examples in every run: a test that fails has something to say, and says it to everybody.
settings.register_profile(
    "softbed",
    derandomize=True,
    deadline=None,
    database=None,
    max_examples=60,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
)
settings.load_profile("softbed")

SWEEP = """
schema_version = 1
name = "sand"
scene = "sand_rotation"
quick = true
[design]
kind = "grid"
[vary]
"motion.angle" = [0.01, 0.03]
"camera.width" = [96]
"camera.height" = [64]
"timing.frame_count" = [3]
[split]
train = 0.5
validation = 0.0
test = 0.5
"""


@pytest.fixture
def small_disk(tmp_path):
    """Mount a disk of so many kB: where it is, and how to make it larger; skips where none can be mounted."""
    place = tmp_path / "disk"

    def mount(options: str) -> subprocess.CompletedProcess:
        command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", place]
        return subprocess.run(command, capture_output=True, text=True)

    def small(size: int) -> tuple[Path, object]:
        place.mkdir()
        done = mount(f"size={size}k")
        if done.returncode != 0:
            pytest.skip(f"a small disk cannot be mounted here: {done.stderr.strip()}")
        return place, lambda: mount("remount,size=16m")

    yield small
    if place.is_mount():
        subprocess.run(["umount", "--lazy", place], check=True)


@pytest.fixture(scope="session")
def sand_sweep(tmp_path_factory):
    path = tmp_path_factory.mktemp("sweep") / "sand.toml"
    path.write_text(SWEEP)
    return path


@pytest.fixture(scope="session")
def sand_set(sand_sweep, tmp_path_factory):
    """A data set of two sequences, by formula; not to be changed."""
    pytest.importorskip("distributed")
    from validation.cli import run_command

    out = tmp_path_factory.mktemp("sets") / "sand"
    assert run_command(["sweep", str(sand_sweep), str(out), "--workers", "1"]) == 0
    return out
