"""The state by the encoders alone: lengths paid out since a known position, and their equilibrium.

Most printers do so; it is the baseline for the other estimators. It assumes that cable is wound regularly, and that it
creeps as the robot's file says, from the beginning on. Load cells help where a place is measured, and only there. Where
lengths are learnt, each place improves the estimate of them (`length_corrections`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.body.updates.cells import Cells
from cablewright.estimation.climate import FeltAir
from cablewright.estimation.fault_monitor import FaultMonitor
from cablewright.estimation.length_corrections import LearntLengths, LengthPriors, MeasuredPlace
from cablewright.estimation.measured_tensions import smoothed
from cablewright.estimation.reading_checks import accepted
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError, Status
from cablewright.foundation.signals import Climate, Encoders, Estimate, SensorFrame, Tensions
from cablewright.kernels import Direct
from cablewright.kernels.filtering import reckoning as kernel
from cablewright.models.coil import Coil, LineCoils
from cablewright.models.creep import CreepMemory, memory_of
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.support_table import Capability, require
from cablewright.models.winch_lines import WinchLines
from cablewright.solvers.continuation import Tracker, TrackerSettings
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise, tension_changes
from cablewright.solvers.taut import Taut, taut_at

_PLACINGS: Final = 3  # Newton steps to the lengths of a known place: centimetres are left as nanometres
_UNWIND: Final = Direct(kernel.unwind)
_UNEVEN: Final = 2e-3  # standard deviation of length errors by load cells, as a share: more than cables creep


@dataclass(frozen=True, eq=False)
class ReckoningSettings:
    """Settings of dead reckoning: the machine as described.

    ``counts_per_radian``: encoder counts for a radian of a winch drum. ``coils``: each line's cable on its drum, wound
    regularly; None: it has no winch. ``total_length``: length of a winch's cable, wound and paid out, m.
    ``slack_threshold``: excess of length from which a line counts as slack, m. ``smoothing_time``: time over which
    velocity and tensions are smoothed, s. ``timeout``: time without counts after which there is a fault, s. ``cells``:
    load cells or torques, which help to learn lengths where a place is measured. ``priors``: priors of the quantities
    to estimate at measured positions; None: each measured position corrects the lengths by itself.
    """

    model: Model
    counts_per_radian: float
    coils: tuple[Coil | None, ...]
    total_length: float
    slack_threshold: float = 2.5e-3
    smoothing_time: float = 0.2
    timeout: float = 0.5
    cells: Cells | None = None
    priors: LengthPriors | None = None

    def __post_init__(self) -> None:
        """Reject platforms with a rotation, and another number of coils than lines."""
        if self.model.n != 3 or len(self.coils) != self.model.m:
            raise InputError(f"robot {self.model.robot.name!r}: a point platform and a coil for each line are expected")
        require(self.model, Capability.ESTIMATION)

    @cached_property
    def drums(self) -> LineCoils:
        """The coils of the lines' cables on their winch drums."""
        return LineCoils(self.coils, self.total_length)

    @cached_property
    def winches(self) -> WinchLines:
        """The winches, whose encoders are read."""
        return WinchLines.of(self.model.robot)


@dataclass(eq=False)
class ReckoningState:
    """State of dead reckoning, changed in place by `step`."""

    SAVED = ("creep", "learnt")

    tracker: Tracker
    start_lengths: Array  # (m,) m
    start_angles: Array  # (m,) rad, wound on each drum at the start
    monitor: FaultMonitor
    start_counts: NDArray[np.int64] | None = None  # (w,)
    creep: CreepMemory | None = None  # of cables that creep as described
    start_strain: Array | float = 0.0  # (m,) by creep, at the start lengths
    air: FeltAir = field(default_factory=FeltAir)
    rotation: Array = field(default_factory=lambda: np.zeros(1))  # (m,) rad, paid out since the start
    lengths: Array | None = None
    velocity: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m/s, smoothed
    measured: Array | None = None  # (m,) tensions, N, smoothed; NaN: not read
    learnt: LearntLengths | None = None
    time: float = -math.inf
    tell: Direct = field(default_factory=lambda: Direct(kernel.tell))

    @property
    def taut(self) -> Taut:
        """The lines, as if straight, at the estimated position."""
        return taut_at(self.tracker.model, self.tracker.pose)


def start(settings: ReckoningSettings, place: Array) -> ReckoningState:
    """Return the state with the platform at *place* (3,), m, all lines taut.

    Raises `AnswerError` if it cannot be there.
    """
    held = solve_inverse(settings.model, place).checked()
    creep = memory_of([line.cable.creep for line in settings.model.robot.lines])
    state = _begin(settings, held.lengths, None, creep)
    if settings.priors is not None:
        state.learnt = LearntLengths.of(settings.priors, settings.model, held.tensions)
        state.learnt.counted = held.lengths.copy()
    return state


def start_at(settings: ReckoningSettings, lengths: Array, counts: NDArray[np.int64]) -> ReckoningState:
    """Return the state with known *lengths* (m,), m, paid out at *counts* (w,). Raises `AnswerError`.

    Earlier creep of the cables is not known, so that none of it counts.
    """
    return _begin(settings, lengths, np.array(counts, dtype=np.int64), None)


def _begin(
    settings: ReckoningSettings, lengths: Array, counts: NDArray[np.int64] | None, creep: CreepMemory | None
) -> ReckoningState:
    tracker = Tracker(settings.model, lengths, TrackerSettings(certify=False))
    monitor = FaultMonitor({"encoders": settings.timeout})
    state = ReckoningState(tracker, lengths.copy(), settings.drums.angles(lengths), monitor, counts, creep)
    state.rotation = np.zeros(len(lengths))
    return state


def placed(
    settings: ReckoningSettings, state: ReckoningState, place: Array, *, by_tensions: bool = False
) -> ReckoningState:
    """Return the state corrected for a platform that is known to be at *place* (3,), m, where it stands.

    Of all changes of the lengths that bring it there the smallest is taken, in proportion to each line's length: creep
    and the error of an oversized drum are a share of it. *by_tensions*: with more taut lines than degrees of freedom,
    choose the changes that do not move the platform so that they fit the measured tensions best. Raises `AnswerError`
    where there is no equilibrium in between.
    """
    lengths = counted(state)
    share, pose = lengths**2, state.tracker.pose
    for _ in range(_PLACINGS):
        held = solve_forward(settings.model, lengths, guess=pose).checked()
        per_length, pose = linearise(held).per_length, held.pose
        weighted = share[:, None] * per_length.T
        change = weighted @ np.linalg.solve(per_length @ weighted, place - pose)
        lengths = lengths + change
        if by_tensions and state.measured is not None:
            lengths = lengths + _tightened(settings, state.measured, held, per_length, change)
    known = start_at(settings, lengths, _counts(settings, state))
    known.time, known.velocity, known.monitor = state.time, np.zeros(3), state.monitor
    known.measured, known.air = state.measured, state.air
    if state.creep is not None:
        known.creep, known.start_strain = state.creep, state.creep.strain
    return known


def taught(settings: ReckoningSettings, state: ReckoningState, place: Array) -> None:
    """Learn length corrections from the platform's known position *place* (3,), m; *state* changes in place.

    Raises `AnswerError` before the first counts, where nothing can be learnt, and where there is no equilibrium.
    """
    if state.start_counts is None or state.lengths is None:
        raise AnswerError("dead reckoning has read no encoder yet")
    if state.learnt is None:
        raise AnswerError("dead reckoning has no priors of lengths, from which places teach more")
    remembered, rotation = state.learnt.remembered, state.rotation.copy()
    measured = MeasuredPlace(state.lengths.copy(), place.copy(), remembered, rotation, state.time)
    there = state.learnt.told(settings.model, measured)
    state.tracker.change(state.learnt.packed(settings.model))
    if not state.tracker.restart(there.lengths):
        raise AnswerError("dead reckoning finds no equilibrium with the estimated corrections")
    state.velocity = np.zeros(3)


def counted(state: ReckoningState) -> Array:
    """Return the lengths (m,), m, by counts and the file's creep, without learnt corrections."""
    return state.start_lengths if state.lengths is None else state.lengths


def resumed(settings: ReckoningSettings, state: ReckoningState) -> None:
    """Give a new *state* the creep and the learnt length corrections of a loaded one.

    Raises `AnswerError` where there is no equilibrium.
    """
    if state.creep is not None:
        state.start_strain = state.creep.strain
    if state.learnt is None:
        return
    lengths = state.learnt.counted.copy()
    state.start_lengths, state.start_angles = lengths, settings.drums.angles(lengths)
    state.tracker.change(state.learnt.packed(settings.model))
    if not state.tracker.restart(lengths + state.learnt.longer(lengths)):
        raise AnswerError("dead reckoning finds no equilibrium with the estimated corrections")


def _tightened(
    settings: ReckoningSettings, measured: Array, held: Equilibrium, per_length: Array, change: Array
) -> Array:
    """Return lengths (m,), m, to add to a *change* (m,), which leave the platform in place and fit tensions best.

    *measured* (m,), N, against those of *held*, whose motion is *per_length* (3, m). Zeros where no more lines are taut
    than hold the platform: its tension does not show how slack a line is.
    """
    cells, added = settings.cells, np.zeros(len(change))
    taut = held.lengths - taut_at(settings.model, held.pose).lengths <= settings.slack_threshold
    if cells is None or taut.sum() <= len(per_length):
        return added
    free = np.zeros((len(change), int(taut.sum()) - len(per_length)))
    free[taut] = np.linalg.svd(per_length[:, taut])[2][len(per_length) :].T
    shown = held.winch_tensions if cells.source == "motor_torques" else held.tensions
    off = np.hypot(np.hypot(cells.deviation, cells.zero), cells.gain * shown)
    changes = tension_changes(held[None])
    by_length = np.diag(changes.per_length[0]) + changes.by_pose[0] @ per_length
    read = np.isfinite(measured) & taut
    rows = [(by_length @ free / off[:, None])[read], free / (_UNEVEN * held.lengths)[:, None]]
    wanted = [((measured - shown - by_length @ change) / off)[read], added]
    return np.asarray(free @ np.linalg.lstsq(np.vstack(rows), np.concatenate(wanted), rcond=None)[0])


def _counts(settings: ReckoningSettings, state: ReckoningState) -> NDArray[np.int64]:
    """The counts (w,) of the last reading. Raises `AnswerError` before the first."""
    if state.start_counts is None:
        raise AnswerError("dead reckoning has read no encoder yet")
    rotation = state.rotation[settings.winches.hosts]
    return state.start_counts + np.rint(rotation * settings.counts_per_radian).astype(np.int64)


def step(settings: ReckoningSettings, state: ReckoningState, frame: SensorFrame) -> Estimate:
    """Return the estimate after one frame; *state* changes in place. No frame raises an error."""
    dt = float(frame.time - state.time)
    if not dt > 0.0:
        state.monitor.restart(frame.time, f"the clock jumped from {state.time:g} to {frame.time:g} s")
        dt = math.inf
    state.time = frame.time
    memories = [state.creep] if state.creep is not None else []
    memories += [state.learnt.memory] if state.learnt is not None else []
    before, loads = state.tracker.pose, state.tracker.tensions
    for climate in accepted(state.monitor, frame.of(Climate), frame.time):
        state.air.read(climate, *memories)
    for reading in accepted(state.monitor, frame.of(Encoders), frame.time):
        _update_lengths(settings, state, reading)
    _read_tensions(settings, state, frame, dt)
    paid = counted(state)
    if state.learnt is not None:
        state.learnt.counted, state.learnt.rotation = paid, state.rotation
        paid = paid + state.learnt.longer(paid)
    status = state.tracker.step(paid)
    for memory in memories if math.isfinite(dt) else ():
        memory.advance(loads, state.tracker.tensions, dt)
    if status is Status.OK:
        state.monitor.clear("encoders", "lost")
    else:
        state.monitor.report("encoders", "lost", f"the equilibrium could not be followed: {status.value}")
    state.monitor.check_timeouts(frame.time)
    return _estimate(settings, state, paid, status, before, dt)


def _read_tensions(settings: ReckoningSettings, state: ReckoningState, frame: SensorFrame, dt: float) -> None:
    """Smooth the tensions that a frame brings; what is not read stays as it was."""
    if settings.cells is not None:
        readings = accepted(state.monitor, frame.of(Tensions), frame.time)
        share = min(1.0, dt / settings.smoothing_time)
        state.measured = smoothed(state.measured, readings, settings.cells.source, share, settings.model.m)


def _update_lengths(settings: ReckoningSettings, state: ReckoningState, reading: Encoders) -> None:
    wrong = len(reading.counts) != len(settings.winches.hosts)
    state.monitor.set("encoders", "lines", f"a reading of {len(reading.counts)} winches: not used", active=wrong)
    if wrong:
        return
    if state.start_counts is None:
        state.start_counts = np.array(reading.counts, dtype=np.int64)
    winches, tables = settings.winches, settings.drums.tables
    paid, rotation = np.empty(len(state.start_angles)), np.empty(len(state.start_angles))
    counts = np.array(reading.counts, dtype=np.int64)
    holds = _UNWIND.call(
        counts, state.start_counts, winches.winch, winches.sense, settings.counts_per_radian, state.start_angles,
        *tables, rotation, paid,
    )  # fmt: skip
    if not holds:
        state.monitor.report("encoders", "jump", "the counts exceed the turns of a winch drum: not used")
        return
    state.monitor.clear("encoders", "jump")
    state.rotation = rotation
    out = state.start_lengths + paid
    state.lengths = out if state.creep is None else out * (1.0 + state.creep.strain - state.start_strain)


def _estimate(
    settings: ReckoningSettings, state: ReckoningState, paid: Array, status: Status, before: Array, dt: float
) -> Estimate:
    """Return the estimate. *paid* (m,): lengths paid out, m; *before* (3,): the position *dt* seconds earlier, m."""
    m, radii_by_turns, turns = len(paid), settings.drums.tables[0], settings.drums.tables[2]
    if not math.isfinite(dt):
        state.velocity[:] = 0.0
    if settings.model.robot.hung:
        paid = state.tracker.solved.lengths[0].copy()
    found = np.empty(kernel.OF_LINES + 3 * m)
    state.tell.call(
        settings.model.packed, state.tracker.pose, before,
        min(1.0, dt / settings.smoothing_time) if math.isfinite(dt) else 0.0, dt,
        state.velocity, paid, state.start_angles, state.rotation, radii_by_turns, turns, found,
    )  # fmt: skip
    excess = found[kernel.OF_LINES + m : kernel.OF_LINES + 2 * m]
    if state.learnt is not None:  # as those have it who know the file alone: at the same tensions
        excess += state.learnt.given(state.tracker.solved)
    found.flags.writeable = False
    return Estimate(
        state.time,
        found[: kernel.SPEED],
        found[kernel.SPEED : kernel.ROTATION],
        found[kernel.ROTATION : kernel.OF_LINES],
        found[kernel.OF_LINES : kernel.OF_LINES + m],
        found[kernel.OF_LINES + m : kernel.OF_LINES + 2 * m],
        excess > settings.slack_threshold,
        found[kernel.OF_LINES + 2 * m :],
        faults=state.monitor.faults,
        valid=status is Status.OK and state.start_counts is not None,
    )
