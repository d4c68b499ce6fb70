"""A part of the picture."""

from dataclasses import dataclass

import numpy as np

from soft.sequence.error import SequenceError
from soft.sequence.number import whole


@dataclass(frozen=True)
class Region:
    """A rectangle of whole pixels.

    Attributes
    ----------
    x, y : int
        Column and row of its upper left pixel in the picture.
    width, height : int
        Columns and rows.

    Raises
    ------
    SequenceError
        If one is not a whole number, or too small.
    """

    x: int
    y: int
    width: int
    height: int

    def __post_init__(self) -> None:
        for name, least in (("x", 0), ("y", 0), ("width", 2), ("height", 2)):
            whole(f"region {name}", getattr(self, name), least=least)

    def require_within(self, shape: tuple[int, int]) -> None:
        """Refuse a picture (rows, columns) that does not hold all of it.

        Raises
        ------
        SequenceError
            If a part of it lies outside.
        """
        if self.x + self.width > shape[1] or self.y + self.height > shape[0]:
            raise SequenceError(
                f"region {self.x},{self.y},{self.width},{self.height}: must lie within the picture of "
                f"{shape[1]} x {shape[0]} px"
            )

    def of(self, picture: np.ndarray) -> np.ndarray:
        """Cut it out: (height, width, ...) array of its own from (H, W, ...)."""
        return picture[self.y : self.y + self.height, self.x : self.x + self.width].copy()
