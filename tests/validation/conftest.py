import tomllib

import numpy as np
import pytest
import tomli_w
import xarray as xr

from synth.scene_files import scenes_folder
from validation.cli import run_command
from validation.scoring.truth_pass import pass_over


def write_scene(path, source, **changes):
    """A shipped scene with other numbers, `camera={"width": 96}`."""
    tables = tomllib.loads((scenes_folder() / f"{source}.toml").read_text())
    tables.pop("quick", None)
    for table, values in changes.items():
        tables[table] = {**tables[table], **values} if isinstance(values, dict) else values
    path.write_text(tomli_w.dumps(tables))
    return path


@pytest.fixture(scope="session")
def tiny_scene(tmp_path_factory):
    """A plate so small that a whole run takes a second or two."""
    path = tmp_path_factory.mktemp("scenes") / "tiny.toml"
    return write_scene(
        path, "plate_rotation", name="tiny", camera={"width": 96, "height": 80, "supersampling": 4}
    )


@pytest.fixture(scope="session")
def tiny_wheel_scene(tmp_path_factory):
    """A wheel in a bed of about 300 grains: seconds to run."""
    return write_scene(
        tmp_path_factory.mktemp("scenes") / "tiny_wheel.toml",
        "rolling_wheel",
        name="tiny_wheel",
        bed={"width": 0.16, "depth": 0.03, "grain_diameter": 3.5e-3, "coarsening": 1.0},
        implement={"radius": 0.03, "normal_load": 4.0, "moving_mass": 0.04},
        drive={"start": 0.05, "run_in": 0.01},
        contact={"normal_stiffness": 2.0e6},
        timing={"frame_count": 4, "speed_up": 20.0},
        camera={"width": 320, "height": 160, "centre_z": 0.022, "supersampling": 4},
    )


@pytest.fixture(scope="session")
def finished_run(tiny_scene, tmp_path_factory):
    """A run folder of the tiny scene with two methods; not to be changed."""
    out = tmp_path_factory.mktemp("finished") / "out"
    assert run_command(["run", str(tiny_scene), str(out), "--method", "dis", "--method", "farneback"]) == 0
    return out


@pytest.fixture
def softbed(capfd):
    """Run a command: `softbed("scenes", "--json")` gives (exit status, standard output, standard error)."""

    def run(*arguments):
        capfd.readouterr()
        status = run_command([str(argument) for argument in arguments])
        return status, *capfd.readouterr()

    return run


def _make_truth(u, v, **others):
    """Truth of one pair; what is not given is valid soil without an implement."""
    u = np.asarray(u, np.float32)
    v = np.broadcast_to(np.asarray(v, np.float32), u.shape)
    arrays = {
        "u": u,
        "v": v,
        "valid": np.ones(u.shape, bool),
        "soil": np.ones(u.shape, bool),
        "mixed": np.zeros(u.shape, bool),
        "distance_to_implement": np.full(u.shape, np.inf, np.float32),
    } | others
    scalars = {name: arrays.pop(name) for name in ("camera_u", "camera_v") if name in arrays}
    return xr.Dataset({name: (("y", "x"), a) for name, a in arrays.items()} | scalars)


class _HandMadeFootage:
    """The part of `synth.Footage` that scoring uses."""

    def __init__(self, *truths):
        self._truths = truths
        self.pair_count = len(truths)

    def truth(self, pair):
        return self._truths[pair]


def _make_flow(u, v, valid=None):
    """Soil flow over `pair, y, x`."""
    u, v = np.asarray(u, np.float32), np.asarray(v, np.float32)
    valid = np.isfinite(u) if valid is None else valid
    pairs = np.arange(len(u))
    coordinates = {"first_frame": ("pair", pairs), "second_frame": ("pair", pairs + 1)}
    dims = ("pair", "y", "x")
    return xr.Dataset({"u": (dims, u), "v": (dims, v), "valid": (dims, valid)}, coordinates)


@pytest.fixture
def make_truth():
    return _make_truth


@pytest.fixture
def make_flow():
    return _make_flow


@pytest.fixture
def make_footage():
    """Footage of these truths."""
    return _HandMadeFootage


@pytest.fixture
def tallied():
    """What a tally tells of a flow, `tallied(tally, footage, flow)`."""

    def tallied(tally, footage, flow):
        pass_over(footage, {"own": flow}, {"own": [tally]})
        return tally.result()

    return tallied
