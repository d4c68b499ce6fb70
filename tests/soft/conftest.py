"""Pictures whose motion is known exactly: a texture that is a function of real coordinates."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

SHAPE = (160, 220)


@pytest.fixture(scope="session")
def texture() -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Grey 0-255 at real coordinates (x, y) in px: 200 plane waves, 5 to 25 px long, never interpolated."""
    rng = np.random.default_rng(5)
    angle, phase = rng.uniform(0, 2 * np.pi, (2, 200))
    number = 2 * np.pi / rng.uniform(5, 25, 200)

    def grey(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        total = np.zeros(np.broadcast_shapes(x.shape, y.shape))
        for k in range(200):
            total += np.cos(number[k] * (np.cos(angle[k]) * x + np.sin(angle[k]) * y) + phase[k])
        return np.clip(128 + 4 * total, 0, 255).astype(np.float32)

    return grey


@pytest.fixture(scope="session")
def moved(texture) -> Callable[..., tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """First and second picture and the true forward displacement for x' = c + A (x - c) + d, c the centre."""

    def pictures(*, shift=(0.0, 0.0), matrix=((1.0, 0.0), (0.0, 1.0)), shape=SHAPE):
        y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
        centre = np.array([(shape[1] - 1) / 2, (shape[0] - 1) / 2])
        A, d = np.array(matrix), np.array(shift)
        position = np.stack([x, y], axis=-1)
        truth = (position - centre) @ A.T + centre + d - position
        origin = (position - centre - d) @ np.linalg.inv(A).T + centre
        return texture(x, y), texture(origin[..., 0], origin[..., 1]), truth

    return pictures


@pytest.fixture
def printed_on() -> Callable[[str, tuple[int, ...]], set[str]]:
    """What a program prints last in processes of its own, told how many threads to take as its argument."""

    def printed(program: str, threads: tuple[int, ...]) -> set[str]:
        environment = os.environ | {"TI_LOG_LEVEL": "error"}
        runs = (
            subprocess.run(
                [sys.executable, "-c", program, str(count)],
                capture_output=True, text=True, check=True, env=environment,
            )
            for count in threads
        )  # fmt: skip
        return {run.stdout.split()[-1] for run in runs}

    return printed


@pytest.fixture(scope="session")
def real_data() -> Path:
    """The folder of real data, or skip."""
    default = Path(__file__).resolve().parents[2].parent / "shared" / "data"
    folder = Path(os.environ.get("SOFTBED_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no real data: {folder} does not exist (set SOFTBED_DATA)")
    return folder


@pytest.fixture
def picture_folder(tmp_path, moved):
    """A folder of three 8-bit pictures, each moved (1.5, -0.75) px from the former."""
    import cv2

    for k in range(3):
        _, picture, _ = moved(shift=(1.5 * k, -0.75 * k))
        cv2.imwrite(str(tmp_path / f"shot{9 + k}.png"), np.rint(picture).astype(np.uint8))
    return tmp_path


@pytest.fixture
def soil_flow():
    """A SoilFlow of these inertial displacements (P, H, W) in px, the camera at rest, 8 frames a second."""
    from soft.soilflow import SCHEMA_VERSION
    from soft.soilflow_writer import MemoryWriter

    def make(u, v, *, valid=None, soil=None, moving=None):
        sizes = dict(zip(("pair", "y", "x"), np.shape(u), strict=True))
        writer = MemoryWriter(sizes, calibrated=False, gridded=False, timed=True)
        everywhere = np.ones(np.shape(u), bool)
        valid, soil, moving = (everywhere if m is None else m for m in (valid, soil, moving))
        for k in range(len(u)):
            known = np.where(valid[k], np.float32(0), np.float32(np.nan))
            values = {"valid": valid[k], "soil": soil[k], "moving": moving[k], "camera_u": 0, "camera_v": 0}
            values |= {"u": u[k] + known, "v": v[k] + known, "first_frame": k, "second_frame": k + 1}
            values |= {"inertial_u": values["u"], "inertial_v": values["v"], "time": k / 8}
            writer.put(k, values)
        return writer.finish(
            {
                "schema_version": SCHEMA_VERSION, "method": "made by hand", "options": "{}", "versions": "{}",
                "frame_rate": 8.0, "metres_per_pixel": 2e-4,
            }
        )  # fmt: skip

    return make
