"""A virtual drive behind an EtherCAT slave controller: states, mailbox, process data, and watchdog."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

from cablewright.machine.drives import objects as o
from cablewright.machine.drives.cia402 import ENERGISED
from cablewright.machine.drives.virtual import slave_memory as m
from cablewright.machine.drives.virtual.dictionary import Dictionary, ObjectEntry
from cablewright.machine.drives.virtual.slave_memory import MemoryWindow, SlaveMemory
from cablewright.machine.drives.virtual.virtual_drive import NO_COMMAND, VirtualDrive

INIT, PREOP, SAFEOP, OP = 1, 2, 4, 8
_ERROR: Final = 0x10  # of the state; of the master's word: it acknowledges it
_BAD_CHANGE, _BAD_OUTPUTS, _BAD_INPUTS, _MASTER_GONE = 0x0011, 0x001D, 0x001E, 0x001B
_NEXT: Final = {INIT: PREOP, PREOP: SAFEOP, SAFEOP: OP}
_MAILBOX_HEADER: Final = 6
_COE, _REQUEST, _ANSWER = 0x03, 2, 3
_ASSIGNED: Final = ((0x1C12, 0x1600, 2), (0x1C13, 0x1A00, 3))
_TICK: Final = 40e-9  # s


@dataclass(eq=False)
class EthercatSlave:
    """A virtual *drive* as a slave in a ring; ``last``: whether it is the last one. ``cut``: frames do not reach it."""

    drive: VirtualDrive
    last: bool
    cut: bool = False
    memory: SlaveMemory = field(init=False)
    state: int = INIT
    _error: bool = False
    _fed: float = math.nan  # s, when outputs were last written

    def __post_init__(self) -> None:
        """Power on."""
        self.memory = SlaveMemory(m.eeprom_of(0x1000 + self.drive.node), last=self.last)
        add_assignment(self.drive.dictionary)

    def restart(self) -> None:
        """Simulate a loss and return of the drive's power."""
        self.drive.restart()
        self.state, self._error, self._fed = INIT, False, math.nan
        self.__post_init__()

    def read(self, at: int, size: int) -> bytes | None:
        """Return the bytes that an EtherCAT master reads at an address of the virtual drive; None: none."""
        manager = self.memory.sync_manager(3)
        if self.state >= SAFEOP and at < manager.start + manager.size and manager.start < at + size:
            self._refresh(manager.start)
        return self.memory.read(at, size)

    def write(self, at: int, data: bytes, now: float) -> bool:
        """Write the bytes of an EtherCAT master to an address at *now*, s; return whether the address accepts them."""
        if not self.memory.write(at, data):
            return False
        if at <= m.AL_CONTROL < at + len(data):
            self._change(data[m.AL_CONTROL - at])
        if self.memory.sync_manager(0).status & m.FULL:
            self._answer()
        outputs = self.memory.sync_manager(2)
        if outputs.active and at < outputs.start + outputs.size and outputs.start < at + len(data):
            self._fed = now
            if self.state == OP:
                self._command(now)
        return True

    def windows(self) -> list[MemoryWindow]:
        """Windows of the ring's logical memory that carry process data, once configured."""
        return self.memory.windows() if self.state >= SAFEOP else []

    def tick(self, now: float) -> None:
        """Advance to *now*, s, and check the watchdog over the master."""
        memory = self.memory
        tick = (memory.get(m.WATCHDOG_DIVIDER, 2) + 2) * _TICK
        limit = memory.get(m.WATCHDOG_TIME, 2) * tick
        armed = memory.sync_manager(2).control & 0x40 and limit > 0.0
        if self.state == OP and armed and now - self._fed > limit:
            self._fail(SAFEOP, _MASTER_GONE)
            self._lose_master()

    def _lose_master(self) -> None:
        if self.drive.dictionary[o.ABORT_OPTION]:
            self.drive.fail(NO_COMMAND)

    def _change(self, word: int) -> None:
        """Go to the state that the master asks for, if it can."""
        wanted = word & 0x0F
        self._error = self._error and not word & _ERROR
        if wanted < self.state:
            if self.state == OP and self.drive.state in ENERGISED:
                self._lose_master()
            self._enter(wanted)
        elif wanted > self.state and not self._error:
            why = self._obstacle(wanted)
            if why:
                self._fail(self.state, why)
            else:
                self._enter(wanted)
        else:
            self._tell(0)

    def _obstacle(self, wanted: int) -> int:
        """The code of the reason that prevents a higher state; 0: none."""
        if _NEXT.get(self.state) != wanted:
            return _BAD_CHANGE
        if wanted == SAFEOP:
            if self.memory.sync_manager(2).size != sum(self._sizes(0)):
                return _BAD_OUTPUTS
            if self.memory.sync_manager(3).size != sum(self._sizes(1)):
                return _BAD_INPUTS
        return 0

    def _enter(self, state: int) -> None:
        self.state = state
        self.drive.nmt = o.OPERATIONAL if state >= SAFEOP else o.PREOPERATIONAL  # PDOs cannot be changed from there on
        self._tell(0)

    def _fail(self, state: int, code: int) -> None:
        self.state, self._error = state, True
        self._tell(code)

    def _tell(self, code: int) -> None:
        self.memory.put(m.AL_STATUS, self.state | (_ERROR if self._error else 0), 2)
        self.memory.put(m.AL_CODE, code, 2)

    def _assigned(self, side: int) -> list[int]:
        """Mapping objects of its outputs (0) or inputs (1)."""
        assign, entries = _ASSIGNED[side][0], self.drive.dictionary.entries
        number = entries[assign, 0].data[0]
        return [int.from_bytes(entries[assign, 1 + k].data, "little") for k in range(number)]

    def _sizes(self, side: int) -> list[int]:
        known = self.drive.dictionary
        return [sum(len(each.data) for each in known.mapped(at)) for at in self._assigned(side)]

    def _command(self, now: float) -> None:
        at = self.memory.sync_manager(2).start
        for mapping, size in zip(self._assigned(0), self._sizes(0), strict=True):
            self.drive.command(mapping, bytes(self.memory.bytes[at : at + size]), now)
            at += size

    def _refresh(self, at: int) -> None:
        for mapping in self._assigned(1):
            data = self.drive.told(mapping)
            self.memory.bytes[at : at + len(data)] = data
            at += len(data)

    def _answer(self) -> None:
        """Take the message in its mailbox, and answer it."""
        self.memory.mark_full(0, full=False)
        box = self.memory.sync_manager(0)
        message = bytes(self.memory.bytes[box.start : box.start + box.size])
        size, kind = int.from_bytes(message[:2], "little"), message[5] & 0x0F
        if kind != _COE or size < 10 or message[7] >> 4 != _REQUEST or self.state < PREOP:
            return
        answer = self.drive.object_answer(message[8:16])
        if answer is None:
            return
        body = bytes([0, _ANSWER << 4]) + answer
        head = len(body).to_bytes(2, "little") + bytes([0, 0, 0, message[5]])
        start = self.memory.sync_manager(1).start
        self.memory.bytes[start : start + m.MAILBOX_SIZE] = (head + body).ljust(m.MAILBOX_SIZE, b"\0")
        self.memory.mark_full(1, full=True)


def add_assignment(dictionary: Dictionary) -> None:
    """Add the further objects of an EtherCAT drive to its dictionary: types of its sync managers, and their PDOs."""
    entries = dictionary.entries
    entries[0x1C00, 0] = ObjectEntry(bytes([4]), writable=False)
    for k in range(4):
        entries[0x1C00, 1 + k] = ObjectEntry(bytes([1 + k]), writable=False)
    for assign, _, number in _ASSIGNED:
        entries[assign, 0] = ObjectEntry(bytes(1))
        for k in range(number):
            entries[assign, 1 + k] = ObjectEntry(bytes(2))
