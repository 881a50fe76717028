"""Which wrong lines lengths can show: with two spare lines at one place, with one at three places, without one none."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from cablewright.control.balance_check import balance
from cablewright.control.faulty_line_search import sentence
from cablewright.control.length_check import check_lengths, lengths_at
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse

PLACE = np.array([0.4, -0.6, 1.1])


@cache
def model(lines: int) -> Model:
    """The exhibition's robot with three to six lines: further ones hang at the middles of its long sides."""
    robot = load("merlet2023")
    first = robot.lines[0]
    x, y, z = robot.lines[0].exit_point
    more = [
        first.model_copy(update={"name": name, "exit_point": place, "winch_exit": None})
        for name, place in (("west", (x, 0.1 * y, z)), ("east", (-x, 0.1 * y, z)))
    ]
    return Model(robot.model_copy(update={"lines": (*robot.lines, *more)[:lines]}))


def names(of: Model) -> list[str]:
    return [line.name for line in of.robot.lines]


def taut(of: Model, place: np.ndarray = PLACE) -> tuple[np.ndarray, np.ndarray]:
    """Lengths and tensions of the platform at rest."""
    found = solve_inverse(of, place)
    tensions = np.array(found.tensions)
    return lengths_at(of, place, tensions), tensions


@pytest.mark.parametrize("line", range(6))
def test_with_two_spare_lines_the_wrong_one_is_named(line: int) -> None:
    of = model(6)
    lengths, tensions = taut(of)
    assert check_lengths(of, lengths, tensions, PLACE).fits
    lengths[line] += 0.05
    found = check_lengths(of, lengths, tensions, PLACE)
    assert not found.fits
    assert list(found.suspects) == [line]
    assert found.suspects[line] == pytest.approx(0.05, abs=1e-3)
    assert found.sentence(names(of)).endswith(f"it is line {names(of)[line]} by +50 mm")


@pytest.mark.parametrize("line", range(4))
def test_with_one_spare_line_it_takes_three_places(line: int) -> None:
    of, checks = model(4), []
    for place in (PLACE, PLACE - np.array([0.4, 0.0, 0.0]), PLACE + np.array([0.0, 0.4, 0.0])):
        lengths, tensions = taut(of, place)
        lengths[line] -= 0.04
        checks.append(check_lengths(of, lengths, tensions, place))
    assert len(checks[0].suspects) == 4
    alone = sentence(checks[:1], names(of))
    assert all(f"{name} by " in alone for name in names(of))
    said = sentence(checks, names(of))
    assert f"{names(of)[line]} by -" in said  # alone, or first of those that are not clearly worse
    assert f"it is line {names(of)[line]} by -40 mm" in said or "if one line is wrong, it is " in said


def test_without_a_spare_line_nothing_is_tested() -> None:
    of = model(3)
    lengths, tensions = taut(of)
    found = check_lengths(of, lengths + np.array([0.05, 0.0, 0.0]), tensions, PLACE)
    assert found.fits
    assert not found.tested


@pytest.mark.parametrize("lines", [3, 4])
def test_tensions_of_the_statics_carry_the_platform_where_it_is(lines: int) -> None:
    """By the catenaries of the inverse solution, which know nothing of chords: to half a percent of the weight."""
    of = model(lines)
    _, tensions = taut(of)
    found = balance(of, PLACE, tensions, 0.1)
    assert float(np.linalg.norm(found.off)) < 0.005 * found.weight
    assert found.holds


@pytest.mark.parametrize("lines", [3, 4])
def test_from_its_reach_on_a_wrong_place_shows(lines: int) -> None:
    """In every direction, even with the largest allowed errors of tensions."""
    of = model(lines)
    _, tensions = taut(of)
    reach = balance(of, PLACE, tensions, 0.02).reach
    assert 0.05 < reach < 1.0
    for way in np.random.default_rng(1).normal(size=(40, 3)):
        wrong = PLACE + reach * way / np.linalg.norm(way)
        assert float(np.linalg.norm(balance(of, wrong, tensions, 0.02).off)) > 0.02 * 9.81 * of.robot.platform.mass


def test_a_load_that_is_not_that_of_the_file_shows_with_numbers() -> None:
    of = model(4)
    _, tensions = taut(of)
    found = balance(of, PLACE, 1.3 * tensions, 0.1)
    assert not found.holds
    assert "place, load or a tension is wrong" in found.sentence()
    assert found.off[2] == pytest.approx(0.3 * found.weight, rel=0.05)


def test_a_place_without_a_line_to_it_is_no_place() -> None:
    of = model(4)
    found = balance(of, np.array(of.robot.lines[0].exit_point), np.full(4, 300.0), 0.1)
    assert not found.holds
