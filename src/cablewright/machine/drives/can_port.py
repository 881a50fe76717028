"""A port to a real CAN bus, by python-can (LGPL-3.0, of the extra ``drives``)."""

from __future__ import annotations

import time
from contextlib import suppress
from typing import Any

from cablewright.foundation.errors import EnvironmentFault
from cablewright.machine.drives.can_bus import BusError, CanFrame


class CanPort:
    """A `Port` to a CAN bus by python-can. Its clock is the computer's monotonic one."""

    def __init__(self, bus: Any) -> None:
        """*bus*: a `can.BusABC`."""
        import can

        self._bus, self._can = bus, can

    @classmethod
    def opened(cls, interface: str, channel: str, bitrate: int) -> CanPort:
        """Open the bus. Raises `EnvironmentFault`, with the package to install or the setup to do."""
        try:
            import can
        except ImportError:
            why = "CAN drives need python-can: pip install 'cablewright[drives]'"
            raise EnvironmentFault(f"drives.interface = {interface!r}: {why}") from None
        try:
            return cls(can.Bus(interface=interface, channel=channel, bitrate=bitrate, receive_own_messages=False))
        except (can.CanError, OSError, ValueError, ImportError) as error:
            hint = f"; for socketcan: ip link set {channel} up type can bitrate {bitrate}"
            hint = hint if interface == "socketcan" else "; see the interfaces of python-can's documentation"
            raise EnvironmentFault(f"drives: the bus {interface} {channel} cannot be opened: {error}{hint}") from None

    def now(self) -> float:
        """Return the time, s, by the clock of `receive`; see `Port.now`."""
        return time.monotonic()

    def send(self, frame: CanFrame) -> None:
        """Send one frame; see `Port.send`."""
        message = self._can.Message(arbitration_id=frame.id, data=frame.data, is_extended_id=False, check=False)
        try:
            self._bus.send(message)
        except (self._can.CanError, OSError) as error:
            raise BusError(str(error)) from None

    def receive(self, until: float) -> CanFrame | None:
        """Return the next frame of other members until a time, s; see `Port.receive`.

        Frames outside CANopen are left out, error frames raise errors.
        """
        while True:
            left = until - time.monotonic()
            try:
                message = self._bus.recv(max(left, 0.0))
            except (self._can.CanError, OSError) as error:
                raise BusError(str(error)) from None
            if message is None:
                if left <= 0.0:
                    return None
                continue
            if message.is_error_frame:
                raise BusError("the adapter reports an error of the bus")
            if not (message.is_extended_id or message.is_remote_frame or message.is_fd):
                return CanFrame(message.arbitration_id, bytes(message.data))

    def close(self) -> None:
        """Leave the bus; see `Port.close`."""
        with suppress(self._can.CanError, OSError):
            self._bus.shutdown()
