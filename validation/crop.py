"""A rectangle of a picture."""

from dataclasses import dataclass
from typing import Self

import numpy as np


class CropError(ValueError):
    """A rectangle that is none, or that a picture does not have; the message is one line."""


@dataclass(frozen=True)
class Crop:
    """A part of a picture: left column, top row, width and height, px."""

    x: int
    y: int
    width: int
    height: int

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read `X,Y,WIDTH,HEIGHT`.

        Raises
        ------
        CropError
            It is none.
        """
        parts = text.split(",")
        if len(parts) != 4 or not all(part.strip().isdecimal() for part in parts):
            raise CropError(f"crop {text!r}: X,Y,WIDTH,HEIGHT in whole px are needed")
        crop = cls(*(int(part) for part in parts))
        if min(crop.width, crop.height) < 1:
            raise CropError(f"crop {text!r}: WIDTH and HEIGHT of 1 px at least are needed")
        return crop

    def __str__(self) -> str:
        return f"{self.x},{self.y},{self.width},{self.height}"

    @property
    def rows(self) -> slice:
        """Its rows."""
        return slice(self.y, self.y + self.height)

    @property
    def columns(self) -> slice:
        """Its columns."""
        return slice(self.x, self.x + self.width)

    def require_within(self, shape: tuple[int, ...], name: str) -> None:
        """Refuse a picture, `name`, that does not have all of it.

        Raises
        ------
        CropError
            It reaches beyond.
        """
        height, width = shape
        if self.x + self.width > width or self.y + self.height > height:
            raise CropError(f"crop {self}: {name} has {width} x {height} px")

    def of(self, picture: np.ndarray, name: str) -> np.ndarray:
        """Cut it out of a picture, `name`."""
        self.require_within(picture.shape, name)
        return picture[self.rows, self.columns]
