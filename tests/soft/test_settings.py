import re
import tomllib

import pytest

from soft import AnalysisSettings, SettingsError, write_settings
from soft.settings import settings_template


def read(tmp_path, text):
    (tmp_path / "settings.toml").write_text(text)
    return AnalysisSettings.read(tmp_path / "settings.toml")


def test_template_is_the_defaults(tmp_path):
    path = tmp_path / "settings.toml"
    write_settings(path)
    assert AnalysisSettings.read(path) == AnalysisSettings()
    with pytest.raises(SettingsError, match="exists already"):
        write_settings(path)


def test_template_says_what_every_key_means():
    text = settings_template()
    keys = 0
    for section, field in AnalysisSettings.model_fields.items():
        assert f"[{section}]" in text
        table = type(field.default) if field.default is not None else None
        for key, inner in table.model_fields.items() if table else ():
            assert inner.description, key
            assert re.search(rf"^(# )?{key} = .*  # {re.escape(inner.description)}$", text, re.M), key
            keys += 1
    assert keys >= 16


def test_examples_in_the_template_are_allowed(tmp_path):
    """Each by itself, as only one can give the pixel size."""
    text = settings_template()
    for key in ("stop", "frame_rate", "metres_per_pixel", "glass_points", "lens", "masks"):
        changed = re.sub(rf"^# ({key} = )", r"\1", text, count=1, flags=re.M)
        assert changed != text
        assert read(tmp_path, changed) != AnalysisSettings()
    for keys in (("scale_points", "scale_length"), (r"\[region\]", "x", "y", "width", "height")):
        changed = text
        for key in keys:
            changed = re.sub(rf"^# ({key})", r"\1", changed, count=1, flags=re.M)
        assert read(tmp_path, changed) != AnalysisSettings()
    assert tomllib.loads(text)["flow"]["options"] == {}


def test_paths_are_relative_to_the_file(tmp_path):
    settings = read(tmp_path, "[soil]\nmasks = 'masks'\n[calibration]\nlens = '/a/lens.toml'\n")
    assert settings.soil.masks == tmp_path / "masks"
    assert str(settings.calibration.lens) == "/a/lens.toml"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[frames]\nstrid = 2", "settings.toml: frames.strid: there is no such key"),
        ("[frame]\n", "settings.toml: frame: there is no such key"),
        ("[frames]\nstride = 0", "frames.stride = 0: must be greater than or equal to 1"),
        ("[soil]\nkind = 'red'", "soil.kind = 'red': must be 'bright', 'dark' or 'all'"),
        ("[region]\nx = 1", "region.y: is missing"),
        ("[calibration]\nmetres_per_pixel = inf", "calibration.metres_per_pixel"),
        ("[calibration]\nrectify = true", "calibration: rectify: needs glass_points"),
        ("[calibration]\nscale_length = 1", "scale_points and scale_length: one needs the other"),
        (
            "[calibration]\nmetres_per_pixel = 1\nscale_points = [[0,0],[1,1]]\nscale_length = 1",
            "metres_per_pixel and scale_points: only one of them",
        ),
        (
            "[flow]\nmethod = 'os:system'",
            "method 'os:system': allowed are .*; any other is given on the command",
        ),
        ("[flow]\nmethod = 'files:x'", "method 'files:x': allowed are"),
        ("frames = 3", "settings.toml: frames = 3: must be a table"),
        ("[camera]\nmotion = 'rigid'", "camera.motion = 'rigid': must be 'median', 'mode' or 'far'"),
        ("= 1", "not a TOML file"),
    ],
)
def test_what_is_refused(tmp_path, text, message):
    with pytest.raises(SettingsError, match=message) as caught:
        read(tmp_path, text)
    assert "\n" not in str(caught.value)


def test_no_file(tmp_path):
    with pytest.raises(SettingsError, match=r"none\.toml: no such file"):
        AnalysisSettings.read(tmp_path / "none.toml")


def test_other_values_in_the_place_of_some():
    settings = AnalysisSettings().changed(
        frames={"stride": 3, "stop": None}, region={"x": 1, "y": 2, "width": 30, "height": 40}
    )
    assert (settings.frames.stride, settings.frames.stop, settings.region.width) == (3, None, 30)
    again = settings.changed(frames={"stop": 9})
    assert (again.frames.stride, again.frames.stop) == (3, 9)
    with pytest.raises(SettingsError, match=r"options: frames\.stride"):
        settings.changed(name="options", frames={"stride": 0})
