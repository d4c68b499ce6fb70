"""When a simulation has gone wrong, and the one line that says which grain, when, and what to change."""

from typing import TYPE_CHECKING

import numpy as np

from synth.scene import SoilBinScene

if TYPE_CHECKING:
    from synth.dem.grains import Grains
    from synth.dem.solver import Solver
    from synth.dem.tool import Tool
    from synth.recording import Recording

LARGEST_OVERLAP = 0.2
"""Overlap / mean diameter at which grains no longer stand for grains: twenty times what soundness allows."""
_LEAP = 0.5
"""Share of its own reach by which an implement may rise above where it started: higher, it was thrown."""


class SimulationError(RuntimeError):
    """The simulation cannot go on.

    Parameters
    ----------
    what : str
        Which grain, where.
    advice : str
        What to change.
    when : str
        Begins the message.

    Attributes
    ----------
    recording : Recording or None
        What was recorded until then.
    """

    def __init__(self, what: str, advice: str, when: str = "") -> None:
        super().__init__(f"{when}{what}: {advice}")
        self.what, self.advice = what, advice
        self.recording: Recording | None = None

    def at(self, when: str) -> "SimulationError":
        """The same, saying when it happened."""
        return SimulationError(self.what, self.advice, f"{when}: ")

    def saying(self, more: str) -> "SimulationError":
        """The same, with more to say at the end."""
        error = SimulationError(self.what, self.advice)
        error.args = (f"{self}; {more}",)
        error.recording = self.recording
        return error


def check(solver: "Solver", scene: SoilBinScene, start: "Tool") -> float:
    """Stop where the state makes no sense any more.

    Parameters
    ----------
    start : Tool
        The implement as it touched down.

    Returns
    -------
    float
        The greatest overlap of two grains / their mean diameter.

    Raises
    ------
    SimulationError
        A grain is no longer a number, has left the bin or lies in another one; or the implement does.
    """
    grains = solver.read_grains()
    check_numbers(grains)
    check_bin(grains, scene, start)
    tool = solver.read_tool()
    check_implement(tool, scene, start)
    check_inside(grains, tool, scene)
    pairs, overlap = solver.contacts()
    overlap = overlap / grains.radius[pairs].sum(axis=0)
    check_overlaps(grains, pairs, overlap, scene)
    return float(overlap.max(initial=0.0))


def check_numbers(grains: "Grains") -> None:
    """Stop where a grain's motion is not a number."""
    finite = np.isfinite(np.concatenate([grains.position, grains.velocity, np.atleast_2d(grains.spin)])).all(
        axis=0
    )
    if not finite.all():
        lost = int(np.argmin(finite))
        raise SimulationError(
            f"{_grain(grains, lost)} is no longer a number",
            "take contact.steps_per_contact higher, or timing.speed_up lower",
        )


def check_bin(grains: "Grains", scene: SoilBinScene, start: "Tool") -> None:
    """Stop where a grain's centre is outside the bin."""
    x, z = grains.in_plane
    ceiling = scene.bed.depth + max(scene.bed.depth, 2 * start.shape.reach)
    stiffer = f"take {_stiffness(scene)}"
    across = grains.position[1] if scene.bed.thickness else np.zeros(grains.count)
    for outside, how, advice in (
        (z < 0, "has gone through the floor", stiffer),
        (x < 0, "has gone through the left end wall", stiffer),
        (x > scene.bed.width, "has gone through the right end wall", stiffer),
        (across < 0, "has gone through the glass", stiffer),
        (across > scene.bed.thickness, "has gone through the slab's far face", stiffer),
        (z > ceiling, "was thrown out of the bin", "take timing.speed_up or the drive's speed lower"),
    ):
        if outside.any():
            raise SimulationError(f"{_grain(grains, int(np.argmax(outside)))} {how}", advice)


def check_overlaps(grains: "Grains", pairs: np.ndarray, overlap: np.ndarray, scene: SoilBinScene) -> None:
    """Stop where two grains lie in each other; `overlap` is that of `pairs` / their mean diameter."""
    if overlap.size == 0 or overlap.max() <= LARGEST_OVERLAP:
        return
    worst = int(overlap.argmax())
    i, j = pairs[:, worst]
    raise SimulationError(
        f"{_grain(grains, i)} and grain {j} overlap by {100 * overlap[worst]:.0f} % of a diameter",
        f"take {_stiffness(scene)}, or timing.speed_up or the load lower",
    )


def check_implement(tool: "Tool", scene: SoilBinScene, start: "Tool") -> None:
    """Stop where the implement has flown up, sunk to the floor, or travelled into an end wall."""
    bed, reach = scene.bed, tool.shape.reach
    where = f"the implement at x = {tool.x:.4g} m, z = {tool.z:.4g} m"
    rim = 0.0 if tool.nodes is None else float(np.abs(tool.nodes).max())
    if not np.isfinite([tool.x, tool.z, tool.angle, tool.velocity_z, rim]).all():
        raise SimulationError(f"{where} is no longer a number", "take contact.steps_per_contact higher")
    if tool.lowest < bed.grain_diameter:
        raise SimulationError(
            f"{where} has sunk to the floor",
            f"take bed.depth (now {bed.depth:g} m) higher, or its load or depth lower",
        )
    if tool.heaves and tool.lowest > start.lowest + _LEAP * reach:
        raise SimulationError(
            f"{where} has shot up by {1000 * (tool.lowest - start.lowest):.0f} mm",
            "take timing.speed_up lower, implement.moving_mass higher, or drive.run_in longer",
        )
    if not -bed.grain_diameter <= tool.x - reach <= tool.x + reach <= bed.width + bed.grain_diameter:
        raise SimulationError(
            f"{where} has run into an end wall",
            f"take bed.width (now {bed.width:g} m) higher, or the travel shorter",
        )


def check_inside(grains: "Grains", tool: "Tool", scene: SoilBinScene) -> None:
    """Stop where a grain's centre is inside a solid implement, whose edges would then draw it further in."""
    if not tool.shape.closed.any():
        return
    offset = grains.in_plane.T - (tool.x, tool.z)
    section = tool.section
    near = np.flatnonzero(np.hypot(*offset.T) < section.reach)
    inside = near[section.encloses(offset[near])]
    if inside.size:
        raise SimulationError(
            f"{_grain(grains, int(inside[0]))} is inside the implement",
            f"take {_stiffness(scene)}, or timing.speed_up lower",
        )


def _stiffness(scene: SoilBinScene) -> str:
    """What to take higher for stiffer contacts."""
    contact = scene.contact
    if contact.law == "hertz_mindlin":
        return f"contact.young_modulus higher (now {contact.young_modulus:g} Pa)"
    return f"contact.normal_stiffness higher (now {contact.normal_stiffness:g} N/m per m)"


def _grain(grains: "Grains", index: int) -> str:
    x, z = grains.in_plane[:, index]
    return f"grain {index} at x = {x:.4g} m, z = {z:.4g} m"
