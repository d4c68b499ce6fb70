"""The grains' state between runs of the solver."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Grains:
    """Discs in plane strain, N of them; everything per metre of width.

    Attributes
    ----------
    position, velocity : ndarray, shape (2, N)
        x and z; m and m/s.
    angle, spin : ndarray, shape (N,)
        rad and rad/s, counter-clockwise positive.
    radius : ndarray, shape (N,)
        m.
    density : float
        Of a grain, kg/m3: that of the bed divided by the share of its area that grains fill.
    """

    position: np.ndarray
    velocity: np.ndarray
    angle: np.ndarray
    spin: np.ndarray
    radius: np.ndarray
    density: float

    @classmethod
    def at_rest(cls, position: np.ndarray, radius: np.ndarray, density: float) -> "Grains":
        """Grains that neither move nor turn."""
        still = np.zeros(radius.size)
        return cls(position, np.zeros_like(position), still, still.copy(), radius, density)

    @property
    def count(self) -> int:
        """Number of grains."""
        return self.radius.size

    @property
    def mass(self) -> np.ndarray:
        """Mass per metre of width, kg/m, shape (N,)."""
        return self.density * np.pi * self.radius**2

    @property
    def inertia(self) -> np.ndarray:
        """Moment of inertia of a disc per metre of width, kg m, shape (N,)."""
        return 0.5 * self.mass * self.radius**2

    def touching(self, pairs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Those of the pairs (2, P) that are in contact, (2, K), and their overlaps, m, shape (K,)."""
        (i, j), position = pairs, self.position
        overlap = self.radius[i] + self.radius[j] - np.hypot(*(position[:, i] - position[:, j]))
        return pairs[:, overlap > 0], overlap[overlap > 0]

    def only(self, chosen: np.ndarray) -> "Grains":
        """The chosen grains, by mask or in the order of indices."""
        return Grains(
            self.position[:, chosen],
            self.velocity[:, chosen],
            self.angle[chosen],
            self.spin[chosen],
            self.radius[chosen],
            self.density,
        )
