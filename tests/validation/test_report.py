import base64
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from validation.figures import draw_forces, to_png
from validation.published import read_published

VOID = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "track", "wbr"}


class Page(HTMLParser):
    """What a page loads, and whether its tags are balanced."""

    def __init__(self, text):
        super().__init__()
        self.open, self.loads, self.ids, self.pictures = [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.loads += [values[name] for name in ("src", "href", "srcset", "data", "action") if name in values]
        self.ids += [values["id"]] if "id" in values else []
        self.pictures += [values] if tag == "img" else []
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def text(finished_run):
    return (finished_run / "report.html").read_text(encoding="utf-8")


def test_page_is_whole(text):
    page = Page(text)
    assert page.open == []
    assert text.startswith("<!DOCTYPE html>")
    assert page.ids == ["scores", "truth", "method-1", "method-2", "again"]
    assert len(page.ids) == len(set(page.ids))


def test_regions_of_every_method_stand_on_the_page(text):
    table = text.partition('<table class="regions">')[2].partition("</table>")[0]
    rows = re.findall(r'<tr><th scope="row">(\S+)</th>\s*<td>([\d.]+)</td>', table)
    assert [name for name, _ in rows] == ["dis", "farneback"]
    assert all(float(soil_iou) > 0.95 for _, soil_iou in rows)


def test_page_needs_nothing_else(text):
    page = Page(text)
    assert page.loads and all(address.startswith("data:image/png;base64,") for address in page.loads)
    for word in ("<script", "@import", "url(", "<link", "<iframe"):
        assert word not in text


def test_figures_are_pictures_with_a_name(text):
    pictures = Page(text).pictures
    assert len(pictures) == 4 + 2 * 4
    for picture in pictures:
        assert picture["alt"]
        content = base64.b64decode(picture["src"].partition(",")[2], validate=True)
        assert content.startswith(b"\x89PNG")


def test_page_tells_what_was_run(text):
    for words in (
        "tiny",
        "0.15",
        "0.30",
        "Journal of Field Robotics",
        "opencv-python-headless",
        "softbed run",
    ):
        assert words in text
    assert "rotation = 0.02944" in text


def test_page_escapes_what_it_is_given(softbed, tiny_scene, tmp_path):
    scene = tmp_path / "scene.toml"
    script = "<script>alert(1)</script>"
    scene.write_text(re.sub(r'description = "A.*"', f'description = "{script}"', tiny_scene.read_text()))
    assert softbed("run", scene, tmp_path / "out")[0] == 0
    assert script not in (tmp_path / "out" / "report.html").read_text()


def test_forces_over_time():
    time = np.linspace(-2, 1, 40)
    forces = {
        "time": time,
        "slip": np.full(40, 0.2),
        "sinkage": 0.01 + 0 * time,
        "force_x": np.sin(time),
        "force_z": 60 + time,
    }
    figure = draw_forces(forces, marked=0.5)
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "slip [%]", "sinkage [mm]", "drawbar pull [N]", "normal force [N]",
    ]  # fmt: skip
    assert to_png(figure) == to_png(draw_forces(forces, marked=0.5))


def test_published_numbers_name_their_place():
    rows = read_published("rotation")
    assert rows["median"].value == 0.15 and rows["p95"].value == 0.30
    assert all(row.where and row.unit for row in rows.values())


def test_a_wheel_s_page_shows_its_forces(softbed, tiny_wheel_scene, tmp_path):
    out = tmp_path / "out"
    status, _, error = softbed("run", tiny_wheel_scene, out)
    assert status == 0, error
    page = Page((out / "report.html").read_text())
    assert page.ids == ["scores", "truth", "method-1", "forces", "soundness", "again"]
    assert any("drawbar pull" in picture["alt"] for picture in page.pictures)
