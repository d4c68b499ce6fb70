"""How sure: the spread of motion fields that the energy allows.

At the solution the reweighted equations' matrix A stands for the energy's curvature. With noise of variance
s^2 in the data, the posterior covariance is (s / data_width)^2 A^-1. Its diagonal is found by sampling:
A x = n with n of covariance A makes x of covariance A^-1 (Papandreou and Yuille, NIPS 2010). Not calibrated:
the prior is the smoothness term, and what breaks brightness constancy is not in it.
"""

import numpy as np

from soft.flow.black_anandan.energy import Energy

_SAMPLES = 8
_AROUND = 3.0
"""Standard deviation of the window in which samples are averaged, px."""
_TOLERANCE = 0.05


def standard_deviation(energy: Energy, flow: np.ndarray) -> np.ndarray:
    """One sigma of u and of v at `flow` (H, W, 2), px: (H, W, 2) float32; zero where nothing was asked."""
    energy.linearize(flow)
    energy.weigh(flow)
    noise = energy.noise(flow) / energy.data_width
    random, total = np.random.default_rng(0), np.zeros_like(flow)
    for _ in range(_SAMPLES):
        _fill(energy, random)
        total += energy.system.solve(_TOLERANCE) ** 2
    return noise * np.sqrt(_averaged(total / _SAMPLES, energy.linked))


def _fill(energy: Energy, random: np.random.Generator) -> None:
    """Put noise of the matrix's covariance on the right-hand side: a draw for each term of the energy."""
    tensor, links, right = energy.system.tensor, energy.system.links, energy.system.right
    drawn = random.standard_normal((*right.shape[:2], 5), dtype=np.float32)
    right[:, :, 0] = np.sqrt(tensor[:, :, 0]) * drawn[:, :, 0]
    right[:, :, 1] = np.copysign(np.sqrt(tensor[:, :, 2]), tensor[:, :, 1]) * drawn[:, :, 0]
    steps = np.sqrt(links) * drawn[:, :, 1:]
    right -= steps[:, :, :2] + steps[:, :, 2:]
    right[:, 1:] += steps[:, :-1, :2]
    right[1:] += steps[:-1, :, 2:]


def _averaged(values: np.ndarray, linked: np.ndarray) -> np.ndarray:
    """Gaussian average over linked pixels."""
    import cv2

    share = cv2.GaussianBlur(linked, (0, 0), _AROUND)
    average = cv2.GaussianBlur(values * linked[:, :, None], (0, 0), _AROUND)
    return average / np.maximum(share, 1e-6)[:, :, None]
