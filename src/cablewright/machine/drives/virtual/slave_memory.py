"""Memory of a virtual EtherCAT slave: registers, EEPROM, sync managers and windows of its process data.

As in ETG.1000.4, without distributed clocks.
"""

from __future__ import annotations

import struct
from typing import Final, NamedTuple

TYPE, STATION, AL_CONTROL, AL_STATUS, AL_CODE = 0x0000, 0x0010, 0x0120, 0x0130, 0x0134
PORTS, WATCHDOG_DIVIDER, WATCHDOG_TIME = 0x0110, 0x0400, 0x0420
EEPROM_CONTROL, EEPROM_ADDRESS, EEPROM_DATA = 0x0502, 0x0504, 0x0508
WINDOWS, SYNC_MANAGERS = 0x0600, 0x0800
SIZE: Final = 0x2000

MAILBOX_OUT, MAILBOX_IN, OUTPUTS, INPUTS = 0x1000, 0x1080, 0x1100, 0x1400
MAILBOX_SIZE: Final = 0x80
FULL: Final = 0x08  # of a mailbox's status
_READ_EEPROM: Final = 0x01
_EIGHT_BYTES: Final = 0x40  # are read at a time


class SyncManager(NamedTuple):
    """A part of the memory that guards access by a writer and a reader."""

    start: int
    size: int
    control: int
    status: int
    active: bool


class MemoryWindow(NamedTuple):
    """A range of the ring's logical memory that maps to some of the slave's bytes."""

    logical: int
    size: int
    physical: int
    writes: bool


class SlaveMemory:
    """The memory of a slave with that EEPROM; *last*: whether the slave is the last of the ring."""

    def __init__(self, eeprom: bytes, *, last: bool) -> None:
        """As after power-on, in the state init."""
        self.bytes, self._eeprom = bytearray(SIZE), eeprom
        self.stubborn = range(0)  # addresses that keep their values, though they seem to be written
        self.bytes[TYPE : TYPE + 9] = bytes([0x11, 0, 0, 0, 8, 8, 8, 0x0F, 0])
        self.put(PORTS, 0x0200 | (0 if last else 0x0800), 2)
        self.put(AL_STATUS, 1, 2)
        self.put(WATCHDOG_DIVIDER, 2498, 2)
        self.put(WATCHDOG_TIME, 1000, 2)
        self.put(EEPROM_CONTROL, _EIGHT_BYTES, 2)

    def get(self, at: int, size: int) -> int:
        """Return the number at an address of a virtual EtherCAT drive's memory."""
        return int.from_bytes(self.bytes[at : at + size], "little")

    def put(self, at: int, value: int, size: int) -> None:
        """Set the number at an address of a virtual EtherCAT drive's memory."""
        self.bytes[at : at + size] = value.to_bytes(size, "little")

    def sync_manager(self, k: int) -> SyncManager:
        """Return one of the eight sync managers."""
        start, size, control, status, active = struct.unpack_from("<HHBBB", self.bytes, SYNC_MANAGERS + 8 * k)
        return SyncManager(start, size, control, status, bool(active & 1))

    def mark_full(self, k: int, full: bool) -> None:
        """Set or clear the flag that a sync manager's mailbox holds a message."""
        self.bytes[SYNC_MANAGERS + 8 * k + 5] = FULL if full else 0

    def windows(self) -> list[MemoryWindow]:
        """Windows in use that map bus addresses to the virtual drive's memory."""
        found = []
        for at in range(WINDOWS, WINDOWS + 16 * 8, 16):
            logical, size, _, _, physical, _, kind, active = struct.unpack_from("<IHBBHBBB", self.bytes, at)
            if active & 1 and size:
                found.append(MemoryWindow(logical, size, physical, kind == 2))
        return found

    def read(self, at: int, size: int) -> bytes | None:
        """Return the bytes that a master reads there; None: not readable. A mailbox is read once."""
        box = self.sync_manager(1)
        in_mailbox = box.active and at < box.start + box.size and box.start < at + size
        if in_mailbox and not box.status & FULL:
            return None
        if in_mailbox and at + size >= box.start + box.size:
            self.mark_full(1, full=False)
        return bytes(self.bytes[at : at + size])

    def write(self, at: int, data: bytes) -> bool:
        """Write a master's bytes to an address; say whether it accepts them. A mailbox is full after its last byte."""
        box = self.sync_manager(0)
        in_mailbox = box.active and at < box.start + box.size and box.start < at + len(data)
        if at + len(data) > SIZE or (in_mailbox and box.status & FULL):
            return False
        if at not in self.stubborn:
            self.bytes[at : at + len(data)] = data
        if in_mailbox and at + len(data) >= box.start + box.size:
            self.mark_full(0, full=True)
        if at <= EEPROM_CONTROL + 1 < at + len(data) and data[EEPROM_CONTROL + 1 - at] & _READ_EEPROM:
            self._read_eeprom()
        return True

    def _read_eeprom(self) -> None:
        at = 2 * self.get(EEPROM_ADDRESS, 2)
        self.bytes[EEPROM_DATA : EEPROM_DATA + 8] = self._eeprom[at : at + 8].ljust(8, b"\xff")
        self.put(EEPROM_CONTROL, _EIGHT_BYTES, 2)


def eeprom_of(serial: int) -> bytes:
    """Return the EEPROM of a virtual drive (ETG.2010): identity, mailbox, sync managers and windows."""
    found = bytearray(0x80)
    struct.pack_into("<IIII", found, 2 * 0x08, 0, 0xCAB1E, 1, serial)
    struct.pack_into("<HHHHH", found, 2 * 0x18, MAILBOX_OUT, MAILBOX_SIZE, MAILBOX_IN, MAILBOX_SIZE, 0x04)
    name = b"cablewright virtual drive"
    text = bytes([1, len(name)]) + name
    general = bytes(5) + bytes([0x01 | 0x04 | 0x08]) + bytes(26)  # CoE: objects, assigned and mapped PDOs
    managers = (
        (MAILBOX_OUT, MAILBOX_SIZE, 0x26, 1),
        (MAILBOX_IN, MAILBOX_SIZE, 0x22, 2),
        (OUTPUTS, 0, 0x64, 3),  # its watchdog waits for writing
        (INPUTS, 0, 0x20, 4),
    )
    rows = b"".join(struct.pack("<HHBBBB", at, size, control, 0, 1, kind) for at, size, control, kind in managers)
    for category, data in ((10, text), (30, general), (40, bytes([1, 2, 0, 0])), (41, rows)):
        even = data + bytes(len(data) % 2)
        found += struct.pack("<HH", category, len(even) // 2) + even
    return bytes(found) + b"\xff" * 8
