"""The search's bookkeeping on a made-up soil whose friction angle is known, and the files it writes."""

import json
import tomllib

import numpy as np
import pytest

from synth.dem.relative_density import SettlingRelation
from synth.scene import load_soil, soil_path
from synth.soil import SoilFile
from validation.calibration import calibrate as module
from validation.calibration.biaxial import BiaxialPoint, peak_sine
from validation.calibration.calibrate import CalibrationError, Target, calibrate
from validation.calibration.evidence import calibration_document, soil_text
from validation.calibration.figure import calibration_figure
from validation.calibration.plate import DEPTH, PlateCurve
from validation.figures import to_png
from validation.verification.biaxial import STRAIN_STEP, Compression


def angle_of(rolling_friction, relative_density):
    """Deg: what the made-up grains have."""
    return 18 + 20 * rolling_friction + 8 * relative_density


def measure(contact, polydispersity, relation, *, relative_density, seeds, progress):
    sine = np.sin(np.radians(angle_of(contact.rolling_friction, relative_density)))
    sines = tuple(float(sine + 0.01 * (-1) ** seed) for seed in seeds)
    return BiaxialPoint(
        contact.friction, contact.rolling_friction, relative_density, sines, tuple(0.2 for _ in seeds)
    )


def press(soil, polydispersity, *, settling_friction, seeds, progress):
    sinkage = (np.arange(16) + 0.5) * DEPTH / 16
    pressure = 2.0e6 * sinkage**1.2
    return PlateCurve(tuple(sinkage), tuple(pressure), tuple(0.1 * pressure), soil.bulk_density)


@pytest.fixture
def made_up(monkeypatch):
    relation = SettlingRelation((0.0, 0.1, 2.0), (0.2, 0.24, 0.3))
    monkeypatch.setattr(module, "settling_relation", lambda *_, **__: relation)
    monkeypatch.setattr(module, "measure_point", measure)
    monkeypatch.setattr(module, "press_plate", press)


def nothing(done, total):
    assert 0 <= done <= total


@pytest.fixture
def calibration(made_up):
    return calibrate(load_soil("grc1").soil, Target(0.5, 33.0), seed_count=4, progress=nothing)


def test_finds_the_rolling_friction_that_gives_the_angle(calibration):
    assert calibration.soil.contact.rolling_friction == pytest.approx((33 - 18 - 4) / 20, abs=0.03)
    assert calibration.found.angle == pytest.approx(33.0, abs=0.5)
    assert calibration.found.angle_error == pytest.approx(0.4, abs=0.1)
    assert calibration.soil.contact.friction == load_soil("grc1").contact.friction
    assert (calibration.loosest.relative_density, calibration.densest.relative_density) == (0.0, 1.0)
    assert calibration.densest.angle - calibration.loosest.angle == pytest.approx(8.0, abs=0.1)
    assert {point.relative_density for point in calibration.tried} == {0.5}


def test_an_angle_out_of_reach_is_told_with_what_is_in_reach(made_up):
    with pytest.raises(CalibrationError, match=r"50\.0 deg.*allowed is 22\.0 to 42\.0 deg.*friction = 0\.5"):
        calibrate(load_soil("grc1").soil, Target(0.5, 50.0), seed_count=2, progress=nothing)


def test_the_file_reads_back_as_what_was_found_and_keeps_its_comments(calibration):
    source = soil_path("grc1").read_text()
    text = soil_text(source, calibration)
    read = SoilFile.model_validate(tomllib.loads(text))
    assert read.soil == calibration.soil
    assert read.published == load_soil("grc1").published
    assert read.evidence["found_friction_angle"] == pytest.approx(calibration.found.angle, abs=0.01)
    assert len(read.evidence["biaxial"]) == len(calibration.tried) + 2
    assert "kg/m3; [S] gives 1600-1900" in text
    assert soil_text(text, calibration) == text  # calibrated again, nothing piles up


def test_a_file_that_cannot_be_rewritten_is_refused(calibration):
    source = soil_path("grc1").read_text().replace("rolling_friction =", '"rolling_friction" =')
    with pytest.raises(ValueError, match="one key a line"):
        soil_text(source, calibration)


def test_figure_and_document(calibration):
    assert to_png(calibration_figure(calibration, load_soil("grc1").published)).startswith(b"\x89PNG")
    assert to_png(calibration_figure(calibration, None)).startswith(b"\x89PNG")
    document = json.loads(json.dumps(calibration_document(calibration), allow_nan=False))
    assert document["plate"]["bekker_exponent"] == pytest.approx(1.2)
    assert document["plate"]["bekker_modulus"] == pytest.approx(2.0e6, rel=1e-6)


def test_a_peak_is_the_greatest_mean_over_a_hundredth_of_strain():
    assert pytest.approx(0.01) == 4 * STRAIN_STEP
    sine = np.array([0.1, 0.2, 0.9, 0.2, 0.3, 0.3, 0.3, 0.5, 0.3])
    confining = np.full(sine.size, 100.0)
    stress = np.stack([confining * (1 + sine) / (1 - sine), confining], axis=1)
    assert peak_sine(Compression(stress, (0.2, 0.2))) == pytest.approx((0.9 + 0.2 + 0.3 + 0.3) / 4)


def test_target_is_the_published_one_at_the_beds_density():
    soil = load_soil("grc1")
    target = Target.of(soil)
    assert target.relative_density == pytest.approx(soil.published.relative_density(1700.0))
    assert Target.of(soil, friction_angle=31.0) == Target(target.relative_density, 31.0)
    assert Target.of(soil, relative_density=0.0).friction_angle == soil.published.loosest_friction_angle


def test_without_published_values_both_are_to_be_given():
    soil = load_soil("grc1").model_copy(update={"published": None})
    with pytest.raises(CalibrationError, match=r"--relative-density and --friction-angle"):
        Target.of(soil, friction_angle=31.0)
    assert Target.of(soil, friction_angle=31.0, relative_density=0.2) == Target(0.2, 31.0)


def test_a_density_that_cannot_be_is_refused():
    soil = load_soil("grc1").model_copy(update={"bulk_density": 1500.0})
    with pytest.raises(CalibrationError, match=r"bulk_density = 1500\.0: allowed is 1600\.0 to 1890\.0"):
        Target.of(soil)


def test_command_writes_the_soil_and_a_figure(made_up, softbed, tmp_path):
    output = tmp_path / "mine.toml"
    status, printed, error = softbed("calibrate", "grc1", "--output", str(output), "--json")
    assert status == 0, error
    document = json.loads(printed)
    found = SoilFile.model_validate(tomllib.loads(output.read_text()))
    assert found.contact.rolling_friction == document["rolling_friction"]
    assert (document["file"], document["figure"]) == (str(output), str(tmp_path / "mine.png"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.png", "mine.toml"]
    status, _, error = softbed("calibrate", "grc1", "--output", str(output))
    assert (status, error.count("\n")) == (2, 1)
    assert "--overwrite" in error
    assert softbed("calibrate", "grc1", "--output", str(output), "--overwrite")[0] == 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["grc1", "--output", "mine.txt"], "ends in .toml"),
        (["grc1", "--output", "nowhere/mine.toml"], "nowhere is not a folder"),
        (["mars", "--output", "mine.toml"], "soil = 'mars': allowed is"),
        (["grc1", "--output", "mine.toml", "--friction-angle", "58"], "allowed is"),
    ],
)
def test_command_says_in_a_line_what_is_wrong(made_up, softbed, tmp_path, monkeypatch, arguments, says):
    monkeypatch.chdir(tmp_path)
    status, _, error = softbed("calibrate", *arguments)
    assert status == 2
    assert says in error.splitlines()[-1]
    assert not list(tmp_path.iterdir())
