"""Spatial resolution: how much of a strain that alternates a method still tells, against its period.

On the scene `sinusoidal_strain`, each column of the picture moves up and down as a cosine of the height, with
a period of its own. The response at a period is the slope of measured on true motion over the columns that
have it: 1 where all of the amplitude is told, 0 where none is (after the "star" pictures of Reu et al., DIC
Challenge 2.0, Experimental Mechanics 62, 2022, who read the middle row alone).
"""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

PERIOD_EDGES = tuple(float(edge) for edge in np.geomspace(20.0, 300.0, 15))
"""px, of the bins that periods are sorted into."""
PERIODS = np.sqrt(np.multiply(PERIOD_EDGES[:-1], PERIOD_EDGES[1:]))
"""px, middle of each bin."""


def response_sums(truth: "xr.Dataset", flow: "xr.Dataset", periods: np.ndarray) -> "xr.Dataset":
    """Sums that the response is a ratio of; those of several pairs add up.

    Parameters
    ----------
    truth, flow : xarray.Dataset
        Over `y, x`.
    periods : (W,) array
        Period of the strain in each column, px.

    Returns
    -------
    xarray.Dataset
        Over `period`: `response_product` of measured and true vertical motion, `response_square` of the true
        one, px2. What is not measured counts as a motion of zero: it tells nothing.
    """
    import xarray as xr

    known = truth["valid"].values & np.isfinite(truth["v"].values)
    true = np.where(known, truth["v"].values, 0.0).astype(np.float64)
    measured = np.where(known, np.nan_to_num(flow["v"].values), 0.0)
    if "valid" in flow:
        measured = np.where(flow["valid"].values.astype(bool), measured, 0.0)
    bins = np.digitize(periods, PERIOD_EDGES) - 1
    chosen = (bins >= 0) & (bins < len(PERIODS))
    sums = {
        name: np.bincount(bins[chosen], weights=values.sum(axis=0)[chosen], minlength=len(PERIODS))
        for name, values in (("response_product", measured * true), ("response_square", true * true))
    }
    return xr.Dataset({name: ("period", values) for name, values in sums.items()}, {"period": PERIODS})


def response(sums: "xr.Dataset") -> np.ndarray:
    """Share of the amplitude that is told at each of PERIODS; NaN where no column has it."""
    product, square = sums["response_product"].values, sums["response_square"].values
    return np.divide(product, square, out=np.full(square.shape, np.nan), where=square > 0)


def resolved_period(shares: np.ndarray, least: float) -> float:
    """Shortest period from which on at least a share of the amplitude is told, px.

    Parameters
    ----------
    shares : (P,) array
        As `response` tells them.
    least : float
        The share.

    Returns
    -------
    float
        Interpolated over the logarithm of the period; NaN if even the longest is told less, the shortest one
        measured if that is told well enough.
    """
    known = np.isfinite(shares)
    periods, shares = PERIODS[known], shares[known]
    short = np.flatnonzero(shares < least)
    if not len(shares) or (len(short) and short[-1] == len(shares) - 1):
        return float("nan")
    if not len(short):
        return float(periods[0])
    k = short[-1]
    part = (least - shares[k]) / (shares[k + 1] - shares[k])
    return float(periods[k] * (periods[k + 1] / periods[k]) ** part)
