import numpy as np
import pytest

from soft import ImageSequence, PairSelection, SequenceError


@pytest.mark.parametrize(
    ("choice", "pairs"),
    [
        ({}, ((0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 6))),
        ({"stride": 3}, ((0, 3), (1, 4), (2, 5), (3, 6))),
        ({"every": 3}, ((0, 1), (3, 4))),
        ({"every": 3, "stride": 3}, ((0, 3), (3, 6))),
        ({"start": 2, "stop": 5}, ((2, 3), (3, 4))),
        ({"start": 1, "stop": 100, "stride": 2, "every": 2}, ((1, 3), (3, 5))),
    ],
)
def test_pairs_of_seven_frames(choice, pairs):
    assert PairSelection(**choice).of(7) == pairs


def test_time_of_a_pair_is_that_of_its_stride():
    frames = [np.full((4, 5), k, np.uint8) for k in range(7)]
    sequence = ImageSequence.from_arrays(frames, frame_rate=8, metres_per_pixel=1e-3)
    assert sequence.select(stride=4, every=2).pair_time == 0.5
    assert sequence.select(every=3).pair_time == 0.125


def test_each_picture_comes_in_its_place_and_is_decoded_once_where_it_can_be():
    read = []

    class Counted:
        names, shape, files, frame_rate = tuple("abcdefg"), (2, 3), (), None

        def read(self, index):
            read.append(index)
            return np.full((2, 3), index, np.float32)

    for choice, count in (({}, 7), ({"stride": 2}, 10), ({"stride": 3, "every": 3}, 3)):
        read.clear()
        sequence = ImageSequence(Counted()).select(**choice)
        seen = [(int(a[0, 0]), int(b[0, 0])) for a, b in sequence.picture_pairs()]
        assert tuple(seen) == sequence.pairs
        assert len(read) == count


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ({"start": 6}, "no pair in 7 frames"),
        ({"stride": 7}, "no pair in 7 frames"),
        ({"stop": 1}, "no pair in 7 frames"),
        ({"stride": 0}, "stride: 0: must be a whole number, 1 or more"),
        ({"every": 1.5}, "every: 1.5: must be a whole number"),
        ({"start": -1}, "start: -1: must be a whole number, 0 or more"),
        ({"stop": True}, "stop: True: must be a whole number"),
    ],
)
def test_choices_that_leave_nothing(choice, message):
    sequence = ImageSequence.from_arrays([np.zeros((4, 5), np.uint8)] * 7)
    with pytest.raises(SequenceError, match=message):
        sequence.select(**choice)
