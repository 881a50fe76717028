"""Conversion of signals to the JSON messages of a log, and back, exactly."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic_core import from_json, to_json

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import SOURCES, Encoders, Inertial, Reading, Scan, SensorFrame, frozen
from cablewright.machine.log.fields import NOTICES, XYZ, XYZW, as_it_is, listed, read_object
from cablewright.machine.log.topics import TOPICS, Signal, Topic

_BY_NAME: Final = {each.topic: each for each in TOPICS}
_BY_SIGNAL: Final = {each.signal: each.topic for each in TOPICS if not each.source}


class _Writer(NamedTuple):
    """What makes JSON of a signal's values: keys, their attributes, those that are arrays, and functions of others."""

    keys: tuple[str, ...]
    attributes: Callable[[Any], tuple[Any, ...]]
    arrays: tuple[str, ...]
    others: tuple[tuple[str, Callable[[Any], Any]], ...]

    @classmethod
    def of(cls, topic: Topic) -> _Writer:
        """Return the writer of the messages of a *topic*."""
        kinds = topic.kinds.items()
        attributes = attrgetter(*(topic.renamed.get(key, key) for key in topic.kinds))
        arrays = tuple(key for key, kind in kinds if kind.write is listed)
        others = tuple((key, kind.write) for key, kind in kinds if kind.write not in (as_it_is, listed))
        return cls(tuple(topic.kinds), attributes, arrays, others)


_WRITERS: Final = {each.topic: _Writer.of(each) for each in TOPICS if each.signal is not SensorFrame}
_MAX_RANGE: Final = 99.99  # m, of ranges that are written by table ...
_STEPS: Final = 1e5  # ... in steps of 10 um: so many a metre
_NOT_TURNED: Final = XYZW.write((0.0, 0.0, 0.0, 1.0))
_ZEROS: Final = (0.0,) * 9
_UNKNOWN: Final = (-1.0, *_ZEROS[1:])  # ROS: there is no such measurement
_EMPTY: Final = ()


def encode(signal: Signal, winches: Sequence[str], counts_per_turn: int, epoch: int = 0) -> tuple[str, bytes]:
    """Return topic and JSON of one signal. *winches* names the winches; *counts_per_turn* is of a motor's encoder.

    *epoch*: time 0, ns since 1970, for the stamps that others read.
    """
    kind = type(signal)
    topic = _BY_SIGNAL.get(kind) or SOURCES[signal.source].topic  # type: ignore[union-attr]
    foreign = _FOREIGN.get(kind)
    if foreign is not None:
        return topic, foreign(signal, winches, counts_per_turn, epoch)
    keys, attributes, arrays, others = _WRITERS[topic]
    values = dict(zip(keys, attributes(signal), strict=True))
    for key in arrays:
        value = values[key]
        values[key] = value.tolist() if type(value) is np.ndarray else listed(value)
    for key, write in others:
        shown = write(values[key])
        if shown is None:
            del values[key]
        else:
            values[key] = shown
    return topic, _dump(values)


def encode_frame(frame: SensorFrame) -> bytes:
    """Return the JSON of the message that closes a step: its time, notices and number of readings."""
    values = {"time": frame.time, "readings": len(frame.readings), "notices": NOTICES.write(frame.notices)}
    return _dump(values)


def decode(name: str, data: bytes, origin: str) -> Signal | SensorFrame | None:
    """Return the signal of a message of the topic *name*; a `SensorFrame` without readings for /frame.

    None for a topic that is not ours. Raises `InputError`, naming *origin*, topic and key, for an invalid message.
    """
    topic = _BY_NAME.get(name)
    if topic is None:
        return None
    try:
        values = from_json(data)
    except ValueError:
        raise InputError(f"{origin}: a message of {name} is not valid JSON") from None
    try:
        found = read_object(topic.kinds, values)
    except ValueError as reason:
        raise InputError(f"{origin}: a message of {name}: {reason}") from None
    if topic.signal is Scan:
        found["ranges"] = frozen(np.where(found["ranges"], found["ranges"], np.nan))
    if issubclass(topic.signal, Reading) and len(topic.signal.SOURCES) > 1:
        found["source"] = topic.source
    return topic.signal(**{topic.renamed.get(key, key): value for key, value in found.items()})


@functools.cache
def _tables() -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Texts of 0.00 to 99.99, five letters each, and of three digits more and a comma."""
    whole = "".join(f"{k // 100:2}.{k % 100:02}" for k in range(10_000))
    rest = "".join(f"{k:03}," for k in range(1000))
    return _letters(whole, 5), _letters(rest, 4)


def _letters(text: str, width: int) -> NDArray[np.uint8]:
    return np.frombuffer(text.encode(), dtype=np.uint8).reshape(-1, width)


def _ranges(ranges: Array) -> bytes:
    """*ranges* as JSON. A lidar's are whole numbers of some grain, which tables write several times as fast."""
    if (ranges < _MAX_RANGE).all():  # not with infinite values
        counts = np.rint(ranges * _STEPS).astype(np.int64)
        if (counts >= 0).all() and (counts / _STEPS == ranges).all():
            whole, rest = _tables()
            return b"[" + np.hstack([whole[counts // 1000], rest[counts % 1000]]).tobytes()[:-1] + b"]"
    return to_json(ranges.tolist())


def _scan(scan: Scan, _winches: Sequence[str], _counts_per_turn: int, epoch: int) -> bytes:
    sec, nanosec = _stamp(scan.begin, epoch)
    values = {
        "timestamp": {"sec": sec, "nsec": nanosec},
        "frame_id": f"lidar_{scan.source}",
        "pose": {"position": XYZ.write((0.0, 0.0, 0.0)), "orientation": _NOT_TURNED},
        "start_angle": scan.first_angle,
        "end_angle": scan.first_angle + scan.angle_step * (len(scan.ranges) - 1),
        "intensities": [],
        "time": scan.begin,
        "ray_period": scan.period,
        "angle_step": scan.angle_step,
    }
    ranges = np.where(np.isnan(scan.ranges), 0.0, scan.ranges)  # 0 is the RPLIDAR's own value without an echo
    return _dump(values)[:-1] + b',"ranges":' + _ranges(ranges) + b"}"


def _imu(reading: Inertial, _winches: Sequence[str], _counts_per_turn: int, epoch: int) -> bytes:
    sec, nanosec = _stamp(reading.time, epoch)
    (x, y, z), (ax, ay, az) = reading.rate.tolist(), reading.acceleration.tolist()
    return _dump(
        {
            "header": {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": "drum"},
            "orientation": _NOT_TURNED,
            "orientation_covariance": _UNKNOWN,
            "angular_velocity": {"x": x, "y": y, "z": z},
            "angular_velocity_covariance": _ZEROS,
            "linear_acceleration": {"x": ax, "y": ay, "z": az},
            "linear_acceleration_covariance": _ZEROS,
            "time": reading.time,
        }
    )


def _joints(reading: Encoders, winches: Sequence[str], counts_per_turn: int, epoch: int) -> bytes:
    sec, nanosec = _stamp(reading.time, epoch)
    return _dump(
        {
            "header": {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": "winches"},
            "name": winches,
            "position": (reading.counts * (2.0 * math.pi / counts_per_turn)).tolist(),
            "velocity": _EMPTY,
            "effort": _EMPTY,
            "counts": reading.counts.tolist(),
            "time": reading.time,
        }
    )


_FOREIGN: Final[Mapping[type, Callable[[Any, Sequence[str], int, int], bytes]]] = {
    Scan: _scan,
    Inertial: _imu,
    Encoders: _joints,
}
"""What writes the messages whose schemas are of other programs."""


def _stamp(time: float, epoch: int) -> tuple[int, int]:
    return divmod(epoch + round(time * 1e9), 1_000_000_000)


def _dump(values: dict[str, Any]) -> bytes:
    """As JSON; unknown values, NaN or infinite, as null."""
    return to_json(values, inf_nan_mode="null")
