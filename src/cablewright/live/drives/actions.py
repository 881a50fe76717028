"""Actions on the drives of a real machine besides printing: scan, write, enable, tension, home, jog."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.control.homing import Homing
from cablewright.control.manual import MAX_SPEED
from cablewright.control.procedure import Procedure
from cablewright.control.take_up import pulls_of
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.signals import Drives, DriveState, Order, OrderKind, PrintState, Tensions
from cablewright.live.drives.answers import BusScan, DriveLine, DriveSession, DriveValues, Found, Value
from cablewright.live.drives.session import RealMachine, SessionOperator, Watching, session_path, taking_up
from cablewright.live.prints import loop
from cablewright.live.prints.loop import Printer
from cablewright.machine.drives.can_bus import Port
from cablewright.machine.drives.choice import drives_of
from cablewright.machine.settings import MachineSettings
from cablewright.robot import Robot
from cablewright.running.garbage_collection import without_old_objects

PERSON: Final = "terminal"
"""Who gives the orders of a command."""

_STAND: Final = {"velocity": (0.0, 0.0, 0.0)}  # of a jog that is let go

OpenPort = Callable[[], Port] | None


def scan(robot: Robot, settings: MachineSettings, port: OpenPort = None) -> BusScan:
    """Ask all nodes of the machine's bus for their identity. Raises `EnvironmentFault`."""
    drives = drives_of(robot, settings, port)
    lines = {axis.node: axis.name for axis in drives.axes}
    found = tuple(Found(each, lines.get(each.node)) for each in drives.scan())
    there = {each.identity.node for each in found}
    return BusScan(settings.name, found, tuple(name for node, name in lines.items() if node not in there))


def show(robot: Robot, settings: MachineSettings, port: OpenPort = None) -> DriveValues:
    """Read the supervision and stop options of drives; nothing is written. Raises `EnvironmentFault`, `InputError`."""
    drives = drives_of(robot, settings, port)
    return DriveValues(
        settings.name,
        tuple(
            Value(line, str(each.object), each.value, value, each.optional if value is None else each.agrees(value))
            for line, rows in drives.read().items()
            for each, value in rows
        ),
    )


def write(robot: Robot, settings: MachineSettings, state: Path, port: OpenPort = None) -> DriveSession:
    """Write the drives' supervision settings and read them back; nothing is enabled.

    Raises `EnvironmentFault`, `InputError`.
    """
    machine = RealMachine.of(robot, settings, state, port)
    machine.machine.open()
    try:
        drives = tuple(DriveLine(axis.name, DriveState.OFF, fault=axis.fault) for axis in machine.drives.axes)
    finally:
        machine.machine.close()
    return _answer(machine, "write", "", drives)


def release(robot: Robot, settings: MachineSettings, state: Path, port: OpenPort = None) -> DriveSession:
    """Remove torque from all winches with closed brakes, in any state left by an earlier program. Raises as `write`."""
    machine = RealMachine.of(robot, settings, state, port)
    watching, loop_of = Watching(), _printer(machine, {})
    loop.run(loop_of, _Off(), watching)
    return _answer(machine, "release", "", _lines(machine, watching), loop_of.time)


def enable(
    robot: Robot,
    settings: MachineSettings,
    state: Path,
    hold: float,
    port: OpenPort = None,
    ends: Callable[[], bool] = lambda: False,
) -> DriveSession:
    """Enable all winches, hold them for *hold*, s, or until *ends*, and close the brakes. Raises as `write`."""
    machine = RealMachine.of(robot, settings, state, port)
    return _session(machine, "enable", SessionOperator(PERSON, hold=hold, ends=ends), {})


def tension(robot: Robot, settings: MachineSettings, state: Path, port: OpenPort = None) -> DriveSession:
    """Take up all slack of the lines. Raises as `write`."""
    machine = RealMachine.of(robot, settings, state, port)
    operator = SessionOperator(PERSON, Order(OrderKind.TAKE_UP))
    return _session(machine, "tension", operator, {PrintState.TENSIONING: taking_up(machine)})


def home(
    robot: Robot, settings: MachineSettings, state: Path, place: Array | None = None, port: OpenPort = None
) -> DriveSession:
    """Home a real machine: take up slack, then test the saved lengths, or find them from a measured *place*.

    Raises as `write`. *place*: (3,) m, or of a rigid platform (6,) m and rad, of which (3,) is unrotated.
    """
    if place is not None:
        _require_inside(robot, place)
        place = np.pad(place, (0, robot.n - len(place)))
    machine = RealMachine.of(robot, settings, state, port)
    homing = machine.homing(_guess(machine), place)
    return _session(machine, "home", SessionOperator(PERSON, Order(OrderKind.HOME)), {PrintState.HOMING: homing})


def jog_winch(
    robot: Robot,
    settings: MachineSettings,
    state: Path,
    line: str,
    speed: float,
    held: Callable[[], bool],
    ends: Callable[[], bool],
    port: OpenPort = None,
) -> DriveSession:
    """Turn the winch of one *line* at a speed, m/s of cable, while *held*; positive pays out. Raises as `write`."""
    machine = RealMachine.of(robot, settings, state, port)
    names = list(robot.winch_names)
    if line not in names:
        raise UnknownName("line", line, names)
    jog = machine.winch_jog(names.index(line), speed)

    def each(_printer: Printer) -> None:
        if held():
            jog.lease()
        else:
            jog.let_go()

    operator = SessionOperator(PERSON, Order(OrderKind.TAKE_UP), ends=ends, each=each)
    return _session(machine, "jog", operator, {PrintState.TENSIONING: jog})


def jog_platform(
    robot: Robot,
    settings: MachineSettings,
    state: Path,
    velocity: Sequence[float],
    held: Callable[[], bool],
    ends: Callable[[], bool],
    port: OpenPort = None,
) -> DriveSession:
    """Home, then move the platform at *velocity* (3,), m/s, while *held*. Raises as `write`."""
    speed = float(np.linalg.norm(velocity))
    if not 0.0 < speed <= MAX_SPEED:
        raise InputError(f"jog: {speed:g} m/s; over 0 and at most {MAX_SPEED:g} is allowed by hand")
    machine = RealMachine.of(robot, settings, state, port)
    machine.require_run_out(speed)
    homing = machine.homing(_guess(machine))
    arguments = {"velocity": tuple(float(each) for each in velocity)}
    operator = _JogOperator(PERSON, Order(OrderKind.HOME), hold=float("inf"))
    operator.ends = lambda: ends() or bool(machine.keeper.doubt)
    operator.jog, operator.held = Order(OrderKind.JOG, PERSON, arguments=arguments), held
    return _session(machine, "jog", operator, {PrintState.HOMING: homing})


def _require_inside(robot: Robot, place: Array) -> None:
    """Raise `InputError` for a place outside the frame."""
    scene = robot.scene
    for axis, low, at, high in zip("xyz", scene.frame_min, place[:3].tolist(), scene.frame_max, strict=True):
        if not low <= at <= high:
            why = f"is outside the frame of {robot.name}, {low:g} to {high:g} m; places are in m"
            raise InputError(f"place: {axis} = {at:g} m: {why}")


class _Off:
    """An operator who wants all off."""

    _steps = 30

    def orders(self, _printer: Printer, _now: float) -> tuple[Order, ...]:
        """Return the orders since the last call, at *now*, s; see `Operator.orders`."""
        self._steps -= 1
        return ()

    def is_over(self, _printer: Printer) -> bool:
        """Return whether the run ends; see `Operator.is_over`."""
        return self._steps <= 0


class _JogOperator(SessionOperator):
    """One who homes the machine and then holds a button."""

    jog: Order
    held: Callable[[], bool]

    def orders(self, printer: Printer, now: float) -> tuple[Order, ...]:
        """Return the orders since the last call, at *now*, s; see `Operator.orders`."""
        given, state = super().orders(printer, now), printer.supervisor.state
        if given or not self.homed or state not in (PrintState.IDLE, PrintState.MANUAL):
            return given
        if self.held():
            self._moves = True
            return (Order(OrderKind.JOG, self.by, now, self.jog.arguments),)
        if not self._moves:
            return ()
        self._moves = False
        return (Order(OrderKind.JOG, self.by, now, _STAND),) if state is PrintState.MANUAL else ()

    def is_over(self, printer: Printer) -> bool:
        """Return whether the run ends; see `Operator.is_over`."""
        over = super().is_over(printer)
        self.homed = self.homed or (self._given and printer.supervisor.valid_since > 0.0)
        return over if not self.homed or self.reason else self.ends()

    homed = False
    _moves = False  # since the button was last held


def _guess(machine: RealMachine) -> Array:
    return session_path(machine.robot, machine.keeper.pose).start_pose


def _printer(machine: RealMachine, procedures: dict[PrintState, Procedure]) -> Printer:
    return machine.printer(session_path(machine.robot, machine.keeper.pose), "model", procedures)


def _session(
    machine: RealMachine, action: str, operator: SessionOperator, procedures: dict[PrintState, Procedure]
) -> DriveSession:
    watching, printer = Watching(), _printer(machine, procedures)
    with without_old_objects(paced=True):
        loop.run(printer, operator, watching)
    if operator.reason and not operator.enabled and watching.refusals:
        operator.reason = watching.refusals[-1]  # why it could not be reset says more
    operator.reason = machine.keeper.doubt or operator.reason
    homing = procedures.get(PrintState.HOMING)
    lines = _lines(machine, watching)
    if isinstance(homing, Homing) and homing.pose is not None:
        x, y, z, *turn = homing.pose.tolist()
        found = _answer(machine, action, operator.reason, lines, printer.time)
        found = replace(found, position=(x, y, z), misfit=homing.misfit, notes=tuple(homing.notes))
        return replace(found, rotation=tuple(turn)) if turn else found
    return _answer(machine, action, operator.reason, lines, printer.time)


def _lines(machine: RealMachine, watching: Watching) -> tuple[DriveLine, ...]:
    names = [axis.name for axis in machine.drives.axes]
    step = watching.last
    drives = () if step is None else step.frame.of(Drives)
    pulls = () if step is None else step.frame.of(Tensions)
    if not drives:
        return tuple(DriveLine(name, DriveState.OFF) for name in names)
    tensions = pulls_of(pulls[0], machine.arms).tolist() if pulls else [float("nan")] * len(names)
    rows = zip(names, drives[0].states, tensions, drives[0].faults, strict=True)
    return tuple(DriveLine(*row) for row in rows)


def _answer(
    machine: RealMachine,
    action: str,
    reason: str,
    drives: tuple[DriveLine, ...],
    duration: float = 0.0,
) -> DriveSession:
    settings = machine.settings
    assert settings.drives is not None
    bus = machine.drives.statistics.figures(settings.period, settings.drives.bitrate)
    reason = reason or machine.bus_machine.left
    return DriveSession(settings.name, action, reason, drives, bus, duration)
