"""Settings of an analysis: from a file, and from options, which go before."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.terminal import Terminal

if TYPE_CHECKING:
    from soft import AnalysisSettings


def given_settings(
    file: Path | None, *, region: str | None = None, **sections: dict[str, Any]
) -> "AnalysisSettings":
    """Settings of a file, or the defaults, with options in the place of some.

    Parameters
    ----------
    region : str, optional
        As "X,Y,W,H".
    **sections
        Values by key, None where an option was not given.

    Raises
    ------
    soft.SettingsError, soft.SequenceError
        A value is not allowed.
    """
    from soft import AnalysisSettings, Region

    settings = AnalysisSettings() if file is None else AnalysisSettings.read(file)
    calibration = sections.get("calibration", {})
    if calibration.get("metres_per_pixel") is not None:
        # The option goes before whatever else the file finds the pixel size by.
        kept = settings.calibration.model_copy(
            update={"scale_points": None, "scale_length": None, "glass_points": None, "rectify": False}
        )
        settings = settings.model_copy(update={"calibration": kept})
    part = None if region is None else asdict(Region.parse(region, name="--region"))
    return settings.changed(name="options", region=part, **sections)


def settings_written(file: Path, terminal: Terminal) -> None:
    """Write all settings with their defaults, and say so."""
    from soft import write_settings

    with terminal.working():
        write_settings(file)
    terminal.show(f"{file}: written; change it, then: softbed analyze PATH --settings {file}")
    terminal.give({"schema_version": 1, "file": str(file)})
