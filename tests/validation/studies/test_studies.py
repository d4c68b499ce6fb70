"""Studies measure what they say, on flows that are known."""

import csv
import json
import tomllib

import numpy as np
import pytest
import tomli_w

from soft.flow import BUILT_IN, installed
from synth import Recording, load_scene
from synth.recording import VARIABLES
from synth.scene import changed_scene
from validation.studies import STUDIES, find_study
from validation.studies.flow_field import Window, mean_flow
from validation.studies.grain_size import band_width, band_widths
from validation.studies.grouser_spacing import by_phase, flux_ahead, largest_spacing, least_count
from validation.studies.picture_errors import picture_errors

SPACING = 1e-3
SURFACE = 0.1
SPEED = 0.008


def lattice_recording(field, *, frames=5, implement_z=0.2, travel=SPEED, rate=8.0):
    """Grains of 2 mm on a lattice 0.4 m x 0.1 m that move by `field(x - implement's x, z)`, m/s."""
    x, z = (one.ravel() for one in np.meshgrid(np.arange(0, 0.4, 2e-3), np.arange(1e-3, SURFACE, 2e-3)))
    sizes = {"frame": frames, "particle": x.size, "sample": 1}
    arrays = {name: np.zeros([sizes[d] for d in dims]) for name, (dims, _, _) in VARIABLES.items()}
    time = np.arange(frames) / rate
    arrays["time"], arrays["implement_x"] = time, 0.2 + travel * time
    arrays["implement_z"][:], arrays["radius"][:] = implement_z, 1e-3
    for frame in range(frames):
        arrays["position_x"][frame], arrays["position_z"][frame] = x, z
        u, w = field(x - arrays["implement_x"][frame] - travel / rate / 2, z)
        x, z = x + u / rate, z + w / rate
    solid = np.pi / 4
    return Recording.from_arrays(arrays, {"surface_height": SURFACE, "solid_fraction": solid})


def test_every_study_is_found_by_its_name():
    for name in STUDIES:
        study = find_study(name)
        assert load_scene(study.scene).name == study.scene and study.columns
    with pytest.raises(ValueError, match="study 'weather': allowed are grain-size, "):
        find_study("weather")


@pytest.mark.parametrize("quick", [False, True])
@pytest.mark.parametrize("name", STUDIES)
def test_cases_are_scenes_with_folders_of_their_own(name, quick):
    study = find_study(name)
    cases = study.cases(load_scene(study.scene, quick=quick), quick=quick)
    assert len({case.label for case in cases}) == len({case.scene.simulation_hash for case in cases})
    assert len(cases) >= (1 if name == "nuisance" else 3)  # that one's cases are pictures


def test_mean_flow_is_a_linear_field_and_its_shear_rate():
    recording = lattice_recording(lambda x, z: (0.05 * (z - 0.05) + 0.02 * x, -0.02 * (z - 0.05)))
    field = mean_flow(recording, Window(-0.05, 0.05, -0.09, -0.01), spacing=SPACING, kernel=2e-3)
    assert (field.x[0], field.z[-1]) == pytest.approx((-0.0495, -0.0105))
    # Positions drift by less than a grain in these four steps; a window's edge has no grain beyond.
    height = field.z[10:-10, None] + SURFACE - 0.05
    np.testing.assert_allclose(
        field.velocity[0][10:-10], 0.05 * height + 0.02 * field.x + 0 * height, atol=5e-5
    )
    stretch, shear = field.shear[:, 15:-15, 15:-15].mean(axis=(1, 2))
    assert (stretch, shear) == pytest.approx((0.04, 0.05), rel=0.03)


def test_there_is_no_flow_where_there_is_no_soil():
    field = mean_flow(
        lattice_recording(lambda x, z: (0 * x, 0 * z)),
        Window(0, 0.01, -0.01, 0.01),
        spacing=SPACING,
        kernel=1e-3,
    )
    assert np.isnan(field.velocity[:, field.z > 5e-3]).all()
    assert np.isfinite(field.velocity[:, field.z < -5e-3]).all()


def test_the_band_holds_the_central_four_fifths():
    depth = np.arange(0, 0.1, 1e-4)
    even = np.where((depth > 0.04) & (depth < 0.06), 3.0, 0.0)
    assert band_width(even, 1e-4) == pytest.approx(0.8 * 0.02, rel=0.02)
    bell = np.exp(-0.5 * ((depth - 0.05) / 5e-3) ** 2)
    assert band_width(bell, 1e-4) == pytest.approx(2.42 * 5e-3, rel=0.02)
    assert band_width(bell + 0.05, 1e-4) == pytest.approx(band_width(bell, 1e-4), rel=0.1)
    apart = even + np.where((depth > 0.08) & (depth < 0.09), 0.2, 0)  # far off and weak: not counted
    assert band_width(apart, 1e-4) == pytest.approx(band_width(even, 1e-4), rel=1e-9)
    assert np.isnan(band_width(np.zeros(9), 1e-4))


def test_the_band_is_measured_below_the_rim():
    """Soil sheared at a depth of 4 to 5 cm, under a rim that goes down to 2 cm at most."""
    scene = load_scene("rolling_wheel")
    recording = lattice_recording(
        lambda x, z: (-0.01 * np.clip((z - 0.05) / 0.01, 0, 1), 0 * z), implement_z=SURFACE + 0.094
    )
    widths = band_widths(scene, recording)
    assert widths.shape == (5,)
    # A centimetre of even shear, smeared by the kernel of 1 mm.
    np.testing.assert_allclose(widths, 0.8 * 0.01, rtol=0.12)


def test_flux_is_that_of_the_soil_ahead_of_the_rim_and_forward_is_positive():
    """All soil moves alike: through the line from the rim's lowest point up flows speed x sinkage."""
    radius, sinkage = 0.08, 0.02
    axle = SURFACE + radius - sinkage
    for speed in (0.004, -0.004):
        recording = lattice_recording(lambda x, z, s=speed: (s + 0 * x, 0 * z), implement_z=axle)
        flux = flux_ahead(recording, radius=radius, sinkage=sinkage, strip=0.05)
        np.testing.assert_allclose(flux, speed * sinkage, rtol=0.045)  # a column of grains more or less
    entry = np.sqrt(radius**2 - (radius - sinkage) ** 2)
    behind = lattice_recording(lambda x, z: (np.where(x < entry - 2e-3, 0.01, 0.0), 0 * z), implement_z=axle)
    np.testing.assert_array_equal(flux_ahead(behind, radius=radius, sinkage=sinkage, strip=0.01), 0)


def test_phases_are_averaged_over_whole_passages():
    turns = np.linspace(0.01, 3.4, 340)
    flux = np.where(np.mod(turns, 1) < 0.5, 2.0, -1.0) + 100 * (turns >= 3)
    phases = by_phase(flux, turns)
    np.testing.assert_allclose(phases, [2] * 6 + [-1] * 6)
    assert np.isfinite(by_phase(flux[:80], turns[:80])).sum() < 12  # not a whole one: what there is


def test_the_spacing_equation_by_its_geometry():
    """In the time from one grouser's entry to the next's the wheel travels from tip entry to rim entry."""
    radius, height, sinkage, slip, rim_speed = 0.114, 0.012, 0.019, 0.2, 0.01
    spacing = largest_spacing(slip=slip, sinkage=sinkage / radius, height=height / radius)
    time = spacing * radius / rim_speed
    axle = radius - sinkage
    tip, rim = (np.sqrt(r**2 - axle**2) for r in (radius + height, radius))
    assert (1 - slip) * rim_speed * time == pytest.approx(tip - rim)
    assert least_count(spacing) == np.ceil(2 * np.pi / spacing)
    assert least_count(2 * np.pi / 24) == 24
    # Higher grousers, more slip: fewer are needed; a deeper wheel needs more.
    more = {"slip": slip, "sinkage": sinkage / radius, "height": height / radius}
    for key, change, wider in (("height", 1.5, True), ("slip", 1.5, True), ("sinkage", 1.5, False)):
        other = largest_spacing(**{**more, key: change * more[key]})
        assert (other > spacing) == wider


def test_simulate_with_convergence_and_again(softbed, tiny_wheel_scene, tmp_path):
    out = tmp_path / "out"
    status, output, error = softbed("simulate", tiny_wheel_scene, out, "--convergence", "--json")
    assert status == 0, error
    told = json.loads(output)["convergence"]
    assert told["rows"][0]["case"] == "as it is" and len(told["rows"]) == 5
    base, *others = told["rows"]
    assert base["flow_change"] == base["sinkage_change"] == 0
    assert all(0 < row["flow_change"] < 300 for row in others)
    for row in others:
        expected = 100 * (row["sinkage"] - base["sinkage"]) / abs(base["sinkage"])
        assert row["sinkage_change"] == pytest.approx(expected)
    place = out / "convergence"
    assert {path.name for path in (place / "runs").iterdir()} == {
        "half-speed-up", "doubled-box", "halved-step", "other-seed"
    }  # fmt: skip
    table = (place / "convergence.csv").read_text().splitlines()
    assert table[0].startswith("case,sinkage [mm],sinkage_change [%]") and len(table) == 6
    assert (place / "convergence.png").read_bytes()[:4] == b"\x89PNG"
    before = (place / "convergence.json").stat().st_mtime_ns
    status, output, error = softbed("simulate", tiny_wheel_scene, out, "--convergence")
    assert status == 0 and error.count("skipped") == 6
    assert (place / "convergence.json").stat().st_mtime_ns == before
    assert "Changes most: sinkage by" in " ".join(output.split())


def test_a_study_needs_soil_and_a_name_that_exists(softbed, tiny_scene, tmp_path):
    status, _, error = softbed("study", "convergence", tmp_path / "a", "--scene", tiny_scene)
    assert status == 2 and "a study needs soil in a bin" in error
    status, _, error = softbed("study", "weather", tmp_path / "b")
    assert status == 2 and f"allowed are {', '.join(STUDIES)}" in error
    assert not (tmp_path / "b").exists()


def read_table(path):
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return {
        name.partition(" [")[0]: np.array(column, float) for name, *column in zip(header, *rows, strict=True)
    }


def test_grain_size_of_a_tiny_wheel(softbed, tiny_wheel_scene, tmp_path, monkeypatch):
    monkeypatch.setattr("validation.studies.grain_size.DIAMETERS", (4.5e-3, 3.5e-3))
    status, output, error = softbed("study", "grain-size", tmp_path, "--scene", tiny_wheel_scene, "--json")
    assert status == 0, error
    assert json.loads(output) == json.loads((tmp_path / "grain-size.json").read_text())
    table = read_table(tmp_path / "grain-size.csv")
    assert table["grain_diameter"].tolist() == [4.5, 3.5]
    assert table["grain_count"][0] < table["grain_count"][1]
    for label, sinkage, pull in zip(
        ("4.5-mm", "3.5-mm"), table["sinkage"], table["drawbar_pull"], strict=True
    ):
        recording = Recording.read(tmp_path / "runs" / label / "recording.nc").data
        since = recording.sample_time.values > 0
        assert recording.sinkage.values[since].mean() * 1000 == pytest.approx(sinkage, rel=1e-5)
        assert recording.force_x.values[since].mean() == pytest.approx(pull, rel=1e-4)
    assert (tmp_path / "grain-size.png").read_bytes()[:4] == b"\x89PNG"


def test_grouser_spacing_of_a_tiny_wheel(softbed, tiny_wheel_scene, tmp_path, monkeypatch):
    monkeypatch.setattr("validation.studies.grouser_spacing.COUNTS", (12, 24))
    tables = tomllib.loads(tiny_wheel_scene.read_text())
    tables["implement"] |= {
        "kind": "grouser_wheel", "grouser_count": 9, "grouser_height": 3e-3, "grouser_thickness": 1e-3,
        "normal_load": 12.0, "moving_mass": 0.12,  # sinks to the rim
    }  # fmt: skip
    scene, out = tmp_path / "scene.toml", tmp_path / "out"
    scene.write_text(tomli_w.dumps(tables))
    status, output, error = softbed("study", "grouser-spacing", out, "--scene", scene, "--json")
    assert status == 0, error
    table = read_table(out / "grouser-spacing.csv")
    assert table["grouser_count"].tolist() == [12, 24]
    for sinkage, count in zip(table["rim_sinkage"], table["predicted_count"], strict=True):
        spacing = largest_spacing(slip=0.2, sinkage=sinkage / 30, height=3 / 30)
        assert count == least_count(spacing)
    assert (table["rim_sinkage"] > 0).all()
    assert (table["forward_share_of_frames"] >= table["forward_share"] - 0.05).all()
    assert "the grouser spacing equation needs" in json.loads(output)["conclusion"]
    assert softbed("study", "grouser-spacing", out, "--scene", tiny_wheel_scene)[0] == 2


FEW = ["dis", "farneback", "robust-affine"]
"""Estimators that a study's test makes do with; all of them take minutes."""


@pytest.mark.parametrize("study", ["nuisance", "texture"])
def test_a_study_of_pictures_takes_every_estimator_there_is(study):
    assert set(find_study(study).inputs["methods"]) == set(installed()) <= set(BUILT_IN)


def small_scene(name):
    """A shipped scene in its quick form, with the fewest samples that a pixel may have."""
    return changed_scene(load_scene(name, quick=True), {"camera.supersampling": 4})


def test_nuisances_of_a_tiny_wheel(softbed, tiny_wheel_scene, tmp_path, monkeypatch):
    monkeypatch.setattr("validation.studies.nuisance.installed", lambda: FEW)
    monkeypatch.setattr("validation.studies.nuisance.load_scene", lambda name, **_: small_scene(name))
    severities = {"vibration": (2.0,), "exchange": (0.2,)}
    monkeypatch.setattr("validation.studies.nuisance.SEVERITIES", severities)
    status, output, error = softbed("study", "nuisance", tmp_path, "--scene", tiny_wheel_scene, "--json")
    assert status == 0, error
    rows = json.loads(output)["rows"]
    methods = {row["method"] for row in rows}
    assert methods == set(FEW)
    cases = {(row["scene"], row["nuisance"], row["stratum"]) for row in rows}
    assert cases == {
        *(("plate_rotation", name, "all") for name in ("none", "exchange")),  # that camera stands
        *(
            ("rolling_wheel", name, stratum)
            for name in ("none", *severities)
            for stratum in ("all", "complex")
        ),
    }
    assert len(rows) == len(cases) * len(methods)

    def p95(scene, nuisance):
        return np.mean(
            [r["p95"] for r in rows if (r["scene"], r["nuisance"], r["stratum"]) == (scene, nuisance, "all")]
        )

    assert p95("plate_rotation", "exchange") > 1.5 * p95("plate_rotation", "none")
    assert (tmp_path / "nuisance.png").read_bytes()[:4] == b"\x89PNG"

    taken = []
    monkeypatch.setattr(
        "validation.studies.nuisance.picture_errors",
        lambda *given, **options: taken.append(given) or picture_errors(*given, **options),
    )
    for name in ("nuisance.csv", "measured-nuisance-plate_rotation-exchange-0.2.json"):
        (tmp_path / name).unlink()
    status, output, error = softbed("study", "nuisance", tmp_path, "--scene", tiny_wheel_scene, "--json")
    assert status == 0, error
    assert json.loads(output)["rows"] == rows
    assert len(taken) == 1  # the others are kept
    assert "pictures taken and measured" in error


def test_textures_of_a_tiny_wheel(softbed, tiny_wheel_scene, tmp_path, monkeypatch):
    monkeypatch.setattr("validation.studies.texture._FACTORS", (1.0, 1.3))
    monkeypatch.setattr("validation.studies.texture.installed", lambda: FEW)
    status, output, error = softbed("study", "texture", tmp_path, "--scene", tiny_wheel_scene, "--json")
    assert status == 0, error
    rows = json.loads(output)["rows"]
    keys = {(row["grain_diameter"], row["texture"], row["method"]) for row in rows}
    assert len(rows) == len(keys) == 2 * 2 * len(FEW)
    # Of one recording, every method is judged on the same pixels, and rigid tiles tear soil more.
    for diameter, texture in {(row["grain_diameter"], row["texture"]) for row in rows}:
        counts = {
            row["pixel_count"]
            for row in rows
            if (row["grain_diameter"], row["texture"]) == (diameter, texture)
        }
        assert len(counts) == 1
    by_texture = {
        texture: np.mean([row["complex_share"] for row in rows if row["texture"] == texture])
        for texture in ("interpolated", "carried")
    }
    assert by_texture["carried"] > by_texture["interpolated"]
    assert (tmp_path / "texture.png").read_bytes()[:4] == b"\x89PNG"
