"""Streamlines of soil motion as polylines."""

import math
from dataclasses import dataclass

import numpy as np

# Px that a line goes forward at a time.
STEP = 1.0

# Lines shorter than this many spacings are dropped.
LEAST_LENGTH = 1.0


@dataclass(frozen=True, eq=False)
class Streamlines:
    """Lines that soil motion is tangent to everywhere, evenly spread.

    Attributes
    ----------
    lines : tuple of (N, 2) float64 arrays
        x, y in px, in the direction of motion.
    spacing : float
        Px that lines keep from each other, about.
    """

    lines: tuple[np.ndarray, ...]
    spacing: float


def trace_streamlines(
    displacement: np.ndarray,
    measured: np.ndarray,
    *,
    spacing: float = 20.0,
    least_speed: float = 0.1,
    longest: float = math.inf,
) -> Streamlines:
    """Follow the direction of motion forwards and backwards from places on a grid.

    A line ends where soil ends or was not measured, where it is slower than `least_speed`, at the border, and
    where it would come nearer to another than `spacing`; longer lines are laid first.

    Parameters
    ----------
    displacement : (H, W, 2) array
        (u, v) in px, as of one pair or of a mean.
    measured : (H, W) bool
        Where to use it: valid, and soil, or the moving region only.
    spacing : float, optional
        In px.
    least_speed : float, optional
        In px; slower soil has no direction worth the name.
    longest : float, optional
        Px that a line is followed each way at most; once around the picture by default.

    Raises
    ------
    ValueError
        If shapes differ, or `spacing` or `least_speed` is not above 0.
    """
    if displacement.shape != (*measured.shape, 2):
        raise ValueError(f"measured: shape {measured.shape}: must be {displacement.shape[:2]}")
    for name, value in (("spacing", spacing), ("least_speed", least_speed)):
        if not 0 < value < math.inf:
            raise ValueError(f"{name}: {value!r}: must be above 0")
    field = np.where(measured[:, :, None], displacement, np.nan).astype(np.float64)
    seeds = _seeds(field, spacing, least_speed)
    steps = math.ceil(min(longest, 2.0 * sum(measured.shape)) / STEP)
    forward, backward = (_followed(field, seeds, way * STEP, steps, least_speed) for way in (1, -1))
    lines = [_joined(backward[:, k], forward[:, k]) for k in range(len(seeds))]
    return Streamlines(tuple(_spread(lines, measured.shape, spacing)), spacing)


def _seeds(field: np.ndarray, spacing: float, least_speed: float) -> np.ndarray:
    """Places (N, 2) x, y of a square grid at which soil moves."""
    rows, columns = (np.arange(spacing / 2, side - 1, spacing) for side in field.shape[:2])
    places = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    return places[np.isfinite(_direction(field, places, least_speed)).all(axis=1)]


def _followed(
    field: np.ndarray, seeds: np.ndarray, step: float, steps: int, least_speed: float
) -> np.ndarray:
    """Positions (steps + 1, N, 2) of all lines by the classical Runge-Kutta method; NaN after their end."""
    track = [seeds]
    place = seeds
    for _ in range(steps):
        one = _direction(field, place, least_speed)
        two = _direction(field, place + step / 2 * one, least_speed)
        three = _direction(field, place + step / 2 * two, least_speed)
        four = _direction(field, place + step * three, least_speed)
        place = place + step / 6 * (one + 2 * two + 2 * three + four)
        if np.isnan(place).any(axis=1).all():
            break
        track.append(place)
    return np.array(track)


def _direction(field: np.ndarray, places: np.ndarray, least_speed: float) -> np.ndarray:
    """Unit vectors (N, 2) at places, bilinear between pixels; NaN beside what is NaN, and where slow."""
    height, width = field.shape[:2]
    x, y = places.T
    with np.errstate(invalid="ignore"):
        inside = (x >= 0) & (y >= 0) & (x <= width - 1) & (y <= height - 1)
    x, y = np.where(inside, x, 0.0), np.where(inside, y, 0.0)
    column = np.minimum(x.astype(np.intp), width - 2)
    row = np.minimum(y.astype(np.intp), height - 2)
    right, down = (x - column)[:, None], (y - row)[:, None]
    upper = (1 - right) * field[row, column] + right * field[row, column + 1]
    lower = (1 - right) * field[row + 1, column] + right * field[row + 1, column + 1]
    vector = (1 - down) * upper + down * lower
    speed = np.hypot(vector[:, 0], vector[:, 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        moves = inside & (speed >= least_speed)
        return np.where(moves[:, None], vector / speed[:, None], np.nan)


def _joined(backward: np.ndarray, forward: np.ndarray) -> np.ndarray:
    whole = np.concatenate([backward[:0:-1], forward])
    return whole[np.isfinite(whole).all(axis=1)]


def _spread(lines: list[np.ndarray], shape: tuple[int, ...], spacing: float) -> list[np.ndarray]:
    """Lay lines from the longest on; each gives way where another lies in the same cell or beside it."""
    cell = spacing / 2
    taken = np.full([math.ceil(side / cell) + 3 for side in shape], -1)
    kept: list[np.ndarray] = []
    for number, line in enumerate(sorted(lines, key=len, reverse=True)):
        columns, rows = (line / cell).astype(np.intp).T + 1
        around = np.stack([taken[rows + i, columns + j] for i in (-1, 0, 1) for j in (-1, 0, 1)])
        free = ((around == -1) | (around == number)).all(axis=0)
        part = _longest_run(line, free)
        if len(part) * STEP >= max(LEAST_LENGTH * spacing, 2):
            kept.append(part)
            columns, rows = (part / cell).astype(np.intp).T + 1
            taken[rows, columns] = number
    return kept


def _longest_run(line: np.ndarray, free: np.ndarray) -> np.ndarray:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], free, [False]]).astype(np.int8)))
    if not len(edges):
        return line[:0]
    starts, ends = edges[::2], edges[1::2]
    k = int(np.argmax(ends - starts))
    return line[starts[k] : ends[k]]
