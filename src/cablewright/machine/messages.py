"""Signals as the JSON messages of a log, and back: exactly what was told comes out again.

Scans, inertial readings and encoders have the schemas that Foxglove draws by itself (foxglove.LaserScan, and ROS'
sensor_msgs/Imu and JointState); what those do not hold stands beside as further keys.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import InputError
from cablewright.signals import (
    Climate,
    Command,
    Condition,
    Distance,
    Encoders,
    Inertial,
    LineAngles,
    Notice,
    Reading,
    Scan,
    SensorFrame,
    Truth,
    frozen,
)

__all__ = ["LIDARS", "TOPICS", "Topic", "decode", "encode", "encode_frame"]

Array = NDArray[np.float64]
_Values = dict[str, Any]

LIDARS: Final = ("north", "south", "vertical")

_NUMBER: Final = {"type": "number"}
_TEXT: Final = {"type": "string"}
_MOST: Final = 100_000  # numbers in one array of a message


class Topic(NamedTuple):
    """One channel of a log: its name, its schema's name and the schema."""

    topic: str
    schema: str
    content: _Values


def _object(**properties: Any) -> _Values:
    return {"type": "object", "properties": properties}


def _array(of: Any) -> _Values:
    return {"type": "array", "items": of}


def _vector(*names: str) -> _Values:
    return _object(**dict.fromkeys(names, _NUMBER))


_XYZ = _vector("x", "y", "z")
_XYZW = _vector("x", "y", "z", "w")
_NUMBERS = _array(_NUMBER)
_HEADER = _object(stamp=_object(sec={"type": "integer"}, nanosec={"type": "integer"}), frame_id=_TEXT)
_SCAN = _object(
    timestamp=_object(sec={"type": "integer"}, nsec={"type": "integer"}),
    frame_id=_TEXT,
    pose=_object(position=_XYZ, orientation=_XYZW),
    start_angle=_NUMBER,
    end_angle=_NUMBER,
    ranges=_NUMBERS,
    intensities=_NUMBERS,
    time=_NUMBER,
    ray_period=_NUMBER,
    angle_step=_NUMBER,
)
_IMU = _object(
    header=_HEADER,
    orientation=_XYZW,
    orientation_covariance=_NUMBERS,
    angular_velocity=_XYZ,
    angular_velocity_covariance=_NUMBERS,
    linear_acceleration=_XYZ,
    linear_acceleration_covariance=_NUMBERS,
    time=_NUMBER,
)
_JOINTS = _object(
    header=_HEADER,
    name=_array(_TEXT),
    position=_NUMBERS,
    velocity=_NUMBERS,
    effort=_NUMBERS,
    counts=_array({"type": "integer"}),
    time=_NUMBER,
)
_TRUE: Final = ("position", "velocity", "rotation", "rate", "lengths", "tensions", "excess", "radii")

TOPICS: Final = (
    *(Topic(f"/scan/{name}", "foxglove.LaserScan", _SCAN) for name in LIDARS),
    Topic("/imu", "sensor_msgs/Imu", _IMU),
    Topic("/encoders", "sensor_msgs/JointState", _JOINTS),
    Topic("/line_angles", "cablewright.LineAngles", _object(time=_NUMBER, angles=_array({"type": ["number", "null"]}))),
    Topic("/distance", "cablewright.Distance", _object(time=_NUMBER, distance={"type": ["number", "null"]})),
    Topic("/climate", "cablewright.Climate", _object(time=_NUMBER, temperature=_NUMBER, humidity=_NUMBER)),
    Topic("/command", "cablewright.Command", _object(time=_NUMBER, winch_speeds=_NUMBERS, valve=_NUMBER)),
    Topic(
        "/truth",
        "cablewright.Truth",
        _object(time=_NUMBER, powder=_NUMBER, **dict.fromkeys(_TRUE, _NUMBERS)),
    ),
    Topic(
        "/frame",
        "cablewright.Frame",
        _object(time=_NUMBER, readings={"type": "integer"}, notices=_array(_object(condition=_TEXT, whose=_TEXT))),
    ),
)
"""Every channel a log has. The message on /frame comes last in each step and closes it."""


def encode(signal: Reading | Command | Truth, lines: Sequence[str], counts_per_turn: int) -> tuple[str, bytes]:
    """Return topic and JSON of one signal. *lines* names the lines; *counts_per_turn* is of a motor's encoder."""
    match signal:
        case Scan():
            return f"/scan/{signal.source}", _dump(_scan(signal))
        case Inertial():
            return "/imu", _dump(_imu(signal))
        case Encoders():
            return "/encoders", _dump(_joints(signal, lines, counts_per_turn))
        case LineAngles():
            return "/line_angles", _dump({"time": signal.time, "angles": [_or_null(a) for a in signal.angles.tolist()]})
        case Distance():
            return "/distance", _dump({"time": signal.time, "distance": _or_null(signal.distance)})
        case Climate():
            values = {"time": signal.time, "temperature": signal.temperature, "humidity": signal.humidity}
            return "/climate", _dump(values)
        case Command():
            speeds = np.asarray(signal.winch_speeds).tolist()
            return "/command", _dump({"time": signal.time, "winch_speeds": speeds, "valve": signal.valve})
        case Truth():
            columns = {name: getattr(signal, name).tolist() for name in _TRUE}
            return "/truth", _dump({"time": signal.time, "powder": signal.powder, **columns})


def encode_frame(frame: SensorFrame) -> tuple[str, bytes]:
    """Return topic and JSON of what closes a step: its time, its notices, and how many readings came before."""
    notices = [{"condition": notice.condition.name, "whose": notice.whose} for notice in frame.notices]
    return "/frame", _dump({"time": frame.time, "readings": len(frame.readings), "notices": notices})


def decode(topic: str, data: bytes, origin: str) -> Reading | Command | Truth | SensorFrame | None:
    """Return the signal of a message; a `SensorFrame` without readings for /frame, None for a topic that is not ours.

    Raises `InputError`, naming *origin*, topic and key, for a message that is none.
    """
    reader = _READERS.get(topic)
    if reader is None:
        return None
    try:
        values = json.loads(data)
    except (ValueError, RecursionError):
        raise InputError(f"{origin}: a message of {topic} is no JSON") from None
    message = _Message(values, f"{origin}: a message of {topic}")
    return reader(message, topic)


class _Message:
    """The values of a message, read key by key. Raises `InputError` for what is not as it should be."""

    def __init__(self, values: Any, origin: str) -> None:
        if not isinstance(values, dict):
            raise InputError(f"{origin} is no object")
        self.values, self.origin = values, origin

    def number(self, key: str, absent: float | None = None) -> float:
        value = self.values.get(key)
        if value is None and absent is not None:
            return absent
        if isinstance(value, bool) or not isinstance(value, int | float) or not _finite(value):
            raise InputError(f"{self.origin}: {key}: a finite number is wanted")
        return float(value)

    def numbers(self, key: str) -> Array:
        return frozen(self._list(key, (int, float), "numbers"))

    def numbers_or_nan(self, key: str) -> Array:
        found = self._list(key, (int, float, type(None)), "numbers or null")
        return frozen([math.nan if value is None else value for value in found])

    def integers(self, key: str) -> NDArray[np.int64]:
        found = np.array(self._list(key, (int,), "whole numbers"), dtype=np.int64)
        found.flags.writeable = False
        return found

    def vector(self, key: str, names: str) -> Array:
        inner = _Message(self.values.get(key), f"{self.origin}: {key}")
        return frozen([inner.number(name) for name in names])

    def _list(self, key: str, kinds: tuple[type, ...], what: str) -> list[Any]:
        found = self.values.get(key)
        if not isinstance(found, list) or len(found) > _MOST or not all(_fits(value, kinds) for value in found):
            raise InputError(f"{self.origin}: {key}: a list of {what} is wanted")
        return found


def _fits(value: Any, kinds: tuple[type, ...]) -> bool:
    return isinstance(value, kinds) and not isinstance(value, bool) and _finite(value)


def _finite(value: Any) -> bool:
    """Whether a number of JSON is finite and no longer than a float or a counter holds."""
    return value is None or (abs(value) < 2**63 if isinstance(value, int) else math.isfinite(value))


def _read_scan(message: _Message, topic: str) -> Scan:
    ranges = message.numbers("ranges").copy()
    ranges[ranges == 0.0] = math.nan
    return Scan(
        topic.rpartition("/")[2],
        message.number("time"),
        message.number("ray_period"),
        message.number("start_angle"),
        message.number("angle_step"),
        frozen(ranges),
    )


def _read_imu(message: _Message, _topic: str) -> Inertial:
    acceleration, rate = message.vector("linear_acceleration", "xyz"), message.vector("angular_velocity", "xyz")
    return Inertial(message.number("time"), acceleration, rate)


def _read_joints(message: _Message, _topic: str) -> Encoders:
    return Encoders(message.number("time"), message.integers("counts"))


def _read_angles(message: _Message, _topic: str) -> LineAngles:
    return LineAngles(message.number("time"), message.numbers_or_nan("angles"))


def _read_distance(message: _Message, _topic: str) -> Distance:
    return Distance(message.number("time"), message.number("distance", absent=math.nan))


def _read_climate(message: _Message, _topic: str) -> Climate:
    return Climate(message.number("time"), message.number("temperature"), message.number("humidity"))


def _read_command(message: _Message, _topic: str) -> Command:
    return Command(message.number("time"), message.numbers("winch_speeds"), message.number("valve"))


def _read_truth(message: _Message, _topic: str) -> Truth:
    columns = {name: message.numbers(name) for name in _TRUE}
    for name in _TRUE[:4]:
        if len(columns[name]) != 3:
            raise InputError(f"{message.origin}: {name}: 3 numbers are wanted")
    return Truth(time=message.number("time"), powder=message.number("powder"), **columns)


def _read_frame(message: _Message, _topic: str) -> SensorFrame:
    notices = message.values.get("notices")
    if not isinstance(notices, list):
        raise InputError(f"{message.origin}: notices: a list is wanted")
    return SensorFrame(message.number("time"), (), tuple(_read_notice(each, message.origin) for each in notices))


def _read_notice(values: Any, origin: str) -> Notice:
    name = values.get("condition") if isinstance(values, dict) else None
    if not isinstance(name, str) or name not in Condition.__members__:
        raise InputError(f"{origin}: notices: unknown condition {str(name)[:60]!r}")
    return Notice(Condition[name], str(values.get("whose", ""))[:60])


_READERS: Final[dict[str, Callable[[_Message, str], Reading | Command | Truth | SensorFrame]]] = {
    **{f"/scan/{name}": _read_scan for name in LIDARS},
    "/imu": _read_imu,
    "/encoders": _read_joints,
    "/line_angles": _read_angles,
    "/distance": _read_distance,
    "/climate": _read_climate,
    "/command": _read_command,
    "/truth": _read_truth,
    "/frame": _read_frame,
}


def _scan(scan: Scan) -> _Values:
    sec, nanosec = _stamp(scan.begin)
    return {
        "timestamp": {"sec": sec, "nsec": nanosec},
        "frame_id": f"lidar_{scan.source}",
        "pose": {"position": _named((0.0, 0.0, 0.0)), "orientation": _named((0.0, 0.0, 0.0, 1.0))},
        "start_angle": scan.first_angle,
        "end_angle": scan.first_angle + scan.angle_step * (len(scan.ranges) - 1),
        "ranges": np.nan_to_num(scan.ranges, nan=0.0).tolist(),  # 0 is the RPLIDAR's own word for nothing
        "intensities": [],
        "time": scan.begin,
        "ray_period": scan.period,
        "angle_step": scan.angle_step,
    }


def _imu(reading: Inertial) -> _Values:
    unknown = [-1.0] + [0.0] * 8  # ROS' way to say that there is no such measurement
    return {
        "header": _header(reading.time, "drum"),
        "orientation": _named((0.0, 0.0, 0.0, 1.0)),
        "orientation_covariance": unknown,
        "angular_velocity": _named(reading.rate.tolist()),
        "angular_velocity_covariance": [0.0] * 9,
        "linear_acceleration": _named(reading.acceleration.tolist()),
        "linear_acceleration_covariance": [0.0] * 9,
        "time": reading.time,
    }


def _joints(reading: Encoders, lines: Sequence[str], counts_per_turn: int) -> _Values:
    return {
        "header": _header(reading.time, "winches"),
        "name": list(lines),
        "position": (reading.counts * (2.0 * math.pi / counts_per_turn)).tolist(),
        "velocity": [],
        "effort": [],
        "counts": reading.counts.tolist(),
        "time": reading.time,
    }


def _header(time: float, frame: str) -> _Values:
    sec, nanosec = _stamp(time)
    return {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": frame}


def _stamp(time: float) -> tuple[int, int]:
    return divmod(round(time * 1e9), 1_000_000_000)


def _named(vector: Sequence[float]) -> dict[str, float]:
    return dict(zip("xyzw", vector, strict=False))


def _or_null(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _dump(values: _Values) -> bytes:
    return json.dumps(values, separators=(",", ":")).encode()
