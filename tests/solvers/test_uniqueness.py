"""Among which equilibria a theorem makes one the only one: the conditions, and starts from everywhere."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from tools.uniqueness_search import contradictions

import cablewright as cw
from cablewright.models.packed_views import LineStates
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


def test_no_sentence_of_random_slack_robots_is_contradicted() -> None:
    """Two batches of each number of lines; `python -m tools.uniqueness_search` runs any number of them."""
    checked = [contradictions(seed=3, number=number, count=60) for number in range(8)]
    assert not [sentence for false, _ in checked for sentence in false]
    assert sum(tally["with a sentence and several solutions"] for _, tally in checked) > 20


def test_a_dead_span_in_a_loop_is_not_called_taut() -> None:
    """Its tension is above that of a dead span that just hangs, but it holds more cable than reaches the winch."""
    robot = cw.load("house-printer")
    hold = cw.inverse(robot, [3.0, 3.0, 10.0], sheave="eyelet")
    tracker = cw.Tracker(cw.Model(robot, cw.Fidelity.of("catenary", "eyelet")), hold.lengths)
    for step in range(1, 81):
        assert tracker.step(hold.lengths + np.array([0.1 * step, 0.0, 0.0, 0.0])) is cw.Status.OK
    states = LineStates(tracker.states)
    weight = robot.lines[0].cable.linear_density * robot.scene.gravity
    assert states.tension[0] > 1.01 * weight * 15.0
    assert states.dead_length[0] > 20.0
    found = cw.forward(robot, hold.lengths + np.array([8.0, 0.0, 0.0, 0.0]), sheave="eyelet").checked()
    looped = dataclasses.replace(found, pose=tracker.pose, states=tracker.states)
    assert unique_among(looped) is None
    assert unique_among(found) == f"{EVERYWHERE} whose dead spans are taut"


def test_a_platform_within_two_radii_of_a_swivel_is_not_among_those_beyond() -> None:
    """The sentence has the largest radius; beside a small swivel a platform leaves it outwards and is nearer."""
    robot, lines = cw.load("merlet2023"), []
    for y, radius in ((0.0, 0.1), (5.0, 0.4)):
        line = robot.lines[0]
        changes = {"exit_point": (0.0, y, 4.0), "sheave": line.sheave.model_copy(update={"radius": radius})}
        lines.append(line.model_copy(update={"winch_exit": None, **changes}))
    robot = robot.model_copy(update={"lines": tuple(lines)})
    beyond = f"{EVERYWHERE} whose platform is farther than 0.8 m from the axis of each swivel"
    for lengths, among in (([2.2, 5.6], None), ([4.0, 4.5], beyond)):
        found = cw.forward(robot, lengths).checked()
        assert (found.pose[1] > 0.8) == (among is not None)
        assert unique_among(found) == among
