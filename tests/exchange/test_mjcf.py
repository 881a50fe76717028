"""MuJoCo models of every robot of the library: lengths at a pose, and where the platform rests on these lengths."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from cablewright.exchange.mjcf import mjcf
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot, library_names, load
from cablewright.studies.rest_pose import rest_pose


def at_rest(robot: Robot) -> Equilibrium:
    return rest_pose(Model.of(robot, cable="rigid")).equilibrium


@pytest.mark.parametrize("name", library_names())
def test_library_robots(name: str) -> None:
    """Lengths agree to 1e-8 m at the pose; dropped from 5 mm above, the platform comes back to it within 0.1 mm."""
    at = at_rest(load(name))
    model = mujoco.MjModel.from_xml_string(mjcf(at).text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.ten_length, model.tendon_range[:, 1], atol=1e-8, rtol=0)
    place, turned = data.body("platform").xpos.copy(), data.body("platform").xquat.copy()
    np.testing.assert_allclose(place, at.pose[:3], atol=1e-12)
    data.qpos[2 if model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE else model.jnt_qposadr[0]] += 0.005
    for _ in range(4000):
        data.qvel *= 0.99
        mujoco.mj_step(model, data)
    assert np.abs(data.qvel).max() < 1e-4
    np.testing.assert_allclose(data.body("platform").xpos, place, atol=1e-4, rtol=0)
    assert abs(data.body("platform").xquat @ turned) > 1 - 1e-6
