"""State of the estimator of a rigid platform."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.body.creep import BodyCreep, LoadPath, creep_of
from cablewright.estimation.body.estimated_constants import BodyLayout, prior
from cablewright.estimation.body.law_sizes import AveragedAt, LawSize, law_sizes
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.updates.update import DrumPulls, Update
from cablewright.estimation.clock_offset import ClockLead
from cablewright.estimation.fault_monitor import FaultMonitor
from cablewright.estimation.time_buffer import TimeBuffer
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import Status
from cablewright.kernels.layout import Packed
from cablewright.models.free_coordinates import with_free
from cablewright.models.packed_views import LineNumbers, PlatformNumbers
from cablewright.models.statics import Model
from cablewright.solvers.continuation import Tracker, TrackerSettings
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import Taut, mount_share, stretches, taut_of

_POSES: Final = 500  # 5 s at 10 ms


@dataclass(eq=False)
class Window:
    """Sum of readings less their predictions, since the last measurement."""

    begin: float = math.nan  # s
    readings: dict[Update, list[Array]] = field(default_factory=dict)  # (k,) each
    seen: list[Array] = field(default_factory=list)  # (6, 6) noise of the poses by a camera
    velocity: Array | None = None  # (3,) m/s, at its begin


@dataclass(eq=False)
class Contradiction:
    """Innovations of measurements that contradict the statics, from which the faulty line is named."""

    begin: float  # s
    frames: int = 0  # since then
    total: Array = field(default_factory=lambda: np.zeros(0))  # (k,) sum of the innovations
    rows: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))  # (k,) that they are of
    count: int = 0

    def add(self, innovation: Array, rows: NDArray[np.int64]) -> None:
        """Add a contradictory measurement; one with other sensors than the last starts a new sum."""
        if not np.array_equal(rows, self.rows):
            self.total, self.rows, self.count = np.zeros(len(rows)), rows, 0
        self.total, self.count = self.total + innovation, self.count + 1

    @property
    def mean(self) -> Array:
        """Mean innovation (k,) of the contradictory measurements."""
        return self.total / self.count


@dataclass(eq=False)
class Belief:
    """Estimated values of the machine's unknown constants, in the order of `BodyLayout`."""

    SAVED = ("unknowns", "covariance", "gradients", "pose_covariance")

    unknowns: Array  # (size,)
    covariance: Array  # (size, size)
    gradients: Array  # (m, size) of the lengths by the unknowns
    untold: Array  # covariance of `BodyLayout.laws` before a measurement
    sizes: tuple[LawSize, ...]  # of creep, softness and mounts
    averaged: AveragedAt | None = None  # over these sizes, the last time
    pose_covariance: Array = field(default_factory=lambda: np.zeros((6, 6)))


@dataclass(eq=False)
class Home:
    """Pose and line lengths at the last homing."""

    SAVED = ("lengths", "angles", "toward", "counts", "known")

    lengths: Array  # (m,) m
    angles: Array  # (m,) rad, wound on each drum
    toward: Array  # (m, 3)
    counts: NDArray[np.int64]  # (m,)
    known: bool = False  # whether the counts are


@dataclass(eq=False)
class Wound:
    """Cable paid out by the winches according to their encoders, and the angles of the drums."""

    SAVED = ("paid", "angles", "measured_at")

    paid: Array  # (m,) m since home
    angles: Array  # (m,) rad, wound
    measured_at: Array  # (m,) m paid out at the last measurement
    sliding: Array  # (m,) how cables slide over their sheaves: 1 while they are paid out, -1 while they are wound
    last_counts: tuple[float, NDArray[np.int64]] | None = None  # s, and the counts of then
    pending: NDArray[np.int64] | None = None  # (m,) counts that jumped, not yet believed
    drums: DrumPulls | None = None  # of drums with several lines; None: each line has a winch of its own


@dataclass(eq=False)
class BodySwing:
    """Velocity of the platform, and the record of its swing."""

    velocity: Array = field(default_factory=lambda: np.zeros(6))  # m/s and rad/s
    way: Array = field(
        default_factory=lambda: np.zeros(6)
    )  # m and rad: sum of the motions within steps, no corrections
    ways: TimeBuffer = field(default_factory=lambda: TimeBuffer(6, _POSES))  # those of late, for readings that are late
    force: Array | None = None  # (3,) m/s^2, platform: mean specific force of late
    time: float = math.nan  # s, of the last
    shaking: float = 0.0  # m^2/s^4: mean square of the force's change about that


@dataclass(eq=False)
class Doubts:
    """Contradictions between measurements and statics.

    They begin again when a state is loaded, except for a wrong cell or camera.
    """

    SAVED = ("cells_used", "camera_used")

    cells_used: Mask  # (m,)
    camera_used: bool = True
    consistency: dict[str, float] = field(default_factory=dict)
    silent: Mask = field(default_factory=lambda: np.zeros(1, dtype=bool))  # (m,) or (1,) cells without a reading
    doubts: int = 0  # measurements in a row that contradict the statics
    pictured: bool = False  # whether each of these had a picture: measurements between, without one, say nothing of it
    danger: str = ""  # why the machine is to stop
    search: Contradiction | None = None  # for the line that is to blame


@dataclass(eq=False)
class LastFrame:
    """Time and readings of the last frame that the next one needs."""

    time: float = -math.inf  # s
    clock: ClockLead | None = None  # by how much the platform's is ahead; None: it is the machine's
    tensions: Array | None = None  # (m,) N, smoothed, of cells that correct nothing; NaN: not read


@dataclass(eq=False)
class BodyState:
    """State of the estimator, changed in place by `step`. Windows and doubts begin again where state is loaded."""

    SAVED = (
        "belief",
        "home",
        "wound",
        "creep",
        "load_path",
        "lengths",
        "retraction",
        "judged",
        "tracker.pose",
        "tracker.states",
    )

    layout: BodyLayout
    tracker: Tracker
    taut: Taut
    monitor: FaultMonitor
    creep: BodyCreep
    load_path: LoadPath
    lengths: Array  # (m,) m, corrected
    belief: Belief
    home: Home
    wound: Wound
    judged: Doubts
    retraction: float = math.nan  # m
    motion: BodySwing = field(default_factory=BodySwing)
    window: Window = field(default_factory=Window)
    latest: LastFrame = field(default_factory=LastFrame)

    @property
    def pose(self) -> Array:
        """Estimated pose (6,) of the rigid platform, m and rad."""
        return self.tracker.pose

    @property
    def tensions(self) -> Array:
        """Estimated tensions (m,) at the sheaves, N."""
        return self.tracker.tensions


def start(
    settings: BodySettings,
    pose: Array,
    retraction: float = math.nan,
    lengths: Array | None = None,
    counts: NDArray[np.int64] | None = None,
) -> BodyState:
    """Return the state with the platform at *pose* (6,), homed there with a *retraction*, m (NaN: the robot's).

    *lengths* (m,), m: at which an estimate had left it; None: those that hold it. *counts* (w,): at which
    these are out; None: those of the first reading. Raises `AnswerError`.
    """
    model = settings.model if math.isnan(retraction) else Model(settings.model.robot.retracted(retraction))
    if lengths is None:
        lengths = solve_inverse(model, with_free(model.robot, pose)).checked().lengths
    tracker = _tracker_near(model, lengths, pose)
    layout = BodyLayout(model.m, settings.sensors)
    wound = settings.drums.angles(lengths)
    taut = taut_of(model.packed, tracker.pose)
    covariance = prior(settings, layout)
    m, still = model.m, np.zeros(model.m)
    return BodyState(
        layout,
        tracker,
        taut,
        FaultMonitor(dict(settings.timeouts)),
        creep_of(model.robot, tracker.tensions, settings.deviations.creep),
        LoadPath(tracker.tensions),
        lengths.copy(),
        Belief(
            np.zeros(layout.size),
            covariance,
            np.eye(m, layout.size),
            covariance[layout.laws, layout.laws].copy(),
            law_sizes(settings),
        ),
        Home(
            lengths.copy(),
            wound,
            taut.toward,
            np.zeros(model.winches, dtype=np.int64) if counts is None else counts.copy(),
            counts is not None,
        ),
        Wound(still, wound.copy(), still.copy(), still.copy()),
        Doubts(np.ones(m, dtype=bool)),
        retraction=retraction if not math.isnan(retraction) else _own_retraction(model),
        latest=LastFrame(clock=None if settings.clock is None else ClockLead(settings.clock)),
    )


def resumed(settings: BodySettings, state: BodyState) -> None:
    """Prepare a *state* loaded from a file for its next step."""
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
    """Return the line lengths (m,), m, by encoders, described creep, and the estimated unknowns."""
    counted, of_lengths, described = (
        state.home.lengths + state.wound.paid,
        state.layout.softness.start,
        state.creep.described,
    )
    if described is not None:
        counted = counted * (1.0 + described.strain)
    stretched_at_home = state.belief.unknowns[state.layout.softness] * state.load_path.home / state.load_path.mean
    return np.asarray(
        counted * (1.0 - stretched_at_home)
        + state.belief.gradients[:, :of_lengths] @ state.belief.unknowns[:of_lengths]
    )


def follow(state: BodyState) -> bool:
    """Move the estimated platform to the equilibrium of the corrected lengths; return whether one was found."""
    status = state.tracker.step(state.lengths)
    if status is Status.OK or state.tracker.restart(state.lengths):
        state.monitor.clear("encoders", "lost")
        state.taut = state.tracker.taut
        if state.tracker.model.robot.hung:
            state.lengths = state.tracker.solved.lengths[0].copy()
        return True
    state.monitor.report("encoders", "lost", f"the equilibrium could not be followed: {status.value}")
    return False


def set_load(state: BodyState, model: Model) -> None:
    """Give the equilibrium tracker the present retraction, the estimated load, and the estimated softness of lines.

    A line is at least half as soft as it is described.
    """
    packed: Packed = model.packed
    retraction = None if math.isnan(state.retraction) else np.array([state.retraction])
    rows = model.rows(retraction=retraction)
    platform = PlatformNumbers(packed.platform.copy())
    platform.wrench = platform.wrench + state.belief.unknowns[state.layout.load]
    lines = LineNumbers(rows.lines[0].copy())
    softer = state.belief.unknowns[state.layout.softness] * state.lengths / state.load_path.mean
    softer = softer + mount_share(lines, state.taut) * state.belief.unknowns[state.layout.mount]
    lines.spring = lines.spring + np.maximum(softer, -0.5 * stretches(lines, state.taut))
    state.tracker.change(packed._replace(lines=lines.array, platform=platform.array))
