"""Acyclic transfers with EtherCAT drives on a thread, since a mailbox blocks its caller."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from typing import Final

from cablewright.machine.drives.axis import Axis
from cablewright.machine.drives.ethercat.ring import Ring

_END: Final = 2.0  # s for a transfer to end


class Mailbox:
    """Carrier of parameter requests by the EtherCAT mailboxes of a *ring* of drives."""

    def __init__(self, ring: Ring, axes: Sequence[Axis]) -> None:
        """Begin with nothing to do."""
        self._ring, self._axes = ring, axes
        self._thread: threading.Thread | None = None

    def now(self) -> float:
        """Return the time, s; see `Carrier.now`."""
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        """Wait for this time, s; see `Carrier.wait`."""
        time.sleep(seconds)

    def finish(self, axis: Axis) -> None:
        """Finish the waiting transfers; see `Carrier.finish`."""
        self._ring.carry_out(axis.transfers, axis.node - 1)

    def work(self) -> None:
        """Start the waiting transfers on a thread, which ends when none waits."""
        at_work = self._thread is not None and self._thread.is_alive()
        if not at_work and not all(axis.transfers.idle for axis in self._axes):
            self._thread = threading.Thread(target=self._finish_all, daemon=True)
            self._thread.start()

    def _finish_all(self) -> None:
        for axis in self._axes:
            self.finish(axis)

    def end(self) -> None:
        """Drop the waiting transfers, and end the thread that carries them."""
        for axis in self._axes:
            axis.transfers.clear()
            axis.checks.clear()
        if self._thread is not None:
            self._thread.join(_END)
