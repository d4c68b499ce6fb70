"""Fields as images for ParaView: one `.vti` a pair, and a `.pvd` that strings them together in time.

ParaView counts y upwards, so rows are told from the lowest, and vectors point up where soil goes up. Places
are in m where the pixel size is known, in px otherwise.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from validation.exchange.field import Field

if TYPE_CHECKING:
    from soft import ImageSequence

# Name in the file, the two variables it is made of.
_VECTORS = {
    "displacement": ("u", "v"),
    "inertial_displacement": ("inertial_u", "inertial_v"),
}
_SCALARS = ("uncertainty_u", "uncertainty_v", "strain_rate", "rotation")
_MASKS = ("valid", "soil", "moving", "implement", "mixed")


def write(
    fields: Sequence[Field], sequence: "ImageSequence", folder: Path, advance: Callable[[], None]
) -> None:
    """Write `<field>.pvd` and `<field>/<pair>.vti`; displacements in px a pair, NaN where not known."""
    from synth.dataset.vtk import write_image, write_series

    spacing = sequence.metres_per_pixel or 1.0
    for field in fields:
        (folder / field.name).mkdir()
        names = [f"{field.name}/{pair:06d}.vti" for pair in range(field.pair_count)]
        for pair, name in enumerate(names):
            write_image(folder / name, image_arrays(field, pair, sequence), spacing=spacing)
            advance()
        write_series(folder / f"{field.name}.pvd", field.data["time"].values, names)


def image_arrays(field: Field, pair: int, sequence: "ImageSequence") -> dict[str, np.ndarray]:
    """Named values of one pair, (H, W) or (H, W, 3), lowest row first, vectors with y up."""
    from soft import to_velocity

    arrays: dict[str, np.ndarray] = {}
    for name, (first, second) in _VECTORS.items():
        if first in field.data:
            x, y = to_velocity(field.vectors(pair, first, second), metres_per_pixel=1.0, time_step=1.0)
            arrays[name] = np.stack([x, y, np.where(np.isfinite(x), np.float32(0), x)], axis=-1)
    if "velocity_x" in field.data:
        velocity = field.vectors(pair, "velocity_x", "velocity_z")
        x = velocity[..., :1]
        arrays["velocity"] = np.concatenate([velocity, np.where(np.isfinite(x), np.float32(0), x)], axis=-1)
    chosen = field.data.isel(pair=pair)
    arrays |= {name: chosen[name].values.astype(np.float32) for name in _SCALARS if name in chosen}
    arrays |= {name: chosen[name].values.astype(np.uint8) for name in _MASKS if name in chosen}
    return {name: np.ascontiguousarray(values[::-1]) for name, values in arrays.items()}
