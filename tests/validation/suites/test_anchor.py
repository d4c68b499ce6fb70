"""The noise at which a method whose error is known shows the published one."""

import tomllib

import pytest

from validation.suites.anchor import METHOD, AnchorError, write_anchor


def lines(error_of):
    return [
        {"method": METHOD, "stratum": stratum, "label": f"noise-{level}", "median": error_of(level) + shift}
        for level in (300, 400, 500)
        for shift in (-0.001, 0.001)
        for stratum in ("all", "moving")
    ]


def test_finds_the_noise(tmp_path):
    path = tmp_path / "severity.toml"
    assert write_anchor(lines(lambda level: level / 3000), path) == pytest.approx(450, abs=1)
    assert tomllib.loads(path.read_text())["sensor"]["read_noise"] == pytest.approx(450, abs=1)


def test_does_not_extrapolate(tmp_path):
    with pytest.raises(AnchorError, match=r"do not enclose the published 0\.15 px"):
        write_anchor(lines(lambda level: level / 1000), tmp_path / "severity.toml")
