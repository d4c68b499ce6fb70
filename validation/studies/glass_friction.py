"""Whether the glass is a plane of symmetry: soil's motion at the glass against that at mid-plane.

The paper's half-width wheel runs along the glass, which is taken for the wheel's middle. Glass has friction:
a slab of spheres between glass and a mirror, the mid-plane, says how much the motion seen through the glass
falls short of that at mid-plane.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from synth.implements import RigidWheel
from synth.scene import SoilBinScene
from validation.studies.flow_field import Window, mean_flow
from validation.studies.study import (
    Case,
    Findings,
    Row,
    Run,
    Study,
    changed,
    column,
    error_bars,
    plain_axes,
    steady_means,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from synth.recording import Recording

FRICTIONS = (0.0, 0.1, 0.3, 0.5)
REALISATIONS = 5
"""Slabs of each friction, each packed by another seed: one alone says little."""
_KERNEL = 1.0
"""Standard deviation that motion is smoothed with / grain diameter."""
_MOVING = 0.1
"""Speeds at mid-plane below this share of the greatest there are left out."""


class GlassFriction(Study):
    """The same wheel against glass of more and more friction, in several realisations of the slab.

    Motion is averaged over frames in layers across the slab, a grain diameter thick, around the wheel. A
    layer's ratio is that factor of the mid-plane's velocity field which comes nearest to the layer's own; its
    share is the same of the mean field of all layers, which scatters less. Without friction the glass is a
    mirror as the mid-plane is, so that all have to be 1 within the error.
    """

    scene = "slab_wheel"
    columns: ClassVar[Mapping[str, str]] = {
        "glass_friction": "1",
        "distance": "mm",
        "ratio": "1",
        "ratio_error": "1",
        "share": "1",
        "share_error": "1",
        "sinkage": "mm",
        "sinkage_deviation": "mm",
    }

    def cases(self, scene: SoilBinScene, *, quick: bool) -> list[Case]:
        """Every friction with every seed, each with a slab that settled against its own glass."""
        if not scene.bed.thickness:
            raise ValueError(f"{scene.name}: bed.thickness = 0: a slab of spheres is needed")
        return [
            Case(
                f"friction-{friction:g}-seed-{seed}",
                changed(scene, bed={"glass_friction": friction}, seed=seed),
            )
            for seed in range(scene.seed, scene.seed + REALISATIONS)
            for friction in FRICTIONS
        ]

    def find(self, runs: Sequence[Run]) -> Findings:
        """Ratio of every layer, by glass friction."""
        rows: list[Row] = []
        for friction in FRICTIONS:
            alike = [run for run in runs if run.case.scene.bed.glass_friction == friction]
            rows += _rows(friction, alike)
        seen = [row for row in rows if row["distance"] == rows[0]["distance"]]
        at_mid_plane, of_slab = (
            ", ".join(
                f"{row[name]:.2f} +- {row[f'{name}_error']:.2f} at {row['glass_friction']:g}" for row in seen
            )
            for name in ("ratio", "share")
        )
        return Findings(
            rows,
            f"Motion at the glass / at mid-plane, by glass friction: {at_mid_plane}; / of the whole slab: "
            f"{of_slab} (+- one standard error, {len(runs) // len(FRICTIONS)} slabs each).",
        )

    def draw(self, findings: Findings) -> "Figure":
        """Profiles across the slab, and the layer at the glass against friction."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8.4, 3.8), layout="constrained")
        across, at_glass = plain_axes(figure, 1, 2)[0]
        rows = findings.rows
        frictions = sorted(set(column(rows, "glass_friction")))
        for place, friction in enumerate(frictions):
            own = [row for row in rows if row["glass_friction"] == friction]
            distance = column(own, "distance")
            # Beside each other, so that bars of one can be told from those of the next.
            beside = 0.04 * (place - (len(frictions) - 1) / 2) * (distance[1] - distance[0])
            across.errorbar(
                distance + beside, column(own, "share"), column(own, "share_error"), marker="o",
                markersize=3.5, linewidth=1.3, capsize=2, label=f"{friction:g}",
            )  # fmt: skip
        across.set_xlabel("distance from the glass [mm]")
        across.set_ylabel("velocity / the whole slab's")
        across.legend(title="glass friction", frameon=False)
        nearest = [row for row in rows if row["distance"] == rows[0]["distance"]]
        error_bars(
            at_glass, frictions, column(nearest, "ratio"), column(nearest, "ratio_error"), colour="#4c78a8"
        )
        at_glass.set_xlabel("glass friction")
        at_glass.set_ylabel("velocity at the glass / at mid-plane")
        for axes in (across, at_glass):
            axes.axhline(1, color="0.5", linewidth=0.8, linestyle=":")
            axes.set_ylim(0, 1.05 * axes.get_ylim()[1])
        figure.supxlabel("bars: one standard error over realisations of the slab", fontsize=8)
        return figure


STUDY = GlassFriction()


def _rows(friction: float, runs: Sequence[Run]) -> list[Row]:
    """Rows of one friction, from the glass to the mid-plane."""
    fields, sinkage = [], []
    for run in runs:
        recording = run.recording()
        fields.append(layers_of(run.case.scene, recording))
        sinkage.append(1000 * steady_means(recording)["sinkage"][0])
    motion, bed = np.array(fields), runs[0].case.scene.bed
    count = motion.shape[1]
    rows: list[Row] = []
    for layer in range(count):
        ratio, error = likeness(motion[:, layer], motion[:, -1])
        share, share_error = likeness(motion[:, layer], motion.mean(axis=1))
        rows.append(
            {
                "glass_friction": friction,
                "distance": round(1000 * (layer + 0.5) * bed.thickness / count, 6),
                "ratio": ratio,
                "ratio_error": error,
                "share": share,
                "share_error": share_error,
                "sinkage": float(np.mean(sinkage)),
                "sinkage_deviation": float(np.std(sinkage)),
            }
        )
    return rows


def layers_of(scene: SoilBinScene, recording: "Recording") -> np.ndarray:
    """Velocity fields of the layers of one slab, from the glass to the mid-plane, m/s (layers, 2, Z, X)."""
    from synth.recording import Recording

    thickness, diameter = scene.bed.thickness, scene.bed.grain_diameter
    count = round(thickness / diameter)
    mean_y = recording.data["position_y"].mean("frame").values
    layer = np.minimum((mean_y / thickness * count).astype(int), count - 1)
    fields = [
        mean_flow(
            Recording(recording.data.isel(particle=layer == number)),
            _window(scene),
            spacing=diameter,
            kernel=_KERNEL * diameter,
        )
        for number in range(count)
    ]
    return np.array([field.velocity for field in fields])


def likeness(one: np.ndarray, other: np.ndarray) -> tuple[float, float]:
    """Factor by which the mean of `other` comes nearest to the mean of `one`, and its standard error.

    Where all have soil, and `other` moves. Products of a field with another realisation's alone are summed:
    noise of one and the same field would add to its square, and make the factor too small. The error is the
    jackknife's over the realisations; NaN for fewer than three.

    Parameters
    ----------
    one, other : ndarray, shape (realisations, 2, Z, X)
        Velocity fields, those of the same place from the same realisation.
    """
    known = np.isfinite(one).all(axis=(0, 1)) & np.isfinite(other).all(axis=(0, 1))
    speed = np.where(known, np.hypot(*other.mean(axis=0)), 0.0)
    counted = speed > _MOVING * speed.max()
    one, other = one[:, :, counted].reshape(len(one), -1), other[:, :, counted].reshape(len(other), -1)
    numerator, denominator = one @ other.T, other @ other.T
    factor, count = _factor(numerator, denominator), len(one)
    if count < 3:
        return factor, float("nan")
    left_out = [
        _factor(*(np.delete(np.delete(products, k, 0), k, 1) for products in (numerator, denominator)))
        for k in range(count)
    ]
    return factor, float(np.sqrt((count - 1) * np.var(left_out)))


def _factor(numerator: np.ndarray, denominator: np.ndarray) -> float:
    """Quotient of the sums of products between different realisations; of all products where there is one."""
    if len(numerator) > 1:
        numerator, denominator = (sums - np.diag(np.diag(sums)) for sums in (numerator, denominator))
    return float(numerator.sum() / denominator.sum())


def _window(scene: SoilBinScene) -> Window:
    """From behind the wheel to ahead of it, and from its radius below the surface to the surface."""
    implement = scene.implement
    reach = implement.radius if isinstance(implement, RigidWheel) else implement.shape.reach
    return Window(-1.2 * reach, 1.2 * reach, -min(reach, scene.bed.depth), 0.0)
