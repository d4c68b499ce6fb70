"""What is changed of rover and soil where something is assumed, and what is told of it."""

import numpy as np
import pytest

from synth.rover.drawbar import DrawbarPoint, LoadSteps
from synth.rover.law.catalogue import loose_grc1
from synth.rover.vehicle import load_vehicle
from validation.drawbar.curve import Curve, CurveOrder, orders_of
from validation.drawbar.experiment import law_of
from validation.drawbar.variation import (
    VARIATIONS,
    Variation,
    VariationError,
    find_variation,
    range_rows,
    varied_orders,
)


def centre_of_mass(vehicle):
    import mujoco

    data = mujoco.MjData(vehicle.model)
    mujoco.mj_resetDataKeyframe(vehicle.model, data, 0)
    mujoco.mj_forward(vehicle.model, data)
    return data.subtree_com[vehicle.main_body].copy()


def test_mass_and_centre_of_mass_are_changed_as_told():
    before, after = load_vehicle("scarab"), load_vehicle("scarab")
    Variation(mass=1.2, raised=0.1).on_vehicle(after)
    assert after.weight == pytest.approx(1.2 * before.weight)
    assert centre_of_mass(after) - centre_of_mass(before) == pytest.approx([0, 0, 0.1], abs=1e-6)


def test_wheelbase_speed_and_stance_are_changed_as_told():
    vehicle = load_vehicle("scarab")
    longer = VARIATIONS["wheelbase-longer"].gait("inching", vehicle, 0.06)
    spreads = [longer.command(time)[0] for time in np.linspace(0, longer.cycle, 201)]
    bases = [longer.frame.wheelbase(spread) for spread in (min(spreads), max(spreads))]
    assert bases == pytest.approx([1.05, 1.3], abs=1e-3)
    assert VARIATIONS["wheelbase-longer"].gait("rolling", vehicle, 0.06).stance == "low"
    assert VARIATIONS["half-the-speed"].gait("rolling", vehicle, 0.06).speed == 0.03
    assert VARIATIONS["as-it-is"].gait("rolling", vehicle, 0.06).speed == 0.06


def test_the_soil_is_changed_as_told():
    usual = loose_grc1()
    assert VARIATIONS["as-it-is"].soil() == usual
    assert VARIATIONS["friction-33"].soil().scale > usual.scale > VARIATIONS["friction-30"].soil().scale
    order = CurveOrder("scarab", "rolling", "rigid", "rft", variation="shear-1")
    assert law_of(order).soil.shear_share == 1.0
    assert order.name == "rolling-rigid-rft-shear-1"


def test_every_variation_can_be_carried_out():
    vehicle = load_vehicle("scarab")
    for order in varied_orders("scarab", ("rolling", "inching")):
        find_variation(order.variation).gait(order.gait, vehicle, order.speed)
        assert CurveOrder.from_dict(order.to_dict()) == order
    with pytest.raises(VariationError, match="variation 'moon': allowed are as-it-is"):
        find_variation("moon")


def test_rows_tell_pulls_and_ratios_where_they_were_reached():
    def curve(gait, pulls):
        reductions = (0.0, 0.2, 0.5)
        points = tuple(DrawbarPoint(p, 0.05, r, ()) for p, r in zip(pulls, reductions, strict=True))
        return Curve(CurveOrder("scarab", gait, "rigid", "rft", variation="shear-1"), 2700.0, points)

    (row,) = range_rows([curve("rolling", (0.0, 0.1, 0.13)), curve("inching", (0.0, 0.2, 0.26))])
    assert row["variation"] == "shear-1"
    assert (row["rolling_at_0.2"], row["inching_at_0.2"], row["ratio_at_0.2"]) == ("0.100", "0.200", "2.00")
    (alone,) = range_rows([curve("rolling", (0.0, 0.1, 0.13))])
    assert alone["inching_at_0.2"] == alone["ratio_at_0.2"] == ""


def test_grains_are_ordered_for_rigid_wheels_at_three_loads():
    orders = orders_of("scarab", gaits=("rolling", "inching"), soil="dem")
    assert [(one.gait, one.wheel, one.law, one.speed) for one in orders] == [
        ("rolling", "rigid", "dem", 0.18),
        ("inching", "rigid", "dem", 0.18),
    ]
    assert orders[0].steps == LoadSteps(loads=(0.08, 0.16, 0.24))
    with pytest.raises(ValueError, match="law = bwj: none beside --soil dem"):
        orders_of("scarab", gaits=("rolling",), laws=["bwj"], soil="dem")


def test_what_is_not_told_is_as_the_command_has_it():
    orders = orders_of("scarab", gaits=("rolling", "inching"))
    assert [(one.gait, one.wheel) for one in orders] == [
        ("rolling", "rigid"),
        ("inching", "rigid"),
        ("rolling", "pneumatic"),
        ("inching", "pneumatic"),
    ]
    assert {one.law for one in orders} == {"rft"}
    assert {one.speed for one in orders} == {0.06}
