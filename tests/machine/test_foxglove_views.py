"""What Foxglove draws of a log: frames and a scene, at the times of the machine."""

import json
import shutil
import subprocess
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from cablewright.foundation.signals import Estimate, PrintState, Progress, SensorFrame, Truth, frozen
from cablewright.live.prints.run import log_epoch
from cablewright.machine.files import load_machine
from cablewright.machine.log.foxglove_views import EVERY, Views, quaternion
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import SCHEMAS, LogWriter, read_log
from cablewright.machine.log.mcap_writer import McapWriter
from cablewright.models.rotation import matrices
from cablewright.robot import load
from cases import some

ROOT = Path(__file__).parents[2]
FOXGLOVE = ROOT / "tools" / "foxglove"
EPOCH = datetime(2026, 5, 1, 12, tzinfo=UTC)
ROTATION = np.array([0.05, -0.1, 0.7])


def truth(time, m=4):
    zero = frozen(np.zeros(3))
    lines = frozen(np.ones(m))
    place = frozen([0.1 * time, 0.2, 1.0])
    return Truth(time, place, zero, frozen(ROTATION), zero, lines, lines, frozen([-1, 0.02, -1, -1]), lines, 0.0)


def estimate(time, valid=True):
    lines = frozen(np.ones(4))
    place = frozen([0.1 * time + 0.01, 0.2, 1.0])
    return Estimate(time, place, frozen(np.zeros(3)), frozen(ROTATION), lines, lines, lines > 2, lines, valid=valid)


def messages(*, epoch=EPOCH, true=True, steps=100, valid=True):
    """Topic, log time (s) and content of all messages of a log of 10 ms steps."""
    file = BytesIO()
    head = LogHead(load("merlet2023"), load_machine("merlet2023"), 0.01, epoch=epoch)
    with LogWriter(file, head) as log:
        for k in range(steps):
            time = 0.01 * (k + 1)
            progress = Progress(time, PrintState.PRINTING, 1, time, frozen([0, 0, 1]), 0.0, "")
            told = estimate(time, valid)
            log.write(SensorFrame(time), truth=truth(time) if true else None, estimate=told, progress=progress)
    file.seek(0)
    for _, channel, message in make_reader(file).iter_messages():
        yield channel.topic, 1e-9 * message.log_time, json.loads(message.data)


def test_frames_are_where_the_platform_is():
    found = [(time, value) for topic, time, value in messages() if topic == "/tf"]
    assert np.diff([time for time, _ in found]) == pytest.approx(EVERY, abs=1e-6)
    for time, value in found:
        by_name = {each["child_frame_id"]: each for each in value["transforms"]}
        assert {"drum", "drum_estimate", "lidar_north"} <= by_name.keys()
        true = by_name["drum"]
        assert true["parent_frame_id"] == "world"
        assert true["translation"]["x"] == pytest.approx(0.1 * (time - EPOCH.timestamp()), abs=1e-6)
        assert by_name["drum_estimate"]["translation"]["x"] - true["translation"]["x"] == pytest.approx(0.01)
        assert true["timestamp"]["sec"] in (int(EPOCH.timestamp()), int(EPOCH.timestamp()) + 1)


def test_lines_go_from_exit_points_to_the_platform_and_slack_is_seen():
    entities = {each["id"]: each for topic, _, value in messages() if topic == "/scene" for each in value["entities"]}
    assert {"frame", "platform", "lines"} <= entities.keys()
    (lines,) = entities["lines"]["lines"]
    exits = [line.exit_point for line in load("merlet2023").lines]
    assert [tuple(point.values()) for point in lines["points"][::2]] == exits
    assert len({tuple(point.values()) for point in lines["points"][1::2]}) == 1  # a point platform
    colours = [tuple(each.values()) for each in lines["colors"][::2]]
    assert colours[1] != colours[0] == colours[2]
    path = next(each for name, each in entities.items() if name.startswith("path"))
    assert len(path["lines"][0]["points"]) > 3


def test_the_path_is_the_nozzles_and_what_is_laid_has_its_width():
    entities = [each for topic, _, value in messages() if topic == "/scene" for each in value["entities"]]
    pieces = [each["lines"] for each in entities if each["id"].startswith("path")]
    drum = load_machine("merlet2023").drum
    down = matrices(ROTATION) @ [0.0, 0.0, -drum.valve]
    assert tuple(pieces[0][0]["points"][0].values()) == pytest.approx(truth(0.1).position + down, abs=0.02)
    assert {len(lines) for lines in pieces} == {1}  # powder: of no bead
    robot, machine = load("house-printer"), load_machine("house-printer")
    views = Views(LogHead(robot, machine, 0.01))
    progress = Progress(0.1, PrintState.PRINTING, 1, 0.1, frozen([0, 0, 1]), 0.0, "")
    ((_, scene),) = (each for each in views.content(0.1, truth(0.1), None, progress) if each[0] == "/scene")
    (path,) = (each for each in scene["entities"] if each["id"].startswith("path"))
    strand = path["lines"][1]
    assert (strand["thickness"], strand["scale_invariant"]) == (machine.extrusion.bead.width, False)
    assert strand["points"] == path["lines"][0]["points"]


def test_without_the_truth_the_estimate_is_shown():
    found = [value for topic, _, value in messages(true=False) if topic == "/tf"]
    assert {each["child_frame_id"] for each in found[0]["transforms"]} >= {"drum"}
    assert "drum_estimate" not in {each["child_frame_id"] for each in found[0]["transforms"]}


def test_nothing_is_shown_while_no_pose_is_known():
    topics = {topic for topic, _, _ in messages(true=False, valid=False)}
    assert not topics & {"/tf", "/scene"}


def test_without_an_epoch_times_begin_at_0():
    assert min(time for _, time, _ in messages(epoch=None)) == pytest.approx(0.01)


def test_readers_of_logs_leave_them_out(tmp_path):
    path = tmp_path / "run.mcap"
    head = LogHead(load("merlet2023"), load_machine("merlet2023"), 0.01, epoch=EPOCH)
    with path.open("wb") as file, LogWriter(file, head) as log:
        log.write(SensorFrame(0.01), truth=truth(0.01))
    with read_log(path) as log:
        (entry,) = log.entries()
        assert log.notes == []
    assert entry.frame.time == 0.01
    assert replace(entry.truth, time=0.01).time == 0.01


@pytest.mark.parametrize("seed", some(range(20)))
def testquaternions_turn_as_matrices_do(seed):
    vector = np.random.default_rng(seed).normal(size=3) * 2
    x, y, z, w = quaternion(matrices(vector)).values()
    part, point = np.array([x, y, z]), np.array([0.3, -1.2, 0.5])
    turned = point + 2 * np.cross(part, np.cross(part, point) + w * point)
    assert turned == pytest.approx(matrices(vector) @ point)


def test_a_print_in_real_time_has_the_time_of_the_clock_and_keeps_it(tmp_path):
    assert log_epoch(tmp_path, real_time=False) is None
    begun = log_epoch(tmp_path, real_time=True)
    assert abs(begun - datetime.now(UTC)) < timedelta(seconds=5)
    head = LogHead(load("merlet2023"), load_machine("merlet2023"), 0.01, epoch=EPOCH)
    with (tmp_path / "log-000.mcap").open("wb") as file, LogWriter(file, head) as log:
        log.write(SensorFrame(0.01), truth=truth(0.01))
    assert log_epoch(tmp_path, real_time=True) == EPOCH


@pytest.mark.skipif(
    shutil.which("node") is None or not (FOXGLOVE / "node_modules").is_dir(), reason="needs npm ci in tools/foxglove"
)
def test_foxgloves_own_reader_and_schemas_take_a_log(tmp_path):
    """By @mcap/core and @foxglove/schemas; a message of another shape than theirs is found."""
    path = tmp_path / "own.mcap"
    loop = ROOT / "examples" / "merlet2023-loop.mcap"
    with read_log(loop) as old, path.open("wb") as file, LogWriter(file, old.head) as log:
        for entry in old.entries():
            log.write(entry.frame, entry.command, entry.truth)
    found = _by_foxglove(path)
    for topic, schema in (
        ("/tf", "foxglove.FrameTransforms"), ("/scene", "foxglove.SceneUpdate"), ("/scan/north", "foxglove.LaserScan")
    ):  # fmt: skip
        assert found[topic]["schema"] == schema
    assert all(each["wrong"] is None and each["messages"] > 0 for each in found.values())
    assert {each["child_frame_id"] for each in found["/tf"]["last"]["transforms"]} >= {"drum", "lidar_north"}
    assert {each["id"] for each in found["/scene"]["first"]["entities"]} >= {"frame", "platform", "lines"}
    path = tmp_path / "wrong.mcap"
    with path.open("wb") as file:
        writer = McapWriter(file, {}, SCHEMAS, 1 << 16)
        writer.add("/tf", 1, 1, b'{"transforms": [{"translation": [1, 2, 3]}]}')
        writer.end_chunk()
        writer.finish()
    assert "transforms/0 must have required property 'timestamp'" in _by_foxglove(path)["/tf"]["wrong"]


def _by_foxglove(log):
    command = ["node", "log.mjs", str(log)]
    done = subprocess.run(command, cwd=FOXGLOVE, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
