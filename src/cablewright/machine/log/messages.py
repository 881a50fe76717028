"""Signals as the JSON messages of a log, and back, exactly."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic_core import from_json, to_json

from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.machine.log.topics import ESTIMATE_FIELDS, LIDARS, TRUTH_FIELDS
from cablewright.signals import (
    Barrier,
    Climate,
    Command,
    Condition,
    Distance,
    Encoders,
    Estimate,
    Fault,
    Inertial,
    LineAngles,
    Notice,
    PrintState,
    Progress,
    Reading,
    Scan,
    SensorFrame,
    Truth,
    frozen,
)

Signal = Reading | Command | Truth | Estimate | Progress
"""Types with a message of their own."""

TOPICS_OF: Final[dict[type[Signal], tuple[str, ...]]] = {
    Scan: tuple(f"/scan/{name}" for name in LIDARS),
    Inertial: ("/imu",),
    Encoders: ("/encoders",),
    LineAngles: ("/line_angles",),
    Distance: ("/distance",),
    Climate: ("/climate",),
    Barrier: ("/barrier",),
    Command: ("/command",),
    Truth: ("/truth",),
    Estimate: ("/estimate",),
    Progress: ("/progress",),
}
"""Topics of each type of signal."""

_Values = dict[str, Any]

_MAX_NUMBERS: Final = 100_000  # numbers in one array of a message
_MAX_RANGE: Final = 99.99  # m, of ranges that are written by table ...
_STEPS: Final = 1e5  # ... in steps of 10 um: so many a metre
_COVARIANCE: Final = 9  # rows of an estimate's covariance


def encode(signal: Signal, lines: Sequence[str], counts_per_turn: int) -> tuple[str, bytes]:
    """Return topic and JSON of one signal. *lines* names the lines; *counts_per_turn* is of a motor's encoder."""
    match signal:
        case Scan():
            return f"/scan/{signal.source}", _scan(signal)
        case Inertial():
            return "/imu", _dump(_imu(signal))
        case Encoders():
            return "/encoders", _dump(_joints(signal, lines, counts_per_turn))
        case LineAngles():
            return "/line_angles", _dump({"time": signal.time, "angles": signal.angles.tolist()})
        case Distance():
            return "/distance", _dump({"time": signal.time, "distance": signal.distance})
        case Climate():
            values = {"time": signal.time, "temperature": signal.temperature, "humidity": signal.humidity}
            return "/climate", _dump(values)
        case Command():
            speeds = np.asarray(signal.winch_speeds).tolist()
            return "/command", _dump({"time": signal.time, "winch_speeds": speeds, "valve": signal.valve})
        case Truth():
            columns = {name: getattr(signal, name).tolist() for name in TRUTH_FIELDS}
            return "/truth", _dump({"time": signal.time, "powder": signal.powder, **columns})
        case Barrier():
            return "/barrier", _dump({"time": signal.time, "broken": signal.broken})
        case Estimate():
            return "/estimate", _dump(_estimate(signal))
        case Progress():
            return "/progress", _dump(_progress(signal))


def encode_frame(frame: SensorFrame) -> tuple[str, bytes]:
    """Return topic and JSON of the message that closes a step: its time, notices and number of readings."""
    notices = [{"condition": notice.condition.name, "whose": notice.subject} for notice in frame.notices]
    return "/frame", _dump({"time": frame.time, "readings": len(frame.readings), "notices": notices})


def decode(topic: str, data: bytes, origin: str) -> Signal | SensorFrame | None:
    """Return the signal of a message; a `SensorFrame` without readings for /frame, None for a topic that is not ours.

    Raises `InputError`, naming *origin*, topic and key, for a message that is none.
    """
    reader = _READERS.get(topic)
    if reader is None:
        return None
    try:
        values = from_json(data)
    except ValueError:
        raise InputError(f"{origin}: a message of {topic} is no JSON") from None
    message = _Message(values, f"{origin}: a message of {topic}")
    return reader(message, topic)


class _Message:
    """The values of a message, read key by key. Raises `InputError` for an invalid value."""

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
        return self._floats(key, (int, float), "numbers")

    def numbers_or_nan(self, key: str) -> Array:
        return self._floats(key, (int, float, type(None)), "numbers or null")

    def integers(self, key: str) -> NDArray[np.int64]:
        values = self._list(key, (int,), "whole numbers")
        if not all(map(_finite, values)):
            raise self._no_list(key, "whole numbers")
        found = np.array(values, dtype=np.int64)
        found.flags.writeable = False
        return found

    def flag(self, key: str) -> bool:
        value = self.values.get(key)
        if not isinstance(value, bool):
            raise InputError(f"{self.origin}: {key}: true or false is wanted")
        return value

    def text(self, key: str, max_length: int = 300) -> str:
        value = self.values.get(key)
        if not isinstance(value, str) or len(value) > max_length:
            raise InputError(f"{self.origin}: {key}: a text of at most {max_length} letters is wanted")
        return value

    def vector(self, key: str, names: str) -> Array:
        inner = _Message(self.values.get(key), f"{self.origin}: {key}")
        return frozen([inner.number(name) for name in names])

    def _list(self, key: str, kinds: tuple[type, ...], what: str) -> list[Any]:
        found = self.values.get(key)
        if not isinstance(found, list) or len(found) > _MAX_NUMBERS or not set(map(type, found)) <= set(kinds):
            raise self._no_list(key, what)
        return found

    def _floats(self, key: str, kinds: tuple[type, ...], what: str) -> Array:
        """A list as floats; null is NaN, and nothing else is."""
        values = self._list(key, kinds, what)
        try:
            found = np.array(values, dtype=np.float64)
        except OverflowError:
            raise self._no_list(key, what) from None
        if np.count_nonzero(np.isfinite(found)) + values.count(None) < len(values):
            raise self._no_list(key, what)
        found.flags.writeable = False
        return found

    def _no_list(self, key: str, what: str) -> InputError:
        return InputError(f"{self.origin}: {key}: a list of {what} is wanted")


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
    columns = {name: message.numbers(name) for name in TRUTH_FIELDS}
    for name in TRUTH_FIELDS[:4]:
        if len(columns[name]) != 3:
            raise InputError(f"{message.origin}: {name}: 3 numbers are wanted")
    return Truth(time=message.number("time"), powder=message.number("powder"), **columns)


def _read_barrier(message: _Message, _topic: str) -> Barrier:
    return Barrier(message.number("time"), message.flag("broken"))


def _read_estimate(message: _Message, _topic: str) -> Estimate:
    columns = {name: message.numbers_or_nan(name) for name in ESTIMATE_FIELDS}
    slack, faults = message.values.get("slack"), message.values.get("faults")
    covariance = message.numbers("covariance")
    if not isinstance(slack, list) or not all(isinstance(each, bool) for each in slack):
        raise InputError(f"{message.origin}: slack: a list of true or false is wanted")
    if len(covariance) not in (0, _COVARIANCE**2):
        raise InputError(f"{message.origin}: covariance: none or {_COVARIANCE**2} numbers are wanted")
    if not isinstance(faults, list) or len(faults) > _MAX_NUMBERS:
        raise InputError(f"{message.origin}: faults: a list is wanted")
    inner = (_Message(each, f"{message.origin}: faults") for each in faults)
    return Estimate(
        message.number("time"),
        slack=np.array(slack, dtype=np.bool_),
        covariance=frozen(covariance.reshape(_COVARIANCE, _COVARIANCE)) if len(covariance) else None,
        faults=tuple(Fault(each.text("source"), each.number("since"), each.text("sentence")) for each in inner),
        valid=message.flag("valid"),
        clearance=message.number("clearance", absent=math.nan),
        **columns,
    )


def _read_progress(message: _Message, _topic: str) -> Progress:
    state, layer, target = message.text("state"), message.values.get("layer"), message.numbers("target")
    if state not in PrintState.__members__.values():
        raise InputError(f"{message.origin}: state: unknown state {state[:60]!r}")
    if type(layer) is not int or len(target) != 3:
        raise InputError(f"{message.origin}: a whole number as layer and 3 numbers as target are wanted")
    return Progress(
        message.number("time"),
        PrintState(state),
        layer,
        message.number("distance"),
        target,
        message.number("error", absent=math.nan),
        message.text("reason"),
    )


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


_READERS: Final[dict[str, Callable[[_Message, str], Signal | SensorFrame]]] = {
    **{f"/scan/{name}": _read_scan for name in LIDARS},
    "/imu": _read_imu,
    "/encoders": _read_joints,
    "/line_angles": _read_angles,
    "/distance": _read_distance,
    "/climate": _read_climate,
    "/command": _read_command,
    "/truth": _read_truth,
    "/barrier": _read_barrier,
    "/estimate": _read_estimate,
    "/progress": _read_progress,
    "/frame": _read_frame,
}


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
    if (ranges < _MAX_RANGE).all():  # not of what is infinite
        counts = np.rint(ranges * _STEPS).astype(np.int64)
        if (counts >= 0).all() and (counts / _STEPS == ranges).all():
            whole, rest = _tables()
            return b"[" + np.hstack([whole[counts // 1000], rest[counts % 1000]]).tobytes()[:-1] + b"]"
    return to_json(ranges.tolist())


def _scan(scan: Scan) -> bytes:
    sec, nanosec = _stamp(scan.begin)
    ranges = scan.ranges.copy()
    ranges[np.isnan(ranges)] = 0.0  # the RPLIDAR's own word for nothing
    values = {
        "timestamp": {"sec": sec, "nsec": nanosec},
        "frame_id": f"lidar_{scan.source}",
        "pose": {"position": _named((0.0, 0.0, 0.0)), "orientation": _named((0.0, 0.0, 0.0, 1.0))},
        "start_angle": scan.first_angle,
        "end_angle": scan.first_angle + scan.angle_step * (len(scan.ranges) - 1),
        "intensities": [],
        "time": scan.begin,
        "ray_period": scan.period,
        "angle_step": scan.angle_step,
    }
    return _dump(values)[:-1] + b',"ranges":' + _ranges(ranges) + b"}"


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


def _estimate(signal: Estimate) -> _Values:
    return {
        "time": signal.time,
        **{name: getattr(signal, name).tolist() for name in ESTIMATE_FIELDS},
        "slack": signal.slack.tolist(),
        "covariance": [] if signal.covariance is None else signal.covariance.ravel().tolist(),
        "faults": [{"source": f.source, "since": max(f.since, 0.0), "sentence": f.sentence} for f in signal.faults],
        "valid": signal.valid,
        "clearance": signal.clearance,
    }


def _progress(signal: Progress) -> _Values:
    return {
        "time": signal.time,
        "state": signal.state.value,
        "layer": signal.layer,
        "distance": signal.distance,
        "target": signal.target.tolist(),
        "error": signal.error,
        "reason": signal.reason,
    }


def _header(time: float, frame: str) -> _Values:
    sec, nanosec = _stamp(time)
    return {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": frame}


def _stamp(time: float) -> tuple[int, int]:
    return divmod(round(time * 1e9), 1_000_000_000)


def _named(vector: Sequence[float]) -> dict[str, float]:
    return dict(zip("xyzw", vector, strict=False))


def _dump(values: _Values) -> bytes:
    """As JSON: what is not known, NaN or infinite, as null."""
    return to_json(values, inf_nan_mode="null")
