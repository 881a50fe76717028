"""CASPR models: bodies and cables, what is carried and what is rejected."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import cablewright as cw
from cablewright.exchange.caspr import read_caspr
from cablewright.exchange.robot_toml import robot_toml
from cablewright.exchange.translation_result import ImportedRobot
from cablewright.foundation.errors import InputError
from cablewright.robot import loads
from exchange import samples
from exchange.samples import BODIES, caspr_cable, caspr_cables


def read(
    folder: Path, bodies: str = BODIES, cables: str | None = None, name: str = "cables", **options: str
) -> ImportedRobot:
    one, other = folder / "own_bodies.xml", folder / "own_cables.xml"
    one.write_text(bodies)
    other.write_text(caspr_cables() if cables is None else cables)
    return read_caspr([one] if name == "bodies" else [other], **options)


@pytest.mark.parametrize("name", ["bodies", "cables"])
def test_all_features_are_carried(name: str, tmp_path: Path) -> None:
    robot = read(tmp_path, name=name).robot
    assert (robot.name, robot.n, robot.m) == ("own body", 6, 8)
    assert [line.exit_point for line in robot.lines] == samples.EXITS
    assert [line.platform_point for line in robot.lines] == samples.ENDS
    assert [line.name for line in robot.lines] == [f"cable {k}" for k in range(8)]
    assert {line.tension_limits for line in robot.lines} == {(5.0, 800.0)}
    assert {line.sheave.kind for line in robot.lines} == {"eyelet"}
    platform = robot.platform
    assert (platform.mass, platform.centre_of_mass) == (12.5, (0.0, 0.02, 0.1))
    assert platform.nozzle == (0.0, 0.0, -0.3)
    assert (platform.inertia, platform.inertia_products) == ((1.5, 1.6, 1.7), (0.1, 0.0, 0.0))


NORMALS = {"XY": (0.0, 0.0, 1.0), "XZ": (0.0, 1.0, 0.0), "YZ": (1.0, 0.0, 0.0)}


@pytest.mark.parametrize("axes", NORMALS)
@pytest.mark.parametrize("body", [False, True])
def test_planar_joints(axes: str, body: bool, tmp_path: Path) -> None:
    """The plane is through the joint; lengths at a pose in it are distances; the joint's limits are the frame."""
    normal = np.array(NORMALS[axes])
    along = np.eye(3)[normal == 0.0]
    kind = f"{'PLANAR' if body else 'P'}_{axes}"
    joint = f'<joint type="{kind}" q_min="-0.5 0.1{" -3" if body else ""}" q_max="0.5 0.9{" 3" if body else ""}"/>'
    text = BODIES.replace('<joint type="SPATIAL_EULER_XYZ"/>', joint)
    place = 0.25 * normal
    text = text.replace("<location>0.0 0.0 0.0", f"<location>{' '.join(map(str, place))}")
    if not body:
        text = text.replace("0.0 0.02 0.1", "0 0 0").replace("0.0 0.0 -0.3", "0 0 0")
    corners = np.array([(-1.0, -0.8), (1.0, -0.8), (1.0, 1.2), (-1.0, 1.2)])
    ends = 0.1 * np.sign(corners) @ along * body
    exits = corners @ along + place
    cables = "".join(
        caspr_cable(str(k), a.tolist(), b.tolist()) for k, (a, b) in enumerate(zip(exits, ends, strict=True))
    )
    found = read(tmp_path, text, caspr_cables(cables))
    robot = found.robot
    assert (robot.n, robot.freedoms) == ((6, 3) if body else (3, 2))
    plane = robot.platform.plane
    assert plane is not None
    assert (plane.across, plane.distance, plane.pulls) == (tuple(normal), 0.25, True)
    assert {line.tension_limits for line in robot.lines} == {(5.0, 800.0)}
    at = np.array([0.1, 0.3]) @ along + place
    pose, turned = at, ends
    if body:
        turn = Rotation.from_rotvec(0.2 * normal)
        pose, turned = np.concatenate([at, turn.as_rotvec()]), turn.apply(ends)
    lengths = cw.inverse(robot, pose, cable="rigid").lengths
    np.testing.assert_allclose(lengths, np.linalg.norm(exits - at - turned, axis=1), atol=1e-9)
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    np.testing.assert_allclose(low[normal == 0.0], [-0.5, 0.1])
    np.testing.assert_allclose(high[normal == 0.0], [0.5, 0.9])
    assert loads(robot_toml(found, "cablewright import")) == robot
    assert not any("parent.location" in each for each in found.lost)


@pytest.mark.parametrize("most", ["1 0 1", "1 nan 1", "1"])
def test_limits_of_a_joint_that_are_no_box(most: str, tmp_path: Path) -> None:
    joint = f'<joint type="TRANSLATIONAL_XYZ" q_min="0 0 0" q_max="{most}"/>'
    point = caspr_cables("".join(caspr_cable(str(k), at, (0.0, 0.0, 0.0)) for k, at in enumerate(samples.EXITS)))
    found = read(tmp_path, BODIES.replace('<joint type="SPATIAL_EULER_XYZ"/>', joint), point)
    assert found.robot.scene == read(tmp_path).robot.scene
    assert "joint.q_min, q_max: no box with a finite extent along each axis of the joint" in found.lost


def test_lengths_are_distances(tmp_path: Path) -> None:
    robot = read(tmp_path).robot
    at = np.array([0.2, -0.1, 1.3])
    apart = np.linalg.norm(np.array(samples.EXITS) - at - np.array(samples.ENDS), axis=1)
    np.testing.assert_allclose(cw.inverse(robot, at, cable="rigid").lengths, apart, atol=1e-9, rtol=0)


def test_attachments_from_the_centre_of_mass(tmp_path: Path) -> None:
    """The same robot, described from another origin of its body."""
    from_mass = [tuple(b - c for b, c in zip(end, (0.0, 0.02, 0.1), strict=True)) for end in samples.ENDS]
    pairs = enumerate(zip(samples.EXITS, from_mass, strict=True))
    found = read(tmp_path, cables=caspr_cables("".join(caspr_cable(f"cable {k}", a, b, "com") for k, (a, b) in pairs)))
    ends = [line.platform_point for line in found.robot.lines]
    np.testing.assert_allclose(ends, samples.ENDS, atol=1e-15)


def test_inertia_about_the_joint(tmp_path: Path) -> None:
    """By the parallel-axis theorem: that about the centre of mass and that of the mass there."""
    x, mass = np.array([0.0, 0.02, 0.1]), 12.5
    about_joint = np.array([[1.5, 0.1, 0.0], [0.1, 1.6, 0.0], [0.0, 0.0, 1.7]])
    about_joint = about_joint + mass * (x @ x * np.eye(3) - np.outer(x, x))
    text = BODIES.replace('ref="com"', 'ref="joint"')
    for key, value in (
        ("Ixx", (0, 0)),
        ("Iyy", (1, 1)),
        ("Izz", (2, 2)),
        ("Ixy", (0, 1)),
        ("Ixz", (0, 2)),
        ("Iyz", (1, 2)),
    ):
        old = text[text.index(f"<{key}>") : text.index(f"</{key}>")]
        text = text.replace(old, f"<{key}>{about_joint[value]!r}".replace("np.float64(", "").replace(")", ""))
    platform = read(tmp_path, text).robot.platform
    np.testing.assert_allclose(platform.inertia, (1.5, 1.6, 1.7), atol=1e-14)
    np.testing.assert_allclose(platform.inertia_products, (0.1, 0.0, 0.0), atol=1e-14)


def test_another_set_and_another_cable(tmp_path: Path) -> None:
    found = read(tmp_path, cable_set="OTHER", cable="dyneema-4mm")
    assert [line.name for line in found.robot.lines] == ["alone"]
    assert found.robot.lines[0].cable.diameter == 0.004
    assert any("other cable sets" in each for each in found.lost)


def test_cables_are_assumed_and_reported(tmp_path: Path) -> None:
    found = read(tmp_path)
    assert any("cable: braided Dyneema" in each for each in found.assumed)
    assert found.robot.lines[0].cable.breaking_load == 5 * 800.0
    assert loads(robot_toml(found, "cablewright import")) == found.robot


def test_a_joint_elsewhere_is_reported(tmp_path: Path) -> None:
    text = BODIES.replace("</num><location>0.0 0.0 0.0", "</num><location>0.0 0.0 1.5")
    assert any(
        "poses count from the world's origin, not from 0, 0, 1.5 m" in each for each in read(tmp_path, text).lost
    )


def test_bodies_within_a_system_and_an_external_type(tmp_path: Path) -> None:
    """As CASPR writes today; the document type that it names is not read."""
    system = BODIES.replace("<links", '<!DOCTYPE bodies_system SYSTEM "bodies.dtd">\n<bodies_system><links')
    found = read(tmp_path, system.replace("</links>", "</links></bodies_system>"))
    assert found.robot == read(tmp_path).robot


def test_a_point(tmp_path: Path) -> None:
    ends = ((0.0, 0.0, 0.0),) * 8
    pairs = enumerate(zip(samples.EXITS, ends, strict=True))
    cables = caspr_cables("".join(caspr_cable(f"{k}", a, b) for k, (a, b) in pairs))
    found = read(tmp_path, BODIES.replace("SPATIAL_EULER_XYZ", "TRANSLATIONAL_XYZ"), cables)
    assert found.robot.n == 3


_TWO = BODIES[BODIES.index("  <link_rigid") : BODIES.index("</links>")]
_SPRING = caspr_cables(caspr_cable("1", (0, 0, 1), (0, 0, 0), kind="cable_linear_spring"))
_THREE = caspr_cables().replace(
    "</attachments>", "<attachment><link>1</link><location>0 0 0</location></attachment></attachments>", 1
)
BAD_BODIES = {
    "links between bodies": (BODIES.replace("</links>", _TWO + "</links>"), "only robots with a single link"),
    "hanging on a body": (BODIES.replace("<num>0</num>", "<num>1</num>"), "must be 0, the ground"),
    "other joint": (BODIES.replace("SPATIAL_EULER_XYZ", "R_Z"), "joint.type = 'R_Z'"),
    "spherical joint": (BODIES.replace("SPATIAL_EULER_XYZ", "S_EULER_XYZ"), "joint.type = 'S_EULER_XYZ': must be one"),
    "universal joint": (BODIES.replace("SPATIAL_EULER_XYZ", "U_XY"), "joint.type = 'U_XY': must be one"),
    "inertia": (BODIES.replace("<Ixx>1.5", "<Ixx>-1.5"), "own_bodies.xml with own_cables.xml: platform.inertia"),
    "mass": (BODIES.replace("<mass>12.5", "<mass>-12.5"), "must be at least"),
    "infinite": (BODIES.replace("<mass>12.5", "<mass>inf"), "must be a finite number"),
    "unit": (BODIES.replace("<mass>12.5", "<mass>12.5 kg"), "must be 1 numbers"),
    "operational link": (BODIES.replace("link_rigid", "link_soft"), "only link_rigid is"),
}
BAD_CABLES = {
    "two of one name": (
        caspr_cables(caspr_cable("a", (0, 0, 1), (0, 0, 0)) + caspr_cable("a", (1, 0, 1), (0, 0, 0.1))),
        "2 lines are named 'a'",
    ),
    "spring": (_SPRING, "only cable_ideal is"),
    "three attachments": (_THREE, "3 attachments"),
    "pulley": (
        caspr_cables()
        .replace("<attachment>", "<base_rotating_pulley>", 1)
        .replace("</attachment>", "</base_rotating_pulley>", 1),
        "<base_rotating_pulley>: this attachment type is not supported",
    ),
    "link 2": (caspr_cables().replace("<link>1</link>", "<link>2</link>", 1), "one of link 1"),
    "reference": (caspr_cables().replace('"joint"', '"end"', 1), "must be joint or com"),
    "default set": (caspr_cables(default="NONE"), "cable set 'NONE'"),
    "negative force": (caspr_cables().replace("<force_min>5", "<force_min>-5", 1), "must be at least 0"),
    "falling limits": (caspr_cables().replace("<force_min>5", "<force_min>900", 1), "must rise"),
    "two coordinates": (caspr_cables().replace("<location>-2.0 ", "<location>", 1), "must be 3 numbers"),
    "bomb": (
        caspr_cables().replace("<!ATTLIST cable_set id ID #REQUIRED>", '<!ENTITY a "b">'),
        "entities are not supported",
    ),
    "wrong half": (BODIES, "a second file of <links>"),
}


@pytest.mark.parametrize("what", BAD_BODIES)
def test_bad_bodies_are_one_line(what: str, tmp_path: Path) -> None:
    text, words = BAD_BODIES[what]
    with pytest.raises(InputError, match=r"^[^\n]*$") as caught:
        read(tmp_path, text)
    assert words in str(caught.value)


@pytest.mark.parametrize("what", BAD_CABLES)
def test_bad_cables_are_one_line(what: str, tmp_path: Path) -> None:
    text, words = BAD_CABLES[what]
    with pytest.raises(InputError, match=r"^[^\n]*$") as caught:
        read(tmp_path, cables=text)
    assert words in str(caught.value)


def test_half_a_model(tmp_path: Path) -> None:
    (tmp_path / "own_bodies.xml").write_text(BODIES)
    with pytest.raises(InputError, match=r"own_cables\.xml, is not in the same folder"):
        read_caspr([tmp_path / "own_bodies.xml"])
    (tmp_path / "body.xml").write_text(BODIES)
    with pytest.raises(InputError, match="give both"):
        read_caspr([tmp_path / "body.xml"])
