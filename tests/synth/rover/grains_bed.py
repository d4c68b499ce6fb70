"""A small bed without settling: discs in rows, under a scene's own contacts."""

import numpy as np

from synth.dem.bed import Bed
from synth.dem.grains import Grains
from synth.scene import SoilBinScene, load_scene, parse_scene

RADIUS = 0.01


def small_scene(width=1.2) -> SoilBinScene:
    told = load_scene("studies/rover_bin").to_dict()
    told["bed"] |= {"width": width, "depth": 0.1, "grain_diameter": 2 * RADIUS}
    told["bed"].pop("fine", None)
    told["implement"] |= {"radius": 0.1}
    told["drive"] |= {"start": 0.3, "run_in": 0.05}
    told["timing"] |= {"frame_count": 2}
    return parse_scene(told, source="small")


def rows_of_discs(scene, rows=5, seed=0) -> Bed:
    """Triangular packing, slightly polydisperse, so that no two contacts are alike."""
    rng = np.random.default_rng(seed)
    spacing = 2 * RADIUS * 1.01
    x, z = [], []
    for row in range(rows):
        first = RADIUS * (1.05 + 1.01 * (row % 2))
        here = np.arange(first, scene.bed.width - 1.1 * RADIUS, spacing)
        x.append(here)
        z.append(np.full(here.size, RADIUS + row * spacing * np.sqrt(3) / 2))
    position = np.stack([np.concatenate(x), np.concatenate(z)])
    radius = RADIUS * rng.uniform(0.95, 1.0, position.shape[1])
    return Bed(Grains.at_rest(position, radius, 2000.0), 0.8)
