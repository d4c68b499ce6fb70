"""Growth of a mask by so many pixels each way (morphological dilation)."""

import numpy as np


def grown(mask: np.ndarray, by: int) -> np.ndarray:
    """Every pixel with one of the mask's at most `by` px off along x and along y: (H, W) bool."""
    import cv2

    square = np.ones((2 * by + 1, 2 * by + 1), np.uint8)
    return cv2.dilate(mask.astype(np.uint8), square) > 0
