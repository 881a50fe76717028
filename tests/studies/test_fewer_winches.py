"""A job on robots with fewer winches than degrees of freedom: tilt at rest, nozzle on the path, verdict, accuracy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.models.free_coordinates import free_coordinates, with_free
from cablewright.models.rotation import matrices
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.hanging_path import hung
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.interference import interference

ORIGIN = (1.1, 0.1, -0.3)


@pytest.fixture
def grab() -> Robot:
    """Four lines to a body whose nozzle is not at its origin, so that a tilt moves it."""
    return cw.load("grab-four-lines").with_platform(nozzle=(0.05, -0.03, -0.12))


def _job(folder: Path, corners: list[tuple[float, float, float]]) -> Job:
    lines = ["G21", "G90", "M83", ";LAYER:0"]
    lines += [f"G{int(k > 0)} X{x} Y{y} Z{z}{' E5' if k else ''} F3000" for k, (x, y, z) in enumerate(corners)]
    (folder / "job.gcode").write_text("\n".join(lines) + "\n")
    return load_job(folder / "job.gcode").model_copy(update={"origin": ORIGIN})


def _kept(robot: Robot, lines: tuple[int, ...]) -> Robot:
    return robot.model_copy(update={"lines": tuple(robot.lines[k] for k in lines)})


def test_rotations_are_free_before_the_coordinate_across_the_exit_points(grab: Robot) -> None:
    assert free_coordinates(grab) == [3, 4]
    assert free_coordinates(_kept(grab, (0, 1, 2))) == [3, 4, 5]
    assert free_coordinates(_kept(grab, (0, 1))) == [3, 4, 5, 1]  # both exit points at y = -1.1 m
    assert free_coordinates(_kept(cw.load("paty2021"), (0, 1, 2))) == []
    poses = np.zeros((2, 6))
    assert with_free(cw.load("cogiro"), poses) is poses


def test_nozzle_is_where_it_is_asked_however_the_platform_tilts(grab: Robot) -> None:
    model, at = cw.Model.of(grab), ORIGIN + np.random.default_rng(1).uniform(-0.4, 0.4, (12, 3)) * [1.0, 1.0, 0.2]
    held = solve_inverse(model, hung(model, model.unrotated_at(at)), path=True)
    assert held.ok.all()
    np.testing.assert_allclose(held.nozzle, at, atol=2e-9)
    assert np.degrees(np.abs(held.pose[:, 3:5]).max()) > 1.0
    np.testing.assert_allclose(held.pose[:, 5], 0.0, atol=1e-15)
    back = solve_forward(model, held.lengths, guess=held.pose)
    np.testing.assert_allclose(back.pose, held.pose, atol=1e-8)


def test_check_gives_a_verdict_with_the_tilt(grab: Robot, tmp_path: Path) -> None:
    job = _job(tmp_path, [(0, 0, 0), (150, 0, 0), (150, 100, 0)])
    found = cw.check(grab, job, skip=("interference", "expected-error"))
    assert found.feasible, found.verdict
    assert found.error_compensated.max() < 1e-6
    np.testing.assert_allclose(found.nozzle(found.poses), found.samples.positions, atol=1e-8)
    tilts = np.degrees(np.arccos(matrices(found.poses[:, 3:])[:, 2, 2]))
    assert np.degrees(found.max_tilt) == pytest.approx(tilts.max())
    assert found.to_dict()["max_tilt"] > 0.01
    alone = cw.inverse(grab, np.where(np.isin(np.arange(6), [3, 4]), np.nan, found.poses[-1]))
    np.testing.assert_allclose(found.lengths[-1], alone.lengths, atol=1e-8)


def test_interference_along_the_job_is_at_its_tilt(grab: Robot, tmp_path: Path) -> None:
    found = interference(cw.Model.of(grab), _job(tmp_path, [(0, 0, 0), (40, 0, 0)]))
    assert np.isfinite(found.margins).any()
    assert np.isfinite(found.region.margins).any()


def test_path_off_the_plane_of_two_lines_is_missed(tmp_path: Path) -> None:
    two = _kept(cw.load("grab-four-lines"), (0, 2))  # from opposite corners: it hangs in the plane through both
    plane = _job(tmp_path, [(0, 0, 0), (0, 40, 0)])
    found = cw.check(two, plane, skip=("interference", "expected-error"))
    assert not found.feasible
    assert np.nanmax(found.error_compensated) > 1e-3


def test_accuracy_along_the_job_is_that_of_its_poses(grab: Robot, tmp_path: Path) -> None:
    job = _job(tmp_path, [(0, 0, 0), (60, 0, 0)])
    ranges = cw.load("grab-four-lines").ranges()[:3]
    along = cw.accuracy(grab, job, ranges=ranges, compensation="full", method="first-order")
    held = cw.accuracy(grab, hung(cw.Model.of(grab), along.accuracy.wanted[:1]), ranges=ranges, compensation="full",
                       method="first-order")  # fmt: skip
    assert along.accuracy.ok.all()
    assert along.accuracy.spread.max_error[0] == pytest.approx(held.spread.max_error[0], rel=1e-6)
