"""The members of a sweep: their scenes, their names, and which of them share a bed or a motion."""

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from synth.dataset.design import Point, points_of
from synth.dataset.sweep import SPLITS, Split, Sweep, SweepError
from synth.scene import AnyScene, FineRegion, SceneError, SoilBinScene, changed_scene

NAME_LENGTH = 16
"""Hexadecimal digits of a hash that name a member or a simulation."""


@dataclass(frozen=True)
class Member:
    """One sequence of a data set.

    Attributes
    ----------
    scene : AnyScene
    values : dict
        What was varied, by dotted key of the scene.
    split : str
        `train`, `validation` or `test`.
    """

    scene: AnyScene
    values: Point
    split: str = SPLITS[0]

    @cached_property
    def name(self) -> str:
        """Beginning of the hash of the resolved scene."""
        return self.scene.hash[:NAME_LENGTH]

    @cached_property
    def simulation(self) -> str:
        """Beginning of the hash of what the motion depends on."""
        return self.scene.simulation_hash[:NAME_LENGTH]

    @cached_property
    def bed(self) -> str | None:
        """Of what the settled bed depends on; None where there is none."""
        return bed_key(self.scene)


@dataclass(frozen=True)
class Impossible:
    """A point of the design that is no scene.

    Attributes
    ----------
    values : dict
    reason : str
    """

    values: Point
    reason: str


@dataclass(frozen=True)
class Failure:
    """Why a member could not be made.

    Attributes
    ----------
    stage : str
        `bed`, `simulation` or `pictures`.
    reason : str
        One line.
    """

    stage: str
    reason: str


@dataclass(frozen=True)
class Membership:
    """All points of a design.

    Attributes
    ----------
    members : tuple of Member
        Different from each other, in the design's order.
    impossible : tuple of Impossible
    repeated : int
        Points left out since another one gives the same scene.
    """

    members: tuple[Member, ...]
    impossible: tuple[Impossible, ...]
    repeated: int


def members_of(sweep: Sweep, base: AnyScene) -> Membership:
    """Resolve every point of a sweep to a scene, and deal them out to the splits.

    A texture is a motion's own, unless the scene or the sweep gives `picture_seed`: pictures of two splits
    must not show the same grains.

    Raises
    ------
    SweepError
        No point is a scene: a key that does not exist, for instance.
    """
    own_region = any(key.startswith("bed.fine") for key in sweep.vary)
    scenes, impossible = _resolved(sweep, base if own_region else _without_derived_region(base))
    if not scenes:
        raise SweepError(f"sweep {sweep.name!r}: {impossible[0].reason}")
    if not own_region:
        scenes = _with_shared_beds(scenes)
    if base.picture_seed is None and "picture_seed" not in sweep.vary:
        scenes = [(_with_own_texture(scene, sweep.seed), values) for scene, values in scenes]
    different = {scene.hash: Member(scene, values) for scene, values in reversed(scenes)}
    members = tuple(reversed(different.values()))
    splits = deal_out({m.simulation for m in members}, sweep.split, seed=sweep.seed)
    dealt = tuple(replace(member, split=splits[member.simulation]) for member in members)
    return Membership(dealt, tuple(impossible), len(scenes) - len(members))


def deal_out(simulations: Iterable[str], split: Split, *, seed: int) -> dict[str, str]:
    """Split by simulation: exact shares (rounded), in an order that hashes give."""
    ordered = sorted(simulations, key=lambda name: hashlib.sha256(f"{seed} {name}".encode()).hexdigest())
    dealt: dict[str, str] = {}
    start, share = 0, 0.0
    for name in SPLITS:
        share += getattr(split, name)
        end = round(share * len(ordered))
        dealt |= dict.fromkeys(ordered[start:end], name)
        start = end
    return dealt


def bed_key(scene: AnyScene) -> str | None:
    """Beginning of a hash of what the settled bed depends on; None of a scene without one."""
    if not isinstance(scene, SoilBinScene):
        return None
    return _digest(_bed_inputs(scene))[:NAME_LENGTH]


def _bed_inputs(scene: SoilBinScene) -> dict[str, Any]:
    tables = scene.to_dict()
    soil = {key: tables["soil"].get(key) for key in ("bulk_density", "contact", "packing")}
    return {"soil": soil, **{key: tables[key] for key in ("bed", "contact", "seed")}}


def _resolved(sweep: Sweep, base: AnyScene) -> "tuple[list[tuple[AnyScene, Point]], list[Impossible]]":
    scenes, impossible = [], []
    for values in points_of(sweep):
        try:
            scenes.append((changed_scene(base, values, source="vary"), values))
        except SceneError as error:
            impossible.append(Impossible(values, str(error)))
    return scenes, impossible


def _without_derived_region(scene: AnyScene) -> AnyScene:
    """Let the region of finest grains follow from each member's camera and drive, where it did so before."""
    if not isinstance(scene, SoilBinScene) or scene.bed.coarsening == 1:
        return scene
    from synth.dem.grading import region_worked_and_seen

    if scene.bed.fine != region_worked_and_seen(scene):
        return scene
    return _with_region(scene, None)


def _with_shared_beds(scenes: "list[tuple[AnyScene, Point]]") -> "list[tuple[AnyScene, Point]]":
    """Give beds that differ by their region of finest grains alone one that holds all of theirs.

    Cameras and drives ask for regions of their own; a bed, and a motion, would not be shared for that.
    """
    groups: dict[str, list[FineRegion]] = {}
    for scene, _ in scenes:
        if isinstance(scene, SoilBinScene) and scene.bed.fine is not None:
            groups.setdefault(_digest(_bed_inputs(_with_region(scene, None))), []).append(scene.bed.fine)
    shared = []
    for scene, values in scenes:
        if isinstance(scene, SoilBinScene) and scene.bed.fine is not None:
            regions = groups[_digest(_bed_inputs(_with_region(scene, None)))]
            scene = _with_region(scene, _union(regions))
        shared.append((scene, values))
    return shared


def _union(regions: list[FineRegion]) -> FineRegion:
    return FineRegion(
        left=min(region.left for region in regions),
        right=max(region.right for region in regions),
        bottom=min(region.bottom for region in regions),
    )


def _with_region(scene: SoilBinScene, fine: FineRegion | None) -> SoilBinScene:
    return scene.model_copy(update={"bed": scene.bed.model_copy(update={"fine": fine})})


def _with_own_texture(scene: AnyScene, seed: int) -> AnyScene:
    digest = hashlib.sha256(f"texture {seed} {scene.simulation_hash}".encode()).digest()
    return scene.model_copy(update={"picture_seed": int.from_bytes(digest[:8], "big") >> 1})


def _digest(value: Any) -> str:
    canonical = json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()
