import numpy as np
import pytest

from synth.rover.law.catalogue import LAW_NAMES, loose_grc1, make_law, pneumatic_stiffness
from synth.rover.law.interface import PlacedWheel, WheelStates
from synth.rover.law.response import SoilError

RADIUS = 0.355


@pytest.mark.parametrize("wheel", ["rigid", "pneumatic"])
@pytest.mark.parametrize("name", LAW_NAMES)
def test_every_law_carries_a_wheel_on_its_soil(name, wheel):
    law = make_law(name, wheel=wheel)
    law.place([PlacedWheel("front", "left", RADIUS, 0.18), PlacedWheel("rear", "left", RADIUS, 0.18)])
    x, still = np.array([1.0, 0.0]), np.zeros(2)
    for k in range(400):
        fall = 1e-4 * (k < 300)
        z = np.full(2, RADIUS - 1e-4 * min(k, 300))
        forces = law.advance(WheelStates(x, z, still, still - fall / 1e-3, still, still), 1e-3)
    assert np.all(forces.force_z > 100)
    np.testing.assert_allclose(forces.force_x, 0, atol=0.01 * forces.force_z[0])
    np.testing.assert_allclose(forces.torque, 0, atol=0.01 * forces.force_z[0] * RADIUS)
    assert law.rut("left").shape[1] == 2


def test_a_law_takes_another_soil_but_not_another_laws():
    assert make_law("rft", soil=loose_grc1()).soil == loose_grc1()
    with pytest.raises(SoilError, match="law 'bwj' needs a BekkerSoil"):
        make_law("bwj", soil=loose_grc1())


def test_unknown_names_are_refused():
    with pytest.raises(SoilError, match="law = 'magic': allowed are rft, bwj, scm"):
        make_law("magic")
    with pytest.raises(SoilError, match="wheel = 'square': allowed are rigid, pneumatic"):
        make_law("rft", wheel="square")


def test_a_pneumatic_wheel_sinks_by_its_deflection_on_a_rigid_floor():
    load, width, deflection = 687.0, 0.18, 0.02
    stiffness = pneumatic_stiffness(load=load, width=width, radius=RADIUS, deflection=deflection)
    angle = np.linspace(-0.4, 0.4, 20_001)
    given_way = np.maximum(RADIUS - (RADIUS - deflection) / np.cos(angle), 0)
    lift = np.trapezoid(stiffness * given_way * np.cos(angle), angle) * RADIUS * width
    assert lift == pytest.approx(load, rel=0.03)
