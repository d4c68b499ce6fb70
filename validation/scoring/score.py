"""Compare soil flow with the truth: `scores.json`."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from synth.text_files import checked, read_json_object
from validation.scoring.averaging import AveragingScore
from validation.scoring.camera import CameraScore, camera_of
from validation.scoring.metrics import ErrorSummary, ErrorTally
from validation.scoring.nodes import difference_at, has_node, stacked
from validation.scoring.regions import RegionScore
from validation.scoring.strata import STRATA
from validation.scoring.truth_pass import TruePair

if TYPE_CHECKING:
    import xarray as xr

    from synth import Footage

SCHEMA_VERSION = 1


class ScoreError(ValueError):
    """A measurement that cannot be compared with this footage; the message is one line."""


@dataclass(frozen=True)
class MethodScore:
    """How one method did.

    Attributes
    ----------
    seconds_per_pair : float or None
        Wall time of the analysis a picture pair.
    strata : dict
        An `ErrorSummary` for every name of `STRATA`.
    camera : CameraScore or None
        How well the camera's motion was found.
    regions : RegionScore or None
        How well soil, its moving part and the shear interface were found; None if the method tells no masks.
    averaging : AveragingScore or None
        What averaging over pairs does for the error; None if the method tells no inertial motion.
    """

    seconds_per_pair: float | None
    strata: dict[str, ErrorSummary]
    camera: CameraScore | None = None
    regions: RegionScore | None = None
    averaging: AveragingScore | None = None

    def to_dict(self) -> dict[str, Any]:
        """As it stands in scores.json; without what is not known."""
        table: dict[str, Any] = {"seconds_per_pair": self.seconds_per_pair}
        if self.camera is not None:
            table["camera"] = self.camera.to_dict()
        for part in (self.regions, self.averaging):
            if part is not None:
                table |= part.to_dict()
        return table | {"strata": {name: summary.to_dict() for name, summary in self.strata.items()}}


@dataclass(frozen=True)
class Scores:
    """The content of `scores.json`."""

    scene: str
    seed: int
    quick: bool
    methods: dict[str, MethodScore]
    versions: dict[str, str]

    def to_dict(self) -> dict[str, Any]:
        """As it stands in scores.json."""
        return {
            "schema_version": SCHEMA_VERSION,
            "scene": self.scene,
            "seed": self.seed,
            "quick": self.quick,
            "versions": self.versions,
            "methods": {name: method.to_dict() for name, method in self.methods.items()},
        }

    def write(self, path: str | Path) -> None:
        """Write `scores.json`."""
        Path(path).write_text(json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n", encoding="utf-8")

    @classmethod
    def read(cls, path: str | Path) -> "Scores":
        """Read `scores.json`.

        Raises
        ------
        ScoreError
            Not scores, or of another schema version.
        """
        try:
            told = checked(_ToldScores, read_json_object(Path(path), schema_version=SCHEMA_VERSION))
            methods = {name: _method_from(table, f"methods.{name}") for name, table in told.methods.items()}
        except ValueError as error:
            raise ScoreError(f"{path}: not scores: {error}") from None
        return cls(told.scene, told.seed, told.quick, methods, told.versions)


@dataclass(frozen=True)
class _ToldScores:
    """What scores.json holds."""

    scene: str
    seed: int
    quick: bool
    versions: dict[str, str]
    methods: dict[str, dict[str, Any]]


def _method_from(table: dict[str, Any], name: str) -> MethodScore:
    """A method's part of scores.json, whose regions' numbers stand beside its own."""
    method = checked(MethodScore, table, name=name)
    regions = checked(RegionScore, table, name=name) if "soil_iou" in table else None
    return replace(method, regions=regions)


def score_pair(true: TruePair, flow: "xr.Dataset") -> dict[str, ErrorSummary]:
    """Errors of one method in every stratum of one picture pair; the flow over `y, x`."""
    tally = StratumTally()
    tally.add(true, flow)
    return tally.result()


class StratumTally:
    """Errors of one method in every stratum, pair by pair."""

    def __init__(self) -> None:
        # Strata overlap; the combinations of them do not: each pixel's error is kept once.
        self._parts: dict[int, ErrorTally] = {}

    def add(self, true: TruePair, flow: "xr.Dataset") -> None:
        """Add one pair of a SoilFlow, over `y, x`."""
        codes = _membership(true.strata.masks)
        nodes = stacked(flow, "node_x", "node_y") if "node_x" in flow else None
        difference = difference_at(stacked(flow, "u", "v"), stacked(true.data, "u", "v"), nodes)
        if "valid" in flow:
            difference[~flow["valid"].values.astype(bool)] = np.nan
        told = None if nodes is None else has_node(nodes)
        for code in np.unique(codes[codes > 0]):
            here = codes == code
            node_count = None if told is None else int(np.count_nonzero(told & here))
            self._parts.setdefault(int(code), ErrorTally()).add(*difference[here].T, node_count=node_count)

    def result(self) -> dict[str, ErrorSummary]:
        """A summary for every name of `STRATA`."""
        return {
            name: ErrorTally.summary(
                [tally for code, tally in sorted(self._parts.items()) if code >> bit & 1]
            )
            for bit, name in enumerate(STRATA)
        }


def require_all_match(footage: "Footage", flows: "Mapping[str, xr.Dataset]") -> None:
    """Refuse flows that are not of this footage.

    Raises
    ------
    ScoreError
        One has another size, or other pairs.
    """
    sizes = footage.truth(0).sizes
    for name, flow in flows.items():
        require_match(name, flow, shape=(sizes["y"], sizes["x"]), pair_count=footage.pair_count)


def require_match(name: str, flow: "xr.Dataset", *, shape: tuple[int, int], pair_count: int) -> None:
    """Refuse a flow that was not measured on pictures of this shape (rows, columns) and number of pairs."""
    from soft.inertial import CAMERA_CHOICES

    measured = (flow.sizes.get("y"), flow.sizes.get("x"))
    if measured != shape:
        raise ScoreError(
            f"analysis of {name}: {measured[1]} x {measured[0]} px, "
            f"but the footage has {shape[1]} x {shape[0]} px"
        )
    if flow.sizes.get("pair") != pair_count:
        raise ScoreError(
            f"analysis of {name}: {flow.sizes.get('pair')} picture pairs, but the footage has {pair_count}"
        )
    if "first_frame" in flow.coords:
        first, second = flow["first_frame"].values, flow["second_frame"].values
        if not (np.array_equal(first, np.arange(pair_count)) and np.array_equal(second, first + 1)):
            raise ScoreError(f"analysis of {name}: its pairs are not the footage's consecutive ones")
    if (camera := camera_of(flow)) not in CAMERA_CHOICES:
        raise ScoreError(
            f"analysis of {name}: camera = {camera!r}: allowed are {', '.join(CAMERA_CHOICES)}: analyze again"
        )


def _membership(masks: dict[str, np.ndarray]) -> np.ndarray:
    """Bit k is set where a pixel belongs to the k-th stratum; (H, W) uint8, 0 where it belongs to none."""
    codes = np.zeros(masks[STRATA[0]].shape, np.uint8)
    for bit, name in enumerate(STRATA):
        codes |= masks[name].astype(np.uint8) << np.uint8(bit)
    return codes
