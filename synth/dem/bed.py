"""The settled bed: discs dropped loosely, settled, levelled, and brought to the soil's bulk density."""

import hashlib
import json
import os
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from synth.dem.contact_law import (
    ContactLaw,
    HertzMindlinLaw,
    Law,
    Material,
    damping_ratio_of,
    largest_time_step,
    reduced_moduli,
)
from synth.dem.grains import Grains, grains_of
from synth.dem.solver import Solver
from synth.devices import cache_folder
from synth.scene import SoilBinScene

Progress = Callable[[int, int], None]

RECIPE = 1
"""Raised when the way a bed is made changes: older beds in the cache are then left alone."""

_FIRST_SOLID_FRACTION = 0.82
"""Guess of the share of area that settled discs fill, until it is measured."""
_SETTLING_STIFFNESS = 1000
"""Contact stiffness while settling / greatest pressure of the bed: soft is quick, hard packs right."""
_CALM = 2e-3
"""Settled: the speed that nine of ten grains stay below / that of a fall through a grain's own diameter."""
_LOOK = 2.5e-3
"""Time between two looks at how calm the bed is, s."""
_LONGEST_REST = 0.15
"""Time after which a bed is taken as it is, s: longer would only show that something else is wrong."""
_DRAG = 200.0
"""Rate at which motion dies away while the bed comes to rest, 1/s."""


@dataclass(frozen=True)
class Bed:
    """Grains at rest in the bin, levelled at the scene's depth.

    Attributes
    ----------
    solid_fraction : float
        Share of the bed's area that grains fill.
    """

    grains: Grains
    solid_fraction: float


def contact_law(scene: SoilBinScene) -> Law:
    """The scene's contact law; after Hertz, walls and implement are rigid."""
    contact, soil = scene.contact, scene.soil.contact
    others = {
        "friction": soil.friction,
        "wall_friction": soil.wall_friction,
        "implement_friction": soil.implement_friction,
        "rolling_friction": soil.rolling_friction,
        "cohesion": contact.cohesion,
        "glass_friction": scene.bed.glass_friction,
    }
    if contact.law == "hertz_mindlin":
        grain = Material(contact.young_modulus, contact.poisson_ratio)
        moduli = (*reduced_moduli(grain, grain), *reduced_moduli(grain))
        return HertzMindlinLaw(*moduli, soil.restitution, contact.impact_speed, **others)
    per = scene.bed.grain_diameter if scene.bed.thickness else 1.0
    return ContactLaw(
        normal_stiffness=contact.normal_stiffness * per,
        tangential_stiffness=contact.normal_stiffness * per * contact.tangential_stiffness_ratio,
        damping_ratio=damping_ratio_of(soil.restitution),
        **others,
    )


def settled_bed(scene: SoilBinScene, *, progress: Progress | None = None) -> Bed:
    """The scene's bed, from the cache where it has been made before."""
    path = cache_folder() / "beds" / f"{_bed_hash(scene)}.npz"
    if path.is_file():
        try:
            return _read(path)
        except (OSError, ValueError, KeyError, zipfile.BadZipFile):
            path.unlink()  # damaged, by a full disk perhaps: made anew
    bed = prepare_bed(scene, progress=progress)
    _write(bed, path)
    return bed


def prepare_bed(scene: SoilBinScene, *, progress: Progress | None = None) -> Bed:
    """Drop, settle, level, weigh, and let come to rest.

    Settling happens at a lower stiffness, which the weight of the bed alone allows and which is quicker; the
    last stage brings the grains to rest at the scene's own.
    """
    if scene.bed.thickness:
        from synth.dem.slab import prepare_slab

        return Bed(*prepare_slab(scene, contact_law(scene), progress=progress))
    law = contact_law(scene)
    assert isinstance(law, ContactLaw)
    softer = _softer(law, _SETTLING_STIFFNESS * scene.soil.bulk_density * scene.bed.gravity * scene.bed.depth)
    softer = replace(softer, friction=scene.bed.settling_friction)
    density = scene.soil.bulk_density / _FIRST_SOLID_FRACTION
    dropped = _dropped(scene, np.random.default_rng([scene.seed, 1]), density)
    fallen = _fallen(dropped, softer, scene, _part(progress, 0))
    settled = _at_rest(fallen, softer, scene, _part(progress, 1))
    levelled = settled.only(settled.position[1] + settled.radius <= scene.bed.depth)
    solid_fraction = _solid_fraction(levelled, scene)
    weighed = replace(levelled, density=scene.soil.bulk_density / solid_fraction)
    rested = _at_rest(weighed, law, scene, _part(progress, 2))
    return Bed(rested.only(_by_column(rested)), solid_fraction)


def _dropped(scene: SoilBinScene, rng: np.random.Generator, density: float) -> Grains:
    """Grains of random size on a loose lattice, with small random velocities that break its order."""
    bed = scene.bed
    diameter = bed.grain_diameter * rng.uniform(1 - bed.polydispersity, 1 + bed.polydispersity, _count(scene))
    pitch = bed.grain_diameter * (1 + bed.polydispersity) * 1.01
    columns = int((bed.width - 0.5 * pitch) / pitch)
    row, column = np.divmod(np.arange(diameter.size), columns)
    x = (column + 0.5 + 0.5 * (row % 2)) * pitch
    z = (row * np.sqrt(3) / 2 + 0.5) * pitch
    grains = Grains.at_rest(np.stack([x, z]), diameter / 2, density)
    return replace(grains, velocity=rng.normal(0, 0.05, grains.position.shape))


def _count(scene: SoilBinScene) -> int:
    """Grains for a little more than the depth of the bed, so that levelling has something to take off."""
    bed = scene.bed
    mean_square = bed.grain_diameter**2 * (1 + bed.polydispersity**2 / 3)
    area = bed.width * (bed.depth + 3 * bed.grain_diameter)
    return int(_FIRST_SOLID_FRACTION * area / (np.pi / 4 * mean_square))


def _fallen(grains: Grains, law: ContactLaw, scene: SoilBinScene, progress: Progress | None) -> Grains:
    """Advance while the lattice collapses: a third longer than its top falls to the bed's depth."""
    height = float(grains.position[1].max()) - scene.bed.depth
    solver = _settling_solver(grains, law, scene, drag=0.0)
    looks = max(1, round(1.33 * np.sqrt(2 * height / scene.bed.gravity) / _LOOK))
    for done in range(1, looks + 1):
        solver.advance(max(1, round(_LOOK / solver.time_step)))
        if progress is not None:
            progress(done, looks)
    return solver.read_grains()


def _at_rest(grains: Grains, law: ContactLaw, scene: SoilBinScene, progress: Progress | None) -> Grains:
    """Advance against a drag until the grains are calm; they are then stopped altogether."""
    solver = _settling_solver(grains, law, scene, drag=_DRAG)
    fall = np.sqrt(2 * scene.bed.gravity * scene.bed.grain_diameter)
    looks = round(_LONGEST_REST / _LOOK)
    now = grains
    for done in range(1, looks + 1):
        solver.advance(max(1, round(_LOOK / solver.time_step)))
        now = solver.read_grains()
        if progress is not None:
            progress(done, looks)
        if np.quantile(np.hypot(*now.velocity), 0.9) < _CALM * fall:
            break
    return Grains.at_rest(now.position, now.radius, now.density)


def _settling_solver(grains: Grains, law: ContactLaw, scene: SoilBinScene, *, drag: float) -> Solver:
    step = largest_time_step(grains.mass, law.normal_stiffness, scene.contact.steps_per_contact)
    return Solver(grains, law, scene.bed.width, step, gravity=(0.0, -scene.bed.gravity), drag=drag)


def _solid_fraction(grains: Grains, scene: SoilBinScene) -> float:
    """Share of area filled by grains, clear of the walls and of the rough surface."""
    (x, z), bed = grains.position, scene.bed
    margin = 3 * bed.grain_diameter
    inside = (x > margin) & (x < bed.width - margin) & (z > margin) & (z < bed.depth - margin)
    area = (bed.width - 2 * margin) * (bed.depth - 2 * margin)
    return float((np.pi * grains.radius[inside] ** 2).sum() / area)


def _by_column(grains: Grains) -> np.ndarray:
    """Order of the grains cell by cell, so that neighbours in the bin are neighbours in memory."""
    cell = np.floor(grains.position / (2 * grains.radius.max())).astype(np.int64)
    return np.lexsort((cell[1], cell[0]))


def _softer(law: ContactLaw, stiffness: float) -> ContactLaw:
    share = min(1.0, stiffness / law.normal_stiffness)
    return replace(
        law,
        normal_stiffness=law.normal_stiffness * share,
        tangential_stiffness=law.tangential_stiffness * share,
    )


def _part(progress: Progress | None, part: int) -> Progress | None:
    """Progress of one of the three stages as progress of the whole."""
    if progress is None:
        return None
    return lambda done, total: progress(part * 100 + round(100 * done / total), 300)


def _bed_hash(scene: SoilBinScene) -> str:
    tables = scene.to_dict()
    made_from = {key: tables[key] for key in ("bed", "contact", "seed")}
    soil = {key: tables["soil"][key] for key in ("bulk_density", "contact")}
    canonical = json.dumps({"recipe": RECIPE, **made_from, "soil": soil}, sort_keys=True)
    return hashlib.sha256(canonical.encode()).hexdigest()


def _write(bed: Bed, path: Path) -> None:
    """Written aside and renamed: a bed in the cache is whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(f".{path.stem}-{os.getpid()}.npz")
    np.savez(
        aside,
        position=bed.grains.position,
        radius=bed.grains.radius,
        density=bed.grains.density,
        solid_fraction=bed.solid_fraction,
    )
    aside.replace(path)


def _read(path: Path) -> Bed:
    with np.load(path, allow_pickle=False) as stored:
        position = stored["position"]
        grains = grains_of(position).at_rest(position, stored["radius"], float(stored["density"]))
        return Bed(grains, float(stored["solid_fraction"]))
