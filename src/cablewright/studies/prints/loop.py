"""The control loop of a print: machine, estimation, control and supervision, and a simulated attendant."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from cablewright.arrays import Array
from cablewright.control import guide, height, supervisor, velocity
from cablewright.control.guide import GuideState, Target, TimedPath
from cablewright.control.height import HeightControl
from cablewright.control.supervisor import Order, SupervisorSettings, SupervisorState, Verdict
from cablewright.control.velocity import VelocitySettings
from cablewright.machine.interface import Machine
from cablewright.machine.simulated.snapshot import Archive
from cablewright.signals import Command, Estimate, PrintState, Progress, SensorFrame, frozen
from cablewright.studies.estimators import Estimator

MakeEstimator = Callable[[Array, Array], Estimator]
"""Makes an estimator from the platform's last position (3,), m, and the winch drums' radii (m,), m; 0: unknown."""


@dataclass(frozen=True, eq=False)
class PrintPlan:
    """Path and settings of a print."""

    path: TimedPath
    velocity: VelocitySettings
    supervisor: SupervisorSettings
    height: HeightControl | None = None  # None: the heights of the path
    flow: float = 0.0  # kg/s of powder with the valve open
    powder: float = math.inf  # kg in a full drum


@dataclass(frozen=True, eq=False)
class Step:
    """One step: its command, the sensor frame at its end, and the estimate and progress from that frame."""

    command: Command
    frame: SensorFrame
    estimate: Estimate
    progress: Progress


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
        """Start idle with winches held, at the start of the path or as in *archive*; *now*: machine time, s."""
        self.plan, self.machine = plan, machine
        self.guide, self.supervisor = GuideState(), SupervisorState()
        self.velocity = velocity.start(plan.velocity)
        self.powder = plan.powder  # kg in the drum, estimated
        self.target: Target | None = None
        self.last_position = plan.path.track.at(0.0).position.copy()  # (3,) m, last valid one of the platform
        self.radii = np.zeros(plan.velocity.model.m)  # (m,) m, last estimated, of the winch drums; 0: unknown
        self.frame_times = (0.0, 0.0)  # s, arrival of the last frame: wall clock and processor time
        self._command = Command(now, frozen(np.zeros(plan.velocity.model.m)))
        self._approach_pending = True  # the approach begins at the platform's position, once that is valid
        self._powder_out_time = math.inf  # s of the path's time law, at which the powder ran out
        if archive is not None:
            self.archive_state(archive)
        self.estimator = make(self.last_position, self.radii)

    @property
    def finished(self) -> bool:
        """Whether the end of the path has been reached."""
        return self.supervisor.finished

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
        command, dt = self._command, self.machine.period
        frame = self.machine.step(command)
        self.frame_times = time.perf_counter(), time.thread_time()
        self.powder -= self.plan.flow * command.valve * dt
        estimate = self.estimator.step(frame)
        state = self.supervisor.state
        verdict = supervisor.step(
            self.plan.supervisor,
            self.supervisor,
            frame,
            estimate,
            target=self.target,
            tensions=self.estimator.tensions,
            powder=self.powder,
            orders=orders,
        )
        if estimate.valid:
            self.last_position[:], self.radii[:] = estimate.position, estimate.radii
        self._on_transition(state, verdict)
        if self.plan.height is not None and verdict.state is PrintState.PRINTING:
            self.guide.height_offset = height.step(self.plan.height, self.guide.height_offset, estimate.clearance, dt)
        if self._approach_pending and estimate.valid:
            self.guide.position, self._approach_pending = estimate.position.copy(), False
        target = guide.step(self.plan.path, self.guide, dt, verdict.guide_mode)
        self.target = None if self._approach_pending else target
        self._command = self._decide(frame.time, verdict, estimate, target, dt)
        return Step(command, frame, estimate, self._progress(verdict, estimate, target))

    def _on_transition(self, previous: PrintState, verdict: Verdict) -> None:
        """Set where the target continues after a change of state."""
        if verdict.state is previous:
            return
        if verdict.state is PrintState.REFILLING and self.powder > self.plan.supervisor.refill_mass:
            self._powder_out_time = self.guide.path_time  # earlier than estimated: the path will continue from here
        if verdict.state is PrintState.READY:
            if math.isfinite(self._powder_out_time):
                self.guide.path_time, self._powder_out_time = self._powder_out_time, math.inf
            self.guide.position, self.guide.speed_factor, self.guide.speed = None, 0.0, 0.0
            self._approach_pending = True

    def _decide(self, now: float, verdict: Verdict, estimate: Estimate, target: Target, dt: float) -> Command:
        m = self.plan.velocity.model.m
        if verdict.hold_winches or not estimate.valid:
            return Command(now, frozen(np.zeros(m)))
        speeds = velocity.step(self.plan.velocity, self.velocity, estimate, target, dt)
        opening = target.path_speed / self.plan.path.print_speed if target.extruding and verdict.valve_allowed else 0.0
        return Command(now, frozen(speeds), min(max(opening, 0.0), 1.0))

    def _progress(self, verdict: Verdict, estimate: Estimate, target: Target) -> Progress:
        error = math.nan
        if verdict.state is PrintState.PRINTING and estimate.valid:
            error = self.plan.path.track.nearest(estimate.position, target.distance).offset
        return Progress(
            estimate.time, verdict.state, target.layer, target.distance, frozen(target.position), error, verdict.reason
        )


@dataclass
class Attendant:
    """Operator of a simulated machine: starts it, refills it, and resumes once the light barrier is clear."""

    refill_drum: Callable[[], None]
    resume_delay: float = 5.0  # s from a stop, or from the light barrier being clear, to the order to resume
    refill_time: float = 60.0  # s that a refill takes
    _since: float = field(default=math.nan, repr=False)
    _state: PrintState = field(default=PrintState.READY, repr=False)

    def orders(self, printer: Printer, now: float) -> tuple[Order, ...]:
        """Return the orders at *now*, s."""
        state = printer.supervisor.state
        if state is not self._state:
            self._since, self._state = now, state
        if state is PrintState.IDLE and not printer.finished:
            return (Order.START,)
        if state is PrintState.PAUSED:
            if printer.supervisor.barrier_broken:
                self._since = now
            return (Order.RESUME,) if now - self._since >= self.resume_delay else ()
        due = state is PrintState.REFILLING and now - self._since >= self.refill_time
        if due and not printer.supervisor.resume_ordered:
            self.refill_drum()
            printer.refilled()
            return (Order.REFILLED,)
        return ()
