"""A solid of any outline is drawn filled, where it is, and as it is turned."""

import numpy as np
import pytest

from synth.camera.implement_face import face_of
from synth.camera.view import View
from synth.scene import parse_scene

CORNERS = [[0.0, 0.0], [0.004, 0.0], [0.004, 0.002], [0.001, 0.002], [0.001, 0.006], [0.0, 0.006]]
"""An L of a base 4 mm x 2 mm and an upright 1 mm wide up to 6 mm; its reference point is its heel."""


@pytest.fixture
def scene(cases):
    tables = cases.scene().to_dict()
    tables["implement"] = {"kind": "outline", "width": 0.05, "points": CORNERS}
    tables["drive"] = {"kind": "cutting", "speed": 0.01, "depth": 0.01, "start": 0.1, "run_in": 0.05}
    return parse_scene(tables)


@pytest.mark.parametrize(("turn", "sense"), [(0.0, 0), (np.pi / 2, 1)])
def test_a_solid_is_filled_up_to_its_edges(taichi, cases, scene, turn, sense):
    case = cases.case(lambda x, z, frame: (x, z), implement=cases.centre, turn=turn)
    view = View(80, 60, 2e-4, *cases.centre)
    distance = face_of(scene, case.recording, 0, view).distance()
    y, x = np.mgrid[:60, :80]
    world_x, world_z = view.to_world(x, y)
    off_x, off_z = world_x - cases.centre[0], world_z - cases.centre[1]
    if sense:  # a quarter turn counter-clockwise: what was up is left
        off_x, off_z = off_z, -off_x
    base = (off_x > 0) & (off_x < 0.004) & (off_z > 0) & (off_z < 0.002)
    upright = (off_x > 0) & (off_x < 0.001) & (off_z > 0) & (off_z < 0.006)
    np.testing.assert_array_equal(distance == 0, base | upright)
    corner = np.hypot(off_x - 0.004, off_z)[(off_x > 0.004) & (off_z < 0)]
    np.testing.assert_allclose(distance[(off_x > 0.004) & (off_z < 0)], corner / 2e-4, rtol=1e-5)
