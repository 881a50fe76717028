"""A check and a print have the same tensions: one choice of tensions, which leaves a sled pressed on its board."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from tools.pages.line_prints import on_the_board

from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.checks.check import check


def test_the_tensions_of_a_sled_that_a_check_judges_are_those_that_a_print_holds(tmp_path: Path) -> None:
    robot, job = load("maslow4"), on_the_board(tmp_path)
    found = check(robot, job, skip=("interference", "expected-error"))
    assert found.feasible, found.verdict
    plan = plan_print(twin_of(robot, job, built_machine(robot)[0], PrintOptions()))
    held = plan.velocity.model
    np.testing.assert_allclose(
        [line.tension_limits for line in held.robot.lines], [line.tension_limits for line in found.chosen.robot.lines]
    )
    pressed = solve_inverse(held, plan.path.track.positions, path=True).plane_force
    least = solve_inverse(found.chosen.full(robot), plan.path.track.positions, path=True).plane_force
    assert pressed.max() <= 0.5 * least.max() < 0.0
    assert float(np.nanmax(found.statics.plane_force)) < 0.0  # with the motion, too
