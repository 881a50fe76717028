"""Rigid bodies in the solvers: what a pose may be given as, loads, retraction, and only poses that hang stably."""

from __future__ import annotations

import logging

import numpy as np
import pytest

import cases
from cablewright.foundation.errors import InputError, Status
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot, load
from cablewright.solvers.forward import forward, solve_forward
from cablewright.solvers.inverse import inverse, solve_inverse
from cablewright.solvers.linearise import linearise

COGIRO = load("cogiro")
GRAB = load("grab-four-lines")
JUNG = load("jung2020")


def same(one: Equilibrium, other: Equilibrium, atol: float = 1e-9) -> None:
    """Assert that two equilibria are equal."""
    np.testing.assert_array_equal(one.code, other.code)
    for numbers in ("pose", "lengths", "states"):
        np.testing.assert_allclose(getattr(one, numbers), getattr(other, numbers), rtol=0, atol=atol)


def heavy_above(robot: Robot, height: float) -> Robot:
    """*robot* with its centre of mass at *height* (m) in the platform frame."""
    platform = robot.platform.model_copy(update={"centre_of_mass": (0.0, 0.0, height)})
    return robot.model_copy(update={"name": "heavy-above", "platform": platform})


def steady(found: Equilibrium) -> np.ndarray:
    """Least eigenvalue of the symmetric part of each row's stiffness, over the largest."""
    stiffness = linearise(found).stiffness
    values = np.linalg.eigvalsh(0.5 * (stiffness + np.swapaxes(stiffness, -1, -2)))
    return values[:, 0] / values[:, -1]


@pytest.mark.parametrize("turns", [1, -1, 2, 3])
def test_a_rotation_vector_over_pi_is_shortened_and_logged(turns: int, caplog: pytest.LogCaptureFixture) -> None:
    vector = np.array([0.03, -0.02, 0.05])
    long = vector * (1.0 + turns * 2.0 * np.pi / np.linalg.norm(vector))
    wanted = inverse(COGIRO, [0.5, 0.2, 1.5, *vector]).checked()
    assert not caplog.records
    with caplog.at_level(logging.WARNING, logger="cablewright"):
        found = inverse(COGIRO, [[0.5, 0.2, 1.5, *long], [0.5, 0.2, 1.5, *vector]]).checked()
    assert len(caplog.records) == 1
    assert "exceeds pi" in caplog.text
    np.testing.assert_allclose(found.pose, [wanted.pose, wanted.pose], atol=1e-12)
    np.testing.assert_allclose(found.lengths, [wanted.lengths, wanted.lengths], atol=1e-10)


def test_half_a_turn_is_not_over_pi(caplog: pytest.LogCaptureFixture) -> None:
    found = inverse(COGIRO, [0.0, 0.0, 1.5, 0.0, 0.0, np.pi])
    assert not caplog.records
    assert found.pose[5] == np.pi


def test_a_place_alone_is_unrotated() -> None:
    places = [[0.5, 0.2, 1.5], [-1.0, 2.0, 1.0]]
    same(inverse(COGIRO, places), inverse(COGIRO, [[*place, 0.0, 0.0, 0.0] for place in places]))
    one = inverse(COGIRO, places[0]).checked()
    assert one.pose.tolist() == [*places[0], 0.0, 0.0, 0.0]
    same(forward(COGIRO, one.lengths, guess=places[0]), forward(COGIRO, one.lengths, guess=one.pose))


@pytest.mark.parametrize("pose", [[1.1, 0.0, 0.0], [1.1, 0.0, 0.0, 0.0, 0.0, 0.0], [1.1, 0.0, 0.0, 0.0, 0.0, np.nan]])
def test_four_lines_do_not_hold_six_degrees_of_freedom(pose: list[float]) -> None:
    with pytest.raises(InputError, match=r"^pose: 4 lines hold 4 of the 6 degrees of freedom; .* leave 2 free"):
        inverse(GRAB, pose)


def test_as_many_degrees_of_freedom_are_given_as_there_are_lines() -> None:
    with pytest.raises(InputError, match="3 are given"):
        inverse(GRAB, [1.1, 0.0, 0.0, np.nan, np.nan, np.nan])
    with pytest.raises(InputError, match="none can be free"):
        inverse(COGIRO, [0.0, 0.0, 1.0, np.nan, 0.0, 0.0])
    found = inverse(GRAB, [1.0, 0.1, -0.2, np.nan, np.nan, 0.05]).checked()
    assert found.pose[[0, 1, 2, 5]].tolist() == [1.0, 0.1, -0.2, 0.05]
    assert np.isfinite(found.pose).all()
    assert found.is_valid()


def test_each_row_has_its_own_retraction() -> None:
    lengths = np.linspace(1.2, 2.0, 5)
    held = cases.poses(Model(JUNG), 5)
    poses = held.pose
    found = inverse(JUNG, poses, retraction=lengths)
    drawn = np.linspace(1.98, 2.0, 5)
    back = forward(JUNG, held.lengths, guess=poses, retraction=drawn)
    for row, length in enumerate(lengths):
        same(found[row], inverse(JUNG.retracted(length), poses[row]))
        same(back[row], forward(JUNG.retracted(drawn[row]), held.lengths[row], guess=poses[row]))
    assert back.ok[-1]
    np.testing.assert_allclose(back.pose[-1], poses[-1], atol=1e-9)
    for_all = inverse(JUNG, poses, retraction=1.5)
    same(for_all, inverse(JUNG.retracted(1.5), poses))
    moved = np.linalg.norm(found.platform_points - inverse(JUNG, poses).platform_points, axis=-1)
    assert np.nanmax(moved) == pytest.approx(0.8)


@pytest.mark.parametrize("retraction", [0.5, 2.5, [1.5, 1.5], np.nan, "long", [[1.5]]])
def test_a_retraction_that_is_none_is_rejected(retraction: object) -> None:
    with pytest.raises(InputError, match="retraction"):
        inverse(JUNG, [0.0, 0.0, 1.0], retraction=retraction)


def test_a_robot_without_retraction_takes_none() -> None:
    with pytest.raises(InputError, match="no retraction"):
        inverse(COGIRO, [0.0, 0.0, 1.0], retraction=1.0)


def test_a_wrench_is_the_platforms_own() -> None:
    force, moment = (60.0, -40.0, -100.0), (15.0, -10.0, 20.0)
    platform = COGIRO.platform.model_copy(update={"force": force, "moment": moment})
    described = COGIRO.model_copy(update={"platform": platform})
    lengths = cases.poses(Model(COGIRO), 5).lengths
    moved = forward(COGIRO.under_wrench(force, moment), lengths).checked()
    same(moved, forward(described, lengths))
    still = forward(COGIRO, lengths).checked()
    assert np.linalg.norm(moved.pose[:, :3] - still.pose[:, :3], axis=1).min() > 1e-4
    assert cases.turned(moved.pose, still.pose).min() > 1e-5


def test_a_load_is_the_platform_so_described() -> None:
    values = {"mass": 150.0, "centre_of_mass": (0.1, 0.0, 0.2), "force": (20.0, 0.0, 0.0)}
    given = COGIRO.platform.model_dump() | {"loads": [{"name": "full", **values}]}
    robot = COGIRO.model_copy(update={"platform": type(COGIRO.platform).model_validate(given)})
    described = COGIRO.model_copy(update={"platform": COGIRO.platform.model_copy(update=values)})
    poses = cases.poses(Model(COGIRO), 5).pose
    found = inverse(robot.under_load("full"), poses)
    same(found, inverse(described, poses))
    same(inverse(robot, poses), inverse(COGIRO, poses))
    assert np.nanmin(np.abs(found.lengths - inverse(COGIRO, poses).lengths).max(axis=1)) > 1e-4


@pytest.mark.parametrize("cable", [CableLaw.ELASTIC, CableLaw.CATENARY])
def test_a_body_on_one_line_is_singular(cable: CableLaw) -> None:
    robot = GRAB.model_copy(update={"lines": GRAB.lines[:1]})
    found = solve_forward(Model(robot, Fidelity(cable)), [1.0])
    assert found.status in (Status.SINGULAR, Status.UNDER_EXIT)


@pytest.mark.parametrize("height", [1.5, 3.0, 6.0, 20.0])
@pytest.mark.parametrize("robot", [COGIRO, GRAB, JUNG], ids=lambda robot: robot.name)
def test_forward_never_says_yes_to_a_body_on_its_head(robot: Robot, height: float) -> None:
    lengths = cases.poses(Model(robot), 20).lengths
    model = Model(heavy_above(robot, height))
    rng = np.random.default_rng(3)
    for scatter in (0.0, 0.05):
        found = solve_forward(model, lengths + rng.normal(0.0, scatter, lengths.shape).clip(-0.1, 0.1))
        if found.ok.any():
            assert steady(found[found.ok]).min() > 0.0
            assert found[found.ok].is_valid()


def test_cogiro_hangs_below_its_exit_points_not_in_the_mirror() -> None:
    held = cases.poses(Model(COGIRO), 3000)
    found = solve_forward(held.model, held.lengths)
    assert found.ok.all()
    assert found.platform_points[..., 2].mean(axis=1).max() < 5.4
    assert found.is_valid()
    assert steady(found).min() > 0.0


def test_rows_without_an_answer_have_no_lengths() -> None:
    poses = cases.random_poses(Model(COGIRO), 500)
    poses[:50, 3] += 2.0
    found = solve_inverse(Model(COGIRO), poses)
    none = np.isnan(found.states).any(axis=(1, 2))
    assert none.any()
    assert not found.ok[none].any()
    assert np.isnan(found.lengths[none]).all()
    assert np.isfinite(found.lengths[~none]).all()
    hanging = solve_inverse(Model(GRAB), [[40.0, 0.0, 0.5, np.nan, np.nan, 0.0], [1.1, 0.0, 0.0, np.nan, np.nan, 0.0]])
    assert hanging.ok.tolist() == [False, True]
    assert np.isnan(hanging.lengths[0]).all()
    assert np.isfinite(hanging.lengths[1]).all()
