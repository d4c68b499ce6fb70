"""The pair of pictures that the page shows of a measurement: the middle one."""

from typing import TYPE_CHECKING

import numpy as np

from validation.pair_view import Measured, Motion, PairView, true_motion
from validation.scoring.metrics import end_point_error

if TYPE_CHECKING:
    import xarray as xr

    from soft.averaging import MeanFlow
    from synth import Footage

DIMS = ("shown_y", "shown_x")
MEASURE = f"{__name__}:measure"
_STEP = 1024.0
"""Per px: what motions are rounded to, so that they take little room on disk."""
_FLAGS = ("soil", "moving", "valid")


def measure(footage: "Footage", flow: "xr.Dataset") -> "xr.Dataset":
    """Keep picture, truth and measurement of the middle pair."""
    import xarray as xr

    pair = flow.sizes["pair"] // 2
    truth, found = footage.truth(pair), flow.isel(pair=pair).load()
    motion = true_motion(truth)
    error = end_point_error(*(found[name].values - truth[name].values for name in ("u", "v")))
    judged = np.isfinite(motion.u) & found["valid"].values.astype(bool)
    fields = {
        "inertial_u": found["inertial_u"].values,
        "inertial_v": found["inertial_v"].values,
        "true_u": motion.u,
        "true_v": motion.v,
        "error": np.where(judged, error, np.nan),
    }
    kept = {f"shown_{name}": (DIMS, rounded(values)) for name, values in fields.items()}
    kept |= {f"shown_{name}": (DIMS, found[name].values.astype(np.int8)) for name in _FLAGS}
    kept["shown_picture"] = (DIMS, footage.picture(pair))
    told = {
        "shown_pair": pair,
        "shown_frames": [int(found["first_frame"]), int(found["second_frame"])],
        "shown_scale": [footage.metres_per_pixel, footage.frame_rate],
        "shown_camera_u": float(found["camera_u"]),
    }
    return xr.Dataset(kept, attrs=told)


def rounded(values: np.ndarray) -> np.ndarray:
    """Motion in px to a 1024th of a px."""
    return (np.round(np.asarray(values, np.float64) * _STEP) / _STEP).astype(np.float32)


def picture_of(measured: "xr.Dataset") -> np.ndarray:
    """The first picture of the pair, (H, W)."""
    return np.asarray(measured["shown_picture"].values)


def flow_of(measured: "xr.Dataset") -> "xr.Dataset":
    """The pair as a SoilFlow of one pair, with what figures of it need."""
    import xarray as xr

    fields = {name: measured[f"shown_{name}"].values for name in ("inertial_u", "inertial_v")}
    fields |= {name: measured[f"shown_{name}"].values.astype(bool) for name in _FLAGS}
    scale, rate = (float(value) for value in measured.attrs["shown_scale"])
    first, second = (int(frame) for frame in measured.attrs["shown_frames"])
    return xr.Dataset(
        {name: (("pair", "y", "x"), values[np.newaxis]) for name, values in fields.items()},
        coords={"first_frame": ("pair", [first]), "second_frame": ("pair", [second])},
        attrs={"metres_per_pixel": scale, "frame_rate": rate, "method": measured.attrs["method"]},
    )


def view_of(measured: "xr.Dataset") -> PairView:
    """The pair with its truth and this one measurement."""
    from soft.figures.units import Units

    scale, rate = (float(value) for value in measured.attrs["shown_scale"])
    true, own = (
        Motion(measured[f"shown_{name}_u"].values, measured[f"shown_{name}_v"].values)
        for name in ("true", "inertial")
    )
    error = measured["shown_error"].values
    soil = np.isfinite(true.u)
    missed = soil & ~np.isfinite(error)
    camera = float(measured.attrs["shown_camera_u"])
    return PairView(
        pair=int(measured.attrs["shown_pair"]),
        picture=picture_of(measured),
        truth=true,
        strata={},
        measured={measured.attrs["method"]: Measured(own, error, missed, camera, soil)},
        camera_u=camera,
        units=Units.of(metres_per_pixel=scale, frame_rate=rate),
    )


def mean_flow_of(measured: "xr.Dataset") -> "MeanFlow":
    """Flow averaged over all pairs, kept by `validation.suites.paper.averaging`, as its figure takes it."""
    from soft import MeanFlow
    from soft.averaging_gain import GainTally

    u, v = (measured[f"averaging_{name}"].values for name in ("u", "v"))
    count = np.isfinite(u).astype(np.int32)
    unknown = np.full(u.shape, np.nan, np.float32)
    scale, rate = (float(value) for value in measured.attrs["shown_scale"])
    return MeanFlow(
        u, v, count, unknown, unknown, count > 0, tuple(range(measured.sizes["pair"])), GainTally().result(),
        metres_per_pixel=scale, frame_rate=rate,
    )  # fmt: skip
