"""Figures and films from the command line, and those that need the truth."""

import json
import re
import shutil

import cv2
import numpy as np
import pytest
from matplotlib.image import imread

from soft.figures.units import Units
from validation.figures import distribution_figure, error_figure, truth_figure
from validation.pair_view import Measured, Motion, PairView
from validation.showing.kinds import KINDS

SHAPE = (60, 90)


@pytest.fixture
def view():
    """Truth goes right by 2 px; measured is 0.3 px too much on the left half, nothing in a corner."""
    u, v = np.full(SHAPE, 2.0), np.zeros(SHAPE)
    error = np.zeros(SHAPE)
    error[:, :45] = 0.3
    error[:10, 80:] = np.nan
    measured = Measured(Motion(u + error, v), error, np.isnan(error), 0.0, np.ones(u.shape, bool))
    everywhere, nowhere = np.ones(SHAPE, bool), np.zeros(SHAPE, bool)
    strata = {"all": everywhere, "moving": everywhere, "complex": nowhere, "quiet": nowhere}
    units = Units.of(metres_per_pixel=5e-4, frame_rate=8)
    picture = np.random.default_rng(3).uniform(60, 200, SHAPE)
    return PairView(0, picture, Motion(u, v), strata, {"dis": measured}, 0.0, units)


def titled(figure):
    return {axes.get_title(loc="left"): axes for axes in figure.axes if axes.get_title(loc="left")}


def map_on(axes):
    return axes.get_images()[1]


def test_truth_and_measurement_have_one_scale_and_unit(view):
    panels = titled(truth_figure(view, "dis"))
    sides = f"Truth, pair {view.pair}", "Measured (dis)"
    assert set(panels) == {f"{side}: {what}" for side in sides for what in ("speed", "direction")}
    true, measured = (map_on(panels[f"{side}: speed"]) for side in sides)
    assert true.get_clim() == measured.get_clim()
    np.testing.assert_allclose(true.get_array(), 2 * 0.5 * 8, rtol=1e-6)
    np.testing.assert_allclose(measured.get_array()[:, :45], 2.3 * 0.5 * 8, rtol=1e-6)
    assert panels["Measured (dis): direction"].get_xlabel() == "x [mm]"


def test_error_is_in_px_and_what_was_missed_is_painted(view):
    axes = error_figure(view, "dis").axes[0]
    _, error, missed = axes.get_images()
    np.testing.assert_allclose(error.get_array()[:, :45], 0.3)
    np.testing.assert_array_equal(
        np.ma.getmaskarray(np.ma.masked_invalid(missed.get_array()))[:10, 80:], False
    )
    assert np.isnan(np.ma.filled(missed.get_array(), np.nan)[10:]).all()
    (words,) = (text.get_text() for text in axes.texts)
    assert "95 % within 0.30 px" in words and "100 px not measured" in words


def test_distribution_tells_its_bounds(view):
    figure = distribution_figure(view.measured["dis"], view.strata, published={"median": 0.15})
    left, right = figure.axes
    labels = [text.get_text() for text in left.get_legend().get_texts()]
    assert labels == ["median of all 0.30 px", "95 % of all 0.30 px", "published median 0.15 px"]
    assert "5300 pixels" in left.get_title(loc="left")
    heights = [bar.get_height() for bar in left.patches]
    assert sum(heights) == pytest.approx(100)
    curve = next(line for line in right.lines if line.get_label() == "all")
    assert np.interp(0.299, *curve.get_data()) == pytest.approx(100 * 2600 / 5300, abs=0.2)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("compare", "gain")])
def test_every_kind_from_the_command_line(softbed, finished_run, tmp_path, kind):
    out = tmp_path / f"{kind}.png"
    status, output, error = softbed("figure", kind, finished_run, "--method", "dis", "--out", out, "--json")
    assert status == 0, error
    assert json.loads(output) == {"schema_version": 1, "figure": kind, "file": str(out), "pair": 0}
    assert imread(out)[..., :3].std() > 0.05, "the figure is empty"
    assert [path.name for path in tmp_path.iterdir()] == [out.name]


def test_runs_beside_each_other(softbed, finished_run, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(finished_run, other)
    out = tmp_path / "both.svg"
    assert softbed("figure", "compare", finished_run, "--with", other, "--out", out)[0] == 0
    text = out.read_text()
    for name, what in ((finished_run.name, "speed"), ("other", "direction")):
        assert re.search(rf">{name}, pair \d+: {what}<", text)
    status, _, error = softbed("figure", "compare", finished_run, "--out", out)
    assert status == 2 and "needs what to set beside: give --with PATH" in error


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("gain",), "average over 1 pair: at least 2 are needed to tell what it gains"),
        (("speeed",), "'speeed': no such kind of figure: allowed are picture, speed"),
        (("speed", "--pair", 3), "--pair: 3: out has 1 pairs, 0 to 0"),
        (("speed", "--method", "tvl1"), "analyzed with dis, farneback: run `softbed analyze"),
        (("speed", "--out", "a.bmp"), "suffix '.bmp': allowed are .png, .pdf, .svg"),
    ],
)
def test_bad_orders_get_one_line(softbed, finished_run, arguments, complaint):
    kind, *options = arguments
    status, _, error = softbed("figure", kind, finished_run, *options)
    assert status == 2 and len(error.splitlines()) == 1 and complaint in error


def test_film_with_truth_of_a_run_and_without_of_pictures(softbed, finished_run, tmp_path):
    film = tmp_path / "film.mp4"
    status, output, error = softbed("film", finished_run, "--out", film, "--json")
    assert status == 0, error
    assert json.loads(output) == {"schema_version": 1, "file": str(film), "pair_count": 1}
    read, picture = cv2.VideoCapture(str(film)).read()
    assert read and picture.std() > 20
    pictures, results = tmp_path / "pictures", tmp_path / "results"
    shutil.copytree(finished_run / "footage" / "frames", pictures)
    assert softbed("analyze", pictures, "--method", "dis", "--soil", "all", "--out", results)[0] == 0
    status, _, error = softbed("film", pictures, "--results", results, "--out", tmp_path / "film.gif")
    assert status == 0 and "film: done" in error
    status, _, error = softbed("figure", "truth", pictures, "--results", results, "--out", tmp_path / "a.png")
    assert status == 2 and "holds no truth.nc" in error
