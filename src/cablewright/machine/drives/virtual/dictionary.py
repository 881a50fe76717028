"""The object dictionary of a virtual drive, and its server for service data objects."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from cablewright.machine.drives import objects as o
from cablewright.machine.drives.can_bus import CanFrame
from cablewright.machine.drives.objects import SDO_ANSWER, Object

_READ_ONLY, _ABSENT, _LENGTH, _STATE = 0x06010002, 0x06020000, 0x06070010, 0x08000022
_UNKNOWN: Final = 0x05040001


@dataclass
class ObjectEntry:
    """A value in the dictionary, as its bytes."""

    data: bytes
    writable: bool = True


@dataclass(eq=False)
class Dictionary:
    """A virtual drive's objects by index and subindex. ``operational``: whether PDOs must not be changed now."""

    node: int
    entries: dict[tuple[int, int], ObjectEntry]
    operational: Callable[[], bool]
    stubborn: set[tuple[int, int]] = field(default_factory=set)  # keep their values, and say that they were written
    _text: bytes = b""
    _toggle: int = 0

    def __getitem__(self, kind: Object) -> int:
        """The value of an object."""
        return kind.unpack(self.entries[kind.index, kind.sub].data)

    def __setitem__(self, kind: Object, value: int) -> None:
        self.entries[kind.index, kind.sub].data = kind.pack(value)

    def mapped(self, mapping: int) -> list[ObjectEntry]:
        """Return the entries that the PDO of a *mapping*, 0x1600 and on, carries; none of one that does not exist."""
        number = self.entries[mapping, 0].data[0]
        places = [int.from_bytes(self.entries[mapping, 1 + k].data, "little") for k in range(number)]
        found = [self.entries.get((place >> 16, place >> 8 & 0xFF)) for place in places]
        return [each for each in found if each is not None]

    def answer(self, request: bytes) -> CanFrame | None:
        """Return the virtual drive's answer to a client's parameter request."""
        if len(request) != 8:
            return None
        command, address = request[0] >> 5, request[1:4]
        key = int.from_bytes(address[:2], "little"), address[2]
        if command == 2:
            return self._read(key, address)
        if command == 1:
            return self._write(key, address, request)
        if command == 3 and self._text:
            return self._segment(request[0] & 0x10)
        return None if command == 4 else self._abort(address, _UNKNOWN)

    def rest(self) -> bytes:
        """Bytes of a text that are still to be sent in segments."""
        rest, self._text = self._text, b""
        return rest

    def _read(self, key: tuple[int, int], address: bytes) -> CanFrame:
        entry = self.entries.get(key)
        if entry is None:
            return self._abort(address, _ABSENT)
        size = len(entry.data)
        if size > 4:
            self._text, self._toggle = entry.data, 0
            return self._frame(bytes([0x41]) + address + size.to_bytes(4, "little"))
        return self._frame(bytes([0x43 | (4 - size) << 2]) + address + entry.data.ljust(4, b"\0"))

    def _write(self, key: tuple[int, int], address: bytes, request: bytes) -> CanFrame:
        entry = self.entries.get(key)
        if entry is None:
            return self._abort(address, _ABSENT)
        if not entry.writable:
            return self._abort(address, _READ_ONLY)
        size = 4 - (request[0] >> 2 & 3)
        if size != len(entry.data):
            return self._abort(address, _LENGTH)
        if 0x1400 <= key[0] < 0x1C20 and self.operational():
            return self._abort(address, _STATE)
        if key not in self.stubborn:
            entry.data = request[4 : 4 + size]
        return self._frame(bytes([0x60]) + address + bytes(4))

    def _segment(self, toggle: int) -> CanFrame:
        part, self._text = self._text[:7], self._text[7:]
        last = 0 if self._text else 1
        return self._frame(bytes([toggle | (7 - len(part)) << 1 | last]) + part.ljust(7, b"\0"))

    def _abort(self, address: bytes, code: int) -> CanFrame:
        return self._frame(bytes([0x80]) + address + code.to_bytes(4, "little"))

    def _frame(self, data: bytes) -> CanFrame:
        return CanFrame(SDO_ANSWER + self.node, data)


def entries_of(serial: int, rated_torque: float, counts: int) -> dict[tuple[int, int], ObjectEntry]:
    """Return the object dictionary of a new servo drive. *rated_torque*: N m; *counts*: a revolution of the motor."""
    fixed = {
        o.DEVICE_TYPE: 0x00020000 | o.PROFILE,
        o.VENDOR: 0,
        o.PRODUCT: 0xCAB1E,
        o.REVISION: 1,
        o.SERIAL: serial,
        o.SUPPORTED_MODES: 1 << 8 | 1 << 9,
        o.RATED_TORQUE: round(1e3 * rated_torque),
        **dict.fromkeys((o.STATUSWORD, o.MODE_SHOWN, o.POSITION, o.VELOCITY, o.TORQUE, o.ERROR_CODE), 0),
        **dict.fromkeys((o.FOLLOWING_ERROR, o.INPUTS), 0),
    }
    own = {
        o.QUICK_STOP_OPTION: 2,  # the usual default, with which a load falls
        **dict.fromkeys((o.SHUTDOWN_OPTION, o.DISABLE_OPTION, o.HALT_OPTION), 0),
        o.FAULT_OPTION: 2,
        o.COUNTS: counts,
        **dict.fromkeys((o.COUNTS_TURNS, o.GEAR_MOTOR, o.GEAR_SHAFT), 1),
        o.MAX_TORQUE: 3000,
        o.MAX_MOTOR_SPEED: 6000,
        **dict.fromkeys((o.MAX_PROFILE_VELOCITY, o.DECELERATION, o.STOP_DECELERATION), 10_000_000),
        o.FOLLOWING_WINDOW: 100_000,
        **dict.fromkeys((o.CONSUMER_HEARTBEAT, o.PRODUCER_HEARTBEAT, o.ABORT_OPTION, o.CONTROLWORD, o.MODE), 0),
        **dict.fromkeys((o.TARGET_VELOCITY, o.TARGET_TORQUE, o.POLARITY, o.FOLLOWING_TIME), 0),
        **dict.fromkeys((o.OUTPUTS, o.OUTPUT_MASK), 0),
        **dict.fromkeys((o.PERIOD, o.PERIOD_INDEX), 0),
    }
    found = {(each.index, each.sub): ObjectEntry(each.pack(value), writable=False) for each, value in fixed.items()}
    found |= {(each.index, each.sub): ObjectEntry(each.pack(value)) for each, value in own.items()}
    found[o.DEVICE_NAME.index, 0] = ObjectEntry(b"cablewright virtual drive", writable=False)
    for base, mapping, number in ((0x1400, 0x1600, len(o.TO_DRIVES)), (0x1800, 0x1A00, len(o.FROM_DRIVES))):
        for k in range(number):
            sizes = {1: 4, 2: 1, 5: 2}
            found |= {(base + k, sub): ObjectEntry(bytes(size)) for sub, size in sizes.items()}
            found[base + k, 1].data = (1 << 31).to_bytes(4, "little")
            found[mapping + k, 0] = ObjectEntry(bytes(1))
            found |= {(mapping + k, sub): ObjectEntry(bytes(4)) for sub in range(1, 5)}
    return found
