"""Parameters written into a drive and read back: PDOs, its own supervision, and its stop options."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from cablewright.machine.drives import objects as o
from cablewright.machine.drives.drum_units import Scale
from cablewright.machine.drives.objects import Object
from cablewright.machine.drives.settings import NodeSettings, WinchDriveSettings

_OFF: Final = 1 << 31  # a PDO that is not in use
_COB_MASK: Final = _OFF | 0x7FF
_AT_ONCE, _BY_SYNC = 0xFF, 1  # transmission types
_DRIVE_HEARTBEAT: Final = 100  # ms
_MOTOR_TURN: Final = 60.0 / math.tau  # 1/min for a rad/s

# Options of CiA 402: how a drive stops.
_SIGNAL_FAULT = 1  # 0x6007: a lost connection is a fault
_RAMP_AND_HOLD = 6  # 0x605A: by the quick stop's ramp, then held under torque; the usual 2 would let a load fall
RAMP_AND_OFF = 1  # 0x605B, 0x605C: by a ramp, then the brake closes and torque goes
_RAMP = 2  # 0x605D, 0x605E: by the quick stop's ramp; of a fault the brake closes then


Mapped = tuple[tuple[Object, ...], ...]
"""Objects of each PDO."""


class ObjectParameter(NamedTuple):
    """A required value of a drive's object.

    ``mask``: bits of it that count. ``optional``: a drive may lack it. ``lasts``: whether it still holds once all is
    written; others are intermediate steps. ``given``: whether the drive and its motor determine the value: it is
    compared, and never written.
    """

    object: Object
    value: int
    mask: int = (1 << 32) - 1
    optional: bool = False
    lasts: bool = True
    given: bool = False

    def agrees(self, found: int) -> bool:
        """Return whether a value that was read back equals this one."""
        return not (found ^ self.value) & self.mask


def communication(settings: WinchDriveSettings, node: NodeSettings, to_drive: Mapped) -> list[ObjectParameter]:
    """Return the PDO and heartbeat parameters of a *node*, to be written before it is operational.

    *to_drive*: objects sent to it.
    """
    consumer = settings.host << 16 | round(1e3 * settings.heartbeat_timeout)
    found = [ObjectParameter(o.CONSUMER_HEARTBEAT, consumer), ObjectParameter(o.PRODUCER_HEARTBEAT, _DRIVE_HEARTBEAT)]
    to_drives, from_drives = (o.CONTROL_PDO, o.TORQUE_PDO), (o.STATE_PDO, o.LOAD_PDO, o.INPUT_PDO)
    for k, (cob, mapped) in enumerate(zip(to_drives, to_drive, strict=True)):
        timeout = round(1e3 * settings.command_timeout)
        found += _pdo(0x1400 + k, 0x1600 + k, cob + node.id, mapped, _AT_ONCE, timeout if k == 0 else None)
    for k, (cob, mapped) in enumerate(zip(from_drives, o.FROM_DRIVES, strict=True)):
        found += _pdo(0x1800 + k, 0x1A00 + k, cob + node.id, mapped, _BY_SYNC, None)
    return found


def _pdo(
    at: int, mapping_at: int, cob: int, mapped: tuple[Object, ...], kind: int, timeout: int | None
) -> list[ObjectParameter]:
    def entry(index: int, sub: int, size: int, name: str) -> Object:
        return Object(index, sub, size, signed=False, name=name)

    identifier = entry(at, 1, 4, "identifier of a PDO")
    found = [ObjectParameter(identifier, _OFF | cob, _COB_MASK, lasts=False)]
    found.append(ObjectParameter(entry(at, 2, 1, "transmission type"), kind))
    if timeout is not None:
        found.append(ObjectParameter(entry(at, 5, 2, "command timeout"), timeout, optional=True))
    return [*found, *mapping(mapping_at, mapped), ObjectParameter(identifier, cob, _COB_MASK)]


def mapping(at: int, mapped: tuple[Object, ...]) -> list[ObjectParameter]:
    """Return the objects that a PDO with that mapping object carries."""
    number = Object(at, 0, 1, signed=False, name="number of mapped objects")
    entries = [Object(at, 1 + j, 4, signed=False, name="mapped object") for j in range(len(mapped))]
    found = [ObjectParameter(entry, each.mapping) for entry, each in zip(entries, mapped, strict=True)]
    return [ObjectParameter(number, 0, lasts=False), *found, ObjectParameter(number, len(mapped))]


def guards(settings: WinchDriveSettings, scale: Scale, counts: int, period: float) -> list[ObjectParameter]:
    """Return the drive's own supervision, its units and stop options: written and read back at each enable.

    *counts*: encoder counts for one turn of the motor. *period*: length of the bus cycle, s.
    """
    turn = abs(scale.speed)
    deceleration = round(settings.deceleration / scale.radii[0] * turn)
    window = round(settings.following_error / scale.radii[1] * abs(scale.counts))
    return [
        ObjectParameter(o.COUNTS, counts, optional=True, given=True),
        ObjectParameter(o.COUNTS_TURNS, 1, optional=True, given=True),
        ObjectParameter(o.GEAR_MOTOR, 1, optional=True),  # units are the motor's; the gear is reckoned with here
        ObjectParameter(o.GEAR_SHAFT, 1, optional=True),
        ObjectParameter(o.POLARITY, 0, optional=True),  # as is the direction
        ObjectParameter(o.PERIOD, round(1e3 * period), optional=True),
        ObjectParameter(o.PERIOD_INDEX, -3, mask=0xFF, optional=True),
        ObjectParameter(o.ABORT_OPTION, _SIGNAL_FAULT),
        ObjectParameter(o.QUICK_STOP_OPTION, _RAMP_AND_HOLD),
        ObjectParameter(o.SHUTDOWN_OPTION, RAMP_AND_OFF, optional=True),
        ObjectParameter(o.DISABLE_OPTION, RAMP_AND_OFF),
        ObjectParameter(o.HALT_OPTION, _RAMP, optional=True),
        ObjectParameter(o.FAULT_OPTION, _RAMP),
        ObjectParameter(o.FOLLOWING_WINDOW, window),
        ObjectParameter(o.FOLLOWING_TIME, round(1e3 * settings.following_time)),
        ObjectParameter(o.MAX_TORQUE, int(scale.max_torque * abs(scale.torque))),
        ObjectParameter(o.MAX_PROFILE_VELOCITY, math.ceil(scale.max_speed * turn), optional=True),
        ObjectParameter(o.DECELERATION, deceleration),
        ObjectParameter(o.STOP_DECELERATION, deceleration),
        speed_limit(scale, scale.max_speed),
    ]


def speed_limit(scale: Scale, speed: float) -> ObjectParameter:
    """Return the parameter that limits the motor's speed to that at a drum *speed*, rad/s."""
    return ObjectParameter(o.MAX_MOTOR_SPEED, math.ceil(speed * scale.ratio * _MOTOR_TURN))


def shut(valve: int) -> list[ObjectParameter]:
    """Return the parameters that close the valve's output and allow commands of this output alone.

    *valve*: its bit, as a mask, 0: none.
    """
    return [ObjectParameter(o.OUTPUTS, 0, mask=valve), ObjectParameter(o.OUTPUT_MASK, valve)] if valve else []


def disarmed() -> ObjectParameter:
    """Return the parameters that end a disabled drive's supervision of this computer's heartbeat."""
    return ObjectParameter(o.CONSUMER_HEARTBEAT, 0)
