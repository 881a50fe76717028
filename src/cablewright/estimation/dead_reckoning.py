"""The state by the encoders alone: lengths paid out since a known place, and where the platform then hangs.

What most printers do, and what everything else here is compared with. It knows the layers of cable on a winch as they
should lie, and nothing of how they do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import InputError, Status
from cablewright.estimation.fault_monitor import Watch
from cablewright.models.coil import Coil
from cablewright.models.statics import Model
from cablewright.signals import Encoders, Estimate, SensorFrame, frozen
from cablewright.solvers.continuation import Tracker, TrackerSettings
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import taut_at

__all__ = ["ReckoningSettings", "ReckoningState", "start", "step"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ReckoningSettings:
    """``counts``: of an encoder for a radian of a winch drum. ``coils``: the cable of each winch as it should lie.

    ``held``: m of cable of a winch, wound or out. ``slack``: m of excess from which a line counts as slack. ``smooth``:
    s over which velocity is averaged. ``quiet``: s without counts until that is said.
    """

    model: Model
    counts: float
    coils: tuple[Coil, ...]
    held: float
    slack: float = 2.5e-3
    smooth: float = 0.2
    quiet: float = 0.5

    def __post_init__(self) -> None:
        """Refuse what does not hang together."""
        if self.model.n != 3 or len(self.coils) != self.model.m:
            raise InputError(f"robot {self.model.robot.name!r}: a point platform and a coil for each line are wanted")


@dataclass(eq=False)
class ReckoningState:
    """What `step` changes."""

    tracker: Tracker
    home: Array  # (m,) m: lengths where it began
    wound: Array  # (m,) rad: on each drum there
    watch: Watch
    counts: NDArray[np.int64] | None = None  # (m,) where it began
    turned: Array = field(default_factory=lambda: np.zeros(1))  # (m,) or (1,) rad since
    lengths: Array | None = None
    velocity: Array | None = None
    time: float = -math.inf


def start(settings: ReckoningSettings, place: Array) -> ReckoningState:
    """Return the state with the platform at *place* (3,), m, all lines taut. Raises `AnswerError` if it cannot hang."""
    held = solve_inverse(settings.model, place).checked()
    wound = [coil.angle(settings.held - out) for coil, out in zip(settings.coils, held.lengths.tolist(), strict=True)]
    tracker = Tracker(settings.model, held.lengths, TrackerSettings(certify=False))
    return ReckoningState(tracker, held.lengths.copy(), np.array(wound), Watch({"encoders": settings.quiet}))


def step(settings: ReckoningSettings, state: ReckoningState, frame: SensorFrame) -> Estimate:
    """Take one frame; *state* changes in place. Raises nothing for what a frame holds."""
    dt = frame.time - state.time
    if not dt > 0.0:
        state.watch.restart(frame.time, f"the clock jumped back from {state.time:g} to {frame.time:g} s")
        dt = math.inf
    state.time = frame.time
    before = state.tracker.pose
    for reading in frame.of(Encoders):
        assert isinstance(reading, Encoders)
        if state.watch.heard(reading, frame.time) is not None:
            _count(settings, state, reading)
    paid = state.home if state.lengths is None else state.lengths
    status = state.tracker.step(paid)
    if status is Status.OK:
        state.watch.clear("encoders", "lost")
    else:
        state.watch.say("encoders", "lost", f"the platform could not be followed: {status.value}")
    if state.velocity is None or not math.isfinite(dt):
        state.velocity = np.zeros(3)
    else:
        share = min(1.0, dt / settings.smooth)
        state.velocity = state.velocity + share * ((state.tracker.pose - before) / dt - state.velocity)
    state.watch.check(frame.time)
    return _estimate(settings, state, paid, status)


def _count(settings: ReckoningSettings, state: ReckoningState, reading: Encoders) -> None:
    if state.counts is None:
        state.counts = reading.counts
    turned = (reading.counts - state.counts) / settings.counts
    rows = zip(settings.coils, state.home.tolist(), state.wound.tolist(), turned.tolist(), strict=True)
    most = [2.0 * math.pi * (len(coil.radii) - 1) for coil in settings.coils]
    if any(not 0.0 <= wound - turn <= end for wound, turn, end in zip(state.wound, turned, most, strict=True)):
        state.watch.say("encoders", "jump", "more turns are counted than a winch has: left out")
        return
    state.watch.clear("encoders", "jump")
    state.turned = turned
    state.lengths = np.array([home + coil.length(on) - coil.length(on - turn) for coil, home, on, turn in rows])


def _estimate(settings: ReckoningSettings, state: ReckoningState, paid: Array, status: Status) -> Estimate:
    assert state.velocity is not None
    pose = state.tracker.pose
    excess = paid - taut_at(settings.model, pose).lengths
    wound = (state.wound - state.turned).tolist()
    radii = [coil.radius(angle) for coil, angle in zip(settings.coils, wound, strict=True)]
    return Estimate(
        state.time,
        frozen(pose),
        frozen(state.velocity),
        frozen(np.zeros(3)),
        frozen(paid),
        frozen(excess),
        excess > settings.slack,
        frozen(radii),
        faults=state.watch.faults,
        valid=status is Status.OK and state.counts is not None,
    )
