"""Service data objects: single objects of a drive read and written, beside the cyclic traffic.

A transfer is a small state machine that is fed with frames, so that it waits for nobody. Numbers go in one frame each;
texts, which are only read, in segments.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Final

from cablewright.machine.drives.bus import Frame
from cablewright.machine.drives.objects import SDO_REQUEST, Object

TIMEOUT: Final = 0.3
"""Time for a drive to answer, s."""

_MAX_TEXT: Final = 256  # bytes
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
    """One object read, or written where there is a ``value``. ``failure``: why not; empty: it went well, if done."""

    object: Object
    value: int | None = None
    done: bool = False
    result: int = 0
    text: str = ""
    failure: str = ""
    absent: bool = False  # the drive has no such object


class Transfers:
    """The transfers with one node, one after the other."""

    def __init__(self, node: int) -> None:
        """Begin with none."""
        self.node, self.sent = node, 0
        self._waiting: deque[Transfer] = deque()
        self._since, self._text, self._toggle = math.nan, b"", 0
        self._answered: tuple[bytes, float] | None = None

    @property
    def idle(self) -> bool:
        """Whether nothing is left to be transferred."""
        return not self._waiting

    def add(self, transfer: Transfer) -> Transfer:
        """Transfer it after all others."""
        self._waiting.append(transfer)
        return transfer

    def clear(self) -> None:
        """Forget what is left."""
        self._waiting.clear()
        self._since = math.nan

    def due(self, now: float) -> Frame | None:
        """The frame to send at *now*, s, if any. A drive that does not answer in time fails the transfer."""
        if not math.isnan(self._since) and now - self._since > TIMEOUT:
            self._end(failure="does not answer")
        if not self._waiting or not math.isnan(self._since):
            return None
        transfer, self._since = self._waiting[0], now
        self._text, self._toggle = b"", 0
        kind, address = transfer.object, transfer.object.index.to_bytes(2, "little") + bytes([transfer.object.sub])
        if transfer.value is None:
            return self._request(bytes([0x40]) + address + bytes(4))
        command = 0x23 | (4 - kind.size) << 2
        return self._request(bytes([command]) + address + kind.pack(transfer.value).ljust(4, b"\0"))

    def take(self, data: bytes, now: float) -> Frame | None:
        """Take a frame of the node's answers; return a further one to send, if any."""
        if len(data) != 8 or math.isnan(self._since) or not self._waiting:
            return None
        transfer = self._waiting[0]
        command = data[0] >> 5
        own = data[1:4] == transfer.object.index.to_bytes(2, "little") + bytes([transfer.object.sub])
        if command in (2, 3, 4) and not own:
            return None  # the late answer to something else
        if command == 4:
            return self._aborted(data)
        if command in (2, 3):
            if (command == 3) != (transfer.value is not None):
                return None
            return self._end() if command == 3 else self._uploaded(transfer, data, now)
        if command == 0 and transfer.object.size == 0:
            return self._segment(data, now)
        return None

    def _request(self, data: bytes) -> Frame:
        self.sent += 1
        return Frame(SDO_REQUEST + self.node, data)

    def _uploaded(self, transfer: Transfer, data: bytes, now: float) -> Frame | None:
        if not data[0] & 2:  # in segments
            if transfer.object.size:
                return self._end(failure="answers with a text")
            self._since = now
            return self._request(bytes([0x60]) + bytes(7))
        size = 4 - (data[0] >> 2 & 3) if data[0] & 1 else 4
        if transfer.object.size == 0:
            self._text = data[4 : 4 + size]
            return self._end()
        if data[0] & 1 and size != transfer.object.size:
            return self._end(failure=f"has {size} bytes, not {transfer.object.size}")
        transfer.result = transfer.object.unpack(data[4:])
        return self._end()

    def _segment(self, data: bytes, now: float) -> Frame | None:
        self._text += data[1 : 8 - (data[0] >> 1 & 7)]
        if data[0] & 1 or len(self._text) > _MAX_TEXT:
            return self._end()
        self._since, self._toggle = now, self._toggle ^ 0x10
        return self._request(bytes([0x60 | self._toggle]) + bytes(7))

    def _aborted(self, data: bytes) -> Frame | None:
        code = int.from_bytes(data[4:8], "little")
        self._waiting[0].absent = code in _ABSENT
        return self._end(failure=_ABORTS.get(code, f"SDO abort 0x{code:08X}"))

    def _end(self, failure: str = "") -> Frame | None:
        transfer = self._waiting.popleft()
        transfer.done, transfer.failure = True, failure
        transfer.text = self._text.split(b"\0")[0].decode("ascii", "replace")
        self._since = math.nan
        return None  # nothing further to send
