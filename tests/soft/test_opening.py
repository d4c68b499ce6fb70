import cv2
import numpy as np
import pytest

from soft import AnalysisSettings, CalibrationError, open_sequence
from soft.calibration import Lens


def settings(**tables):
    return AnalysisSettings.checked(tables, name="test")


def test_as_they_are(picture_folder):
    sequence = open_sequence(picture_folder)
    assert sequence.pairs == ((0, 1), (1, 2))
    assert (sequence.metres_per_pixel, sequence.calibration) == (None, "")


def test_pairs_region_masks_and_rate(picture_folder, tmp_path_factory):
    mask = tmp_path_factory.mktemp("masks") / "mask.png"
    cv2.imwrite(str(mask), np.pad(np.full((160, 110), 9, np.uint8), ((0, 0), (0, 110))))
    sequence = open_sequence(
        picture_folder,
        settings(
            frames={"stride": 2, "frame_rate": 4},
            region={"x": 100, "y": 10, "width": 50, "height": 60},
            soil={"masks": mask},
        ),
    )
    assert sequence.pairs == ((0, 2),)
    assert sequence.pair_time == 0.5
    assert sequence.usable(0).sum() == 10 * 60


def test_scale(picture_folder):
    table = {"scale_points": [[10, 20], [40, 60]], "scale_length": 0.1}
    sequence = open_sequence(picture_folder, settings(calibration=table))
    assert sequence.metres_per_pixel == pytest.approx(0.002)
    assert sequence.calibration == "scale of 0.1 m"


def test_glass_points_and_lens(picture_folder, tmp_path_factory):
    lens = Lens((160, 220), np.array([[300.0, 0, 109.5], [0, 300, 79.5], [0, 0, 1]]), np.zeros(5), 0.1)
    path = tmp_path_factory.mktemp("lens") / "lens.toml"
    lens.write(path)
    points = [[10, 150, 0, 0], [210, 150, 0.1, 0], [210, 10, 0.1, 0.07], [10, 10, 0, 0.07]]
    for rectify in (False, True):
        table = {"glass_points": points, "lens": path, "rectify": rectify}
        sequence = open_sequence(picture_folder, settings(calibration=table))
        assert sequence.metres_per_pixel == pytest.approx(0.0005, rel=1e-6)
        assert "tilt 0.00 degrees" in sequence.calibration
        assert ("rectified" in sequence.calibration) == rectify
        # Square already, and a lens without distortion: the pictures stay what they are.
        plain = open_sequence(picture_folder)[0]
        assert np.abs(sequence[0][2:158, 2:218] - plain[2:158, 2:218]).max() < 0.1
    with pytest.raises(CalibrationError, match="needed are 4"):
        open_sequence(picture_folder, settings(calibration={"glass_points": points[:3]}))
