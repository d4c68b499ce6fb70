"""The suite `complex`: what the paper called for, errors where flow is complex.

Every shipped scene, both soils. Each motion is seen clean and at the severity `paper`; the rolling wheel also
otherwise (strides, textures, grains that others replace, coarser particles), since what is said of complex
flow should not depend on how it is seen.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from validation.suites.plan import Look, Motion, Realisation, Suite
from validation.suites.severities import CLEAN, PAPER

METHODS = ("robust-affine", "robust-affine-fast", "dis", "dis-full", "farneback")
SOFT = "soft-2014"
"""The published technique."""
_SECONDARY = ("tvl1", "ilk")
_THOROUGH = (*_SECONDARY, "black-anandan")
SEVERITIES = (PAPER, CLEAN)
BIN_SCENES = (
    "rolling_wheel",
    "bucket",
    "pushed_wheel",
    "grouser_wheel",
    "fillite_wheel",
    "compliant_wheel",
    "constant_speed",
    "slab_wheel",
)
ANALYTIC_SCENES = ("plate_rotation", "fillite_plate", "shear_band", "sinusoidal_strain")
"""By formula, seen at both severities."""
SAND_SCENES = ("sand_rotation", "sand_low_contrast", "sand_defocus", "sand_aliased")
"""By formula, with what disturbs them in the scene itself."""
FORMULA_SCENES = (*ANALYTIC_SCENES, *SAND_SCENES)
_FIRST = 2
"""Frame; the pictures before it show how the motion begins."""

Changes = tuple[tuple[str, str, Any], ...]


@dataclass(frozen=True)
class Extent:
    """How much of everything is looked at.

    Attributes
    ----------
    seeds, picture_seeds : tuple of int
        Simulations, and sets of pictures of each, at the severity `paper`.
    clean_picture_seeds : tuple of int
        The same for clean pictures.
    pair_count : int
        Picture pairs of each set.
    varied_picture_seeds : tuple of int
        Of the rolling wheel seen otherwise.
    strides, exchanges, coarser : tuple
        Frames between pictures; share of the grains a frame that others replace; particle diameters / the
        scene's.
    glances : mapping
        Methods that take long: the sets of pictures whose first pair they see, by severity.
    """

    seeds: tuple[int, ...]
    picture_seeds: tuple[int, ...]
    clean_picture_seeds: tuple[int, ...]
    pair_count: int
    varied_picture_seeds: tuple[int, ...]
    strides: tuple[int, ...]
    exchanges: tuple[float, ...]
    coarser: tuple[float, ...]
    glances: Mapping[str, Mapping[str, tuple[int, ...]]]


_ALL = (0, 1, 2, 3)
FULL = Extent(
    seeds=(1, 2),
    picture_seeds=_ALL,
    clean_picture_seeds=_ALL,
    pair_count=4,
    varied_picture_seeds=_ALL,
    strides=(2, 4),
    exchanges=(0.05, 0.1, 0.2),
    coarser=(1.4, 2.0),
    glances={SOFT: {PAPER: _ALL, CLEAN: _ALL}}
    | {method: {PAPER: (0, 1), CLEAN: (0, 1)} for method in _THOROUGH},
)
QUICK = Extent(
    seeds=(1, 2),
    picture_seeds=_ALL,
    clean_picture_seeds=(0, 1),
    pair_count=1,
    varied_picture_seeds=(0, 1),
    strides=(2,),
    exchanges=(0.1,),
    coarser=(1.5,),
    glances={SOFT: {PAPER: (0, 1), CLEAN: (0,)}} | {method: {PAPER: (0,)} for method in _SECONDARY},
)


@dataclass(frozen=True)
class ComplexSuite(Suite):
    """A suite whose slow methods see a part of the pictures: which, is told by `extent`.

    Attributes
    ----------
    extent : Extent
    """

    extent: Extent = FULL

    def _looks_at(self, realisation: Realisation) -> list[Look]:
        glances = [
            Look(realisation, method, pair_count=1)
            for method, seen in self.extent.glances.items()
            if method not in self.methods and realisation.picture_seed in seen.get(realisation.severity, ())
        ]
        return [*(Look(realisation, method) for method in self.methods), *glances]


def complex_suite(quick: bool) -> ComplexSuite:
    """Every implement, both soils, and motions by formula.

    Quick, a simulation is the scene's quick one, pictures show what is next to the implement, and methods
    that take long see the fewest pictures that an interval can be had of.
    """
    extent = QUICK if quick else FULL
    # What needs no simulation first, so that something can be seen soon.
    pictures = [one for scene in FORMULA_SCENES for one in _by_formula(scene, extent, quick)]
    pictures += _seen(BIN_SCENES[0], extent, quick)
    pictures += [one for seed in extent.seeds for one in _seen_otherwise(seed, extent, quick)]
    pictures += [one for scene in BIN_SCENES[1:] for one in _seen(scene, extent, quick)]
    about = "every implement, both soils: where flow is complex"
    slow = tuple(extent.glances)
    return ComplexSuite("complex", about, tuple(pictures), METHODS, slow, extent)


def _seen(scene: str, extent: Extent, quick: bool) -> list[Realisation]:
    return [
        Realisation(
            Motion(scene, seed, quick),
            picture_seed,
            severity,
            first=_FIRST,
            pair_count=extent.pair_count,
            changes=_view(scene) if quick else (),
        )
        for seed in extent.seeds
        for severity in SEVERITIES
        for picture_seed in _picture_seeds(extent, severity)
    ]


def _picture_seeds(extent: Extent, severity: str) -> tuple[int, ...]:
    return extent.clean_picture_seeds if severity == CLEAN else extent.picture_seeds


def _by_formula(scene: str, extent: Extent, quick: bool) -> list[Realisation]:
    seeds = {severity: _picture_seeds(extent, severity) for severity in SEVERITIES}
    if scene in SAND_SCENES:
        seeds = {CLEAN: extent.picture_seeds}
    return [
        Realisation(Motion(scene, seed, quick), picture_seed, severity, pair_count=1)
        for seed in extent.seeds
        for severity, picture_seeds in seeds.items()
        for picture_seed in picture_seeds
    ]


def _seen_otherwise(seed: int, extent: Extent, quick: bool) -> list[Realisation]:
    """The rolling wheel at other strides, with other textures, exchange, and coarser particles."""
    scene = BIN_SCENES[0]
    view = _view(scene) if quick else ()
    motion = Motion(scene, seed, quick)
    found = []
    for picture_seed in extent.varied_picture_seeds:
        base = Realisation(motion, picture_seed, PAPER, _FIRST, extent.pair_count, changes=view)
        found += [replace(base, stride=stride) for stride in extent.strides]
        found.append(_changed(base, "carried", ("texture", "motion", "carried")))
        found += [
            _changed(base, f"exchange-{rate:g}", ("nuisance", "exchange", rate)) for rate in extent.exchanges
        ]
        found += [
            replace(base, motion=_coarser(motion, factor), label=f"grains-x{factor:g}")
            for factor in extent.coarser
        ]
    return found


def _changed(base: Realisation, label: str, change: tuple[str, str, Any]) -> Realisation:
    return replace(base, label=label, changes=(*base.changes, change))


def _coarser(motion: Motion, factor: float) -> Motion:
    """The same motion of coarser particles; the grains seen on the glass stay the soil's own."""
    diameter = factor * motion.load().to_dict()["bed"]["grain_diameter"]
    change = ("bed", "grain_diameter", round(diameter, 6))
    return replace(motion, changes=(change,), label=f"grains-x{factor:g}")


_CENTRES = {"pushed_wheel": -0.02}
"""Where the smaller picture of a quick suite looks, m from the axle."""
_CENTRE = 0.01


def _view(scene: str) -> Changes:
    """A smaller picture of the same scale, of what is next to the implement."""
    if scene == "slab_wheel":  # small already
        return ()
    centre = _CENTRES.get(scene, _CENTRE)
    return (("camera", "width", 640), ("camera", "height", 360), ("camera", "centre_x", centre))
