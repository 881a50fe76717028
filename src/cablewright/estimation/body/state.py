"""State of the estimator of a rigid platform."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array, Mask
from cablewright.errors import Status
from cablewright.estimation.body.creep import BodyCreep, LoadPath, creep_of
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.unknowns import BodyLayout, prior
from cablewright.estimation.body.updates.update import Update
from cablewright.estimation.fault_monitor import FaultMonitor
from cablewright.kernels.layout import Packed
from cablewright.models.packed_views import LineNumbers, PlatformNumbers
from cablewright.models.statics import Model
from cablewright.solvers.continuation import Tracker, TrackerSettings
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import Taut, mount_share, stretches, taut_of_body


@dataclass(eq=False)
class Window:
    """Readings less what was predicted of them, since the last measurement."""

    begin: float = math.nan  # s
    readings: dict[Update, list[Array]] = field(default_factory=dict)  # (k,) each
    velocity: Array | None = None  # (3,) m/s, at its begin


@dataclass(eq=False)
class Contradiction:
    """Innovations of measurements that contradict the statics, from which the line that is to blame is named."""

    begin: float  # s
    frames: int = 0  # since then
    total: Array = field(default_factory=lambda: np.zeros(0))  # (k,) sum of the innovations
    rows: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))  # (k,) that they are of
    count: int = 0

    def add(self, innovation: Array, rows: NDArray[np.int64]) -> None:
        """Add a measurement; one of other readings than the last begins anew."""
        if not np.array_equal(rows, self.rows):
            self.total, self.rows, self.count = np.zeros(len(rows)), rows, 0
        self.total, self.count = self.total + innovation, self.count + 1

    @property
    def mean(self) -> Array:
        """Mean innovation (k,)."""
        return self.total / self.count


@dataclass(eq=False)
class BodyState:
    """Changed in place by `step`. Windows and doubts begin anew where state is loaded."""

    SAVED = (
        "unknowns",
        "covariance",
        "home_lengths",
        "home_angles",
        "home_toward",
        "home_counts",
        "homed",
        "creep",
        "load_path",
        "gradients",
        "cells_used",
        "paid",
        "angles",
        "lengths",
        "measured_at",
        "retraction",
        "pose_covariance",
        "tracker.pose",
        "tracker.states",
    )

    layout: BodyLayout
    tracker: Tracker
    unknowns: Array  # (size,)
    covariance: Array  # (size, size)
    home_lengths: Array  # (m,) m
    home_angles: Array  # (m,) rad, wound on each drum at home
    home_toward: Array  # (m, 3)
    taut: Taut
    monitor: FaultMonitor
    creep: BodyCreep
    load_path: LoadPath
    gradients: Array  # (m, size) of the lengths by the unknowns
    home_counts: NDArray[np.int64]  # (m,)
    cells_used: Mask  # (m,)
    paid: Array  # (m,) m since home, by the encoders
    angles: Array  # (m,) rad, wound
    lengths: Array  # (m,) m, corrected
    measured_at: Array  # (m,) m paid out at the last measurement
    velocity: Array = field(default_factory=lambda: np.zeros(6))  # m/s and rad/s
    homed: bool = False  # whether the home counts are known
    last_counts: tuple[float, NDArray[np.int64]] | None = None  # s, and the counts of then
    pending: NDArray[np.int64] | None = None  # (m,) counts that jumped, not yet believed
    time: float = -math.inf
    retraction: float = math.nan  # m
    window: Window = field(default_factory=Window)
    untold: Array = field(default_factory=lambda: np.zeros((0, 0)))  # covariance of `layout.laws` before a measurement
    pose_covariance: Array = field(default_factory=lambda: np.zeros((6, 6)))
    consistency: dict[str, float] = field(default_factory=dict)
    silent: Mask = field(default_factory=lambda: np.zeros(1, dtype=bool))  # (m,) or (1,) cells without a reading
    specific_force: Array | None = None  # (3,) m/s^2, platform: its mean of late
    shaken_at: float = math.nan  # s
    shaking: float = 0.0  # m^2/s^4: mean square of the force's change about that
    doubts: int = 0  # measurements in a row that contradict the statics
    danger: str = ""  # why the machine is to stop
    search: Contradiction | None = None  # for the line that is to blame

    @property
    def pose(self) -> Array:
        """The pose (6,), m and rad."""
        return self.tracker.pose

    @property
    def tensions(self) -> Array:
        """Tensions (m,), N, at the sheaves."""
        return self.tracker.tensions


def start(settings: BodySettings, pose: Array, retraction: float = math.nan, lengths: Array | None = None) -> BodyState:
    """Return the state with the platform at *pose* (6,), homed there with a *retraction*, m (NaN: the robot's).

    *lengths* (m,), m: at which an estimate had left it; None: those that hold it. Raises `AnswerError`.
    """
    model = settings.model if math.isnan(retraction) else Model(settings.model.robot.retracted(retraction))
    if lengths is None:
        lengths = solve_inverse(model, pose).checked().lengths
    tracker = _tracker_near(model, lengths, pose)
    layout = BodyLayout(model.m, settings.sensors)
    wound = [
        coil.angle(settings.total_length - out) for coil, out in zip(settings.coils, lengths.tolist(), strict=True)
    ]
    taut = taut_of_body(model.packed.lines, tracker.pose)
    covariance = prior(settings, layout)
    return BodyState(
        layout,
        tracker,
        np.zeros(layout.size),
        covariance,
        lengths.copy(),
        np.array(wound),
        taut.toward,
        taut,
        FaultMonitor(dict(settings.timeouts)),
        creep_of(model.robot, tracker.tensions, settings.deviations.creep),
        LoadPath(tracker.tensions),
        np.eye(model.m, layout.size),
        np.zeros(model.m, dtype=np.int64),
        np.ones(model.m, dtype=bool),
        np.zeros(model.m),
        np.array(wound),
        lengths.copy(),
        np.zeros(model.m),
        untold=covariance[layout.laws, layout.laws].copy(),
        retraction=retraction if not math.isnan(retraction) else _own_retraction(model),
    )


def resumed(settings: BodySettings, state: BodyState) -> None:
    """Let a *state* go on with what was loaded."""
    crept, home, places = state.creep.memories, state.load_path.home, state.load_path.places
    state.load_path, state.creep = LoadPath(home), creep_of(settings.model.robot, home, settings.deviations.creep)
    state.load_path.places = places
    for memory, loaded in zip(state.creep.memories, crept, strict=True):
        memory.stretched = loaded.stretched
    set_load(state, settings.model)
    state.tracker.restart(state.lengths)


def _own_retraction(model: Model) -> float:
    own = model.robot.retraction
    return math.nan if own is None else own.length


def _tracker_near(model: Model, lengths: Array, pose: Array) -> Tracker:
    """Return the tracker at the equilibrium of *lengths* near *pose*, where a body could hang in several."""
    near = solve_forward(model, lengths, guess=pose).checked()
    return Tracker(model, lengths, TrackerSettings(certify=False), begin=near)


def corrected(state: BodyState) -> Array:
    """Return the lengths (m,), m, by the encoders, creep as described, and what is known of the unknowns."""
    counted, of_lengths, described = state.home_lengths + state.paid, state.layout.softness.start, state.creep.described
    if described is not None:
        counted = counted * (1.0 + described.strain)
    stretched_at_home = state.unknowns[state.layout.softness] * state.load_path.home / state.load_path.mean
    return np.asarray(
        counted * (1.0 - stretched_at_home) + state.gradients[:, :of_lengths] @ state.unknowns[:of_lengths]
    )


def follow(state: BodyState) -> bool:
    """Let the platform follow the corrected lengths; whether an equilibrium was found."""
    status = state.tracker.step(state.lengths)
    if status is Status.OK or state.tracker.restart(state.lengths):
        state.monitor.clear("encoders", "lost")
        state.taut = taut_of_body(state.tracker.packed.lines, state.pose)
        return True
    state.monitor.report("encoders", "lost", f"the equilibrium could not be followed: {status.value}")
    return False


def set_load(state: BodyState, model: Model) -> None:
    """Give the tracker the model's numbers at the present retraction, the estimated load, and how soft lines are.

    A line is at least half as soft as it is described.
    """
    packed: Packed = model.packed
    retraction = None if math.isnan(state.retraction) else np.array([state.retraction])
    rows = model.rows(retraction=retraction)
    platform = PlatformNumbers(packed.platform.copy())
    platform.wrench = platform.wrench + state.unknowns[state.layout.load]
    lines = LineNumbers(rows.lines[0].copy())
    softer = state.unknowns[state.layout.softness] * state.lengths / state.load_path.mean
    softer = softer + mount_share(lines, state.taut) * state.unknowns[state.layout.mount]
    lines.spring = lines.spring + np.maximum(softer, -0.5 * stretches(lines, state.taut))
    state.tracker.change(packed._replace(lines=lines.array, platform=platform.array))
