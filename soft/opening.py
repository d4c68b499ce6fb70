"""`open_sequence`: opens pictures for an analysis, as settings say.

They are calibrated, undistorted, cut out, masked and paired.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from soft.calibration import GlassCalibration, Lens, calibrate_glass, metres_per_pixel_between
from soft.sequence import ImageSequence, Region
from soft.settings import AnalysisSettings, CalibrationSettings


def open_sequence(path: str | Path, settings: AnalysisSettings | None = None) -> ImageSequence:
    """Open pictures for an analysis.

    Parameters
    ----------
    path : str or Path
        A folder of pictures or a video, as `ImageSequence.open` takes it.
    settings : AnalysisSettings, optional
        By default, every consecutive pair of whole pictures.

    Raises
    ------
    SequenceError, CalibrationError
        If the pictures cannot be used, or not so.
    """
    settings = settings or AnalysisSettings()
    frames = settings.frames
    sequence = ImageSequence.open(
        path, metres_per_pixel=settings.calibration.metres_per_pixel, frame_rate=frames.frame_rate
    )
    sequence = _calibrated(sequence, settings.calibration)
    if settings.soil.masks is not None:
        sequence = sequence.mask(settings.soil.masks)
    if settings.region is not None:
        sequence = sequence.crop(Region(**settings.region.model_dump()))
    return sequence.select(start=frames.start, stop=frames.stop, stride=frames.stride, every=frames.every)


def _calibrated(sequence: ImageSequence, settings: CalibrationSettings) -> ImageSequence:
    lens = None if settings.lens is None else Lens.read(settings.lens)
    if settings.glass_points is not None:
        return _on_glass(sequence, settings, lens)
    if settings.scale_points is not None and settings.scale_length is not None:
        ends = np.array(settings.scale_points)
        first, second = ends if lens is None else lens.undistorted(ends)
        scale = metres_per_pixel_between(first, second, length=settings.scale_length)
        sequence = replace(
            sequence, metres_per_pixel=scale, calibration=f"scale of {settings.scale_length:g} m"
        )
    return sequence if lens is None else _undistorted(sequence, lens)


def _on_glass(sequence: ImageSequence, settings: CalibrationSettings, lens: Lens | None) -> ImageSequence:
    points = np.array(settings.glass_points)
    glass = calibrate_glass(points[:, :2], points[:, 2:], shape=sequence.frames.shape, lens=lens)
    told = f"glass points: {_words(glass)}"
    if settings.rectify:
        view = glass.rectification()
        sequence = sequence.resample(view.resampling, metres_per_pixel=view.metres_per_pixel)
        return replace(sequence, calibration=f"{told}, rectified")
    sequence = replace(sequence, metres_per_pixel=glass.metres_per_pixel, calibration=told)
    return sequence if lens is None else _undistorted(sequence, lens)


def _undistorted(sequence: ImageSequence, lens: Lens) -> ImageSequence:
    told = f"lens taken out, known to {lens.reprojection_error:.2f} px"
    before = f"{sequence.calibration}; " if sequence.calibration else ""
    return replace(sequence.resample(lens.undistortion()), calibration=f"{before}{told}")


def _words(glass: GlassCalibration) -> str:
    tilt = "" if glass.tilt is None else f", tilt {np.degrees(glass.tilt):.2f} degrees"
    return (
        f"{glass.point_count}, off by {glass.residual:.2f} px (rms), {glass.residual_max:.2f} px at most"
        f"{tilt}, pixel size {glass.metres_per_pixel:.4g} m, {glass.scale_spread:.1%} apart over the picture"
    )
