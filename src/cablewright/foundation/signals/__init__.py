"""The messages between machine, estimation, control, log and viewer: readings, commands, estimates.

Frozen values with read-only arrays, in SI units. Frames: **world**: the robot file's; **drum** (platform): origin at B,
where the lines meet, z up along its axis, parallel to the world's axes without tilt and yaw; of a rigid platform its
own frame, whose origin is then B; **lidar**: its x-y plane is the scan's. Times are seconds since the machine's start,
by its own clock. NaN: not measured.

Each sensor's reading has a module of its own here, and is declared there: modules are found, not listed.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from cablewright.foundation.discovery import modules_of
from cablewright.foundation.signals.barrier import Barrier
from cablewright.foundation.signals.beam_length import BeamLength
from cablewright.foundation.signals.camera import CameraPose
from cablewright.foundation.signals.climate import Climate
from cablewright.foundation.signals.commands import ORDER_LIFE, RETRACTION, YAW, Command, Order, OrderKind, WinchMode
from cablewright.foundation.signals.distance import Distance
from cablewright.foundation.signals.drives import Drives, DriveState
from cablewright.foundation.signals.encoders import Encoders
from cablewright.foundation.signals.frame import SensorFrame, frozen
from cablewright.foundation.signals.inertial import Inertial
from cablewright.foundation.signals.line_angles import LineAngles
from cablewright.foundation.signals.notices import Condition, Notice
from cablewright.foundation.signals.reading import OR_NAN, PerLine, Reading, Source, miscounted, per_line
from cablewright.foundation.signals.safety_inputs import Inputs
from cablewright.foundation.signals.scan import Scan
from cablewright.foundation.signals.states import Estimate, Fault, PrintState, Progress, Truth
from cablewright.foundation.signals.swivels import Swivels
from cablewright.foundation.signals.tensions import Tensions
from cablewright.foundation.signals.yaw_angle import YawAngle

__all__ = [
    "ORDER_LIFE",
    "OR_NAN",
    "READINGS",
    "RETRACTION",
    "SOURCES",
    "YAW",
    "Barrier",
    "BeamLength",
    "CameraPose",
    "Climate",
    "Command",
    "Condition",
    "Distance",
    "DriveState",
    "Drives",
    "Encoders",
    "Estimate",
    "Fault",
    "Inertial",
    "Inputs",
    "LineAngles",
    "Notice",
    "Order",
    "OrderKind",
    "PerLine",
    "PrintState",
    "Progress",
    "Reading",
    "Scan",
    "SensorFrame",
    "Source",
    "Swivels",
    "Tensions",
    "Truth",
    "WinchMode",
    "YawAngle",
    "frozen",
    "miscounted",
    "per_line",
]

modules_of(__name__, __path__)

READINGS: Final = tuple(sorted(Reading.__subclasses__(), key=lambda kind: kind.SOURCES[0].stream))
"""All kinds of readings, by the streams of their sources."""

SOURCES: Final[Mapping[str, Source]] = MappingProxyType(
    {source.name: source for kind in READINGS for source in kind.SOURCES}
)
"""All sensors by name, in the order of their streams."""
