"""Small recordings whose particles follow a known field, and the scenes to photograph them with."""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from synth import Recording, load_scene
from synth.recording import VARIABLES
from synth.scene import parse_scene

PIXEL = 0.2e-3  # m
SIZE = (96, 128)  # px, height and width
CENTRE = (0.2, 0.1)  # m, where the camera looks
OUT_OF_SIGHT = 5.0  # m
SAMPLING = 4
"""Samples along each side of a pixel, for all that is not about them: kernels are compiled for each number of
them anew, and longer for more.
"""


@dataclass(frozen=True)
class Case:
    scene: object
    recording: Recording


def make_scene(*, name="rolling_wheel", **tables):
    """A quick scene with a small, noise-free picture; `tables` change keys of its tables."""
    scene = load_scene(name, quick=True).to_dict()
    height, width = SIZE
    scene["camera"].update(
        width=width, height=height, metres_per_pixel=PIXEL, follows="bin", supersampling=SAMPLING
    )
    if name != "plate_rotation":
        scene["camera"].update(centre_x=CENTRE[0], centre_z=CENTRE[1])
    scene["lens"].update(blur=0.7, vignetting=0.0)
    for table, keys in tables.items():
        scene[table] = {**scene[table], **keys} if isinstance(keys, dict) else keys
    return parse_scene(scene)


def lattice(diameter=2e-3, half_width=0.03, half_height=0.025, seed=3):
    """Jittered rows of particles around the camera's centre: x, z (m)."""
    across = np.arange(-half_width, half_width, diameter)
    up = np.arange(-half_height, half_height, 0.9 * diameter)
    x, z = np.meshgrid(across, up)
    x = x + 0.5 * diameter * (np.arange(len(up)) % 2)[:, None]
    jitter = np.random.default_rng(seed).normal(0, 0.05 * diameter, (2, x.size))
    return CENTRE[0] + x.ravel() + jitter[0], CENTRE[1] + z.ravel() + jitter[1]


def make_recording(
    x, z, *, angle=None, radius=1e-3, carriage=0.0, implement=(OUT_OF_SIGHT, OUT_OF_SIGHT), turn=0.0
):
    """A recording of the given particle paths, (frame, particle) each, and of the implement."""
    frames, particles = np.shape(x)
    sizes = {"frame": frames, "particle": particles, "sample": 0}
    arrays = {name: np.zeros([sizes[d] for d in dims]) for name, (dims, _, _) in VARIABLES.items()}
    arrays.update(position_x=np.asarray(x, float), position_z=np.asarray(z, float))
    arrays["radius"][:] = radius
    arrays["time"][:] = np.arange(frames) / 8
    arrays["carriage_x"][:] = carriage
    arrays["implement_x"][:], arrays["implement_z"][:] = implement
    arrays["implement_angle"][:] = turn
    if angle is not None:
        arrays["angle"][:] = angle
    return Recording.from_arrays(arrays, {"simulation_hash": "", "surface_height": CENTRE[1]})


def make_case(field, *, frames=2, carriage=0.0, implement=(OUT_OF_SIGHT, OUT_OF_SIGHT), turn=0.0, **tables):
    """Particles of a lattice moved by `field(x, z, frame)`."""
    start = lattice()
    paths = [field(*start, frame) for frame in range(frames)]
    x, z = [path[0] for path in paths], [path[1] for path in paths]
    recording = make_recording(x, z, carriage=carriage, implement=implement, turn=turn)
    return Case(make_scene(**tables), recording)


def make_plate(angles, **tables):
    """A plate turned to the given angles."""
    nothing = np.empty((len(angles), 0))
    recording = make_recording(nothing, nothing, implement=(0.0, 0.0), turn=angles)
    return Case(make_scene(name="plate_rotation", **tables), recording)


def _rest(x, z, frame):
    return x, z


def _rotation(rate):
    def field(x, z, frame):
        cosine, sine = np.cos(rate * frame), np.sin(rate * frame)
        off_x, off_z = x - CENTRE[0], z - CENTRE[1]
        return CENTRE[0] + cosine * off_x - sine * off_z, CENTRE[1] + sine * off_x + cosine * off_z

    return field


def _translation(right, up):
    """`right`, `up` px a frame."""
    return lambda x, z, frame: (x + frame * right * PIXEL, z + frame * up * PIXEL)


def _shear(gamma):
    """Particles above the centre move right, by `gamma` times their height."""
    return lambda x, z, frame: (x + frame * gamma * (z - CENTRE[1]), z)


@pytest.fixture(scope="session")
def fields():
    """Fields of motion by name."""
    return {"rest": _rest, "rotation": _rotation, "translation": _translation, "shear": _shear}


@pytest.fixture(scope="session")
def cases():
    """Makers of scenes, recordings and both."""

    class Makers:
        scene, recording, case, plate = map(staticmethod, (make_scene, make_recording, make_case, make_plate))
        lattice, swirl = staticmethod(lattice), staticmethod(swirl)
        pixel, size, centre = PIXEL, SIZE, CENTRE

    return Makers


# What `swirl` gives, rendered in a process of its own.
RENDERING = """
import sys
sys.path.insert(0, sys.argv[1])
from pathlib import Path
from conftest import swirl
from synth import render
case = swirl()
render(case.recording, case.scene, Path(sys.argv[2]), threads=int(sys.argv[3])).close()
"""


def swirl():
    """Soil that shears and parts below a wheel, seen from a carriage."""

    def field(x, z, frame):
        return x + frame * 0.05 * (z - CENTRE[1]), z + frame * 1e-4 * (x > CENTRE[0])

    return make_case(
        field,
        frames=3,
        carriage=[0, 5e-4, 1e-3],
        turn=[0, 0.01, 0.02],
        implement=(CENTRE[0], CENTRE[1] + 0.12),
        camera={"follows": "carriage", "centre_x": CENTRE[0]},
    )


@pytest.fixture(scope="session")
def render_apart():
    """Render `swirl` in a process of so many threads: `render_apart(folder, threads)`."""

    def rendered(folder, threads):
        told = [str(Path(__file__).parent), str(folder), str(threads)]
        subprocess.run([sys.executable, "-c", RENDERING, *told], check=True, stdout=subprocess.DEVNULL)
        return folder

    return rendered


@pytest.fixture(scope="session")
def rendered_on_one_thread(render_apart, tmp_path_factory):
    """Footage of `swirl` by a process of one thread; what it compiled is there for others of one thread."""
    return render_apart(tmp_path_factory.mktemp("one_thread") / "footage", 1)


@pytest.fixture(scope="session")
def taichi():
    """Start taichi, for tests that call a part below the public functions."""
    from synth.devices import start_taichi

    return start_taichi()


@pytest.fixture(scope="session")
def offsets():
    """Image coordinates of every pixel from the picture's centre: x, y, (H, W) each."""
    height, width = SIZE
    y, x = np.mgrid[:height, :width].astype(float)
    return x - (width - 1) / 2, y - (height - 1) / 2


@pytest.fixture(scope="session")
def photograph(taichi):
    """Noise-free light of a frame, (H, W) float32."""

    def take(case, frame):
        from synth.camera.nuisance import as_seen
        from synth.camera.photographer import Photographer
        from synth.truth import grains_and_motion

        recording = as_seen(case.recording, case.scene)
        grains, motion = grains_and_motion(recording, case.scene)
        placement, previous = motion.start(), None
        for _ in range(frame):
            placement, previous = motion.advance(placement), placement
        light = np.empty((case.scene.camera.height, case.scene.camera.width), np.float32)
        Photographer(case.scene, recording, grains, motion).light(placement, previous, light)
        return light

    return take
