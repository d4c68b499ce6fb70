"""The mean motion of grains around an implement, coarse-grained onto a raster that travels with it."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from synth.recording import Recording

_FULL = 0.4
"""Share of area filled by grains from which on there is soil; a bed has about 0.8."""
_REACH = 4.0
"""Grains further from the window than this many standard deviations of the kernel are left out."""


@dataclass(frozen=True)
class Window:
    """A rectangle: x from the implement's reference point, z above the levelled surface, m."""

    left: float
    right: float
    bottom: float
    top: float


@dataclass(frozen=True)
class FlowField:
    """Mean velocity of the soil in the bin's frame, over all frames of a recording.

    Attributes
    ----------
    x : ndarray, shape (X,)
        m from the implement's reference point.
    z : ndarray, shape (Z,)
        m above the levelled surface.
    velocity : ndarray, shape (2, Z, X)
        m/s in laboratory time, along x and z; NaN where there is no soil.
    """

    x: np.ndarray
    z: np.ndarray
    velocity: np.ndarray

    @property
    def shear(self) -> np.ndarray:
        """``u_x - w_z`` and ``u_z + w_x``, whose root of squares is the shear rate, 1/s, shape (2, Z, X).

        That is ``sqrt(2 D : D)`` with the velocity gradient's symmetric deviator D.
        """
        (u_z, u_x), (w_z, w_x) = (np.gradient(one, self.z, self.x) for one in self.velocity)
        return np.stack([u_x - w_z, u_z + w_x])


def mean_flow(recording: "Recording", window: Window, *, spacing: float, kernel: float) -> FlowField:
    """Coarse-grain the grains' displacements from frame to frame.

    Momentum and mass are smoothed by the same Gaussian and summed over the frames; velocity is their quotient
    (Goldhirsch, *Granular Matter* 12 (2010) 239).

    Parameters
    ----------
    spacing : float
        Of the raster, m.
    kernel : float
        Standard deviation of the Gaussian, m.
    """
    from scipy.ndimage import gaussian_filter

    margin = int(np.ceil(_REACH * kernel / spacing))
    x_edges = _edges(window.left, window.right, spacing, margin)
    z_edges = _edges(window.bottom, window.top, spacing, margin)
    sums = np.zeros((3, z_edges.size - 1, x_edges.size - 1))
    data, frames = recording.data, recording.frame_count
    area = np.pi * data["radius"].values ** 2
    surface, interval = float(data.attrs["surface_height"]), np.diff(data["time"].values)
    travel = data["implement_x"].values
    x, z = data["position_x"].values, data["position_z"].values
    for frame in range(frames - 1):
        at_x = (x[frame] + x[frame + 1] - travel[frame] - travel[frame + 1]) / 2
        at_z = (z[frame] + z[frame + 1]) / 2 - surface
        u, w = (x[frame + 1] - x[frame]) / interval[frame], (z[frame + 1] - z[frame]) / interval[frame]
        for sum_, weight in zip(sums, (area, area * u, area * w), strict=True):
            sum_ += np.histogram2d(at_z, at_x, (z_edges, x_edges), weights=weight)[0]
    mass, *momentum = (gaussian_filter(sum_, kernel / spacing, mode="constant") for sum_ in sums)
    with np.errstate(invalid="ignore", divide="ignore"):
        velocity = np.array(momentum) / mass
    velocity[:, mass < _FULL * spacing**2 * (frames - 1)] = np.nan
    inner = slice(margin, -margin or None)
    return FlowField(_middles(x_edges)[inner], _middles(z_edges)[inner], velocity[:, inner, inner])


def _edges(low: float, high: float, spacing: float, margin: int) -> np.ndarray:
    count = max(2, round((high - low) / spacing))
    return low + spacing * np.arange(-margin, count + margin + 1)


def _middles(edges: np.ndarray) -> np.ndarray:
    return (edges[1:] + edges[:-1]) / 2
