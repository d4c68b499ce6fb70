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
    def in_plane(self) -> np.ndarray:
        """Positions along the bin and upwards, m, shape (2, N)."""
        return self.position

    @property
    def volume(self) -> np.ndarray:
        """Area: volume per metre of width, m2, shape (N,)."""
        return np.pi * self.radius**2

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
        overlap = self.radius[i] + self.radius[j] - length_of(position[:, i] - position[:, j])
        return pairs[:, overlap > 0], overlap[overlap > 0]

    def only(self, chosen: np.ndarray) -> "Grains":
        """The chosen grains, by mask or in the order of indices."""
        return type(self)(
            self.position[:, chosen],
            self.velocity[:, chosen],
            self.angle[chosen],
            self.spin[..., chosen],
            self.radius[chosen],
            self.density,
        )


@dataclass(frozen=True)
class Spheres(Grains):
    """Spheres in a slab: x along the bin, y from the glass into the slab, z up; N of them.

    A camera before the glass looks along y, so that x is right, z up, and the axes right-handed.

    Attributes
    ----------
    position, velocity : ndarray, shape (3, N)
        x, y and z; m and m/s.
    angle : ndarray, shape (N,)
        What the camera sees of their rotation: the integral of -`spin[1]`, rad, counter-clockwise positive.
    spin : ndarray, shape (3, N)
        Angular velocity about x, y and z, rad/s.
    radius : ndarray, shape (N,)
        m.
    density : float
        Of a grain, kg/m3: that of the bed divided by the share of its volume that grains fill.
    """

    @classmethod
    def at_rest(cls, position: np.ndarray, radius: np.ndarray, density: float) -> "Spheres":
        """Grains that neither move nor turn."""
        still = np.zeros_like(position)
        return cls(position, still, np.zeros(radius.size), still.copy(), radius, density)

    @property
    def in_plane(self) -> np.ndarray:
        """Positions along the bin and upwards, m, shape (2, N)."""
        return self.position[[0, 2]]

    @property
    def volume(self) -> np.ndarray:
        """m3, shape (N,)."""
        return 4 / 3 * np.pi * self.radius**3

    @property
    def mass(self) -> np.ndarray:
        """kg, shape (N,)."""
        return self.density * self.volume

    @property
    def inertia(self) -> np.ndarray:
        """Moment of inertia of a homogeneous sphere, kg m2, shape (N,)."""
        return 0.4 * self.mass * self.radius**2


def length_of(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (2 or 3, N), shape (N,)."""
    return np.asarray(np.hypot.reduce(vectors, axis=0))


def grains_of(position: np.ndarray) -> type[Grains]:
    """Discs or spheres, by the number of coordinates."""
    return Spheres if len(position) == 3 else Grains
