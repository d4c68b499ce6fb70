"""A compliant wheel: an elastic rim that flattens under its load."""

from dataclasses import replace
from functools import lru_cache
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from synth.implements.rigid_wheel import RigidWheel
from synth.implements.ring import Ring, stiffened
from synth.implements.shape import Shape


class CompliantWheel(RigidWheel):
    """A smooth wheel with an elastic rim, half the width and half the load of the wheel it stands for.

    The rim is a ring on an elastic foundation (`synth.implements.ring`). The foundation is as stiff as makes
    the axle sink by `deflection` under `normal_load` on a rigid flat floor without friction;
    `bending_stiffness` and `hoop_stiffness` are the rim's own. The rim's weight is part of the load.

    `radius` is the outer one while nothing acts: that of rim speed and slip.
    """

    kind: Literal["compliant_wheel"]  # type: ignore[assignment]
    deflection: float = Field(gt=0, description="m, fall of the axle under normal_load on a rigid flat floor")
    node_count: int = Field(ge=24, le=1000, description="points of the rim that move")
    rim_thickness: float = Field(gt=0, le=0.05, description="m")
    rim_mass: float = Field(gt=0, description="kg, of the half-width rim")
    bending_stiffness: float = Field(gt=0, description="N m per m of width and of curvature, of the rim")
    hoop_stiffness: float = Field(gt=0, description="N per m of width and of strain, of the rim")
    tangential_stiffness_ratio: float = Field(gt=0, le=10, description="foundation, tangential / radial")
    damping_ratio: float = Field(
        ge=0, le=1, description="of the rim as a whole on its foundation / critical damping"
    )

    @model_validator(mode="after")
    def _flattens(self) -> Self:
        if not self.rim_thickness < 0.5 * self.radius:
            raise ValueError(
                f"rim_thickness = {self.rim_thickness} m: below half of radius = {self.radius} m is allowed"
            )
        if not self.deflection < 0.5 * self.radius:
            raise ValueError(
                f"deflection = {self.deflection} m: below half of radius = {self.radius} m is allowed"
            )
        return self

    @property
    def shape(self) -> Shape:
        """The rim while nothing acts."""
        half = self.rim_thickness / 2
        angle = 2 * np.pi * np.arange(self.node_count) / self.node_count
        return rim_shape((self.radius - half) * np.stack([np.cos(angle), np.sin(angle)], axis=1), half)

    @property
    def ring(self) -> Ring:
        """Constants of the rim.

        Raises
        ------
        RingError
            The rim itself is too stiff for the deflection asked for.
        """
        return _ring_of(self.model_dump_json())

    def check_time_step(self, step: float, *, contact_stiffness: float, grain_diameter: float) -> None:
        """Refuse a time step (s) of the grains that the rim cannot keep up with.

        Parameters
        ----------
        contact_stiffness : float
            N/m per metre of width.
        grain_diameter : float
            Of the smallest grain, m: a node is touched by those along both its bars.

        Raises
        ------
        ValueError
            With what to change.
        """
        ring = self.ring
        most_contacts = 1 + 2 * ring.bar_length / grain_diameter
        largest = ring.largest_time_step(most_contacts * contact_stiffness)
        if step > largest:
            raise ValueError(
                f"implement.rim_mass = {self.rim_mass} kg: the rim needs steps of at most {largest:.2g} s, "
                f"the grains take {step:.2g} s: take rim_mass or contact.steps_per_contact "
                "higher, or node_count, hoop_stiffness or bending_stiffness lower"
            )


def rim_shape(nodes: np.ndarray, half_thickness: float) -> Shape:
    """A closed ring of capsules through nodes (N, 2), m, and all that is within."""
    count = len(nodes)
    whole = np.ones(count, bool)
    return Shape(nodes, np.roll(nodes, -1, axis=0), np.full(count, half_thickness), whole, whole.copy())


@lru_cache(maxsize=16)
def _ring_of(tables: str) -> Ring:
    """Solved once for each wheel, given as JSON."""
    wheel = CompliantWheel.model_validate_json(tables)
    node_radius, count = wheel.radius - wheel.rim_thickness / 2, wheel.node_count
    bar = 2 * node_radius * float(np.sin(np.pi / count))
    mass = wheel.rim_mass / wheel.width / count
    loose = Ring(
        node_count=count,
        node_radius=node_radius,
        half_thickness=wheel.rim_thickness / 2,
        node_mass=mass,
        radial_stiffness=1.0,
        tangential_stiffness=wheel.tangential_stiffness_ratio,
        damping=0.0,
        hoop_stiffness=wheel.hoop_stiffness / bar,
        bending_stiffness=wheel.bending_stiffness / bar,
    )
    solved = stiffened(loose, wheel.deflection, wheel.normal_load / wheel.width)
    return replace(solved, damping=2 * wheel.damping_ratio * float(np.sqrt(solved.radial_stiffness * mass)))
