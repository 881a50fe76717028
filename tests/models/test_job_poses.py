"""Poses that bring the nozzle along a job's path."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation import memory_mapped
from cablewright.foundation.memory_mapped import Room
from cablewright.models.job_poses import along, path_box, poses_at, sampled
from cablewright.models.plane import within
from cablewright.models.statics import Model
from cablewright.printing.job import Job, load_job
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load

HELIX = Helix(radius=0.5, layers=3, layer_height=0.2, first_height=0.3)
SCHEDULES = {
    "cogiro": ({"z": 0.3, "rotation": (0.0, 0.0, 0.0)}, {"z": 0.9, "rotation": (0.1, 0.05, -0.3)}),
    "jung2020": ({"z": 0.3, "retraction": 1.3}, {"z": 0.9, "retraction": 1.8}),
    "house-printer": (),
}


@pytest.mark.parametrize("name", SCHEDULES)
def test_poses_in_blocks_and_files_are_the_same(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot, job = load(name), Job(name="helix", helix=HELIX, schedule=SCHEDULES[name])
    samples = job.samples(job.toolpath())
    poses, retraction = poses_at(robot, job, samples.positions)
    monkeypatch.setattr(memory_mapped, "BLOCK", 7)
    monkeypatch.setattr(memory_mapped, "SMALL", 1)
    found, drawn = along(robot, job, samples, Room(tmp_path))
    np.testing.assert_array_equal(found, poses)
    if drawn is None:
        np.testing.assert_allclose(Model(robot).nozzle(found), samples.positions, atol=1e-12)
    assert (drawn is None) == (retraction is None) == (name != "jung2020")
    if retraction is not None:
        np.testing.assert_array_equal(drawn, retraction)


def test_the_box_of_a_path_holds_its_samples() -> None:
    job = Job(name="helix", helix=HELIX, scale=2.0, origin=(1.0, -2.0, 0.5))
    toolpath = job.toolpath()
    low, high = path_box(job, toolpath)
    places = job.samples(toolpath).positions
    np.testing.assert_allclose(low, places.min(axis=0), atol=1e-12)
    np.testing.assert_allclose(high, places.max(axis=0), atol=1e-12)


@pytest.mark.parametrize(("decimals", "off"), [(2, 0.0), (3, 0.0), (3, 0.02), (0, 0.4)])
def test_a_path_is_moved_into_a_tilted_plane_by_the_rounding_of_its_file(
    tmp_path: Path, decimals: int, off: float
) -> None:
    robot = load("maslow4")
    plane = robot.platform.plane
    assert plane is not None
    corners = within(plane, np.array([[0.1, 0.0, 0.8], [0.16, 0.0, 0.8], [0.16, 0.0, 0.86]]))
    corners[:, 1] += 1e-3 * off
    moves = (" ".join(f"{a}{1e3 * x:.{decimals}f}" for a, x in zip("XYZ", at, strict=True)) for at in corners)
    (tmp_path / "part.gcode").write_text("G21\nG90\nM83\n" + "".join(f"G1 {move} E5 F600\n" for move in moves))
    job = load_job(tmp_path / "part.gcode")
    samples, _ = sampled(robot, job, job.toolpath())
    heights = samples.positions[1:] @ plane.across  # it begins at 0, 0, 0
    assert (np.abs(heights).max() < 1e-12) == (decimals > 0 and off == 0.0)
