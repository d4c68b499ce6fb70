"""What the angle of a wedge changes: the forces on it."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

from synth.scene import SoilBinScene
from validation.studies.study import (
    Case,
    Findings,
    Row,
    Run,
    Study,
    changed,
    column,
    plain_axes,
    steady_means,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ANGLES = (30.0, 45.0, 60.0)
"""deg."""


class WedgeAngle(Study):
    """The same cut by steeper and steeper wedges."""

    scene = "wedge_in_quartz"
    columns: ClassVar[Mapping[str, str]] = {"angle": "deg", "force_x": "N", "force_z": "N"}

    def cases(self, scene: SoilBinScene, *, quick: bool) -> list[Case]:
        """One for each angle."""
        angles = ANGLES[::2] if quick else ANGLES
        return [Case(f"{angle:g}-deg", changed(scene, implement={"angle": angle})) for angle in angles]

    def find(self, runs: Sequence[Run]) -> Findings:
        """Mean forces of the soil on the wedge."""
        rows: list[Row] = []
        for run in runs:
            means, angle = steady_means(run.recording()), run.case.scene.implement.angle
            rows.append({"angle": angle, "force_x": means["force_x"][0], "force_z": means["force_z"][0]})
        return Findings(rows, f"Draught from {rows[0]['force_x']:.2f} to {rows[-1]['force_x']:.2f} N")

    def draw(self, findings: Findings) -> "Figure":
        """Forces against the angle."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(5, 3.5), layout="constrained")
        axes = plain_axes(figure, 1, 1)[0, 0]
        for name in ("force_x", "force_z"):
            axes.plot(column(findings.rows, "angle"), column(findings.rows, name), "o-", label=name)
        axes.set_xlabel("angle of the face [deg]")
        axes.set_ylabel("force of the soil [N]")
        axes.legend(frameon=False)
        return figure


STUDY = WedgeAngle()
