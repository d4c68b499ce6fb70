"""Whether a result depends on how it was computed: on speed-up, box, time step, grading and seed."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from synth.scene import Bed, SoilBinScene
from validation.studies.flow_field import FlowField, Window, mean_flow
from validation.studies.study import Case, Findings, Row, Run, Study, changed, plain_axes, steady_means

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from synth.recording import Recording

BASE = "as-it-is"
_NAMES = {
    "half-speed-up": "half the speed-up",
    "doubled-box": "doubled box",
    "halved-step": "halved step",
    "other-seed": "another seed",
    "uniform-grains": "uniform grains",
}
_QUANTITIES = ("sinkage", "drawbar_pull", "torque", "flow")


class Convergence(Study):
    """A scene as it is, and with one thing of its computation changed.

    Another seed, too: what a bed packed otherwise changes is no error, and no smaller change can be told from
    it. A bed settles anew wherever its box or its time step is another. A graded bed is also compared with
    one of the finest grains throughout.
    """

    scene = "rolling_wheel"
    columns: ClassVar[Mapping[str, str]] = {
        "case": "",
        "sinkage": "mm",
        "sinkage_change": "%",
        "drawbar_pull": "N",
        "drawbar_pull_change": "%",
        "torque": "N m",
        "torque_change": "%",
        "flow_change": "%",
    }

    def cases(self, scene: SoilBinScene, *, quick: bool) -> list[Case]:
        """The scene, and its variations; they are as quick as the scene is."""
        bed, timing, contact = scene.bed, scene.timing, scene.contact
        doubled = changed(
            scene,
            bed={"width": 2 * bed.width, "depth": 2 * bed.depth, "fine": _moved(bed)},
            drive={"start": scene.drive.start + bed.width / 2},
            camera={"centre_z": scene.camera.centre_z + bed.depth},
        )
        uniform = changed(scene, bed={"coarsening": 1.0, "fine": None})
        return [
            Case(BASE, scene),
            Case("half-speed-up", changed(scene, timing={"speed_up": timing.speed_up / 2})),
            Case("doubled-box", doubled),
            Case("halved-step", changed(scene, contact={"steps_per_contact": 2 * contact.steps_per_contact})),
            Case("other-seed", changed(scene, seed=scene.seed + 1)),
            *([Case("uniform-grains", uniform)] if bed.coarsening > 1 else []),
        ]

    def find(self, runs: Sequence[Run]) -> Findings:
        """Changes relative to the scene as it is."""
        base, *others = runs
        recording = base.recording()
        view, diameter = _view(base.case.scene, recording), base.case.scene.bed.grain_diameter
        flow, means = _flow(recording, view, diameter), steady_means(recording)
        rows = [_row(base, means, means, 0.0)]
        for run in others:
            recording = run.recording()
            difference = flow_change(flow, _flow(recording, view, diameter))
            rows.append(_row(run, steady_means(recording), means, difference))
        return Findings(rows, _conclusion(rows))

    def draw(self, findings: Findings) -> "Figure":
        """Changes side by side."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8.4, 4.2), layout="constrained")
        axes = plain_axes(figure, 1, 1)[0, 0]
        colours = ("#b07d2b", "#e45756", "#4c78a8", "#54a24b")
        rows = findings.rows[1:]
        for place, (name, colour) in enumerate(zip(_QUANTITIES, colours, strict=True)):
            change = [float(row[f"{name}_change"]) for row in rows]
            at = np.arange(len(rows)) + 0.2 * (place - 1.5)
            bars = axes.bar(at, change, 0.18, color=colour, label=name.replace("_", " "))
            axes.bar_label(bars, fmt="%.2g", fontsize=8, padding=2)
        axes.axhline(0, color="black", linewidth=0.8)
        axes.set_xticks(range(len(rows)), [str(row["case"]) for row in rows])
        axes.set_ylabel("change from the scene as it is [%]")
        axes.legend(frameon=False, ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0))
        axes.margins(y=0.12)
        figure.supxlabel("flow: RMS difference of the mean velocity in view / its RMS", fontsize=8)
        return figure


STUDY = Convergence()


def _moved(bed: Bed) -> dict[str, float] | None:
    """Where the finest grains are in a box of double size: about the implement as before."""
    if bed.fine is None:
        return None
    left, right = bed.fine.left + bed.width / 2, bed.fine.right + bed.width / 2
    return {"left": left, "right": right, "bottom": bed.fine.bottom + bed.depth}


def flow_change(flow: FlowField, other: FlowField) -> float:
    """RMS difference of two velocity fields on one raster / RMS of the first, where both have soil."""
    both = np.isfinite(flow.velocity).all(axis=0) & np.isfinite(other.velocity).all(axis=0)
    apart = np.sum((flow.velocity - other.velocity)[:, both] ** 2)
    size = np.sum(flow.velocity[:, both] ** 2)
    return float(np.sqrt(apart / size)) if size > 0 else float("nan")


def _flow(recording: "Recording", view: Window, diameter: float) -> FlowField:
    return mean_flow(recording, view, spacing=diameter / 2, kernel=diameter)


def _view(scene: SoilBinScene, recording: "Recording") -> Window:
    """What the scene's camera sees half-way, as far as it is below the surface."""
    from synth.camera.view import View

    frame = recording.frame_count // 2
    left, right, bottom, top = View.of(scene, recording, frame).bounds()
    x, surface = float(recording.data["implement_x"].values[frame]), recording.data.attrs["surface_height"]
    # No deeper than the bed: a doubled one has soil there, too.
    return Window(left - x, right - x, max(bottom, 0.0) - surface, top - surface)


def _row(
    run: Run, means: dict[str, tuple[float, float]], base: dict[str, tuple[float, float]], flow: float
) -> Row:
    def change(name: str) -> float:
        before = base[name][0]
        return 100 * (means[name][0] - before) / abs(before) if before else float("nan")

    return {
        "case": _NAMES.get(run.case.label, "as it is"),
        "sinkage": 1000 * means["sinkage"][0],
        "sinkage_change": change("sinkage"),
        "drawbar_pull": means["force_x"][0],
        "drawbar_pull_change": change("force_x"),
        "torque": means["torque"][0],
        "torque_change": change("torque"),
        "flow_change": 100 * flow,
    }


def _conclusion(rows: Sequence[Row]) -> str:
    told = []
    for name in _QUANTITIES:
        changes = {str(row["case"]): float(row[f"{name}_change"]) for row in rows[1:]}
        seed = changes.pop(_NAMES["other-seed"])
        worst = max(changes, key=lambda case: abs(changes[case]))
        label = name.replace("_", " ")
        told.append(f"{label} by {changes[worst]:+.2g} % ({worst}; another seed {seed:+.2g} %)")
    return f"Changes most: {', '.join(told)}."
