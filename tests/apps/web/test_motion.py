"""Scenes of machines in motion: the nozzle's way, poses of the platform, and what the lidars saw."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from cablewright.apps.web.detail_levels import unpacked
from cablewright.apps.web.log_scene import log_scene
from cablewright.apps.web.print_scene import print_scene
from cablewright.apps.web.scene import SceneDescription
from cablewright.control.attitude import Attitude
from cablewright.foundation.signals import PrintState, Progress, Scan, SensorFrame, Truth, frozen
from cablewright.live.prints.record import record
from cablewright.machine.files import load_machine
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import Entry, LogWriter, read_log
from cablewright.machine.log.scan_points import MOST
from cablewright.models.rotation import placed
from cablewright.models.statics import Model
from cablewright.printing.arc_length_path import Track
from cablewright.printing.path import Samples
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse

LOOP = Path(__file__).parents[3] / "examples" / "merlet2023-loop.mcap"
TURNED = np.array([0.02, -0.03, 0.05])


@pytest.fixture(scope="module")
def loop() -> SceneDescription:
    return log_scene(LOOP)


def test_lidars_see_the_walls_and_the_floor_where_the_log_has_them(loop: SceneDescription) -> None:
    points = np.concatenate(loop.states.scans)
    assert len(points) > 2000
    assert max(map(len, loop.states.scans)) <= 3 * MOST
    with read_log(LOOP) as log:
        walls = log.head.settings.room.walls
    gaps = [np.abs(points[:, 2] - loop.robot.scene.frame_min[2])]
    for wall in walls:
        start, way = np.array(wall.start), np.subtract(wall.end, wall.start)
        share = np.clip((points[:, :2] - start) @ way / (way @ way), 0.0, 1.0)
        gaps.append(np.linalg.norm(points[:, :2] - start - share[:, None] * way, axis=1))
    assert np.median(np.min(gaps, axis=0)) < 0.01
    assert np.quantile(np.min(gaps, axis=0), 0.9) < 0.05  # the rest: rays of random distance, and people


def test_points_of_each_state_are_in_the_page(loop: SceneDescription) -> None:
    data = json.loads(loop.as_json())
    ends, points = unpacked(data["frames"]["scan_ends"]), unpacked(data["frames"]["scans"])
    assert len(ends) == len(loop.states)
    assert len(points) == ends[-1]
    low, high = data["bounds"]["low"], data["bounds"]["high"]
    step = max(np.subtract(high, low)) / 65_535
    k = int(np.argmax(np.diff(ends))) + 1
    found = points[ends[k - 1] : ends[k]] * step + low
    apart = np.linalg.norm(found[:, None] - loop.states.scans[k][None], axis=2).min(axis=1)
    assert apart.max() < step


def test_old_scans_are_not_shown(tmp_path: Path) -> None:
    path = tmp_path / "silent.mcap"
    with read_log(LOOP) as log:
        entries = list(log.entries())
        head = log.head
    first = next(k for k, entry in enumerate(entries) if entry.frame.of(Scan))
    with path.open("wb") as file, LogWriter(file, head) as log:
        for k, entry in enumerate(entries):
            late, told = (0.0, entry.frame.readings) if k <= first else (10.0, ())
            log.write(SensorFrame(entry.frame.time + late, told), truth=entry.truth)
    found = log_scene(path)
    assert len(found.states.scans[first]) > 100
    assert len(found.states.scans[-1]) == 0


def test_the_way_of_a_log_is_the_nozzles(loop: SceneDescription) -> None:
    with read_log(LOOP) as log:
        nozzle = np.array(log.head.nozzle)
    assert nozzle[2] == -log.head.settings.drum.valve
    places = [placed(pose, [nozzle])[0] for pose in loop.states.poses]
    assert np.allclose(loop.path.positions[loop.states.samples], places, atol=1e-9)


def test_the_way_of_a_bodys_print_is_the_nozzles_and_its_poses_are_the_origins() -> None:
    robot = load("jung2020")
    platform = robot.platform.model_copy(update={"nozzle": (0.02, 0.0, -0.1)})
    robot = robot.model_copy(update={"platform": platform})
    head, nozzle = LogHead(robot, load_machine("jung2020"), 0.1), np.array(platform.nozzle)
    ways = np.column_stack([np.linspace(-0.1, 0.1, 30), np.zeros(30), np.full(30, 0.8)])
    attitude = Attitude.of((), platform.nozzle)
    ones, along = np.ones(30, dtype=np.int32), ways[:, 0] - ways[0, 0]
    track = Track.of(Samples(ways, along, 0.1 * ones, 0.0 * ones, ones.astype(np.int64), ones > 0, ones, ones))
    poses = np.column_stack([ways, np.tile(TURNED, (30, 1))])
    held = solve_inverse(Model(robot), poses)
    printed = record(_entries(poses, held.lengths), head, track, print_speed=0.1, attitude=attitude)
    found = print_scene(printed, "a body")
    assert np.allclose(found.states.poses, poses[found.states.samples], atol=1e-9)
    assert np.allclose(found.path.positions, placed(poses, [nozzle])[:, 0], atol=1e-9)


def _entries(poses: np.ndarray, lengths: np.ndarray) -> list[Entry]:
    zero, made = frozen(np.zeros(3)), []
    for k, (pose, own) in enumerate(zip(poses, lengths, strict=True)):
        time, lines = 0.1 * (k + 1), frozen(np.ones(len(own)))
        truth = Truth(time, frozen(pose[:3]), zero, frozen(pose[3:]), zero, frozen(own), lines, -lines, lines, 0.0)
        progress = Progress(time, PrintState.PRINTING, 1, 0.01 * k, frozen(pose[:3]), 0.0)
        made.append(Entry(SensorFrame(time), None, truth, None, progress))
    return made
