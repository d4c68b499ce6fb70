"""A film says what its pictures show, page by page, and holds one of them at a time."""

import weakref

import cv2
import numpy as np
import pytest
from PIL import Image

from soft import FigureError, ImageSequence, analyze, flow_film
from soft.figures.colours import COLOURS
from soft.figures.film import FilmPage, Panel, Shot, label_of
from soft.figures.film_file import film_file
from soft.figures.units import Units


def frames_of(path):
    """Every picture of a film, red, green, blue."""
    if path.suffix == ".gif":
        with Image.open(path) as film:
            for k in range(film.n_frames):
                film.seek(k)
                yield np.asarray(film.convert("RGB"))
        return
    video = cv2.VideoCapture(str(path))
    while (read := video.read())[0]:
        yield cv2.cvtColor(read[1], cv2.COLOR_BGR2RGB)


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_pictures_come_back_in_order_and_colour(tmp_path, suffix):
    path = tmp_path / f"film{suffix}"
    colours = [(220, 30, 30), (30, 200, 40), (40, 60, 220)]
    with film_file(path, rate=4) as film:
        for colour in colours:
            film.add(np.broadcast_to(np.array(colour, np.uint8), (60, 81, 3)))
    back = list(frames_of(path))
    assert len(back) == 3
    for picture, colour in zip(back, colours, strict=True):
        np.testing.assert_allclose(picture.mean(axis=(0, 1)), colour, atol=12)


def test_a_gif_keeps_its_time_and_goes_on_for_ever(tmp_path):
    with film_file(tmp_path / "a.gif", rate=4) as film:
        for grey in (10, 200):
            film.add(np.full((20, 30, 3), grey, np.uint8))
    with Image.open(tmp_path / "a.gif") as back:
        assert (back.info["duration"], back.info["loop"], back.n_frames) == (250, 0, 2)


def test_an_mp4_is_of_a_codec_that_browsers_play(tmp_path):
    with film_file(tmp_path / "a.mp4", rate=8) as film:
        film.add(np.zeros((20, 30, 3), np.uint8))
    video = cv2.VideoCapture(str(tmp_path / "a.mp4"))
    assert int(video.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little") == b"VP90"
    assert video.get(cv2.CAP_PROP_FPS) == 8


def test_a_gif_keeps_rare_colours(tmp_path):
    picture = np.repeat(np.random.default_rng(4).integers(0, 256, (200, 300, 1), np.uint8), 3, axis=2)
    bar = np.stack([np.arange(0, 240, 8), np.arange(240, 0, -8), np.full(30, 128)], axis=-1)
    picture[:30, :3] = bar[:, None]
    with film_file(tmp_path / "a.gif", rate=8) as film:
        film.add(picture)
    (back,) = frames_of(tmp_path / "a.gif")
    np.testing.assert_allclose(back[:30, 1], bar, atol=16)


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_no_picture_is_held(tmp_path, suffix):
    with film_file(tmp_path / f"a{suffix}", rate=8) as film:
        held = []
        for grey in range(0, 200, 20):
            picture = np.full((40, 60, 3), grey, np.uint8)
            held.append(weakref.ref(picture))
            film.add(picture)
            del picture
        assert not any(reference() is not None for reference in held)


def test_other_suffixes_are_refused(tmp_path):
    with (
        pytest.raises(FigureError, match=r"a\.avi: suffix '\.avi': allowed are \.mp4, \.gif"),
        film_file(tmp_path / "a.avi", rate=8),
    ):
        pass


def test_a_page_shows_the_new_values_and_only_them():
    panels = [Panel("Picture"), Panel("Speed", "batlow", "speed [px/frame]", 0.0, 2.0)]
    page = FilmPage(panels, (40, 60), (40, 60), units=Units(), pixels=800, colours=COLOURS["even"])
    grey, speed = np.full((40, 60), 128.0), np.full((40, 60), 2.0)
    first = page.draw(Shot("frame 0", grey, (None, speed)))
    second = page.draw(Shot("frame 0", grey, (None, 0 * speed)))
    assert first.shape == second.shape and first.shape[1] == pytest.approx(800, abs=2)
    differs = np.flatnonzero((first != second).any(axis=(0, 2)))
    assert differs.min() > 400, "the picture's half must stay"
    np.testing.assert_array_equal(page.draw(Shot("frame 0", grey, (None, speed))), first)


def test_a_page_draws_the_shear_interface_where_it_is_told():
    panels = [Panel("Picture"), Panel("Speed", "batlow", "speed [px/frame]", 0.0, 2.0)]
    page = FilmPage(panels, (40, 60), (40, 60), units=Units(), pixels=800, colours=COLOURS["even"])
    grey, speed = np.full((40, 60), 128.0), np.full((40, 60), 2.0)
    line = np.array([[10.0, 20.0], [50.0, 20.0]])
    without = page.draw(Shot("frame 0", grey, (None, speed)))
    drawn = page.draw(Shot("frame 0", grey, (None, speed), ((), (line,))))
    rows, columns = np.nonzero((drawn != without).any(axis=2))
    assert columns.min() > 400 and np.ptp(rows) < 10 < np.ptp(columns)
    np.testing.assert_array_equal(page.draw(Shot("frame 0", grey, (None, speed))), without)


def test_film_of_a_measurement(moved, tmp_path):
    pictures = [moved(shift=(0.0, -1.5 * k))[1] for k in range(4)]
    sequence = ImageSequence.from_arrays(pictures, metres_per_pixel=1e-3, frame_rate=5)
    flow = analyze(sequence, method="dis", soil="all")
    told = []
    flow_film(flow, sequence, tmp_path / "a.gif", progress=lambda done, total: told.append((done, total)))
    assert told == [(1, 3), (2, 3), (3, 3)]
    assert len(list(frames_of(tmp_path / "a.gif"))) == 3
    assert label_of(flow, 2) == "frames 2 to 3, 0.400 s"
