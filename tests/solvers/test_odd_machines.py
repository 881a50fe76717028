"""Machines no library robot is like: heavy cables, no upper limit, lines overhead or in one plane, far frames."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise

SQUARE = [(-5.0, -5.0, 10.0), (5.0, -5.0, 10.0), (5.0, 5.0, 10.0), (-5.0, 5.0, 10.0)]
TRIANGLE = [(-5.0, -5.0, 10.0), (5.0, -5.0, 10.0), (0.0, 6.0, 10.0)]


def machine(exits, mass: float = 10.0, density: float = 0.05, limits=(1.0, 500.0), offset=(0.0, 0.0, 0.0)) -> Robot:
    """A point platform on eyelet lines of 1 MN."""
    cable = {"axial_stiffness": 1e6, "linear_density": density, "breaking_load": 1e12}
    lines = [
        {
            "name": f"line {i}",
            "exit_point": tuple(a + b for a, b in zip(exit_point, offset, strict=True)),
            "cable": cable,
            "sheave": {"kind": "eyelet"},
            "tension_limits": limits,
        }
        for i, exit_point in enumerate(exits)
    ]
    scene = {"frame_min": (-1e8,) * 3, "frame_max": (1e8,) * 3}
    return Robot.model_validate({"name": "odd", "scene": scene, "platform": {"mass": mass}, "lines": lines})


def poses(count: int = 300) -> np.ndarray:
    return np.random.default_rng(0).uniform([-3, -3, 1], [3, 3, 8], (count, 3))


def test_a_platform_lighter_than_its_cables() -> None:
    held = solve_inverse(Model(machine(SQUARE, mass=1.0)), poses()).checked()
    assert held.is_valid()
    back = solve_forward(held.model, held.lengths).checked()
    assert np.abs(back.pose - held.pose).max() < 1e-9


@pytest.mark.parametrize("most", [1e5, 1e8, 1e11, 1e12])
def test_a_limit_that_limits_nothing_changes_nothing(most: float) -> None:
    plain = solve_inverse(Model(machine(TRIANGLE)), poses())
    wide = solve_inverse(Model(machine(TRIANGLE, limits=(1.0, most))), poses())
    assert wide[wide.ok].is_valid()
    assert (plain.ok[wide.ok]).all()
    assert (wide.code != plain.code).sum() <= 4  # beyond 1e11 N rounding may keep an answer back, never change it


@pytest.mark.parametrize("aside", [1e-11, 1e-9, 1e-7, 1e-6, 1e-5])
def test_three_lines_in_a_plane_hold_nothing_beside_it(aside: float) -> None:
    found = solve_inverse(Model(machine([(-5, 0, 10), (5, 0, 10), (0, 0, 11)])), [1.0, aside, 4.0])
    assert not found.ok


def test_a_slack_massless_line_moves_nothing() -> None:
    model = Model(machine(SQUARE, density=0.0), Fidelity(CableLaw.ELASTIC))
    lengths = solve_inverse(model, [0.5, 0.3, 4.0]).lengths + np.array([3.0, 0.0, 0.0, 0.0])
    motion = linearise(solve_forward(model, lengths)).per_length
    np.testing.assert_array_equal(motion[:, 0], 0.0)
    for i in (1, 2, 3):
        ends = [solve_forward(model, lengths + sign * 1e-5 * np.eye(4)[i]).checked().pose for sign in (1, -1)]
        np.testing.assert_allclose(motion[:, i], (ends[0] - ends[1]) / 2e-5, atol=1e-4)


def test_rigid_cables_have_no_stiffness() -> None:
    held = solve_inverse(Model(machine(SQUARE), Fidelity(CableLaw.RIGID)), [0.5, 0.3, 4.0])
    with pytest.raises(InputError, match="rigid"):
        linearise(held)


@pytest.mark.parametrize("length", [5.0, 5.5, 6.0, 6.5, 7.0, 8.0])
def test_a_slack_line_from_overhead(length: float) -> None:
    found = solve_forward(Model(machine([*SQUARE, (0, 0, 10)], limits=(1, 5e4))), [8.5, 8.6, 8.7, 8.6, length])
    assert found.is_valid()


@pytest.mark.parametrize("turned", [False, True])
def test_three_lines_in_a_plane(turned: bool) -> None:
    exits = [(y, 0, 10) if turned else (0, y, 10) for y in (-5, 0, 5)]
    found = solve_forward(Model(machine(exits)), [7.0, 9.0, 7.5])
    assert found.is_valid()
    across = found.pose[1 if turned else 0]
    assert abs(across) < 1e-9


def test_a_weight_on_one_line_hangs_under_its_exit() -> None:
    found = solve_forward(Model(machine([(0, 0, 10)])), [5.0])
    assert found.is_valid()
    assert np.abs(found.pose[:2]).max() < 1e-8


def test_a_frame_far_from_the_origin() -> None:
    offset = np.array([5e6, 4e6, 0.0])  # eastings and northings
    near = solve_inverse(Model(machine(SQUARE)), [0.5, 0.3, 4.0]).checked()
    model = Model(machine(SQUARE, offset=tuple(offset)))
    back = solve_forward(model, near.lengths).checked()
    np.testing.assert_allclose(back.pose - offset, near.pose, atol=1e-8)


def test_no_answer_has_no_numbers() -> None:
    found = solve_inverse(Model(machine(TRIANGLE)), [40.0, 0.0, 5.0])
    assert not found.ok
    for numbers in (found.lengths, found.tensions, found.residual_norm(), found.unbalanced_force()):
        assert np.isnan(numbers).all()
