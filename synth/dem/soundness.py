"""Whether a simulation is sound: slow enough, stiff enough, and finely enough resolved in time.

Grains stand for soil that flows slowly only while their inertia is small against the pressure (inertial
number), their contacts are stiff against it (stiffness / pressure, overlap), and their collisions are
resolved. The dimensionless numbers are those of da Cruz, Emam, Prochnow, Roux, Chevoir, *Physical Review E*
72 (2005) 021309; the limits are this project's.

The inertial number's limit holds for the soil that carries the load: every grain that moves counts by its
share of it, pressure x volume. Counted alike, the number says nothing of the speed: under a free surface
pressure goes to nothing and the number beyond any limit, however slowly the implement is driven.

All is computed from a few recorded frames, after the run; nothing here feeds back into it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from synth.dem.bed import contact_law
from synth.dem.contact_law import ContactLaw, Law, shortest_contact, spring_force
from synth.dem.grains import Grains, length_of
from synth.dem.log import Frame, RunLog
from synth.dem.tool import Tool
from synth.implements import RigidWheel
from synth.scene import GRAVITY, SoilBinScene

_FRAMES = 24
"""Frames looked at, evenly over the run."""
_AVERAGED_OVER = 2.5
"""Radius around a grain that its velocity gradient and pressure are averaged over / mean diameter there."""
_NEAREST = 12
"""Grains that the mean diameter at a place is taken of."""
_MOVING = 0.1
"""Soil that moves: grains faster than this share of the implement's speed."""


@dataclass(frozen=True)
class Quantity:
    """One thing that a run reports of its own soundness.

    Attributes
    ----------
    attribute : str
        Its name among the attributes of a recording.
    name : str
        For a person.
    unit : str
        "" for a plain number; a share is shown in %.
    limit : float or None
    at_most : bool
        The limit is an upper one.
    advice : str
        What to change where the limit is not kept.
    """

    attribute: str
    name: str
    unit: str = ""
    limit: float | None = None
    at_most: bool = True
    advice: str = ""

    def show(self, value: float) -> str:
        """The value with its unit."""
        if self.unit == "%":
            return f"{100 * value:.2g} %"
        return f"{value:.3g} {self.unit}".strip()

    def keeps(self, value: float) -> bool:
        """Whether the limit, if there is one, is kept."""
        return self.limit is None or (value <= self.limit if self.at_most else value >= self.limit)


_SLOWER = "take timing.speed_up lower"
_STIFFER = "take contact.normal_stiffness higher"
QUANTITIES = (
    Quantity("inertial_number_median", "inertial number of soil that moves, median"),
    Quantity("inertial_number_p95", "inertial number of soil that moves, 95 %"),
    Quantity("inertial_number_carrying_median", "inertial number of soil that carries the load, median"),
    Quantity(
        "inertial_number_carrying_p95",
        "inertial number of soil that carries the load, 95 %",
        limit=3e-3,
        advice=_SLOWER,
    ),
    Quantity("mean_pressure", "mean pressure under the implement", unit="Pa"),
    Quantity(
        "stiffness_ratio", "contact stiffness / mean pressure", limit=1000.0, at_most=False, advice=_STIFFER
    ),
    Quantity("overlap_mean", "overlap / diameter, mean", unit="%"),
    Quantity("overlap_p99", "overlap / diameter, 99 %", unit="%", limit=0.01, advice=_STIFFER),
    Quantity("overlap_max", "overlap / diameter, greatest", unit="%"),
    Quantity(
        "steps_per_contact",
        "time steps in the shortest collision",
        limit=20.0,
        at_most=False,
        advice="take contact.steps_per_contact higher",
    ),
    Quantity("relative_density", "relative density of the bed"),
    Quantity(
        "relative_density_deviation",
        "relative density, off what was asked for",
        limit=0.1,
        advice="give bed.settling_friction instead",
    ),
)


@dataclass(frozen=True)
class Judgement:
    """A quantity of a run, in words."""

    name: str
    value: str
    limit: str
    kept: bool
    advice: str


def attributes_of(attributes: Mapping[str, Any]) -> dict[str, float]:
    """Those of a recording's attributes that are about its soundness."""
    names = [quantity.attribute for quantity in QUANTITIES]
    return {name: float(attributes[name]) for name in names if name in attributes}


def judge(soundness: Mapping[str, float]) -> list[Judgement]:
    """What values by attribute say; quantities that are not among them are left out."""
    judgements = []
    for quantity in QUANTITIES:
        if quantity.attribute in soundness:
            value = soundness[quantity.attribute]
            sign = "at most" if quantity.at_most else "at least"
            limit = "" if quantity.limit is None else f"{sign} {quantity.show(quantity.limit)}"
            kept = quantity.keeps(value)
            judgements.append(Judgement(quantity.name, quantity.show(value), limit, kept, quantity.advice))
    return judgements


def soundness_of(scene: SoilBinScene, time_step: float, log: RunLog) -> dict[str, float]:
    """Attributes of a run by their names in `QUANTITIES`; those that are not defined are left out.

    Parameters
    ----------
    time_step : float
        Simulated, s.
    """
    chosen = np.unique(np.linspace(0, len(log.frames) - 1, _FRAMES).astype(int))
    frames = [log.frames[index] for index in chosen]
    law, density = contact_law(scene), scene.soil.bulk_density
    moving = MovingSoil.together([moving_soil(frame, law, density) for frame in frames])
    inertial = moving.inertial_number
    overlap = np.concatenate([_overlaps(frame.grains) for frame in frames])
    found = {"steps_per_contact": shortest_contact(frames[0].grains, law) / time_step}
    if inertial.size:
        found["inertial_number_median"] = float(np.median(inertial))
        found["inertial_number_p95"] = float(np.quantile(inertial, 0.95))
        found["inertial_number_carrying_median"] = weighted_quantile(inertial, moving.load, 0.5)
        found["inertial_number_carrying_p95"] = weighted_quantile(inertial, moving.load, 0.95)
    if overlap.size:
        found["overlap_mean"] = float(overlap.mean())
        found["overlap_p99"] = float(np.quantile(overlap, 0.99))
        found["overlap_max"] = max(log.greatest_overlap, float(overlap.max()))
    pressure = mean_pressure(scene, log)
    if pressure > 0:
        found |= {"mean_pressure": pressure, "stiffness_ratio": _stiffness_ratio(scene, law, pressure)}
    return found


def _stiffness_ratio(scene: SoilBinScene, law: Law, pressure: float) -> float:
    """Contact stiffness / pressure: of spheres, stiffness / diameter; after Hertz ``(E* / p)^(2/3)``.

    The last as in Agnolin and Roux, *Physical Review E* 76 (2007) 061302: the inverse of the overlap's scale.
    """
    if isinstance(law, ContactLaw):
        return scene.contact.normal_stiffness / pressure
    return float((law.effective_modulus / pressure) ** (2 / 3))


def mean_pressure(scene: SoilBinScene, log: RunLog) -> float:
    """Mean pressure of the soil on the implement since the first frame, Pa; 0 where they do not touch.

    Under a wheel: upward force / width / horizontal length of the contact from where the rim enters the soil
    to its lowest point, ``sqrt(2 R s - s^2)`` at sinkage s; under one with an elastic rim, of the contact as
    measured. On another implement: resultant force / width /
    depth of its lowest point.
    """
    columns = log.sample_arrays()
    recorded = columns["sample_time"] > 0
    sinkage, upward, along = (float(columns[n][recorded].mean()) for n in ("sinkage", "force_z", "force_x"))
    implement = scene.implement
    if sinkage <= 0:
        return 0.0
    if "contact_length" in columns:
        length = float(columns["contact_length"][recorded].mean())
        return max(0.0, upward) / implement.width / length if length > 0 else 0.0
    if isinstance(implement, RigidWheel):
        radius = implement.shape.reach
        depth = min(sinkage, radius)
        return max(0.0, upward) / implement.width / float(np.sqrt(2 * radius * depth - depth**2))
    return float(np.hypot(upward, along)) / implement.width / sinkage


@dataclass(frozen=True)
class MovingSoil:
    """Grains that move and carry more than a layer of a grain's thickness, in simulated time.

    Attributes
    ----------
    inertial_number : ndarray, shape (n,)
        Shear rate x diameter x root(grain density / pressure), all of them those around the grain.
    pressure : ndarray, shape (n,)
        Pa.
    volume : ndarray, shape (n,)
        Of the grain, m3; of discs m2.
    """

    inertial_number: np.ndarray
    pressure: np.ndarray
    volume: np.ndarray

    @classmethod
    def together(cls, parts: Sequence["MovingSoil"]) -> "MovingSoil":
        """The grains of several moments."""
        return cls(
            np.concatenate([part.inertial_number for part in parts]),
            np.concatenate([part.pressure for part in parts]),
            np.concatenate([part.volume for part in parts]),
        )

    @property
    def load(self) -> np.ndarray:
        """What each grain carries: pressure x volume, N m; of discs N."""
        return self.pressure * self.volume


def moving_soil(frame: Frame, law: Law, bulk_density: float) -> MovingSoil:
    """The soil that moves at a moment.

    Shear rate and pressure are averaged over 2.5 diameters around each grain; diameter is the mean there.
    Grains under less than a layer of a grain's thickness are left out: there is no continuum around them.

    Parameters
    ----------
    law : ContactLaw or HertzMindlinLaw
    bulk_density : float
        kg/m3.
    """
    grains = frame.grains
    chosen = np.flatnonzero(_moving(frame))
    if chosen.size == 0:
        return MovingSoil(*np.zeros((3, 0)))
    diameter = _diameter_around(grains, chosen)
    near = _Surroundings.of(grains.position, chosen, _AVERAGED_OVER * diameter)
    rate = near.shear_rate(grains.in_plane, grains.velocity[[0, -1]])
    solid_fraction = bulk_density / grains.density
    pressure = solid_fraction * near.mean(virials(grains, frame.tool, law)) / near.mean(grains.volume)
    carries = (pressure > bulk_density * GRAVITY * diameter) & np.isfinite(rate)
    rate, diameter, pressure = rate[carries], diameter[carries], pressure[carries]
    number = rate * diameter * np.sqrt(grains.density / pressure)
    return MovingSoil(number, pressure, grains.volume[chosen][carries])


def weighted_quantile(values: np.ndarray, weights: np.ndarray, share: float) -> float:
    """The smallest value up to which, in ascending order, values hold that share of all weight.

    Parameters
    ----------
    values, weights : ndarray, shape (n,)
        n > 0; weights not negative, and not all zero.
    """
    order = np.argsort(values, kind="stable")
    held = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(held, share * held[-1])])


def _diameter_around(grains: Grains, chosen: np.ndarray) -> np.ndarray:
    """Mean diameter of the grains nearest to each chosen one, m, shape (chosen,)."""
    count = min(_NEAREST, grains.count)
    nearest = cKDTree(grains.position.T).query(grains.position[:, chosen].T, count)[1]
    return np.asarray(2 * grains.radius[nearest.reshape(chosen.size, count)].mean(axis=1))


def virials(grains: Grains, tool: Tool, law: Law) -> np.ndarray:
    """Mean normal component of every grain's virial, ``sum of f . l / dimensions``, shape (N,).

    N per metre of width for discs, N m for spheres. The branch from a grain's centre to its contact lies
    along the normal, so that only normal forces count. They are the springs' alone: in slow flow, the
    dashpots' share is small.
    """
    pairs, overlap = _contacts(grains)
    (i, j), radius = pairs, grains.radius
    pressing = spring_force(law, overlap, radius[i] * radius[j] / (radius[i] + radius[j]))
    virial = np.zeros(grains.count)
    for grain in (i, j):
        np.add.at(virial, grain, pressing * (radius[grain] - overlap / 2))
    pressed = np.maximum(radius[:, None] - _gaps_to(tool, grains), 0)
    force = spring_force(law, pressed, radius[:, None], boundary=True)
    virial += (force * (radius[:, None] - pressed / 2)).sum(axis=1)
    return virial / len(grains.position)


def _gaps_to(tool: Tool, grains: Grains) -> np.ndarray:
    """Distance of grains' centres to every capsule of the implement, m, shape (N, C)."""
    return tool.section.distance_to_capsules(grains.in_plane.T - (tool.x, tool.z))


def _moving(frame: Frame) -> np.ndarray:
    """Grains faster than a tenth of the implement; none while it stands still."""
    tool = frame.tool
    speed = max(abs(tool.velocity_x), abs(tool.spin) * tool.shape.reach)
    return (length_of(frame.grains.velocity) > _MOVING * speed) & (speed > 0)


def _contacts(grains: Grains) -> tuple[np.ndarray, np.ndarray]:
    """Pairs in contact (2, K), and their overlaps, m (K,)."""
    near = cKDTree(grains.position.T).query_pairs(2 * grains.radius.max(), output_type="ndarray")
    return grains.touching(near.T)


def _overlaps(grains: Grains) -> np.ndarray:
    """Overlap / the two grains' mean diameter, of every pair in contact."""
    pairs, overlap = _contacts(grains)
    return np.asarray(overlap / grains.radius[pairs].sum(axis=0))


@dataclass(frozen=True)
class _Surroundings:
    """Grains around chosen ones: `owner` counts the chosen, `grain` is one around it, itself among them."""

    count: int
    owner: np.ndarray
    grain: np.ndarray

    @classmethod
    def of(cls, position: np.ndarray, chosen: np.ndarray, reach: np.ndarray) -> "_Surroundings":
        near = cKDTree(position.T).query_ball_point(position[:, chosen].T, reach)
        sizes = [len(grains) for grains in near]
        return cls(chosen.size, np.repeat(np.arange(chosen.size), sizes), np.concatenate(near).astype(int))

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean of the grains' values around each chosen one, shape (chosen,)."""
        return np.bincount(self.owner, values[self.grain], self.count) / np.bincount(self.owner)

    def shear_rate(self, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Shear rate of the velocity field that fits best around each chosen grain, 1/s; NaN: too few grains.

        With the gradient's symmetric part D less its isotropic part, ``sqrt(2 D : D)``: in simple shear, the
        velocity's change across the layer.
        """
        x, z = (self._about_mean(component) for component in position)
        u, w = (self._about_mean(component) for component in velocity)
        xx, xz, zz = self._sum(x * x), self._sum(x * z), self._sum(z * z)
        determinant = xx * zz - xz * xz
        flat = determinant < 1e-6 * (xx + zz) ** 2
        determinant[flat] = np.nan
        ux, uz, wx, wz = (self._sum(v * p) for v in (u, w) for p in (x, z))
        stretch = (zz * ux - xz * uz) - (xx * wz - xz * wx)
        shear = (xx * uz - xz * ux) + (zz * wx - xz * wz)
        return np.hypot(stretch, shear) / determinant

    def _sum(self, values: np.ndarray) -> np.ndarray:
        return np.bincount(self.owner, values, self.count)

    def _about_mean(self, component: np.ndarray) -> np.ndarray:
        return component[self.grain] - self.mean(component)[self.owner]
