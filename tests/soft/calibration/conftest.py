"""A camera whose lens is known, and photographs of boards through it, every pixel computed by itself."""

import cv2
import numpy as np
import pytest

SHAPE = (360, 480)
MATRIX = np.array([[520.0, 0, 246.3], [0, 515.0, 171.8], [0, 0, 1]])
DISTORTION = np.array([-0.22, 0.06, 0.0012, -0.0008, 0.0])
SAMPLES = 3


@pytest.fixture(scope="session")
def true_lens():
    from soft.calibration import Lens

    return Lens(SHAPE, MATRIX, DISTORTION)


def distort(rays):
    """Brown's model written out: (N, 2) rays to px."""
    x, y = rays.T
    k1, k2, p1, p2, k3 = DISTORTION
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    bent_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    bent_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.stack([MATRIX[0, 0] * bent_x + MATRIX[0, 2], MATRIX[1, 1] * bent_y + MATRIX[1, 2]], axis=1)


def straighten(pixels):
    """The ray of each px, by repeating what `distort` is off by."""
    centre, focal = MATRIX[:2, 2], np.diag(MATRIX)[:2]
    rays = (pixels - centre) / focal
    for _ in range(12):
        rays = rays - (distort(rays) - pixels) / focal
    return rays


@pytest.fixture(scope="session")
def rays():
    """Rays of every sample of every pixel: centres at whole numbers, SAMPLES each way evenly around them."""
    step = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    y = (np.arange(SHAPE[0])[:, None] + step).ravel()
    x = (np.arange(SHAPE[1])[:, None] + step).ravel()
    found = straighten(np.stack(np.meshgrid(x, y), axis=2).reshape(-1, 2))
    assert (
        np.abs(distort(found)[::997] - np.stack(np.meshgrid(x, y), axis=2).reshape(-1, 2)[::997]).max() < 1e-6
    )
    return found


POSES = [
    ((0.0, 0.0, 0.02), (0.0, 0.0, 0.42)),
    ((0.5, 0.0, 0.0), (-0.02, 0.01, 0.45)),
    ((-0.5, 0.1, 0.0), (0.03, -0.02, 0.45)),
    ((0.0, 0.5, 0.1), (-0.04, 0.02, 0.42)),
    ((0.1, -0.5, 0.0), (0.05, 0.0, 0.45)),
    ((0.35, 0.35, -0.2), (0.02, 0.04, 0.48)),
    ((-0.3, -0.4, 0.3), (-0.05, -0.04, 0.42)),
    ((0.2, 0.1, 1.4), (0.01, 0.0, 0.5)),
]


class Photographer:
    """Takes pictures of a flat thing through the lens."""

    def __init__(self, rays):
        self._rays = rays

    def picture(self, paint, pose):
        """(H, W) grey of `paint(x, y)`, grey at places in m on the thing, which lies as `pose` says."""
        rotation, shift = cv2.Rodrigues(np.array(pose[0]))[0], np.array(pose[1])
        rays = np.concatenate([self._rays, np.ones((len(self._rays), 1))], axis=1)
        normal = rotation[:, 2]
        place = (rays * ((normal @ shift) / (rays @ normal))[:, None] - shift) @ rotation
        grey = paint(place[:, 0], place[:, 1]).reshape(SHAPE[0], SAMPLES, SHAPE[1], SAMPLES)
        return grey.mean(axis=(1, 3)).astype(np.float32)

    @staticmethod
    def place(points, pose):
        """Px at which points (N, 2) m on the thing are seen."""
        rotation, shift = cv2.Rodrigues(np.array(pose[0]))[0], np.array(pose[1])
        seen = np.concatenate([points, np.zeros((len(points), 1))], axis=1) @ rotation.T + shift
        return distort(seen[:, :2] / seen[:, 2:])


@pytest.fixture(scope="session")
def photographer(rays):
    return Photographer(rays)
