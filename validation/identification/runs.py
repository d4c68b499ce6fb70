"""Read what the simulator wrote of single wheels."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from synth.rover.law.identification import Trial
from synth.scene import SoilBinScene

_BLOCKS = 5
"""Of a steady run, for the standard error of its means: slow swings of the force make neighbours alike."""


@dataclass(frozen=True)
class Forces:
    """Of a run, each of shape (n,): columns of its `forces.csv`, SI units.

    `torque` is what drives the wheel.
    """

    time: NDArray
    travel: NDArray
    sinkage: NDArray
    force_x: NDArray
    force_z: NDArray
    torque: NDArray

    @classmethod
    def read(cls, path: Path) -> "Forces":
        """Read a run's `forces.csv`.

        Raises
        ------
        ValueError
            A column is missing.
        """
        with path.open(encoding="utf-8") as file:
            names = [one.partition(" ")[0] for one in file.readline().strip().split(",")]
        table = np.genfromtxt(path, delimiter=",", skip_header=1)
        wanted = ("time", "travel", "sinkage", "force_x", "force_z", "torque")
        missing = [name for name in wanted if name not in names]
        if missing:
            raise ValueError(f"{path}: no column {missing[0]!r}")
        return cls(*(table[:, names.index(name)] for name in wanted))


@dataclass(frozen=True)
class SteadyRun:
    """Means since the first frame, and their standard errors, of a wheel at constant slip."""

    label: str
    trial: Trial
    standard_error: Trial

    @classmethod
    def read(cls, label: str, scene: SoilBinScene, path: Path) -> "SteadyRun":
        """From a run's scene and its `forces.csv`."""
        forces = Forces.read(path)
        steady = forces.time > 0
        columns = np.stack([forces.sinkage, forces.force_x, forces.torque])[:, steady]
        blocks = np.array([part.mean(axis=1) for part in np.array_split(columns, _BLOCKS, axis=1)])
        errors = blocks.std(axis=0, ddof=1) / np.sqrt(_BLOCKS)
        travel, run_in = float(forces.travel[-1]), float(forces.travel[steady][0])
        measured = _trial(scene, columns.mean(axis=1), travel, 1 - run_in / travel)
        return cls(label, measured, _trial(scene, errors, travel, 1 - run_in / travel))


def _trial(scene: SoilBinScene, values: NDArray, travel: float, averaged: float) -> Trial:
    wheel = scene.implement
    sinkage, drawbar_pull, torque = values.tolist()
    return Trial(
        slip=scene.drive.slip,  # type: ignore[union-attr]
        load=wheel.normal_load,  # type: ignore[union-attr]
        radius=wheel.radius,  # type: ignore[union-attr]
        width=wheel.width,  # type: ignore[union-attr]
        sinkage=sinkage,
        drawbar_pull=drawbar_pull,
        torque=torque,
        travel=travel / wheel.radius,  # type: ignore[union-attr]
        averaged=averaged,
    )
