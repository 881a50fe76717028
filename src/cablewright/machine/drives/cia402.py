"""The state machine of CiA 402 (IEC 61800-7-201): a drive's state from its statusword, and the next controlword."""

from __future__ import annotations

from enum import Enum, IntEnum
from typing import Final

from cablewright.foundation.signals import DriveState


class PowerState(Enum):
    """Power states of a drive by the standard CiA 402."""

    NOT_READY = "not ready to switch on"
    DISABLED = "switch on disabled"
    READY = "ready to switch on"
    SWITCHED_ON = "switched on"
    ENABLED = "operation enabled"
    QUICK_STOP = "quick stop active"
    FAULT_REACTION = "fault reaction active"
    FAULT = "fault"


_BY_STATUS: Final = (
    (0x4F, 0x00, PowerState.NOT_READY),
    (0x4F, 0x40, PowerState.DISABLED),
    (0x6F, 0x21, PowerState.READY),
    (0x6F, 0x23, PowerState.SWITCHED_ON),
    (0x6F, 0x27, PowerState.ENABLED),
    (0x6F, 0x07, PowerState.QUICK_STOP),
    (0x4F, 0x0F, PowerState.FAULT_REACTION),
    (0x4F, 0x08, PowerState.FAULT),
)

IN_FAULT: Final = (PowerState.FAULT, PowerState.FAULT_REACTION)


def state_of(statusword: int) -> PowerState:
    """Return the state of a drive by its *statusword*; NOT_READY for a statusword that the standard does not define."""
    for mask, value, state in _BY_STATUS:
        if statusword & mask == value:
            return state
    return PowerState.NOT_READY


def shown(state: PowerState) -> DriveState:
    """Return the state as `cablewright.foundation.signals.Drives` names it."""
    if state in IN_FAULT:
        return DriveState.FAULT
    if state in (PowerState.ENABLED, PowerState.QUICK_STOP):
        return DriveState.ENABLED
    return DriveState.READY if state in (PowerState.READY, PowerState.SWITCHED_ON) else DriveState.OFF


class Wish(IntEnum):
    """The state to which a drive must be brought."""

    OFF = 0  # no torque, brake closed
    SWITCHED_ON = 1  # all but enabled
    ENABLED = 2


_SHUTDOWN, _SWITCH_ON, _ENABLE = 0x06, 0x07, 0x0F

DISABLE_OPERATION: Final = 0x07
"""By the ramp of 0x605C and with the brake. In no other state does it take torque away."""

FAULT_RESET: Final = 0x80
"""Resets a fault by its rising edge."""

ENERGISED: Final = (PowerState.ENABLED, PowerState.QUICK_STOP, PowerState.FAULT_REACTION)
"""States in which a motor has torque."""

_NEXT: Final = {
    Wish.OFF: {
        PowerState.SWITCHED_ON: _SHUTDOWN,
        PowerState.READY: _SHUTDOWN,
        PowerState.DISABLED: _SHUTDOWN,
    },
    Wish.SWITCHED_ON: {
        PowerState.SWITCHED_ON: _SWITCH_ON,
        PowerState.READY: _SWITCH_ON,
        PowerState.DISABLED: _SHUTDOWN,
    },
    Wish.ENABLED: {
        PowerState.ENABLED: _ENABLE,
        PowerState.SWITCHED_ON: _ENABLE,
        PowerState.READY: _SWITCH_ON,
        PowerState.DISABLED: _SHUTDOWN,
    },
}


def controlword(wish: Wish, state: PowerState, *, rests: bool, held: bool = False) -> int:
    """Return the controlword that leads a drive from its *state* towards the *wish*, one transition at a time.

    *rests*: it has had no torque for as long as its brake needs to close; until then nothing is sent that could cut
    the torque: no shutdown, and never "disable voltage". *held*: it stands under torque, and would be commanded to
    stand.

    A fault is never reset by it, and a drive that stopped by itself is not taken up again without being off first: from
    its quick stop it is enabled for a moment, held, as that alone leads on to the ramp and the brake.
    """
    if wish is Wish.OFF:
        if state is PowerState.QUICK_STOP and held:
            return _ENABLE
        if not rests:
            return DISABLE_OPERATION
    return _NEXT[wish].get(state, DISABLE_OPERATION)
