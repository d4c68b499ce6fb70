"""A picture on another grid: lens distortion out, seen square on the glass."""

from dataclasses import dataclass

import numpy as np

from soft.sequence.error import SequenceError
from soft.sequence.region import Region


@dataclass(frozen=True, eq=False)
class Resampling:
    """Where on the camera's picture each pixel of a new one lies.

    Attributes
    ----------
    source : (H, W, 2) float32
        x and y px on the camera's picture, whose pixel centres are whole numbers.
    shape : (int, int)
        Rows and columns of the camera's picture.
    """

    source: np.ndarray
    shape: tuple[int, int]

    @property
    def seen(self) -> np.ndarray:
        """Pixels that the camera's picture holds, (H, W) bool."""
        x, y = self.source[:, :, 0], self.source[:, :, 1]
        height, width = self.shape
        return (x >= 0) & (y >= 0) & (x <= width - 1) & (y <= height - 1)

    def cropped(self, region: Region) -> "Resampling":
        """Keep a part of the new picture only."""
        region.require_within(self.source.shape[:2])
        return Resampling(region.of(self.source), self.shape)

    def of(self, picture: np.ndarray) -> np.ndarray:
        """Grey levels of the new picture by cubic splines, (H, W) float32.

        OpenCV's own remapping rounds positions to 1/32 px, which would be seen as motion. Beyond the picture,
        its border's grey levels go on; `seen` tells where.

        Parameters
        ----------
        picture : (rows, columns) float32
            The camera's, of `shape`.
        """
        from scipy.ndimage import map_coordinates

        self._require_shape(picture)
        height, width = self.shape
        x = np.clip(self.source[:, :, 0], 0, width - 1)
        y = np.clip(self.source[:, :, 1], 0, height - 1)
        grey = map_coordinates(picture, [y, x], order=3, mode="mirror", output=np.float32)
        # A spline through white and black may go a little beyond.
        return np.clip(grey, 0, 255, out=grey)

    def of_mask(self, mask: np.ndarray) -> np.ndarray:
        """Nearest pixels of a mask, (H, W) bool; False where nothing is seen."""
        self._require_shape(mask)
        height, width = self.shape
        column = np.clip(np.rint(self.source[:, :, 0]), 0, width - 1).astype(np.intp)
        row = np.clip(np.rint(self.source[:, :, 1]), 0, height - 1).astype(np.intp)
        return mask[row, column] & self.seen

    def _require_shape(self, picture: np.ndarray) -> None:
        if picture.shape != self.shape:
            raise SequenceError(
                f"calibrated for {self.shape[1]} x {self.shape[0]} px, "
                f"but the pictures have {picture.shape[1]} x {picture.shape[0]} px"
            )
