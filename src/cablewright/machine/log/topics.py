"""The channels of a log: their signals, and the fields and JSON schemas of their messages.

The channel of a sensor follows from the declaration of its reading: topic, name, and the types of its fields.

Scans, inertial readings and encoders have the schemas that Foxglove draws by itself (foxglove.LaserScan, and ROS'
sensor_msgs/Imu and JointState); further keys hold what those lack.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Annotated, Any, Final, NamedTuple, get_type_hints

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import (
    OR_NAN,
    READINGS,
    Command,
    DriveState,
    Encoders,
    Estimate,
    Inertial,
    Order,
    Progress,
    Reading,
    Scan,
    SensorFrame,
    Source,
    Truth,
)
from cablewright.machine.log.fields import (
    ARGUMENTS,
    CLOSED,
    COUNTS,
    COVARIANCE,
    DRIVE_STATES,
    FAULTS,
    FLAG,
    FLAGS,
    MODES,
    NOTICES,
    NUMBER,
    NUMBER_OR_NAN,
    NUMBER_OR_NOTHING,
    NUMBERS,
    NUMBERS_BY_NAME,
    NUMBERS_OR_NAN,
    NUMBERS_OR_NONE,
    ORDER,
    PLACE,
    STATE,
    TEXT,
    TEXTS,
    WHOLE_NUMBER,
    XYZ,
    XYZW,
    FieldKind,
    array_schema,
    object_schema,
)

Signal = Reading | Command | Order | Truth | Estimate | Progress
"""Types with a message of their own."""


class Topic(NamedTuple):
    """One channel of a log.

    ``kinds``: type of each of the signal's values in a message, by key, which is the attribute's name.
    """

    topic: str
    schema: str  # name
    content: dict[str, Any]  # JSON schema
    signal: type[Signal | SensorFrame]
    kinds: Mapping[str, FieldKind]
    renamed: Mapping[str, str] = {}  # attributes whose name differs from the key
    source: str = ""  # of a reading


def _plain(
    topic: str,
    schema: str,
    signal: type[Signal],
    kinds: Mapping[str, FieldKind],
    renamed: Mapping[str, str] | None = None,
) -> Topic:
    """Return the topic of a signal whose message holds its attributes alone, and its time.

    *schema*: its name, which logs hold: a text of its own, whatever the class is called.
    """
    kinds = {"time": NUMBER, **kinds}
    content = object_schema(**{key: kind.schema for key, kind in kinds.items()})
    return Topic(topic, schema, content, signal, kinds, renamed or {})


_STAMP: Final = object_schema(sec=WHOLE_NUMBER.schema, nanosec=WHOLE_NUMBER.schema)
_HEADER: Final = object_schema(stamp=_STAMP, frame_id=TEXT.schema)
_SCAN: Final = object_schema(
    timestamp=object_schema(sec=WHOLE_NUMBER.schema, nsec=WHOLE_NUMBER.schema),
    frame_id=TEXT.schema,
    pose=object_schema(position=XYZ.schema, orientation=XYZW.schema),
    start_angle=NUMBER.schema,
    end_angle=NUMBER.schema,
    ranges=NUMBERS.schema,
    intensities=NUMBERS.schema,
    time=NUMBER.schema,
    ray_period=NUMBER.schema,
    angle_step=NUMBER.schema,
)
_IMU: Final = object_schema(
    header=_HEADER,
    orientation=XYZW.schema,
    orientation_covariance=NUMBERS.schema,
    angular_velocity=XYZ.schema,
    angular_velocity_covariance=NUMBERS.schema,
    linear_acceleration=XYZ.schema,
    linear_acceleration_covariance=NUMBERS.schema,
    time=NUMBER.schema,
)
_JOINTS: Final = object_schema(
    header=_HEADER,
    name=array_schema(TEXT.schema),
    position=NUMBERS.schema,
    velocity=NUMBERS.schema,
    effort=NUMBERS.schema,
    counts=COUNTS.schema,
    time=NUMBER.schema,
)
_SCAN_KINDS: Final = {"ranges": NUMBERS, **dict.fromkeys(("time", "ray_period", "start_angle", "angle_step"), NUMBER)}
_SCAN_NAMES: Final = {"time": "begin", "ray_period": "period", "start_angle": "first_angle"}

_FOREIGN: Final[Mapping[type, tuple[str, dict[str, Any], Mapping[str, FieldKind], Mapping[str, str]]]] = {
    Scan: ("foxglove.LaserScan", _SCAN, _SCAN_KINDS, _SCAN_NAMES),
    Inertial: (
        "sensor_msgs/Imu",
        _IMU,
        {"time": NUMBER, "linear_acceleration": XYZ, "angular_velocity": XYZ},
        {"linear_acceleration": "acceleration", "angular_velocity": "rate"},
    ),
    Encoders: ("sensor_msgs/JointState", _JOINTS, {"time": NUMBER, "counts": COUNTS}, {}),
}
"""Readings whose messages are of other programs' schemas: name, schema, kinds and renamed attributes."""

_KINDS: Final[Mapping[object, FieldKind]] = {
    float: NUMBER,
    Annotated[float, OR_NAN]: NUMBER_OR_NAN,
    bool: FLAG,
    Array: NUMBERS_OR_NAN,
    Array | None: NUMBERS_OR_NONE,
    tuple[DriveState, ...]: DRIVE_STATES,
    tuple[str, ...]: TEXTS,
    tuple[bool, ...]: CLOSED,
}
"""Kinds of values by the types of a reading's fields."""


def _kinds_of(reading: type[Reading]) -> dict[str, FieldKind]:
    """The kinds of a reading's fields but its source, in their order."""
    plain, marked = get_type_hints(reading), get_type_hints(reading, include_extras=True)
    names = [field.name for field in fields(reading) if field.name != "source"]
    return {name: _KINDS.get(marked[name]) or _KINDS[plain[name]] for name in names}


def _of_reading(reading: type[Reading], source: Source) -> Topic:
    """The topic of a source's readings."""
    if reading in _FOREIGN:
        schema, content, kinds, renamed = _FOREIGN[reading]
        return Topic(source.topic, schema, content, reading, kinds, renamed, source.name)
    return _plain(source.topic, f"cablewright.{reading.__name__}", reading, _kinds_of(reading))._replace(
        source=source.name
    )


TOPICS: Final = (
    *(_of_reading(reading, source) for reading in READINGS for source in reading.SOURCES),
    _plain(
        "/command",
        "cablewright.Command",
        Command,
        {
            "winch_speeds": NUMBERS,
            "valve": NUMBER,
            "modes": MODES,
            "tensions": NUMBERS_OR_NONE,
            "outputs": NUMBERS_BY_NAME,
        },
    ),
    _plain(
        "/order",
        "cablewright.Order",
        Order,
        {"order": ORDER, "by": TEXT, "arguments": ARGUMENTS, "refusal": TEXT},
        {"order": "kind"},
    ),
    _plain(
        "/truth",
        "cablewright.Truth",
        Truth,
        {
            "powder": NUMBER,
            **dict.fromkeys(("position", "velocity", "rotation", "rate"), PLACE),
            **dict.fromkeys(("lengths", "tensions", "excess", "radii"), NUMBERS),
            "retraction": NUMBER_OR_NOTHING,
        },
    ),
    _plain(
        "/estimate",
        "cablewright.Estimate",
        Estimate,
        {
            **dict.fromkeys(("position", "velocity", "rotation", "lengths", "excess", "radii"), NUMBERS_OR_NAN),
            "slack": FLAGS,
            "covariance": COVARIANCE,
            "faults": FAULTS,
            "valid": FLAG,
            "clearance": NUMBER_OR_NAN,
            "consistency": NUMBERS_BY_NAME,
        },
    ),
    _plain(
        "/progress",
        "cablewright.Progress",
        Progress,
        {
            "state": STATE,
            "layer": WHOLE_NUMBER,
            "distance": NUMBER,
            "target": PLACE,
            "error": NUMBER_OR_NAN,
            "reason": TEXT,
            "tensions": NUMBERS_OR_NONE,
        },
    ),
    Topic(
        "/frame",
        "cablewright.Frame",
        object_schema(time=NUMBER.schema, readings=WHOLE_NUMBER.schema, notices=NOTICES.schema),
        SensorFrame,
        {"time": NUMBER, "notices": NOTICES},
    ),
)
"""Every channel a log has. The message on /frame comes last in each step and closes it."""

TOPICS_OF: Final = {each.signal: tuple(one.topic for one in TOPICS if one.signal is each.signal) for each in TOPICS}
"""Names of the topics of each type of signal."""
