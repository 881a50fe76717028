"""The control loop of a print: machine, guard, estimation, supervision and control, step by step.

Nothing here knows what kind of machine it is: see `cablewright.machine.interface`.
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar, Final, Protocol, runtime_checkable

import numpy as np

from cablewright.control import guard, height, manual, path_follower, retraction, stretch_damping, supervisor, velocity
from cablewright.control.balance_check import cleared
from cablewright.control.clock import FrameClock
from cablewright.control.guard import GuardSettings, GuardState, StopCause
from cablewright.control.height import HeightControl
from cablewright.control.manual import ManualSettings, ManualState
from cablewright.control.orders import BY_HAND, OrderState, examine
from cablewright.control.path_follower import GuideMode, GuideState, Target, TimedPath
from cablewright.control.procedure import Procedure
from cablewright.control.retraction import BeamMotion, BeamSettings, BeamState
from cablewright.control.stop import StopKind, StopState, advance
from cablewright.control.supervisor import SupervisorSettings, SupervisorState, Verdict
from cablewright.control.velocity import VelocitySettings
from cablewright.control.yaw import YawSettings, YawState, yaw_rate
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.saved_state import Saved, Snapshot, load
from cablewright.foundation.signals import (
    RETRACTION,
    YAW,
    Command,
    Estimate,
    Order,
    OrderKind,
    PrintState,
    Progress,
    SensorFrame,
    WinchMode,
    frozen,
)
from cablewright.live.estimators import DeadReckoning, Estimator, Measuring, Weighing
from cablewright.machine.interface import RESET, Machine, check_command, require_abilities
from cablewright.machine.powder_load import PowderLoad

MakeEstimator = Callable[[Array, Array], Estimator]
"""Makes an estimator from the platform's last pose (n,), m and rad, and the drums' radii (m,), m; 0: unknown."""


@runtime_checkable
class Learning(Protocol):
    """An estimator whose state is saved with a print, and which may find a reason to stop the machine."""

    SAVED: ClassVar[Saved]

    @property
    def danger(self) -> str:
        """Reason why the machine must stop; empty: none. It may become more exact."""

    @property
    def searches(self) -> bool:
        """Whether the estimator still searches for the cause of the danger."""


_TENSIONED: Final = 0.1  # share of the smallest chosen tension by which all may deviate when a path begins
_COLLECT_STEPS: Final = 100  # between garbage collections of a loop in real time
_MAX_STEPS: Final = 100_000_000
_SAFETY_TIMEOUT: Final = 0.5  # s without drives or inputs, of a machine that has them


@dataclass(frozen=True, eq=False)
class PrintPlan:
    """Path and settings of a print. ``procedures``: keyed by the state in which they run, TENSIONING or HOMING."""

    path: TimedPath
    velocity: VelocitySettings
    supervisor: SupervisorSettings
    guard: GuardSettings
    manual: ManualSettings
    height: HeightControl | None = None  # None: the heights of the path
    flow: float = 0.0  # kg/s of powder with the valve open
    powder: float = math.inf  # kg in a full drum
    sensors: frozenset[str] = frozenset()  # that the machine must have
    procedures: Mapping[PrintState, Procedure] = field(default_factory=dict)
    beam: BeamSettings | None = None  # of a platform that retracts
    yaw: YawSettings | None = None  # of a drum whose yaw is held
    notes: tuple[str, ...] = ()  # properties of the path that its job does not have


@dataclass(frozen=True, eq=False)
class Step:
    """One step of a print: its command, the sensor frame at its end, the orders, and estimate and progress after it."""

    command: Command
    frame: SensorFrame
    estimate: Estimate
    progress: Progress
    orders: tuple[Order, ...] = ()


class Printer:
    """The control loop of one print. `step` raises nothing, whatever a frame contains."""

    SAVED = ("guide", "load", "supervisor", "yaw", "_powder_out_time", "last_pose", "radii")

    def __init__(
        self,
        plan: PrintPlan,
        machine: Machine,
        make: MakeEstimator,
        *,
        now: float = 0.0,
        saved: Mapping[str, Snapshot] | None = None,
    ) -> None:
        """Start in a fault, to be reset, at the start of the path or as *saved*; *now*: machine time, s.

        Raises `InputError` for a machine that lacks equipment of the plan.
        """
        robot, able = plan.velocity.model.robot, machine.abilities
        require_abilities(able, robot.winches, plan.sensors)
        silent = {source: _SAFETY_TIMEOUT for source in ("drives", "inputs") if source in able.sensors}
        guarded = replace(plan.guard, timeouts=silent | dict(plan.guard.timeouts))
        self.plan, self.machine = replace(plan, guard=guarded), machine
        self._full_mass = plan.velocity.model.robot.platform.mass
        self.guide, self.supervisor = GuideState(), SupervisorState()
        self.velocity = velocity.start(plan.velocity)
        self.load = PowderLoad(plan.flow, plan.powder)  # estimated
        self.target: Target | None = None
        self.last_pose = plan.path.start_pose.copy()  # (n,) m and rad, last valid one of the platform
        self.radii = np.zeros(robot.m)  # (m,) m, last estimated, of the winch drums; 0: unknown, or none
        self.frame_times = (0.0, 0.0)  # s, arrival of the last frame: wall clock and processor time
        self.speed_share = 1.0  # of the planned speed
        self._clock, self._orders = FrameClock(machine.period, now), OrderState()
        self._guard, self._manual, self.yaw = GuardState(), ManualState(), YawState()
        self._stop: StopState | None = StopState.closed(robot.winches)
        self._command = self._standing(now, frozen(np.zeros(robot.winches)), WinchMode.OFF)
        self._approach_pending = True  # the approach begins at the platform's position, once that is valid
        self._powder_out_time = math.inf  # s of the path's time law, at which the powder ran out
        if saved is not None:
            load(self, saved["print"])
        self.estimator = make(self.last_pose, self.radii)
        self._beam = None if plan.beam is None else BeamState(plan.path.start_retraction)
        self.learning = self.estimator if isinstance(self.estimator, Learning) else None
        self._weighing = self.estimator if isinstance(self.estimator, Weighing) else None
        self._measuring = self.estimator if isinstance(self.estimator, Measuring) else None
        self._danger = ""  # last one of the estimator
        if saved is not None and self.learning is not None and self.learning.SAVED:
            load(self.learning, saved["estimator"])

    @property
    def finished(self) -> bool:
        """Whether the end of the path has been reached."""
        return self.supervisor.finished

    @property
    def time(self) -> float:
        """Time of the machine at its last sensor frame, s."""
        return self._clock.now

    @property
    def command(self) -> Command:
        """Winch speeds and valve for the next step of the print."""
        return self._command

    @property
    def damps(self) -> bool:
        """Whether the last step damped a swing, if the winches move."""
        stretch = self.velocity.stretch
        return self.plan.velocity.swing is not None or (stretch.filtered is not None and stretch.time == self.time)

    @property
    def tensions(self) -> Array | None:
        """Tensions (m,), N, that the control uses: as measured, or of a rigid platform by the lengths."""
        measured = None if self._measuring is None else self._measuring.measured
        return measured if measured is not None or self.plan.path.attitude is None else self.estimator.tensions

    def refilled(self) -> None:
        """Record that the container is full."""
        self.load.refill()

    def place_measured(self, place: Array, *, by_tensions: bool = False) -> None:
        """Pass the measured position (3,), m, of the standing platform to the estimator.

        *by_tensions*: see `encoders_only.placed`. Raises `InputError` if it takes no position.
        """
        if not isinstance(self.estimator, DeadReckoning):
            raise InputError("a measured position needs the estimator of encoders alone: --estimator encoders")
        self.estimator.place_measured(place, by_tensions)

    def step(self, orders: tuple[Order, ...] = ()) -> Step:
        """Run one period of the machine and compute the next command."""
        command = self._command
        frame, dt = self._clock.tell(self.machine.step(command))
        self.frame_times = time.perf_counter(), time.thread_time()
        self.load.pour(command.valve, dt)
        if self._weighing is not None:
            self._weighing.weigh(self._full_mass - self.load.gone)
        estimate = self.estimator.step(frame)
        velocity.note_counts(self.velocity, frame)
        if self._beam is not None and self.plan.beam is not None:
            retraction.read(self.plan.beam, self._beam, frame)
        state = self.supervisor.state
        stopped = self._stop is None or self._stop.at_rest(self.plan.guard.stop)
        verdict = supervisor.step(
            self.plan.supervisor,
            self.supervisor,
            frame,
            estimate,
            cause=self._cause(frame, state),
            standing=not any(command.winch_speeds.tolist()) and WinchMode.TENSION not in command.modes,
            stopped=stopped,
            target=self.target,
            powder=self.load.left,
            orders=examine(
                self.plan.manual,
                self._orders,
                orders,
                self.time,
                known=math.isfinite(self.supervisor.valid_since),
                procedures=self.plan.procedures,
                step=self.machine.period,
            ),
        )
        if estimate.valid:
            self.last_pose[:3] = estimate.position
            self.radii[:] = [each if math.isfinite(each) else 0.0 for each in estimate.radii.tolist()]
            self.last_pose[3:] = estimate.rotation[: len(self.last_pose) - 3]
        self._on_transition(state, verdict)
        self._begin_stop(state, verdict, command)
        self._obey(verdict.orders, state, estimate)
        if self.plan.height is not None and verdict.state is PrintState.PRINTING:
            self.guide.height_offset = height.step(self.plan.height, self.guide.height_offset, estimate.clearance, dt)
        if self._approach_pending and estimate.valid:
            path_follower.leave_path(self.plan.path, self.guide, estimate.position, estimate.rotation)
            self._approach_pending = False
        target = self._next_target(verdict, estimate, dt)
        self.target = None if self._approach_pending else target
        self._command = self._with_reset(verdict, self._sound(self._decide(frame, verdict, estimate, target, dt)))
        guard.take_note(self._guard, frame.time, self._command)
        return Step(command, frame, estimate, self._progress(verdict, estimate, target), verdict.orders)

    @property
    def searches(self) -> bool:
        """Whether the estimator still searches for the cause of the stop."""
        return self.learning is not None and self.learning.searches

    def _cause(self, frame: SensorFrame, state: PrintState) -> StopCause | None:
        """Why the machine is to stop: by measured limits, and by the estimate."""
        lowest = state is PrintState.PRINTING
        inferred, best = self.estimator.tensions, self.tensions
        limits = self.plan.guard.max_tensions
        if inferred is not None and best is not None and (inferred > limits).any():
            own, beam = self.plan.velocity.model, None if self._beam is None else self._beam.length
            inferred = cleared(own, self.last_pose, inferred, best, limits, self.load.gone, beam)
        found = guard.judge(self.plan.guard, self._guard, frame, inferred, lowest=lowest, best=best)
        danger = "" if self.learning is None else self.learning.danger
        if danger != self._danger:
            supervisor.explain(self.supervisor, self._danger, danger)
            self._danger = danger
        return found or (StopCause(danger, StopKind.HOLD) if danger else None)

    def _begin_stop(self, previous: PrintState, verdict: Verdict, command: Command) -> None:
        """Begin a stop of the winches, make one more urgent, or end it where the state lets them move."""
        interrupted = previous in _HANDLED and verdict.state is PrintState.IDLE
        if verdict.state in (PrintState.FAULT, PrintState.OFF) or interrupted:
            if self._stop is None:
                self._stop = StopState(command.winch_speeds)
            self._stop.brakes = not interrupted
            if verdict.stop is not None:
                self._stop.worsen(verdict.stop)
        elif verdict.state is not previous:
            self._stop = None

    def _on_transition(self, previous: PrintState, verdict: Verdict) -> None:
        """Set where the target continues after a change of state."""
        if verdict.state is previous:
            return
        if verdict.state is PrintState.FAULT:  # the target stands with the machine
            self.guide.stand()
        if verdict.state is PrintState.REFILLING and self.load.left > self.plan.supervisor.refill_mass:
            self._powder_out_time = self.guide.path_time  # earlier than estimated: the path will continue from here
        if verdict.state is PrintState.READY:
            if math.isfinite(self._powder_out_time):
                self.guide.path_time, self._powder_out_time = self._powder_out_time, math.inf
            self.guide.position = None
            self.guide.stand()
            self._approach_pending = True
        if verdict.state in self.plan.procedures:
            self.plan.procedures[verdict.state].begin(self.time)

    def _obey(self, orders: tuple[Order, ...], previous: PrintState, estimate: Estimate) -> None:
        """Take the arguments of the orders that were accepted."""
        for order in orders:
            if order.refusal:
                continue
            if order.kind is OrderKind.OVERRIDE:
                self.speed_share = order.arguments["share"][0]
            elif self.supervisor.state is PrintState.MANUAL and order.kind in BY_HAND:
                at = self.plan.path.printing_point(estimate.position, estimate.rotation), estimate.rotation
                begun = previous is PrintState.MANUAL
                manual.begin(self.plan.manual, self._manual, order, self.time, None if begun else at)

    def _next_target(self, verdict: Verdict, estimate: Estimate, dt: float) -> Target:
        if verdict.state is not PrintState.MANUAL:
            target = path_follower.step(self.plan.path, self.guide, dt, verdict.guide_mode, self.speed_share)
            waits = verdict.state is PrintState.READY and not self._is_tensioned()
            return target._replace(arrived=False) if waits else target
        motion = manual.step(self.plan.manual, self._manual, self.time, dt, self._off_target(estimate))
        if motion.done:
            supervisor.end_procedure(self.supervisor, self.time, motion.failure)
        path, distance = self.plan.path, self.plan.path.distance(self.guide.path_time)
        layer = int(path.track.layer[path.track.piece(distance)])
        place, turned = motion.position, np.zeros(3)
        if path.attitude is not None:
            place, turned = path.attitude.origin(place, self._manual.rotation), self._manual.rotation
        own = place, motion.velocity, distance, layer, 0.0, False, False, False, turned
        return Target(*own, accelerations=motion.accelerations)

    def _off_target(self, estimate: Estimate) -> float:
        """Distance, m, of the moved point from the target of a motion by hand; 0 where the estimate swings with it."""
        if not (self.plan.velocity.by_lengths or self.plan.path.attitude is not None):
            return 0.0
        there = self.plan.path.printing_point(estimate.position, estimate.rotation)
        return float(np.linalg.norm(there - self._manual.position))

    def _is_tensioned(self) -> bool:
        """Whether lines with winches have about their tensions on the path: those that the control chooses."""
        own = self.plan.velocity
        chooses = own.model.m > own.model.freedoms and own.law == "model" and not own.manage_slack
        if not (chooses or self.plan.path.attitude is not None):
            return True
        wait, wanted = self.plan.supervisor.tensioning_timeout, self.velocity.chosen
        waited = self.time - self.supervisor.state_start > wait
        if waited or wanted is None:
            return waited
        return self.velocity.tension_error <= _TENSIONED * float(wanted[list(own.model.robot.hosts)].min())

    def _decide(self, frame: SensorFrame, verdict: Verdict, estimate: Estimate, target: Target, dt: float) -> Command:
        now = frame.time
        if self._stop is not None:
            speeds, mode = advance(self.plan.guard.stop, self._stop, self.machine.period)
            return self._standing(now, frozen(speeds), mode)
        if verdict.state in self.plan.procedures:
            return self._proceed(now, verdict, frame, estimate, dt)
        if verdict.hold_winches or not estimate.valid:
            return Command(now, frozen(np.zeros(self.machine.abilities.winches)))
        own, tensions, moved = self.plan.velocity, self.tensions, self._retract(target, dt)
        if own.stretch is not None:
            stretch_damping.listen(own.stretch, self.velocity.stretch, frame)
        calms = verdict.guide_mode is not GuideMode.HOLD and verdict.state is not PrintState.MANUAL  # its ramps stay
        speeds = velocity.step(own, self.velocity, estimate, target, dt, tensions, moved, calms=calms)
        outputs = {} if moved is None else {RETRACTION: moved.speed}
        if self.plan.yaw is not None:
            outputs[YAW] = yaw_rate(self.plan.yaw, self.yaw, frame, estimate.yaw, dt)
        opening = target.flow / self.plan.path.print_speed if verdict.valve_allowed else 0.0
        return Command(now, frozen(speeds), min(max(opening, 0.0), 1.0), outputs=outputs)

    def _retract(self, target: Target, dt: float) -> BeamMotion | None:
        """The motion of the beam in the next step; None of a platform that does not retract."""
        if self.plan.beam is None or self._beam is None:
            return None
        return retraction.step(self.plan.beam, self._beam, target.retraction, target.retraction_rate, dt)

    def _standing(self, now: float, speeds: Array, mode: WinchMode) -> Command:
        """A command of a stop, in its mode where the machine has it."""
        has = mode is not WinchMode.VELOCITY and mode in self.machine.abilities.modes
        return Command(now, speeds, modes=(mode,) * len(speeds) if has else ())

    def _with_reset(self, verdict: Verdict, command: Command) -> Command:
        """The command, with an order to reset for the machine's drives where winches are disabled.

        It reaches them even where it was rejected, as their own faults are a cause for that: it is ordered again then.
        """
        since = self.supervisor.state_start  # older orders are from before the fault
        asked = any(order.kind is OrderKind.RESET and order.time >= since for order in verdict.orders)
        able = RESET in self.machine.abilities.outputs and WinchMode.OFF in command.modes
        return replace(command, outputs={RESET: 1.0}) if asked and able else command

    def _proceed(self, now: float, verdict: Verdict, frame: SensorFrame, estimate: Estimate, dt: float) -> Command:
        """The command of the procedure that runs. Where it ends, the winches come to rest by a ramp."""
        done = self.plan.procedures[verdict.state].step(frame, estimate, dt)
        if done.finished or done.failure:
            supervisor.end_procedure(self.supervisor, now, done.failure)
            self._stop = StopState(self._command.winch_speeds, brakes=False)
            speeds, mode = advance(self.plan.guard.stop, self._stop, self.machine.period)
            return self._standing(now, frozen(speeds), mode)
        return Command(now, frozen(done.winch_speeds), modes=done.modes, tensions=done.tensions)

    def _sound(self, command: Command) -> Command:
        """The command, if a machine can take it within the limits; else all winches stop, and the state is a fault."""
        try:
            check_command(self.machine.abilities, command, -math.inf)
            most = self.plan.guard.max_drum_speed or math.inf
            if not max(map(abs, command.winch_speeds.tolist())) <= most:
                raise InputError(f"command.winch_speeds: over {most:g} rad/s")
        except InputError as error:
            supervisor.fail(self.supervisor, command.time, f"the control failed: {error}")
            self._stop = StopState(np.zeros(self.machine.abilities.winches), StopKind.HOLD)
            return self._standing(command.time, frozen(self._stop.speeds), WinchMode.HOLD)
        return command

    def _progress(self, verdict: Verdict, estimate: Estimate, target: Target) -> Progress:
        error, tensions = math.nan, None
        if verdict.state is PrintState.PRINTING and estimate.valid:
            tensions = self.velocity.chosen
            printed = self.plan.path.printing_point(estimate.position, estimate.rotation)
            error = self.plan.path.offset(printed, target.distance)
        due = velocity.due(self.plan.velocity, self.velocity, target, self.time)
        where = target.layer, target.distance, frozen(self.plan.path.printing_point(*due))
        return Progress(estimate.time, verdict.state, *where, error, verdict.reason, tensions)


_HANDLED: Final = (PrintState.TENSIONING, PrintState.HOMING, PrintState.MANUAL)


class Operator(Protocol):
    """Interface of the source of orders: a person at a page or a terminal, or a simulated operator."""

    def orders(self, printer: Printer, now: float) -> tuple[Order, ...]:
        """Return the orders since the last call, at *now*, s. Is called once in each step."""

    def is_over(self, printer: Printer) -> bool:
        """Whether the operator ends the run at this step."""


class StepRecorder(Protocol):
    """Interface of an object that records the steps of a print."""

    def add(self, printer: Printer, step: Step, *, last: bool) -> None:
        """Record one step; *last*: whether it is the last step of this run."""


def run(printer: Printer, operator: Operator, recorder: StepRecorder) -> int:
    """Run until the operator ends it; return the number of steps.

    The machine is opened before and closed after, whatever happens; an error in between stops it first.
    """
    machine = printer.machine
    try:
        machine.open()
        for number in range(1, _MAX_STEPS):
            step = printer.step(operator.orders(printer, printer.time))
            last = operator.is_over(printer)
            recorder.add(printer, step, last=last)
            if last:
                return number
            if machine.abilities.real_time and number % _COLLECT_STEPS == 0:
                gc.collect(1)
        return _MAX_STEPS
    finally:
        try:
            machine.stop()
        finally:
            machine.close()
