"""A machine's log, or its latest signals, as messages of ROS 2: standard types alone, as mappings of their fields.

Fields that are left out are zero. SI and radians, as ROS has them; a line is a joint that slides: m and N.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final, NamedTuple

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import (
    READINGS,
    SOURCES,
    CameraPose,
    Encoders,
    Estimate,
    Inertial,
    Reading,
    Scan,
    Source,
    per_line,
)
from cablewright.machine.log.fields import XYZ
from cablewright.machine.log.foxglove_views import Views, quaternion
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import Entry
from cablewright.machine.sensors import SENSORS
from cablewright.models.rotation import matrix_of

Fields = Mapping[str, Any]

_POSED: Final = np.r_[0:3, 6:9]  # of an estimate's covariance: position and rotation
_THIN: Final = 2e-3  # of the frame: width of lines, ...
_LETTERS: Final = 0.02  # ... and height of names, which Foxglove has in pixels
_KINDS: Final = {"cubes": 1, "spheres": 2, "cylinders": 3}  # types of Marker
_END: Final = 10**9 << 31  # ns
_LINE_STRIP, _LINE_LIST, _TEXT = 4, 5, 9
_EFFORT: Final = "N"  # unit of a joint that slides


def _topics(sources: Iterable[Source]) -> str:
    return ", ".join(source.topic for source in sources)


class RosMessage(NamedTuple):
    """One message: its topic, type, time (ns since 1970, or since time 0 of a log without an epoch) and fields."""

    topic: str
    type: str
    time: int
    fields: Fields


_SHOWN: Final = (Scan, Inertial, Encoders, CameraPose)
_LEFT: Final = [
    source
    for kind in READINGS
    if kind not in _SHOWN and all(mark.unit != _EFFORT for mark in per_line(kind).values())
    for source in kind.SOURCES
]
_OTHERS: Final = "/command, /order, /progress, notices of frames"
_SENSORS: Final = {sensor.source for sensor in SENSORS}

LEFT_OUT: Final = (
    f"{_topics(each for each in _LEFT if each.name in _SENSORS)}: ROS has no message for such sensors",
    f"{_topics(each for each in _LEFT if each.name not in _SENSORS)}, {_OTHERS}: of cablewright's own types",
)
"""What of a log no message has, a sentence each."""


class RosMessages:
    """Converts one log to ROS messages, step by step."""

    def __init__(self, head: LogHead) -> None:
        """For the robot and machine of *head*."""
        self._head, self._views = head, Views(head)
        self._names, self._winches = [line.name for line in head.robot.lines], list(head.robot.winch_names)
        scene = head.robot.scene
        self._size = float(np.subtract(scene.frame_max, scene.frame_min).max())

    def of(self, entry: Entry) -> Iterator[RosMessage]:
        """Yield the ROS messages of one step."""
        for reading in entry.frame.readings:
            yield from self._reading(reading)
        if entry.truth is not None:
            fields = {
                "header": self._header(entry.truth.time, "world"),
                "pose": _pose(entry.truth.position, entry.truth.rotation),
            }
            yield RosMessage("/truth", "geometry_msgs/msg/PoseStamped", self._time(entry.truth.time), fields)
        if entry.estimate is not None and entry.estimate.valid:
            yield self._estimate(entry.estimate)
        yield from self._lines(entry)
        now = entry.frame.time
        for topic, content in self._views.content(now, entry.truth, entry.estimate, entry.progress):
            if topic == "/tf":
                yield self._tree(now, content)
            else:
                markers = [each for entity in content["entities"] for each in self._markers(entity)]
                scene: Fields = {"markers": markers}
                yield RosMessage("/scene", "visualization_msgs/msg/MarkerArray", self._time(now), scene)

    def latest(self, signal: object, tensions: Array | None) -> Iterator[RosMessage]:
        """Yield the messages of a machine's latest reading or estimate; other signals have none.

        An estimate is followed by its transforms, and by ``/joint_states``: unstrained lengths and the *tensions* (m,)
        that were measured last, N, as efforts.
        """
        if isinstance(signal, Reading):
            yield from self._reading(signal)
        elif isinstance(signal, Estimate) and signal.valid:
            yield self._estimate(signal)
            efforts = {} if tensions is None else {"effort": tensions}
            yield self._joints("/joint_states", signal.time, self._names, position=signal.lengths, **efforts)
            for topic, content in self._views.content(signal.time, None, signal, None):
                if topic == "/tf":
                    yield self._tree(signal.time, content)

    def _tree(self, time: float, content: Fields) -> RosMessage:
        tree = {"transforms": [_transform(each) for each in content["transforms"]]}
        return RosMessage("/tf", "tf2_msgs/msg/TFMessage", self._time(time), tree)

    def _time(self, time: float) -> int:
        made = self._head.epoch_ns + round(max(time, 0.0) * 1e9)
        if not 0 <= made < _END:
            raise InputError(f"{time:g} s after the log's epoch: times of ROS are from 1970 to 2038")
        return made

    def _header(self, time: float, frame: str) -> Fields:
        sec, nanosec = divmod(self._time(time), 1_000_000_000)
        return {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": frame}

    def _reading(self, reading: Reading) -> Iterator[RosMessage]:
        if isinstance(reading, Scan):
            yield self._scan(reading)
        elif isinstance(reading, Inertial):
            fields = {
                "header": self._header(reading.time, "drum"),
                "orientation": {"w": 1.0},
                "orientation_covariance": np.r_[-1.0, np.zeros(8)],  # ROS: there is no such measurement
                "angular_velocity": XYZ.write(reading.rate),
                "linear_acceleration": XYZ.write(reading.acceleration),
            }
            yield RosMessage("/imu", "sensor_msgs/msg/Imu", self._time(reading.time), fields)
        elif isinstance(reading, Encoders):
            turns = np.asarray(reading.counts * (math.tau / self._head.settings.winch.counts))
            yield self._joints("/motors", reading.time, self._winches, position=turns)
        elif isinstance(reading, CameraPose):
            yield self._posed("/camera_pose", reading.time, reading.pose[:3], reading.pose[3:], reading.covariance)
        else:
            for name, mark in per_line(type(reading)).items():
                if mark.unit == _EFFORT:
                    names = self._winches if mark.winch else self._names
                    values = getattr(reading, name)
                    yield self._joints(SOURCES[reading.source].topic, reading.time, names, effort=values)

    def _scan(self, scan: Scan) -> RosMessage:
        lidar = {str(name): each for name, each in self._head.settings.lidars.items()}.get(scan.source)
        count = len(scan.ranges)
        fields = {
            "header": self._header(scan.begin, f"lidar_{scan.source}"),
            "angle_min": scan.first_angle,
            "angle_max": scan.first_angle + scan.angle_step * (count - 1),
            "angle_increment": scan.angle_step,
            "time_increment": scan.period,
            "scan_time": scan.period * count,
            "range_min": 0.0 if lidar is None else lidar.least,
            "range_max": math.inf if lidar is None else lidar.most,
            "ranges": scan.ranges,
        }
        return RosMessage(f"/scan/{scan.source}", "sensor_msgs/msg/LaserScan", self._time(scan.time), fields)

    def _joints(self, topic: str, time: float, names: list[str], **values: Array) -> RosMessage:
        fields = {"header": self._header(time, ""), "name": names, **values}
        return RosMessage(topic, "sensor_msgs/msg/JointState", self._time(time), fields)

    def _estimate(self, told: Estimate) -> RosMessage:
        covariance = np.zeros((6, 6))
        if told.covariance is not None:
            covariance = np.asarray(told.covariance, dtype=float)[np.ix_(_POSED, _POSED)]
        return self._posed("/estimate", told.time, told.position, told.rotation, covariance.ravel())

    def _posed(self, topic: str, time: float, position: Array, rotation: Array, covariance: Array) -> RosMessage:
        pose = {"pose": _pose(position, rotation), "covariance": covariance}
        fields = {"header": self._header(time, "world"), "pose": pose}
        return RosMessage(topic, "geometry_msgs/msg/PoseWithCovarianceStamped", self._time(time), fields)

    def _lines(self, entry: Entry) -> Iterator[RosMessage]:
        """Unstrained lengths, and of a log with the truth tensions."""
        if entry.truth is not None:
            yield self._joints(
                "/lines", entry.truth.time, self._names, position=entry.truth.lengths, effort=entry.truth.tensions
            )
        elif entry.estimate is not None:
            yield self._joints("/lines", entry.estimate.time, self._names, position=entry.estimate.lengths)

    def _markers(self, entity: Fields) -> Iterator[Fields]:
        """The shapes of an entity of the scene, each a marker that the next of its name and number replaces."""
        about = {
            "header": {"stamp": _stamp(entity["timestamp"]), "frame_id": entity["frame_id"]},
            "ns": entity["id"],
            "frame_locked": entity["frame_locked"],
        }
        made: list[Fields] = []
        for key, kind in _KINDS.items():
            made += [
                {"type": kind, "pose": each["pose"], "scale": each["size"], "color": each["color"]}
                for each in entity[key]
            ]
        for each in entity["lines"]:
            wide = self._size * _THIN if each["scale_invariant"] else each["thickness"]
            kind = _LINE_STRIP if each["type"] == 0 else _LINE_LIST
            own = {key: each[key] for key in ("pose", "points", "color", "colors")}
            made.append({"type": kind, "scale": {"x": wide}, **own})
        for each in entity["texts"]:
            scale = {"z": self._size * _LETTERS}
            made.append({"type": _TEXT, "scale": scale, **{key: each[key] for key in ("pose", "color", "text")}})
        yield from ({**about, "id": k, **each} for k, each in enumerate(made))


def _pose(position: Array, rotation: Array) -> Fields:
    turn = quaternion(matrix_of(np.nan_to_num(rotation)))
    return {"position": XYZ.write(position), "orientation": turn}


def _stamp(stamp: Fields) -> Fields:
    return {"sec": stamp["sec"], "nanosec": stamp["nsec"]}


def _transform(given: Fields) -> Fields:
    return {
        "header": {"stamp": _stamp(given["timestamp"]), "frame_id": given["parent_frame_id"]},
        "child_frame_id": given["child_frame_id"],
        "transform": {"translation": given["translation"], "rotation": given["rotation"]},
    }
