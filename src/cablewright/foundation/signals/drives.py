"""Reports of the winches' drives."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals.reading import PerLine, Reading, Source


class DriveState(StrEnum):
    """State of a winch's drive."""

    OFF = "off"
    READY = "ready"
    ENABLED = "enabled"
    FAULT = "fault"


@dataclass(frozen=True, eq=False)
class Drives(Reading, sources=[Source("drives", stream=11, topic="/drives")]):
    """Reports of the winches' drives. Angles are of the winch drums; paying cable out is positive."""

    time: float  # s
    states: Annotated[tuple[DriveState, ...], PerLine(winch=True)]  # (w,)
    positions: Annotated[Array, PerLine("rad", winch=True)]  # (w,); NaN: not measured, as in the others
    velocities: Annotated[Array, PerLine("rad/s", winch=True)]  # (w,)
    torques: Annotated[Array, PerLine("N m", winch=True)]  # (w,)
    following_errors: Annotated[Array, PerLine("rad", winch=True)]  # (w,) commanded less measured
    faults: Annotated[tuple[str, ...], PerLine(winch=True)]  # (w,) text of each drive's fault; empty: none
