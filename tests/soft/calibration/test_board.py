import pytest

from soft.calibration import CalibrationError, CharucoBoard, Chessboard, parse_board


def test_boards_as_written():
    assert parse_board("chessboard:9x6:0.025") == Chessboard(9, 6, 0.025)
    expected = CharucoBoard(11, 8, 0.02, 0.015, "DICT_5X5_100")
    assert parse_board("charuco:11x8:0.02:0.015:DICT_5X5_100") == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("chessboard", "allowed are chessboard:9x6"),
        ("circles:9x6:0.025", "allowed are chessboard:9x6"),
        ("chessboard:9:0.025", "allowed are chessboard:9x6"),
        ("chessboard:9x6:wide", "lengths must be numbers"),
        ("chessboard:9x6:0", "board square: 0.0: must be above 0 m"),
        ("chessboard:2x6:0.1", "board 2x6: needs at least 3 each way"),
        ("charuco:11x8:0.02:0.03:DICT_5X5_100", "board marker: 0.03 m: must be smaller than its square"),
        ("charuco:11x8:0.02:0.01:DICT_9X9", "board dictionary: 'DICT_9X9': OpenCV has none"),
        ("charuco:11x8:0.02:0.01:Board", "board dictionary: 'Board': OpenCV has none"),
    ],
)
def test_what_is_no_board(text, message):
    with pytest.raises(CalibrationError, match=message):
        parse_board(text)
