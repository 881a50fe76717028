"""Slack lines of robots in planes, with counterweights, over guides of any kind, and on common drums."""

from __future__ import annotations

from functools import cache
from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import root

import cablewright as cw
import cases
import out_of_plane
import planar_robots
from cablewright.foundation.errors import InputError, Status
from cablewright.kernels import batches
from cablewright.models.packed_views import LineStates, blank_states
from cablewright.models.shared_winches import missed_lengths
from cablewright.robot import Eyelet, Robot, load
from cablewright.robot.winch import Winch
from cablewright.solvers.one_line import LoneLine, taut_lengths
from cablewright.solvers.slack import angle_from_excess, excess_from_angle, excess_lengths
from cablewright.solvers.tension import structures
from physics.test_shared_winches import parallelograms, shared
from solvers.test_slack import textbook_angle

BODY = np.array([0.4, -0.3, 1.6, 0.0, 0.0, 0.02])


def hung(robot: Robot, index: int, share: float, pose: np.ndarray) -> Robot:
    """The robot with a counterweight that pulls a *share* of a winch's tension there."""
    mass = share * float(cw.inverse(robot, pose).checked().winch_tensions[index]) / 9.81
    lines = list(robot.lines)
    changes = {"counterweight": mass, "winch": Winch(), "tension_limits": (0.0, robot.lines[index].tension_limits[1])}
    lines[index] = lines[index].model_copy(update=changes)
    return out_of_plane.checked(robot.model_copy(update={"lines": tuple(lines)}))


@cache
def robots() -> dict[str, tuple[Robot, np.ndarray]]:
    """A robot and a pose of each kind; limits from zero on, so that lines may be slack."""
    found = {kind: (out_of_plane.body(kind), BODY) for kind in ("tilted", "guides", "pulleys", "platform sheaves")}
    for plane in planar_robots.PLANES:
        for body in (False, True):
            robot = planar_robots.board(plane, body, force=(3.0, -2.0, 4.0))
            found[f"{plane} {'body' if body else 'point'}"] = robot, planar_robots.places(robot, 1)[0]
    cogiro = load("cogiro").limited((1.0, 1e4))
    found["counterweight"] = hung(cogiro, 5, 1.0, BODY), BODY
    return {name: (robot.limited((0.1, 1e4)) if robot.n == 6 else robot, pose) for name, (robot, pose) in found.items()}


IN_PLANE = [f"{plane} {kind}" for plane in planar_robots.PLANES for kind in ("point", "body")]
KINDS = ["tilted", "guides", "pulleys", "platform sheaves", *IN_PLANE, "counterweight"]


@pytest.mark.parametrize("kind", KINDS)
def test_sets_of_slack_lines_are_those_whose_others_balance(kind: str) -> None:
    """Straight lines without weight: each set is a system of linear equations."""
    robot, pose = robots()[kind]
    model = cw.Model.of(robot, cable=("rigid", "elastic")[KINDS.index(kind) % 2])
    A, w = (each[0] for each in structures(model, pose))
    given, limits = model.lines.counterweight, model.lines.tension_limits
    winched = np.flatnonzero(given == 0.0)
    held = {}
    for taut in combinations(winched, robot.freedoms):
        tensions, *_ = np.linalg.lstsq(A[:, taut], -w - A @ given, rcond=None)
        if (tensions >= limits[list(taut), 0]).all() and (tensions <= limits[list(taut), 1]).all():
            slack = tuple(robot.lines[i].name for i in winched if i not in taut)
            held[slack] = tensions
    found = {each.slack: each for each in cw.slack_sets(model, pose)}
    assert set(found) == set(held)
    assert held or kind == "counterweight"
    for slack, tensions in held.items():
        taut = [i for i in winched if robot.lines[i].name not in slack]
        np.testing.assert_allclose(found[slack].tensions[taut], tensions, rtol=1e-6)
        np.testing.assert_allclose(found[slack].tensions[given > 0.0], given[given > 0.0], rtol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_the_lengths_found_bring_the_platform_back(kind: str) -> None:
    robot, pose = robots()[kind]
    answered = 0
    for line in robot.lines:
        if line.counterweight is not None or answered == 2:
            continue
        found = cw.solve_with_slack(robot, pose, {line.name: 0.03})
        if not found.ok:
            continue
        assert found.is_valid()
        index = [each.name for each in robot.lines].index(line.name)
        assert excess_lengths(found)[index] == pytest.approx(0.03, abs=1e-11)
        back = cw.forward(robot, found.lengths, guess=found.pose).checked()
        np.testing.assert_allclose(back.pose, found.pose, atol=2e-8)
        np.testing.assert_allclose(back.tensions, found.tensions, rtol=1e-5, atol=1e-5)
        answered += 1
    assert answered > 0


def stiff(robot: Robot) -> Robot:
    """The robot with cables that hardly stretch."""
    cable = robot.lines[0].cable.model_copy(update={"axial_stiffness": 1e12, "young_modulus": None})
    return robot.model_copy(update={"lines": tuple(line.model_copy(update={"cable": cable}) for line in robot.lines)})


def test_a_line_behind_guides_hangs_as_a_textbook_catenary() -> None:
    robot = stiff(out_of_plane.body("guides"))
    model, line = cw.Model(robot), robot.lines[0]
    away = BODY[:3] + cw.inverse(robot, BODY).platform_points[0] - BODY[:3] - np.array(line.exit_point)
    x, z = float(np.hypot(*away[:2])), float(away[2])
    for excess in (0.01, 0.2):
        angle = angle_from_excess(model, BODY, line.name, 0.2, excess)
        assert angle == pytest.approx(textbook_angle(x, z, float(np.hypot(x, z)) + excess, 0.2), abs=1e-6)
    plain = line.model_copy(update={"winch_exit": None, "guides": (), "sheave": Eyelet()})
    alone = cw.Model(robot.model_copy(update={"lines": (plain, *robot.lines[1:])}))
    (limit, ended), (other, also) = (LoneLine(each, BODY[None], 0).max_excess() for each in (model, alone))
    assert ended == also == "floor"
    assert limit == pytest.approx(other, rel=1e-6)


def test_a_long_dead_span_pulls_the_slack_back_over_its_guides() -> None:
    """At the largest excess the straight dead span carries its own weight, and its lower end nothing."""
    robot = out_of_plane.body("guides")
    line = robot.lines[0].model_copy(update={"winch_exit": tuple(np.subtract(robot.lines[0].exit_point, [0, 0, 12]))})
    model = cw.Model(robot.model_copy(update={"lines": (line, *robot.lines[1:])}))
    lone = LoneLine(model, BODY[None], 0)
    limit, ended = lone.max_excess()
    assert ended == "sheave"
    (code, y), (beyond, _) = lone.hung(limit), lone.hung(1.01 * limit)
    assert (code, Status.of(beyond)) == (0, Status.NOT_CONVERGED)
    tension, dead = float(LineStates(y).tension), float(LineStates(y).dead_length)
    assert tension + lone.numbers.weight * dead * lone.numbers.winch_rise == pytest.approx(0.0, abs=1e-4 * tension)


@pytest.mark.parametrize("kind", ["tilted", "aside", "pulleys", "platform sheaves", "platform pulleys", "wheels"])
def test_an_angle_has_its_excess(kind: str) -> None:
    robot = out_of_plane.body(kind)
    model = cw.Model(robot)
    for line in robot.lines[:3]:
        angle = float(angle_from_excess(model, BODY, line.name, 0.1, 0.02))
        assert excess_from_angle(model, BODY, line.name, 0.1, angle) == pytest.approx(0.02, rel=1e-6)


@cache
def on_drums() -> tuple[Robot, np.ndarray]:
    """A point on six lines of five winches, of elastic cables, the tensions of all of them over zero there."""
    robot, pose = cases.six_lines().limited((0.1, 5e3)), np.array([0.3, -0.8, 1.5])
    lengths = cw.inverse(robot, pose, cable="elastic").checked().lengths
    return shared(robot, (1, 0, float(lengths[1] - lengths[0]) + 1e-4, "along")), pose


def test_sets_of_drums_are_those_whose_others_balance() -> None:
    """By the lengths of three winches: each set is a system of three equations in them."""
    robot, pose = on_drums()
    model = cw.Model.of(robot, cable="elastic")
    A, w = (each[0] for each in structures(model, pose))
    lengths = cw.inverse(robot, pose, cable="elastic", preferred=np.full(6, 100.0)).checked().lengths
    share = robot.lines[1].shared_winch
    held = {}
    for hosts in combinations((0, 2, 3, 4, 5), 3):
        taut = [i for i in range(6) if i in hosts or (i == 1 and 0 in hosts)]

        def tensions(paid: np.ndarray, hosts: tuple[int, ...] = hosts, taut: list[int] = taut) -> np.ndarray:
            every = dict(zip(hosts, paid, strict=True))
            own = [every[i] if i in every else every[0] + share.offset for i in taut]
            found = np.zeros(6)
            found[taut] = [straight_tension(robot, pose, i, length) for i, length in zip(taut, own, strict=True)]
            return found

        met = root(lambda paid, t=tensions: A @ t(paid) + w, lengths[list(hosts)], tol=1e-13)
        found = tensions(met.x)
        if np.abs(A @ found + w).max() < 1e-6 and (found[taut] >= 0.1).all() and (found[taut] <= 5e3).all():
            held[tuple(robot.lines[i].name for i in range(6) if i not in taut)] = found
    found_sets = {each.slack: each for each in cw.slack_sets(model, pose)}
    assert set(found_sets) == set(held)
    assert any(len(slack) == 3 for slack in held)
    assert any(len(slack) == 2 for slack in held)
    for slack, expected in held.items():
        np.testing.assert_allclose(found_sets[slack].tensions, expected, rtol=1e-6, atol=1e-6)


def straight_tension(robot: Robot, pose: np.ndarray, index: int, length: float) -> float:
    """Tension of a straight elastic line of an unstrained *length*, by bisection over its own length at a tension."""
    alone = cw.Model.of(robot, cable="elastic")
    taut = float(taut_lengths(alone.rows(), pose[None])[0, index])
    line = robot.lines[index]
    rigid = 0.0 if line.dead_elastic else float(np.linalg.norm(np.subtract(line.winch_exit, line.exit_point)))
    arc = 0.0
    if not line.arc_elastic:
        drawn = LineStates(straight_states(alone, pose)[0, index])
        dead = float(np.linalg.norm(np.subtract(line.winch_exit, line.exit_point)))
        arc = taut - float(drawn.free_length) - dead
    still = rigid + arc
    return line.cable.stiffness * ((taut - still) / (length - still) - 1.0)


def straight_states(model: cw.Model, pose: np.ndarray) -> np.ndarray:
    """States (1, m, 6) of straight lines."""
    states = blank_states(1, model.m)
    batches.shape_rows(model.rows(), pose[None], np.full((1, model.m), np.nan), states)
    return states


@pytest.mark.parametrize("cable", ["elastic", "catenary"])
@pytest.mark.parametrize("index", [0, 1, 4])
def test_slack_lines_and_their_drums_bring_the_platform_back(cable: str, index: int) -> None:
    robot, pose = on_drums()
    found = cw.solve_with_slack(robot, pose, {index: 0.02}, cable=cable).checked()
    share = robot.lines[1].shared_winch
    assert found.lengths[1] == pytest.approx(found.lengths[0] + share.offset, abs=1e-9)
    assert excess_lengths(found)[index] == pytest.approx(0.02, abs=1e-9)
    back = cw.forward(robot, found.lengths, guess=found.pose, cable=cable).checked()
    np.testing.assert_allclose(back.pose, found.pose, atol=2e-8)
    np.testing.assert_allclose(back.tensions, found.tensions, rtol=1e-5, atol=1e-5)


def test_a_drum_has_one_excess() -> None:
    robot, pose = on_drums()
    with pytest.raises(InputError, match="its drum is that of 'line 0', which decides it: leave it out"):
        cw.solve_with_slack(robot, pose, {0: 0.1, 1: 0.1})
    with pytest.raises(InputError, match=r"3 winches hold .*, which has 5: at most 2 can be slack"):
        cw.solve_with_slack(robot, pose, {0: 0.1, 2: 0.1, 3: 0.1})


def test_a_drum_lets_out_all_its_lines() -> None:
    robot = parallelograms(4)
    held = cw.inverse(robot, [0.0, 0.0, 1.0, np.nan, np.nan, np.nan]).checked()
    before = missed_lengths(robot, held.lengths)
    found = cw.let_out(robot, held.lengths, robot.sharing[0].name, [0.0, 0.002])
    moved = found.lengths - held.lengths
    np.testing.assert_allclose(missed_lengths(robot, found.lengths), np.tile(before, (2, 1)), atol=1e-14)
    assert (np.abs(moved[1]) > 1e-3).sum() == 2
    assert found.ok.all()


def test_a_counterweight_is_never_slack() -> None:
    robot, pose = robots()["counterweight"]
    for asked in (
        lambda: cw.solve_with_slack(robot, pose, {5: 0.1}),
        lambda: angle_from_excess(cw.Model(robot), pose, 5, 0.1, 0.1),
        lambda: cw.let_out(robot, cw.inverse(robot, pose).lengths, 5, 0.1),
    ):
        with pytest.raises(InputError, match="has a counterweight instead of a winch"):
            asked()
