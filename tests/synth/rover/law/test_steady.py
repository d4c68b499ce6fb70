from dataclasses import astuple, replace

import numpy as np
import pytest

from synth.rover.law import rft
from synth.rover.law.response import SoilError
from synth.rover.law.steady import steady_forces

SIZE = {"radius": 0.355, "width": 0.18}


@pytest.mark.parametrize("slip", [0.4, -0.3, -1.0])
def test_a_wheel_led_through_stiff_soil_comes_to_it(soil, place, move, slip, monkeypatch):
    monkeypatch.setattr(rft, "_LEASH", 1e-4)  # no memory of the direction
    stiff = replace(soil, stiffness=1e9, shear_share=1.0)
    rim = 1 / (1 - slip) if slip >= 0 else 1 + slip
    x = np.concatenate([np.zeros(150), np.arange(0, 0.5, 2e-4)])
    sinkage = np.minimum(np.arange(x.size) * 2e-4, 0.03)
    found = move(place(stiff, element_count=400), x, sinkage, x * rim / SIZE["radius"])[-500:].mean(axis=0)
    expected = np.array(astuple(steady_forces(stiff, slip=slip, sinkage=0.03, **SIZE)))
    np.testing.assert_allclose(found, expected, rtol=0.05, atol=0.01 * expected[1])


def test_forces_grow_with_the_cube_of_lengths(soil):
    small = astuple(steady_forces(soil, slip=0.2, sinkage=0.01, radius=0.1, width=0.05))
    large = astuple(steady_forces(soil, slip=0.2, sinkage=0.03, radius=0.3, width=0.15))
    np.testing.assert_allclose(large, np.array(small) * [27, 27, 81])


@pytest.mark.parametrize(
    ("changed", "told"),
    [({"slip": 1.0}, "slip = 1.0: -1 to"), ({"sinkage": 0.4}, "sinkage = 0.4 m: above 0")],
)
def test_refuses_what_is_out_of_range(soil, changed, told):
    with pytest.raises(SoilError, match=told):
        steady_forces(soil, **({"slip": 0.2, "sinkage": 0.03} | SIZE | changed))
