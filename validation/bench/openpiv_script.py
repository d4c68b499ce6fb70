"""Run by OpenPIV's own interpreter, never imported: pictures in, a grid of vectors out.

Usage: openpiv_script.py FIRST.npy SECOND.npy GRID.npz

GRID.npz holds x, y, u, v and flags as `simple_multipass` gives them, the seconds it took, and OpenPIV's
version.
"""

import sys
import time
from importlib.metadata import version

import numpy as np
from openpiv import windef

WINDOWS = (64, 32, 32)
"""Sides of the windows, px, pass by pass; they overlap by half."""


def main(first: str, second: str, grid: str) -> None:
    """Measure and write."""
    settings = windef.PIVSettings()
    settings.windowsizes = WINDOWS
    settings.overlap = tuple(side // 2 for side in WINDOWS)
    settings.num_iterations = len(WINDOWS)
    settings.show_plot = settings.save_plot = False
    pictures = [np.load(path) for path in (first, second)]
    began = time.perf_counter()
    x, y, u, v, flags = windef.simple_multipass(*pictures, settings)
    seconds = time.perf_counter() - began
    u, v = (np.ma.filled(component, np.nan) for component in (u, v))
    told = {"x": x, "y": y, "u": u, "v": v, "flags": np.asarray(flags, float)}
    np.savez(grid, allow_pickle=False, seconds=seconds, version=version("OpenPIV"), **told)


if __name__ == "__main__":
    main(*sys.argv[1:])
