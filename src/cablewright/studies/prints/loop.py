"""A print, step by step: machine, estimation, control and supervision put together, and a simulated attendant."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cablewright.control import guide, height, supervisor, velocity
from cablewright.control.guide import GuideState, Target, TimedPath
from cablewright.control.height import HeightControl
from cablewright.control.supervisor import Order, SupervisorSettings, SupervisorState, Verdict
from cablewright.control.velocity import VelocitySettings
from cablewright.machine.interface import Machine
from cablewright.machine.simulated.snapshot import Archive
from cablewright.signals import Command, Estimate, PrintState, Progress, SensorFrame, frozen
from cablewright.studies.estimators import Estimator

__all__ = ["Attendant", "PrintPlan", "Printer", "Step"]

Array = NDArray[np.float64]
MakeEstimator = Callable[[Array, Array], Estimator]


@dataclass(frozen=True, eq=False)
class PrintPlan:
    """What a printer is to do and how. ``height``: None keeps the path's own heights.

    ``flow``: kg/s of powder with the valve open, ``powder``: kg in a full drum; infinite where nothing runs out.
    """

    path: TimedPath
    velocity: VelocitySettings
    supervisor: SupervisorSettings
    height: HeightControl | None = None
    flow: float = 0.0
    powder: float = math.inf


@dataclass(frozen=True, eq=False)
class Step:
    """What happened in one step: the command it began with, and what came of it."""

    command: Command
    frame: SensorFrame
    estimate: Estimate
    progress: Progress


class Printer:
    """Drives one machine through one plan. `step` never raises for what a machine tells."""

    def __init__(
        self,
        plan: PrintPlan,
        machine: Machine,
        make: MakeEstimator,
        *,
        now: float = 0.0,
        archive: Archive | None = None,
    ) -> None:
        """Begin idle, winches held, at the path's beginning or where *book* has it; *now* is the machine's time, s.

        *make* is asked for an estimator that begins where the platform is, (3,) m, with what is known of the winch
        drums' radii, (m,) m, 0 where nothing is.
        """
        self.plan, self.machine = plan, machine
        self.guide, self.supervisor = GuideState(), SupervisorState()
        self.velocity = velocity.start(plan.velocity)
        self.powder = plan.powder
        """kg in the drum, as believed."""
        self.target: Target | None = None
        self.last_position = plan.path.track.at(0.0).position.copy()
        """(3,) m, where the platform was when that was known last."""
        self.radii = np.zeros(plan.velocity.model.m)
        """(m,) m of the winch drums, as found out last; 0: never."""
        self.frame_times = (0.0, 0.0)
        """When the last frame had come, s: by the wall clock and by the processor's."""
        self._command = Command(now, frozen(np.zeros(plan.velocity.model.m)))
        self._approach_pending = True  # the way back to the path begins where the platform is, once that is known
        self._powder_out_clock = math.inf  # s of the law's time where powder ran out
        if archive is not None:
            self.archive_state(archive)
        self.estimator = make(self.last_position, self.radii)

    @property
    def finished(self) -> bool:
        """Whether the path has been gone to its end."""
        return self.supervisor.finished

    def archive_state(self, archive: Archive) -> None:
        """Note how far the print has come, or take that up again."""
        guided, watched = self.guide, self.supervisor
        guided.clock, guided.lift = archive.number("clock", guided.clock), archive.number("lift", guided.lift)
        self.powder, self._powder_out_clock = (
            archive.number("powder", self.powder),
            archive.number("mark", self._powder_out_clock),
        )
        watched.barrier_stops, watched.refills = (
            archive.count("stops", watched.barrier_stops),
            archive.count("refills", watched.refills),
        )
        watched.finished = bool(archive.count("finished", int(watched.finished)))
        archive.array("place", self.last_position)
        archive.array("radii", self.radii)

    def refilled(self) -> None:
        """Note that the drum is full again."""
        self.powder = self.plan.powder

    def step(self, orders: tuple[Order, ...] = ()) -> Step:
        """Live through one period of the machine, and decide on the next."""
        command, dt = self._command, self.machine.period
        frame = self.machine.step(command)
        self.frame_times = time.perf_counter(), time.thread_time()
        self.powder -= self.plan.flow * command.valve * dt
        estimate = self.estimator.step(frame)
        was = self.supervisor.state
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
        self._change(was, verdict)
        if self.plan.height is not None and verdict.state is PrintState.PRINTING:
            self.guide.lift = height.step(self.plan.height, self.guide.lift, estimate.clearance, dt)
        if self._approach_pending and estimate.valid:
            self.guide.place, self._approach_pending = estimate.position.copy(), False
        target = guide.step(self.plan.path, self.guide, dt, verdict.wish)
        self.target = None if self._approach_pending else target
        self._command = self._decide(frame.time, verdict, estimate, target, dt)
        return Step(command, frame, estimate, self._progress(verdict, estimate, target))

    def _change(self, was: PrintState, verdict: Verdict) -> None:
        """What a new state means for where the target goes on."""
        if verdict.state is was:
            return
        if verdict.state is PrintState.REFILLING and self.powder > self.plan.supervisor.refill_mass:
            self._powder_out_clock = self.guide.clock  # it ran out before it should have: the path goes on here
        if verdict.state is PrintState.READY:
            if math.isfinite(self._powder_out_clock):
                self.guide.clock, self._powder_out_clock = self._powder_out_clock, math.inf
            self.guide.place, self.guide.pace, self.guide.speed = None, 0.0, 0.0
            self._approach_pending = True

    def _decide(self, now: float, verdict: Verdict, estimate: Estimate, target: Target, dt: float) -> Command:
        m = self.plan.velocity.model.m
        if verdict.hold_winches or not estimate.valid:
            return Command(now, frozen(np.zeros(m)))
        speeds = velocity.step(self.plan.velocity, self.velocity, estimate, target, dt)
        open_ = target.pace / self.plan.path.print_speed if target.laying and verdict.valve_allowed else 0.0
        return Command(now, frozen(speeds), min(max(open_, 0.0), 1.0))

    def _progress(self, verdict: Verdict, estimate: Estimate, target: Target) -> Progress:
        error = math.nan
        if verdict.state is PrintState.PRINTING and estimate.valid:
            error = self.plan.path.track.nearest(estimate.position, target.distance).offset
        return Progress(
            estimate.time, verdict.state, target.layer, target.distance, frozen(target.position), error, verdict.reason
        )


@dataclass
class Attendant:
    """Who stands by a simulated machine: starts it, refills it, and lets it go on once everybody is out of its way.

    ``after``: s from a stop to the order to go on, ``refill``: s that a refill takes, done by *fill*.
    """

    refill_drum: Callable[[], None]
    resume_delay: float = 5.0
    refill_time: float = 60.0
    _since: float = field(default=math.nan, repr=False)
    _state: PrintState = field(default=PrintState.READY, repr=False)

    def orders(self, printer: Printer, now: float) -> tuple[Order, ...]:
        """What is ordered at *now*, s."""
        state = printer.supervisor.state
        if state is not self._state:
            self._since, self._state = now, state
        if state is PrintState.IDLE and not printer.finished:
            return (Order.START,)
        if state is PrintState.PAUSED:
            if printer.supervisor.barrier_broken:
                self._since = now
            return (Order.RESUME,) if now - self._since >= self.resume_delay else ()
        if (
            state is PrintState.REFILLING
            and now - self._since >= self.refill_time
            and not printer.supervisor.resume_ordered
        ):
            self.refill_drum()
            printer.refilled()
            return (Order.REFILLED,)
        return ()
