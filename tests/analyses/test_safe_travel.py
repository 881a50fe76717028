"""Travel moves that lines can make: the shortest safe way among those tried, and nothing else is changed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.analyses.interference import distances
from cablewright.analyses.travel_moves import led
from cablewright.models.statics import Model
from cablewright.printing.job import Job, Motion
from cablewright.printing.path import Samples
from cablewright.robot import Robot, load
from cablewright.robot.scene import Beam
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.checks.check import check

TWO_WALLS = """G21 G90 M83
;LAYER:0
G0 X-2000 Y-1000 Z200 F6000
G1 X-2000 Y1000 E9 F900
G0 X2000 Y1000 Z200 F6000
G1 X2000 Y-1000 E9 F900
G0 X3000 Y-1000
G1 X3000 Y1000 E9
"""


def job_in(folder: Path, travel: str) -> Job:
    """Two walls with a travel move between them."""
    (folder / "walls.gcode").write_text(TWO_WALLS)
    return Job(name="walls", gcode=folder / "walls.gcode", motion=Motion(travel=travel, shaping="none"))


def with_post(*, height: float) -> Robot:
    """The house printer with a post between the walls."""
    robot = load("house-printer")
    post = Beam(start=(0.0, 1.0, 0.0), end=(0.0, 1.0, height), radius=0.1)
    return robot.model_copy(update={"scene": robot.scene.model_copy(update={"beams": (post,)})})


def margins(robot: Robot, samples: Samples) -> np.ndarray:
    """Distances of lines from the frame at samples that lay nothing, m."""
    rows = ~samples.extruding
    return distances(solve_inverse(Model.full(robot), samples.positions[rows], path=True)).margins[:, 2]


@pytest.mark.parametrize("height", [0.4, 2.0])
def test_a_post_is_passed_over_or_aside_at_the_clearance(tmp_path: Path, height: float) -> None:
    robot, job = with_post(height=height), job_in(tmp_path, "safe")
    asis = job.samples(job.toolpath())
    found, changes = led(Model.full(robot), job, asis, job.beads(job.toolpath()), 0.05)
    assert margins(robot, asis).min() < 0.05 <= margins(robot, found).min()
    assert [each.line for each in changes] == [5]
    assert changes[0].added > 0.0
    assert changes[0].added == pytest.approx(found.travel_length - asis.travel_length)


def test_what_is_laid_and_what_is_safe_stays(tmp_path: Path) -> None:
    robot, job = with_post(height=2.0), job_in(tmp_path, "safe")
    asis = job.samples(job.toolpath())
    found, _ = led(Model.full(robot), job, asis, job.beads(job.toolpath()))
    for name in ("positions", "speed_limit", "layer", "line", "move"):
        assert np.array_equal(getattr(found, name)[found.extruding], getattr(asis, name)[asis.extruding])
    last = asis.line > 6
    assert np.array_equal(found.positions[-int(last.sum()) :], asis.positions[last])
    assert np.diff(found.distance).min() > 0.0
    clear, none = led(Model.full(load("house-printer")), job, asis, job.beads(job.toolpath()))
    assert clear is asis
    assert none == ()


def test_the_nozzle_slows_down_between_the_legs(tmp_path: Path) -> None:
    found = check(with_post(height=2.0), job_in(tmp_path, "safe"), skip=("expected-error",))
    turns = np.diff(found.samples.positions, axis=0)
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    corner = 1 + np.flatnonzero((turns[1:] * turns[:-1]).sum(axis=1) < 0.99)
    assert found.law.speed[corner].max() < 0.2
    assert found.feasible


def test_without_it_the_same_job_is_rejected(tmp_path: Path) -> None:
    found = check(with_post(height=2.0), job_in(tmp_path, "gcode"), skip=("expected-error",))
    assert not found.feasible
    assert "touches" in found.verdict


def test_where_no_way_is_safe_it_stays_and_is_named(tmp_path: Path) -> None:
    robot = load("house-printer")
    wall = tuple(Beam(start=(0.0, y, 0.0), end=(0.0, y, 15.0), radius=0.3) for y in np.arange(-7.5, 7.6, 0.5))
    robot = robot.model_copy(update={"scene": robot.scene.model_copy(update={"beams": wall})})
    job = job_in(tmp_path, "safe")
    asis = job.samples(job.toolpath())
    found, changes = led(Model.full(robot), job, asis, job.beads(job.toolpath()))
    assert found is asis
    assert np.isnan(changes[0].added)
