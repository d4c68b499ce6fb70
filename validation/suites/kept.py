"""What a suite found, small enough to be kept: tables that docs and figures are made of without a rerun.

A folder of three files: `lines.csv.gz`, a line for each picture pair, stratum and method; `profiles.nc`, for
each set of pictures and method the errors by what may explain them; `about.json`, what made them.
"""

import gzip
import io
import json
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from synth.text_files import checked, read_json_object
from validation.published import REFERENCE_FOLDER
from validation.scoring.error_profile import EXPLANATIONS, MOMENTS, percentile, share_above
from validation.scoring.metrics import WRONG_ABOVE
from validation.suites.gathered import Gathered
from validation.suites.plan import Look
from validation.suites.table import Line, read_lines, write_lines

if TYPE_CHECKING:
    import xarray as xr

T = TypeVar("T")

SCHEMA_VERSION = 1
SHIPPED = REFERENCE_FOLDER / "measured" / "complex"
"""What the docs tell of."""
LINES, PROFILES, ABOUT = "lines.csv.gz", "profiles.nc", "about.json"
_WRONG = WRONG_ABOVE[0]
_LOOK = ("scene", "label", "severity", "stride", "method", "seed", "picture_seed")
_MEANINGS = {
    "pixel_count": "pixels of the bin, measured or not",
    "wrong_count": f"those wrong by more than {_WRONG} px, or not measured",
    "unmeasured_count": "those not measured",
    "median": "median error of the others, px",
    "directed_count": "measured ones that move by 0.1 px at least",
    "bias": "mean error of these along the true motion, px",
    "random": "its standard deviation, px",
}


class KeptError(ValueError):
    """Tables that cannot be read; the message is one line."""


@dataclass(frozen=True)
class _About:
    """What `about.json` must tell."""

    measured: int
    of: int


@dataclass(frozen=True, eq=False)
class Kept:
    """Tables read.

    Attributes
    ----------
    lines : list of dict
    profiles : xarray.Dataset
        Over `look` (its labels are coordinates) and `bin` (`explanation` and `range` are).
    about : dict
        `command`, `versions`, `machine`, `suite`, `measured`, `of`.
    """

    lines: list[Line]
    profiles: "xr.Dataset"
    about: dict[str, Any]


def write_kept(gathered: Gathered, folder: Path, about: Mapping[str, Any]) -> None:
    """Write the tables of a suite into a folder; files that are there are replaced."""
    folder.mkdir(parents=True, exist_ok=True)
    text = io.StringIO(newline="")
    write_lines(gathered.lines, text)
    # No time and no name inside: the same lines are the same bytes.
    (folder / LINES).write_bytes(gzip.compress(text.getvalue().encode("utf-8"), mtime=0))
    profiles = profile_table(gathered.profiles)
    encoding = {name: {"zlib": True, "complevel": 9, "shuffle": True} for name in profiles.data_vars}
    profiles.to_netcdf(folder / PROFILES, engine="h5netcdf", encoding=encoding)
    told = {"schema_version": SCHEMA_VERSION, **about}
    (folder / ABOUT).write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


def read_kept(folder: Path) -> Kept:
    """Read tables that were kept.

    Raises
    ------
    KeptError
        There are none, or of another schema version.
    """
    about = _read(folder / ABOUT, _read_about)
    return Kept(_read(folder / LINES, _read_lines), _read(folder / PROFILES, _read_profiles), about)


def _read(path: Path, reader: Callable[[Path], T]) -> T:
    try:
        return reader(path)
    except FileNotFoundError:
        raise KeptError(f"{path.parent}: no tables of a suite: it holds no {path.name}") from None
    except (OSError, EOFError, zlib.error, KeyError, ValueError) as error:
        raise KeptError(f"{path}: not of the tables of a suite: {error}") from None


def _read_about(path: Path) -> dict[str, Any]:
    told = read_json_object(path, schema_version=SCHEMA_VERSION)
    checked(_About, told)
    return told


def _read_lines(path: Path) -> list[Line]:
    text = gzip.decompress(path.read_bytes()).decode("utf-8")
    return read_lines(io.StringIO(text, newline=""))


def _read_profiles(path: Path) -> "xr.Dataset":
    import xarray as xr

    with xr.open_dataset(path, engine="h5netcdf") as profiles:
        return profiles.load()


def profile_table(profiles: "Sequence[tuple[Look, xr.Dataset]]") -> "xr.Dataset":
    """Errors of every look by everything that may explain them, summed up."""
    import xarray as xr

    rows = [_row(profile) for _, profile in profiles]
    explanations, ranges = zip(*_bins(), strict=True)
    variables = {
        name: (("look", "bin"), np.array([row[name] for row in rows]), {"long_name": told})
        for name, told in _MEANINGS.items()
    }
    coordinates: dict[str, Any] = {
        "explanation": ("bin", list(explanations)),
        "range": ("bin", list(ranges)),
        **{name: ("look", [_label(look, name) for look, _ in profiles]) for name in _LOOK},
    }
    found = xr.Dataset(variables, coordinates)
    return found.merge(_responses([profile for _, profile in profiles]))


def _bins() -> list[tuple[str, int]]:
    return [(name, k) for name, one in EXPLANATIONS.items() for k in range(len(one.edges) - 1)]


def _label(look: Look, name: str) -> Any:
    realisation = look.realisation
    told = {"scene": realisation.motion.scene, "seed": realisation.motion.seed, "method": look.method}
    return told[name] if name in told else getattr(realisation, name)


def _row(profile: "xr.Dataset") -> dict[str, np.ndarray]:
    parts = [_summary(profile, name) for name in EXPLANATIONS]
    return {name: np.concatenate([part[name] for part in parts]) for name in _MEANINGS}


def _summary(profile: "xr.Dataset", name: str) -> dict[str, np.ndarray]:
    counts, unmeasured = profile[f"count_{name}"].values, profile[f"unmeasured_{name}"].values
    measured = counts.sum(axis=1)
    sums = dict(zip(MOMENTS, profile[f"sums_{name}"].values.T, strict=True))
    with np.errstate(invalid="ignore", divide="ignore"):
        bias = sums["along"] / sums["number"]
        spread = np.sqrt(np.maximum(sums["along_squared"] / sums["number"] - bias**2, 0))
    wrong = unmeasured + measured * np.nan_to_num(share_above(counts, _WRONG))
    return {
        "pixel_count": (measured + unmeasured).astype(np.int32),
        "wrong_count": np.rint(wrong).astype(np.int32),
        "unmeasured_count": unmeasured.astype(np.int32),
        "median": percentile(counts, 0.5).astype(np.float32),
        "directed_count": sums["number"].astype(np.int32),
        "bias": bias.astype(np.float32),
        "random": spread.astype(np.float32),
    }


def _responses(profiles: "Sequence[xr.Dataset]") -> "xr.Dataset":
    """Sums of the spatial response, NaN for looks at other scenes; nothing where no look has any."""
    import xarray as xr

    with_response = next((one for one in profiles if "response_product" in one), None)
    if with_response is None:
        return xr.Dataset()
    nothing = np.full(with_response.sizes["period"], np.nan)
    names = ("response_product", "response_square")
    sums = {
        name: (("look", "period"), np.array([p[name].values if name in p else nothing for p in profiles]))
        for name in names
    }
    return xr.Dataset(sums, {"period": with_response["period"].values})
