"""What the stages of a member take of a core, foretold from stated rates."""

import functools
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from synth.analytic.settings import AnalyticCamera
from synth.scene import AnyScene, Bed, SoilBinScene

if TYPE_CHECKING:
    from synth.dem.contact_law import Law

STEP_SECONDS, DISC_SECONDS, SPHERE_SECONDS = 4.1e-5, 4.0e-8, 1.7e-7
"""Of a core: for a time step, and for each grain in it."""
FALL, REST = 0.53, 0.05
"""Simulated time in which a bed settles: falling and coming to rest in soft contacts, s / sqrt(m of depth);
and coming to rest in the scene's own, s."""
SEQUENCE_SECONDS, PIXEL_SECONDS, SAMPLE_SECONDS = 1.4, 9.3e-7, 1.0e-8
"""Of a core: for a sequence's texture, for each pixel of a picture with its truth, written and read back, and
for each of its samples."""
_KEPT = 0.82
"""Grains of a settled bed / dropped ones."""


def bed_seconds(scene: AnyScene) -> float:
    """To settle a scene's bed, s of a core."""
    return _seconds(scene, bed_step_count(scene))


def simulation_seconds(scene: AnyScene) -> float:
    """To simulate a scene once its bed is settled, s of a core."""
    return _seconds(scene, step_count(scene))


def picture_seconds(scene: AnyScene) -> float:
    """To take a scene's pictures and read them back, s of a core."""
    camera = scene.camera
    pixels = camera.width * camera.height * scene.timing.frame_count
    if isinstance(camera, AnalyticCamera):
        return pixels * PIXEL_SECONDS
    return SEQUENCE_SECONDS + pixels * (PIXEL_SECONDS + camera.supersampling**2 * SAMPLE_SECONDS)


def grain_count(scene: AnyScene) -> float:
    """Grains of a scene's bed, about."""
    if not isinstance(scene, SoilBinScene):
        return 0
    layers = max(scene.bed.thickness / scene.bed.grain_diameter, 1)
    return _KEPT * layers * _dropped(scene.bed)


def step_count(scene: AnyScene) -> float:
    """Time steps of a simulation, about."""
    if not isinstance(scene, SoilBinScene):
        return 0
    from synth.dem.bed import contact_law
    from synth.dem.log import Schedule

    schedule = Schedule.of(scene, _time_step(scene, contact_law(scene)))
    return schedule.total * schedule.steps


def bed_step_count(scene: AnyScene) -> float:
    """Time steps in which a scene's bed settles, about."""
    if not isinstance(scene, SoilBinScene):
        return 0
    from synth.dem.bed import bin_of, contact_law
    from synth.dem.contact_law import ContactLaw

    law = contact_law(scene)
    own = _time_step(scene, law)
    soft = own
    if isinstance(law, ContactLaw):
        box = bin_of(scene.bed, scene.contact.steps_per_contact)
        soft = _time_step(scene, box.soft_law(law, scene.soil.bulk_density))
    return FALL * math.sqrt(scene.bed.depth) / soft + REST / own


def _seconds(scene: AnyScene, steps: float) -> float:
    """Of a core, for so many time steps of a scene's grains."""
    spheres = isinstance(scene, SoilBinScene) and scene.bed.thickness > 0
    return steps * (STEP_SECONDS + grain_count(scene) * (SPHERE_SECONDS if spheres else DISC_SECONDS))


def _time_step(scene: SoilBinScene, law: "Law") -> float:
    """Of grains that touch by a law, s: a share of the shortest collision of the smallest ones."""
    from synth.dem.contact_law import HertzMindlinLaw, contact_time, hertz_time

    bed = scene.bed
    radius = 0.5 * bed.grain_diameter * (1 - bed.polydispersity)
    volume = 4 / 3 * math.pi * radius**3 if bed.thickness else math.pi * radius**2
    mass = scene.soil.bulk_density / _KEPT * volume
    if isinstance(law, HertzMindlinLaw):
        shortest = float(hertz_time(mass / 2, radius / 2, law.effective_modulus, law.impact_speed))
    else:
        shortest = contact_time(mass, law.normal_stiffness)
    return shortest / scene.contact.steps_per_contact


@functools.lru_cache(maxsize=64)
def _dropped(bed: Bed) -> int:
    """Grains that a bed is made of, before it is levelled."""
    import numpy as np

    from synth.dem.bed import bin_of

    any_steps = 20  # of no consequence before grains move
    return bin_of(bed, any_steps).drop(np.random.default_rng(0), 1.0).count


STAGES: dict[str, Callable[[AnyScene], float]] = {
    "bed": bed_seconds,
    "simulation": simulation_seconds,
    "pictures": picture_seconds,
}
"""Seconds of a core for a scene, by stage."""
