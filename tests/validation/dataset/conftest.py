import pytest

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
