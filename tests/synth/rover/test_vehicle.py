import mujoco
import numpy as np
import pytest

from synth.rover.stance import side_frame
from synth.rover.vehicle import VehicleError, load_vehicle

CART = """<mujoco><worldbody><body name="cart" pos="0 0 1"><freejoint/><geom size="0.1"/>
<body name="{name}" pos="0 0.2 0"><joint axis="{axis}"/>
<geom type="{geom}" size="0.1 0.05" zaxis="0 1 0"/></body>
</body></worldbody></mujoco>"""


def cart(folder, *, name="front_wheel", axis="0 1 0", geom="cylinder"):
    path = folder / "cart.xml"
    path.write_text(CART.format(name=name, axis=axis, geom=geom))
    return path


def test_scarab_is_what_its_readme_says(scarab):
    assert scarab.weight == pytest.approx(280 * 9.81)
    assert [wheel.name for wheel in scarab.wheels if wheel.is_rear] == ["rear_left_wheel", "rear_right_wheel"]
    for wheel in scarab.wheels:
        assert (wheel.placed.radius, wheel.placed.width) == pytest.approx((0.355, 0.18))
        assert wheel.placed.track in wheel.name
        assert scarab.model.actuator(wheel.actuator).name == wheel.name
    assert scarab.model.opt.timestep == 0.001
    assert scarab.model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST


@pytest.mark.parametrize(("stance", "wheelbase", "height"), [("high", 0.8, 0.74), ("low", 1.3, 0.48)])
def test_stances_have_the_published_height_of_the_centre_of_mass(scarab, stance, wheelbase, height):
    data = mujoco.MjData(scarab.model)
    mujoco.mj_resetDataKeyframe(scarab.model, data, scarab.model.key(stance).id)
    mujoco.mj_forward(scarab.model, data)
    x, y, z = data.xpos[scarab.wheel_bodies].T
    assert np.ptp(x) == pytest.approx(wheelbase, abs=1e-4)
    assert np.ptp(y) == pytest.approx(1.4)
    assert z == pytest.approx(0.355, abs=1e-4)
    assert data.subtree_com[scarab.main_body, 2] == pytest.approx(height, abs=0.005)


def test_the_side_frame_is_read_from_the_model(scarab):
    frame = side_frame(scarab)
    assert frame.arm_length == pytest.approx(0.674)
    assert frame.wheelbase(frame.spread(1.1)) == pytest.approx(1.1)
    with pytest.raises(VehicleError, match=r"1\.5 m: this vehicle allows 0\.70 to 1\.32 m"):
        frame.require(1.5)


def test_any_model_with_named_wheels_is_a_vehicle(tmp_path):
    (wheel,) = load_vehicle(cart(tmp_path)).wheels
    assert (wheel.name, wheel.placed.track, wheel.actuator) == ("front_wheel", "left", -1)
    assert len(load_vehicle("rocker_bogie").wheels) == 6


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"name": "disc"}, "no body's name ends in '_wheel'"),
        ({"axis": "1 0 0"}, "needs one hinge about y"),
        ({"geom": "capsule"}, "needs a cylinder geom"),
    ],
)
def test_refuses_what_cannot_be_driven(tmp_path, change, told):
    with pytest.raises(VehicleError, match=told):
        load_vehicle(cart(tmp_path, **change))


def test_refuses_what_is_no_model(tmp_path):
    with pytest.raises(VehicleError, match="neither an MJCF file nor a shipped vehicle"):
        load_vehicle("lunokhod")
    broken = tmp_path / "broken.xml"
    broken.write_text("<mujoco><worldbody><body/></mujoco>")
    with pytest.raises(VehicleError, match=r"broken\.xml: not a model that MuJoCo loads"):
        load_vehicle(broken)


def test_only_a_vehicle_with_side_frames_has_a_wheelbase_to_change():
    with pytest.raises(VehicleError, match="no actuator 'left_spread'; it has front_left_wheel"):
        side_frame(load_vehicle("rocker_bogie"))
