"""Interface of procedures that a machine runs by itself before a print, such as taking up slack."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Estimate, SensorFrame, WinchMode


class ProcedureStep(NamedTuple):
    """Winch commands of a procedure for the next step, and whether it has ended."""

    winch_speeds: Array  # (m,) rad/s
    modes: tuple[WinchMode, ...] = ()  # (m,); empty: all `VELOCITY`
    tensions: Array | None = None  # (m,) N, of winches in mode `TENSION`
    finished: bool = False
    failure: str = ""  # why it ends without success


class Procedure(Protocol):
    """Interface of a procedure. The guard judges it like all else."""

    def begin(self, now: float) -> None:
        """Begin at *now*, s."""

    def step(self, frame: SensorFrame, estimate: Estimate, dt: float) -> ProcedureStep:
        """Return the winch commands for the next *dt*, s. Raises nothing, whatever the frame contains."""
