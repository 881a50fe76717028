"""A machine of real winches: `WinchDrives` behind the interface of all machines.

Winches are enabled together, or none is. What takes several cycles, to enable them or to change a mode, is done within
one step, with all winches held; the frame tells the time that it took. After anything that went wrong the drives are
off until a person has reset them.
"""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.errors import CablewrightError, InputError
from cablewright.machine.drives.axis import Axis, Setpoint
from cablewright.machine.drives.cia402 import IN_FAULT, PowerState, Wish, shown
from cablewright.machine.drives.objects import Mode
from cablewright.machine.drives.protocol import WinchDrives
from cablewright.machine.drives.settings import DriveSettings
from cablewright.machine.interface import Abilities, check_command
from cablewright.machine.settings import MachineSettings
from cablewright.signals import (
    Barrier,
    Command,
    Condition,
    Drives,
    Encoders,
    Inputs,
    Notice,
    Reading,
    SensorFrame,
    Tensions,
    WinchMode,
    frozen,
)

RESET: Final = "reset"
"""Output by which a person's order to reset reaches the drives."""

_TIME: Final = 2.0  # s for parameters, and for all drives to be enabled
_MODE_TIME: Final = 0.5  # s to change a mode
_STOP_TIME: Final = 1.0  # s for drives to stop, and to be off
_RESET_TIME: Final = 0.3  # s
_HALF: Final = 1 << 31  # of a drive's counter
_ENERGISED: Final = (PowerState.ENABLED, PowerState.QUICK_STOP, PowerState.FAULT_REACTION)
_FORGOTTEN: Final = 1.0  # s
_STANDS: Final = 0.02  # rad/s of a drum that stands


class DriveMachine:
    """A `Machine`. Its clock is at ``begin``, s, when it is opened."""

    def __init__(self, drives: WinchDrives, settings: MachineSettings) -> None:
        """*settings* with a table ``[drives]``. Raises `InputError` for sensors that its drives do not have."""
        assert settings.drives is not None
        _require_tensions(settings, settings.drives)
        self._drives, self._settings, self._own = drives, settings, settings.drives
        m = len(drives.axes)
        self._off = (Setpoint(),) * m
        self._setpoints, self._on, self.tripped = self._off, False, ""
        self._start, self._cycles, self._due, self._last_time = 0.0, 0, 0.0, -math.inf
        self.begin = 0.0
        self._measured, self._fresh, self._open = -math.inf, False, False
        self._limited: list[Notice] = []
        self._strayed: tuple[float, NDArray[np.int64], Array] | None = None  # s, counts, and rad off
        modes = frozenset({WinchMode.OFF, WinchMode.HOLD, WinchMode.VELOCITY, WinchMode.TENSION})
        self._abilities = Abilities(m, _sensors(settings.drives), modes, frozenset({RESET}), brakes=True)

    @property
    def period(self) -> float:
        """Time of one step, s."""
        return self._settings.period

    @property
    def abilities(self) -> Abilities:
        """All modes, brakes, and an output to reset faults."""
        return self._abilities

    @property
    def drives(self) -> WinchDrives:
        """Its drives."""
        return self._drives

    def open(self) -> None:
        """As `Machine`: drives are found and told what to watch, and are off. Raises `InputError` for wrong ones."""
        self._drives.open()
        self._due = self._drives.now()
        self._start = self._due - self.begin
        self._cycles, self._on, self._open, self.tripped = 0, False, True, ""
        self._last_time = -math.inf
        self._setpoints = self._off

    def step(self, command: Command) -> SensorFrame:
        """As `Machine`."""
        check_command(self._abilities, command, self._last_time)
        self._last_time = command.time
        self._limited = []
        on = WinchMode.OFF not in command.modes
        if command.outputs.get(RESET, 0.0) > 0.0 and not on:
            self._reset()
        if on and not self.tripped:
            if not self._on:
                self._enable()
            wanted = tuple(self._setpoint(i, command) for i in range(self._abilities.winches))
            if self._on and [each.mode for each in wanted] != [each.mode for each in self._setpoints]:
                self._change_modes(wanted)
            if self._on:
                self._setpoints = wanted
        if not on or self.tripped or not self._on:
            self._switch_off()
        self._cycle(self._setpoints)
        if self._on:
            self._watch()
        else:
            self._strayed = None
        return self._frame()

    def stop(self) -> None:
        """As `Machine`: each drive comes to rest by its own ramp and closes its brake before torque goes.

        A quick stop would hold as well, but leads off by cutting the torque alone.
        """
        if not self._open:
            return
        self._switch_off()
        end = self._drives.now() + _STOP_TIME + self._own.brake_time
        while True:
            self._cycle(self._off)
            if self._drives.now() >= end or not any(axis.state in _ENERGISED for axis in self._drives.axes):
                return

    def close(self) -> None:
        """As `Machine`: winches are stopped and braked before the bus is left."""
        if not self._open:
            return
        self.stop()
        self._open = False
        with suppress(CablewrightError):
            self._drives.close()

    def _setpoint(self, i: int, command: Command) -> Setpoint:
        """What winch *i* is to do; a speed over its limit is cut to it, with a notice."""
        mode = command.modes[i] if command.modes else WinchMode.VELOCITY
        axis = self._drives.axes[i]
        if mode is WinchMode.TENSION:
            assert command.tensions is not None
            tension = min(float(command.tensions[i]), self._own.tension)
            return Setpoint(Wish.ENABLED, Mode.TORQUE, torque=axis.scale.torque_of(tension))
        speed, most = float(command.winch_speeds[i]), axis.scale.max_speed
        if abs(speed) > most:
            self._limited.append(Notice(Condition.LIMITED, axis.name))
            speed = math.copysign(most, speed)
        return Setpoint(Wish.ENABLED, Mode.VELOCITY, speed)

    def _cycle(self, setpoints: tuple[Setpoint, ...], *, reset: bool = False) -> None:
        """One cycle on the bus. After a step that came so late that drives have stopped by now, nothing old is sent."""
        self._due += self.period
        now = self._drives.now()
        if now - self._due > self._own.command_timeout:
            setpoints = tuple(each._replace(speed=0.0, torque=0.0) for each in setpoints)
        if now > self._due:  # the cycles go on from here: none is made up for
            self._due = now
        time = self._drives.cycle(setpoints, self._due, reset=reset)
        self._fresh = any(not axis.pending for axis in self._drives.axes)
        self._measured = time - self._start

    def _switch_off(self) -> None:
        self._on, self._setpoints = False, self._off

    def _trip(self, why: str) -> None:
        """Switch all off, until a person resets."""
        self.tripped = self.tripped or why
        self._switch_off()

    def _enable(self) -> None:
        """Write and read back what drives watch, switch all on, enable all; whatever goes wrong switches all off."""
        for axis in self._drives.axes:
            if trouble := self._trouble(axis):
                return self._trip(trouble)
        self._drives.begin_checks()
        if not self._settled(self._off, _TIME, "its parameters could not be read in time"):
            return None
        velocity = (Setpoint(Wish.ENABLED),) * len(self._off)
        for wish, state in ((Wish.SWITCHED_ON, PowerState.SWITCHED_ON), (Wish.ENABLED, PowerState.ENABLED)):
            wanted = tuple(each._replace(wish=wish) for each in velocity)
            if not self._reached(wanted, state):
                return None
        end = self._drives.now() + self._own.brake_time
        while self._drives.now() < end:  # brakes open under torque
            self._cycle(velocity)
            if why := self._lost():
                return self._trip(why)
        self._on, self._setpoints = True, velocity
        return None

    def _reached(self, wanted: tuple[Setpoint, ...], state: PowerState) -> bool:
        """Cycle until all drives are in that state; False: one does not get there, and all are off."""
        end = self._drives.now() + _TIME
        while True:
            self._cycle(wanted)
            axes, on = self._drives.axes, state is PowerState.ENABLED
            late = [
                axis for axis in axes if axis.state is not state or axis.pending or (on and axis.mode != Mode.VELOCITY)
            ]
            if not late:
                return True
            for axis in axes:
                if axis.state in IN_FAULT or self._drives.now() > end:
                    who = axis if axis.state in IN_FAULT else late[0]
                    self._trip(f"{who.name}: does not become {state.value}: {who.fault or who.state.value}")
                    return False

    def _settled(self, setpoints: tuple[Setpoint, ...], timeout: float, why: str) -> bool:
        """Cycle until parameters are transferred; False: they could not be, and all are off."""
        end = self._drives.now() + timeout
        while self._drives.checking and self._drives.now() < end:
            self._cycle(setpoints)
        late = self._drives.checking
        for axis in self._drives.axes:
            if axis.failure or (late and axis.checks):
                self._trip(f"{axis.name}: {axis.failure or why}")
                return False
        return True

    def _change_modes(self, wanted: tuple[Setpoint, ...]) -> None:
        """Bring winches to rest, limit their speed for the mode, and change it while they are held."""
        held = tuple(each._replace(speed=0.0, torque=each.torque) for each in self._setpoints)
        end = self._drives.now() + _MODE_TIME
        while not self._standing(Mode.VELOCITY):
            self._cycle(held)
            if why := self._lost() or ("a winch does not come to rest" if self._drives.now() > end else ""):
                return self._trip(f"{why}, so that its mode is not changed" if "rest" in why else why)
        self._drives.begin_speed_limits([each.mode is Mode.TORQUE for each in wanted])
        if not self._settled(held, _MODE_TIME, "its speed limit could not be read in time"):
            return None
        changed = tuple(each._replace(speed=0.0) for each in wanted)
        end = self._drives.now() + _MODE_TIME
        while True:
            self._cycle(changed)
            late = [a.name for a, each in zip(self._drives.axes, wanted, strict=True) if a.mode != each.mode]
            if why := self._lost() or (f"{late[0]}: its mode does not change" if self._drives.now() > end else ""):
                return self._trip(why)
            if not late:
                return None

    def _reset(self) -> None:
        """Reset faults of drives whose cause is gone, by a person's order, while all are off."""
        end = self._drives.now() + _RESET_TIME
        self._switch_off()
        for _ in range(2):  # an edge, and what drives answer
            self._cycle(self._off, reset=True)
        while any(axis.state in IN_FAULT for axis in self._drives.axes) and self._drives.now() < end:
            self._cycle(self._off)
        if not any(axis.state in IN_FAULT or axis.restarted for axis in self._drives.axes):
            self.tripped = ""

    def _watch(self) -> None:
        if why := self._lost() or self._astray():
            self._trip(why)

    def _astray(self) -> str:
        """Which winch turns otherwise than commanded, which its drive may not see; an empty text: none.

        What it is off is forgotten within `_FORGOTTEN`, so that small errors of speeds do not add up.
        """
        axes = self._drives.axes
        if any(axis.pending for axis in axes):
            return ""
        counts = np.array([axis.counts for axis in axes], dtype=np.int64)
        before, self._strayed = self._strayed, (self._measured, counts, np.zeros(len(axes)))
        if before is None:
            return ""
        dt = self._measured - before[0]
        asked = np.array([each.speed for each in self._setpoints])
        turned = (counts - before[1] + _HALF) % (2 * _HALF) - _HALF  # counters wrap
        angles = turned / np.array([abs(axis.scale.counts) for axis in axes])
        off = before[2] * math.exp(-dt / _FORGOTTEN) + angles - asked * dt
        off[[each.mode is not Mode.VELOCITY for each in self._setpoints]] = 0.0
        self._strayed = self._measured, counts, off
        lengths = np.abs(off) * np.array([axis.scale.radii[1] for axis in axes])
        worst = int(np.argmax(lengths))
        if lengths[worst] <= self._own.following_error:
            return ""
        return f"{axes[worst].name}: its winch is {1e3 * lengths[worst]:.0f} mm from where it was commanded"

    def _lost(self) -> str:
        """Why not all drives are enabled any more; an empty text: they are."""
        if self._drives.trouble:
            return self._drives.trouble
        for axis in self._drives.axes:
            if (trouble := self._trouble(axis)) or axis.state is not PowerState.ENABLED:
                return trouble or f"{axis.name}: is no longer enabled but {axis.state.value}"
        return ""

    def _trouble(self, axis: Axis) -> str:
        if axis.restarted:
            return f"{axis.name}: its drive was restarted: open the machine anew"
        if self._silent(axis):
            return f"{axis.name}: its drive does not answer"
        return f"{axis.name}: {axis.fault}" if axis.state in IN_FAULT else ""

    def _silent(self, axis: Axis) -> bool:
        return self._drives.now() - axis.heard > self._own.answer_timeout + self.period

    def _standing(self, mode: Mode | None = None) -> bool:
        """Whether all winches stand, or all that are in that *mode*."""
        pairs = zip(self._drives.axes, self._setpoints, strict=True)
        return all(abs(axis.velocity) < _STANDS for axis, each in pairs if mode is None or each.mode is mode)

    def _frame(self) -> SensorFrame:
        time, axes = self._measured, self._drives.axes
        readings: list[Reading] = []
        if not any(axis.pending for axis in axes):
            counts = np.array([axis.counts for axis in axes], dtype=np.int64)
            counts.flags.writeable = False
            tensions = frozen([axis.scale.tension(axis.torque) for axis in axes])
            readings += [Encoders(time, counts), Tensions("motor_torques", time, tensions)]
        if self._fresh:
            readings += [self._drive_reading(time), *self._input_readings(time)]
        return SensorFrame(time, tuple(readings), tuple(self._notices()))

    def _drive_reading(self, time: float) -> Drives:
        axes = self._drives.axes
        angles = [axis.counts / abs(axis.scale.counts) for axis in axes]
        known = [not axis.pending for axis in axes]

        def told(values: list[float]) -> np.ndarray:
            return frozen(np.where(known, values, np.nan))

        return Drives(
            time,
            tuple(shown(axis.state) for axis in axes),
            told(angles),
            told([axis.velocity for axis in axes]),
            told([axis.torque for axis in axes]),
            told([axis.following_error for axis in axes]),
            tuple(axis.fault for axis in axes),
        )

    def _input_readings(self, time: float) -> list[Reading]:
        """What the drives' inputs say; a drive whose inputs are not known says that it is not safe."""
        bits, axes = self._own.inputs, self._drives.axes

        def all_set(bit: int | None) -> bool:
            return bit is None or all(axis.inputs >> bit & 1 for axis in axes)

        found: list[Reading] = []
        if bits.barrier is not None:
            found.append(Barrier(time, not all_set(bits.barrier)))
        if any(bit is not None for bit in (bits.chain, bits.torque_on, bits.enabling, bits.brake)):
            closed = () if bits.brake is None else tuple(bool(axis.inputs >> bits.brake & 1) for axis in axes)
            found.append(Inputs(time, all_set(bits.chain), not all_set(bits.torque_on), all_set(bits.enabling), closed))
        return found

    def _notices(self) -> list[Notice]:
        found = list(self._limited)
        if self._drives.trouble:
            found.append(Notice(Condition.BUS_SILENT, self._drives.trouble))
        found += [Notice(Condition.BUS_SILENT, axis.name) for axis in self._drives.axes if self._silent(axis)]
        if self.tripped:
            found.append(Notice(Condition.DRIVE_FAULT, self.tripped))
        return found


def _sensors(drives: DriveSettings) -> frozenset[str]:
    bits, found = drives.inputs, {"encoders", "motor_torques", "drives"}
    if bits.barrier is not None:
        found.add("barrier")
    if any(bit is not None for bit in (bits.chain, bits.torque_on, bits.enabling, bits.brake)):
        found.add("inputs")
    return frozenset(found)


def _require_tensions(settings: MachineSettings, drives: DriveSettings) -> None:
    """Raise `InputError` where tensions are not read, or the file has sensors that nobody reads."""
    if settings.motor_torques is None:
        why = "drives are enabled only where tensions are read; add the table: they tell their torque"
        raise InputError(f"machine {settings.name!r}: no [motor_torques]: {why}")
    if settings.encoders is None:
        raise InputError(f"machine {settings.name!r}: no [encoders]: the drives' positions are read by it; add it")
    if settings.barrier is not None and drives.inputs.barrier is None:
        why = "no bit of the drives' inputs is it: give drives.inputs.barrier, or leave the table out"
        raise InputError(f"machine {settings.name!r}: [barrier]: {why}")
