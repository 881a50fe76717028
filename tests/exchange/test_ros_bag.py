"""Bags of ROS 2, read by rosbags' own reader: what stands in them is what stands in the log."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="needs the extra ros")

from rosbags.highlevel import AnyReader

from cablewright.apps.cli.main import run
from cablewright.exchange.ros.bag import ros_bag
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Estimate, PrintState, Progress, Scan, SensorFrame, frozen
from cablewright.machine.files import load_machine
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import Entry, LogWriter, read_log
from cablewright.models.rotation import matrices
from cablewright.robot import load

LOOP = Path(__file__).parents[2] / "examples" / "merlet2023-loop.mcap"
EPOCH = datetime(2026, 5, 1, 12, tzinfo=UTC)


def read(bag: Path) -> dict[str, list[tuple[int, Any]]]:
    """Times (ns) and messages by topic."""
    found: dict[str, list[tuple[int, Any]]] = {}
    with AnyReader([bag]) as reader:
        for connection, time, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((time, message))
    return found


@pytest.fixture(scope="module")
def entries() -> list[Entry]:
    with read_log(LOOP) as log:
        return list(log.entries())


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[tuple[int, Any]]]:
    out = tmp_path_factory.mktemp("ros") / "loop"
    told = ros_bag(load("merlet2023"), LOOP, out)
    assert {path.name for path in out.iterdir()} == {"loop.mcap", "metadata.yaml"}
    found = read(out)
    assert told.messages == {topic: len(own) for topic, own in found.items()}
    return found


def turned(quaternion: Any) -> np.ndarray:
    """The matrix of a unit quaternion of ROS."""
    x, y, z, w = quaternion.x, quaternion.y, quaternion.z, quaternion.w
    assert x * x + y * y + z * z + w * w == pytest.approx(1.0)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def xyz(point: Any) -> tuple[float, float, float]:
    return point.x, point.y, point.z


def test_poses_are_those_of_the_log(bag, entries) -> None:
    assert len(bag["/truth"]) == len(entries)
    for (time, message), entry in zip(bag["/truth"], entries, strict=True):
        assert time == round(1e9 * entry.truth.time)
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == time
        assert xyz(message.pose.position) == tuple(entry.truth.position)
        assert np.allclose(turned(message.pose.orientation), matrices(entry.truth.rotation), atol=1e-12)


def test_frames_are_a_tree_below_the_world(bag, entries) -> None:
    _, first = bag["/tf"][0]
    frames = {each.child_frame_id: each for each in first.transforms}
    assert {"drum", "lidar_north", "lidar_south", "lidar_vertical"} <= frames.keys()
    assert all(each.header.frame_id in {"world", *frames} for each in frames.values())
    assert xyz(frames["drum"].transform.translation) == tuple(entries[0].truth.position)
    settings = load_machine("merlet2023").lidars["vertical"]
    x, y = np.array(settings.axes)
    assert np.allclose(turned(frames["lidar_vertical"].transform.rotation), np.column_stack([x, y, np.cross(x, y)]))


def test_scans_and_joints_are_those_of_the_log(bag, entries) -> None:
    logged = [scan for entry in entries for scan in entry.frame.of(Scan) if scan.source == "north"]
    for (_, message), scan in zip(bag["/scan/north"], logged, strict=True):
        assert np.allclose(message.ranges, scan.ranges, rtol=1e-6, equal_nan=True)
        assert message.angle_min == pytest.approx(scan.first_angle)
        assert message.angle_max == pytest.approx(scan.angles[-1])
        assert message.time_increment == pytest.approx(scan.period)
        assert (message.range_min, message.range_max) == (pytest.approx(0.15), pytest.approx(12.0))
    _, joints = bag["/lines"][-1]
    assert joints.name == [line.name for line in load("merlet2023").lines]
    assert joints.position.tolist() == entries[-1].truth.lengths.tolist()
    assert joints.effort.tolist() == entries[-1].truth.tensions.tolist()


def test_the_scene_has_lines_from_exit_points_to_the_platform(bag, entries) -> None:
    _, first = bag["/scene"][0]
    names = {marker.ns for marker in first.markers}
    assert {"frame", "platform", "lines"} <= names
    assert len({(marker.ns, marker.id) for marker in first.markers}) == len(first.markers)
    _, last = bag["/scene"][-1]
    (lines,) = (marker for marker in last.markers if marker.ns == "lines")
    assert lines.type == lines.LINE_LIST
    assert lines.scale.x > 0.0
    assert [xyz(each) for each in lines.points[::2]] == [line.exit_point for line in load("merlet2023").lines]
    assert np.allclose([xyz(each) for each in lines.points[1::2]], entries[-1].truth.position)
    assert len(lines.colors) == len(lines.points)
    texts = {marker.text for marker in first.markers if marker.type == marker.TEXT_VIEW_FACING}
    assert texts == {line.name for line in load("merlet2023").lines}


def _logged(path: Path, epoch: datetime | None, covariance: np.ndarray) -> None:
    head = LogHead(load("merlet2023"), load_machine("merlet2023"), 0.1, kind="real", epoch=epoch)
    zero, lines = frozen(np.zeros(3)), frozen(np.ones(4))
    with path.open("wb") as file, LogWriter(file, head) as log:
        for k in range(1, 30):
            place = frozen([0.01 * k, 0.2, 1.0])
            told = Estimate(0.1 * k, place, zero, zero, lines, lines, lines > 2, lines, covariance, valid=k > 5)
            progress = Progress(0.1 * k, PrintState.PRINTING, 1, 0.01 * k, place, 0.0)
            log.write(SensorFrame(0.1 * k), estimate=told, progress=progress)


def test_a_real_machines_log_has_the_estimate_its_covariance_and_the_time_of_day(tmp_path) -> None:
    covariance = np.random.default_rng(1).normal(size=(9, 9))
    _logged(tmp_path / "real.mcap", EPOCH, covariance)
    ros_bag(load("merlet2023"), tmp_path / "real.mcap", tmp_path / "bag")
    found = read(tmp_path / "bag")
    assert "/truth" not in found
    assert len(found["/estimate"]) == 24  # not those that are not valid
    time, message = found["/estimate"][0]
    assert time == round(1e9 * EPOCH.timestamp()) + 600_000_000
    own = message.pose.covariance.reshape(6, 6)
    assert np.array_equal(own[:3, 3:], covariance[:3, 6:])
    assert np.array_equal(own[3:, 3:], covariance[6:, 6:])
    strips = [m for _, scene in found["/scene"] for m in scene.markers if m.type == m.LINE_STRIP]
    assert len(strips[-1].points) > 10


def test_times_that_ros_does_not_have_are_rejected(tmp_path) -> None:
    _logged(tmp_path / "late.mcap", datetime(2040, 1, 1, tzinfo=UTC), np.zeros((9, 9)))
    with pytest.raises(InputError, match="from 1970 to 2038"):
        ros_bag(load("merlet2023"), tmp_path / "late.mcap", tmp_path / "bag")
    assert not (tmp_path / "bag").exists()


def test_the_command(tmp_path, capsys) -> None:
    half = tmp_path / "half.mcap"
    half.write_bytes(LOOP.read_bytes()[: int(0.9 * LOOP.stat().st_size)])
    assert run(["export", "ros2", "merlet2023", str(half), "--out", str(tmp_path / "bag"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["messages"]["/tf"] == len(read(tmp_path / "bag")["/tf"])
    assert any("cut or damaged" in each for each in told["lost"])
    for words, says in (
        (("cogiro", str(half)), "belongs to robot 'merlet2023', not to 'cogiro'"),
        (("merlet2023",), "expected a machine's LOG"),
        (("merlet2023", str(tmp_path / "no.mcap")), "no such file"),
        (("merlet2023", __file__), "is not a log of a machine"),
    ):
        assert run(["export", "ros2", *words, "--out", str(tmp_path / "other")]) == 2
        assert says in capsys.readouterr().err
        assert not (tmp_path / "other").exists()
