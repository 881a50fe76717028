"""A check and a print have the same tensions: one choice of tensions, which leaves a sled pressed on its board."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tools.pages.line_prints import on_the_board

from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.checks.check import check


def led_up(robot: Robot) -> Robot:
    """A robot in a plane with its exit points on the other side of it, so that its lines pull it off."""
    out, lines = np.array(robot.platform.plane.across), []
    for line in robot.lines:
        along = np.subtract(line.exit_point, line.platform_point)
        there = tuple((along - 2.0 * (along @ out) * out).tolist())
        lines.append(line.model_copy(update={"exit_point": there, "platform_point": (0.0, 0.0, 0.0)}))
    return robot.model_copy(update={"lines": tuple(lines)})


def test_the_library_s_sled_can_draw_its_own_rectangle(tmp_path: Path) -> None:
    """Its belts lead down to the board, over what lies on it, and press it on: more so, the more they pull."""
    robot = load("maslow4")
    found = check(robot, on_the_board(tmp_path))
    assert found.feasible, found.verdict
    assert found.nearest is not None
    assert found.nearest.margin > 0.0
    weight = -robot.platform.mass * robot.scene.gravity * robot.platform.plane.across[2]
    assert float(np.nanmax(found.statics.plane_force)) < weight


@pytest.mark.parametrize("leads", ["down", "up"])
def test_the_tensions_of_a_sled_that_a_check_judges_are_those_that_a_print_holds(tmp_path: Path, leads: str) -> None:
    robot, job = load("maslow4"), on_the_board(tmp_path)
    robot = led_up(robot) if leads == "up" else robot
    found = check(robot, job, skip=("interference", "expected-error"))
    assert found.feasible, found.verdict
    plan = plan_print(twin_of(robot, job, built_machine(robot)[0], PrintOptions()))
    held = plan.velocity.model
    np.testing.assert_allclose(
        [line.tension_limits for line in held.robot.lines], [line.tension_limits for line in found.chosen.robot.lines]
    )
    pressed = solve_inverse(held, plan.path.track.positions, path=True).plane_force
    least = solve_inverse(found.chosen.full(robot), plan.path.track.positions, path=True).plane_force
    assert pressed.max() <= (0.5 if leads == "up" else 1.0) * least.max() < 0.0
    assert float(np.nanmax(found.statics.plane_force)) < 0.0  # with the motion, too
