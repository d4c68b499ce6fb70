"""On a GPU the results are those of the CPU, within what rounding in another order does; skips without one.

Each device has a process of its own: taichi is started once in a process. Tolerances are stated here before
anything has been measured on a GPU.
"""

import os
import subprocess
import sys

import numpy as np
import pytest

PROGRAM = """
import sys
import numpy as np
import synth
from pathlib import Path
from soft import estimate_flow
from synth.devices import start_taichi

device, scene, out = sys.argv[1], synth.load_scene(sys.argv[2]), Path(sys.argv[3])
start_taichi(device, 1)
recording = synth.simulate(scene, device=device, threads=1)
if device == "cuda":  # pictures of one and the same motion
    own, recording = recording, synth.Recording.read(out.parent / "cpu" / "recording.nc")
else:
    own = recording
out.mkdir()
recording.write(out / "recording.nc")
with synth.render(recording, scene, out / "footage", device=device, threads=1) as footage:
    first, second = (footage.picture(frame).astype(np.float32) for frame in (0, 1))
    truth = footage.truth(0)
    if device == "cuda":  # motion in one and the same pictures
        with synth.Footage.open(out.parent / "cpu" / "footage") as theirs:
            shown = [theirs.picture(frame).astype(np.float32) for frame in (0, 1)]
    else:
        shown = [first, second]
    flow = estimate_flow(*shown, method="robust-affine", device=device)
    np.savez(
        out / "found.npz",
        x=own.data["position_x"].values[-1], force=own.data["force_z"].values,
        sinkage=own.data["sinkage"].values,
        picture=first, soil=truth["soil"].values, u=truth["u"].values, v=truth["v"].values,
        flow=flow.displacement, valid=flow.valid,
    )
"""


def has_cuda():
    import taichi as ti

    return ti.lang.misc.is_arch_supported(ti.cuda)


@pytest.fixture(scope="module")
def found(tiny_wheel_scene, tmp_path_factory):
    """What each device found, by name."""
    if not has_cuda():
        pytest.skip("no CUDA device is found here")
    folder = tmp_path_factory.mktemp("devices")
    for device in ("cpu", "cuda"):
        command = [sys.executable, "-c", PROGRAM, device, str(tiny_wheel_scene), str(folder / device)]
        done = subprocess.run(command, capture_output=True, text=True, env=os.environ)
        assert done.returncode == 0, done.stderr
    return {device: np.load(folder / device / "found.npz") for device in ("cpu", "cuda")}


def test_the_wheel_works_the_soil_alike(found):
    # Grains are chaotic: each goes its own way after a while, what the wheel feels stays.
    assert found["cuda"]["sinkage"][-1] == pytest.approx(found["cpu"]["sinkage"][-1], rel=0.2)
    means = [np.mean(found[device]["force"]) for device in ("cuda", "cpu")]
    assert means[0] == pytest.approx(means[1], rel=0.1)
    assert np.median(np.abs(found["cuda"]["x"] - found["cpu"]["x"])) < 0.5 * 3.5e-3


def test_pictures_and_truth_are_the_same(found):
    differ = np.abs(found["cuda"]["picture"] - found["cpu"]["picture"])
    assert np.mean(differ > 1) < 1e-3
    assert np.mean(found["cuda"]["soil"] != found["cpu"]["soil"]) < 1e-4
    for name in "uv":
        known = np.isfinite(found["cuda"][name]) & np.isfinite(found["cpu"][name])
        assert np.mean(np.abs(found["cuda"][name] - found["cpu"][name])[known] > 1e-3) < 1e-3


def test_flow_is_the_same(found):
    assert np.mean(found["cuda"]["valid"] != found["cpu"]["valid"]) < 1e-3
    both = found["cuda"]["valid"] & found["cpu"]["valid"]
    differ = np.abs(found["cuda"]["flow"] - found["cpu"]["flow"])[both]
    assert np.mean(differ > 0.01) < 1e-3
