"""Registers of an EtherCAT drive besides the parameters of CiA 402: process data, and the watchdog over the master.

Registers of the slave controller (ETG.1000.4) stand below the object dictionary, which begins at 0x1000, so that both
are read and written as objects.
"""

from __future__ import annotations

from typing import Final

from cablewright.foundation.errors import InputError
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.objects import Object
from cablewright.machine.drives.parameters import Mapped, ObjectParameter, mapping
from cablewright.machine.drives.settings import WinchDriveSettings

FIRST_OBJECT: Final = 0x1000
"""Below it are registers."""

OUTPUT_PDO, INPUT_PDO = 0x1600, 0x1A00  # mapping objects of the first PDO to, and of the first from a drive
OUTPUT_ASSIGN, INPUT_ASSIGN = 0x1C12, 0x1C13


def _register(index: int, size: int, name: str) -> Object:
    return Object(index, 0, size, signed=False, name=f"{name} (register)")


WATCHDOG_DIVIDER: Final = _register(0x0400, 2, "watchdog divider")
WATCHDOG_TIME: Final = _register(0x0420, 2, "watchdog of process data")
OUTPUT_CONTROL: Final = _register(0x0814, 1, "control of the outputs' sync manager")
INPUT_START: Final = _register(0x0818, 2, "address of the inputs")

_DIVIDER: Final = 2498  # two more of 40 ns are 100 us
_UNIT: Final = 100e-6  # s
_ARMED: Final = 1 << 6  # of the sync manager's control byte: writing it is what the watchdog waits for


def process_data(to_drive: Mapped) -> list[ObjectParameter]:
    """Return the PDOs of a drive and their sync managers, to be written before it is safe-operational."""
    found = []
    for assign, first, mapped in ((OUTPUT_ASSIGN, OUTPUT_PDO, to_drive), (INPUT_ASSIGN, INPUT_PDO, o.FROM_DRIVES)):
        number = Object(assign, 0, 1, signed=False, name="number of assigned PDOs")
        found.append(ObjectParameter(number, 0, lasts=False))
        for k, objects in enumerate(mapped):
            found += mapping(first + k, objects)
        entries = [Object(assign, 1 + k, 2, signed=False, name="assigned PDO") for k in range(len(mapped))]
        found += [ObjectParameter(entry, first + k) for k, entry in enumerate(entries)]
        found.append(ObjectParameter(number, len(mapped)))
    return found


def watchdog(settings: WinchDriveSettings) -> list[ObjectParameter]:
    """Return the time, s, after which a drive without its master stops by itself. Raises `InputError` if too long."""
    ticks = round(settings.command_timeout / _UNIT)
    if ticks > 0xFFFF:
        why = f"a watchdog of EtherCAT has {0xFFFF * _UNIT:g} s at most"
        raise InputError(f"drives.command_timeout = {settings.command_timeout:g} s: {why}")
    return [ObjectParameter(WATCHDOG_DIVIDER, _DIVIDER), ObjectParameter(WATCHDOG_TIME, ticks)]


def armed() -> ObjectParameter:
    """Return the parameter by which only the outputs reset that watchdog; the master's set-up has written it."""
    return ObjectParameter(OUTPUT_CONTROL, _ARMED, mask=_ARMED, given=True)
