"""The control loop of a print: a machine, its guard, estimation, supervision and control.

Nothing here knows what kind of machine it is: see `cablewright.machine.interface`.
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final, Protocol

import numpy as np

from cablewright.arrays import Array
from cablewright.control import guard, guide, height, manual, supervisor, velocity
from cablewright.control.guard import GuardSettings, GuardState, RampState
from cablewright.control.guide import GuideState, Target, TimedPath
from cablewright.control.height import HeightControl
from cablewright.control.manual import ManualSettings, ManualState
from cablewright.control.procedure import Procedure
from cablewright.control.supervisor import SupervisorSettings, SupervisorState, Verdict
from cablewright.control.velocity import VelocitySettings
from cablewright.machine.interface import Machine, require_abilities
from cablewright.machine.simulated.snapshot import Archive
from cablewright.signals import (
    Command,
    Condition,
    Estimate,
    Notice,
    Order,
    OrderKind,
    PrintState,
    Progress,
    SensorFrame,
    WinchMode,
    frozen,
)
from cablewright.studies.estimators import Estimator

MakeEstimator = Callable[[Array, Array], Estimator]
"""Makes an estimator from the platform's last position (3,), m, and the winch drums' radii (m,), m; 0: unknown."""

_SAME: Final = 1e-6  # of a period: elapsed times that differ by less are a period, told by a clock with rounding
_LATE: Final = 1.5  # periods after which a step is an overrun
_MOST: Final = 3.0  # periods for which the control goes on after a gap
_COLLECT_STEPS: Final = 100  # between garbage collections of a loop in real time
_MAX_STEPS: Final = 100_000_000


@dataclass(frozen=True, eq=False)
class PrintPlan:
    """Path and settings of a print. ``procedures``: by the state in which they run, `TENSIONING` or `HOMING`."""

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


@dataclass(frozen=True, eq=False)
class Step:
    """One step: its command, the sensor frame at its end, the orders, and estimate and progress from that frame."""

    command: Command
    frame: SensorFrame
    estimate: Estimate
    progress: Progress
    orders: tuple[Order, ...] = ()


class Printer:
    """Runs one machine through one plan. `step` raises nothing, whatever a frame contains."""

    def __init__(
        self,
        plan: PrintPlan,
        machine: Machine,
        make: MakeEstimator,
        *,
        now: float = 0.0,
        archive: Archive | None = None,
    ) -> None:
        """Start in a fault, to be reset, at the start of the path or as in *archive*; *now*: machine time, s.

        Raises `InputError` for a machine that lacks what the plan needs.
        """
        m = plan.velocity.model.m
        require_abilities(machine.abilities, m, plan.sensors)
        self.plan, self.machine = plan, machine
        self.guide, self.supervisor = GuideState(), SupervisorState()
        self.velocity = velocity.start(plan.velocity)
        self.powder = plan.powder  # kg in the drum, estimated
        self.target: Target | None = None
        self.last_position = plan.path.track.at(0.0).position.copy()  # (3,) m, last valid one of the platform
        self.radii = np.zeros(m)  # (m,) m, last estimated, of the winch drums; 0: unknown
        self.frame_times = (0.0, 0.0)  # s, arrival of the last frame: wall clock and processor time
        self.speed_share = 1.0  # of the planned speed
        self._now = now
        self._command = Command(now, frozen(np.zeros(m)))
        self._guard, self._manual = GuardState(), ManualState()
        self._ramp: RampState | None = None
        self._approach_pending = True  # the approach begins at the platform's position, once that is valid
        self._powder_out_time = math.inf  # s of the path's time law, at which the powder ran out
        if archive is not None:
            self.archive_state(archive)
        self.estimator = make(self.last_position, self.radii)

    @property
    def finished(self) -> bool:
        """Whether the end of the path has been reached."""
        return self.supervisor.finished

    @property
    def time(self) -> float:
        """The machine's time at the last frame, s."""
        return self._now

    @property
    def command(self) -> Command:
        """The command of the next step."""
        return self._command

    def archive_state(self, archive: Archive) -> None:
        """Save or load the progress of the print."""
        path, supervised = self.guide, self.supervisor
        path.path_time = archive.number("path_time", path.path_time)
        path.height_offset = archive.number("height_offset", path.height_offset)
        self.powder = archive.number("powder", self.powder)
        self._powder_out_time = archive.number("powder_out_time", self._powder_out_time)
        supervised.barrier_stops = archive.count("barrier_stops", supervised.barrier_stops)
        supervised.refills = archive.count("refills", supervised.refills)
        supervised.finished = bool(archive.count("finished", int(supervised.finished)))
        archive.array("position", self.last_position)
        archive.array("radii", self.radii)

    def refilled(self) -> None:
        """Set the estimated powder to that of a full drum."""
        self.powder = self.plan.powder

    def step(self, orders: tuple[Order, ...] = ()) -> Step:
        """Run one period of the machine and compute the next command."""
        command = self._command
        frame, dt = self._timed(self.machine.step(command))
        self.frame_times = time.perf_counter(), time.thread_time()
        self.powder -= self.plan.flow * command.valve * dt
        estimate = self.estimator.step(frame)
        state = self.supervisor.state
        refused = {order: why for order in orders if (why := self._refusal(order))}
        verdict = supervisor.step(
            self.plan.supervisor,
            self.supervisor,
            frame,
            estimate,
            cause=guard.judge(self.plan.guard, self._guard, frame, self.estimator.tensions),
            standing=not command.winch_speeds.any(),
            target=self.target,
            powder=self.powder,
            orders=[order for order in orders if order not in refused],
        )
        if estimate.valid:
            self.last_position[:], self.radii[:] = estimate.position, estimate.radii
        self._on_transition(state, verdict, command)
        self._obey(verdict.orders, state, estimate)
        if self.plan.height is not None and verdict.state is PrintState.PRINTING:
            self.guide.height_offset = height.step(self.plan.height, self.guide.height_offset, estimate.clearance, dt)
        if self._approach_pending and estimate.valid:
            self.guide.position, self._approach_pending = estimate.position.copy(), False
        target = self._next_target(verdict, dt)
        self.target = None if self._approach_pending else target
        self._command = self._decide(frame, verdict, estimate, target, dt)
        answered = (*verdict.orders, *(replace(order, refusal=why) for order, why in refused.items()))
        return Step(command, frame, estimate, self._progress(verdict, estimate, target), answered)

    def _timed(self, frame: SensorFrame) -> tuple[SensorFrame, float]:
        """The frame, and the time that has elapsed since the last one, s: a period, or more up to a limit.

        A late frame has a notice. One that is not later than the last has another, no readings and the time of one
        period later: whoever judges by times sees silence.
        """
        period, elapsed = self.machine.period, frame.time - self._now
        if not elapsed > 0.0:
            self._now += period
            return SensorFrame(self._now, (), (*frame.notices, Notice(Condition.CLOCK_BACK))), period
        self._now = frame.time
        if abs(elapsed - period) <= _SAME * period:
            return frame, period
        if elapsed > _LATE * period:
            frame = replace(frame, notices=(*frame.notices, Notice(Condition.OVERRUN)))
        return frame, min(elapsed, _MOST * period)

    def _refusal(self, order: Order) -> str:
        """Why an order cannot be obeyed, whatever the state; an empty text: the state decides."""
        if order.kind in (OrderKind.JOG, OrderKind.GO_TO, OrderKind.PARK):
            if not math.isfinite(self.supervisor.valid_since):
                return f"{order.kind}: the position is not known"
            return manual.refusal(self.plan.manual, order)
        if order.kind in _PROCEDURES and _PROCEDURES[order.kind] not in self.plan.procedures:
            return f"{order.kind}: the plan has no procedure for it"
        if order.kind is OrderKind.OVERRIDE:
            share = order.arguments.get("share", ())
            if len(share) != 1 or not 0.0 <= share[0] <= 1.0:
                return f"override: share = {share}: one number from 0 to 1 is expected"
        return ""

    def _on_transition(self, previous: PrintState, verdict: Verdict, command: Command) -> None:
        """Set where the target continues, and how the winches stop, after a change of state."""
        faulted, worse = verdict.state is PrintState.FAULT, verdict.at_once and not (self._ramp and self._ramp.at_once)
        interrupted = previous in _HANDLED and verdict.state is PrintState.IDLE
        if (faulted and (self._ramp is None or worse)) or interrupted:
            at_once = verdict.at_once or self.machine.period >= self.plan.guard.ramp_time
            self._ramp = RampState(self._now, command.winch_speeds, at_once)
        elif verdict.state is not previous:
            self._ramp = None
        if verdict.state is previous:
            return
        if faulted:  # the target stands with the machine
            self.guide.speed_factor, self.guide.speed = 0.0, 0.0
        if verdict.state is PrintState.REFILLING and self.powder > self.plan.supervisor.refill_mass:
            self._powder_out_time = self.guide.path_time  # earlier than estimated: the path will continue from here
        if verdict.state is PrintState.READY:
            if math.isfinite(self._powder_out_time):
                self.guide.path_time, self._powder_out_time = self._powder_out_time, math.inf
            self.guide.position, self.guide.speed_factor, self.guide.speed = None, 0.0, 0.0
            self._approach_pending = True
        if verdict.state in self.plan.procedures:
            self.plan.procedures[verdict.state].begin(self._now)

    def _obey(self, orders: tuple[Order, ...], previous: PrintState, estimate: Estimate) -> None:
        """Take the arguments of the orders that were accepted."""
        for order in orders:
            if order.refusal:
                continue
            if order.kind is OrderKind.OVERRIDE:
                self.speed_share = order.arguments["share"][0]
            elif self.supervisor.state is PrintState.MANUAL and order.kind in _BY_HAND:
                place = estimate.position if previous is not PrintState.MANUAL else None
                manual.begin(self.plan.manual, self._manual, order, self._now, place)

    def _next_target(self, verdict: Verdict, dt: float) -> Target:
        if verdict.state is not PrintState.MANUAL:
            return guide.step(self.plan.path, self.guide, dt, verdict.guide_mode, self.speed_share)
        motion = manual.step(self.plan.manual, self._manual, self._now, dt)
        if motion.done:
            supervisor.end_procedure(self.supervisor, self._now)
        path, distance = self.plan.path, self.plan.path.distance(self.guide.path_time)
        layer = int(path.track.layer[path.track.piece(distance)])
        return Target(motion.position, motion.velocity, distance, layer, 0.0, False, False, False)

    def _decide(self, frame: SensorFrame, verdict: Verdict, estimate: Estimate, target: Target, dt: float) -> Command:
        now, m = frame.time, self.plan.velocity.model.m
        if self._ramp is not None:
            speeds, braked = guard.ramp(self.plan.guard, self._ramp, now)
            return self._standing(now, frozen(speeds), braked and verdict.state is PrintState.FAULT)
        if verdict.state is PrintState.OFF:
            return self._standing(now, frozen(np.zeros(m)), True)
        if verdict.state in self.plan.procedures:
            return self._proceed(now, verdict, frame, estimate, dt)
        if verdict.hold_winches or not estimate.valid:
            return Command(now, frozen(np.zeros(m)))
        speeds = velocity.step(self.plan.velocity, self.velocity, estimate, target, dt)
        opening = target.path_speed / self.plan.path.print_speed if target.extruding and verdict.valve_allowed else 0.0
        return Command(now, frozen(speeds), min(max(opening, 0.0), 1.0))

    def _standing(self, now: float, speeds: Array, braked: bool) -> Command:
        """A command that stops: by *speeds*, then held, then with brakes closed where the machine has the modes."""
        modes = self.machine.abilities.modes
        wanted = WinchMode.VELOCITY if speeds.any() else WinchMode.OFF if braked else WinchMode.HOLD
        return Command(now, speeds, modes=(wanted,) * len(speeds) if wanted in modes else ())

    def _proceed(self, now: float, verdict: Verdict, frame: SensorFrame, estimate: Estimate, dt: float) -> Command:
        """The command of the procedure that runs."""
        done = self.plan.procedures[verdict.state].step(frame, estimate, dt)
        if done.finished or done.failure:
            supervisor.end_procedure(self.supervisor, now, done.failure)
        return Command(now, frozen(done.winch_speeds), modes=done.modes, tensions=done.tensions)

    def _progress(self, verdict: Verdict, estimate: Estimate, target: Target) -> Progress:
        error = math.nan
        if verdict.state is PrintState.PRINTING and estimate.valid:
            error = self.plan.path.track.nearest(estimate.position, target.distance).offset
        return Progress(
            estimate.time, verdict.state, target.layer, target.distance, frozen(target.position), error, verdict.reason
        )


_HANDLED: Final = (PrintState.TENSIONING, PrintState.HOMING, PrintState.MANUAL)
_BY_HAND: Final = (OrderKind.JOG, OrderKind.GO_TO, OrderKind.PARK)
_PROCEDURES: Final = {OrderKind.TAKE_UP: PrintState.TENSIONING, OrderKind.HOME: PrintState.HOMING}


class Operator(Protocol):
    """Whoever gives orders: a person at a page or a terminal, or a simulated attendant."""

    def orders(self, printer: Printer, now: float) -> tuple[Order, ...]:
        """Return the orders since the last call, at *now*, s. Is called once in each step."""

    def is_over(self, printer: Printer) -> bool:
        """Whether the run ends here."""


class StepRecorder(Protocol):
    """Whoever keeps what happens."""

    def add(self, printer: Printer, step: Step, *, last: bool) -> None:
        """Keep one step; *last*: of this run."""


def run(printer: Printer, operator: Operator, recorder: StepRecorder) -> int:
    """Run until the operator ends it; return the number of steps.

    The machine is opened before and closed after, whatever happens; an error on the way stops it first.
    """
    machine = printer.machine
    machine.open()
    try:
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
        machine.stop()
        machine.close()
