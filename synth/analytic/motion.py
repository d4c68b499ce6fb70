"""Motions by formula: where each grain is in every frame, forwards and backwards.

Positions are px from the picture's middle, x right, y down. A motion is told in the coordinates of frame 0:
`place` says where a grain has gone by a frame, `origin` where it came from, and both are inverses of each
other for every frame, negative ones included. Angles are counter-clockwise as seen, as a plate's.
"""

import math
from abc import abstractmethod
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from synth.table import Table

Points = tuple[np.ndarray, np.ndarray]
"""x and y of points, px from the picture's middle; arrays of one shape."""

_GRADIENT_STEP = 1e-3
"""px; central differences over it are exact to 1e-6 for what varies over 2 px or more."""
_NEWTON_STEPS = 50
_NEWTON_END = 1e-12
"""px; a step below it ends Newton's method."""


class _Motion(Table):
    """What every motion can tell."""

    @abstractmethod
    def place(self, x: np.ndarray, y: np.ndarray, frame: int) -> Points:
        """Where points of frame 0 are in `frame`."""

    @abstractmethod
    def origin(self, x: np.ndarray, y: np.ndarray, frame: int) -> Points:
        """Where points of `frame` were in frame 0."""

    def folds_within(self, frame: int) -> bool:
        """Whether two points of frame 0 come to lie upon each other until `frame`."""
        return False

    def displacement(self, x: np.ndarray, y: np.ndarray, first: int, second: int) -> Points:
        """Motion of what is at the given points of frame `first`, to frame `second`: u and v, px."""
        x_then, y_then = self.place(*self.origin(x, y, first), second)
        return x_then - x, y_then - y

    def gradient(self, x: np.ndarray, y: np.ndarray, first: int, second: int) -> np.ndarray:
        """Gradient of `displacement`: (..., 2, 2) px/px, [.., i, j] = d(u, v)_i / d(x, y)_j."""
        step = _GRADIENT_STEP
        columns = []
        for right, down in ((step, 0.0), (0.0, step)):
            after = self.displacement(x + right, y + down, first, second)
            before = self.displacement(x - right, y - down, first, second)
            columns.append(np.stack([(a - b) / (2 * step) for a, b in zip(after, before, strict=True)], -1))
        return np.stack(columns, axis=-1)


class Translation(_Motion):
    """All grains move alike."""

    kind: Literal["translation"]
    u: float = Field(description="px a frame, to the right")
    v: float = Field(description="px a frame, downwards")

    def place(self, x: np.ndarray, y: np.ndarray, frame: int) -> Points:
        """Where points of frame 0 are in `frame`."""
        return x + frame * self.u, y + frame * self.v

    def origin(self, x: np.ndarray, y: np.ndarray, frame: int) -> Points:
        """Where points of `frame` were in frame 0."""
        return self.place(x, y, -frame)


class SimpleShear(_Motion):
    """Rows slide over each other, each as far as it lies below the centre."""

    kind: Literal["simple_shear"]
    shear: float = Field(ge=-1, le=1, description="px/px a frame; positive: below the centre to the right")
    centre_y: float = Field(default=0.0, description="px below the picture's middle, of the row at rest")

    def place(self, x: np.ndarray, y: np.ndarray, frame: int) -> Points:
        """Where points of frame 0 are in `frame`."""
        return x + frame * self.shear * (y - self.centre_y), y + 0.0

    def origin(self, x: np.ndarray, y: np.ndarray, frame: int) -> Points:
        """Where points of `frame` were in frame 0."""
        return self.place(x, y, -frame)


class _Turning(_Motion):
    """Every point stays on its circle about a pin."""

    centre_x: float = Field(default=0.0, description="px right of the picture's middle, of the pin")
    centre_y: float = Field(default=0.0, description="px below the picture's middle, of the pin")

    @abstractmethod
    def turn(self, radius: np.ndarray) -> np.ndarray | float:
        """Angle a frame (rad, counter-clockwise as seen) at a distance from the pin (px)."""

    def place(self, x: np.ndarray, y: np.ndarray, frame: int) -> Points:
        """Where points of frame 0 are in `frame`."""
        off_x, off_y = x - self.centre_x, y - self.centre_y
        angle = frame * self.turn(np.hypot(off_x, off_y))
        cosine, sine = np.cos(angle), np.sin(angle)
        return self.centre_x + cosine * off_x + sine * off_y, self.centre_y - sine * off_x + cosine * off_y

    def origin(self, x: np.ndarray, y: np.ndarray, frame: int) -> Points:
        """Where points of `frame` were in frame 0."""
        return self.place(x, y, -frame)


class Rotation(_Turning):
    """All grains turn rigidly about a pin."""

    kind: Literal["rotation"]
    angle: float = Field(ge=-math.pi, le=math.pi, description="rad a frame, counter-clockwise as seen")

    def turn(self, radius: np.ndarray) -> float:
        """Angle a frame, the same everywhere."""
        return self.angle


class ShearBand(_Turning):
    """A disc turns rigidly in soil at rest; between them is a band where the angle falls by a tanh.

    The slip circle of soil mechanics. `turn(r)` = jump / radius * (1 - tanh((r - radius) / scale)) / 2: it
    neither thickens nor thins the soil.
    """

    kind: Literal["shear_band"]
    radius: float = Field(gt=0, description="px, of the band's middle")
    jump: float = Field(description="px a frame along the circle, from one side of the band to the other")
    scale: float = Field(gt=0, description="px, of the tanh profile across the band")

    def turn(self, radius: np.ndarray) -> np.ndarray:
        """Angle a frame: jump / radius inside, half of it at the band's middle, 0 outside."""
        return self.jump / self.radius * 0.5 * (1 - np.tanh((radius - self.radius) / self.scale))


class SinusoidalStrain(_Motion):
    """Rows move up and down as a cosine of their height, whose period grows from left to right.

    v = amplitude cos(2 pi (y - middle) / period(x)), as the "star" pictures by which the spatial resolution
    of image correlation is measured (Reu et al., DIC Challenge 2.0, Experimental Mechanics 62, 2022). On the
    middle row v is `amplitude` at every period: what a method makes of it there, over x, is its response.
    """

    kind: Literal["sinusoidal_strain"]
    amplitude: float = Field(description="px a frame, downwards on the middle row")
    shortest: float = Field(gt=2, description="px, period at the left edge")
    longest: float = Field(gt=2, description="px, period at the right edge")
    span: float = Field(gt=0, description="px, from the left edge to the right edge")

    def period(self, x: np.ndarray) -> np.ndarray:
        """Period (px) at a place along x: grows by the same factor a px."""
        share = x / self.span + 0.5
        return self.shortest * (self.longest / self.shortest) ** share

    def place(self, x: np.ndarray, y: np.ndarray, frame: int) -> Points:
        """Where points of frame 0 are in `frame`."""
        return x + 0.0, y + frame * self.amplitude * np.cos(2 * np.pi * y / self.period(x))

    def origin(self, x: np.ndarray, y: np.ndarray, frame: int) -> Points:
        """Where points of `frame` were in frame 0, by Newton's method."""
        swing, number = frame * self.amplitude, 2 * np.pi / self.period(x)
        start = y + 0.0
        for _ in range(_NEWTON_STEPS if swing else 0):
            miss = start + swing * np.cos(number * start) - y
            step = miss / (1 - swing * number * np.sin(number * start))
            start = start - step
            if np.abs(step).max(initial=0) < _NEWTON_END:
                break
        return x + 0.0, start

    def folds_within(self, frame: int) -> bool:
        """Whether the strain reaches 0.8 until `frame`; at 1 the soil would fold over."""
        return abs(frame * self.amplitude) * 2 * math.pi / min(self.shortest, self.longest) > 0.8


Motion = Annotated[
    Translation | SimpleShear | Rotation | ShearBand | SinusoidalStrain, Field(discriminator="kind")
]
