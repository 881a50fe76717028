"""Objects of CiA 301 and CiA 402 that are used: index, subindex, size, sign."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Final


@dataclass(frozen=True)
class Object:
    """An entry of a drive's object dictionary. ``size``: bytes; 0: a text."""

    index: int
    sub: int
    size: int
    signed: bool
    name: str

    @property
    def mapping(self) -> int:
        """Return the object as an entry of a PDO's mapping."""
        return self.index << 16 | self.sub << 8 | 8 * self.size

    def __str__(self) -> str:
        """As in messages: ``0x1016:1 consumer heartbeat``."""
        sub = f":{self.sub}" if self.sub else ""
        return f"0x{self.index:04X}{sub} {self.name}"

    def pack(self, value: int) -> bytes:
        """Return the bytes of a value; a value out of range is clamped."""
        end = 1 << 8 * self.size - self.signed
        return min(max(value, -end if self.signed else 0), end - 1).to_bytes(self.size, "little", signed=self.signed)

    def unpack(self, data: bytes) -> int:
        """Return the value that the first bytes of an answer contain."""
        return int.from_bytes(data[: self.size], "little", signed=self.signed)


def _unsigned(index: int, sub: int, size: int, name: str) -> Object:
    return Object(index, sub, size, signed=False, name=name)


def _signed(index: int, sub: int, size: int, name: str) -> Object:
    return Object(index, sub, size, signed=True, name=name)


DEVICE_TYPE: Final = _unsigned(0x1000, 0, 4, "device type")
DEVICE_NAME: Final = _unsigned(0x1008, 0, 0, "device name")
VENDOR: Final = _unsigned(0x1018, 1, 4, "vendor")
PRODUCT: Final = _unsigned(0x1018, 2, 4, "product")
REVISION: Final = _unsigned(0x1018, 3, 4, "revision")
SERIAL: Final = _unsigned(0x1018, 4, 4, "serial number")
CONSUMER_HEARTBEAT: Final = _unsigned(0x1016, 1, 4, "consumer heartbeat")
PRODUCER_HEARTBEAT: Final = _unsigned(0x1017, 0, 2, "producer heartbeat")

ABORT_OPTION: Final = _signed(0x6007, 0, 2, "reaction to a lost connection")
ERROR_CODE: Final = _unsigned(0x603F, 0, 2, "error code")
CONTROLWORD: Final = _unsigned(0x6040, 0, 2, "controlword")
STATUSWORD: Final = _unsigned(0x6041, 0, 2, "statusword")
QUICK_STOP_OPTION: Final = _signed(0x605A, 0, 2, "quick stop")
SHUTDOWN_OPTION: Final = _signed(0x605B, 0, 2, "shutdown")
DISABLE_OPTION: Final = _signed(0x605C, 0, 2, "disable operation")
HALT_OPTION: Final = _signed(0x605D, 0, 2, "halt")
FAULT_OPTION: Final = _signed(0x605E, 0, 2, "reaction to a fault")
MODE: Final = _signed(0x6060, 0, 1, "mode of operation")
MODE_SHOWN: Final = _signed(0x6061, 0, 1, "mode of operation, as it is")
POSITION: Final = _signed(0x6064, 0, 4, "position")
FOLLOWING_WINDOW: Final = _unsigned(0x6065, 0, 4, "following error window")
FOLLOWING_TIME: Final = _unsigned(0x6066, 0, 2, "following error time")
VELOCITY: Final = _signed(0x606C, 0, 4, "velocity")
TARGET_TORQUE: Final = _signed(0x6071, 0, 2, "target torque")
MAX_TORQUE: Final = _unsigned(0x6072, 0, 2, "max torque")
RATED_TORQUE: Final = _unsigned(0x6076, 0, 4, "motor rated torque")
TORQUE: Final = _signed(0x6077, 0, 2, "torque")
POLARITY: Final = _unsigned(0x607E, 0, 1, "polarity")
MAX_PROFILE_VELOCITY: Final = _unsigned(0x607F, 0, 4, "max profile velocity")
MAX_MOTOR_SPEED: Final = _unsigned(0x6080, 0, 4, "max motor speed")
DECELERATION: Final = _unsigned(0x6084, 0, 4, "profile deceleration")
STOP_DECELERATION: Final = _unsigned(0x6085, 0, 4, "quick stop deceleration")
COUNTS: Final = _unsigned(0x608F, 1, 4, "encoder increments")
COUNTS_TURNS: Final = _unsigned(0x608F, 2, 4, "encoder increments: motor turns")
GEAR_MOTOR: Final = _unsigned(0x6091, 1, 4, "gear ratio: motor turns")
GEAR_SHAFT: Final = _unsigned(0x6091, 2, 4, "gear ratio: shaft turns")
PERIOD: Final = _unsigned(0x60C2, 1, 1, "interpolation period")
PERIOD_INDEX: Final = _signed(0x60C2, 2, 1, "interpolation period: power of ten")
FOLLOWING_ERROR: Final = _signed(0x60F4, 0, 4, "following error")
INPUTS: Final = _unsigned(0x60FD, 0, 4, "digital inputs")
OUTPUTS: Final = _unsigned(0x60FE, 1, 4, "digital outputs")
OUTPUT_MASK: Final = _unsigned(0x60FE, 2, 4, "digital outputs: mask")
TARGET_VELOCITY: Final = _signed(0x60FF, 0, 4, "target velocity")
SUPPORTED_MODES: Final = _unsigned(0x6502, 0, 4, "supported modes")

PROFILE: Final = 402
"""Of the device type's lower half."""


class Mode(IntEnum):
    """Modes of operation, cyclic synchronous ones."""

    VELOCITY = 9
    TORQUE = 10


def supports(modes: int, mode: Mode) -> bool:
    """Whether a drive whose 0x6502 is *modes* has that *mode*."""
    return bool(modes >> (mode - 1) & 1)


# Identifiers of frames; those of a node are these plus its number.
NMT: Final = 0x000
SYNC: Final = 0x080  # with a node: EMCY
STATE_PDO, LOAD_PDO, INPUT_PDO = 0x180, 0x280, 0x380  # of drives
CONTROL_PDO, TORQUE_PDO = 0x200, 0x300  # to drives
SDO_ANSWER, SDO_REQUEST = 0x580, 0x600
HEARTBEAT: Final = 0x700

MAX_NODE: Final = 127

NMT_START, NMT_STOP, NMT_PREOPERATIONAL = 0x01, 0x02, 0x80
BOOTED, OPERATIONAL, PREOPERATIONAL = 0x00, 0x05, 0x7F  # states in heartbeats

TO_DRIVES: Final = ((CONTROLWORD, MODE, TARGET_VELOCITY), (TARGET_TORQUE,))
"""What is mapped into `CONTROL_PDO` and `TORQUE_PDO`."""

TO_DRIVE_WITH_VALVE: Final = (TO_DRIVES[0], (*TO_DRIVES[1], OUTPUTS))
"""The same for the drive that has the valve's output."""

FROM_DRIVES: Final = ((STATUSWORD, MODE_SHOWN, POSITION), (VELOCITY, TORQUE, ERROR_CODE), (FOLLOWING_ERROR, INPUTS))
"""What is mapped into `STATE_PDO`, `LOAD_PDO` and `INPUT_PDO`."""


def unpacked(objects: tuple[Object, ...], data: bytes) -> list[int] | None:
    """Return the values in the bytes of a PDO; None if it has another length."""
    if len(data) != sum(each.size for each in objects):
        return None
    values, at = [], 0
    for each in objects:
        values.append(each.unpack(data[at:]))
        at += each.size
    return values
