"""Run by pyvale's own interpreter, never imported: pictures in, a grid of vectors out.

Usage: subset_dic_script.py FIRST.npy SECOND.npy GRID.npz

GRID.npz holds x, y, u, v (px) and converged (0 or 1) of every subset, the seconds it took, and its version.
"""

import csv
import os
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np
from pyvale import dic

SUBSET, STEP = 31, 10
"""Side of the subsets and the way between their middles, px."""
FURTHEST = 32
"""Largest motion that is looked for, px."""
_COLUMNS = {
    "x": "subset_x",
    "y": "subset_y",
    "u": "disp_u",
    "v": "disp_v",
    "converged": "converged",
}


def main(first: str, second: str, grid: str) -> None:
    """Measure and write."""
    pictures = [np.rint(np.load(path)).astype(np.uint8) for path in (first, second)]
    height, width = pictures[0].shape
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        dic.calculate_2d(
            reference=pictures[0],
            deformed=pictures[1][None],
            roi_mask=np.ones((height, width), bool),
            seed=[width // 2, height // 2],
            subset_size=SUBSET,
            subset_step=STEP,
            shape_function="AFFINE",
            max_displacement=FURTHEST,
            num_threads=int(os.environ.get("OMP_NUM_THREADS", os.cpu_count() or 1)),
            output_basepath=folder,
        )
        seconds = time.perf_counter() - began
        (path,) = Path(folder).glob("*.csv")
        with path.open(encoding="utf-8", newline="") as lines:
            rows = list(csv.DictReader(lines))
    told = {name: np.array([float(row[column]) for row in rows]) for name, column in _COLUMNS.items()}
    np.savez(grid, allow_pickle=False, seconds=seconds, version=version("pyvale"), **told)


if __name__ == "__main__":
    main(*sys.argv[1:])
