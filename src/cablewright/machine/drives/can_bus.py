"""Frames of a CAN bus, and the interface (port) to a bus, in real or in virtual time."""

from __future__ import annotations

from typing import NamedTuple, Protocol


class BusError(Exception):
    """A frame could not be sent or received: the cable, the adapter or the bus itself."""


class CanFrame(NamedTuple):
    """A frame of the classic CAN: an identifier of 11 bits and up to 8 bytes."""

    id: int
    data: bytes = b""


class Port(Protocol):
    """Interface by which a program sends and receives frames on a bus."""

    def now(self) -> float:
        """The time, s, by the clock of `receive`."""

    def send(self, frame: CanFrame) -> None:
        """Send one frame on the bus. Raises `BusError`."""

    def receive(self, until: float) -> CanFrame | None:
        """Return the next frame of others; None: none came until that time. Raises `BusError`."""

    def close(self) -> None:
        """Leave the bus; raises nothing."""
