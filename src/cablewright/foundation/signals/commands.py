"""Commands to a machine in each step, and orders of its operators."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated, Final

from cablewright.foundation.arrays import Array
from cablewright.foundation.quick_values import quickly_filled
from cablewright.foundation.signals.reading import PerLine

RETRACTION: Final = "retraction"
"""Output of a machine, m/s, and subject of notices: positive makes the platform longer."""

YAW: Final = "yaw"
"""Output of a machine, rad/s, and subject of notices: positive turns the drum counter-clockwise, seen from above."""


class WinchMode(StrEnum):
    """Control mode of a winch."""

    OFF = "off"  # brake closed, no torque
    HOLD = "hold"  # stand still under torque
    VELOCITY = "velocity"
    TENSION = "tension"


@quickly_filled
@dataclass(frozen=True, eq=False)
class Command:
    """Command to the machine, valid until the next one. The speed of a winch that holds or is switched off is 0."""

    time: float  # s
    winch_speeds: Annotated[Array, PerLine("rad/s", winch=True)]  # (w,) of the drums, not the motors; positive pays out
    valve: float = 0.0  # opening of the powder's valve, 0 to 1
    modes: tuple[WinchMode, ...] = ()  # (w,); empty: all `VELOCITY`
    tensions: Array | None = None  # (w,) N, of the winches in mode `TENSION`; NaN: of the others. None: of none
    outputs: Mapping[str, float] = field(default_factory=dict)  # further outputs of the machine by name


class OrderKind(StrEnum):
    """Orders of an operator."""

    ENABLE = "enable"
    TAKE_UP = "take up"
    HOME = "home"
    RELEASE = "release"
    JOG = "jog"
    GO_TO = "go to"
    PARK = "park"
    START = "start"
    PAUSE = "pause"
    RESUME = "resume"
    OVERRIDE = "override"
    REFILLED = "refilled"
    STOP = "stop"
    EMERGENCY = "emergency stop"
    RESET = "reset"


ORDER_LIFE: Final = 1.0
"""Time, s, after which an order that enables or moves the machine is rejected, if it was not obeyed before."""


@dataclass(frozen=True, eq=False)
class Order:
    """An order, and who gave it.

    ``arguments``: for `JOG` the platform's ``velocity`` (3,), m/s, which holds for `control.manual.LEASE`; for `GO_TO`
    the ``position`` (3,), m; of `OVERRIDE` the ``share`` of the planned speed, 0 to 1.
    """

    kind: OrderKind
    by: str = ""
    time: float = 0.0  # s, by the machine's clock
    arguments: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    refusal: str = ""  # why it was not obeyed; known afterwards
