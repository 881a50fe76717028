"""Laws of lines with a counterweight: energy, LPs, the same robot with winches, derivatives, inertia, rejections."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog, root
from scipy.spatial.transform import Rotation

import cablewright as cw
import out_of_plane
from cablewright.analyses.motion.path_swing import PathSwing
from cablewright.analyses.steady_acceleration import tensions_by_acceleration
from cablewright.foundation.errors import InputError, Status
from cablewright.models.inertia import mass_matrix
from cablewright.models.plane import within
from cablewright.robot import Eyelet, Robot, load
from cablewright.robot.parameters import Parameter, parameters_of
from cablewright.robot.winch import SharedWinch, Winch
from cablewright.solvers.parameter_effects import response
from cablewright.studies.design.measures import _cost
from cablewright.studies.design.problem import Prices
from oracles import linear_program
from physics.test_lines_out_of_plane import differences

GRAVITY = 9.81
POSES = {3: [0.4, -0.3, 1.2], 6: [0.4, -0.3, 1.6, 0.0, 0.0, 0.02]}
HUNG = {"merlet2023": 1, "jung2020": 2, "maslow4": 0, "cogiro": 5, "tilted": 3, "mounts": 6, "guides": 2}
AT = {"jung2020": [0.2, 0.1, 0.9], "maslow4": [0.3, 0.2, np.nan]}


def of(name: str) -> Robot:
    return out_of_plane.body(name) if name in ("tilted", "mounts", "guides") else load(name)


def hung(robot: Robot, index: int, mass: float, **own: Any) -> Robot:
    """The robot with a counterweight at one of its lines, as if read from a file."""
    lines = list(robot.lines)
    limits = (0.0, max(line.tension_limits[1] for line in lines))
    changes = {"counterweight": mass, "winch": Winch(), "tension_limits": limits} | own
    lines[index] = lines[index].model_copy(update=changes)
    return out_of_plane.checked(robot.model_copy(update={"lines": tuple(lines)}))


def at(name: str) -> list[float]:
    return AT.get(name, POSES[of(name).n])


def heavy(name: str) -> float:
    """A mass, kg, a little over the load of a winch there."""
    return 1.03 * float(cw.inverse(of(name), at(name)).checked().winch_tensions[HUNG[name]]) / GRAVITY


def held(name: str, cable: str = "catenary") -> cw.Equilibrium:
    return cw.inverse(hung(of(name), HUNG[name], heavy(name)), at(name), cable=cable).checked()


def straight(robot: Robot) -> Robot:
    """The robot with eyelets and without dead spans."""
    cut = {"sheave": Eyelet(), "winch_exit": None, "guides": (), "dead_length": 0.0}
    lines = tuple(line.model_copy(update=cut) for line in robot.lines)
    return out_of_plane.checked(robot.model_copy(update={"lines": lines}))


@pytest.mark.parametrize("cable", ["rigid", "elastic", "catenary"])
@pytest.mark.parametrize("name", HUNG)
def test_it_decides_the_tension_at_its_winch_end(name: str, cable: str) -> None:
    found = held(name, cable)
    line = found.model.robot.lines[HUNG[name]]
    assert found.winch_tensions[HUNG[name]] == pytest.approx(line.counterweight * GRAVITY / line.cables, rel=1e-10)
    assert found.is_valid()


@pytest.mark.parametrize("cable", ["elastic", "catenary"])
@pytest.mark.parametrize("name", HUNG)
def test_poses_are_found_again_and_as_with_a_winch_that_holds_as_much(name: str, cable: str) -> None:
    """Whatever is given as the length of its line; and a winch that pays that length out holds the same pose."""
    found = held(name, cable)
    for guess in (found.pose, None) if found.model.n == 3 else (found.pose,):
        for other in (np.nan, 1.0, 1e3):
            lengths = found.lengths.copy()
            lengths[HUNG[name]] = other
            again = cw.forward(found.model.robot, lengths, cable=cable, guess=guess).checked()
            np.testing.assert_allclose(again.pose, found.pose, atol=1e-8)
            np.testing.assert_allclose(again.lengths, found.lengths, atol=1e-9)
    plain = of(name)
    winched = cw.forward(plain, found.lengths, cable=cable, guess=found.pose).checked()
    np.testing.assert_allclose(winched.pose, found.pose, atol=2e-8)
    np.testing.assert_allclose(winched.tensions, found.tensions, rtol=1e-6)


@pytest.mark.parametrize(("advantage", "cables"), [(1, 1), (2, 1), (2, 3)])
def test_the_platform_rests_where_the_energy_is_stationary(advantage: int, cables: int) -> None:
    """Straight lines: strain energy of three of them, and the heights of platform and counterweight."""
    robot = straight(load("merlet2023"))
    robot = hung(robot, 1, 25.0 / advantage, advantage=advantage, cables=cables)
    lengths = cw.inverse(robot, POSES[3], cable="elastic").checked().lengths - [0.01, 0.0, 0.02, -0.01]
    exits = np.array([line.exit_point for line in robot.lines])
    hard = np.array([line.cable.stiffness for line in robot.lines])

    def slope(place: np.ndarray) -> np.ndarray:
        away = place - exits
        chord = np.linalg.norm(away, axis=1)
        pulls = hard * (chord - lengths) / lengths
        pulls[1] = advantage * robot.lines[1].counterweight * GRAVITY  # of a mass that rises by so many chords
        return (pulls / chord) @ away + [0.0, 0.0, robot.platform.mass * GRAVITY]

    found = cw.forward(robot, lengths, cable="elastic").checked()
    there = root(slope, found.pose + 0.01, tol=1e-13)
    np.testing.assert_allclose(found.pose, there.x, atol=1e-8)
    assert found.lengths[1] == pytest.approx(
        advantage * np.linalg.norm(there.x - exits[1]) / (1.0 + found.tensions[1] / hard[1]), abs=1e-9
    )


@pytest.mark.parametrize("name", ["merlet2023", "cogiro"])
def test_each_yes_and_no_is_that_of_an_lp(name: str) -> None:
    robot = straight(of(name))
    robot = hung(robot, HUNG[name], heavy(name))
    rng, answers = np.random.default_rng(11), []
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    for _ in range(60):
        pose = np.concatenate([rng.uniform(low, high), 0.15 * rng.normal(size=3)])[: robot.n]
        found = cw.inverse(robot, pose, cable="elastic")
        chords = np.array([line.exit_point for line in robot.lines]) - found.platform_points
        units = chords / np.linalg.norm(chords, axis=1)[:, None]
        needed, matrix = np.array([0.0, 0.0, robot.platform.mass * GRAVITY]), units
        if robot.n == 6:
            arms = found.platform_points - pose[:3]
            matrix = np.hstack([units, np.cross(arms, units)])
            offset = Rotation.from_rotvec(pose[3:]).apply(robot.platform.centre_of_mass)
            needed = np.concatenate([needed, np.cross(offset, needed)])
        bounds = [
            2 * (line.counterweight * GRAVITY,) if line.counterweight else line.tension_limits for line in robot.lines
        ]
        lp = linprog(np.zeros(robot.m), A_eq=matrix.T, b_eq=needed, bounds=bounds)
        if found.status in (Status.OK, Status.INFEASIBLE):
            assert (found.status is Status.OK) == (lp.status == 0), pose
            answers.append(found.status)
        else:
            assert found.status is Status.UNSTABLE
    assert len(set(answers)) == 2
    assert len(answers) > 40


@pytest.mark.parametrize("name", ["merlet2023", "cogiro", "jung2020"])
def test_margins_are_those_of_an_lp(name: str) -> None:
    """Of the distances of all tensions from their limits, that of the counterweight's line among them."""
    robot, index = hung(straight(of(name)), HUNG[name], heavy(name)), HUNG[name]
    low, high = np.transpose([line.tension_limits for line in robot.lines])
    given, row = robot.lines[index].counterweight * GRAVITY, np.eye(robot.m)[index]
    poses = scattered(robot, 25)
    found = cw.tension_distribution(robot, poses, "exact")
    for one, pose in zip(found, poses, strict=True):
        A, w = linear_program.structure(robot, pose)
        best = linear_program.margin(np.vstack([A, row]), np.r_[w, -given], low, high)
        assert one.margin == pytest.approx(best, rel=1e-8, abs=1e-8)
        if np.isfinite(best):
            np.testing.assert_allclose(A @ one.tensions, -w, atol=1e-8 * abs(w).max())
            assert one.tensions[index] == pytest.approx(given)
    least = cw.tension_distribution(robot, poses)
    np.testing.assert_array_equal(least.feasible, found.margin >= 0.0)
    assert len(set(least.feasible)) == 2


@pytest.mark.parametrize("name", HUNG)
def test_the_least_tensions_are_those_of_the_inverse_problem(name: str) -> None:
    robot = hung(of(name), HUNG[name], heavy(name))
    held = cw.inverse(robot, at(name), cable="rigid").checked()
    found = cw.tension_distribution(robot, held.pose)
    np.testing.assert_allclose(found.tensions, held.tensions, rtol=1e-7)
    full = cw.tension_distribution(robot, held.pose, cw.Quadratic(np.eye(robot.m)))
    np.testing.assert_allclose(full.tensions, held.tensions, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("name", ["merlet2023", "cogiro", "jung2020"])
def test_capacity_is_that_of_a_winch_with_hardly_any_room(name: str) -> None:
    robot, index = hung(of(name), HUNG[name], heavy(name)), HUNG[name]
    given = robot.lines[index].counterweight * GRAVITY
    lines = list(robot.lines)
    lines[index] = lines[index].model_copy(update={"counterweight": None, "tension_limits": (given, given + 1e-9)})
    winched = robot.model_copy(update={"lines": tuple(lines)})
    poses = scattered(robot, 25)
    one, other = cw.capacity(robot, poses).margin, cw.capacity(winched, poses).margin
    np.testing.assert_allclose(np.maximum(one, 0.0), np.maximum(other, 0.0), rtol=1e-7, atol=1e-6)
    np.testing.assert_array_equal(one >= 0.0, other >= -1e-6)  # outside there are more facets to be measured from
    others = robot.model_copy(update={"lines": tuple(line for line in robot.lines if line.counterweight is None)})
    closed, without = cw.wrench_closure(robot, poses), cw.wrench_closure(others, poses)
    np.testing.assert_array_equal(closed.margin, without.margin)
    np.testing.assert_array_equal(closed.code, without.code)
    known = np.isfinite(closed.margin)
    assert (closed.tensions[known, index] == 0.0).all()


def test_limits_that_a_counterweight_exceeds_hold_nowhere() -> None:
    robot = hung(of("merlet2023"), 1, 12.0)
    limits = (130.0, 500.0)
    assert cw.tension_distribution(robot, POSES[3], "exact", tension_limits=limits).margin <= 12.0 * GRAVITY - 130.0
    for found in (
        cw.tension_distribution(robot, POSES[3], tension_limits=limits),
        cw.capacity(robot, POSES[3], tension_limits=limits),
    ):
        assert Status.of(found.code) is Status.INFEASIBLE


def test_a_counterweight_narrows_the_workspace_as_an_lp_has_it() -> None:
    robot = hung(straight(load("merlet2023")), 1, 12.0)
    found = cw.workspace(robot, tolerance=0.02)
    poses = scattered(robot, 400)
    held = cw.tension_distribution(robot, poses).feasible
    share = held.mean()
    assert 0.05 < share < 0.95
    assert found.fraction == pytest.approx(share, abs=4.0 * np.sqrt(share * (1.0 - share) / 400))


def scattered(robot: Robot, count: int) -> np.ndarray:
    """Random poses in the frame, little turned, in the plane if there is one."""
    rng = np.random.default_rng(12)
    places = rng.uniform(robot.scene.frame_min, robot.scene.frame_max, (count, 3))
    poses = np.hstack([places, 0.1 * rng.normal(size=(count, 3))])[:, : robot.n]
    return within(robot.platform.plane, poses)


@pytest.mark.parametrize("name", HUNG)
def test_motions_are_differences(name: str) -> None:
    found = held(name)
    model, line = found.model, found.model.robot.lines[HUNG[name]]
    other = model.robot.lines[HUNG[name] - 1].name
    steps = {"counterweight": 1e-2, "modulus": 1e-3, "exit_point.x": 1e-4, "exit_point.z": 1e-4, "linear_density": 1e-4}
    for kind, step in steps.items():
        parameter = Parameter(kind, line.name)
        apart = differences(model, found, parameter, step)
        motion = response(found[None], [parameter])[0, :, 0]
        np.testing.assert_allclose(motion, apart, rtol=5e-5, atol=5e-6 * max(np.abs(apart).max(), 1e-6), err_msg=kind)
    apart = differences(model, found, Parameter("length_offset", other), 1e-6)
    motion = response(found[None], [Parameter("length_offset", other)])[0, :, 0]
    np.testing.assert_allclose(motion, apart, rtol=5e-5, atol=5e-6 * np.abs(apart).max())


def test_its_line_is_no_spring() -> None:
    """The platform is held by the others along its cable; lengths alone say nothing of it."""
    found = held("merlet2023")
    parts = cw.modes(found).stiffness
    assert abs(parts.axial[1]) < 1e-3 * parts.axial[[0, 2, 3]].min()
    robot = found.model.robot
    winched = [line.name for line in robot.lines if line.counterweight is None]
    assert [one.line for one in parameters_of(robot, "length_offset")] == winched
    with pytest.raises(InputError, match="has a counterweight and no winch"):
        parameters_of(robot, "length_offset", [robot.lines[1].name])
    with pytest.raises(InputError, match="has no counterweight"):
        parameters_of(robot, "counterweight")
    shared = response(found[None], [Parameter("length_scale")])[0, :, 0]
    each = response(found[None], list(parameters_of(robot, "length_scale")))[0].sum(axis=-1)
    np.testing.assert_allclose(shared, each, rtol=1e-12)
    expands = [
        line.model_copy(update={"cable": line.cable.model_copy(update={"thermal_expansion": 1e-5})})
        for line in robot.lines
    ]
    warm = cw.inverse(robot.model_copy(update={"lines": tuple(expands)}), found.pose).checked()
    moved = response(warm[None], [Parameter("temperature")])[0, :, 0]
    np.testing.assert_allclose(moved, 1e-5 * each, rtol=1e-9)


def test_it_swings_along() -> None:
    """Frequencies by the energies of platform and counterweight, whose cable does not stretch."""
    robot = hung(straight(load("merlet2023")), 1, 12.0, advantage=2)
    found = cw.inverse(robot, POSES[3], cable="elastic").checked()
    matrix = cw.linearise(found).stiffness
    away = found.pose - np.array(robot.lines[1].exit_point)
    rises = 2.0 * away / np.linalg.norm(away)
    masses = mass_matrix(robot, found.pose) + 12.0 * np.outer(rises, rises)
    values = np.sort(np.linalg.eigvals(np.linalg.solve(masses, matrix)).real)
    found_modes = cw.modes(found)
    np.testing.assert_allclose((2 * np.pi * found_modes.frequencies) ** 2, values, rtol=1e-9)
    shares = found_modes.participation.sum(axis=0)
    assert (shares <= 1.0 + 1e-12).all()
    moved = rises @ found_modes.shapes
    np.testing.assert_allclose(1.0 - shares, 12.0 * moved**2, atol=1e-12)


def test_acceleration_takes_it_along() -> None:
    robot = hung(straight(load("merlet2023")), 1, 25.0)
    found = cw.inverse(robot, POSES[3], cable="elastic").checked()[None]
    linear = cw.linearise(found)
    away = found.pose[0] - np.array(robot.lines[1].exit_point)
    rises = away / np.linalg.norm(away)
    none, upwards = np.zeros(1), np.array([[0.0, 0.0, 2.0]])
    effects = PathSwing(found.model).take(found, found.ok, linear, none, none, upwards)
    push = robot.platform.mass * np.array([0.0, 0.0, 2.0]) + 25.0 * rises * (rises @ [0.0, 0.0, 2.0])
    moved = -np.linalg.solve(linear.stiffness[0], push)
    assert effects.displacement[0] == pytest.approx(np.linalg.norm(moved), rel=1e-9)
    assert tensions_by_acceleration(found, linear)[0, 1] == pytest.approx(25.0, rel=1e-9)


def test_fewer_winches_than_degrees_of_freedom_leave_coordinates_free() -> None:
    """Two winches and two counterweights hold a point: two coordinates are given, and gravity decides the third."""
    robot = hung(hung(straight(load("merlet2023")), 1, 20.0), 3, 20.0)
    with pytest.raises(
        InputError, match="4 lines on 2 winches hold 2 of the 3 degrees of freedom; 3 are given: leave 1 free"
    ):
        cw.inverse(robot, POSES[3])
    found = cw.inverse(robot, [0.4, np.nan, 1.2]).checked()
    assert found.is_valid()
    assert found.pose[[0, 2]] == pytest.approx([0.4, 1.2], abs=1e-12)
    assert found.winch_tensions[[1, 3]] == pytest.approx(20.0 * GRAVITY, rel=1e-9)
    again = cw.forward(robot, np.where([0, 1, 0, 1], np.nan, found.lengths), guess=found.pose)
    np.testing.assert_allclose(again.pose, found.pose, atol=1e-8)
    plain = load("grab-four-lines")
    first = cw.inverse(plain, [0.0, 0.1, plain_height(plain), np.nan, np.nan, 0.0]).checked()
    body = hung(plain, 1, float(first.winch_tensions[1]) / GRAVITY)
    free = cw.inverse(body, [*first.pose[:3], np.nan, np.nan, np.nan]).checked()
    assert free.is_valid()
    assert free.winch_tensions[1] == pytest.approx(first.winch_tensions[1], rel=1e-9)


def plain_height(robot: Robot) -> float:
    return float(np.mean([robot.scene.frame_min[2], robot.scene.frame_max[2]]))


def test_one_too_light_for_its_own_cable_is_no_formula_s_fault() -> None:
    """A heavy cable that its counterweight cannot hold up: no pose there is one."""
    robot = load("merlet2023")
    heavy = {"cable": robot.lines[1].cable.model_copy(update={"linear_density": 1.0})}
    found = cw.inverse(hung(robot, 1, 0.05, **heavy), POSES[3])
    assert found.status is Status.INFEASIBLE
    assert found.violation > 0.0


def test_what_does_not_cover_it_says_so(tmp_path: Path) -> None:
    found = held("merlet2023")
    robot = found.model.robot
    with pytest.raises(InputError, match="counterweight"):
        cw.let_out(robot, found.lengths, robot.lines[1].name, 0.01)
    text = (Path(cw.robot.__file__).parent / "library" / "merlet2023.toml").read_text()
    for lines, why in (
        ('counterweight = "0 kg"', "greater than 0"),
        ('counterweight = "2 N"', "unit one of"),
        ('counterweight = "1 kg"', "at least one with a winch"),
    ):
        (tmp_path / "bad.toml").write_text(text.replace("[line]", f"[line]\n{lines}", 1))
        with pytest.raises(InputError, match=why):
            load(tmp_path / "bad.toml")
    for own, why in (
        ({"tension_limits": (1.0, 200.0)}, "245.25 N, which must be within its tension_limits, 1 to 200 N"),
        ({"winch": Winch(drum_radius=0.05)}, "winch: is not for a line with a counterweight"),
        ({"spring": 1e4}, "spring: has no effect"),
    ):
        with pytest.raises(ValueError, match=why):
            hung(load("merlet2023"), 1, 25.0, **own)
    with pytest.raises(ValueError, match="counterweight: is for lines without a universal joint"):
        hung(load("paty2021"), 1, 25.0)
    first, *others = hung(load("merlet2023"), 1, 25.0).lines
    shared = first.model_copy(update={"shared_winch": SharedWinch(line="south-east")})
    with pytest.raises(ValueError, match="'south-east' has a counterweight, and no winch"):
        out_of_plane.checked(load("merlet2023").model_copy(update={"lines": (shared, *others)}))


def test_a_check_and_costs_know_that_it_has_no_winch(tmp_path: Path) -> None:
    (tmp_path / "part.gcode").write_text("G21\nG90\nM82\nG1 X0 Y0 Z1 F300\nG1 X5 Y0 E1 F300\nG1 X5 Y5 E2\n")
    job = 'schema = 1\nname = "part"\ngcode = "part.gcode"\norigin = [0.0, 0.0, 1.0]\n'
    job += '[bead]\nwidth = "60 mm"\nheight = "20 mm"\n[sampling]\nstep = "5 mm"\n'
    (tmp_path / "part.toml").write_text(job)
    plain = load("merlet2023")
    middle = plain.lines[0].model_copy(
        update={"name": "middle", "exit_point": (0.0, 0.0, 4.0), "winch_exit": None, "sheave": Eyelet()}
    )
    robot = hung(plain.model_copy(update={"lines": (*plain.lines, middle)}), 4, 30.0)
    found = cw.check(robot, tmp_path / "part.toml")
    assert found.feasible
    said = "line 'middle' has a counterweight: counterweights against what is around them, and the room they move in"
    assert said in found.not_checked
    assert not any("middle" in each for each in found.not_checked if "winch" in each)
    torques = found.statics.lines.winch_torque
    assert np.isfinite(torques[:, :4]).all()
    assert np.isnan(torques[:, 4]).all()
    of = SimpleNamespace(
        robot=robot, prices=Prices(winch=7.0, torque=10.0), held=found.statics,
        lines=SimpleNamespace(winch_torque=[[3.0, 2.0, 1.0, 1.0, np.nan]]),
    )  # fmt: skip
    assert _cost(of) == 4 * 7.0 + 10.0 * 7.0  # type: ignore[arg-type]
