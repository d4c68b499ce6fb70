"""The settled bed: discs dropped loosely, settled, levelled, and brought to the soil's bulk density."""

import hashlib
import json
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
    reduced_moduli,
)
from synth.dem.grading import GradedBin
from synth.dem.grains import Grains, grains_of
from synth.dem.packing import void_ratio
from synth.dem.relative_density import SettlingRelation, settling_relation
from synth.dem.settling import FIRST_SOLID_FRACTION, Bin
from synth.devices import cache_folder
from synth.disk import written_whole
from synth.locks import sole_maker
from synth.npz_files import UNREADABLE
from synth.scene import Bed as BedTable
from synth.scene import SoilBinScene

Progress = Callable[[int, int], None]

RECIPE = 2
"""Raised when the way a bed is made changes: older beds in the cache are then left alone."""


@dataclass(frozen=True)
class Bed:
    """Grains at rest in the bin, levelled at the scene's depth.

    Attributes
    ----------
    solid_fraction : float
        Share of the bed's area that grains fill.
    relative_density : float or None
        Where the void ratio lies between loosest (0) and densest (1); None where these are not known.
    """

    grains: Grains
    solid_fraction: float
    relative_density: float | None = None


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
    relation = _relation(scene, _part(progress, 0))
    friction = _settling_friction(scene, relation)
    path = cache_folder() / "beds" / f"{_bed_hash(scene, friction)}.npz"
    if (kept := _read(path)) is not None:
        return _judged(*kept, relation)
    with sole_maker(path):
        if (kept := _read(path)) is None:
            kept = _prepared(scene, friction, progress)
            _write(*kept, path)
    return _judged(*kept, relation)


def _relation(scene: SoilBinScene, progress: Progress | None) -> SettlingRelation | None:
    """Void ratio by friction while settling: where a relative density is wanted, or the soil knows."""
    bed, soil = scene.bed, scene.soil
    known = soil.packing is not None and soil.packing.is_of(soil.contact, bed.polydispersity)
    if bed.thickness or (bed.relative_density is None and not known):
        return None
    return settling_relation(soil.contact, bed.polydispersity, packing=soil.packing, progress=progress)


def _settling_friction(scene: SoilBinScene, relation: SettlingRelation | None) -> float:
    if scene.bed.settling_friction is not None:
        return scene.bed.settling_friction
    assert relation is not None
    assert scene.bed.relative_density is not None
    return relation.friction_for(scene.bed.relative_density)


def _judged(grains: Grains, solid_fraction: float, relation: SettlingRelation | None) -> Bed:
    known = None if relation is None else relation.relative_density(void_ratio(solid_fraction))
    return Bed(grains, solid_fraction, known)


def _prepared(
    scene: SoilBinScene, settling_friction: float, progress: Progress | None
) -> tuple[Grains, float]:
    """Grains and solid fraction of a bed made anew: dropped, settled, levelled, weighed, and come to rest.

    Settling happens at a lower stiffness, which the weight of the bed alone allows and which is quicker; the
    last stage brings the grains to rest at the scene's own.
    """
    law, bin_ = contact_law(scene), bin_of(scene.bed, scene.contact.steps_per_contact)
    if scene.bed.thickness:
        from synth.dem.slab import prepare_slab

        return prepare_slab(scene, law, progress=progress)
    assert isinstance(law, ContactLaw)  # of discs
    softer = replace(bin_.soft_law(law, scene.soil.bulk_density), friction=settling_friction)
    density = scene.soil.bulk_density / FIRST_SOLID_FRACTION
    dropped = bin_.drop(np.random.default_rng([scene.seed, 1]), density)
    levelled = bin_.settle(dropped, softer, _part(progress, 1))
    weighed = replace(levelled, density=scene.soil.bulk_density / bin_.solid_fraction(levelled))
    rested = bin_.rest(weighed, law, _part(progress, 2))
    solid_fraction = bin_.solid_fraction(rested)  # a bed settled with more friction than it has now gave way
    rested = replace(rested, density=scene.soil.bulk_density / solid_fraction)
    return rested.only(_by_column(rested)), solid_fraction


def bin_of(bed: BedTable, steps_per_contact: int) -> Bin:
    """The bin that discs are dropped into, as a scene describes their bed."""
    what = (bed.width, bed.depth, bed.grain_diameter, bed.polydispersity, bed.gravity)
    if bed.coarsening == 1 or bed.fine is None:
        return Bin(*what, steps_per_contact)
    return GradedBin(
        *what,
        steps_per_contact,
        coarsening=bed.coarsening,
        left=bed.fine.left,
        right=bed.fine.right,
        fine_bottom=bed.fine.bottom,
    )


def _by_column(grains: Grains) -> np.ndarray:
    """Order of the grains cell by cell, so that neighbours in the bin are neighbours in memory."""
    cell = np.floor(grains.position / (2 * grains.radius.max())).astype(np.int64)
    return np.lexsort((cell[1], cell[0]))


def _part(progress: Progress | None, part: int) -> Progress | None:
    """Progress of one of the three stages as progress of the whole."""
    if progress is None:
        return None
    return lambda done, total: progress(part * 100 + round(100 * done / total), 300)


def _bed_hash(scene: SoilBinScene, settling_friction: float) -> str:
    tables = scene.to_dict()
    made_from = {key: tables[key] for key in ("bed", "contact", "seed")}
    made_from["bed"] = {**tables["bed"], "settling_friction": settling_friction, "relative_density": None}
    soil = {key: tables["soil"][key] for key in ("bulk_density", "contact")}
    canonical = json.dumps({"recipe": RECIPE, **made_from, "soil": soil}, sort_keys=True)
    return hashlib.sha256(canonical.encode()).hexdigest()


def _write(grains: Grains, solid_fraction: float, path: Path) -> None:
    with written_whole(path) as draft:
        np.savez(
            draft,
            position=grains.position,
            radius=grains.radius,
            density=grains.density,
            solid_fraction=solid_fraction,
        )


def _read(path: Path) -> tuple[Grains, float] | None:
    """Grains and solid fraction of a bed; None where it is not there, or damaged, by a full disk perhaps."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            position = stored["position"]
            grains = grains_of(position).at_rest(position, stored["radius"], float(stored["density"]))
            return grains, float(stored["solid_fraction"])
    except UNREADABLE:
        return None
