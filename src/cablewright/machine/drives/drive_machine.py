"""A machine of real winches: `WinchDrives` behind the interface of all machines.

Winches are enabled together, or none is. Actions of several cycles, such as to enable them or to change a mode, are
done within one step, with all winches held; the frame has the elapsed time. After any fault the drives stay disabled
until a person resets them.
"""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Final

import numpy as np

from cablewright.foundation.errors import CablewrightError, InputError
from cablewright.foundation.signals import (
    ORDER_LIFE,
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
from cablewright.machine.drives.axis import STANDS, Axis, Setpoint
from cablewright.machine.drives.cia402 import IN_FAULT, PowerState, Wish, shown
from cablewright.machine.drives.disabled_check import OffWatch
from cablewright.machine.drives.objects import Mode
from cablewright.machine.drives.settings import WinchDriveSettings
from cablewright.machine.drives.unexpected_motion import StrayWatch, slipping
from cablewright.machine.drives.winch_drives import WinchDrives
from cablewright.machine.interface import RESET, Abilities, check_command
from cablewright.machine.sensors.barrier import BARRIER
from cablewright.machine.sensors.encoders import ENCODERS
from cablewright.machine.sensors.tensions import MOTOR_TORQUES
from cablewright.machine.settings import MachineSettings

_STOP_IT: Final = "it has to stop by its own watch over this computer; press the emergency stop"

_OPENS: Final = 0.5  # of a valve that is open or shut: while speeds change evenly it lays as much as one that is not

_TIME: Final = 2.0  # s for parameters
_ENABLE_TIME: Final = 0.5  # s for all drives to be switched on, or enabled
_MODE_TIME: Final = 0.5  # s to change a mode
_RESET_TIME: Final = 0.3  # s


class DriveMachine:
    """A `Machine` of real winches on drives. Its clock is at ``begin``, s, when it is opened."""

    def __init__(self, drives: WinchDrives, settings: MachineSettings) -> None:
        """*settings* with a table ``[drives]``. Raises `InputError` for sensors that its drives do not have."""
        assert settings.drives is not None
        _require_tensions(settings, settings.drives)
        self._drives, self._settings, self._own = drives, settings, settings.drives
        m = len(drives.axes)
        self._off = (Setpoint(),) * m
        self._setpoints, self._on, self.tripped = self._off, False, ""
        self._start, self._anchor, self._cycles, self._last_time = 0.0, 0.0, 0, -math.inf
        self.begin = 0.0
        self._measured, self._fresh, self._open = -math.inf, False, False
        self._limited: list[Notice] = []
        self._strays, self._off_watch = StrayWatch(settings.drives), OffWatch(drives.axes, settings.drives)
        self._beats, self._slips = True, ""  # whether the heartbeat goes on; which brake slips
        self.left = ""  # which drive was not known to be off when it was closed
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
        """Drives of the machine."""
        return self._drives

    def open(self) -> None:
        """Connect to the machine; see `Machine.open`.

        Drives are found and configured, and stay disabled. Raises `InputError` for wrong ones.
        """
        self._drives.open()
        self._anchor, self._cycles = self._drives.now(), 0
        self._start = self._anchor - self.begin
        self._on, self._open, self.tripped = False, True, ""
        self._last_time = -math.inf
        self._setpoints, self._beats, self.left = self._off, True, ""
        self._off_watch.end()
        self._off_watch.begin(self._anchor)
        self._strays.forget()

    def step(self, command: Command) -> SensorFrame:
        """Send *command*, wait for the step, and return the readings that arrived; see `Machine.step`."""
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
        self._watch()
        return self._frame()

    def stop(self) -> None:
        """Stop and hold all winches; see `Machine.stop`.

        Each drive comes to rest by its own ramp and closes its brake before torque goes.

        A quick stop would hold as well, but it ends only with the torque cut.
        """
        if not self._open:
            return
        self._switch_off()
        watch, now = self._off_watch, self._drives.now()
        end = now + 2.0 * watch.limit + self._own.heartbeat_timeout  # by its ramp, or without heartbeat by its own
        while True:
            self._cycle(self._off)
            now = self._drives.now()
            if now >= end or not watch.unproven(now):
                return

    def close(self) -> None:
        """Disconnect from the machine; see `Machine.close`.

        Winches are stopped and braked before the bus is left.

        A drive that is not known to be disabled goes on watching this computer's heartbeat, which ends; ``left``
        reports it.
        """
        if not self._open:
            return
        self.stop()
        self._open = False
        unproven = self._off_watch.unproven(self._drives.now())
        if unproven:
            axis = unproven[0]
            self.left = f"{axis.name}: its drive was not seen to switch off ({axis.state.value}): {_STOP_IT}"
        with suppress(CablewrightError):
            self._drives.close(proven=not unproven)

    def _setpoint(self, i: int, command: Command) -> Setpoint:
        """What winch *i* is to do; a speed over its limit is cut to it, with a notice."""
        mode = command.modes[i] if command.modes else WinchMode.VELOCITY
        axis, opens = self._drives.axes[i], command.valve >= _OPENS
        if mode is WinchMode.TENSION:
            assert command.tensions is not None
            tension = min(float(command.tensions[i]), self._own.tension)
            return Setpoint(Wish.ENABLED, Mode.TORQUE, torque=axis.scale.torque_of(tension), valve=opens)
        speed, most = float(command.winch_speeds[i]), axis.scale.max_speed
        if abs(speed) > most:
            self._limited.append(Notice(Condition.LIMITED, axis.name))
            speed = math.copysign(most, speed)
        return Setpoint(Wish.ENABLED, Mode.VELOCITY, speed, valve=opens)

    def _cycle(self, setpoints: tuple[Setpoint, ...], *, reset: bool = False) -> None:
        """One cycle on the bus. After a step that came so late that drives have stopped by now, nothing old is sent."""
        self._cycles += 1
        due = self._anchor + self._cycles * self.period  # no sum of periods, which loses digits in an hour
        now = self._drives.now()
        if self._on and now - due > ORDER_LIFE:
            self._trip(f"{Condition.HUNG} for {now - due:.1f} s")
        if now - due > self._own.command_timeout:
            setpoints = tuple(each._replace(speed=0.0, torque=0.0, valve=False) for each in setpoints)
        if now > due:  # the cycles go on from here: none is made up for
            self._anchor, self._cycles, due = now, 0, now
        time = self._drives.cycle(setpoints, due, reset=reset, beats=self._beats)
        self._fresh = any(not axis.pending for axis in self._drives.axes)
        self._measured = time - self._start
        if why := self._off_watch.disobeys(self._drives.now()):
            self.tripped, self._beats = self.tripped or why, False

    def _switch_off(self) -> None:
        self._on, self._setpoints = False, self._off
        self._off_watch.begin(self._drives.now())

    def _trip(self, why: str) -> None:
        """Switch all off, until a person resets."""
        self.tripped = self.tripped or why
        self._switch_off()

    def _enable(self) -> None:
        """Write and read back what drives watch, switch all on, enable all; whatever goes wrong switches all off."""
        end = self._drives.now() + self._off_watch.limit
        while self._off_watch.unproven(self._drives.now()):
            if why := self._troubles() or ("a drive is not off yet" if self._drives.now() > end else ""):
                return self._trip(why)
            self._cycle(self._off)
        self._drives.begin_checks()
        if not self._settled(self._off, _TIME, "its parameters could not be read in time"):
            return None
        self._off_watch.end()
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
        """Cycle until all drives are in that state; False: one does not reach it, and all are disabled."""
        end = self._drives.now() + _ENABLE_TIME
        while True:
            self._cycle(wanted)
            axes, on = self._drives.axes, state is PowerState.ENABLED
            late = [
                axis for axis in axes if axis.state is not state or axis.pending or (on and axis.mode != Mode.VELOCITY)
            ]
            why = self._troubles()
            if not why and late and self._drives.now() > end:
                why = f"{late[0].name}: does not become {state.value}: {late[0].state.value}"
            if why:
                self._trip(why)
            if why or not late:
                return not why

    def _settled(self, setpoints: tuple[Setpoint, ...], timeout: float, why: str) -> bool:
        """Cycle until parameters are transferred; False: they could not be, and all are disabled."""
        end = self._drives.now() + timeout
        while self._drives.checking and self._drives.now() < end:
            self._cycle(setpoints)
            if troubles := self._lost() if self._on else self._troubles():
                self._trip(troubles)
                return False
        late = self._drives.checking
        for axis in self._drives.axes:
            if axis.failure or (late and axis.checks):
                self._trip(f"{axis.name}: {axis.failure or why}")
                return False
        return True

    def _change_modes(self, wanted: tuple[Setpoint, ...]) -> None:
        """Bring winches to rest, limit their speed for the mode, and change it while they are held."""
        held = tuple(each._replace(speed=0.0, valve=False) for each in self._setpoints)
        end = self._drives.now() + _MODE_TIME
        while not self._standing(Mode.VELOCITY):
            self._cycle(held)
            if why := self._lost() or ("a winch does not come to rest" if self._drives.now() > end else ""):
                return self._trip(f"{why}, so that its mode is not changed" if "rest" in why else why)
        now_slow = [each.mode is Mode.TORQUE for each in self._setpoints]
        then_slow = [each.mode is Mode.TORQUE for each in wanted]
        both = [now or then for now, then in zip(now_slow, then_slow, strict=True)]
        changed = tuple(each._replace(speed=0.0, valve=False) for each in wanted)
        if both != now_slow and not self._limited_speeds(both, held):
            return None  # a limit comes before the mode that needs it ...
        end = self._drives.now() + _MODE_TIME
        while True:
            self._cycle(changed)
            late = [a.name for a, each in zip(self._drives.axes, wanted, strict=True) if a.mode != each.mode]
            if why := self._lost() or (f"{late[0]}: its mode does not change" if self._drives.now() > end else ""):
                return self._trip(why)
            if not late:
                break
        if both != then_slow:  # ... and goes after it
            self._limited_speeds(then_slow, changed)
        return None

    def _limited_speeds(self, slow: list[bool], setpoints: tuple[Setpoint, ...]) -> bool:
        """Limit the speeds of drives for torque mode where *slow*; False: one rejects it, and all are disabled."""
        self._drives.begin_speed_limits(slow)
        return self._settled(setpoints, _MODE_TIME, "its speed limit could not be read in time")

    def _reset(self) -> None:
        """Reset faults of drives whose cause is gone, by a person's order, while all are known to be off."""
        self._switch_off()
        self._strays.forget()  # where brakes have slipped is where the winches are
        end = self._drives.now() + self._own.brake_time + _RESET_TIME
        while self._off_watch.unproven(self._drives.now()):
            if self._drives.now() > end:
                return
            self._cycle(self._off)
        self._beats = True
        end = self._drives.now() + _RESET_TIME
        for _ in range(2):  # an edge, and what drives answer
            self._cycle(self._off, reset=True)
        while any(axis.state in IN_FAULT for axis in self._drives.axes) and self._drives.now() < end:
            self._cycle(self._off)
        if not self._troubles():
            self.tripped = ""

    def _watch(self) -> None:
        """Trip where a winch is lost or astray; also of one that its brake should hold."""
        self._slips = ""
        if not self._on and self._off_watch.unproven(self._drives.now()):
            return self._strays.forget()
        why = self._lost() if self._on else ""
        stray = self._strays.judge(self._drives.axes, self._setpoints, self._measured)
        if stray and not self._on:
            self._slips = stray = slipping(stray)
        if why or stray:
            self._trip(why or stray)
        return None

    def _troubles(self) -> str:
        """What is wrong with the bus or a drive; an empty text: nothing."""
        return self._drives.trouble or next(filter(None, map(self._trouble, self._drives.axes)), "")

    def _lost(self) -> str:
        """Why not all drives are enabled any more; an empty text: they are."""
        if trouble := self._troubles():
            return trouble
        for axis in self._drives.axes:
            if axis.state is not PowerState.ENABLED:
                return f"{axis.name}: is no longer enabled but {axis.state.value}"
        return ""

    def _trouble(self, axis: Axis) -> str:
        if axis.restarted:
            return f"{axis.name}: its drive was restarted: open the machine again"
        if self._silent(axis):
            return f"{axis.name}: its drive does not answer"
        return f"{axis.name}: {axis.fault}" if axis.state in IN_FAULT else ""

    def _silent(self, axis: Axis) -> bool:
        return self._drives.now() - axis.heard > self._own.answer_timeout + self.period

    def _standing(self, mode: Mode | None = None) -> bool:
        """Whether all winches stand, or all that are in that *mode*."""
        pairs = zip(self._drives.axes, self._setpoints, strict=True)
        return all(abs(axis.velocity) < STANDS for axis, each in pairs if mode is None or each.mode is mode)

    def _frame(self) -> SensorFrame:
        time, axes = self._measured, self._drives.axes
        readings: list[Reading] = []
        if not any(axis.pending for axis in axes):
            counts = np.array([axis.counts for axis in axes], dtype=np.int64)
            counts.flags.writeable = False
            lines = self._drives.winches
            tensions = np.array([axis.scale.tension(axis.torque) for axis in axes])[lines.winch]
            torques = frozen([-axis.torque for axis in axes])
            alone = frozen(np.where(lines.alone, tensions, np.nan))
            readings += [Encoders(time, counts), Tensions("motor_torques", time, alone, torques)]
        if self._fresh:
            readings.append(self._drive_reading(time))
        readings += self._input_readings(time)
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
        """What the drives' inputs say; none in a cycle that did not bring them all.

        Inputs that are not known for `answer_timeout` say that it is not safe.
        """
        bits, axes, now = self._own.inputs, self._drives.axes, self._drives.now()
        old = [now - axis.inputs_heard > self._own.answer_timeout + self.period for axis in axes]
        if any(axis.pending >> 2 & 1 for axis in axes) and not any(old):
            return []

        def told(axis: Axis, bit: int) -> bool:
            return not old[axes.index(axis)] and bool(axis.inputs >> bit & 1)

        def all_set(bit: int | None) -> bool:
            return bit is None or all(told(axis, bit) for axis in axes)

        found: list[Reading] = []
        if bits.barrier is not None:
            found.append(Barrier(time, not all_set(bits.barrier)))
        if any(bit is not None for bit in (bits.chain, bits.torque_on, bits.enabling, bits.brake)):
            closed = () if bits.brake is None else tuple(told(axis, bits.brake) for axis in axes)
            found.append(Inputs(time, all_set(bits.chain), not all_set(bits.torque_on), all_set(bits.enabling), closed))
        return found

    def _notices(self) -> list[Notice]:
        found = list(self._limited)
        if self._drives.trouble:
            found.append(Notice(Condition.BUS_SILENT, self._drives.trouble))
        found += [Notice(Condition.BUS_SILENT, axis.name) for axis in self._drives.axes if self._silent(axis)]
        if self._slips:
            found.append(Notice(Condition.BRAKE, self._slips))
        if self.tripped:
            found.append(Notice(Condition.DRIVE_FAULT, self.tripped))
        return found


def _sensors(drives: WinchDriveSettings) -> frozenset[str]:
    bits, found = drives.inputs, {"encoders", "motor_torques", "drives"}
    if bits.barrier is not None:
        found.add("barrier")
    if any(bit is not None for bit in (bits.chain, bits.torque_on, bits.enabling, bits.brake)):
        found.add("inputs")
    return frozenset(found)


def _require_tensions(settings: MachineSettings, drives: WinchDriveSettings) -> None:
    """Raise `InputError` where tensions are not read, or the file has sensors that this machine cannot read."""
    if settings.sensor(MOTOR_TORQUES) is None:
        why = "drives are enabled only with measured tensions; add the table: drives report their torque"
        raise InputError(f"machine {settings.name!r}: no [motor_torques]: {why}")
    if settings.sensor(ENCODERS) is None:
        raise InputError(
            f"machine {settings.name!r}: no [encoders], through which the drives' positions are read: add this table"
        )
    if settings.sensor(BARRIER) is not None and drives.inputs.barrier is None:
        why = "no bit of the drives' inputs is it: give drives.inputs.barrier, or leave the table out"
        raise InputError(f"machine {settings.name!r}: [barrier]: {why}")
