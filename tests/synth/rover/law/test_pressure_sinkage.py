from dataclasses import replace

import numpy as np
import pytest

from synth.rover.law.interface import PlacedWheel
from synth.rover.law.pressure_sinkage import BekkerLaw, BekkerSoil, ColumnLaw
from synth.rover.law.response import SoilError
from synth.rover.law.single_wheel import Paths, lead

RADIUS, WIDTH, LOAD = 0.355, 0.18, 700.0
SOIL = BekkerSoil(modulus=1.2e6, exponent=1.0, friction=0.6, shear_modulus=0.015, stiffness=5e7)


def rolled(law, slip, *, load=LOAD):
    law.place([PlacedWheel("", "", RADIUS, WIDTH)])
    path = Paths.at_slip(
        np.array([slip]), np.array([load]), np.array([RADIUS]), travel=np.array([0.5]), step_count=4000
    )
    mean = lead(law, law._wheels, path).mean(0.2)
    return mean.sinkage[0], np.array([mean.force_x[0], mean.force_z[0], mean.torque[0]])


def closed_form(soil, slip, sinkage):
    """Bekker's pressure over the leading rim, Janosi's shear with Wong's displacement, by quadrature."""
    entry = np.arccos(1 - sinkage / RADIUS)
    edge = np.linspace(0, entry, 20_001)
    angle = (edge[1:] + edge[:-1]) / 2
    pressure = soil.modulus * (RADIUS * (np.cos(angle) - np.cos(entry))) ** soil.exponent
    sheared = RADIUS * ((entry - angle) - (1 - slip) * (np.sin(entry) - np.sin(angle)))
    shear = soil.friction * pressure * (1 - np.exp(-sheared / soil.shear_modulus))
    area = WIDTH * RADIUS * np.diff(edge)
    force_x = (shear * np.cos(angle) - pressure * np.sin(angle)) * area
    force_z = (shear * np.sin(angle) + pressure * np.cos(angle)) * area
    return np.array([force_x.sum(), force_z.sum(), -(RADIUS * shear * area).sum()])


@pytest.mark.parametrize("slip", [0.1, 0.3, 0.6])
def test_a_rolling_wheel_is_bekkers_integral_with_janosis_shear(slip):
    sinkage, found = rolled(BekkerLaw(SOIL, element_count=256), slip)
    expected = closed_form(SOIL, slip, sinkage)
    np.testing.assert_allclose(found[1], expected[1], rtol=0.02)
    assert np.all(np.abs(found - expected) < 0.03 * LOAD * np.array([1, 1, RADIUS]))


def test_a_towed_wheel_without_friction_sinks_as_bekker_says():
    slippery = replace(SOIL, friction=1e-6)
    sinkage, (pull, _, _) = rolled(BekkerLaw(slippery, element_count=256), 0.0)
    # Bekker 1956, for n = 1: z = (3 W / (2 b k sqrt(D)))^(2/3) and resistance b k z^2 / 2.
    expected = (3 * LOAD / (2 * WIDTH * SOIL.modulus * np.sqrt(2 * RADIUS))) ** (2 / 3)
    assert sinkage == pytest.approx(expected, rel=0.03)
    assert pull == pytest.approx(-WIDTH * SOIL.modulus * sinkage**2 / 2, rel=0.05)


def test_columns_take_pressure_vertically():
    """Pressure alone neither holds a wheel back nor turns it: what the axle pays it pays as torque."""
    slippery = replace(SOIL, friction=1e-6)
    _, (pull, lift, _) = rolled(ColumnLaw(slippery, element_count=256), 0.0)
    assert abs(pull) < 1e-3 * LOAD
    assert lift == pytest.approx(LOAD, rel=0.01)


def test_pull_grows_with_slip_and_reverses_with_skid():
    pulls = [rolled(BekkerLaw(SOIL), slip)[1][0] for slip in (-0.5, -0.1, 0.1, 0.5)]
    assert pulls == sorted(pulls)
    assert pulls[0] < 0 < pulls[-1]


def test_refuses_constants_that_cannot_be():
    with pytest.raises(SoilError, match=r"exponent = -1: above 0 is allowed"):
        replace(SOIL, exponent=-1)
