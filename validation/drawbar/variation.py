"""What of rover and soil is assumed, and its range: curves are measured over it at a few loads."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from synth.rover.drawbar import LoadSteps
from validation.drawbar.curve import Curve, CurveOrder

if TYPE_CHECKING:
    from rich.table import Table

    from synth.rover.gaits import Inching, Rolling
    from synth.rover.law.rft import ResistiveSoil
    from synth.rover.vehicle import Vehicle

RANGE_LOADS = (0.1, 0.16, 0.22)
"""Drawbar pulls over weight."""
RANGE_REDUCTIONS = (0.1, 0.2, 0.4)
"""Travel reductions at which gaits are compared."""


class VariationError(ValueError):
    """A name that is none of a variation's."""


@dataclass(frozen=True)
class Variation:
    """What is changed.

    Attributes
    ----------
    mass : float
        Of all parts / the model's.
    raised : float
        Centre of mass of the vehicle, upwards, m.
    shortest, longest : float
        Wheelbase when inching, m.
    stance : str or None
        Keyframe when rolling.
    speed : float or None
        Of the rim, m/s; None: the order's.
    friction_angle : float or None
        deg, from which the scale of the soil's traction follows; None: the soil's own.
    shear_share, surface_friction, rut_share : float or None
        Of `ResistiveSoil`; None: the soil's own.
    """

    mass: float = 1.0
    raised: float = 0.0
    shortest: float = 0.8
    longest: float = 1.3
    stance: str | None = None
    speed: float | None = None
    friction_angle: float | None = None
    shear_share: float | None = None
    surface_friction: float | None = None
    rut_share: float | None = None

    def on_vehicle(self, vehicle: "Vehicle") -> None:
        """Change a model that was just loaded."""
        import mujoco

        model = vehicle.model
        model.body_mass[:] *= self.mass
        model.body_inertia[:] *= self.mass
        body = vehicle.main_body
        model.body_ipos[body, 2] += self.raised * model.body_mass.sum() / model.body_mass[body]
        model.body_sameframe[body] = 0  # else MuJoCo takes the body's own place for its centre of mass
        mujoco.mj_setConst(model, mujoco.MjData(model))

    def gait(self, name: str, vehicle: "Vehicle", speed: float) -> "Rolling | Inching":
        """The gait, its wheelbase and speed changed."""
        from synth.rover.gaits import Inching, Rolling

        speed = self.speed or speed
        if name == "rolling":
            return Rolling(vehicle, speed=speed, stance=self.stance)
        return Inching(vehicle, speed=speed, shortest=self.shortest, longest=self.longest)

    def soil(self) -> "ResistiveSoil":
        """Loose GRC-1, changed."""
        from synth.rover.law.catalogue import loose_grc1

        soil = loose_grc1() if self.friction_angle is None else loose_grc1(friction_angle=self.friction_angle)
        told = {name: getattr(self, name) for name in ("shear_share", "surface_friction", "rut_share")}
        return replace(soil, **{name: value for name, value in told.items() if value is not None})


VARIATIONS = {
    "as-it-is": Variation(),
    "mass-less-20": Variation(mass=0.8),
    "mass-more-20": Variation(mass=1.2),
    "centre-lower-0.1": Variation(raised=-0.1),
    "centre-higher-0.1": Variation(raised=0.1),
    "wheelbase-shorter": Variation(shortest=0.8, longest=1.05, stance="high"),
    "wheelbase-longer": Variation(shortest=1.05, longest=1.3, stance="low"),
    "friction-30": Variation(friction_angle=30.0),
    "friction-33": Variation(friction_angle=33.0),
    "shear-0.06": Variation(shear_share=0.06),
    "shear-1": Variation(shear_share=1.0),
    "half-the-speed": Variation(speed=0.03),
    "rut-0": Variation(rut_share=0.0),
    "rut-1": Variation(rut_share=1.0),
}
"""By name; the first changes nothing."""


def find_variation(name: str) -> Variation:
    """A variation by its name.

    Raises
    ------
    VariationError
        There is none.
    """
    if name not in VARIATIONS:
        raise VariationError(f"variation {name!r}: allowed are {', '.join(VARIATIONS)}")
    return VARIATIONS[name]


def varied_orders(vehicle: str, gaits: Sequence[str]) -> list[CurveOrder]:
    """Every variation in every gait, on rigid wheels."""
    return [
        CurveOrder(vehicle, gait, "rigid", "rft", LoadSteps(loads=RANGE_LOADS), variation=name)
        for name in VARIATIONS
        for gait in gaits
    ]


def range_rows(curves: Sequence[Curve]) -> list[dict[str, str]]:
    """One for each variation: what both gaits pull over weight at travel reductions, and their ratio."""
    known = {(curve.order.variation, curve.order.gait): curve for curve in curves}
    rows = []
    for name in dict.fromkeys(curve.order.variation for curve in curves):
        row = {"variation": name}
        for reduction in RANGE_REDUCTIONS:
            pulls = {
                gait: known[name, gait].pull_at(reduction) if (name, gait) in known else None
                for gait in ("rolling", "inching")
            }
            for gait, pull in pulls.items():
                row[f"{gait}_at_{reduction:g}"] = "" if pull is None else f"{pull:.3f}"
            both = pulls["rolling"] and pulls["inching"]
            row[f"ratio_at_{reduction:g}"] = f"{pulls['inching'] / pulls['rolling']:.2f}" if both else ""  # type: ignore[operator]
        rows.append(row)
    return rows


def range_table(curves: Sequence[Curve]) -> "Table":
    """`range_rows` for the terminal."""
    from rich.table import Table

    rows = range_rows(curves)
    table = Table(title="Drawbar pull / vehicle weight over what is assumed, rigid wheels, rft")
    for name in rows[0]:
        table.add_column(name.replace("_", " "), justify="left" if name == "variation" else "right")
    for row in rows:
        table.add_row(*(value or "-" for value in row.values()))
    return table
