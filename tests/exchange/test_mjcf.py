"""MuJoCo models of every robot of the library: lengths at a pose, and where the platform rests on these lengths."""

from __future__ import annotations

import re

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cablewright.exchange.mjcf import mjcf
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.live.rest_pose import rest_pose
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot, library_names, load
from cablewright.solvers.inverse import solve_inverse
from physics.test_shared_winches import parallelograms
from planar_robots import board

WHEEL = {"centre": (0.4, 0.0, 6.5), "axis": (-0.2, 0.6, 0.4), "radius": 0.1}


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
    np.testing.assert_allclose(data.ten_length, at.lengths, atol=2e-6, rtol=0)
    place, turned = data.body("platform").xpos.copy(), data.body("platform").xquat.copy()
    np.testing.assert_allclose(place, at.pose[:3], atol=1e-12)
    data.qpos[2 if model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE else model.jnt_qposadr[0]] += 0.005
    for _ in range(4000):
        data.qvel *= 0.99
        mujoco.mj_step(model, data)
    assert np.abs(data.qvel).max() < 1e-4
    np.testing.assert_allclose(data.body("platform").xpos, place, atol=1e-4, rtol=0)
    assert abs(data.body("platform").xquat @ turned) > 1 - 1e-6


def straight(robot: Robot, pose: np.ndarray) -> list[float]:
    """Lengths from exit point over an upright swivel, tangent to its axis there, to the platform: by plane geometry."""
    found = []
    turn = Rotation.from_rotvec(pose[3:] if len(pose) == 6 else np.zeros(3))
    for line in robot.lines:
        away = turn.apply(line.platform_point) + pose[:3] - line.exit_point
        r = getattr(line.sheave, "radius", 0.0)
        if r == 0.0:
            found.append(float(np.linalg.norm(away)))
            continue
        along = float(np.array(line.sheave.axis) @ away)
        x, z = float(np.linalg.norm(away - along * np.array(line.sheave.axis))) - r, along
        free = float(np.sqrt(x * x + z * z - r * r))
        # the tangent point's angle about the wheel's centre, from the side of the axis over the top
        touch = np.arctan2(z, x) + (1.0 if line.sheave.wrap == "over" else -1.0) * np.arctan2(free, r)
        side = 1.0 if line.sheave.wrap == "over" else -1.0
        found.append(free + r * float((np.pi - side * touch) % (2.0 * np.pi)))
    return found


@pytest.mark.parametrize("name", ["ipanema1", "cogiro", "cable-robot-simulator", "wang2021", "jung2020"])
def test_tendons_are_as_long_as_the_straight_line_and_its_arc(name: str) -> None:
    """Independent of the exporter: MuJoCo's own length against distances and an arc."""
    at = at_rest(load(name))
    model = mujoco.MjModel.from_xml_string(mjcf(at).text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.ten_length, straight(at.model.robot, at.pose), atol=2e-6, rtol=0)


def test_another_length_is_noted() -> None:
    robot = lines_with(load("hangprinter-v4"), dead_length=0.7)
    at = solve_inverse(Model.of(robot, cable="rigid"), [0.1, -0.1, 0.4])
    made = mjcf(at)
    model = mujoco.MjModel.from_xml_string(made.text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.ten_length, at.lengths - 0.7, atol=2e-6, rtol=0)
    note = next(each for each in made.lost if "are 700 mm shorter than the lines" in each)
    assert f"<!-- lost: {note} -->" in made.text


def settled(at: Equilibrium, steps: int = 3000) -> tuple[np.ndarray, mujoco.MjModel, mujoco.MjData]:
    """Where MuJoCo's platform rests that begins 5 mm aside."""
    model = mujoco.MjModel.from_xml_string(mjcf(at).text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.ten_length, model.tendon_range[:, 1], atol=1e-8, rtol=0)
    data.qpos[model.jnt_qposadr[0]] += 0.005
    for _ in range(steps):
        data.qvel *= 0.99
        mujoco.mj_step(model, data)
    return data.body("platform").xpos.copy(), model, data


def lines_with(robot: Robot, **changes: object) -> Robot:
    table = robot.model_dump(by_alias=True)
    for line in table["lines"]:
        line.update(changes)
    return Robot.model_validate(table)


@pytest.mark.parametrize(
    "changes",
    [
        {"sheave": {"kind": "swivel", "radius": 0.03, "axis": (0.2, -0.1, 1.0)}, "winch_exit": None},
        {"sheave": {"kind": "swivel", "radius": 0.03, "wrap": "under"}, "winch_exit": None},
        {"sheave": {"kind": "eyelet"}, "winch_exit": (0.0, 0.0, 6.0), "guides": ((0.4, 0.0, 6.5), (0.0, 1.0, 6.0))},
        {"sheave": {"kind": "eyelet"}, "winch_exit": (0.0, 0.0, 6.0), "guides": (WHEEL, (0.0, 1.0, 5.0))},
        {"sheave": {"kind": "eyelet"}, "winch_exit": None, "advantage": 3},
        {"sheave": {"kind": "eyelet"}, "winch_exit": None, "cables": 2, "dead_length": 0.7},
        {"exit_compliance": 2e-6},
        {"exit_compliance": ((1e-6, 2e-7, 0.0), (2e-7, 2e-6, 0.0), (0.0, 0.0, 1e-6)), "sheave": {"kind": "eyelet"}},
        {"spring": 1e5},
    ],
    ids=["tilted", "under", "guides", "wheels", "advantage", "cables", "mount", "spatial mount", "spring"],
)
def test_kinds_of_lines(changes: dict[str, object]) -> None:
    robot = lines_with(load("merlet2023"), **changes)
    at = solve_inverse(Model.of(robot, cable="rigid"), [0.3, -0.4, 1.2])
    place, model, _ = settled(at)
    np.testing.assert_allclose(place, at.pose, atol=1e-4, rtol=0)
    apart = 1e3 * np.abs(model.tendon_range[:, 1] - at.lengths)  # which `settled` held against MuJoCo's own
    noted = re.findall(r"tendons of .* are ([0-9.]+) mm (?:longer|shorter)", "\n".join(mjcf(at).lost))
    assert sorted(set(map(float, noted))) == pytest.approx(
        sorted({float(f"{each:.4g}") for each in apart if each > 2e-3})
    )
    told = any("wheels are sites on their rims" in each for each in mjcf(at).lost)
    assert told == (WHEEL in changes.get("guides", ()))


def test_a_sheave_on_the_platform() -> None:
    robot = load("jung2020")
    table = robot.model_dump(by_alias=True)
    for line in table["lines"]:
        line["platform_sheave"] = {"radius": 0.01, "axis": (0.0, 0.0, 1.0 if line["platform_point"][2] < 0.5 else -1.0)}
    table["platform"]["retraction"] = None
    at = solve_inverse(Model.of(Robot.model_validate(table), cable="rigid"), [0.05, -0.02, 0.9, 0.0, 0.0, 0.0])
    if not np.isfinite(at.lengths).all():
        pytest.skip(at.sentence())
    place, _, _ = settled(at)
    np.testing.assert_allclose(place, at.pose[:3], atol=1e-4, rtol=0)


@pytest.mark.parametrize("kind", ["swivel", "eyelet", "guided"])
def test_a_counterweight_hangs_and_pulls(kind: str) -> None:
    """As a mass at the end of its cable: the platform rests at the pose, and the mass 1 m below the winch exit."""
    robot = load("merlet2023")
    changes = {} if kind == "swivel" else {"sheave": {"kind": "eyelet"}, "winch_exit": (0.0, 0.0, 6.0)}
    robot = lines_with(robot, **changes, **({"guides": ((0.4, 0.0, 6.5),)} if kind == "guided" else {}))
    table = robot.model_dump(by_alias=True)
    lines = list(table["lines"])
    lines[2] = lines[2] | {"counterweight": 4.0, "winch": {}}
    table["lines"] = lines
    at = solve_inverse(Model.of(Robot.model_validate(table), cable="rigid"), [0.3, -0.4, 1.2]).checked()
    made = mjcf(at)
    name = at.model.robot.lines[2].name
    assert [each for each in made.lost if "counterweight" in each] == [
        f"tendon of {name!r} is 1 m longer than the line: down to its counterweight"
    ]
    model = mujoco.MjModel.from_xml_string(made.text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.ten_length, model.tendon_range[:, 1], atol=1e-8, rtol=0)
    for _ in range(8000):
        data.qvel *= 0.99
        mujoco.mj_step(model, data)
    assert np.abs(data.qvel).max() < 1e-4
    np.testing.assert_allclose(data.body("platform").xpos, at.pose, atol=1e-4, rtol=0)
    start = np.array(at.model.robot.lines[2].winch_exit) - [0.0, 0.0, 1.0]
    hung = data.site(f"counterweight {at.model.robot.lines[2].name}").xpos
    np.testing.assert_allclose(hung, start, atol=2e-4, rtol=0)


def test_lines_that_share_winches_keep_their_lengths() -> None:
    """Their drums are lost, by a note: tendons of equal lengths hold the parallelograms all the same."""
    at = solve_inverse(Model.of(parallelograms(4), cable="rigid"), [0.1, 0.05, 1.0, *[np.nan] * 3]).checked()
    assert any("shared_winch" in each for each in mjcf(at).lost)
    place, model, data = settled(at)
    np.testing.assert_allclose(place, at.pose[:3], atol=1e-4, rtol=0)
    np.testing.assert_allclose(data.body("platform").xquat[1:], 0.0, atol=1e-4)
    np.testing.assert_allclose(model.tendon_range[:, 1], at.lengths, atol=2e-6, rtol=0)


@pytest.mark.parametrize("plane", ["vertical", "tilted"])
@pytest.mark.parametrize("body", [False, True])
def test_a_platform_in_a_plane(plane: str, body: bool) -> None:
    robot = board(plane, body)
    at = rest_pose(Model.of(robot, cable="rigid")).equilibrium
    place, model, _ = settled(at)
    assert model.nv == (3 if body else 2)
    np.testing.assert_allclose(place, at.pose[:3], atol=1e-4, rtol=0)


def test_motors_pull() -> None:
    """With the model's own tensions as controls, and tendons let out, the platform is in balance."""
    at = rest_pose(Model.of(load("jung2020"), cable="rigid")).equilibrium
    model = mujoco.MjModel.from_xml_string(mjcf(at).text)
    model.tendon_limited[:] = 0
    data = mujoco.MjData(model)
    data.ctrl[:] = at.tensions
    mujoco.mj_forward(model, data)
    assert np.abs(data.qacc).max() < 1e-6


def test_rejections() -> None:
    robot = load("merlet2023")
    with pytest.raises(InputError, match="tendons do not stretch"):
        mjcf(solve_inverse(Model.of(robot), [0.0, 0.0, 1.0]))
    with pytest.raises(AnswerError, match="no lengths at this pose"):
        mjcf(solve_inverse(Model.of(load("house-printer"), cable="rigid"), [0.0, 0.0, 16.0]))
    aside = lines_with(robot, winch_exit=(0.0, 0.0, 0.0))
    with pytest.raises(InputError, match="a winch that is not on the axis of its swivel; not supported"):
        mjcf(solve_inverse(Model.of(aside, cable="rigid"), [0.0, 0.0, 1.0]))
