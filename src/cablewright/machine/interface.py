"""Interface of a machine, simulated, replayed or real: it takes a command for one step and returns its readings."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Protocol

import numpy as np

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Command, SensorFrame, Truth, WinchMode

RESET: Final = "reset"
"""Output by which a person's order to reset reaches drives and brakes."""


@dataclass(frozen=True)
class Abilities:
    """Equipment and abilities of a machine: winches, sensors, modes, brakes.

    ``winches``: their number. ``sensors``: sources of its readings, see `signals.SOURCES`. ``modes``: of
    its winches. ``outputs``: names of further outputs. ``brakes``: whether its winches have brakes. ``real_time``:
    whether a step takes its time. ``truth``, ``snapshot`` and ``refill`` (kg of powder) are of a simulation: None
    without.
    """

    winches: int
    sensors: frozenset[str] = frozenset()
    modes: frozenset[WinchMode] = frozenset({WinchMode.VELOCITY})
    outputs: frozenset[str] = frozenset()
    brakes: bool = False
    real_time: bool = True
    truth: Callable[[], Truth] | None = None
    snapshot: Callable[[], Any] | None = None
    refill: Callable[[float], None] | None = None


class Machine(Protocol):
    """Interface of a machine with m winches.

    Its clock starts at 0, or where it was left, and advances with each step.
    """

    @property
    def period(self) -> float:
        """Planned time of one step, s. Sensor frames have the true time."""

    @property
    def abilities(self) -> Abilities:
        """Equipment and abilities of the machine."""

    def open(self) -> None:
        """Connect to the machine. Raises `EnvironmentFault` if it does not answer."""

    def step(self, command: Command) -> SensorFrame:
        """Send *command*, wait until the step is due, and return the readings that arrived.

        A fault during the step is a notice of the frame, not an error, and is repeated with each frame while it
        lasts. Raises `InputError` for an invalid command:
        of another number of winches, not finite, older than the last, of a mode or output that it does not have.
        Raises `StopIteration` when a replayed machine's log is over.
        """

    def stop(self) -> None:
        """Hold all winches now, in the fastest way; of an open machine this raises nothing."""

    def close(self) -> None:
        """Disconnect from the machine; winches are held first."""


def require_abilities(
    abilities: Abilities,
    winches: int,
    sensors: frozenset[str] = frozenset(),
    modes: frozenset[WinchMode] = frozenset({WinchMode.VELOCITY}),
    outputs: frozenset[str] = frozenset(),
) -> None:
    """Raise `InputError`, before anything moves, for missing abilities of the machine."""
    if abilities.winches != winches:
        raise InputError(f"the machine has {abilities.winches} winches, the robot {winches} lines")
    for what, asked, given in (
        ("sensor", sensors, abilities.sensors),
        ("winch mode", modes, abilities.modes),
        ("output", outputs, abilities.outputs),
    ):
        if missing := sorted(asked - given):
            known = ", ".join(sorted(given)) or "none"
            raise InputError(f"the plan needs the {what} {str(missing[0])!r}, which the machine lacks; it has {known}")


def check_command(abilities: Abilities, command: Command, last_time: float) -> None:
    """Raise `InputError` for a command that a machine with *abilities* cannot take.

    *last_time*: time of the last command, s.
    """
    m, given = abilities.winches, np.asarray(command.winch_speeds, dtype=np.float64)
    speeds = given.tolist()
    if given.shape != (m,) or not (math.isfinite(sum(speeds)) or all(map(math.isfinite, speeds))):
        raise InputError(f"command.winch_speeds: {m} finite numbers are expected, rad/s; got {speeds}")
    if not 0.0 <= command.valve <= 1.0:
        raise InputError(f"command.valve = {command.valve:g}: must be from 0 (shut) to 1 (open)")
    if not math.isfinite(command.time):
        raise InputError(f"command.time = {command.time:g} s: a finite number is expected")
    if not command.time >= last_time:
        raise InputError(f"command.time = {command.time:g} s: the clock jumped back, from {last_time:g} s")
    if command.modes:
        _check_modes(abilities, command, speeds)
    if not command.outputs:
        return
    if unknown := sorted(command.outputs.keys() - abilities.outputs):
        raise InputError(f"command.outputs: {unknown[0]!r}: the machine has no such output")
    for name, value in command.outputs.items():
        if not math.isfinite(value):
            raise InputError(f"command.outputs: {name} = {value:g}: a finite number is expected")


def _check_modes(abilities: Abilities, command: Command, speeds: list[float]) -> None:
    m, modes = abilities.winches, command.modes
    if len(modes) != m:
        raise InputError(f"command.modes: {m} are expected; got {len(modes)}")
    for i, (mode, speed) in enumerate(zip(modes, speeds, strict=True)):
        if mode not in abilities.modes:
            known = ", ".join(sorted(abilities.modes))
            raise InputError(f"command.modes: {mode.value!r} of winch {i + 1}: the machine has {known}")
        if mode in (WinchMode.OFF, WinchMode.HOLD) and speed != 0.0:
            raise InputError(f"command.winch_speeds: {speed:g} rad/s of winch {i + 1}, which is {mode.value!r}")
    if WinchMode.TENSION not in modes:
        return
    tensions = np.full(0, np.nan) if command.tensions is None else np.asarray(command.tensions, dtype=np.float64)
    if tensions.shape != (m,):
        raise InputError(f"command.tensions: {m} are expected with the mode 'tension'")
    for i, (mode, tension) in enumerate(zip(modes, tensions.tolist(), strict=True)):
        if mode is WinchMode.TENSION and not 0.0 <= tension < math.inf:
            raise InputError(f"command.tensions: {tension:g} N of winch {i + 1}: a finite number from 0 on is expected")
