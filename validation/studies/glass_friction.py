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
from validation.studies.flow_field import FlowField, Window, mean_flow
from validation.studies.study import Case, Findings, Row, Run, Study, changed, plain_axes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from synth.recording import Recording

FRICTIONS = (0.0, 0.1, 0.3, 0.5)
_KERNEL = 1.0
"""Standard deviation that motion is smoothed with / grain diameter."""
_MOVING = 0.1
"""Speeds at mid-plane below this share of the greatest there are left out."""


class GlassFriction(Study):
    """The same wheel against glass of more and more friction.

    Motion is averaged over frames in layers across the slab, a grain diameter thick, around the wheel. A
    layer's ratio is that factor of the mid-plane's velocity field which comes nearest to the layer's own;
    what is left over is its difference. The layer at the mid-plane is 1 by definition.
    """

    scene = "slab_wheel"
    columns: ClassVar[Mapping[str, str]] = {
        "glass_friction": "1",
        "distance": "mm",
        "ratio": "1",
        "difference": "1",
    }

    def cases(self, scene: SoilBinScene, *, quick: bool) -> list[Case]:
        """One for each friction, each with a slab that settled against its own glass."""
        if not scene.bed.thickness:
            raise ValueError(f"{scene.name}: bed.thickness = 0: a slab of spheres is needed")
        return [
            Case(f"friction-{friction:g}", changed(scene, bed={"glass_friction": friction}))
            for friction in FRICTIONS
        ]

    def find(self, runs: Sequence[Run]) -> Findings:
        """Ratio and difference of every layer of every run."""
        rows: list[Row] = []
        for run in runs:
            rows += layers_of(run.case.scene, run.recording())
        seen = [row for row in rows if row["distance"] == rows[0]["distance"]]
        told = ", ".join(f"{row['ratio']:.2f} at {row['glass_friction']:g}" for row in seen)
        return Findings(rows, f"Motion at the glass / at mid-plane, by glass friction: {told}.")

    def draw(self, findings: Findings) -> "Figure":
        """Profiles across the slab, and the layer at the glass against friction."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8.4, 3.8), layout="constrained")
        across, at_glass = plain_axes(figure, 1, 2)[0]
        frictions = sorted({float(row["glass_friction"]) for row in findings.rows})
        for friction in frictions:
            rows = [row for row in findings.rows if row["glass_friction"] == friction]
            distance, ratio = ([float(row[name]) for row in rows] for name in ("distance", "ratio"))
            across.plot(distance, ratio, "o-", markersize=3.5, linewidth=1.3, label=f"{friction:g}")
        across.set_xlabel("distance from the glass [mm]")
        across.set_ylabel("velocity / that at mid-plane")
        top = 1.1 * max(
            1.05, *(float(row[name]) for row in findings.rows for name in ("ratio", "difference"))
        )
        across.set_ylim(0, top)
        across.legend(title="glass friction", frameon=False)
        nearest = [next(row for row in findings.rows if row["glass_friction"] == one) for one in frictions]
        for name, colour in (("ratio", "#4c78a8"), ("difference", "#e45756")):
            at_glass.plot(frictions, [float(row[name]) for row in nearest], "o-", color=colour, label=name)
        at_glass.set_xlabel("glass friction")
        at_glass.set_ylabel("layer at the glass")
        at_glass.set_ylim(0, top)
        at_glass.legend(frameon=False)
        return figure


STUDY = GlassFriction()


def layers_of(scene: SoilBinScene, recording: "Recording") -> list[Row]:
    """Rows of one run, from the glass to the mid-plane."""
    from synth.recording import Recording

    thickness, diameter = scene.bed.thickness, scene.bed.grain_diameter
    count = round(thickness / diameter)
    mean_y = recording.data["position_y"].mean("frame").values
    layer = np.minimum((mean_y / thickness * count).astype(int), count - 1)
    window = _window(scene)
    fields = [
        mean_flow(
            Recording(recording.data.isel(particle=layer == number)),
            window,
            spacing=diameter,
            kernel=_KERNEL * diameter,
        )
        for number in range(count)
    ]
    rows: list[Row] = []
    for number, field in enumerate(fields):
        ratio, difference = likeness(field, fields[-1])
        rows.append(
            {
                "glass_friction": scene.bed.glass_friction,
                "distance": round(1000 * (number + 0.5) * thickness / count, 6),
                "ratio": ratio,
                "difference": difference,
            }
        )
    return rows


def likeness(field: FlowField, other: FlowField) -> tuple[float, float]:
    """Factor by which `other` comes nearest to `field`, and what is left / that field's root of mean square.

    Where both have soil, and `other` moves.
    """
    speed = np.hypot(*other.velocity)
    counted = np.isfinite(field.velocity[0]) & (speed > _MOVING * np.nanmax(speed))
    one, two = field.velocity[:, counted], other.velocity[:, counted]
    factor = float((one * two).sum() / (two**2).sum())
    return factor, float(np.sqrt(((one - factor * two) ** 2).sum() / (two**2).sum()))


def _window(scene: SoilBinScene) -> Window:
    """From behind the wheel to ahead of it, and from its radius below the surface to the surface."""
    implement = scene.implement
    reach = implement.radius if isinstance(implement, RigidWheel) else implement.shape.reach
    return Window(-1.2 * reach, 1.2 * reach, -min(reach, scene.bed.depth), 0.0)
