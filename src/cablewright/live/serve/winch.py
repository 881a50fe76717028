"""Jog of one winch from the page: the tensioning procedure takes up slack, or turns the winch that was chosen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from cablewright.control.procedure import Procedure, ProcedureStep
from cablewright.control.winch_jog import WinchJog
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Estimate, SensorFrame

WINCH: Final = "winch"
"""Argument of an order to take up slack that turns one winch: its index, and m/s of cable, positive pays out."""

HELD: Final = "held"
"""Argument of such an order that goes on with a winch that turns, and begins nothing."""


@dataclass(eq=False)
class WinchByHand:
    """A `Procedure` that takes up slack or jogs one winch.

    ``take_up``: the procedure without a chosen winch. ``jog_of``: makes the jog of a winch, m/s.
    """

    take_up: Procedure
    jog_of: Callable[[int, float], WinchJog]
    winches: int
    _jog: WinchJog | None = None
    _next: WinchJog | None = None  # what was chosen since it began

    def choose(self, given: tuple[float, ...] | None) -> str:
        """Choose the next action: jog one winch as in `WINCH`, or take up slack (None); return why not, or nothing."""
        self._next = None
        if given is None:
            return ""
        if len(given) != 2 or given[0] not in range(self.winches):
            return f"winch = {given}: number of a winch from 0 to {self.winches - 1} and m/s of cable are expected"
        try:
            self._next = self.jog_of(int(given[0]), given[1])
        except InputError as error:
            return str(error)
        return ""

    def hold(self, given: tuple[float, ...]) -> None:
        """Continue the jog of a winch as long as it is held at its speed; any other speed, such as 0, ends it."""
        if self._jog is not None and len(given) == 2 and given[0] == self._jog.settings.line:
            if given[1] == self._jog.settings.speed:
                self._jog.lease()
            else:
                self._jog.let_go()

    def begin(self, now: float) -> None:
        """Begin the last chosen procedure, once, at *now*, s; without a choice it takes up slack."""
        self._jog, self._next = self._next, None
        (self._jog or self.take_up).begin(now)

    def step(self, frame: SensorFrame, estimate: Estimate, dt: float) -> ProcedureStep:
        """Return the winch commands for the next *dt*, s; see `Procedure.step`."""
        return (self._jog or self.take_up).step(frame, estimate, dt)
