from dataclasses import dataclass

import numpy as np

from soft import segments_figure


@dataclass(frozen=True)
class Compared:
    points: np.ndarray
    sift: np.ndarray
    flow: np.ndarray
    agree: np.ndarray
    threshold: float
    match_count: int
    agreement: float


def compared(motion):
    points = np.array([[20.0, 30.0], [120.0, 60.0], [200.0, 100.0]])
    sift = np.tile(motion, (3, 1))
    flow = sift + np.array([[0.1, 0], [0, 2.0], [0.2, 0.2]])
    return Compared(points, sift, flow, np.array([True, False, True]), 0.56, 3, 2 / 3)


def test_segments_go_from_where_a_point_is_to_where_it_goes():
    one = compared([12.0, -3.0])
    axes = segments_figure(one, np.full((160, 300), 128.0)).axes
    for panel, motion in zip(axes, (one.sift, one.flow), strict=True):
        agree, disagree = (np.array(c.get_segments()) for c in panel.collections)
        np.testing.assert_allclose(agree[:, 0], one.points[[0, 2]])
        np.testing.assert_allclose(disagree[:, 1], (one.points + motion)[[1]])
        assert "times" not in panel.get_title(loc="left")


def test_agreement_is_blue_else_red_and_thicker():
    panel = segments_figure(compared([12.0, -3.0]), np.full((160, 300), 128.0)).axes[0]
    agree, disagree = panel.collections
    assert agree.get_color()[0][2] > 0.7 > agree.get_color()[0][0]
    assert disagree.get_color()[0][0] > 0.7 > disagree.get_color()[0][2]
    assert disagree.get_linewidth()[0] > agree.get_linewidth()[0]


def test_short_motion_is_drawn_longer_and_that_is_said():
    one = compared([1.0, 0.0])
    axes = segments_figure(one, np.full((160, 300), 128.0), metres_per_pixel=1e-3).axes
    segment = axes[0].collections[0].get_segments()[0]
    assert "drawn 10 times as long" in axes[0].get_title(loc="left")
    np.testing.assert_allclose(segment[1] - segment[0], [10, 0], atol=1e-9)
    assert axes[0].get_xlabel() == "" and axes[1].get_xlabel() == "x [mm]"


def test_the_share_is_told():
    texts = [
        text.get_text() for text in segments_figure(compared([1.0, 0.0]), np.zeros((160, 300))).axes[1].texts
    ]
    assert texts == ["66.7% agree within 0.56 px"]
