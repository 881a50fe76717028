"""Acyclic transfers: single objects of a drive to read or write beside the cyclic traffic, on any bus."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass
from typing import Final

from cablewright.machine.drives.objects import Object

TIMEOUT: Final = 0.3
"""Time for a drive to answer, s."""

_ABORTS: Final = {
    0x05030000: "toggle bit not changed",
    0x05040000: "time out",
    0x05040001: "command unknown",
    0x06010000: "access not supported",
    0x06010001: "can only be written",
    0x06010002: "can only be read",
    0x06020000: "object does not exist",
    0x06040041: "object cannot be mapped",
    0x06070010: "length does not match",
    0x06090011: "subindex does not exist",
    0x06090030: "value out of range",
    0x06090031: "value too high",
    0x06090032: "value too low",
    0x08000000: "general error",
    0x08000020: "cannot be stored",
    0x08000021: "cannot be stored: local control",
    0x08000022: "cannot be stored in this state",
}
_ABSENT: Final = (0x06020000, 0x06090011)


@dataclass(eq=False)
class Transfer:
    """One object to read, or to write where there is a ``value``.

    ``failure``: reason of a failure; empty: success, if done.
    """

    object: Object
    value: int | None = None
    done: bool = False
    result: int = 0
    text: str = ""
    length: int = 0  # bytes that were read
    failure: str = ""
    absent: bool = False  # the drive has no such object


class Transfers:
    """The parameter transfers with one drive, one after the other. Another thread may carry them out."""

    def __init__(self) -> None:
        """Begin with none."""
        self._waiting: deque[Transfer] = deque()
        self._changes = threading.Lock()

    @property
    def idle(self) -> bool:
        """Whether no parameter of the drive is left to be transferred."""
        return not self._waiting

    @property
    def first(self) -> Transfer | None:
        """Next or present parameter transfer; None: none."""
        try:
            return self._waiting[0]
        except IndexError:
            return None

    def add(self, transfer: Transfer) -> Transfer:
        """Add a transfer, to be done after all others."""
        with self._changes:
            self._waiting.append(transfer)
        return transfer

    def clear(self) -> None:
        """Drop the remaining parameter transfers."""
        with self._changes:
            self._waiting.clear()

    def end(self, transfer: Transfer, failure: str = "") -> None:
        """End the parameter transfer; *failure*: why it failed."""
        transfer.failure = failure
        transfer.done = True
        with self._changes:
            if self.first is transfer:
                self._waiting.popleft()

    def abort(self, transfer: Transfer, code: int) -> None:
        """End the transfer, which the drive has rejected with that *code*."""
        transfer.absent = code in _ABSENT
        self.end(transfer, _ABORTS.get(code, f"SDO abort 0x{code:08X}"))


def text_of(data: bytes) -> str:
    """Return the text in the bytes of a drive's answer."""
    return data.split(b"\0")[0].decode("ascii", "replace")
