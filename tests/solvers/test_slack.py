"""Slack lines: balance, excess there and back, the hanging shape against a textbook catenary, Merlet's figures."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
from mpmath import mp

import cases
from cablewright.foundation.errors import AnswerError, InputError, Status
from cablewright.kernels import layout
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.statics import Model
from cablewright.robot import Eyelet, Robot, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise
from cablewright.solvers.one_line import line_index
from cablewright.solvers.slack import (
    angle_from_excess,
    excess_from_angle,
    excess_lengths,
    let_out,
    slack_sets,
    solve_with_slack,
    tangent_angle,
)
from oracles import machine

MERLET = Model(load("merlet2023"))
POSE = [0.0, -1.0, 1.0]
FAR = "north-west"
COGIRO = Model(load("cogiro"))
BODY = [3.0, 3.0, 2.0, 0.0, 0.0, 0.0]
SENSOR = 0.2  # m from the platform point
SPARE = [model for model in cases.models(*CableLaw) if model.m > model.n]
AS_BUILT = [Model(robot) for robot in cases.robots() if robot.m > robot.n]
SAGGING = [model for model in SPARE if model.fidelity.cable is CableLaw.CATENARY]
SUSPENDED = [model for model in SAGGING if model.robot.name != "ipanema"]  # six of its lines hold nothing within limits


def first_slack(model: Model, pose: np.ndarray, excess: float) -> list[tuple[int, ...]]:
    """Single lines, of a body pairs, that can be slack at *pose*; of a body that lines pull down too, single ones."""
    for count in (1,) if model.n == 3 else (2, 1):
        tried = combinations(range(model.m), count)
        found = [each for each in tried if solve_with_slack(model, pose, dict.fromkeys(each, excess)).ok]
        if found:
            return found
    return []


def span_model(elevation: float, length: float = 2.5) -> tuple[Model, list[float]]:
    """A line of merlet2023 through a ring, and a place *length* from it that the line falls to at *elevation* (rad)."""
    line = MERLET.robot.lines[0].model_copy(update={"sheave": Eyelet(), "winch_exit": None})
    x, y, z = line.exit_point
    place = [x + length * math.cos(elevation), y, z - length * math.sin(elevation)]
    return Model(MERLET.robot.model_copy(update={"lines": (line,)})), place


def textbook_angle(x: float, z: float, length: float, distance: float) -> float:
    """Tangent (rad) of an inextensible catenary over (x, z), *distance* before its end, with 30 digits.

    y = a cosh((s - b) / a): 2 a sinh(x / 2 a) = sqrt(L^2 - z^2), the middle at b + a atanh(z / L).
    """
    with mp.workdps(30):
        flat = mp.sqrt(mp.mpf(length) ** 2 - mp.mpf(z) ** 2)
        ratio = flat / x
        u = mp.findroot(lambda u: mp.sinh(u) / u - ratio, mp.sqrt(6 * (ratio - 1)))
        a = x / (2 * u)
        end = mp.sinh(mp.atanh(mp.mpf(z) / length) + u)  # slope at the end; the arc from the lowest point is a times it
        return float(mp.atan(end - distance / a))


# --- excess


@pytest.mark.parametrize("model", SPARE, ids=cases.name)
def test_excess_is_the_length_over_that_of_a_rigid_line(model: Model) -> None:
    held = cases.poses(model, 4)
    rigid = solve_inverse(Model(model.robot, Fidelity(CableLaw.RIGID, model.fidelity.sheave)), held.pose)
    ok = rigid.ok
    assert ok.any()
    excess = excess_lengths(held)[ok] - (held.lengths - rigid.lengths)[ok]
    # on a lever rigid lines differ by the lever's weight, which the excess leaves out
    has_lever = (model.packed.lines[:, layout.UNKNOWNS] == 6).any()
    np.testing.assert_allclose(excess, 0.0, atol=1e-3 if has_lever else 1e-8)
    if model.fidelity.cable is CableLaw.RIGID and not has_lever:
        np.testing.assert_allclose(excess_lengths(held), 0.0, atol=1e-12)


def test_excess_of_an_elastic_line_is_its_stretch() -> None:
    model = Model(cases.replaced(MERLET.robot, "rings", sheave=Eyelet(), winch_exit=None), Fidelity(CableLaw.ELASTIC))
    held = solve_inverse(model, POSE)
    stiffness = model.robot.lines[0].cable.stiffness
    np.testing.assert_allclose(excess_lengths(held), -held.lengths * held.tensions / stiffness, rtol=1e-10)


def test_excess_of_a_batch_is_that_of_its_rows() -> None:
    held = solve_inverse(MERLET, [POSE, [1.0, 2.0, 0.5], [9.0, 0.0, 1.0]])
    excess = excess_lengths(held)
    assert excess.shape == (3, 4)
    for row in range(3):
        np.testing.assert_array_equal(excess_lengths(held[row]), excess[row])
    assert np.isnan(excess[2]).all()


# --- the pose held with slack lines


@pytest.mark.parametrize("excess", [1e-3, pytest.param(0.05, marks=pytest.mark.slow), 0.3])
@pytest.mark.parametrize("model", SPARE, ids=cases.name)
def test_solutions_balance_and_have_the_requested_excess(model: Model, excess: float) -> None:
    answered = 0
    for pose in cases.poses(model, 2).pose:
        for slack in first_slack(model, pose, excess)[:2]:
            found = solve_with_slack(model, pose, dict.fromkeys(slack, excess))
            assert found.is_valid(1e-9)
            assert float(found.residual_norm()) <= 1e-9
            assert float(found.unbalanced_force()) <= 1e-9
            np.testing.assert_allclose(excess_lengths(found)[list(slack)], excess, atol=1e-11)
            low, high = found.extremes()
            taut = [i for i in range(model.m) if i not in slack]
            lines = [model.robot.lines[i] for i in taut]
            assert (low[taut] >= [line.tension_limits[0] - 1e-6 for line in lines]).all()
            assert (high[taut] <= [line.tension_limits[1] + 1e-6 for line in lines]).all()
            answered += 1
    assert answered > 0


@pytest.mark.parametrize("model", SAGGING, ids=cases.name)
def test_the_lengths_found_bring_the_platform_back(model: Model) -> None:
    pose = next(pose for pose in cases.poses(model, 6).pose if first_slack(model, pose, 0.05))
    found = solve_with_slack(model, pose, dict.fromkeys(first_slack(model, pose, 0.05)[0], 0.05))
    back = solve_forward(model, found.lengths, guess=pose + 0.01)
    assert back.status is Status.OK
    # slack lines leave some ways soft: what rounding moves along them
    np.testing.assert_allclose(back.pose, pose, atol=1e-8)
    np.testing.assert_allclose(back.tensions, found.tensions, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("model", AS_BUILT, ids=cases.name)
def test_an_independent_evaluation_agrees_that_it_balances(model: Model) -> None:
    pose = next(pose for pose in cases.poses(model, 6).pose if first_slack(model, pose, 0.05))
    found = solve_with_slack(model, pose, dict.fromkeys(first_slack(model, pose, 0.05)[0], 0.05))
    left = machine.balance(model.robot, found.lengths, found.pose, cases.line_states(found))
    assert left.geometry < 1e-9
    assert left.force < 1e-9 * model.robot.platform.mass * 9.81
    assert left.turning < 1e-8 * model.robot.platform.mass * 9.81


@pytest.mark.parametrize("cable", [CableLaw.RIGID, CableLaw.ELASTIC])
def test_a_massless_slack_line_is_as_good_as_none(cable: CableLaw) -> None:
    fidelity = Fidelity(cable)
    found = solve_with_slack(Model(MERLET.robot, fidelity), POSE, {FAR: 0.2})
    three = MERLET.robot.model_copy(update={"lines": MERLET.robot.lines[:3]})
    alone = solve_inverse(Model(three, fidelity), POSE)
    np.testing.assert_allclose(found.tensions[:3], alone.tensions, rtol=1e-12)
    np.testing.assert_allclose(found.lengths[:3], alone.lengths, rtol=1e-14)
    assert found.tensions[3] == found.platform_tensions[3] == 0.0
    assert found.is_valid()


def test_a_lighter_cable_tends_to_a_massless_one() -> None:
    def tensions(share: float) -> np.ndarray:
        line = MERLET.robot.lines[0].cable
        cable = line.model_copy(update={"linear_density": share * line.linear_density})
        return solve_with_slack(Model(cases.replaced(MERLET.robot, "light", cable=cable)), POSE, {FAR: 0.1}).tensions

    limit = solve_with_slack(Model(MERLET.robot, Fidelity(CableLaw.ELASTIC)), POSE, {FAR: 0.1}).tensions
    far, near = np.abs(tensions(1e-2) - limit).max(), np.abs(tensions(1e-3) - limit).max()
    assert near == pytest.approx(0.1 * far, rel=0.02)
    assert near < 2e-3


@pytest.mark.parametrize("name", ["south-west", "south-east", "north-east", "north-west"])
def test_as_the_excess_goes_the_taut_pose_comes_back(name: str) -> None:
    """A line with the excess that it has in a taut solution has that solution's tension, and so have the others."""
    sets = {each.slack: each for each in slack_sets(MERLET, [0.0, 0.0, 2.0])}
    taut = sets[(name,)].equilibrium
    assert excess_lengths(taut)[line_index(MERLET, name)] == 0.0
    steps = [
        np.abs(solve_with_slack(MERLET, [0.0, 0.0, 2.0], {name: excess}).tensions - taut.tensions).max()
        for excess in (1e-5, 1e-6, 1e-7)
    ]
    np.testing.assert_allclose(np.divide(steps[:-1], steps[1:]), 10.0, rtol=0.05)  # in proportion: no jump at 0
    # at no excess stretch and sag are equal: w^2 x^2 / 24 T^2 = T / EA of all that stretches
    assert 1.0 < taut.tensions[line_index(MERLET, name)] < 20.0


def test_without_slack_lines_it_is_the_inverse_problem() -> None:
    for limits in (None, (150.0, 1000.0)):
        model = Model(MERLET.robot, tension_limits=limits)
        found, plain = solve_with_slack(model, POSE, {}), solve_inverse(model, POSE)
        np.testing.assert_array_equal(found.tensions, plain.tensions)
        assert float(found.margin()) == float(plain.margin())


def test_a_mirrored_machine_has_the_mirrored_answer() -> None:
    west = solve_with_slack(MERLET, POSE, {"north-west": 0.3})
    east = solve_with_slack(MERLET, POSE, {"north-east": 0.3})
    np.testing.assert_allclose(east.tensions, west.tensions[[1, 0, 3, 2]], rtol=1e-12)
    np.testing.assert_allclose(east.lengths, west.lengths[[1, 0, 3, 2]], rtol=1e-14)


def test_rows_are_single_solves() -> None:
    poses = [POSE, [0.3, -1.2, 1.5], [9.0, 0.0, 1.0], [0.5, 1.0, 2.0]]
    rows = solve_with_slack(MERLET, poses, {FAR: 0.1})
    assert rows.lengths.shape == (4, 4)
    for row, pose in enumerate(poses):
        one = solve_with_slack(MERLET, pose, {3: 0.1})
        np.testing.assert_array_equal(one.lengths, rows.lengths[row])
        np.testing.assert_array_equal(one.states, rows.states[row])
        assert int(one.code) == rows.code[row]


def test_a_body_may_have_two_slack_lines() -> None:
    found = solve_with_slack(COGIRO, BODY, {0: 0.05, 1: 0.4}).checked()
    np.testing.assert_allclose(excess_lengths(found)[:2], [0.05, 0.4], atol=1e-12)
    back = solve_forward(COGIRO, found.lengths, guess=np.array(BODY) + 0.02).checked()
    np.testing.assert_allclose(back.pose, BODY, atol=1e-8)
    one = solve_with_slack(COGIRO, BODY, {0: 0.05}).checked()  # seven taut lines: of least norm
    assert np.linalg.norm(one.tensions[1:]) < np.linalg.norm(found.tensions[1:])


# --- Merlet, Papegay 2023, section II.C


@pytest.mark.parametrize(("excess", "slack", "largest"), [(0.01, 2.25, 363.5), (1.0, 0.26, 365.6)])
def test_merlets_slack_line(excess: float, slack: float, largest: float) -> None:
    """It prints 2.43 to 0.22 N and 369 N; its exit points are not known, so near is as good as it gets."""
    found = solve_with_slack(MERLET, POSE, {FAR: excess}).checked()
    assert found.platform_tensions[3] == pytest.approx(slack, abs=0.01)
    assert found.tensions.max() == pytest.approx(largest, abs=0.1)
    assert found.platform_tensions[3] == pytest.approx(2.43 if excess == 0.01 else 0.22, rel=0.2)
    assert found.tensions.max() == pytest.approx(369.0, rel=0.02)


def test_newton_on_forward_solves_finds_the_same_lengths() -> None:
    found = solve_with_slack(MERLET, POSE, {FAR: 0.3})
    lengths = solve_inverse(Model(MERLET.robot, Fidelity(CableLaw.RIGID)), POSE).lengths
    lengths[3] += 0.3
    for _ in range(10):
        hung = solve_forward(MERLET, lengths).checked()
        lengths[:3] -= np.linalg.solve(linearise(hung).per_length[:, :3], hung.pose - POSE)
    np.testing.assert_allclose(found.lengths, lengths, atol=1e-10)


# --- limits and statuses


def test_a_near_line_cannot_be_slack() -> None:
    found = solve_with_slack(MERLET, POSE, {"south-west": 0.1})
    assert found.status is Status.INFEASIBLE
    assert float(found.violation) == pytest.approx(91.9, abs=0.1)
    assert "a line would have to push" in found.sentence()
    assert np.isnan(found.lengths).all()


def test_a_slack_line_needs_no_lowest_tension_but_keeps_its_highest() -> None:
    lines = tuple(
        line.model_copy(update={"tension_limits": (5.0, 10.0)}) if line.name == FAR else line
        for line in MERLET.robot.lines
    )
    model = Model(MERLET.robot.model_copy(update={"lines": lines}))
    loose = solve_with_slack(model, POSE, {FAR: 1.0}).checked()
    assert 0.0 < float(loose.margin()) < 5.0
    tight = solve_with_slack(model, POSE, {FAR: 0.0})
    assert tight.status is Status.INFEASIBLE
    assert float(tight.violation) == pytest.approx(tight.extremes()[1][3] - 10.0)
    assert f"line {FAR} is {float(tight.violation):.4g} N above its maximum" in tight.sentence()


def test_the_sentence_of_a_no_speaks_of_a_taut_line() -> None:
    found = solve_with_slack(Model(MERLET.robot, tension_limits=(100.0, 1000.0)), POSE, {FAR: 0.3})
    assert found.status is Status.INFEASIBLE
    assert "line south-east is 28.13 N below its minimum, 100 N" in found.sentence()


@pytest.mark.parametrize(
    ("pose", "status"),
    [
        ([-2.5, 5.0, 1.0], Status.UNDER_EXIT),
        ([-2.48, 4.99, 4.03], Status.INSIDE_SHEAVE),
        ([0.0, 0.0, 20.0], Status.INFEASIBLE),
    ],
)
def test_a_pose_without_an_answer_says_why(pose: list[float], status: Status) -> None:
    found = solve_with_slack(MERLET, pose, {FAR: 0.1})
    assert found.status is status
    assert np.isnan(found.tensions).all()


def test_a_line_that_cannot_hold_its_dead_span_has_no_answer() -> None:
    house = Model(load("house-printer"))
    found = solve_with_slack(house, [3.0, 3.0, 10.0], {2: 0.4})
    assert found.status is Status.NOT_CONVERGED


# --- sets


def test_two_sets_hold_merlets_pose() -> None:
    sets = slack_sets(MERLET, POSE)
    assert [each.slack for each in sets] == [("north-east",), ("north-west",)]
    assert [each.taut[:2] for each in sets] == [("south-west", "south-east")] * 2
    for each in sets:
        assert (each.excess_low, each.ended_by) == (0.0, "floor")
        assert each.equilibrium.is_valid()
    assert sets[0].excess_high == pytest.approx(sets[1].excess_high, rel=1e-9)


@pytest.mark.parametrize("model", SUSPENDED, ids=cases.name)
def test_the_ends_of_a_range_are_ends(model: Model) -> None:
    found = next(sets for pose in cases.poses(model, 6).pose if (sets := slack_sets(model, pose)))
    for each in found:
        pose = each.equilibrium.pose

        def at(excess: float, names: tuple[str, ...] = each.slack, pose: np.ndarray = pose) -> Status:
            return solve_with_slack(model, pose, dict.fromkeys(names, excess)).status

        assert each.equilibrium.status is Status.OK
        assert at(each.excess_low) is at(each.excess_high) is Status.OK
        assert at(0.5 * (each.excess_low + each.excess_high)) is Status.OK
        if each.excess_low > 0.0:
            assert at(each.excess_low - 1e-6) is not Status.OK
        if each.ended_by in ("limits", "sheave"):
            assert at(each.excess_high + 1e-6) is not Status.OK


def test_where_the_floor_ends_a_range_the_line_touches_it() -> None:
    each = slack_sets(MERLET, POSE)[1]
    found = solve_with_slack(MERLET, POSE, {FAR: each.excess_high})
    phi, tau, free = found.states[3, :3]
    cable, line = MERLET.robot.lines[3].cable, MERLET.robot.lines[3]
    weight, h, v = cable.linear_density * 9.81, math.exp(tau) * math.cos(phi), math.exp(tau) * math.sin(phi)
    assert v < 0.0 < v + weight * free
    along = np.linspace(0.0, -v / weight, 20001)  # summed up: dz/ds = v (1/T + 1/EA)
    rise = v + weight * along
    slope = rise * (1.0 / np.hypot(h, rise) + 1.0 / cable.stiffness)
    lowest = line.exit_point[2] + 0.0375 * math.cos(phi) + np.trapezoid(slope, along)
    assert lowest == pytest.approx(0.0, abs=1e-6)


def test_ranges_without_weight_end_where_the_drum_does() -> None:
    elastic = slack_sets(Model(MERLET.robot, Fidelity(CableLaw.ELASTIC)), POSE)
    assert [each.ended_by for each in elastic] == ["capacity"] * 2
    taut = solve_inverse(Model(MERLET.robot, Fidelity(CableLaw.RIGID)), POSE).lengths
    assert elastic[1].excess_high == pytest.approx(250.0 - taut[3])
    drums = cases.replaced(
        MERLET.robot, "no end", winch=MERLET.robot.lines[0].winch.model_copy(update={"capacity": None})
    )
    (east, _west) = slack_sets(Model(drums, Fidelity(CableLaw.ELASTIC)), POSE)
    assert (east.excess_high, east.ended_by) == (math.inf, "nothing")
    short = MERLET.robot.lines[0].winch.model_copy(update={"capacity": 11.0})
    assert slack_sets(Model(cases.replaced(MERLET.robot, "short", winch=short)), POSE) == ()


def test_no_set_is_an_answer() -> None:
    assert slack_sets(Model(MERLET.robot, tension_limits=(100.0, 200.0)), POSE) == ()


def test_a_body_has_sets_of_six() -> None:
    sets = slack_sets(COGIRO, BODY)
    assert [each.slack for each in sets] == [("1", "2"), ("1", "8"), ("2", "7"), ("7", "8")]
    for each in sets:
        assert len(each.taut) == 6
        assert each.tensions.shape == (8,)
        assert each.equilibrium.is_valid()


# --- angles


@pytest.mark.parametrize("elevation", [-60.0, 0.0, 30.0, 45.0, 80.5])
@pytest.mark.parametrize("excess", [0.002, 0.01, 0.1, 0.5])
@pytest.mark.parametrize("distance", [0.0, 0.2, 0.6])
def test_the_angle_is_that_of_a_textbook_catenary(elevation: float, excess: float, distance: float) -> None:
    model, place = span_model(math.radians(elevation))
    x, z = 2.5 * math.cos(math.radians(elevation)), -2.5 * math.sin(math.radians(elevation))
    ours = angle_from_excess(model, place, 0, distance, excess)
    theirs = textbook_angle(x, z, 2.5 + excess, distance)
    assert ours == pytest.approx(theirs, abs=2e-4)  # ours stretches a little


@pytest.mark.parametrize(
    ("elevation", "turned"),
    [(0.0, 7.5), (45.0, 7.9), (80.5, 9.4)],
)
def test_merlets_inclinometer_is_not_reproduced(elevation: float, turned: float) -> None:
    """It prints 12.45 degrees for 1 cm on 250 cm, 20 cm from the platform; a catenary turns by 7.3 to 9.4 there."""
    model, place = span_model(math.radians(elevation))
    ours = math.degrees(angle_from_excess(model, place, 0, SENSOR, 0.01)) + elevation
    assert ours == pytest.approx(turned, abs=0.1)
    x, z = 2.5 * math.cos(math.radians(elevation)), -2.5 * math.sin(math.radians(elevation))
    theirs = math.degrees(textbook_angle(x, z, 2.51, SENSOR)) + elevation
    assert ours == pytest.approx(theirs, abs=0.02)


@pytest.mark.parametrize("model", SAGGING, ids=cases.name)
def test_excess_to_angle_and_back(model: Model) -> None:
    pose = cases.poses(model, 1).pose[0]
    for line in range(model.m):
        angles = angle_from_excess(model, pose, line, SENSOR, [0.0, 1e-4, 0.003, 0.02])
        known = ~np.isnan(angles)
        assert known[:2].all()
        for excess, angle in zip(np.array([0.0, 1e-4, 0.003, 0.02])[known], angles[known], strict=True):
            assert excess_from_angle(model, pose, line, SENSOR, float(angle)) == pytest.approx(excess, abs=1e-9)


@pytest.mark.parametrize("elevation", [-60.0, 0.0, 45.0, 80.0])
def test_near_the_platform_the_angle_grows_with_the_excess(elevation: float) -> None:
    model, place = span_model(math.radians(elevation))
    angles = angle_from_excess(model, place, 0, SENSOR, np.append(0.0, np.geomspace(1e-6, 1.0, 200)))
    assert (np.diff(angles) > 0.0).all()


def test_the_angle_of_an_equilibrium_is_that_of_its_hanging_line() -> None:
    found = solve_with_slack(MERLET, [POSE, POSE], {FAR: 0.3})
    angles = tangent_angle(found, FAR, SENSOR)
    assert angles.shape == (2,)
    np.testing.assert_allclose(angles, angle_from_excess(MERLET, POSE, FAR, SENSOR, 0.3), atol=1e-12)
    assert excess_from_angle(MERLET, POSE, FAR, SENSOR, float(angles[0])) == pytest.approx(0.3)
    # at the sheave it leaves in the direction of the state
    assert tangent_angle(found[0], 3, float(found.states[0, 3, layout.FREE])) == pytest.approx(found.states[0, 3, 0])
    platform = found[0].platform_tensions[3]
    h = found[0].tensions[3] * math.cos(found.states[0, 3, layout.PHI])
    assert math.cos(tangent_angle(found[0], 3, 0.0)) == pytest.approx(h / platform)


def test_a_massless_slack_line_has_no_angle() -> None:
    elastic = Model(MERLET.robot, Fidelity(CableLaw.ELASTIC))
    found = solve_with_slack(elastic, POSE, {FAR: 0.3})
    assert math.isnan(tangent_angle(found, FAR, SENSOR))
    assert tangent_angle(found, 0, SENSOR) == found.states[0, layout.PHI]
    for ask in (angle_from_excess, excess_from_angle):
        with pytest.raises(InputError, match="use cable = catenary"):
            ask(elastic, POSE, FAR, SENSOR, 0.0)


@pytest.mark.parametrize("angle", [-1.5, -0.4303, 1.5])
def test_an_angle_that_cannot_be_is_rejected(angle: float) -> None:
    with pytest.raises(InputError, match=r"must be -0\.4302 to 0\.7162 rad, the angles that line 'north-west'"):
        excess_from_angle(MERLET, POSE, FAR, SENSOR, angle)


@pytest.mark.parametrize("distance", [-0.1, 4.0, math.nan, math.inf])
def test_a_distance_off_the_line_is_rejected(distance: float) -> None:
    with pytest.raises(InputError, match=r"distance = .* m: 0 to 3\.5"):
        excess_from_angle(MERLET, POSE, FAR, distance, -0.3)
    with pytest.raises(InputError, match="distance"):
        tangent_angle(solve_with_slack(MERLET, POSE, {FAR: 0.1}), FAR, 3.0 * distance)


@pytest.mark.parametrize("pose", [[-2.5, 5.0, 1.0], [-2.48, 4.99, 4.03]])
def test_where_a_line_has_no_tangent_it_has_no_angle(pose: list[float]) -> None:
    with pytest.raises(InputError, match="no plane or no tangent"):
        excess_from_angle(MERLET, pose, FAR, SENSOR, 0.0)


@pytest.mark.parametrize("excess", [-0.1, math.nan, math.inf, "much"])
def test_an_angle_of_no_excess_is_rejected(excess: object) -> None:
    with pytest.raises(InputError, match="excess: "):
        angle_from_excess(MERLET, POSE, FAR, SENSOR, [0.1, excess])


# --- one line let out


def test_a_line_let_out_is_a_row_of_forward_solves() -> None:
    lengths = solve_inverse(MERLET, POSE).lengths
    by = np.linspace(-0.02, 0.02, 41)
    found = let_out(MERLET, lengths, FAR, by).checked()
    for row in (0, 13, 20, 40):
        alone = lengths + np.array([0.0, 0.0, 0.0, by[row]])
        np.testing.assert_allclose(found.pose[row], solve_forward(MERLET, alone).pose, atol=1e-9)
    excess = excess_lengths(found)
    slack = excess > 0.0
    assert (slack.sum(axis=1) <= 1).all()
    assert slack[0, 2]  # reeled in: its neighbour is slack instead
    assert slack[-1, 3]
    assert (np.diff(found.tensions[:, 3]) < 0.0).all()
    np.testing.assert_allclose(found.pose[20], POSE, atol=1e-9)


# --- what is rejected


@pytest.mark.parametrize(
    ("excess", "says"),
    [
        ({"north-wst": 0.1}, r"unknown line 'north-wst'; did you mean 'north-west'"),
        ({4: 0.1}, "line 4: the lines of 'merlet2023' are 0 to 3"),
        ({-1: 0.1}, "line -1: the lines of"),
        ({1.5: 0.1}, "line 1.5: a name or a whole number is expected"),
        ({FAR: -0.1}, "excess of line 'north-west' = -0.1 m: a slack line's is finite and not negative"),
        ({FAR: math.nan}, "= nan m"),
        ({FAR: math.inf}, "= inf m"),
        ({FAR: "long"}, "= 'long': a number is expected"),
        ({FAR: None}, "a number is expected"),
        ({FAR: 0.1, 3: 0.1}, "line 'north-west' is named twice"),
        ({FAR: 0.1, 0: 0.1}, "3 taut ones hold 'merlet2023', which has 4: at most 1 can be slack"),
    ],
)
def test_bad_slack_lines_are_rejected(excess: dict, says: str) -> None:
    with pytest.raises(InputError, match=says):
        solve_with_slack(MERLET, POSE, excess)


def three_lines() -> Robot:
    return MERLET.robot.model_copy(update={"lines": MERLET.robot.lines[:3]})


@pytest.mark.parametrize(
    ("robot", "why"),
    [(three_lines(), "none can be slack"), (load("grab-four-lines"), "fewer winches than degrees of freedom")],
    ids=["three", "grab"],
)
def test_a_machine_without_spare_lines_has_none_slack(robot: Robot, why: str) -> None:
    with pytest.raises(InputError, match=why):
        solve_with_slack(Model(robot), [0.0] * robot.n, {0: 0.1})
    with pytest.raises(InputError, match=why):
        slack_sets(Model(robot), [0.0] * robot.n)


def test_sets_and_angles_are_of_one_pose() -> None:
    with pytest.raises(InputError, match="one pose is expected; got 2 rows"):
        slack_sets(MERLET, [POSE, POSE])
    with pytest.raises(InputError, match="angle = nan: a finite number is expected"):
        excess_from_angle(MERLET, POSE, 0, SENSOR, math.nan)
    with pytest.raises(InputError, match="one pose is expected"):
        excess_from_angle(MERLET, [POSE, POSE], 0, SENSOR, 0.0)
    with pytest.raises(InputError, match="lengths: one row is expected"):
        let_out(MERLET, np.full((2, 4), 10.0), 0, [0.0])
    with pytest.raises(InputError, match="let out by: at least one number is expected; got 0"):
        let_out(MERLET, [10.0] * 4, 0, [])
    with pytest.raises(AnswerError, match="over its breaking load"):
        let_out(MERLET, [10.0, 7.0, 10.0, 10.0], 0, [0.0])


def test_too_many_sets_are_rejected() -> None:
    lines = [
        MERLET.robot.lines[0].model_copy(update={"name": str(i), "exit_point": (-2.0, i, 4.0), "winch_exit": None})
        for i in range(30)
    ]
    with pytest.raises(InputError, match="4060 sets of 3 of 30 lines are too many; at most 2000"):
        slack_sets(Model(MERLET.robot.model_copy(update={"lines": tuple(lines)})), POSE)


def test_kernels_called_from_here_keep_their_one_signature() -> None:
    for model in (MERLET, COGIRO, Model(load("paty2021"), Fidelity(CableLaw.ELASTIC, SheaveLaw.UNIVERSAL_JOINT))):
        pose = cases.poses(model, 1).pose[0]
        solve_forward(model, solve_inverse(model, pose).lengths)
        slack_sets(model, pose)
    cases.assert_one_signature_per_kernel()
