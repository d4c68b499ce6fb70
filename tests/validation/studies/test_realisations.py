"""What studies make of several realisations, where the answer is known."""

import numpy as np
import pytest
from scipy.stats import ttest_ind

from synth import Recording, load_scene
from synth.recording import VARIABLES
from synth.scene_files import study_scene_names
from validation.figures import to_png
from validation.studies import find_study
from validation.studies.glass_friction import likeness
from validation.studies.grading import GRADED, UNIFORM, difference, difference_at_one_density
from validation.studies.grouser_spacing import forward_error
from validation.studies.study import Case, Run, changed


def noisy_layers(rng, *, factor, realisations, noise):
    """Velocities at the glass and at mid-plane, (realisations, 2, 12, 20)."""
    z, x = np.meshgrid(np.linspace(-1, 0, 12), np.linspace(-1, 1, 20), indexing="ij")
    motion = np.stack([np.exp(2 * z) * x, np.exp(2 * z) * (1 - x**2)])
    size = noise * np.sqrt((motion**2).mean())
    return (share * motion + rng.normal(0, size, (realisations, *motion.shape)) for share in (factor, 1.0))


def test_noise_of_layers_neither_biases_their_ratio_nor_its_error():
    rng = np.random.default_rng(0)
    found = np.array([likeness(*noisy_layers(rng, factor=0.6, realisations=6, noise=1.0)) for _ in range(40)])
    ratio, error = found.T
    assert ratio.mean() == pytest.approx(0.6, abs=3 * ratio.std() / np.sqrt(40))
    assert error.mean() == pytest.approx(ratio.std(), rel=0.3)
    glass, middle = noisy_layers(rng, factor=0.6, realisations=1, noise=1.0)
    assert likeness(glass, middle)[0] < 0.5  # of one realisation, noise passes for motion at mid-plane


def test_the_mid_plane_is_as_itself_and_places_without_soil_are_left_out():
    _, middle = noisy_layers(np.random.default_rng(1), factor=1.0, realisations=4, noise=0.3)
    middle[2, :, 0, 0] = np.nan
    assert likeness(middle, middle) == pytest.approx((1.0, 0.0), abs=1e-12)


def rows_of(graded, uniform, density_graded, density_uniform):
    beds = ((GRADED, graded, density_graded), (UNIFORM, uniform, density_uniform))
    return [
        {"bed": bed, "sinkage": value, "relative_density": density}
        for bed, values, densities in beds
        for value, density in zip(values, densities, strict=True)
    ]


def test_beds_differ_by_welchs_interval():
    graded, uniform = [8.1, 9.4, 8.8, 10.2], [11.0, 10.1, 12.3, 9.9]
    found = difference(rows_of(graded, uniform, [0.4] * 4, [0.4] * 4), "sinkage")
    bounds = ttest_ind(graded, uniform, equal_var=False).confidence_interval(0.95)
    assert found.value == pytest.approx(np.mean(graded) - np.mean(uniform))
    assert (found.low, found.high) == pytest.approx((bounds.low, bounds.high))


def test_what_density_does_is_taken_off():
    """Sinkage falls by 20 mm for a whole relative density; graded beds are denser."""
    rng = np.random.default_rng(2)
    dense, loose = rng.uniform(0.40, 0.46, 30), rng.uniform(0.32, 0.38, 30)
    noise = rng.normal(0, 0.05, (2, 30))
    rows = rows_of(12.5 - 20 * dense + noise[0], 12.0 - 20 * loose + noise[1], dense, loose)
    assert difference(rows, "sinkage").high < 0
    alike = difference_at_one_density(rows, "sinkage")
    assert alike.low < 0.5 < alike.high and alike.high - alike.low < 0.25


def test_a_recordings_row_and_what_is_concluded_of_several(make_run):
    study = find_study("grading")
    depths = {"graded": (8e-3, 9e-3, 10e-3), "uniform": (9e-3, 10e-3, 11e-3)}
    runs = [
        make_run(
            coarsening=4.0 if bed == "graded" else 1.0, seed=seed, sinkage=depth, density=0.4 + seed / 100
        )
        for bed, several in depths.items()
        for seed, depth in enumerate(several)
    ]
    findings = study.find(runs)
    assert [row["sinkage"] for row in findings.rows] == pytest.approx([8, 9, 10, 9, 10, 11])
    assert [row["bed"] for row in findings.rows] == ["graded"] * 3 + ["uniform"] * 3
    assert "over 3 seeds: sinkage -1 mm (-10 %, 95 %: -33 to +13 %)" in findings.conclusion
    assert to_png(study.draw(findings))[:4] == b"\x89PNG"


@pytest.fixture
def make_run(tmp_path):
    """A run whose wheel sank by so much, in a bed of so many fine grains."""
    scene = load_scene("rolling_wheel", quick=True)

    def make(*, coarsening, seed, sinkage, density):
        arrays = {
            name: np.zeros([{"frame": 2}.get(d, 3) for d in dims]) for name, (dims, *_) in VARIABLES.items()
        }
        arrays |= {"sample_time": np.array([-1.0, 1.0, 2.0]), "sinkage": np.array([1.0, sinkage, sinkage])}
        arrays |= {"force_x": np.full(3, 3.0 + seed), "torque": np.full(3, 1.0 + seed / 10)}
        path = tmp_path / f"{coarsening}-{seed}.nc"
        Recording.from_arrays(arrays, {"relative_density": density}).write(path)
        changes = {"coarsening": coarsening, "fine": None}
        return Run(Case(path.stem, changed(scene, bed=changes, seed=seed)), path)

    return make


def test_passages_that_are_alike_leave_no_error_and_chance_leaves_its_own():
    turns = np.linspace(0.005, 4.005, 401)
    periodic = np.where(np.mod(turns, 1) < 0.5, 2.0, -1.0)
    assert forward_error(periodic, turns) == pytest.approx(0, abs=1e-12)
    assert np.isnan(forward_error(periodic[:90], turns[:90]))
    rng = np.random.default_rng(3)
    scattered = [5.0 + periodic + rng.normal(0, 1, 5)[np.floor(turns).astype(int)] for _ in range(200)]
    assert np.mean([forward_error(one, turns) ** 2 for one in scattered]) == pytest.approx(1 / 4, rel=0.2)


@pytest.mark.parametrize("name", study_scene_names())
def test_scenes_of_studies_are_found_by_name_and_say_which_study(name):
    scene = load_scene(name)
    assert f"studies/{scene.name}" == name
    if scene.name == "graded_roll":
        labels = [case.label for case in find_study("grading").cases(scene, quick=True)]
        assert labels[:2] == ["graded-seed-0", "uniform-seed-0"] and len(labels) == 6
