"""Pictures whose statistics are known are measured right."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.ndimage import gaussian_filter

from soft import Region
from validation.compare_pictures import picture_statistics, read_pictures

SIDE = 600


@pytest.fixture(scope="module")
def white():
    return np.random.default_rng(0).standard_normal((SIDE, SIDE))


def measured(picture):
    return picture_statistics([picture], "x")


def test_white_noise(white):
    found = measured(120 + 9 * white)
    assert found.noise == pytest.approx(9, rel=0.02)
    assert (found.contrast, found.deviation) == pytest.approx((9, 9), rel=0.02)
    assert found.spectrum_slope == pytest.approx(0, abs=0.05)
    assert found.autocorrelation_length < 1
    assert found.skewness == pytest.approx(0, abs=0.02)
    assert found.histogram.sum() == pytest.approx(1)
    # Central differences of white noise have the deviation 9 / sqrt(2) each; their magnitude is Rayleigh's.
    assert found.mean_intensity_gradient == pytest.approx(9 / np.sqrt(2) * np.sqrt(np.pi / 2), rel=0.01)


@pytest.mark.parametrize("blur", [2.0, 4.0])
def test_the_autocorrelation_length_of_blurred_noise(white, blur):
    picture = 120 + 60 * gaussian_filter(white, blur, mode="wrap")
    # Noise blurred by a Gaussian has the autocorrelation exp(-lag^2 / (4 blur^2)): 1/e at 2 blur.
    found = measured(picture)
    assert found.autocorrelation_length == pytest.approx(2 * blur, rel=0.03)
    assert found.noise < 0.05 * found.contrast


@pytest.mark.parametrize("slope", [-1.0, -2.5])
def test_the_slope_of_a_power_law(slope):
    frequency = np.fft.fftfreq(1024)
    radius = np.maximum(np.hypot(frequency[:, None], frequency), 1e-9)
    noise = np.random.default_rng(1).standard_normal((1024, 1024))
    shaped = np.fft.ifft2(np.fft.fft2(noise) * radius ** (slope / 2)).real
    shaped -= shaped.mean()
    assert measured(120 + 20 * shaped / shaped.std()).spectrum_slope == pytest.approx(slope, abs=0.12)


def test_noise_over_texture_and_uneven_light(white):
    generator = np.random.default_rng(2)
    texture = 150 * gaussian_filter(white, 2.0)
    ramp = np.linspace(-40, 40, SIDE)[:, None]
    found = measured(120 + texture + ramp + 4 * generator.standard_normal(texture.shape))
    assert found.noise == pytest.approx(4, rel=0.03)
    assert found.contrast == pytest.approx(np.hypot(texture.std(), 4), rel=0.05)
    assert found.deviation == pytest.approx(np.sqrt(texture.var() + 16 + ramp.var()), rel=0.02)


def test_a_step_of_grey_has_the_gradient_it_has():
    ramp = np.tile(2.0 * np.arange(100), (100, 1)) + np.random.default_rng(0).normal(0, 1e-6, (100, 100))
    assert measured(ramp).mean_intensity_gradient == pytest.approx(2.0)


def test_a_folder_is_taken_as_one_set(tmp_path, white):
    for k in range(12):
        Image.fromarray((120 + 5 * np.roll(white, k)).astype(np.uint8)).save(tmp_path / f"p{k}.png")
    (tmp_path / "notes.txt").write_text("mine")
    pictures = read_pictures(tmp_path, Region.parse("10, 20, 300, 200"))
    assert len(pictures) == 8
    assert pictures[0].shape == (200, 300)
    assert np.array_equal(pictures[0], read_pictures(tmp_path / "p0.png")[0][20:220, 10:310])


def test_binning_averages_squares(tmp_path):
    picture = np.arange(70 * 40, dtype=np.uint8).reshape(70, 40)
    Image.fromarray(picture).save(tmp_path / "picture.png")
    (binned,) = read_pictures(tmp_path / "picture.png", Region(1, 2, 38, 67), binning=3)
    assert binned.shape == (22, 12)
    assert binned[1, 2] == pytest.approx(picture[5:8, 7:10].mean())


def test_the_command(softbed, tmp_path, white):
    for name, blur in (("a", 1.0), ("b", 3.0)):
        picture = 120 + 80 * gaussian_filter(white, blur)
        Image.fromarray(picture.clip(0, 255).astype(np.uint8)).save(tmp_path / f"{name}.png")
    files = tmp_path / "a.png", tmp_path / "b.png"
    status, output, error = softbed("compare-pictures", *files, "--out", tmp_path / "f.png", "--json")
    assert status == 0, error
    document = json.loads(output)
    assert document["a"]["autocorrelation_length"] < document["b"]["autocorrelation_length"]
    assert document["a"]["name"] == "a.png" and len(document["a"]["histogram"]) == 256
    assert Image.open(tmp_path / "f.png").width > 900
    status, output, _ = softbed(
        "compare-pictures", *files, "--out", tmp_path / "f.png", "--crop-a", "0,0,64,64"
    )
    assert status == 0 and "autocorrelation length" in output and "f.png" in output


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["none.png", "a.png"], "no such picture"),
        (["a.png", "empty"], "no picture in it"),
        (["a.png", "a.png", "--crop-b", "0,0,9"], "--crop-b '0,0,9': must be four whole numbers"),
        (["a.png", "a.png", "--crop-b", "90,0,50,50"], "must lie within a.png of 100 x 100 px"),
        (["a.png", "a.png", "--crop-b", "0,0,10,50"], "10 x 50 px: at least 32"),
        (["a.png", "flat.png"], "no texture"),
        (["a.png", "a.png", "--out", "f.jpg"], "f.jpg: suffix '.jpg': allowed are .png"),
    ],
)
def test_what_cannot_be_compared_is_one_line(softbed, tmp_path, monkeypatch, white, arguments, says):
    monkeypatch.chdir(tmp_path)
    Image.fromarray((120 + 5 * white[:100, :100]).astype(np.uint8)).save("a.png")
    Image.fromarray(np.full((100, 100), 9, np.uint8)).save("flat.png")
    Path("empty").mkdir()
    status, output, error = softbed("compare-pictures", *arguments)
    assert (status, output) == (2, "")
    assert says in error and error.count("\n") == 1
    assert not Path("compare-pictures.png").exists() and not Path("f.jpg").exists()


def test_a_real_photograph(tmp_path):
    folder = Path(os.environ.get("SOFTBED_DATA", "nowhere")) / "tbar"
    if not folder.is_dir():
        pytest.skip("$SOFTBED_DATA has no tbar: real photographs of soil behind glass")
    found = picture_statistics(read_pictures(folder / "IMG_1062.jpg", Region(400, 2150, 1200, 700)), "tbar")
    assert found.spectrum_slope < -1  # soil is coarser than noise
    assert 2 < found.autocorrelation_length < 30
    assert found.noise < found.contrast / 3
