"""A session with the drives of a machine: the same loop as a print, with procedures instead of a path to be printed.

Each order is that of the person who typed the command; whatever goes wrong after the winches were enabled ends it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.control import manual
from cablewright.control.homing import Homing, HomingSettings
from cablewright.control.manual import ManualSettings
from cablewright.control.path_follower import TimedPath
from cablewright.control.procedure import Procedure
from cablewright.control.take_up import PULLS, TakeUp, TakeUpSettings
from cablewright.control.winch_jog import WinchJog, WinchJogSettings
from cablewright.foundation.arrays import Array
from cablewright.foundation.choices import LawName
from cablewright.foundation.errors import InputError
from cablewright.foundation.saved_state import Snapshot
from cablewright.foundation.signals import Order, OrderKind, PrintState
from cablewright.live.drives.saved_lengths import KeptEstimator, LengthKeeper, warm
from cablewright.live.placeholder_path import still_path
from cablewright.live.prints.body_limits import chosen_places, poses_at
from cablewright.live.prints.limits import planned
from cablewright.live.prints.loop import Printer, PrintPlan, Step
from cablewright.machine.drives.can_bus import Port
from cablewright.machine.drives.choice import drives_of
from cablewright.machine.drives.drive_machine import DriveMachine
from cablewright.machine.drives.drives_of_winches import require_drives
from cablewright.machine.drives.limits import require_limits
from cablewright.machine.drives.settings import ACKNOWLEDGED, LOOPBACK
from cablewright.machine.drives.winch_drives import WinchDrives
from cablewright.machine.settings import MachineSettings, require_robot
from cablewright.machine.winch_counts import CountFile, Remembering
from cablewright.models.support_table import Capability, require
from cablewright.printing.job import Motion
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

_RESETS: Final = 3  # orders to reset before a session gives up
_RESET_WAIT: Final = 0.5  # s between them
_ORDER_PERIODS: Final = 3  # from an order to the drives
_SLOW: Final = Motion(print_speed=0.01, travel_speed=0.01, acceleration=0.05)  # m/s, m/s^2
_OVER: Final = 1.2  # of a drive's own limit: where the guard stops


@dataclass(eq=False)
class RealMachine:
    """A machine on drives, with its two files on disk: encoder counts and lengths."""

    robot: Robot
    settings: MachineSettings
    drives: WinchDrives
    bus_machine: DriveMachine
    machine: Remembering
    keeper: LengthKeeper

    @classmethod
    def of(
        cls, robot: Robot, settings: MachineSettings, state: Path, port: Callable[[], Port] | None = None
    ) -> RealMachine:
        """Return the machine on drives. Raises `InputError`. *state*: path of its two files, without suffix."""
        require_robot(settings, robot.name)
        require(robot, Capability.HOMING)
        known = require_drives(settings, robot)
        if port is None and known.interface != LOOPBACK and known.acknowledged is None:
            why = f"this version was {ACKNOWLEDGED}, and no performance level is claimed: read docs/drives.md first"
            raise InputError(
                f"machine {settings.name!r}: drives.acknowledged: is missing: {why}, then write {ACKNOWLEDGED!r}"
            )
        require_limits(robot, settings)
        drives = drives_of(robot, settings, port)
        bus_machine = DriveMachine(drives, settings)
        counts = CountFile(state.with_name(state.name + ".counts.json"), robot.name, robot.winch_names)
        counted = Remembering(bus_machine, counts)
        keeper = LengthKeeper(state.with_name(state.name + ".lengths.json"), robot, settings)
        keeper.machine = counted
        return cls(robot, settings, drives, bus_machine, counted, keeper)

    @property
    def take_up(self) -> TakeUpSettings:
        """Settings for taking up slack."""
        assert self.settings.drives is not None
        radius = max(axis.scale.radii[1] for axis in self.drives.axes)
        return TakeUpSettings(
            self.robot.winch_names,
            self.settings.drives.tension,
            self.keeper.reckoning.counts_per_radian,
            radius,
            arms=self.arms,
            opposed=self.drives.winches.opposed,
        )

    @property
    def arms(self) -> Array:
        """Return the lever arm (w,) of each drum, m: its smallest radius times the number of its cables."""
        return np.array([axis.scale.radii[0] * axis.scale.cables for axis in self.drives.axes])

    def homing(self, guess: Array, place: Array | None = None) -> Homing:
        """Return the procedure that homes the machine, near *guess* (n,) if nothing is saved.

        *place* (n,): pose measured by a person. Both in m and rad.
        """
        keeper, counted = self.keeper, self.machine  # which a sitting may pace
        near = guess if keeper.pose is None else keeper.pose
        scene = self.robot.scene
        frame = np.array(scene.frame_min), np.array(scene.frame_max)
        assert self.settings.drives is not None
        return Homing(
            HomingSettings(
                keeper.reckoning.model,
                self.take_up,
                keeper.lengths,
                keeper.accept,
                near,
                frame,
                place,
                keeper.tensions,
                self.settings.drives.tension_error,
                lambda: counted.power_lost,
                lambda: keeper.laid(),
            )
        )

    @property
    def estimator(self) -> str:
        """Name of the estimator to use: for a rigid platform the filter, whose torques correct its lengths."""
        return "encoders" if self.robot.n == 3 else "filter"

    @property
    def delay(self) -> float:
        """Time from an order to the start of the motion, s."""
        return _ORDER_PERIODS * self.settings.period + self.settings.winch.lag

    def by_hand(self, plan: ManualSettings) -> ManualSettings:
        """Limits of manual motion, including those of the drives."""
        own = self.settings.drives
        assert own is not None
        return replace(plan, deceleration=own.jog_deceleration, max_run_out=own.jog_run_out, delay=self.delay)

    def require_run_out(self, speed: float) -> None:
        """Raise `InputError` for a jog of the platform at *speed*, m/s, from which it would not stop in time."""
        own = self.settings.drives
        assert own is not None
        manual.require_run_out(speed, own.jog_deceleration, self.delay, own.jog_run_out)

    def winch_jog(self, winch: int, speed: float) -> WinchJog:
        """Return the procedure that jogs one winch at *speed*, m/s of cable. Raises `InputError`."""
        own, scale = self.settings.drives, self.drives.axes[winch].scale
        assert own is not None
        most = own.jog_tension or own.tension
        least = np.where(self.drives.winches.opposed, -np.inf, -PULLS * own.tension)
        limits = least, own.jog_deceleration, own.jog_run_out, self.delay, self.arms, scale.opposed
        return WinchJog(WinchJogSettings(winch, self.robot.winches, speed, most, scale.radii[1], *limits))

    def printer(
        self,
        path: TimedPath,
        law: LawName,
        procedures: dict[PrintState, Procedure],
        saved: Mapping[str, Snapshot] | None = None,
        begin: float = 0.0,
    ) -> Printer:
        """Return the control loop on this machine, whose clock begins at *begin*, s.

        Raises `InputError` for a path too fast for its drives, `AnswerError` for one out of reach.
        """
        settings, scales = self.settings, [axis.scale for axis in self.drives.axes]
        self.bus_machine.begin = begin
        plan = planned(self.robot, settings, path, settings.period, self.estimator, law, None)
        speed = min(scale.max_speed for scale in scales)
        fastest, thin = max(path.print_speed, path.travel_speed), min(scale.radii[0] for scale in scales)
        if fastest / thin > speed:
            why = f"lines may run at {fastest:g} m/s, {fastest / thin:.3g} rad/s of a drum; its drive has {speed:.3g}"
            raise InputError(f"the job is too fast for the drives: {why}; lower its speed")
        self._require_torque(plan)
        torques = np.array([_OVER * scale.max_torque for scale in scales])
        plan = replace(
            plan,
            velocity=replace(plan.velocity, max_drum_speed=speed),
            guard=replace(plan.guard, max_torques=torques, max_drum_speed=_OVER * settings.winch.max_speed),
            manual=self.by_hand(plan.manual),
            procedures=procedures,
        )
        warm(self.keeper, path.start_pose)
        return Printer(
            plan, self.machine, lambda pose, _radii: KeptEstimator(self.keeper, pose), now=begin, saved=saved
        )

    def reckon_powder(self, printer: Printer) -> None:
        """Let *printer* subtract the powder that it lays from the container; without a valve nothing leaves it."""
        assert self.settings.drives is not None
        if self.settings.drives.valve is not None and printer.plan.flow > 0.0:
            self.keeper.laid = lambda: printer.load.poured

    def _require_torque(self, plan: PrintPlan) -> None:
        """Raise `InputError` where the drives cannot hold the tensions that the control chooses on a path."""
        poses, retraction = poses_at(plan.velocity.model, plan.path, chosen_places(plan.path))
        pulls = solve_inverse(plan.velocity.model, poses, path=True, retraction=retraction).tensions
        winches = self.drives.winches
        largest = np.array([axis.scale.radii[1] for axis in self.drives.axes])[winches.winch]
        arms = largest * [line.cables for line in self.robot.lines]
        torques = np.nanmax(np.abs(winches.torques(pulls, arms)), axis=0)
        for axis, torque in zip(self.drives.axes, torques.tolist(), strict=True):
            if torque > axis.scale.max_torque:
                why = f"line {axis.name} needs {torque:.3g} N m of its drum; its drive has {axis.scale.max_torque:.3g}"
                raise InputError(f"the job is too heavy for the drives: {why}")


def session_path(robot: Robot, pose: Array | None) -> TimedPath:
    """Return a `still_path` about *pose* (n,), m and rad, or the middle of the frame, without rotation there."""
    scene = robot.scene
    middle = 0.5 * (np.array(scene.frame_min) + np.array(scene.frame_max))
    place = (middle if pose is None else pose[:3]) + np.array(robot.platform.nozzle)
    job, samples = still_path(robot, place, _SLOW)
    return TimedPath.of(job, nozzle=robot.platform.own_nozzle, samples=samples)


@dataclass(eq=False)
class SessionOperator:
    """Operator that resets and enables the winches, gives one order, and ends when it is done, or on an error.

    ``order``: None only enables. ``hold``: s for which the winches are then held. ``ends``: asked in each step.
    """

    by: str
    order: Order | None = None
    hold: float = 0.0
    ends: Callable[[], bool] = lambda: False
    each: Callable[[Printer], None] = lambda _printer: None
    reason: str = ""  # why it ended without success
    enabled: bool = False  # whether it ever got so far
    _resets: int = 0
    _reset_time: float = field(default=-np.inf, repr=False)
    _given: bool = False
    _done_time: float = np.inf

    def orders(self, printer: Printer, now: float) -> tuple[Order, ...]:
        """Return the orders since the last call, at *now*, s; see `Operator.orders`."""
        self.each(printer)
        state = printer.supervisor.state
        if state is PrintState.FAULT and not self.enabled:
            if now - self._reset_time < _RESET_WAIT or self._resets >= _RESETS:
                return ()
            self._resets, self._reset_time = self._resets + 1, now
            return (Order(OrderKind.RESET, self.by, now),)
        if state is PrintState.OFF and not self.enabled:
            return (Order(OrderKind.ENABLE, self.by, now),)
        if state is PrintState.IDLE and not self._given:
            self.enabled = self._given = True
            if self.order is not None:
                return (replace(self.order, by=self.by, time=now),)
        return ()

    def is_over(self, printer: Printer) -> bool:
        """Return whether the session with the drives ends; see `Operator.is_over`."""
        state, now = printer.supervisor.state, printer.time
        if state is PrintState.FAULT:
            gone = self.enabled or (self._resets >= _RESETS and now - self._reset_time > _RESET_WAIT)
            self.reason = printer.supervisor.reason if gone else ""
            return gone
        if self._given and state is PrintState.IDLE and now > printer.supervisor.state_start:
            if self.order is not None and printer.supervisor.reason not in ("", "enabled"):
                self.reason = printer.supervisor.reason
                return True
            self._done_time = min(self._done_time, now)
        return now - self._done_time >= self.hold or self.ends()


@dataclass(eq=False)
class Watching:
    """A recorder that keeps the last step, and which orders were rejected."""

    last: Step | None = None
    refusals: list[str] = field(default_factory=list)

    def add(self, _printer: Printer, step: Step, *, last: bool) -> None:  # noqa: ARG002
        """Record one step of the machine; see `StepRecorder.add`."""
        self.last = step
        self.refusals += [order.refusal for order in step.orders if order.refusal]


def taking_up(machine: RealMachine) -> TakeUp:
    """Return the procedure that takes up slack of the lines."""
    return TakeUp(machine.take_up)
