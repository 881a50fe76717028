"""First order per uncertain number: what differences of full solves of robots described otherwise see."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from mpmath import mp, mpf

import cases
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.parameters import OF_LINES, OF_PLATFORM, varied
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot, load
from cablewright.robot.parameters import KINDS, Parameter, nominal, parameters_of, why_not, with_value
from cablewright.solvers.forward import forward, solve_again, solve_forward
from cablewright.solvers.inverse import inverse
from cablewright.solvers.linearise import linearise
from cablewright.solvers.parameter_effects import departures, nozzle_response, response
from models.test_parameters import all_of, rebuilt
from oracles import machine
from oracles.platform import Place, turned_by
from physics.test_linearisation import motion_between

NAMES = ["paty2021", "house-printer", "merlet2023", "cogiro", "jung2020", "six-lines", "off-axis", "jointed-body"]
ROBOTS = [robot for robot in cases.robots() if robot.name in (*NAMES, "under")]
MODELS = [Model(robot, Fidelity(law)) for robot in ROBOTS for law in (CableLaw.CATENARY, CableLaw.ELASTIC)]
MOVED = 4e-6  # m or rad, about: how far a step of the differences moves the platform
STEEPEST = 1e-2  # of a number's size: the largest step
ROUNDING = 1e-10  # m and rad: of the poses of two solves
CURVED = 1e-3  # of a slope: error of differences of second order over such steps
TAUT = 20.0  # N: no line without weight goes slack over a step


def taut(model: Model, count: int) -> Equilibrium:
    """Poses at which every line carries a load, solved."""
    low = max(line.tension_limits[0] for line in model.robot.lines)
    high = min(line.tension_limits[1] for line in model.robot.lines)
    least = low if low >= 10.0 else TAUT
    return cases.poses(Model(model.robot, model.fidelity, (least, high)), count)


def steps(held: Equilibrium, parameters: list[Parameter], motion: np.ndarray) -> np.ndarray:
    """Steps (k,) of the numbers, each of which moves the platform as little as the next."""
    largest = np.abs(motion).max(axis=(0, 1))
    size = [max(abs(nominal(held.model.robot, one)), 0.1) for one in parameters]
    return np.minimum(MOVED / np.maximum(largest, 1e-300), STEEPEST * np.array(size))


def differences(held: Equilibrium, parameters: list[Parameter], step: np.ndarray) -> np.ndarray:
    """Motions (N, n, k) per number by central differences of fourth order, of solves in one batch."""
    robot, count = held.model.robot, len(parameters)
    base = np.array([nominal(robot, one) for one in parameters])
    offsets = np.concatenate([by * np.diag(step) for by in (-2.0, -1.0, 1.0, 2.0)])
    rows = len(held.pose)
    values = np.tile(base + offsets, (rows, 1))
    lengths = np.repeat(held.lengths, 4 * count, axis=0)
    packed, paid_out = varied(robot, held.packed, parameters, values, lengths)
    found = solve_again(held, packed, paid_out, 4 * count).checked()
    poses = found.pose.reshape(rows, 4, count, held.model.n)
    out = np.empty((rows, held.model.n, count))
    for row in range(rows):
        for k in range(count):
            ends = [motion_between(held.pose[row], pose) for pose in poses[row, :, k]]
            out[row, :, k] = (8.0 * (ends[2] - ends[1]) - (ends[3] - ends[0])) / (12.0 * step[k])
    return out


@pytest.mark.parametrize("model", MODELS, ids=cases.name)
def test_responses_to_every_number_are_differences_of_solves(model: Model) -> None:
    held = taut(model, 2)
    parameters = all_of(model.robot)
    answer = response(held, parameters)
    step = steps(held, parameters, answer)
    off = np.abs(answer - differences(held, parameters, step)).max(axis=(0, 1))
    np.testing.assert_array_less(off, 3e-6 * np.abs(answer).max(axis=(0, 1)) + ROUNDING / step)
    if model.fidelity.cable is CableLaw.ELASTIC:  # leaves out the cable's weight
        assert not answer[..., [one.kind == "linear_density" for one in parameters]].any()


@pytest.mark.parametrize("name", ["house-printer", "jung2020"])
def test_shared_numbers_answer_as_the_sum_of_the_lines(name: str) -> None:
    robot = load(name)
    held = cases.poses(Model(robot), 3)
    for kind in ("modulus", "linear_density", "length_offset", "length_scale"):
        together = response(held, list(parameters_of(robot, kind, shared=True)))[..., 0]
        apart = response(held, list(parameters_of(robot, kind))).sum(axis=2)
        np.testing.assert_allclose(together, apart, rtol=1e-12, atol=1e-18)


HARDWARE = [
    (robot, kind.name)
    for robot in map(load, cases.LIBRARY)
    for kind in KINDS.values()
    if kind.role == "hardware" and why_not(robot, kind, None, False) is None
]


@cache
def held_by(robot: Robot) -> Equilibrium:
    return taut(Model(robot), 1)


@pytest.mark.parametrize(("robot", "kind"), HARDWARE, ids=lambda each: getattr(each, "name", each))
def test_robots_described_otherwise_go_where_first_order_says(robot: Robot, kind: str) -> None:
    """As a user would: another `Robot`, solved again, differs by the response but for the square of the step."""
    held, parameters = held_by(robot), parameters_of(robot, kind)
    one = parameters[len(parameters) // 2]
    answer = response(held, [one])[0, :, 0]
    step = steps(held, [one], answer[None, :, None])[0]
    ends = [with_value(robot, one, nominal(robot, one) + by * step) for by in (-1.0, 1.0)]
    poses = [forward(end, held.lengths[0], guess=held.pose[0]).checked().pose for end in ends]
    moved = motion_between(*poses) / (2.0 * step)
    np.testing.assert_allclose(moved, answer, rtol=0, atol=CURVED * np.abs(answer).max() + ROUNDING / step)


def test_every_number_of_the_statics_has_its_columns() -> None:
    """An entry of the registry, but for those that a calibration alone knows, is in one of the two tables."""
    wanted = {kind.name: kind.of for kind in KINDS.values() if kind.role in ("hardware", "command", "load")}
    assert {*OF_LINES, *OF_PLATFORM} == {*wanted}
    assert set(OF_PLATFORM) == {name for name, owner in wanted.items() if owner == "platform"}


SLOPES: dict[str, Callable[[Equilibrium, int], np.ndarray]] = {
    "modulus": lambda held, i: linearise(held).per_modulus[:, i],
    "sheave_radius": lambda held, i: linearise(held).per_sheave_radius[:, i],
    "linear_density": lambda held, i: linearise(held).per_weight[:, i] / held.model.robot.lines[i].cable.linear_density,
    "platform_point.x": lambda held, i: linearise(held).per_platform_point[:, i, 0],
    "platform_point.z": lambda held, i: linearise(held).per_platform_point[:, i, 2],
    "force.y": lambda held, i: linearise(held).per_wrench[:, 1],
    "moment.x": lambda held, i: linearise(held).per_wrench[:, 3],
}
EXACT = [
    *(("house-printer", kind) for kind in ("modulus", "sheave_radius", "linear_density", "force.y")),
    *(("under", kind) for kind in ("sheave_radius", "linear_density")),
    *(("cogiro", kind) for kind in SLOPES),
    *(("jointed-body", kind) for kind in ("sheave_radius", "platform_point.z")),
]


@cache
def solved(name: str) -> tuple[Equilibrium, machine.Solution]:
    """A pose of a robot, and the oracle's."""
    held = taut(Model(next(one for one in cases.robots() if one.name == name)), 1)[0]
    return held, machine.solve(held.model.robot, held.lengths, held.pose, cases.line_states(held))


@pytest.mark.parametrize(("name", "kind"), EXACT)
def test_columns_of_the_linearisation_are_the_oracles(name: str, kind: str) -> None:
    """Differences of 50-digit solutions of independent equations, of robots described otherwise."""
    held, start = solved(name)
    robot = held.model.robot
    line = robot.lines[1].name if kind not in ("force.y", "moment.x") else None
    one = Parameter(kind, line)
    with mp.workdps(50):
        step = mpf(10) ** -15
        robots = [rebuilt(robot, one, nominal(robot, one) + by) for by in (-step, step)]
        ends = [machine.solve(other, held.lengths, start.pose, start.states).pose for other in robots]
        way = [on - back for back, on in zip(*ends, strict=True)][:3]
        if robot.n == 6:
            way += turned_by(*(Place.of(end).rotation for end in ends))
        exact = np.array([float(value / (2 * step)) for value in way])
    found = SLOPES[kind](held, 1)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-9 * np.abs(exact).max())


def test_the_nozzle_moves_with_the_platform_and_with_its_turn() -> None:
    """Of a platform whose nozzle is not at its origin: differences of the nozzle's position."""
    robot = load("cogiro")
    robot = robot.model_copy(update={"platform": robot.platform.model_copy(update={"nozzle": (0.3, -0.2, -0.5)})})
    held = cases.poses(Model(robot), 2)
    parameters = all_of(robot)
    answer = nozzle_response(held, parameters)
    assert answer.shape == (2, 3, len(parameters))
    arm = held.nozzle - held.pose[:, :3]
    np.testing.assert_allclose(np.linalg.norm(arm, axis=1), np.linalg.norm(robot.platform.nozzle), rtol=1e-12)
    step = steps(held, parameters, answer)
    base = np.array([nominal(robot, one) for one in parameters])
    ends = []
    for by in (-1.0, 1.0):
        values = np.tile(base + by * np.diag(step), (2, 1))
        lengths = np.repeat(held.lengths, len(base), axis=0)
        packed, paid_out = varied(robot, held.packed, parameters, values, lengths)
        ends.append(solve_again(held, packed, paid_out, len(base)).checked().nozzle.reshape(2, len(base), 3))
    exact = np.swapaxes((ends[1] - ends[0]) / (2.0 * step[None, :, None]), 1, 2)
    off = np.abs(answer - exact).max(axis=(0, 1))
    np.testing.assert_array_less(off, CURVED * np.abs(answer).max(axis=(0, 1)) + ROUNDING / step)
    central = response(held, parameters)[:, :3]
    assert (np.abs(answer - central).max(axis=(0, 1)) > 0.05 * np.abs(central).max(axis=(0, 1))).any()


def test_of_a_point_the_nozzle_is_the_platform() -> None:
    robot = load("merlet2023")
    held = cases.poses(Model(robot), 3)
    parameters = all_of(robot)
    np.testing.assert_array_equal(nozzle_response(held, parameters), response(held, parameters))


def test_departures_are_differences_but_of_a_modulus_what_its_compliance_loses() -> None:
    parameters = [Parameter("modulus", "south"), Parameter("mass"), Parameter("modulus")]
    base = np.array([1.0, 200.0, 2.0])
    values = np.array([[[0.5, 190.0, 2.0], [2.0, 200.0, 4.0]]])
    wanted = [[[-1.0, -10.0, 0.0], [0.5, 0.0, 0.25]]]
    np.testing.assert_allclose(departures(parameters, base, values), wanted, rtol=1e-15)
    slope = (departures(parameters, base, base + 1e-6) - departures(parameters, base, base - 1e-6)) / 2e-6
    np.testing.assert_allclose(slope[:2], 1.0, rtol=1e-6)  # at a factor of 1 they are in the unit of `response`


@pytest.mark.parametrize("factor", [0.5, 0.8, 1.25, 3.0])
def test_a_softer_robot_is_nearly_linear_in_its_departures(factor: float) -> None:
    """Stretch goes with the compliance: first order in departures is far nearer than in the factor itself."""
    robot = load("house-printer")
    held = inverse(robot, [[1.0, -2.0, 3.0]])
    shared = [Parameter("modulus")]
    soft = solve_forward(Model(robot), held.lengths, guess=held.pose, modulus_factors=np.full(4, factor)).checked()
    slope = response(held, shared)[0, :, 0]
    moved = soft.pose[0] - held.pose[0]
    departure = departures(shared, np.ones(1), np.array([factor]))[0]
    assert np.linalg.norm(moved - slope * departure) < 0.05 * np.linalg.norm(moved)
    assert np.linalg.norm(moved - slope * (factor - 1.0)) > 0.15 * np.linalg.norm(moved)


def test_only_what_was_solved_has_a_response() -> None:
    robot = load("house-printer")
    with pytest.raises(AnswerError):
        response(inverse(robot, [[0.0, 0.0, 14.9]]), [Parameter("mass")])
    with pytest.raises(InputError, match="rigid"):
        response(inverse(robot, [[0.0, 0.0, 1.0]], cable="rigid"), [Parameter("mass")])
