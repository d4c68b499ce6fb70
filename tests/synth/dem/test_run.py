import csv
import shutil
import subprocess
import sys

import numpy as np
import pytest

from synth import Recording, simulate
from synth.dem.bed import settled_bed
from synth.dem.log import slip_of
from synth.devices import cache_folder, thread_count
from synth.scene import parse_scene


@pytest.fixture(scope="module")
def recording(tiny_recording):
    return tiny_recording


def test_bed_is_settled_level_and_of_the_soils_density(tiny_wheel, recording):
    bed = settled_bed(tiny_wheel)
    assert bed.grains.position[1].min() > 0
    top = (bed.grains.position[1] + bed.grains.radius).max()
    assert tiny_wheel.bed.depth - tiny_wheel.bed.grain_diameter < top <= tiny_wheel.bed.depth * 1.01
    assert 0.74 < bed.solid_fraction < 0.88
    assert bed.grains.density * bed.solid_fraction == pytest.approx(tiny_wheel.soil.bulk_density)


def test_bed_in_the_cache_is_the_bed_that_was_made(tiny_wheel):
    shutil.rmtree(cache_folder() / "beds", ignore_errors=True)
    made, cached = settled_bed(tiny_wheel), settled_bed(tiny_wheel)
    assert cached.grains is not made.grains
    np.testing.assert_array_equal(cached.grains.position, made.grains.position)
    np.testing.assert_array_equal(cached.grains.radius, made.grains.radius)


def test_frames_and_samples_are_where_the_scene_wants_them(tiny_wheel, recording):
    data, timing, wheel, drive = recording.data, tiny_wheel.timing, tiny_wheel.implement, tiny_wheel.drive
    assert recording.frame_count == timing.frame_count
    np.testing.assert_allclose(np.diff(data.time), 1 / timing.frame_rate)
    assert data.sample_time.values[-1] == pytest.approx(data.time.values[-1])
    step = drive.carriage_speed / timing.frame_rate
    np.testing.assert_allclose(np.diff(data.carriage_x), step, rtol=1e-9)
    np.testing.assert_allclose(
        np.diff(data.implement_angle), -drive.rim_speed / wheel.radius / timing.frame_rate
    )
    travel = data.carriage_x.values[0] - drive.start
    assert travel == pytest.approx(drive.run_in, rel=1e-3)


def test_soil_carries_the_load(tiny_wheel, recording):
    after = recording.data.where(recording.data.sample_time > 0, drop=True)
    assert float(after.force_z.mean()) == pytest.approx(tiny_wheel.implement.normal_load, rel=0.15)
    assert float(after.sinkage.min()) > 0
    assert float(after.torque.mean()) > 0


def test_driven_wheel_drives_soil_backwards_beneath_and_forwards_ahead(tiny_wheel, recording):
    data, wheel = recording.data, tiny_wheel.implement
    moved = (data.position_x.isel(frame=-1) - data.position_x.isel(frame=0)).values
    x, z = data.position_x.values[0] - data.implement_x.values[0], data.position_z.values[0]
    bottom = data.implement_z.values[0] - wheel.radius
    beneath = (
        (x < 0) & (x > -wheel.radius / 2) & (z < bottom) & (z > bottom - 2 * tiny_wheel.bed.grain_diameter)
    )
    ahead = (x > wheel.radius / 2) & (x < wheel.radius) & (z > bottom)
    assert moved[beneath].mean() < 0 < moved[ahead].mean()


def test_grains_stay_in_the_bin_and_hardly_overlap(tiny_wheel, recording):
    data = recording.data
    assert float(data.position_x.min()) > 0
    assert float(data.position_x.max()) < tiny_wheel.bed.width
    assert float(data.position_z.min()) > 0
    assert 0 < data.attrs["overlap_p99"] < 0.01


def test_recording_on_disk_is_the_recording(tmp_path, recording):
    recording.write(tmp_path / "recording.nc")
    assert Recording.read(tmp_path / "recording.nc").digest == recording.digest


def test_forces_csv_has_units_and_a_line_a_record(tmp_path, recording):
    recording.write_forces(tmp_path / "forces.csv")
    header, *lines = csv.reader((tmp_path / "forces.csv").read_text().splitlines())
    assert header == [
        "time [s]", "travel [m]", "slip [1]", "sinkage [m]", "force_x [N]", "force_z [N]", "torque [N m]",
    ]  # fmt: skip
    assert len(lines) == recording.data.sizes["sample"]


def test_same_bytes_on_another_number_of_threads_and_on_a_rerun(tmp_path, tiny_wheel, recording):
    scene = tmp_path / "scene.toml"
    scene.write_text(tiny_wheel.to_toml())
    program = (
        "import sys; from synth import load_scene, simulate; "
        "print(simulate(load_scene(sys.argv[1]), threads=int(sys.argv[2])).digest)"
    )
    # Kernels may be shared, the bed must be settled anew.
    shutil.rmtree(cache_folder() / "beds")
    assert simulate(tiny_wheel).digest == recording.digest
    shutil.rmtree(cache_folder() / "beds")
    other_count = 2 if thread_count() == 1 else 1
    run = [sys.executable, "-c", program, scene, str(other_count)]
    output = subprocess.run(run, capture_output=True, text=True, check=True).stdout
    assert output.strip() == recording.digest


def test_force_x_is_what_the_soil_does_to_the_implement(tiny_wheel):
    """Soil resists a braked wheel that is pushed backwards: it pushes forwards."""
    tables = tiny_wheel.to_dict()
    drive = {"kind": "pushing", "speed": 0.008, "start": 0.08, "loading": 1.0, "rest": 0.1, "rolled_in": 0.0}
    data = simulate(parse_scene({**tables, "drive": drive})).data
    pushing = data.sample_time > 0.1
    assert float(data.force_x.where(pushing).mean()) > 0.1 * tiny_wheel.implement.normal_load
    assert data.slip.where(pushing).min() == data.slip.where(pushing).max() == -1
    assert float(data.travel[-1]) < 0


def test_slip_and_velocities_are_the_laboratorys(tiny_wheel, recording):
    data = recording.data
    np.testing.assert_allclose(data.slip, tiny_wheel.drive.slip, rtol=1e-9)
    moved = np.diff(data.position_x, axis=0) * tiny_wheel.timing.frame_rate
    mean = (data.velocity_x.values[1:] + data.velocity_x.values[:-1]) / 2
    # Speeds at two frames say what happened between them, up to what jerks do.
    assert np.polyfit(moved.ravel(), mean.ravel(), 1)[0] == pytest.approx(1, abs=0.3)


@pytest.mark.parametrize(
    ("velocity", "rim_speed", "slip"),
    [
        (0.8, 1.0, 0.2),
        (1.0, 1.0, 0.0),
        (0.0, 1.0, 1.0),
        (1.0, 0.0, -1.0),
        (1.0, 0.5, -0.5),
        (-1.0, 0.0, -1.0),
        (0, 0, 0),
    ],
)
def test_slip_is_driving_slip_or_skid(velocity, rim_speed, slip):
    assert slip_of(velocity, rim_speed) == pytest.approx(slip)
