"""Winch speeds move the platform as wanted, by physics that the controller does not compute by itself."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.control import height, slack, velocity
from cablewright.control.height import HeightControl
from cablewright.control.path_follower import Target
from cablewright.control.slack import SlackSettings
from cablewright.control.velocity import VelocitySettings
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.signals import Estimate, frozen
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.slack import angle_from_excess, solve_with_slack
from cablewright.solvers.taut import taut_at

MODEL = Model(load("merlet2023"))
PLACE = np.array([0.4, -1.2, 1.1])
DT = 0.01


def target(position: np.ndarray, speed: np.ndarray) -> Target:
    return Target(position, speed, 0.0, 0, float(np.linalg.norm(speed)), True, False, False)


def believed(lengths: np.ndarray, place: np.ndarray, radius: float = 0.05) -> Estimate:
    excess = lengths - taut_at(MODEL, place).lengths
    zeros = frozen(np.zeros(3))
    return Estimate(
        0.0, frozen(place), zeros, zeros, frozen(lengths), frozen(excess), excess > 2.5e-3, frozen([radius] * 4)
    )


def settings(**changes: object) -> VelocitySettings:
    return VelocitySettings(MODEL, 3.65, **changes)  # type: ignore[arg-type]


def loop(
    law: str, lengths: np.ndarray, aim: np.ndarray, steps: int, **changes: object
) -> tuple[np.ndarray, np.ndarray]:
    """A machine without errors under control: where it ends, and its lengths."""
    given = settings(law=law, **changes)
    place = solve_forward(MODEL, lengths, guess=PLACE).checked().pose
    state = velocity.start(given)
    for _ in range(steps):
        speeds = velocity.step(given, state, believed(lengths, place), target(aim, np.zeros(3)), DT * 10)
        lengths = lengths + 0.05 * speeds * DT * 10
        place = solve_forward(MODEL, lengths, guess=place).checked().pose
    return place, lengths


@pytest.mark.parametrize("direction", np.eye(3))
def test_the_platform_moves_with_the_wanted_velocity(direction: np.ndarray) -> None:
    """The forward solver, with the lengths a moment later, agrees."""
    lengths = solve_inverse(MODEL, PLACE).checked().lengths
    wanted = 0.03 * direction
    given = settings(law="paper")
    speeds = velocity.step(given, velocity.start(given), believed(lengths, PLACE), target(PLACE, wanted), DT)
    moved = solve_forward(MODEL, lengths + 0.05 * speeds * DT, guess=PLACE).checked().pose - PLACE
    np.testing.assert_allclose(moved / DT, wanted, atol=2e-4)


@pytest.mark.parametrize("law", velocity.LAWS)
def test_it_comes_to_where_it_should_be(law: str) -> None:
    begin = solve_inverse(MODEL, PLACE).checked().lengths
    aim = PLACE + np.array([0.03, -0.02, 0.01])
    place, _ = loop(law, begin, aim, 300)
    assert np.linalg.norm(place - aim) < 2e-3  # the straight Jacobian leaves what stretch changes
    place, _ = loop(law, begin, aim, 600)
    assert np.linalg.norm(place - aim) < 1e-3


def test_slack_is_taken_in_by_the_papers_term() -> None:
    begin = solve_with_slack(MODEL, PLACE, {3: 0.05}).checked().lengths
    place, lengths = loop("paper", begin, PLACE, 300)
    assert (lengths - taut_at(MODEL, place).lengths)[3] == pytest.approx(SlackSettings().target_excess, abs=2e-3)
    assert np.linalg.norm(place - PLACE) < 2e-3


def test_the_model_gives_the_line_with_least_to_do_its_excess() -> None:
    begin = solve_inverse(MODEL, PLACE).checked()
    place, lengths = loop("model", begin.lengths, PLACE, 400)
    least = int(np.argmin(begin.tensions))
    excess = lengths - taut_at(MODEL, place).lengths
    assert int(np.argmax(excess)) == least
    assert 0.0 < excess[least] < 2 * SlackSettings().planned_excess
    assert np.linalg.norm(place - PLACE) < 2e-3


def test_without_slack_it_keeps_the_models_tensions() -> None:
    held = solve_inverse(MODEL, PLACE).checked()
    _, lengths = loop("model", held.lengths + np.array([2e-3, 0.0, 1e-3, 0.0]), PLACE, 400, manage_slack=False)
    found = solve_forward(MODEL, lengths, guess=PLACE).checked()
    np.testing.assert_allclose(found.tensions, held.tensions, rtol=0.02)


def test_a_tension_that_is_not_known_is_no_tension_that_is_right() -> None:
    """The error of the tensions is known for this step: a path begins by it."""
    held = solve_inverse(MODEL, PLACE).checked()
    given, still = settings(law="model", manage_slack=False), target(PLACE, np.zeros(3))
    state, known = velocity.start(given), believed(held.lengths, PLACE)
    for unread in (0, 1, 4):
        velocity.step(given, state, known, still, DT, held.tensions)
        assert state.tension_error < 0.01 * held.tensions.min()
        pulls = np.where(np.arange(4) < unread, np.nan, held.tensions)
        assert np.isfinite(velocity.step(given, state, known, still, DT, pulls)).all()
        assert (state.tension_error < np.inf) == (unread == 0)
    velocity.step(given, state, known, still, DT, held.tensions)
    velocity.step(given, state, believed(np.full(4, np.nan), PLACE), still, DT, held.tensions)
    assert state.tension_error == np.inf


def test_all_winches_slow_down_equally_where_one_is_too_slow() -> None:
    lengths = solve_inverse(MODEL, PLACE).checked().lengths
    fast, slow = settings(law="paper"), VelocitySettings(MODEL, 0.1, "paper")
    asked = target(PLACE, np.array([0.1, 0.05, 0.0]))
    free = velocity.step(fast, velocity.start(fast), believed(lengths, PLACE), asked, DT)
    bound = velocity.step(slow, velocity.start(slow), believed(lengths, PLACE), asked, DT)
    assert np.abs(bound).max() == pytest.approx(0.1)
    np.testing.assert_allclose(bound / np.linalg.norm(bound), free / np.linalg.norm(free), atol=1e-12)


def test_where_nothing_is_known_winches_stand() -> None:
    nowhere = believed(np.full(4, np.nan), PLACE)
    assert not velocity.step(settings(), velocity.start(settings()), nowhere, target(PLACE, PLACE), DT).any()


@pytest.mark.parametrize("excess", [5e-3, 0.02, 0.1])
def test_sag_is_that_of_the_hanging_line(excess: float) -> None:
    """Against the catenary over its sheave, by the solver; the parabola is a few parts in a hundred off."""
    taut = taut_at(MODEL, PLACE)
    shown = slack.sag_angles(SlackSettings(), taut, np.full(4, excess))
    for line in range(4):
        exact = angle_from_excess(MODEL, PLACE, line, 0.2, excess) - taut.angles[line]
        assert shown[line] == pytest.approx(exact, rel=0.1)


def test_height_follows_the_structure_no_faster_than_allowed() -> None:
    given, lift, ground = HeightControl(1.0), 0.0, 0.08
    heights = []
    for _ in range(20_000):
        lift = height.step(given, lift, 1.0 + lift - ground, DT)
        heights.append(lift)
    assert lift == pytest.approx(ground, abs=1e-6)
    assert np.diff(heights).max() <= given.max_speed * DT + 1e-15
    assert height.step(given, 0.3, float("nan"), DT) == 0.3


def test_what_is_no_controller_is_rejected() -> None:
    with pytest.raises(UnknownName, match="law"):
        settings(law="magic")
    with pytest.raises(InputError, match="gain = -1"):
        settings(gain=-1.0)
    with pytest.raises(InputError, match="is only for a point platform"):
        VelocitySettings(Model(load("cogiro")), 1.0)
    with pytest.raises(InputError, match="clearance = 0"):
        HeightControl(0.0)
