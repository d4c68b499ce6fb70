import os

import pytest

from synth import Recording, simulate
from synth.devices import cache_folder
from synth.scene import SoilBinScene, load_scene, parse_scene


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """Beds of tests are made by the code under test, not found in a user's cache.

    Compiled kernels are: taichi finds them by what is in them, and most processes that tests start would
    else compile all that another one has compiled.
    """
    before = os.environ.get("SOFTBED_CACHE")
    kernels, own = cache_folder() / "kernels", tmp_path_factory.mktemp("cache")
    kernels.mkdir(parents=True, exist_ok=True)
    (own / "kernels").symlink_to(kernels.resolve())
    os.environ["SOFTBED_CACHE"] = str(own)
    yield
    if before is None:
        del os.environ["SOFTBED_CACHE"]
    else:
        os.environ["SOFTBED_CACHE"] = before


@pytest.fixture(scope="session")
def tiny_wheel() -> SoilBinScene:
    """A wheel of 3 cm radius in a bed of about 300 grains: seconds to run, and still soil."""
    tables = load_scene("rolling_wheel", quick=True).to_dict()
    tables["name"] = "tiny_wheel"
    tables["soil"]["contact"]["rolling_friction"] = 0.2  # its own, whatever soils are calibrated to
    del tables["bed"]["relative_density"], tables["bed"]["fine"]
    tables["bed"] |= {"width": 0.16, "depth": 0.03, "grain_diameter": 3.5e-3, "settling_friction": 0.5}
    tables["bed"]["coarsening"] = 1.0
    tables["implement"] |= {"radius": 0.03, "normal_load": 4.0, "moving_mass": 0.04}
    tables["drive"] |= {"start": 0.05, "run_in": 0.01}
    tables["contact"] |= {"normal_stiffness": 2.0e6}
    tables["timing"] |= {"frame_count": 4, "speed_up": 20.0}
    tables["camera"] |= {"width": 320, "height": 160, "centre_z": 0.022, "supersampling": 4}
    return parse_scene(tables)


@pytest.fixture(scope="session")
def tiny_recording(tiny_wheel) -> Recording:
    """What the tiny wheel does, undisturbed; not to be changed."""
    return simulate(tiny_wheel)


@pytest.fixture(scope="session")
def tiny_wheel_with_contacts(tiny_wheel) -> SoilBinScene:
    """The same, and the forces between grains are kept."""
    tables = tiny_wheel.to_dict()
    tables["timing"]["record_contacts"] = True
    return parse_scene(tables)


@pytest.fixture(scope="session")
def tiny_recording_with_contacts(tiny_wheel_with_contacts) -> Recording:
    """What it does, with the forces between grains; not to be changed."""
    return simulate(tiny_wheel_with_contacts)


@pytest.fixture(scope="session")
def tiny_rim(tiny_wheel) -> SoilBinScene:
    """The same with an elastic rim, which gives way by a sixth of the radius."""
    tables = tiny_wheel.to_dict()
    tables["name"] = "tiny_rim"
    tables["implement"] |= {
        "kind": "compliant_wheel",
        "deflection": 0.005,
        "node_count": 60,
        "rim_thickness": 2e-3,
        "rim_mass": 0.05,
        "bending_stiffness": 0.01,
        "hoop_stiffness": 1e5,
        "tangential_stiffness_ratio": 0.5,
        "damping_ratio": 1.0,
    }
    return parse_scene(tables)
