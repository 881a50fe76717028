"""Laws of lines out of the plane: their lengths, balance, derivatives, energy and symmetries."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.spatial.transform import Rotation

import cablewright as cw
import out_of_plane
from cablewright.kernels import batches, layout
from cablewright.kernels.statics.line import spatial
from cablewright.models.parameters import varied
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.stiffness import stiffness
from cablewright.robot import Eyelet, Line, PlatformSheave, Pulley, Robot, Swivel
from cablewright.robot.new_robot import Outline, robot_file
from cablewright.robot.parameter_values import with_modulus
from cablewright.robot.parameters import Parameter, nominal
from cablewright.solvers.linearise import tension_changes
from cablewright.solvers.parameter_effects import response
from oracles import guided_paths as oracle
from oracles import irvine

LIMITS = (10.0, 8000.0)
LAWS = ("elastic", "catenary")


def bodies() -> list[Robot]:
    return [out_of_plane.body(kind) for kind in out_of_plane.KINDS]


def points() -> list[Robot]:
    return [out_of_plane.point(kind) for kind in ("tilted", "pulleys", "guides", "wheels")]


def held(robot: Robot, cable: str, count: int = 6) -> Equilibrium:
    """Random poses that the robot holds."""
    rng = np.random.default_rng(3)
    if robot.n == 6:
        poses = rng.uniform([-2, -1.5, 1, -0.1, -0.1, -0.1], [2, 1.5, 3, 0.1, 0.1, 0.1], (count, 6))
    else:
        poses = rng.uniform([-2, -2, 0.3], [2, 2, 1.5], (count, 3))
    found = cw.inverse(robot, poses, cable=cable, tension_limits=LIMITS)
    assert found.ok.any()
    return found[found.ok]


def turned(pose: np.ndarray) -> np.ndarray:
    return Rotation.from_rotvec(pose[3:]).as_matrix() if len(pose) == 6 else np.eye(3)


@pytest.mark.parametrize("robot", [*bodies(), *points()], ids=lambda robot: robot.name)
def test_rigid_lengths_and_pulls_are_the_geometry(robot: Robot) -> None:
    """Against the tangency equations with 60 digits, and for sheaves that MuJoCo can have, its tendons."""
    some = held(robot, "rigid", 3)
    for pose, lengths, tensions in zip(some.pose, some.lengths, some.tensions, strict=True):
        if any(line.is_aside for line in robot.lines):
            continue  # the oracle does not know them: see the textbook form
        wrench = np.zeros(6)
        for line, length, tension in zip(robot.lines, lengths, tensions, strict=True):
            frame, end = out_of_plane.frame_of(line), out_of_plane.end_of(line)
            path = oracle.taut_path(frame, end, pose[:3], turned(pose))
            dead = out_of_plane.dead_length(line) if isinstance(frame, oracle.Eyelet) else 0.0
            dead += out_of_plane.before_pulley(line) if isinstance(frame, oracle.Pulley) else 0.0
            assert abs(length - float(path.length) - dead) < 1e-12 * length + 1e-13
            pull = -tension * np.array(path.direction, dtype=float)
            arm = np.array(path.arrives, dtype=float) - pose[:3]
            wrench += np.concatenate([pull, np.cross(arm, pull)])
            if not isinstance(frame, oracle.Pulley) and end.leaves is None:
                tendon = oracle.mujoco_path(frame, end, pose[:3], turned(pose))
                np.testing.assert_allclose(tendon.gradient[:3], -pull / tension, atol=1e-9)
        weight = robot.platform.mass * robot.scene.gravity
        if robot.n == 6:
            centre = turned(pose) @ np.array(robot.platform.centre_of_mass)
            wrench += np.concatenate([[0, 0, -weight], np.cross(centre, [0, 0, -weight])])
        else:
            wrench = wrench[:3] - [0, 0, weight]
        assert np.abs(wrench).max() < 1e-8 * weight


@pytest.mark.parametrize("robot", [*bodies(), *points()], ids=lambda robot: robot.name)
@pytest.mark.parametrize("cable", LAWS)
def test_balance_in_textbook_form(robot: Robot, cable: str) -> None:
    """Irvine's span from where the tension vector touches one sheave ends where it touches the other."""
    model = Model.of(robot, cable=cable)
    some = held(robot, cable, 4)
    assert some.is_valid()
    for each in some[:2]:
        wrench, load = np.zeros(6), robot.platform.mass * robot.scene.gravity
        for i, line in enumerate(robot.lines):
            weight = line.cable.linear_density * robot.scene.gravity if cable == "catenary" else 0.0
            state = each.states[i]
            start, end, gap, length = textbook(line, state, weight, each.pose, model)
            assert gap < 1e-9
            assert abs(length - each.lengths[i]) < 1e-9
            assert abs(np.linalg.norm(start) - each.tensions[i]) < 1e-9 * each.tensions[i]
            assert abs(np.linalg.norm(end[0]) - each.platform_tensions[i]) < 1e-9 * each.tensions[i]
            wrench -= np.concatenate([end[0], np.cross(end[1], end[0])])
        if robot.n == 6:
            centre = turned(each.pose) @ np.array(robot.platform.centre_of_mass)
            wrench += np.concatenate([[0, 0, -load], np.cross(centre, [0, 0, -load])])
        else:
            wrench = wrench[:3] - [0, 0, load]
        assert np.abs(wrench).max() < 1e-9 * load


def textbook(line: Line, state: np.ndarray, weight: float, pose: np.ndarray, model: Model):
    """Start force, end force and arm, how far the span misses the sheave on the platform (m), and its length (m)."""
    phi, tau, free, _, azimuth, _ = state
    tension, R = np.exp(tau), turned(pose)
    start = tension * np.array([np.cos(phi) * np.cos(azimuth), np.cos(phi) * np.sin(azimuth), np.sin(phi)])
    end = start + np.array([0, 0, weight * free])
    stiffness = line.cable.stiffness
    x, z = irvine.span(np.hypot(*start[:2]), start[2], free, weight, stiffness)
    across = start[:2] / np.hypot(*start[:2])
    left, contact = out_of_plane.touched(line, start)
    gave = out_of_plane.given_way(line, start)
    left = left + gave
    slip, wound = out_of_plane.at_platform(line, R, end)
    anchor = R @ np.array(line.platform_point) + slip
    reached = left + np.array([float(x) * across[0], float(x) * across[1], float(z)])
    gap = float(np.abs(reached - pose[:3] - anchor).max())
    rise, dead = 0.0, out_of_plane.dead_length(line)
    if line.winch_exit is not None:
        way = out_of_plane.way_of(line)
        if line.is_aside:
            aside = out_of_plane.Aside(line, start)
            dead = float(np.linalg.norm(aside.winch - aside.enters) - np.linalg.norm(aside.winch)) + way.length
        if isinstance(line.sheave, Pulley):
            path = oracle.taut_path(
                out_of_plane.frame_of(line), oracle.End((0, 0, 0)), line.exit_point - 3.0 * np.array(line.exit_point)
                / np.linalg.norm(line.exit_point), np.eye(3))  # fmt: skip
            dead = float(path.dead_length) + out_of_plane.before_pulley(line)
        rise = (way.mean_height - way.contacts[-1][0][2]) / way.length  # mean height over the sheave, per length
    dead -= float(gave @ out_of_plane.towards_winch(line))
    unstrained = mp.findroot(
        lambda L: L * (1 + (mpf(tension) + weight * L * rise) / stiffness) - dead, dead
    ) if line.winch_exit is not None and line.dead_elastic else dead  # fmt: skip
    strain = 1 + tension / stiffness if line.arc_elastic else 1.0
    return start, (end, anchor), gap, free + float(unstrained) + (contact + wound) / strain


@pytest.mark.parametrize("robot", [*bodies(), *points()], ids=lambda robot: robot.name)
@pytest.mark.parametrize("cable", LAWS)
def test_round_trip(robot: Robot, cable: str) -> None:
    some = held(robot, cable)
    there = cw.forward(robot, some.lengths, cable=cable)
    assert there.ok.all()
    np.testing.assert_allclose(there.pose, some.pose, atol=1e-9)
    np.testing.assert_allclose(there.tensions, some.tensions, rtol=1e-6)


@pytest.mark.parametrize("robot", bodies(), ids=lambda robot: robot.name)
@pytest.mark.parametrize("cable", LAWS)
def test_stiffness_is_symmetric_where_statics_is_conservative(robot: Robot, cable: str) -> None:
    lines = tuple(line.model_copy(update={"arc_elastic": True}) for line in robot.lines)
    stiffness = cw.linearise(held(robot.model_copy(update={"lines": lines}), cable)).stiffness
    skew = np.abs(stiffness - np.swapaxes(stiffness, 1, 2)).max() / np.abs(stiffness).max()
    # a groove that holds a cable aslant, arcs without weight and dead spans that keep theirs spend a little energy
    if robot.name in ("aside", "pulleys", "mixed", "pulleys on mounts", "wheels", "platform pulleys"):
        most = 1e-3
    else:
        most = 1e-9 if cable == "elastic" else 1e-6 if robot.name == "mounts" else 1e-7
    assert skew < most


@pytest.mark.parametrize("robot", [*bodies(), *points()], ids=lambda robot: robot.name)
@pytest.mark.parametrize("cable", LAWS)
def test_motions_are_differences(robot: Robot, cable: str) -> None:
    each = held(robot, cable, 2)[0]
    linear, model = cw.linearise(each), Model.of(robot, cable=cable)
    for i in (0, 3):
        line, by_step = robot.lines[i], {"modulus": 1e-4, "linear_density": 1e-4}
        columns = {"length_offset": linear.per_length[:, i], "modulus": linear.per_modulus[:, i]}
        columns["linear_density"] = linear.per_weight[:, i] / line.cable.linear_density
        for axis, word in enumerate("xyz"):
            columns[f"exit_point.{word}"] = linear.per_exit_point[:, i, axis]
            if robot.n == 6:
                columns[f"platform_point.{word}"] = linear.per_platform_point[:, i, axis]
        if not isinstance(line.sheave, Eyelet):
            columns["sheave_radius"] = linear.per_sheave_radius[:, i]
        if isinstance(line.exit_compliance, float):
            columns["exit_compliance"] = response(each[None], [Parameter("exit_compliance", line.name)])[0, :, 0]
            by_step["exit_compliance"] = 1e-9
        for kind, wanted in columns.items():
            motion = differences(model, each, Parameter(kind, line.name), by_step.get(kind, 1e-6))
            np.testing.assert_allclose(wanted, motion, rtol=2e-6, atol=1e-6, err_msg=f"{kind} of {line.name}")


def differences(model: Model, each: Equilibrium, parameter: Parameter, step: float) -> np.ndarray:
    """Fourth-order differences of the motion (m, and rotations about world axes) by a parameter."""
    value, ways = nominal(model.robot, parameter), {}
    for k in (-2, -1, 1, 2):
        values = np.array([[value + k * step]])
        packed, lengths = varied(model.robot, model.rows(), [parameter], values, each.lengths[None])
        pose, states = each.pose[None].copy(), each.states[None].copy()
        codes, counts, residuals = np.zeros(1, np.int64), np.zeros(1, np.int64), np.zeros(1)
        batches.forward_rows(packed, lengths, pose, states, codes, counts, residuals, batches.WARM, 0, 1)
        assert codes[0] == 0
        ways[k] = pose[0] - each.pose
        if model.n == 6:
            way = Rotation.from_rotvec(pose[0, 3:]) * Rotation.from_rotvec(each.pose[3:]).inv()
            ways[k][3:] = way.as_rotvec()
    return (8 * (ways[1] - ways[-1]) - (ways[2] - ways[-2])) / (12 * step)


def test_changes_of_tension_are_differences() -> None:
    """With the platform held: by the line's own length, and by its exit point."""
    robot = out_of_plane.body("mixed")
    model, each = Model.of(robot), held(robot, "catenary", 2)[0]
    own, by_pose, codes = np.zeros((1, 8, 10)), np.zeros((1, 8, 6)), np.zeros(1, np.int64)
    batches.tension_rows(each.packed, *each.solved_arrays(), own, by_pose, codes)
    assert codes[0] == 0
    for i, line in enumerate(robot.lines):
        for kind, column in (("length_offset", 0), ("exit_point.x", 2), ("exit_point.z", 4)):
            tensions = {}
            for k in (-1, 1):
                parameter = Parameter(kind, line.name)
                value = np.array([[nominal(robot, parameter) + k * 1e-6]])
                packed, lengths = varied(robot, model.rows(), [parameter], value, each.lengths[None])
                tensions[k] = settled_tension(packed, lengths[0, i], each, i)
            change = (tensions[1] - tensions[-1]) / 2e-6
            np.testing.assert_allclose(
                own[0, i, column], change, rtol=1e-5, atol=1e-6, err_msg=f"{kind} of {line.name}"
            )
    np.testing.assert_allclose(by_pose[0, :, :3], -own[0, :, 2:5], rtol=1e-9)


def settled_tension(packed, length: float, each: Equilibrium, i: int) -> float:
    """Logarithm of the tension of line *i* with the platform held where it is."""
    row, pose, y = packed.lines[0, i].copy(), each.pose.copy(), each.states[i].copy()
    arm = turned(pose) @ row[layout.POINT_X : layout.POINT_X + 3]
    block, rhs, record = (
        np.zeros((spatial.SIZE, spatial.SIZE)),
        np.zeros((spatial.SIZE, spatial.COLUMNS)),
        np.zeros(spatial.RECORD),
    )
    assert spatial.settle_spatial(row, y, pose, arm, turned(pose), length, record, block, rhs)
    return float(y[layout.TAU])


@pytest.mark.parametrize("cable", LAWS)
def test_an_upright_swivel_written_as_a_tilted_one(cable: str) -> None:
    """Under an axis that points down the cable runs as over one that points up, in the other kernel."""
    upright = out_of_plane.point("tilted")
    way: dict[str, Robot] = {}
    for name, axis, wrap in (("plane", (0, 0, 1), "over"), ("space", (0, 0, -1), "under")):
        own = {"sheave": Swivel(radius=0.06, axis=axis, wrap=wrap), "dead_elastic": True, "arc_elastic": True}
        lines = tuple(
            line.model_copy(update=own | {"winch_exit": tuple(np.array(line.exit_point) - [0, 0, 2.0])})
            for line in upright.lines
        )
        way[name] = out_of_plane.checked(upright.model_copy(update={"lines": lines}))
    assert way["plane"].lines[0].in_plane
    assert not way["space"].lines[0].in_plane
    one, two = (held(way[name], cable) for name in ("plane", "space"))
    np.testing.assert_allclose(two.lengths, one.lengths, rtol=1e-13)
    for what in ("tensions", "platform_tensions", "winch_tensions"):
        np.testing.assert_allclose(getattr(two, what), getattr(one, what), rtol=1e-11)
    np.testing.assert_allclose(two.margin(), one.margin(), rtol=1e-9)
    np.testing.assert_allclose(cw.linearise(two).stiffness, cw.linearise(one).stiffness, rtol=1e-8, atol=1e-4)
    np.testing.assert_allclose(stiffness(two).axial, stiffness(one).axial, rtol=1e-9)


@pytest.mark.parametrize("cable", LAWS)
def test_small_sheaves_are_eyelets(cable: str) -> None:
    """Lengths come closer to those of eyelets as the sheaves shrink, in proportion."""
    robot = out_of_plane.body("both")
    plain = cw.inverse(robot, [0.4, 0.3, 1.5, 0, 0, 0], cable=cable, sheave="eyelet", tension_limits=LIMITS)
    apart = []
    for size in (1e-2, 1e-4, 1e-6):
        lines = []
        for line in robot.lines:
            sheave = line.sheave.model_copy(update={"radius": size * line.sheave.radius})
            end = line.platform_sheave.model_copy(update={"radius": size * line.platform_sheave.radius})
            lines.append(line.model_copy(update={"sheave": sheave, "platform_sheave": end}))
        small = robot.model_copy(update={"lines": tuple(lines)})
        found = cw.inverse(small, plain.pose, cable=cable, tension_limits=LIMITS)
        apart.append(np.abs(found.lengths - plain.lengths).max())
    assert apart[0] < 0.01
    np.testing.assert_allclose(apart[1:], [apart[0] * 1e-2, apart[0] * 1e-4], rtol=0.1)


@pytest.mark.parametrize("cable", LAWS)
def test_the_world_can_be_turned_and_mirrored(cable: str) -> None:
    robot, turn = out_of_plane.body("both"), Rotation.from_rotvec([0, 0, 0.7])
    mirror = np.diag([1.0, -1.0, 1.0])
    pose = np.array([0.6, 0.3, 1.4, 0.05, -0.04, 0.03])
    here = cw.inverse(robot, pose, cable=cable, tension_limits=LIMITS).checked()
    there = cw.inverse(
        moved(robot, turn.as_matrix(), np.eye(3)),
        np.concatenate([turn.apply(pose[:3]), (turn * Rotation.from_rotvec(pose[3:])).as_rotvec()]),
        cable=cable, tension_limits=LIMITS,
    )  # fmt: skip
    np.testing.assert_allclose(there.lengths, here.lengths, rtol=1e-12)
    reflected = np.concatenate([mirror @ pose[:3], -mirror @ pose[3:]])
    other = cw.inverse(moved(robot, mirror, mirror), reflected, cable=cable, tension_limits=LIMITS)
    np.testing.assert_allclose(other.lengths, here.lengths, rtol=1e-12)
    np.testing.assert_allclose(other.tensions, here.tensions, rtol=1e-9)


def moved(robot: Robot, world: np.ndarray, own: np.ndarray) -> Robot:
    """The robot with its frame moved by *world* and its platform's frame by *own*."""
    lines = []
    for line in robot.lines:
        update = {"exit_point": tuple(world @ line.exit_point), "platform_point": tuple(own @ line.platform_point)}
        if line.winch_exit is not None:
            update["winch_exit"] = tuple(world @ line.winch_exit)
        axis, end = tuple(world @ line.sheave.axis), tuple(own @ line.platform_sheave.axis)
        update["sheave"] = line.sheave.model_copy(update={"axis": axis})
        update["platform_sheave"] = line.platform_sheave.model_copy(update={"axis": end})
        lines.append(line.model_copy(update=update))
    centre = tuple(own @ robot.platform.centre_of_mass)
    platform = robot.platform.model_copy(update={"centre_of_mass": centre})
    return robot.model_copy(update={"lines": tuple(lines), "platform": platform})


def test_gravity_alone_turns_a_platform_on_four_lines() -> None:
    """An underconstrained robot with horizontal swivels: position given, rotation found, and found again."""
    robot, rng = cw.load("grab-four-lines"), np.random.default_rng(1)
    own = [
        {"sheave": Swivel(radius=0.02, axis=tuple(rng.normal(size=3) * [1, 1, 0.2])), "winch_exit": None,
         "platform_sheave": PlatformSheave(radius=0.01, axis=(0.0, 0.3, -1.0))}
        for _ in robot.lines
    ]  # fmt: skip
    lines = tuple(line.model_copy(update=new) for line, new in zip(robot.lines, own, strict=True))
    robot = out_of_plane.checked(robot.model_copy(update={"lines": lines}))
    asked = [[0.1, -0.05, -0.9 + robot.lines[0].exit_point[2], 0.0, np.nan, np.nan]]
    for cable in LAWS:
        found = cw.inverse(robot, asked, cable=cable)
        assert found.ok.all()
        assert found.is_valid()
        again = cw.forward(robot, found.lengths, guess=found.pose, cable=cable)
        np.testing.assert_allclose(again.pose, found.pose, atol=1e-8)


@pytest.mark.parametrize("cable", LAWS)
def test_close_to_the_axis_the_cable_leaves_backwards(cable: str) -> None:
    """From beyond the sheave to close to its axis, against the planar kernel."""
    way: dict[str, Robot] = {}
    robot = cw.loads(robot_file(Outline(name="hang", layout="over-middle", size=(4.0, 3.0, 3.0))))
    for name, axis, wrap in (("plane", (0, 0, 1), "over"), ("space", (0, 0, -1), "under")):
        over = robot.lines[-1].model_copy(update={"sheave": Swivel(radius=0.05, axis=axis, wrap=wrap)})
        way[name] = robot.model_copy(update={"lines": (*robot.lines[:-1], over)})
    aside = np.concatenate([np.geomspace(1e-4, 0.09, 12), np.linspace(0.095, 0.105, 12), np.linspace(0.11, 0.5, 6)])
    poses = np.stack([0.6 * aside, 0.8 * aside, np.full(len(aside), 0.5)], axis=1)
    one, two = (cw.inverse(way[name], poses, cable=cable) for name in ("plane", "space"))
    assert one.status == two.status
    assert one.ok.sum() > 20
    np.testing.assert_allclose(two.lengths[two.ok], one.lengths[one.ok], rtol=1e-10)
    np.testing.assert_allclose(two.tensions[two.ok], one.tensions[one.ok], rtol=1e-8)


def test_tension_is_least_and_most_at_the_guides() -> None:
    """Along a dead span that rises over its exit point and falls below its winch."""
    robot = out_of_plane.point("guides")
    for each in held(robot, "catenary", 3):
        low, high = each.extremes()
        for i, line in enumerate(robot.lines):
            weight = line.cable.linear_density * robot.scene.gravity
            points = np.array([line.winch_exit, *line.guides, line.exit_point])
            density = each.line_states.dead_length[i] / out_of_plane.dead_length(line)
            along = each.tensions[i] + weight * density * (points[:, 2] - line.exit_point[2])
            assert high[i] == pytest.approx(max(along.max(), each.platform_tensions[i]), rel=1e-12)
            assert low[i] <= along.min() * (1.0 + 1e-12)
            assert each.winch_tensions[i] == pytest.approx(along[0], rel=1e-12)
            assert along.max() > max(each.tensions[i], each.winch_tensions[i])  # at a guide, above both ends


def one_line_over(**own: object) -> Robot:
    """A point of 10 kg on four lines from eyelets, the first one with other keys."""
    corners, lines = [(2, 2), (-2, 2), (-2, -2), (2, -2)], []
    for i, (x, y) in enumerate(corners):
        lines.append({
            "name": str(i), "exit_point": (x, y, 3), "sheave": {"kind": "eyelet"}, "tension_limits": (1, 2000),
            "cable": {"axial_stiffness": 2e5, "linear_density": 0.02, "breaking_load": 1e5},
        } | (own if i == 0 else {}))  # fmt: skip
    scene = {"frame_min": (-2, -2, 0), "frame_max": (2, 2, 3)}
    return Robot.model_validate({"name": "four", "scene": scene, "platform": {"mass": 10}, "lines": lines})


@pytest.mark.parametrize("cable", LAWS)
def test_several_spans_behind_guides(cable: str) -> None:
    """Guides on the straight path of the dead span change nothing, for each span of an advantage."""
    own = {"winch_exit": (2, 2, 0), "advantage": 2}
    plain, guided = (cw.inverse(one_line_over(**own | more), [0.3, 0.2, 1], cable=cable) for more in
                     ({}, {"guides": [(2, 2, 1)]}))  # fmt: skip
    assert guided.is_valid()
    np.testing.assert_allclose(guided.lengths, plain.lengths, rtol=1e-9)
    np.testing.assert_allclose(cw.linearise(guided).per_length, cw.linearise(plain).per_length, rtol=1e-6, atol=1e-9)
    back = cw.forward(guided.model, guided.lengths)
    np.testing.assert_allclose(back.pose, guided.pose, atol=1e-9)
    for tension in ("winch_tensions", "tensions"):
        np.testing.assert_allclose(getattr(guided, tension), getattr(plain, tension), rtol=1e-9)


def test_a_winch_aside_counts_all_its_dead_spans() -> None:
    swivel = {"kind": "swivel", "radius": 0.05}
    near = cw.inverse(one_line_over(sheave=swivel, winch_exit=(2, 2.5, 1)), [0.3, 0.2, 1], cable="rigid")
    far = one_line_over(sheave=swivel, winch_exit=(2, 2.5, -9), guides=[(2, 2.5, 1)])
    found = cw.inverse(far, [0.3, 0.2, 1], cable="rigid")
    assert found.lengths[0] - near.lengths[0] == pytest.approx(10.0, rel=1e-9)
    sagging = cw.inverse(far, [0.3, 0.2, 1])
    fall = 12.0 * 0.02 * 9.81 * sagging.line_states.dead_length[0] / found.line_states.dead_length[0]
    weight_on_sheave = 2 * 0.05 * 0.02 * 9.81  # heights count from the exit point, not from where the cable enters
    assert sagging.winch_tensions[0] == pytest.approx(sagging.tensions[0] - fall, abs=weight_on_sheave)
    np.testing.assert_allclose(cw.forward(far, sagging.lengths).pose, sagging.pose, atol=1e-9)


def test_tensions_change_as_the_platform_moves() -> None:
    """With the platform's sheaves, also as it turns: against the equilibrium under a small moment."""
    robot = out_of_plane.body("both")
    held_ = cw.inverse(robot, [[0.3, 0.2, 1.4, 0.02, 0.03, -0.05]], tension_limits=LIMITS)
    changes = tension_changes(held_)
    linear = cw.linearise(held_)
    moment = np.array([0.0, 0.0, 0.0, 0.3, -0.2, 0.4])
    motion = np.linalg.solve(linear.stiffness[0], moment)
    pushed = robot.under_wrench((0, 0, 0), tuple(moment[3:]))
    other = cw.forward(pushed, held_.lengths, guess=held_.pose)
    found = changes.following(motion[None, :, None])[0, :, 0]
    np.testing.assert_allclose(found, (other.tensions - held_.tensions)[0], rtol=1e-3, atol=1e-5)


def test_the_elastic_part_of_the_stiffness_scales_with_the_cables() -> None:
    """At the same tensions ten times as stiff cables leave the geometric part as it is."""
    robot, parts = out_of_plane.body("platform sheaves"), []
    for factor in (1.0, 10.0):
        lines = [with_modulus(line, "", factor * 100.0) for line in robot.lines]
        stiff = robot.model_copy(update={"lines": tuple(lines)})
        found = cw.inverse(stiff, [0.3, 0.2, 1.4, 0.02, 0.03, -0.05], cable="elastic", tension_limits=LIMITS)
        parts.append(stiffness(found))
    np.testing.assert_allclose(parts[1].elastic, 10.0 * parts[0].elastic, rtol=1e-4)
    largest = np.abs(parts[0].geometric).max()
    np.testing.assert_allclose(parts[1].geometric, parts[0].geometric, atol=0.02 * largest)


def test_contact_below_zero_at_the_frame_is_no_answer() -> None:
    """However long the contact on the platform's sheave is: the cable would pass the frame's sheave by."""
    own = {"sheave": Swivel(radius=0.05), "exit_point": (0.0, 0.0, 0.0),
           "platform_sheave": PlatformSheave(radius=0.1, axis=(0.0, 0.0, 1.0))}  # fmt: skip
    robot = one_line_over()
    low = robot.lines[0].model_copy(update=own)
    robot = out_of_plane.checked(
        robot.model_copy(update={"lines": (*robot.lines, low.model_copy(update={"name": "low"}))})
    )
    for x in (0.03, 0.06, 0.3):
        found = cw.inverse(robot, [x, 0.0, 1.0], cable="elastic")
        record = np.zeros(spatial.RECORD)
        row, y = Model.of(robot, cable="elastic").packed.lines[4], np.zeros(6)
        block, rhs, arm, eye = np.zeros((4, 4)), np.zeros((4, spatial.COLUMNS)), np.zeros(3), np.eye(3)
        assert spatial.straight_spatial(row, y, np.array([x, 0.0, 1.0]), arm, eye, 1.0, record, block, rhs)
        contacts = record[spatial.FRAME + 12], record[spatial.PLATFORM + 12]
        assert (found.status.word == "bad-wrap") == (min(contacts) < -1e-9) or found.status.word == "infeasible"
