"""Sweeps so small that a data set takes seconds."""

import pytest
import tomli_w

from synth.scene import load_scene

SAND = {
    "scene": "sand_rotation",
    "quick": True,
    "vary": {
        "motion.angle": [0.01, 0.02, 0.03],
        "lens.blur": [0.5, 1.0],
        "camera.width": [96],
        "camera.height": [64],
        "timing.frame_count": [3],
    },
    "split": {"train": 0.34, "validation": 0.33, "test": 0.33},
}


def write_sweep(folder, *, base=None, **tables):
    """A sweep file, and the scene that it varies beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    if base is not None:
        (folder / "own.toml").write_text(base.to_toml())
        tables["scene"] = "own.toml"
    given = {"schema_version": 1, "name": "tiny", "seed": 3, "design": {"kind": "grid"}, **tables}
    path = folder / "sweep.toml"
    path.write_text(tomli_w.dumps(given))
    return path


@pytest.fixture(scope="session")
def sand_sweep(tmp_path_factory):
    """Six sequences of three motions, all by formula."""
    return write_sweep(tmp_path_factory.mktemp("sand"), **SAND)


@pytest.fixture(scope="session")
def wheel_sweep(tiny_wheel, tmp_path_factory):
    """Four sequences of two motions of a wheel in one bed."""
    vary = {"drive.slip": [0.1, 0.3], "lens.blur": [0.5, 1.0]}
    return write_sweep(
        tmp_path_factory.mktemp("wheel"),
        base=tiny_wheel,
        vary=vary,
        split={"train": 0.5, "validation": 0.0, "test": 0.5},
    )


@pytest.fixture(scope="session")
def sand_set(sand_sweep, tmp_path_factory):
    """The data set of `sand_sweep`, made by two workers; not to be changed."""
    pytest.importorskip("distributed")
    from synth.dataset.execution import make_data_set

    out = tmp_path_factory.mktemp("sets") / "sand"
    assert make_data_set(sand_sweep, out, workers=2)["complete"]
    return out


@pytest.fixture(scope="session")
def sweep_of():
    """Write a sweep file."""
    return write_sweep


@pytest.fixture(scope="session")
def sand_tables():
    """What `sand_sweep` has in its file."""
    return SAND


@pytest.fixture(scope="session")
def quick_sand():
    return load_scene("sand_rotation", quick=True)
