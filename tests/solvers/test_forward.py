"""Forward problem: one or many, from a guess or from nothing, in any layout: the same pose."""

from __future__ import annotations

import numpy as np
import pytest

import cases
from cablewright.foundation.errors import AnswerError, InputError, Status
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Cable, Robot, load
from cablewright.solvers.forward import forward, solve_forward
from cablewright.solvers.inverse import solve_inverse

HOUSE = Model(load("house-printer"))


@pytest.fixture(scope="module")
def held() -> Equilibrium:
    """130 poses that the house-printer holds."""
    return cases.poses(HOUSE, 130)


def softened(robot: Robot, factors: np.ndarray) -> Robot:
    """*robot* with each cable's modulus multiplied."""

    def soft(cable: Cable, factor: float) -> Cable:
        return cable.model_copy(update={"young_modulus": cable.young_modulus * factor})

    pairs = zip(robot.lines, factors, strict=True)
    lines = tuple(line.model_copy(update={"cable": soft(line.cable, factor)}) for line, factor in pairs)
    return robot.model_copy(update={"lines": lines})


def test_one_few_and_many_rows_agree(held: Equilibrium) -> None:
    many = solve_forward(HOUSE, held.lengths)
    few = solve_forward(HOUSE, held.lengths[:63])
    np.testing.assert_array_equal(few.pose, many.pose[:63])
    for row in (0, 62, 63, 64, 129):
        one = solve_forward(HOUSE, held.lengths[row])
        assert (one.pose.shape, one.lengths.shape, one.states.shape, one.code.shape) == ((3,), (4,), (4, 6), ())
        np.testing.assert_array_equal(one.pose, many.pose[row])
        assert one.status is Status.OK


def test_what_is_solved_can_be_judged(held: Equilibrium) -> None:
    found = solve_forward(HOUSE, held.lengths)
    assert found.is_valid(1e-9)
    assert found.residual_norm().max() < 1e-9
    assert found.unbalanced_force().max() < 1e-6
    assert found.residual_norm().shape == found.unbalanced_force().shape == found.margin().shape == (130,)
    assert (found.margin() >= -1e-6).all()
    np.testing.assert_allclose(found.tensions, held.tensions, rtol=1e-7)


@pytest.mark.parametrize("rows", [5, 100])
def test_a_guess_for_all_is_a_guess_for_each(held: Equilibrium, rows: int) -> None:
    lengths, guess = held.lengths[:rows], np.array([0.0, 0.0, 5.0])
    for path in (False, True):
        for_all = solve_forward(HOUSE, lengths, guess=guess, path=path)
        for_each = solve_forward(HOUSE, lengths, guess=np.tile(guess, (rows, 1)), path=path)
        np.testing.assert_array_equal(for_all.pose, for_each.pose)
        np.testing.assert_allclose(for_all.pose, held.pose[:rows], atol=1e-9)


@pytest.mark.parametrize("cable", [CableLaw.ELASTIC, CableLaw.CATENARY])
def test_a_path_gets_the_same_answers(cable: CableLaw) -> None:
    model = Model(HOUSE.robot, Fidelity(cable))
    turn = np.linspace(0, 4 * np.pi, 300)
    places = np.transpose([4 * np.cos(turn), 4 * np.sin(turn), 1 + turn / 4])
    lengths = solve_forward(model, [30.0] * 4).lengths + 0.3 * np.transpose([np.sin(turn + k) for k in range(4)])
    cold = solve_forward(model, lengths)
    warm = solve_forward(model, lengths, guess=places, path=True)
    assert cold.ok.all()
    assert warm.ok.all()
    np.testing.assert_allclose(warm.pose, cold.pose, atol=1e-9)


@pytest.mark.parametrize("rows", [3, 80])
def test_modulus_factors_are_another_robot(held: Equilibrium, rows: int) -> None:
    lengths, factors = held.lengths[:rows], np.array([0.7, 1.0, 1.3, 0.9])
    soft = Model(softened(HOUSE.robot, factors))
    wanted = solve_forward(soft, lengths)
    for_all = solve_forward(HOUSE, lengths, modulus_factors=factors)
    for_each = solve_forward(HOUSE, lengths, modulus_factors=np.tile(factors, (rows, 1)))
    np.testing.assert_allclose(for_all.pose, wanted.pose, atol=1e-9)
    np.testing.assert_array_equal(for_all.pose, for_each.pose)
    assert np.linalg.norm(for_all.pose - held.pose[:rows], axis=1).max() > 1e-4


def test_each_row_has_its_own_factors(held: Equilibrium) -> None:
    factors = np.random.default_rng(2).uniform(0.7, 1.3, (80, 4))
    found = solve_forward(HOUSE, held.lengths[:80], modulus_factors=factors)
    for row in (0, 63, 64, 79):
        one = solve_forward(Model(softened(HOUSE.robot, factors[row])), held.lengths[row])
        np.testing.assert_allclose(found.pose[row], one.pose, atol=1e-9)


def test_a_solution_with_modulus_factors_is_valid(held: Equilibrium) -> None:
    found = solve_forward(HOUSE, held.lengths[:5], modulus_factors=[0.7, 1.0, 1.3, 0.9])
    assert found.residual_norm().max() < 1e-9
    assert found.is_valid(1e-9)


@pytest.mark.parametrize("layout", ["C", "F", "strided", "list", "readonly"])
def test_arrays_of_any_layout_are_read_and_left_alone(held: Equilibrium, layout: str) -> None:
    def laid_out(values: np.ndarray) -> object:
        if layout == "list":
            return values.tolist()
        if layout == "strided":
            return np.repeat(values, 2, axis=1)[:, ::2]
        given = np.array(values, order="F" if layout == "F" else "C")
        given.setflags(write=layout != "readonly")
        return given

    lengths, guess, factors = (laid_out(a) for a in (held.lengths[:4], held.pose[:4] + 0.01, np.full((4, 4), 0.9)))
    before = [np.array(a) for a in (lengths, guess, factors)]
    found = forward(HOUSE.robot, lengths, guess=guess, modulus_factors=factors)
    for given, was in zip((lengths, guess, factors), before, strict=True):
        np.testing.assert_array_equal(given, was)
        assert not any(np.shares_memory(given, a) for a in (found.lengths, found.pose, found.states))
    np.testing.assert_array_equal(
        found.pose, forward(HOUSE.robot, before[0], guess=before[1], modulus_factors=before[2]).pose
    )


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"lengths": [28.0] * 3}, "lengths: 4 numbers"),
        ({"lengths": [28.0, 28.0, 28.0, np.nan]}, "lengths: every number must be finite"),
        ({"lengths": [28.0, 28.0, 28.0, 0.0]}, "lengths: every length must be over zero"),
        ({"lengths": "long"}, "lengths: numbers in m"),
        ({"guess": [0.0, 0.0]}, "guess: 3 numbers"),
        ({"guess": [[0.0, 0.0, 1.0]] * 2}, "guess: one row, or 5 as there are problems, is expected; got 2"),
        ({"guess": [0.0, 0.0, np.inf]}, "guess: every number must be finite"),
        ({"modulus_factors": [1.0] * 5}, "modulus factors: 4 numbers"),
        ({"modulus_factors": np.ones((4, 4))}, "modulus factors: one row, or 5"),
        ({"modulus_factors": [1.0, 1.0, 1.0, 0.0]}, "modulus factors: every factor must be over zero"),
        ({"cable": "rigid"}, "do not determine tensions"),
    ],
)
def test_what_cannot_be_used_is_rejected(arguments: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says):
        forward(HOUSE.robot, **({"lengths": np.full((5, 4), 28.0)} | arguments))


@pytest.mark.parametrize("cable", [CableLaw.ELASTIC, CableLaw.CATENARY])
@pytest.mark.parametrize("robot", cases.robots(), ids=lambda robot: robot.name)
@pytest.mark.parametrize("share", [0.7, 0.5])
def test_lines_too_short_are_overstretched(robot: Robot, cable: CableLaw, share: float) -> None:
    model = Model(robot, Fidelity(cable))
    found = solve_forward(model, cases.poses(model, 1)[0].lengths * share)
    if robot.m < robot.n and found.ok:  # a body that gravity may turn can hang elsewhere, soundly
        assert found.is_valid()
        assert found.extremes()[1].max() <= robot.lines[0].cable.breaking_load
        return
    assert found.status is Status.OVERSTRETCHED
    _low, high = found.extremes()
    worst = int(np.argmax(high))
    with pytest.raises(AnswerError, match="over its breaking load: line ") as caught:
        found.checked()
    over = high[worst] - robot.lines[worst].cable.breaking_load
    assert f"line {robot.lines[worst].name} at {high[worst]:.6g} N, {over:.4g} N over" in str(caught.value)


def test_a_slack_line_without_weight_pulls_nothing() -> None:
    model = Model(load("merlet2023"), Fidelity(CableLaw.ELASTIC))
    lengths = cases.poses(model, 1)[0].lengths + np.array([3.0, 0.0, 0.0, 0.0])
    found = solve_forward(model, lengths).checked()
    assert found.tensions[0] == found.platform_tensions[0] == found.winch_tensions[0] == 0.0
    assert (found.tensions[1:] > 0.0).any()


def test_one_bad_row_does_not_spoil_its_neighbours(held: Equilibrium) -> None:
    lengths = held.lengths[:100].copy()
    lengths[[0, 40, 99]] *= 0.5
    for guess in (None, held.pose[:100]):
        found = solve_forward(HOUSE, lengths, guess=guess, path=guess is not None)
        good = np.setdiff1d(np.arange(100), [0, 40, 99])
        assert found.ok[good].all()
        assert not found.ok[[0, 40, 99]].any()
        np.testing.assert_allclose(found.pose[good], held.pose[good], atol=1e-9)


@pytest.mark.parametrize("half", [0.24, 24.0, 240.0, 600.0])
def test_a_machine_of_any_size_is_found_without_a_guess(half: float) -> None:
    """The same machine, larger: forces grow as the square of the size, and the lines' weight by length as the size."""
    scale = half / 240.0
    line = {
        "cable": {"axial_stiffness": 7e8 * scale**2, "linear_density": 0.3 * scale, "breaking_load": 1e8 * scale**2},
        "sheave": {"kind": "eyelet"},
        "tension_limits": (0.0, 1e7 * scale**2),
    }
    exits = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)]
    lines = [line | {"name": f"{i}", "exit_point": (x * half, y * half, 1.08 * half)} for i, (x, y) in enumerate(exits)]
    scene = {"frame_min": (-half, -half, -half), "frame_max": (half, half, 1.1 * half)}
    platform = {"mass": 2e4 * scale**2}
    robot = Robot.model_validate({"name": "large", "scene": scene, "platform": platform, "lines": lines})
    places = half * np.random.default_rng(0).uniform(-0.5, 0.5, (30, 3))
    model = Model.full(robot)
    wanted = solve_inverse(model, places)
    assert wanted.ok.sum() > 10
    found = solve_forward(model, wanted.lengths[wanted.ok])
    assert found.ok.all()
    np.testing.assert_allclose(found.pose, places[wanted.ok], atol=1e-7 * half)
