"""Among which equilibria a theorem makes one the only one: the conditions, and starts from everywhere."""

from __future__ import annotations

import numpy as np
import pytest

import cablewright as cw
from cablewright.solvers.uniqueness import EVERYWHERE, unique_among


def _forward(name: str, pose: list[float], **laws: str) -> cw.Equilibrium:
    robot = cw.load(name)
    return cw.forward(robot, cw.inverse(robot, pose, **laws).lengths, **laws)


@pytest.mark.parametrize(
    ("name", "laws", "among"),
    [
        ("wang2021", {"sheave": "eyelet"}, EVERYWHERE),  # theorem 1
        ("merlet2023", {"sheave": "eyelet"}, f"{EVERYWHERE} whose dead spans are taut"),  # theorem 2
        ("wang2021", {}, f"{EVERYWHERE} whose platform is farther than 0.15 m from the axis of each swivel"),
        ("paty2021", {}, None),  # levers
    ],
)
def test_the_theorem_that_covers_a_machine_is_found(name: str, laws: dict[str, str], among: str | None) -> None:
    assert unique_among(_forward(name, [0.3, 0.1, 1.0], **laws)) == among


def test_dead_spans_on_swivels_are_covered_by_both_conditions() -> None:
    among = unique_among(_forward("merlet2023", [0.3, 0.1, 1.0]))
    assert among is not None
    assert "dead spans are taut" in among
    assert "0.075 m from the axis" in among


def _changed(robot: cw.Robot, **sheave: object) -> cw.Robot:
    lines = [line.model_copy(update={"sheave": line.sheave.model_copy(update=sheave)}) for line in robot.lines]
    return robot.model_copy(update={"lines": tuple(lines)})


@pytest.mark.parametrize("change", [{"wrap": "under"}, {"radius": 5.0}])
def test_what_the_theorems_leave_out_is_not_claimed(change: dict[str, object]) -> None:
    robot = _changed(cw.load("wang2021"), **change)
    assert unique_among(cw.forward(robot, [5.0, 5.0, 5.0, 5.0])) is None


def test_an_elastic_arc_is_not_claimed() -> None:
    robot = cw.load("wang2021")
    lines = tuple(line.model_copy(update={"arc_elastic": True}) for line in robot.lines)
    assert unique_among(cw.forward(robot.model_copy(update={"lines": lines}), [5.0] * 4)) is None


def test_a_slack_dead_span_is_not_claimed() -> None:
    robot = cw.load("merlet2023")
    held = cw.inverse(robot, [0.0, -1.0, 1.0])
    lengths = held.lengths + np.array([0.0, 0.0, 60.0, 0.0])
    found = cw.forward(robot, lengths)
    slackest = found.tensions.min()
    claimed = unique_among(found)
    limit = robot.lines[0].cable.linear_density * 9.80665 * 4.03
    assert (claimed is None) == bool(slackest <= limit * (1.0 + 1e-6))


def test_no_two_covered_equilibria_are_found_for_the_same_lengths() -> None:
    """The claim against 60 sets of lengths from 12 starts each: of all that are found at most one is covered."""
    robot, rng = cw.load("merlet2023"), np.random.default_rng(5)
    for _ in range(60):
        pose = rng.uniform([-2.0, -4.0, 0.2], [2.0, 4.0, 3.0])
        lengths = cw.inverse(robot, pose).lengths + rng.uniform(0.0, 1.0, 4) * rng.integers(0, 2, 4)
        if not np.isfinite(lengths).all():
            continue
        assert sum(unique_among(one) is not None for one in cw.equilibria(robot, lengths)) <= 1
