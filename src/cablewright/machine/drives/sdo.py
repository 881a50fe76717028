"""Service data objects (SDO) on CAN: requests to read or write single objects of a drive.

A client is a small state machine that is fed with frames, so that it never blocks. Numbers go in one frame each; texts,
which are only read, in segments.
"""

from __future__ import annotations

import math
from typing import Final

from cablewright.machine.drives.can_bus import CanFrame
from cablewright.machine.drives.object_transfers import TIMEOUT, Transfer, Transfers, text_of
from cablewright.machine.drives.objects import SDO_REQUEST

_MAX_TEXT: Final = 256  # bytes


class SdoClient:
    """SDO client that carries out the *transfers* with a *node*."""

    def __init__(self, node: int, transfers: Transfers) -> None:
        """Begin with the first."""
        self.node, self.transfers, self.sent = node, transfers, 0
        self._now: Transfer | None = None
        self._since, self._text, self._toggle = math.nan, b"", 0

    def due(self, now: float) -> CanFrame | None:
        """Return the frame to send at *now*, s, if any. A drive that does not answer in time fails the transfer."""
        if self._now is not None and self._now is not self.transfers.first:
            self._now = None  # it was dropped
        if self._now is not None and now - self._since > TIMEOUT:
            self._end(failure="does not answer")
        transfer = self.transfers.first
        if transfer is None or self._now is not None:
            return None
        self._now, self._since = transfer, now
        self._text, self._toggle = b"", 0
        kind, address = transfer.object, transfer.object.index.to_bytes(2, "little") + bytes([transfer.object.sub])
        if transfer.value is None:
            return self._request(bytes([0x40]) + address + bytes(4))
        command = 0x23 | (4 - kind.size) << 2
        return self._request(bytes([command]) + address + kind.pack(transfer.value).ljust(4, b"\0"))

    def take(self, data: bytes, now: float) -> CanFrame | None:
        """Process a frame of the node's answers; return a further one to send, if any."""
        transfer = self._now
        if len(data) != 8 or transfer is None or transfer is not self.transfers.first:
            return None
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

    def _request(self, data: bytes) -> CanFrame:
        self.sent += 1
        return CanFrame(SDO_REQUEST + self.node, data)

    def _uploaded(self, transfer: Transfer, data: bytes, now: float) -> CanFrame | None:
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

    def _segment(self, data: bytes, now: float) -> CanFrame | None:
        self._text += data[1 : 8 - (data[0] >> 1 & 7)]
        if data[0] & 1 or len(self._text) > _MAX_TEXT:
            return self._end()
        self._since, self._toggle = now, self._toggle ^ 0x10
        return self._request(bytes([0x60 | self._toggle]) + bytes(7))

    def _aborted(self, data: bytes) -> CanFrame | None:
        transfer, self._now = self._now, None
        assert transfer is not None
        self.transfers.abort(transfer, int.from_bytes(data[4:8], "little"))
        return None

    def _end(self, failure: str = "") -> CanFrame | None:
        transfer, self._now = self._now, None
        assert transfer is not None
        transfer.text = text_of(self._text)
        self.transfers.end(transfer, failure)
        return None  # nothing further to send
