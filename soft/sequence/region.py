"""A part of the picture."""

from dataclasses import dataclass
from typing import Self

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

    @classmethod
    def parse(cls, text: str, *, name: str = "region") -> Self:
        """Read `X,Y,W,H`.

        Parameters
        ----------
        text : str
            What was written.
        name : str, optional
            What to call it in an error message.

        Raises
        ------
        SequenceError
            If it is no four whole numbers, or one is too small.
        """
        try:
            x, y, width, height = (int(part) for part in text.split(","))
        except ValueError:
            raise SequenceError(f"{name} {text!r}: must be four whole numbers X,Y,W,H in px") from None
        return cls(x, y, width, height)

    def __str__(self) -> str:
        """As it is written on the command line."""
        return f"{self.x},{self.y},{self.width},{self.height}"

    @property
    def rows(self) -> slice:
        """Its rows."""
        return slice(self.y, self.y + self.height)

    @property
    def columns(self) -> slice:
        """Its columns."""
        return slice(self.x, self.x + self.width)

    def require_within(self, shape: tuple[int, ...], *, name: str = "the picture") -> None:
        """Refuse a picture (rows, columns, ...), called `name`, that does not hold all of it.

        Raises
        ------
        SequenceError
            If a part of it lies outside.
        """
        if self.x + self.width > shape[1] or self.y + self.height > shape[0]:
            raise SequenceError(f"region {self}: must lie within {name} of {shape[1]} x {shape[0]} px")

    def of(self, picture: np.ndarray, *, name: str = "the picture") -> np.ndarray:
        """Cut it out: (height, width, ...) array of its own from (H, W, ...), called `name`.

        Raises
        ------
        SequenceError
            If a part of it lies outside.
        """
        self.require_within(picture.shape, name=name)
        return picture[self.rows, self.columns].copy()
