"""The fastest motion: as fast as winches, flow and the job's own limits allow, and no faster."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.analyses.travel_moves import driven_job
from cablewright.control.path_follower import TimedPath
from cablewright.foundation.errors import InputError
from cablewright.printing.job import Job, Motion, load_job
from cablewright.robot import Robot, load
from cablewright.solvers.path_speeds import fed
from cablewright.studies.checks.check import check

WALL = """G21 G90 M83
;LAYER:0
G0 X0 Y0 Z20 F6000
G1 X4000 Y0 E9 F900
G1 X4000 Y3000 E9
G0 X0 Y0 F1200
G1 X2000 Y2000 E9
"""


SKIP = ("interference", "expected-error")


def wall(folder: Path, **motion: Any) -> Job:
    """The job of a wall with that motion, which is not shaped: speeds are the law's own."""
    file = folder / "wall.gcode"
    file.write_text(WALL)
    return Job(name="wall", gcode=file, motion=Motion(shaping="none", **motion))


def quick(robot: Robot, speed: float | None) -> Robot:
    """The robot whose winches have that speed, m/s."""
    lines = [
        each.model_copy(update={"winch": each.winch.model_copy(update={"max_speed": speed})}) for each in robot.lines
    ]
    return robot.model_copy(update={"lines": tuple(lines)})


@pytest.fixture
def house() -> Robot:
    return load("house-printer")


def test_some_winch_is_at_its_limit_and_none_beyond(house: Robot, tmp_path: Path) -> None:
    robot = quick(house, 0.2)
    found = check(robot, wall(tmp_path, speed="fastest", acceleration=20.0, corner_deviation=0.5), skip=SKIP)
    speeds = found.statics.lines.winch_speed
    assert 0.18 < np.nanmax(speeds) <= 0.2
    assert found.law.speed.max() > 0.2


def test_no_more_is_laid_than_can_flow(house: Robot, tmp_path: Path) -> None:
    job = wall(tmp_path, speed="fastest", mass_flow_limit="0.5 kg/s", density="2000 kg/m^3")
    samples = fed(house, job, job.samples(job.toolpath()))
    beads = job.beads(job.toolpath())
    laid = samples.extruding
    flow = samples.speed_limit * [beads.typical.section] * laid
    assert flow.max() == pytest.approx(0.5 / 2000.0)
    assert samples.speed_limit[~laid][1:].max() > samples.speed_limit[laid].max()


def test_flow_limits_the_feeds_of_a_file_too(tmp_path: Path) -> None:
    slow = wall(tmp_path, flow_limit="0.01 l/s").samples(wall(tmp_path).toolpath())
    asis = wall(tmp_path).samples(wall(tmp_path).toolpath())
    assert (slow.speed_limit[asis.extruding] < asis.speed_limit[asis.extruding]).all()
    assert (slow.speed_limit[~asis.extruding] == asis.speed_limit[~asis.extruding]).all()


def test_feeds_do_not_count_and_speeds_of_the_job_do(house: Robot, tmp_path: Path) -> None:
    job = wall(tmp_path, speed="fastest", print_speed=0.4)
    samples = fed(quick(house, 5.0), job, job.samples(job.toolpath()))
    assert np.unique(samples.speed_limit[samples.extruding]) == [0.4]
    assert samples.speed_limit[~samples.extruding][1:].min() > 1.0


def test_where_nothing_limits_it_says_what_would(house: Robot, tmp_path: Path) -> None:
    job = wall(tmp_path, speed="fastest", travel_speed=0.4)
    with pytest.raises(InputError, match=r"nothing limits it: give motion\.print_speed, motion\.flow_limit"):
        fed(quick(house, None), job, job.samples(job.toolpath()))


def test_a_flow_is_given_once(tmp_path: Path) -> None:
    file = tmp_path / "job.toml"
    for text, says in (
        ('mass_flow_limit = "2 kg/s"', "goes with mass_flow_limit"),
        ('density = "2 g/cm^3"', "goes with mass_flow_limit"),
        ('flow_limit = "2 l/s"\nmass_flow_limit = "2 kg/s"\ndensity = "2 g/cm^3"', "flow_limit is given, too"),
        ('flow_limit = "2 kg/s"', "volume flow"),
        ('speed = "quick"', "gcode"),
    ):
        file.write_text(
            f'schema = 1\nname = "x"\n[motion]\n{text}\n[helix]\nradius = 1.0\nlayers = 1\nlayer_height = 0.01\n'
        )
        with pytest.raises(InputError, match=says):
            load_job(file)


def test_a_check_says_what_the_fastest_would_take(house: Robot, tmp_path: Path) -> None:
    robot, limit = quick(house, 0.6), "0.5 l/s"
    slow = check(robot, wall(tmp_path, flow_limit=limit), skip=SKIP)
    fast = check(robot, wall(tmp_path, flow_limit=limit, speed="fastest"), skip=SKIP)
    assert slow.fastest is not None
    assert slow.fastest.duration == pytest.approx(fast.law.duration, rel=0.02)
    assert slow.fastest.bound < slow.fastest.duration < slow.law.duration
    assert check(quick(house, None), wall(tmp_path), skip=SKIP).fastest is None


def test_a_print_goes_as_fast_with_the_valve_open(house: Robot, tmp_path: Path) -> None:
    robot = quick(house, 0.6)
    job, samples = driven_job(robot, wall(tmp_path, flow_limit="0.5 l/s", speed="fastest"))
    path = TimedPath.of(job, samples=samples)
    assert path.speed[path.samples.extruding].max() == pytest.approx(path.print_speed, rel=1e-6)
    assert path.duration == pytest.approx(check(robot, job, skip=SKIP).law.duration, rel=1e-6)
