"""URDF and STL of every robot of the library: loaded by others, and closed."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cablewright.exchange.shapes import shapes, solids
from cablewright.exchange.urdf import urdf
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.live.rest_pose import rest_pose
from cablewright.models.statics import Model
from cablewright.printing.stl import read_stl
from cablewright.robot import Beam, RigidPlatform, library_names, load

POSE = np.array([0.3, -0.2, 1.1, 0.4, -0.3, 0.7])


@pytest.mark.parametrize("name", library_names())
def test_mujoco_loads_the_urdf_with_mass_and_inertia(name: str) -> None:
    robot = load(name)
    if robot.platform.plane is not None:
        pytest.skip("MuJoCo has no planar joint")
    pose = POSE[: robot.n]
    model = mujoco.MjModel.from_xml_string(urdf(robot, pose).text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    platform = model.body("platform").id
    assert model.body_mass[platform] == pytest.approx(robot.platform.mass)
    np.testing.assert_allclose(data.xpos[platform], pose[:3], atol=1e-12)
    if isinstance(robot.platform, RigidPlatform):
        turned = data.xmat[platform].reshape(3, 3)
        np.testing.assert_allclose(turned, Rotation.from_rotvec(pose[3:]).as_matrix(), atol=1e-9)
        if robot.platform.inertia is not None:
            (xx, yy, zz), (xy, xz, yz) = robot.platform.inertia, robot.platform.inertia_products
            moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            np.testing.assert_allclose(sorted(model.body_inertia[platform]), moments, rtol=1e-9)


def test_a_platform_in_a_plane_has_a_planar_joint() -> None:
    robot = load("maslow4")
    text = urdf(robot, rest_pose(robot).equilibrium.pose).text
    assert 'type="planar"' in text
    assert '<axis xyz="0.0 -0.96' in text


def test_bars_of_the_urdf_run_from_end_to_end() -> None:
    import xml.etree.ElementTree as ET

    beam = Beam(start=(0.1, 0.2, 0.3), end=(1.0, -0.7, 0.9), radius=0.02)
    robot = load("merlet2023")
    robot = robot.model_copy(update={"scene": robot.scene.model_copy(update={"beams": (beam,)})})
    found = ET.fromstring(urdf(robot, POSE[:3]).text).find("link/visual")
    assert found is not None
    origin, cylinder = found.find("origin"), found.find("geometry/cylinder")
    assert origin is not None
    assert cylinder is not None
    middle, turns = (np.array(origin.get(key, "").split(), float) for key in ("xyz", "rpy"))
    half = 0.5 * float(cylinder.get("length", "nan")) * Rotation.from_euler("xyz", turns).as_matrix()[:, 2]
    np.testing.assert_allclose(middle - half, beam.start, atol=1e-12)
    np.testing.assert_allclose(middle + half, beam.end, atol=1e-12)


@pytest.mark.parametrize("name", library_names())
def test_solids_are_closed_and_turned_outwards(name: str, tmp_path: Path) -> None:
    robot = load(name)
    pose = rest_pose(Model.of(robot, cable="rigid")).equilibrium.pose
    parts = [TriangleMesh.of_corners(triangles) for triangles in solids(robot, pose)]
    assert len(parts) > robot.m
    assert all(part.is_closed and part.volume > 0.0 for part in parts)
    (tmp_path / "shapes.stl").write_bytes(shapes(robot, pose).stl())
    again = read_stl(tmp_path / "shapes.stl")
    assert again.volume == pytest.approx(sum(part.volume for part in parts), rel=1e-3)
