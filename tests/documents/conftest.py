"""What the pages take for given, so small that it is made in seconds."""

import importlib
import shutil
import sys
import tomllib

import cv2
import numpy as np
import pytest
import tomli_w
from PIL import Image

from synth.scene_files import scenes_folder
from tests.documents.blocks import ROOT
from validation.cli import run_command

WHEEL = {
    "bed": {"width": 0.16, "depth": 0.03, "grain_diameter": 3.5e-3, "coarsening": 1.0},
    "implement": {"radius": 0.03, "normal_load": 10.0, "moving_mass": 0.1},
    "contact": {"normal_stiffness": 2.0e6},
    "timing": {"frame_count": 2, "speed_up": 20.0},
    "camera": {"width": 208, "height": 128, "centre_z": 0.022, "supersampling": 4},
}
DRIVES = {
    "rolling_wheel": {"kind": "rolling", "rim_speed": 0.01, "slip": 0.2, "start": 0.05, "run_in": 0.01},
    "pushed_wheel": {"kind": "pushing", "speed": 0.008, "start": 0.08, "loading": 0.5, "rest": 0.1},
}
# The rolling wheel of the page that changes it; its own is full-size.
DRIVES["slipping"] = {**DRIVES["rolling_wheel"], "slip": 0.4}
BAND = """
base = "shear_band"
name = "small_band"
[quick.motion]
radius = 32.0
[quick.camera]
width = 160
height = 96
"""
FILM_SHAPE = (480, 880)
SAND = """
base = "sand_rotation"
name = "sand"
[timing]
frame_count = 6
[camera]
width = 128
height = 96
"""


@pytest.fixture(scope="module")
def docs_make():
    """Import a program of docs/make by its name; afterwards, none is left of them."""
    folder, before = str(ROOT / "docs" / "make"), set(sys.modules)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        yield importlib.import_module
    for name in set(sys.modules) - before:
        if (getattr(sys.modules[name], "__file__", None) or "").startswith(folder):
            del sys.modules[name]


@pytest.fixture(scope="module")
def maker(docs_make):
    """The program that `make figures` runs."""
    return docs_make("figures")


@pytest.fixture(scope="module")
def entries(maker):
    """What it makes."""
    return maker.read_entries()


@pytest.fixture(scope="session")
def small_scenes(tmp_path_factory):
    """A folder of wheels in beds of about 300 grains, by the names of those that pages run."""
    folder = tmp_path_factory.mktemp("small")
    shipped = tomllib.loads((scenes_folder() / "rolling_wheel.toml").read_text())
    for name, drive in DRIVES.items():
        tables = {key: {**shipped[key], **values} for key, values in WHEEL.items()}
        quick = {"timing": {"frame_count": 2}}
        scene = {**shipped, **tables, "name": name, "drive": drive, "quick": quick}
        (folder / f"{name}.toml").write_text(tomli_w.dumps(scene))
    return folder


@pytest.fixture(scope="session")
def small_band(tmp_path_factory):
    """A folder with a small shear band, by the name of the one that pages run."""
    folder = tmp_path_factory.mktemp("band")
    (folder / "shear_band.toml").write_text(BAND)
    return folder


@pytest.fixture(scope="session")
def sand_run(tmp_path_factory):
    """A run of five pairs of sand by formula, measured by the default method."""
    folder = tmp_path_factory.mktemp("run")
    (folder / "sand.toml").write_text(SAND)
    assert run_command(["run", str(folder / "sand.toml"), str(folder / "OUT"), "--threads", "1"]) == 0
    return folder / "OUT"


@pytest.fixture(scope="session")
def own_pictures(tmp_path_factory):
    """Three pictures of soil below a dark background, of which a block moves to the left."""
    folder = tmp_path_factory.mktemp("own") / "PICTURES"
    folder.mkdir()
    grains = np.random.default_rng(4).uniform(90, 250, (2, 120, 168)).astype(np.uint8)
    for k in range(3):
        picture = grains[0, :, :160].copy()
        picture[20:70, 40:120] = grains[1, 20:70, 40 + 3 * k : 120 + 3 * k]
        picture[:20] = 12
        Image.fromarray(picture).save(folder / f"IMG_{k}.png")
    return folder


@pytest.fixture(scope="session")
def own_film(tmp_path_factory):
    """A film of soil below a dark background, of which a block moves; a mask, and a lens file."""
    from soft.calibration import Lens

    folder, (height, width) = tmp_path_factory.mktemp("film"), FILM_SHAPE
    noise = np.random.default_rng(5).uniform(-1, 1, (2, height, width))
    smooth = np.stack([cv2.GaussianBlur(one, (0, 0), 1.5) for one in noise])
    grains = np.clip(150 + 90 * smooth / smooth.std(), 60, 255).astype(np.uint8)
    film = cv2.VideoWriter(str(folder / "FILM.mp4"), cv2.VideoWriter_fourcc(*"mp4v"), 25.0, (width, height))
    assert film.isOpened()
    for k in range(6):
        picture = grains[0].copy()
        picture[220:340, 300:600] = grains[1, 220:340, 300 + k : 600 + k]
        picture[:160] = 12
        film.write(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR))
    film.release()
    mask = np.full(FILM_SHAPE, 255, np.uint8)
    Image.fromarray(cv2.circle(mask, (450, 180), 50, 0, -1)).save(folder / "wheel.png")
    matrix = np.array([[900.0, 0, width / 2], [0, 900.0, height / 2], [0, 0, 1]])
    Lens(FILM_SHAPE, matrix, np.array([-0.01, 0.0, 0.0, 0.0, 0.0])).write(folder / "lens.toml")
    return folder


@pytest.fixture(scope="session")
def wheels(sand_sweep, sand_set, tmp_path_factory):
    """A folder with a sweep file and its data set, by the names that pages have for them."""
    folder = tmp_path_factory.mktemp("set")
    shutil.copy(sand_sweep, folder / "wheels.toml")
    shutil.copytree(sand_set, folder / "wheels")
    return folder
