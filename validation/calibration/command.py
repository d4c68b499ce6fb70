"""From a soil's file to a calibrated one beside its figure."""

from pathlib import Path
from typing import TYPE_CHECKING

from synth.devices import start_taichi
from synth.disk import written_whole
from synth.scene import load_soil, soil_path
from validation.calibration.calibrate import Calibration, CalibrationError, Target, calibrate
from validation.calibration.evidence import soil_text

if TYPE_CHECKING:
    from validation.terminal import Terminal


def calibrate_file(
    soil: str,
    output: Path,
    *,
    friction_angle: float | None,
    relative_density: float | None,
    seed_count: int,
    overwrite: bool,
    threads: int,
    device: str,
    terminal: "Terminal",
) -> tuple[Calibration, Path]:
    """Calibrate a soil and write `output` and the figure, whose path is given back, too.

    Raises
    ------
    CalibrationError
        The files may not be written, or the soil cannot be calibrated.
    """
    figure = output.with_suffix(".png")
    _require_place(output, figure, overwrite)
    file = load_soil(soil)
    source = soil_path(soil).read_text(encoding="utf-8")
    target = Target.of(file, relative_density=relative_density, friction_angle=friction_angle)
    start_taichi(device, threads)
    with terminal.progress(f"calibrate {file.name}") as progress:
        calibration = calibrate(file.soil, target, seed_count=seed_count, progress=progress)
    text = soil_text(source, calibration)
    from validation.calibration.figure import calibration_figure
    from validation.figures import to_png

    picture = to_png(calibration_figure(calibration, file.published))
    for path, content in ((figure, picture), (output, text.encode())):
        with written_whole(path) as draft:
            draft.write_bytes(content)
    return calibration, figure


def _require_place(output: Path, figure: Path, overwrite: bool) -> None:
    """What takes minutes must not fail at its end."""
    if output.suffix != ".toml":
        raise CalibrationError(f"--output = {output}: a name that ends in .toml is needed")
    if not output.parent.is_dir():
        raise CalibrationError(f"--output = {output}: {output.parent} is not a folder")
    for file in (output, figure):
        if file.exists() and not overwrite:
            raise CalibrationError(f"--output = {output}: {file} is there already; --overwrite replaces it")
