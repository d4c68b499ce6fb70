"""How many grousers keep soil from being pushed ahead of the wheel, against the published equation.

Skonieczny, Moreland, Wettergreen, "A grouser spacing equation for determining appropriate geometry of
planetary rover wheels", IEEE/RSJ IROS 2012, 5065-5070 [G]: a wheel with too few grousers makes soil flow
forward ahead of it, periodically; slip, sinkage, radius, grouser height and spacing say from how many on it
does not.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from synth.drive import Rolling
from synth.implements import GrouserWheel
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

    from synth.recording import Recording

COUNTS = (8, 12, 16, 24, 32)
QUICK_COUNTS = (8, 16, 32, 48)
_QUICK_GRAINS = 4.4e-3
"""m: a grouser is then still almost three grains high."""
_PASSAGES = 2
"""Of grousers, at least, that every run sees."""
_STRIP = 2.0
"""Thickness of the strip ahead of the rim that the flux is averaged over / grain diameter."""
_PHASES = 12
"""Parts of a grouser's passage that the flux is averaged in."""
_LITTLE = 0.1
"""Forward flux below this share of that with the fewest grousers has vanished."""


class GrouserSpacing(Study):
    """The same wheel with more and more grousers.

    The forward part of the flux is taken of its mean over passages of grousers: what is periodic stays, what
    is chance goes, the more so the more grousers pass. `forward_share_error` is one standard error, by
    leaving out one passage after the other. `forward_share_of_frames` is without that mean, and alike for all
    counts: chance makes it greater than nothing even where nothing flows forward.
    """

    scene = "grouser_wheel"
    columns: ClassVar[Mapping[str, str]] = {
        "grouser_count": "1",
        "forward_flux": "mm2/s",
        "forward_share": "1",
        "forward_share_error": "1",
        "forward_share_of_frames": "1",
        "flux_swing": "mm2/s",
        "mean_flux": "mm2/s",
        "rim_sinkage": "mm",
        "predicted_count": "1",
        "drawbar_pull": "N",
        "torque": "N m",
    }

    def cases(self, scene: SoilBinScene, *, quick: bool) -> list[Case]:
        """One for each count; every run is as long as the fewest grousers take to pass twice."""
        wheel, drive = scene.implement, scene.drive
        if not isinstance(wheel, GrouserWheel) or not isinstance(drive, Rolling):
            raise ValueError(
                f"{scene.name}: implement.kind = {wheel.kind!r}: a rolling grouser wheel is needed"
            )
        counts = QUICK_COUNTS if quick else COUNTS
        passage = 2 * np.pi / min(counts) * wheel.radius / drive.rim_speed
        timing = {"frame_count": int(np.ceil(_PASSAGES * passage * scene.timing.frame_rate)) + 2}
        bed = {"grain_diameter": max(_QUICK_GRAINS, scene.bed.grain_diameter)} if quick else {}
        bed |= _bed_for(scene, timing["frame_count"])
        return [
            Case(
                f"{count}-grousers",
                changed(scene, implement={"grouser_count": count}, timing=timing, bed=bed),
            )
            for count in counts
        ]

    def find(self, runs: Sequence[Run]) -> Findings:
        """Flux ahead of the rim by parts of a grouser's passage, and what of it is forward."""
        rows, curves = [], {}
        for run in runs:
            row, curve = _row(run.case.scene, run.recording())
            rows.append(row)
            curves[f"{row['grouser_count']:.0f}"] = curve
        return Findings(rows, _conclusion(rows), curves)

    def draw(self, findings: Findings) -> "Figure":
        """Forward share against count, beside the equation's; and the flux over a grouser's passage."""
        from cmcrameri import cm
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9.6, 4.4), layout="constrained")
        left, right = plain_axes(figure, 1, 2)[0]
        rows = findings.rows
        count = column(rows, "grouser_count")
        share, error = 100 * column(rows, "forward_share"), 100 * column(rows, "forward_share_error")
        left.errorbar(
            count, share, error, marker="o", capsize=3, color="#4c78a8", label="of the mean over passages"
        )
        of_frames = 100 * column(rows, "forward_share_of_frames")
        left.plot(count, of_frames, "o:", color="#4c78a8", label="of every frame")
        left.legend(frameon=False, fontsize=8, loc="center right")
        needed = column(rows, "predicted_count")
        span = f"{needed.min():.0f}" + (f" to {needed.max():.0f}" if needed.max() > needed.min() else "")
        left.axvspan(needed.min() - 0.5, needed.max() + 0.5, color="#e45756", alpha=0.25, linewidth=0)
        left.annotate(
            f"needed by\nthe equation:\n{span}", (needed.max() + 1, 0.97), xycoords=("data", "axes fraction"),
            fontsize=8, va="top",
        )  # fmt: skip
        left.set_xlabel("number of grousers")
        left.set_ylabel("forward flux / (carriage speed x rim sinkage) [%]")
        left.set_ylim(bottom=-0.02 * of_frames.max())
        left.set_xlim(0, 1.4 * count.max())
        colours = cm.batlow(np.linspace(0, 0.85, len(findings.curves)))
        for (name, (part, flux)), colour in zip(findings.curves.items(), colours, strict=True):
            right.plot(part, flux, "o-", color=colour, label=name, linewidth=1.2, markersize=3)
        right.axhline(0, color="black", linewidth=0.8)
        right.set_xlabel("part of a grouser's passage")
        right.set_ylabel("flux of soil ahead of the rim, forward positive [mm²/s]", fontsize=9)
        right.legend(
            title="grousers",
            frameon=False,
            fontsize=8,
            ncols=len(findings.curves),
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0),
        )
        return figure


STUDY = GrouserSpacing()


def _bed_for(scene: SoilBinScene, frame_count: int) -> dict[str, Any]:
    """The bed, its finest grains too, longer by as much as the wheel goes farther in so many frames."""
    then, now = (
        scene.program.travel((n - 1) / scene.timing.frame_rate)
        for n in (frame_count, scene.timing.frame_count)
    )
    farther, fine = max(0.0, then - now), scene.bed.fine
    longer: dict[str, Any] = {"width": scene.bed.width + farther}
    if fine is not None:
        longer["fine"] = {**fine.model_dump(), "right": fine.right + farther}
    return longer


def largest_spacing(*, slip: float, sinkage: float, height: float) -> float:
    """Largest angle between grousers without soil flowing forward, rad [G].

    The rim meets the surface at ``sqrt(1 - (1 - z)^2)`` ahead of the axle, a grouser's tip enters at
    ``sqrt((1 + h)^2 - (1 - z)^2)``. The wheel travels ``(1 - i) phi`` from one grouser's entry to the next's:
    no further than those two points are apart, and the next grouser is in the soil before the rim gets to
    push it forward.

    Parameters
    ----------
    slip : float
        i.
    sinkage : float
        z, of the rim / wheel radius.
    height : float
        h, of the grousers above the rim / wheel radius.
    """
    depth = 1 - (1 - sinkage) ** 2
    return (np.sqrt((1 + height) ** 2 - (1 - sinkage) ** 2) - np.sqrt(depth)) / (1 - slip)


def least_count(spacing: float) -> int:
    """Fewest grousers that are no further apart than `spacing`, rad."""
    return int(np.ceil(2 * np.pi / spacing - 1e-9))


def flux_ahead(recording: "Recording", *, radius: float, sinkage: float, strip: float) -> np.ndarray:
    """Area of soil that moves forward through a line just ahead of the rim in a second, m2/s, (frames - 1,).

    The line stands where the rim meets the levelled surface and reaches from the height of the rim's lowest
    point upwards: below the surface all of it is ahead of the rim. Grains in a strip ahead of it count, with
    the voids between them; their velocity is in the bin's frame.

    Parameters
    ----------
    radius, sinkage : float
        Of the rim, m.
    strip : float
        Thickness of the strip, m.
    """
    data = recording.data
    entry = np.sqrt(radius**2 - (radius - sinkage) ** 2)
    area = np.pi * data["radius"].values ** 2 / float(data.attrs["solid_fraction"])
    x, z = data["position_x"].values, data["position_z"].values
    axle_x, axle_z = data["implement_x"].values, data["implement_z"].values
    interval = np.diff(data["time"].values)
    flux = np.zeros(interval.size)
    for frame in range(interval.size):
        off_x = (x[frame] + x[frame + 1] - axle_x[frame] - axle_x[frame + 1]) / 2 - entry
        off_z = (z[frame] + z[frame + 1] - axle_z[frame] - axle_z[frame + 1]) / 2 + radius
        counted = (off_x > 0) & (off_x < strip) & (off_z > 0)
        moved = x[frame + 1][counted] - x[frame][counted]
        flux[frame] = np.sum(area[counted] * moved) / interval[frame] / strip
    return flux


def by_phase(flux: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Mean flux in each part of a grouser's passage, over whole passages; NaN where no frame fell in one.

    Parameters
    ----------
    flux : ndarray, shape (n,)
    turns : ndarray, shape (n,)
        Passages since the first frame, ascending.
    """
    whole = turns < max(1.0, _whole_passages(turns))
    return _phase_means(flux[whole], turns[whole])


def _whole_passages(turns: np.ndarray) -> int:
    return int(np.floor(turns[-1] + 1e-9))


def _phase_means(flux: np.ndarray, turns: np.ndarray) -> np.ndarray:
    part = (np.mod(turns, 1.0) * _PHASES).astype(int)
    count = np.bincount(part, minlength=_PHASES)
    with np.errstate(invalid="ignore"):
        return np.bincount(part, flux, _PHASES) / np.where(count > 0, count, np.nan)


def forward_error(flux: np.ndarray, turns: np.ndarray) -> float:
    """Standard error of the mean forward flux of `by_phase`, by the jackknife over passages; NaN for one."""
    count, passage = _whole_passages(turns), np.floor(turns).astype(int)
    if count < _PASSAGES:
        return float("nan")
    left_out = []
    for one in range(count):
        kept = (passage < count) & (passage != one)
        left_out.append(_forward(_phase_means(flux[kept], turns[kept])))
    return float(np.sqrt((count - 1) * np.var(left_out)))


def _forward(phases: np.ndarray) -> float:
    return float(np.nanmean(np.maximum(phases, 0)))


def _row(scene: SoilBinScene, recording: "Recording") -> tuple[Row, np.ndarray]:
    wheel, drive = scene.implement, scene.drive
    assert isinstance(wheel, GrouserWheel) and isinstance(drive, Rolling)
    data, means = recording.data, steady_means(recording)
    sinkage = float(data.attrs["surface_height"] + wheel.radius - data["implement_z"].values.mean())
    sinkage = min(max(sinkage, 0.0), wheel.radius)
    strip = _STRIP * scene.bed.grain_diameter
    flux = flux_ahead(recording, radius=wheel.radius, sinkage=sinkage, strip=strip)
    angle = data["implement_angle"].values
    turned = np.abs((angle[1:] + angle[:-1]) / 2 - angle[0])
    turns = turned * wheel.grouser_count / (2 * np.pi)
    phases = by_phase(flux, turns)
    forward = _forward(phases)
    spacing = largest_spacing(
        slip=drive.slip, sinkage=sinkage / wheel.radius, height=wheel.grouser_height / wheel.radius
    )
    displaced = drive.carriage_speed * sinkage if sinkage > 0 else float("nan")
    row: Row = {
        "grouser_count": float(wheel.grouser_count),
        "forward_flux": 1e6 * forward,
        "forward_share": forward / displaced,
        "forward_share_error": forward_error(flux, turns) / displaced,
        "forward_share_of_frames": float(np.maximum(flux, 0).mean()) / displaced,
        "flux_swing": 1e6 * float(np.nanmax(phases) - np.nanmin(phases)),
        "mean_flux": 1e6 * float(np.nanmean(phases)),
        "rim_sinkage": 1000 * sinkage,
        "predicted_count": float(least_count(spacing)),
        "drawbar_pull": means["force_x"][0],
        "torque": means["torque"][0],
    }
    return row, np.stack([(np.arange(_PHASES) + 0.5) / _PHASES, 1e6 * phases])


def _conclusion(rows: Sequence[Row]) -> str:
    ordered = sorted(rows, key=lambda row: float(row["grouser_count"]))
    most = float(ordered[0]["forward_share"])
    shares = ", ".join(f"{100 * float(r['forward_share']):.2g} % ({r['grouser_count']:.0f})" for r in ordered)
    gone = [r for r in ordered if float(r["forward_share"]) <= _LITTLE * most]
    where = (
        f"it is below a tenth of that with the fewest from {gone[0]['grouser_count']:.0f} on"
        if gone
        else "it falls below a tenth of that with the fewest at none of these"
    )
    needed = column(ordered, "predicted_count")
    mean = column(ordered, "mean_flux")
    turns = [row["grouser_count"] for row, flux in zip(ordered, mean, strict=True) if flux <= 0]
    backward = f"mean flux is backward from {turns[0]:.0f} on" if turns else "mean flux is forward throughout"
    return (
        f"Forward flux / (speed x sinkage) by number of grousers: {shares}; {where}; {backward}; "
        f"the grouser spacing equation needs {needed.min():.0f} to {needed.max():.0f} "
        "at the slip and sinkages of these runs."
    )
