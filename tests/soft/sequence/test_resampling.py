import numpy as np
import pytest

from soft import ImageSequence, Region, SequenceError
from soft.sequence.resampling import Resampling


def grid(shape, shift):
    y, x = np.mgrid[: shape[0], : shape[1]].astype(np.float32)
    return np.stack([x + shift[0], y + shift[1]], axis=2)


def test_pixel_centres_are_whole_numbers(texture, moved):
    """Seen half a pixel to the right, the picture is the texture there: neither more nor less than half."""
    picture, _, _ = moved()
    y, x = np.mgrid[:160, :220].astype(float)
    shifted = Resampling(grid((160, 220), (0.5, -0.25)), (160, 220)).of(picture)
    inner = (slice(10, -10), slice(10, -10))
    # The mean, as the texture is cut off at black and white: no spline passes through such a kink.
    error = np.abs(shifted - texture(x + 0.5, y - 0.25))[inner].mean()
    assert error < 0.1 < 0.02 * np.abs(shifted - texture(x, y))[inner].mean()


def test_beyond_the_picture_nothing_is_seen(moved):
    picture, _, _ = moved()
    resampling = Resampling(grid((170, 230), (-4.5, -2.0)), (160, 220))
    expected = np.zeros((170, 230), bool)
    expected[2:162, 5:224] = True
    assert np.array_equal(resampling.seen, expected)
    assert np.isfinite(resampling.of(picture)).all()
    assert np.array_equal(resampling.of_mask(np.ones((160, 220), bool)), expected)


def test_sequence_on_another_grid_and_a_part_of_it(moved):
    first, second, _ = moved(shift=(2.0, 1.0))
    sequence = ImageSequence.from_arrays([first, second], metres_per_pixel=1e-3)
    seen = sequence.resample(Resampling(grid((160, 220), (1.0, 0.0)), (160, 220)), metres_per_pixel=2e-3)
    assert seen.metres_per_pixel == 2e-3
    assert np.allclose(seen[0][:, :-1], first[:, 1:], atol=1e-3)
    assert seen.seen[:, :-1].all()
    assert not seen.seen[:, -1].any()
    part = seen.crop(Region(200, 10, 20, 30))
    assert part.shape == part[0].shape == part.usable(0).shape == (30, 20)
    assert np.allclose(part[0][:, :-1], first[10:40, 201:220], atol=1e-3)
    assert not part.usable(1)[:, -1].any()
    with pytest.raises(SequenceError, match="choose it after"):
        part.resample(Resampling(grid((160, 220), (0, 0)), (160, 220)))
    with pytest.raises(SequenceError, match="calibrated for 100 x 90 px, but the pictures have 220 x 160 px"):
        sequence.resample(Resampling(grid((90, 100), (0, 0)), (90, 100)))


def test_region(moved):
    first, second, _ = moved()
    sequence = ImageSequence.from_arrays([first, second]).crop(Region(x=30, y=20, width=50, height=40))
    assert sequence.shape == (40, 50)
    assert np.array_equal(sequence[0], first[20:60, 30:80])
    sequence[0][:] = 0
    assert np.array_equal(sequence[0], first[20:60, 30:80])
    for numbers, message in (
        ((200, 0, 21, 10), r"region 200,0,21,10: must lie within the picture of 220 x 160 px"),
        ((0, 0, 1, 10), "region width: 1: must be a whole number, 2 or more"),
        ((-1, 0, 9, 10), "region x: -1: must be a whole number, 0 or more"),
    ):
        with pytest.raises(SequenceError, match=message):
            ImageSequence.from_arrays([first, second]).crop(Region(*numbers))


def test_region_as_it_is_written():
    assert Region.parse("30, 20,50,40") == Region(30, 20, 50, 40)
    assert str(Region(30, 20, 50, 40)) == "30,20,50,40"
    for text, message in (
        ("1,2,3", "--crop '1,2,3': must be four whole numbers X,Y,W,H in px"),
        ("1,2,3,4.5", "four whole numbers"),
        ("1,2,3,-4", "region height: -4: must be a whole number, 2 or more"),
    ):
        with pytest.raises(SequenceError, match=message):
            Region.parse(text, name="--crop")
