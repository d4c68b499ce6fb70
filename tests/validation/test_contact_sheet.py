"""A contact sheet has every scene it is asked for, at every level, and is not made twice."""

import json

import cv2
import numpy as np

from validation.contact_sheet import CLEAN, LEVELS, quick_scene


def test_a_sheet_of_a_plate_and_an_analytic_scene(softbed, tmp_path):
    arguments = ("--scene", "plate_rotation", "--scene", "sand_aliased", "--json")
    status, output, error = softbed("contact-sheet", tmp_path, *arguments)
    assert status == 0, error
    sheet = json.loads(output)["sheet"]
    pictures = {
        name: cv2.imread(str(tmp_path / name), cv2.IMREAD_UNCHANGED)
        for name in (f"plate_rotation-{level}.png" for level in LEVELS)
    }
    camera = quick_scene("plate_rotation").camera
    assert all(picture.shape == (camera.height, camera.width) for picture in pictures.values())
    clean, light, heavy = (picture.astype(float) for picture in pictures.values())
    assert 0 < np.abs(light - clean).mean() < np.abs(heavy - clean).mean()
    assert (tmp_path / f"sand_aliased-{CLEAN}.png").is_file()
    assert not (tmp_path / "sand_aliased-heavy.png").exists()
    shown = cv2.imread(sheet, cv2.IMREAD_GRAYSCALE)
    assert shown.shape[1] > 3 * 400 and shown.shape[0] > 2 * 200
    before = (tmp_path / "contact-sheet.jpg").stat().st_mtime_ns
    assert softbed("contact-sheet", tmp_path, *arguments)[0] == 0
    assert (tmp_path / "contact-sheet.jpg").stat().st_mtime_ns == before


def test_a_scene_that_there_is_not_is_refused_before_any_is_simulated(softbed, tmp_path):
    status, _, error = softbed(
        "contact-sheet", tmp_path / "out", "--scene", "rolling_wheel", "--scene", "rolling_wheal"
    )
    assert status == 2
    assert error.count("\n") == 1 and "'rolling_wheal' is neither a file nor a shipped scene" in error
    assert not (tmp_path / "out").exists()
