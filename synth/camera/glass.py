"""What lies between soil and sensor and is not soil: marks on the glass, reflections, dirt on the lens.

Scratches and smudges are fixed to the bin. Reflections and dirt are fixed to the picture: the lamps stand
with the camera, on the carriage or in the laboratory.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from synth.camera.streams import Purpose, random_stream
from synth.camera.view import View

if TYPE_CHECKING:
    from synth.camera.cover import Cover
    from synth.recording import Recording
    from synth.scene import Scene

_SCRATCHES = 3e4
"""1/m2, of glass: assumed, a bin in use."""
_SMUDGES = 1.5e3
"""1/m2, of glass: assumed."""
_SPECKS = 2e-5
"""1/px2, of dirt on lens or mirror: assumed."""
_HAZE = 0.3
"""Grey level / full scale of a smudge that hides everything behind it: dust."""
_LAMPS = ((0.22, 0.2), (0.78, 0.2))
"""Where the lamps are reflected: shares of the picture's width and height."""
_LAMP_SIZE = (0.03, 0.12)
"""Deviations of a reflection's glow: shares of the picture's width and height."""


@dataclass(frozen=True, eq=False)
class Glass:
    """Marks on the glass of everything that a recording's pictures show.

    Attributes
    ----------
    scratches : (n, 6) float64
        Both ends (x, z each) and half the width, m; strength, 0 to 1.
    smudges : (n, 4) float64
        Middle (x, z), deviation, m; strength, 0 to 1.
    lamps : (n, 4) float64
        Middle and deviations of reflections, px.
    dirt : (H, W) float32
        Share of the light that specks on the lens let pass.
    """

    scratches: np.ndarray
    smudges: np.ndarray
    lamps: np.ndarray
    dirt: np.ndarray

    @classmethod
    def of(cls, scene: "Scene", recording: "Recording") -> Self:
        """Marks drawn from the seed of the scene's pictures; none of those whose severity is 0."""
        nuisance, camera = scene.nuisance, scene.camera
        bounds = np.array([View.of(scene, recording, k).bounds() for k in range(recording.frame_count)])
        box = bounds[:, 0].min(), bounds[:, 1].max(), bounds[:, 2].min(), bounds[:, 3].max()
        scratches, smudges = _marks(scene.seed_of_pictures, box)
        across, down = np.array(_LAMPS).T
        lamps = np.column_stack(
            [
                across * camera.width,
                down * camera.height,
                np.full(len(across), _LAMP_SIZE[0] * camera.width),
                np.full(len(across), _LAMP_SIZE[1] * camera.height),
            ]
        )
        return cls(
            scratches if nuisance.scratches > 0 else scratches[:0],
            smudges if nuisance.smudges > 0 else smudges[:0],
            lamps if nuisance.reflections > 0 else lamps[:0],
            _dirt(scene),
        )

    @property
    def clear(self) -> bool:
        """Whether nothing is on the glass or reflected in it."""
        return not (len(self.scratches) or len(self.smudges) or len(self.lamps))

    def put_before(self, scene: "Scene", covered: "Cover", radiance: np.ndarray) -> None:
        """Change the light of every sample by what is on the glass."""
        from synth.camera import glass_kernels

        if self.clear:
            return
        nuisance = scene.nuisance
        glass_kernels.put_glass_before(
            glass_kernels.projection.numbers(covered.view.numbers),
            self.scratches,
            self.smudges,
            self.lamps,
            nuisance.scratches,
            nuisance.smudges,
            nuisance.reflections,
            _HAZE,
            covered.sampling,
            covered.margin,
            radiance,
        )


def _marks(seed: int, box: tuple[float, float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Scratches and smudges over left, right, bottom and top, m."""
    left, right, bottom, top = box
    area = (right - left) * (top - bottom)
    stream = random_stream(seed, Purpose.GLASS)
    count = max(round(_SCRATCHES * area), 1)
    x, z = stream.uniform(left, right, count), stream.uniform(bottom, top, count)
    # Soil is dragged along the glass: scratches are mostly level.
    length, angle = stream.exponential(0.01, count), stream.normal(0, 0.5, count)
    half, strength = stream.uniform(0.03e-3, 0.12e-3, count), stream.uniform(0.2, 1, count)
    end_x, end_z = x + length * np.cos(angle), z + length * np.sin(angle)
    scratches = np.column_stack([x, z, end_x, end_z, half, strength])
    count = max(round(_SMUDGES * area), 1)
    x, z = stream.uniform(left, right, count), stream.uniform(bottom, top, count)
    smudges = np.column_stack([x, z, stream.uniform(3e-3, 9e-3, count), stream.uniform(0.4, 1, count)])
    return scratches, smudges


def _dirt(scene: "Scene") -> np.ndarray:
    """Blurred specks, fixed to the picture; (H, W) float32, 1 where the lens is clean."""
    camera, severity = scene.camera, scene.nuisance.dirt
    passed = np.ones((camera.height, camera.width), np.float32)
    if severity == 0:
        return passed
    stream = random_stream(scene.seed_of_pictures, Purpose.DIRT)
    count = max(round(_SPECKS * camera.height * camera.width), 3)
    rows, columns = np.mgrid[: camera.height, : camera.width].astype(np.float32)
    places = zip(
        stream.uniform(0, camera.width, count),
        stream.uniform(0, camera.height, count),
        stream.uniform(2, 9, count),
        stream.uniform(0.5, 1, count),
        strict=True,
    )
    for x, y, size, strength in places:
        away = np.hypot(columns - np.float32(x), rows - np.float32(y)) / np.float32(size)
        # A speck out of focus: flat in the middle, with a soft edge.
        passed *= 1 - np.float32(severity * strength) / (1 + away**6)
    return passed
