import numpy as np

from soft import CrossValidation, segments_figure


def compared(motion):
    points = np.array([[20.0, 30.0], [120.0, 60.0], [200.0, 100.0]])
    sift = np.tile(motion, (3, 1))
    flow = sift + np.array([[0.1, 0], [0, 2.0], [0.2, 0.2]])
    error, agree = np.hypot(*(flow - sift).T), np.array([True, False, True])
    return CrossValidation(
        points, sift, flow, error, agree, 0.56, keypoint_count=9, match_count=4, unmeasured_count=1,
        agreement=2 / 3,
    )  # fmt: skip


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


def test_a_leap_is_cut_and_that_is_said():
    one = compared([1.0, 0.0])
    one.sift[1] = (200.0, 0.0)
    panel = segments_figure(one, np.full((160, 300), 128.0)).axes[0]
    (segment,) = panel.collections[1].get_segments()
    np.testing.assert_allclose(segment[1] - segment[0], [0.12 * 300, 0], atol=1e-9)
    assert "1 segment cut short" in [text.get_text() for text in panel.texts]


def test_the_share_is_told():
    axes = segments_figure(compared([1.0, 0.0]), np.zeros((160, 300))).axes
    assert axes[0].get_title(loc="left").startswith("SIFT: motion at 3 key points")
    texts = [text.get_text() for text in axes[1].texts]
    assert texts == ["66.7% agree within 0.56 px; 4 of 9 features matched"]


def test_nothing_to_compare_is_said():
    none, nobody = np.zeros((0, 2)), np.zeros(0, bool)
    empty = CrossValidation(none, none, none, np.zeros(0), nobody, 0.56, 5, 0, 0, np.nan)
    texts = [text.get_text() for text in segments_figure(empty, np.zeros((160, 300))).axes[1].texts]
    assert texts == ["0 of 5 features matched: nothing to compare"]
