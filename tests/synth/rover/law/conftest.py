import numpy as np
import pytest

from synth.rover.law.interface import PlacedWheel, WheelStates
from synth.rover.law.rft import ResistiveForceLaw, ResistiveSoil

RADIUS, WIDTH = 0.355, 0.18


@pytest.fixture
def soil():
    return ResistiveSoil(
        scale=2e6, surface_friction=0.5, stiffness=1e7, shear_share=0.3, rut_share=0.5, damping_time=0.0
    )


@pytest.fixture
def place(soil):
    """`place()` gives the law of one wheel; `place(other_soil, count=2, rim_stiffness=1e6)`."""

    def placed(own=None, *, count=1, track=None, **options):
        law = ResistiveForceLaw(own or soil, **options)
        law.place([PlacedWheel(f"{k}", track or f"{k}", RADIUS, WIDTH) for k in range(count)])
        return law

    return placed


@pytest.fixture
def move():
    """`move(law, x, sinkage, angle)` leads one wheel along arrays (n,), a step a second; forces (n, 3)."""

    def moved(law, x, sinkage, angle):
        x, sinkage, angle = (np.asarray(one, float) for one in np.broadcast_arrays(x, sinkage, angle))
        z = RADIUS - sinkage
        steps = [np.diff(one, prepend=one[:1]) for one in (x, z, angle)]
        found = []
        for state in zip(x, z, *steps[:2], angle, steps[2], strict=True):
            forces = law.advance(WheelStates(*(np.array([one]) for one in state)), 1.0)
            found.append((forces.force_x[0], forces.force_z[0], forces.torque[0]))
        return np.array(found)

    return moved
