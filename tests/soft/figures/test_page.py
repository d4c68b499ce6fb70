import numpy as np
import pytest

from soft import FigureError, picture_figure, save_figure
from soft.figures.page import new_page


def figure():
    return picture_figure(np.random.default_rng(1).uniform(0, 255, (60, 90)), title="Grains")


@pytest.mark.parametrize(("suffix", "begin"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_files_are_what_their_names_say_and_equal_again(tmp_path, suffix, begin):
    paths = [save_figure(figure(), tmp_path / f"{k}.{suffix}") for k in range(2)]
    contents = [path.read_bytes() for path in paths]
    assert contents[0] == contents[1]
    assert contents[0].startswith(begin)


def test_letters_stay_letters(tmp_path):
    assert ">Grains<" in save_figure(figure(), tmp_path / "a.svg").read_text()


def test_other_suffixes_are_refused(tmp_path):
    with pytest.raises(FigureError, match=r"a\.bmp: suffix '\.bmp': allowed are \.png, \.pdf, \.svg"):
        save_figure(figure(), tmp_path / "a.bmp")


@pytest.mark.parametrize("shape", [(100, 400), (300, 400), (900, 300)])
def test_panels_have_the_shape_of_the_picture_and_do_not_overlap(shape):
    page, grid = new_page(shape, rows=2, columns=2)
    size = page.get_size_inches()
    boxes = [axes.get_position() for axes in grid.ravel()]
    for box in boxes:
        assert box.height * size[1] / (box.width * size[0]) == pytest.approx(shape[0] / shape[1])
        assert 0 <= box.x0 < box.x1 <= 1 and 0 <= box.y0 < box.y1 <= 1
    assert boxes[0].x1 < boxes[1].x0 and boxes[2].y1 < boxes[0].y0
