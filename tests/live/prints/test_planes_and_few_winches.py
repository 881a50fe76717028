"""Closed-loop prints of a platform in a plane and of one that hangs on fewer lines than it has degrees of freedom."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
import planar_robots
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import PrintState
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.run import run_print
from cablewright.machine.log.log import read_log
from cablewright.machine.simulated.machine_file import machine_file
from cablewright.models.path_offset import nearest
from cablewright.printing.job import load_job
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.checks.check import check

JOB = """\
schema = 1
name = "line"
gcode = "line.gcode"
origin = {origin}
[bead]
width = "6 mm"
height = "2 mm"
[motion]
print_speed = {speed}
travel_speed = {speed}
acceleration = {speed}
corner_deviation = "2 mm"
"""


def described(name: str) -> Robot:
    """A robot of the library, or a body in a vertical plane on the upper two lines, which leave its rotation free."""
    if name != "board":
        return cw.load(name)
    values = planar_robots.board(body=True).model_dump(by_alias=True)
    values["lines"] = values["lines"][-2:]
    for line in values["lines"]:
        line["cable"]["diameter"], line["winch"] = 0.003, {"drum_radius": 0.05}
    return Robot.model_validate(values)


@pytest.mark.parametrize(
    ("name", "origin", "speed"),
    [
        ("maslow4", (0.0, 0.258819, 0.965926), 0.1),
        pytest.param("grab-four-lines", (1.1, 0.0, -0.3), 0.1, marks=pytest.mark.slow),
        pytest.param("board", (0.0, 0.02, -0.3), 0.05, marks=pytest.mark.slow),  # a pendulum, which swings
    ],
)
def test_print_follows_its_path_within_the_limits_of_tension(
    name: str, origin: tuple[float, ...], speed: float, tmp_path: Path
) -> None:
    (tmp_path / "line.gcode").write_text(
        "G21\nG90\nM83\n;LAYER:0\nG0 X0 Y0 Z0 F6000\nG1 X60 Y0 Z0 E5\n;LAYER:1\nG1 X0 Y0 Z0 E5\n"
    )
    (tmp_path / "job.toml").write_text(JOB.format(origin=list(origin), speed=speed))
    robot = described(name)
    (tmp_path / "machine.toml").write_text(machine_file(robot))
    options = PrintOptions(seed=3, severity="typical")
    twin = twin_of(robot, load_job(tmp_path / "job.toml"), tmp_path / "machine.toml", options)
    run = run_print(twin, tmp_path / "out", {"robot": name}, {})
    assert run.finished, run.reason
    with read_log(tmp_path / "out") as log:
        seen = [each for each in log.entries() if each.progress and each.progress.state is PrintState.PRINTING]
    for each in seen:
        nozzle = twin.path.printing_point(each.truth.position, each.truth.rotation)
        assert nearest(twin.path.track, nozzle, each.progress.distance).offset < 3e-3
    low, high = np.array([line.tension_limits for line in robot.lines]).T
    tensions = np.array([each.truth.tensions for each in seen])
    assert (tensions >= low).all()
    assert (tensions <= high).all()
    if robot.platform.plane is not None:
        heights = [robot.platform.plane.height(each.truth.position) for each in seen]
        np.testing.assert_allclose(heights, 0.0, atol=1e-9)


@pytest.mark.parametrize(("name", "origin"), [("maslow4", (0.0, 0.258819, 0.965926)), ("ipanema", (0.0, 0.0, 0.8))])
def test_check_judges_the_tensions_that_print_chooses(name: str, origin: tuple[float, ...], tmp_path: Path) -> None:
    (tmp_path / "line.gcode").write_text(
        "G21\nG90\nM83\n;LAYER:0\nG0 X0 Y0 Z0 F6000\nG1 X60 Y0 Z0 E5\n;LAYER:1\nG1 X0 Y0 Z0 E5\n"
    )
    (tmp_path / "job.toml").write_text(JOB.format(origin=list(origin), speed=0.1))
    robot, job = cw.load(name), load_job(tmp_path / "job.toml")
    found = check(robot, job, skip=("interference", "expected-error"))
    assert found.feasible, found.verdict
    plan = plan_print(twin_of(robot, job, None, PrintOptions()))
    held = plan.velocity.model
    assert [line.tension_limits for line in found.chosen.robot.lines] == [ln.tension_limits for ln in held.robot.lines]
    assert found.chosen.preferred == held.preferred
    assert found.reserved
    at_end = solve_inverse(held, found.poses[-1])
    np.testing.assert_allclose(found.statics.tensions[-1], at_end.tensions, rtol=1e-6)


def test_tool_off_the_plane_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "line.gcode").write_text("G21\nG90\nM83\nG1 X60 Y0 Z0 E5 F6000\n")
    robot, options = cw.load("maslow4"), PrintOptions()
    text = machine_file(robot).replace('valve = "0 mm"', 'valve = "20 mm"')
    (tmp_path / "machine.toml").write_text(text)
    with pytest.raises(
        InputError, match=r"drum\.valve = 0\.02 m: must be 0 m: the tool of 'maslow4' works in its plane"
    ):
        twin_of(robot, load_job(tmp_path / "line.gcode"), tmp_path / "machine.toml", options)
