"""The channels of a log and the JSON schemas of their messages.

Scans, inertial readings and encoders have the schemas that Foxglove draws by itself (foxglove.LaserScan, and ROS'
sensor_msgs/Imu and JointState); what those do not hold stands beside as further keys.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

_Values = dict[str, Any]

LIDARS: Final = ("north", "south", "vertical")

_NUMBER: Final = {"type": "number"}
_TEXT: Final = {"type": "string"}


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
_NUMBER_OR_NULL: Final = {"type": ["number", "null"]}
TRUTH_FIELDS: Final = ("position", "velocity", "rotation", "rate", "lengths", "tensions", "excess", "radii")
ESTIMATE_FIELDS: Final = ("position", "velocity", "rotation", "lengths", "excess", "radii")

TOPICS: Final = (
    *(Topic(f"/scan/{name}", "foxglove.LaserScan", _SCAN) for name in LIDARS),
    Topic("/imu", "sensor_msgs/Imu", _IMU),
    Topic("/encoders", "sensor_msgs/JointState", _JOINTS),
    Topic("/line_angles", "cablewright.LineAngles", _object(time=_NUMBER, angles=_array(_NUMBER_OR_NULL))),
    Topic("/distance", "cablewright.Distance", _object(time=_NUMBER, distance=_NUMBER_OR_NULL)),
    Topic("/climate", "cablewright.Climate", _object(time=_NUMBER, temperature=_NUMBER, humidity=_NUMBER)),
    Topic("/barrier", "cablewright.Barrier", _object(time=_NUMBER, broken={"type": "boolean"})),
    Topic("/command", "cablewright.Command", _object(time=_NUMBER, winch_speeds=_NUMBERS, valve=_NUMBER)),
    Topic(
        "/truth",
        "cablewright.Truth",
        _object(time=_NUMBER, powder=_NUMBER, **dict.fromkeys(TRUTH_FIELDS, _NUMBERS)),
    ),
    Topic(
        "/estimate",
        "cablewright.Estimate",
        _object(
            time=_NUMBER,
            **dict.fromkeys(ESTIMATE_FIELDS, _array(_NUMBER_OR_NULL)),
            slack=_array({"type": "boolean"}),
            covariance=_array(_NUMBER),
            faults=_array(_object(source=_TEXT, since=_NUMBER, sentence=_TEXT)),
            valid={"type": "boolean"},
            clearance=_NUMBER_OR_NULL,
        ),
    ),
    Topic(
        "/progress",
        "cablewright.Progress",
        _object(
            time=_NUMBER,
            state=_TEXT,
            layer={"type": "integer"},
            distance=_NUMBER,
            target=_NUMBERS,
            error=_NUMBER_OR_NULL,
            reason=_TEXT,
        ),
    ),
    Topic(
        "/frame",
        "cablewright.Frame",
        _object(time=_NUMBER, readings={"type": "integer"}, notices=_array(_object(condition=_TEXT, whose=_TEXT))),
    ),
)
"""Every channel a log has. The message on /frame comes last in each step and closes it."""
