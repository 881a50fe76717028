"""Velocity control: winch speeds from target and estimate.

Two laws of a point platform. ``paper`` (Merlet and Papegay 2023, III): the target velocity, corrected by the path
error, times the inverse Jacobian of the lines, and for slack lines a term that keeps them nearly taut. ``model``: the
same velocity; in the null space of the lengths (with more lines than degrees of freedom), each line is controlled to
the excess or stretch that the full model gives it at the chosen tensions.

A rigid platform has the law ``model`` for all lengths together: they follow those that the full model gives for the
target, so that pose and tensions follow it together. The estimated lengths are by the encoders alone, or as load cells
and other sensors correct them, whatever the sensors of the estimate: the loop of tensions is then closed on
measurements.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, NamedTuple, get_args

import numpy as np

from cablewright.control.path_follower import Target
from cablewright.control.retraction import BeamMotion
from cablewright.control.slack import SlackSettings, slack_rates
from cablewright.control.stretch_damping import StretchDamping, StretchState
from cablewright.control.stretch_damping import follow as follow_stretch
from cablewright.control.swing_damping import MOST_SPEED, SwingDamping, SwingState, follow, gains
from cablewright.control.tensioned_lengths import held_at, length_errors
from cablewright.foundation.arrays import Array, Indices
from cablewright.foundation.choices import LawName
from cablewright.foundation.errors import InputError, UnknownName, require_positive
from cablewright.foundation.signals import Encoders, Estimate, SensorFrame
from cablewright.kernels import Direct
from cablewright.kernels.control import body_velocity_step as body_kernel
from cablewright.kernels.control import point_velocity_step as kernel
from cablewright.kernels.control.body_velocity_step import BodyGains, HeldStep
from cablewright.kernels.control.point_velocity_step import PointGains
from cablewright.kernels.layout import Packed
from cablewright.models.fidelity import CableLaw
from cablewright.models.inertia import compensates, inertia_wrenches
from cablewright.models.packed_views import PlatformNumbers
from cablewright.models.rotation import moved
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.support_table import Capability, require
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.preferred_tensions import preferred_tensions
from cablewright.solvers.taut import Taut, taut_at

LAWS: Final = get_args(LawName)

_STILL: Final = np.zeros(3)
_NONE: Final = np.empty(0)
_OK: Final = np.zeros(1, np.int64)
_OLDEST: Final = 0.1  # s, age of counts that is allowed for: the guard judges older ones


@dataclass(frozen=True, eq=False)
class VelocitySettings:
    """Settings of the velocity control: law, gains and limits.

    ``max_drum_speed``: largest speed of a winch drum, rad/s. ``gain``: gain on the path error, 1/s; ``max_correction``:
    largest speed of its correction, m/s. ``internal_gain``: gain on the lines' errors in the null space, 1/s.
    ``manage_slack``: under the law ``model``, whether one line is slack on purpose; otherwise all lines have the
    model's tensions. ``by_lengths``: whether the estimated position is that at which the lengths hold the platform at
    rest. ``swing``: damping of the swing of a drum below a point; None: it is not damped. ``stretch``: damping of
    swings in which lines stretch, under the law ``model``.
    ``lag``: time constant of the winches' speeds behind their commands, s. ``ages``: whether the estimated pose is that
    of the last counts; otherwise it is predicted to the time of the estimate.
    """

    model: Model
    max_drum_speed: float
    law: LawName = "paper"
    gain: float = 0.5
    max_correction: float = 0.02
    internal_gain: float = 0.5
    manage_slack: bool = True
    by_lengths: bool = False
    slack: SlackSettings = field(default_factory=SlackSettings)
    swing: SwingDamping | None = None
    stretch: StretchDamping | None = None
    lag: float = 0.0
    ages: bool = False

    @property
    def damps(self) -> bool:
        """Whether the control damps swings of the drum, or swings in which lines stretch."""
        return self.swing is not None or self.stretch is not None

    @cached_property
    def gains(self) -> PointGains:
        """Gains and limits for the kernel of a point platform."""
        own = self.slack
        return PointGains(
            float(self.gain), float(self.max_correction), float(self.internal_gain), float(own.planned_excess),
            float(own.switch_margin), float(own.excess_rate), bool(self.manage_slack), bool(self.by_lengths),
        )  # fmt: skip

    @cached_property
    def free(self) -> Array:
        """The motions (3, p) of a point that its plane, if any, allows."""
        free = self.model.free_directions
        return np.eye(3) if free is None else np.array(free, order="C")

    @cached_property
    def row(self) -> Packed | None:
        """The model with its preferred tensions, for kernels that solve with a winch for each line; None: others."""
        model = self.model
        solved = model.robot.is_plainly_driven and model.fidelity.cable is not CableLaw.RIGID
        return model.rows(preferred=preferred_tensions(model)) if solved else None

    @cached_property
    def plain(self) -> Packed | None:
        """The `row` of a point platform, for the kernel that computes all; None where it cannot."""
        return None if self.stretch is not None or self.model.massless else self.row

    @cached_property
    def steers(self) -> bool:
        """Whether one kernel computes the speeds of the winches, see `point_velocity_step.steer`."""
        return self.model.n == 3 and self.law == "model" and self.plain is not None

    @cached_property
    def body_gains(self) -> BodyGains:
        """Gain, largest correction, lag and mass, packed for the kernels of a rigid platform."""
        platform = self.model.robot.platform
        own = float(self.gain), float(self.max_correction), float(self.lag), float(platform.mass)
        return BodyGains(*own, np.array(platform.centre_of_mass, dtype=np.float64))

    @cached_property
    def leads(self) -> bool:
        """Whether the lengths compensate the forces of an accelerating platform."""
        return compensates(self.model.robot)

    @cached_property
    def hosts(self) -> Indices:
        """The lines (w,) that the winches are named for."""
        return np.array(self.model.robot.hosts)

    def __post_init__(self) -> None:
        """Raise `InputError` for unknown laws, rigid platforms and numbers that are not positive and finite."""
        if self.law not in LAWS:
            raise UnknownName("law", self.law, LAWS)
        if self.model.n != 3 and self.law != "model":
            raise InputError(
                f"law = {self.law}: is only for a point platform; the platform of {self.model.robot.name!r} is "
                f"rigid: use law model"
            )
        require(self.model, Capability.CONTROL)
        names = ("gain", "max_correction", "internal_gain", "max_drum_speed")
        require_positive(**{name: getattr(self, name) for name in names})


@dataclass(eq=False)
class VelocityState:
    """State of the velocity control, changed in place by `step`."""

    planned_excess: Array  # (m,) m, of each line on purpose
    near: Array  # (2, m, 6) states of lines that hold a point at rest, and accelerated; of a body the first: `hold` ...
    at: Array = field(default_factory=lambda: np.full((2, 3), np.nan))  # ... at a pose and an acceleration ...
    known: int = 0  # ... and of how many they are known
    steer: Direct = field(default_factory=lambda: Direct(kernel.steer))
    hold_body: Direct = field(default_factory=lambda: Direct(body_kernel.hold))
    pursue_body: Direct = field(default_factory=lambda: Direct(body_kernel.pursue))
    slack_line: Indices = field(default_factory=lambda: np.array([-1]))  # (1,) index; -1: none chosen yet
    swing: SwingState = field(default_factory=SwingState)
    stretch: StretchState = field(default_factory=StretchState)
    tension_error: float = math.inf  # N, largest, from those that the model chooses
    chosen: Array | None = None  # (m,) N at the sheaves, that the model chooses; None: lines that are slack on purpose
    velocity: Array = field(default_factory=lambda: np.zeros(6))  # m/s, rad/s, expected of the platform: see `_delay`
    commanded: Array = field(default_factory=lambda: np.zeros(6))  # m/s, rad/s, of the platform in the last step ...
    time: float = -math.inf  # s ... and its time
    counted: float = -math.inf  # s, of the last counts of the encoders


def start(settings: VelocitySettings) -> VelocityState:
    """Return the state of the control before the first step."""
    m, n = settings.model.m, settings.model.n
    return VelocityState(np.zeros(m), np.zeros((2, m, 6)), np.full((2, n), np.nan))


def step(
    settings: VelocitySettings,
    state: VelocityState,
    estimate: Estimate,
    target: Target,
    dt: float,
    tensions: Array | None = None,
    beam: BeamMotion | None = None,
    *,
    calms: bool = True,
) -> Array:
    """Return the speeds of the winch drums (w,), rad/s, for the next *dt* (s); positive pays out.

    *tensions* (m,), N: estimated for a rigid platform, measured for a point platform; None: unknown. *beam*: retraction
    of a platform that retracts. *calms*: whether swings in which lines stretch may be damped now. If one exceeds the
    limit, all are scaled, so that the platform stays on its path. Zeros for an unknown position or a line without a
    tangent there.
    """
    state.tension_error = math.inf  # unless it is found here
    delay = _delay(settings, state, estimate.time, dt)
    if settings.steers:
        return _steered(settings, state, estimate, target, dt, tensions, delay)
    if settings.model.n == 6:
        rates = _rates_of_body(settings, state, estimate, target, dt, tensions, beam, delay, calms=calms)
    else:
        rates = _rates_of_point(settings, state, estimate, target, dt, tensions, delay, calms=calms)
    if rates is None:
        state.commanded = np.zeros(6)
        return np.zeros(len(settings.hosts))
    speeds = rates / estimate.radii[settings.hosts]
    share = min(1.0, settings.max_drum_speed / max(*map(abs, speeds.tolist()), 1e-300))
    state.commanded = share * np.concatenate([target.velocity, target.rate])
    return np.asarray(share * speeds)


def _steered(
    settings: VelocitySettings,
    state: VelocityState,
    estimate: Estimate,
    target: Target,
    dt: float,
    tensions: Array | None,
    delay: float,
) -> Array:
    """Return the speeds of `step` of a point under the law ``model``, where one kernel computes all. *delay*: s."""
    own, target = estimate, target.writable()
    estimated = np.concatenate([own.position, own.rotation, own.excess, own.lengths, own.radii])
    pushed, swing = target.accelerations if settings.leads else np.zeros((2, 3)), settings.swing
    share, faster = (0.0, 0.0) if swing is None else gains(swing, dt)
    numbers = np.array([settings.model.robot.platform.mass, share, faster, MOST_SPEED, settings.max_drum_speed])
    chosen, speeds = np.empty(settings.model.m), np.empty(len(settings.hosts))
    state.known, drawn, error, share = state.steer.call(
        settings.plain, settings.model.packed, settings.hosts, settings.free, settings.gains, numbers, state.swing.mean,
        target.position, target.velocity, pushed, estimated, _NONE if tensions is None else tensions.copy(), dt, delay,
        state.known, state.near, state.at, state.velocity, state.planned_excess, state.slack_line, chosen, speeds,
    )  # fmt: skip
    if not (math.isnan(error) or settings.manage_slack):
        state.chosen, state.tension_error = chosen, error
    state.commanded = share * np.concatenate([target.velocity, target.rate]) if drawn else np.zeros(6)
    return speeds


def _rates_of_point(
    settings: VelocitySettings,
    state: VelocityState,
    estimate: Estimate,
    target: Target,
    dt: float,
    tensions: Array | None,
    delay: float,
    *,
    calms: bool,
) -> Array | None:
    """Return rates (w,), m/s, of the winches' lines of a point; None for an unknown position or line. *delay*: s."""
    if not np.isfinite(estimate.lengths).all():
        return None
    target = target.writable()
    held = _held_point(settings, state, target, dt)
    swing, rates = _STILL, np.empty(settings.model.m)
    if settings.swing is not None:
        swing = follow(settings.swing, state.swing, estimate.rotation, dt)
    place = estimate.position + delay * state.velocity[:3]
    packed, free, gains = settings.model.packed, settings.free, settings.gains
    if settings.law != "model":
        toward, _ = kernel.follow(
            packed, free, gains, held.lengths, place, target.position, target.velocity, swing, dt, rates
        )
        if not np.isfinite(toward).all():
            return None
    if settings.law == "paper":
        rates += _slack_term(settings, taut_at(settings.model, place + 0.5 * dt * target.velocity), estimate, dt)
        return np.asarray(rates[settings.hosts])
    drawn, error = kernel.pursue(
        packed, settings.hosts, free, gains, held.lengths, held.tensions,
        target.position if held.solved is None else held.solved.pose,
        place, target.position, target.velocity, swing,
        estimate.excess.copy(), _NONE if tensions is None else tensions.copy(), dt,
        state.planned_excess, state.slack_line, rates,
    )  # fmt: skip
    if not drawn:
        return None
    if not (settings.manage_slack or math.isnan(error)):
        state.chosen, state.tension_error = held.tensions, error
    if calms and held.solved is not None:
        rates += _stretch_rates(settings, state, held.solved, target.accelerations[0], estimate, dt)
    return np.asarray(rates[settings.hosts])


def note_counts(state: VelocityState, frame: SensorFrame) -> None:
    """Record the time of the encoder counts in a *frame*, by which positions are estimated.

    Call it for each frame.
    """
    for each in frame.readings:
        if isinstance(each, Encoders):
            state.counted = max(state.counted, min(each.time, frame.time))


def due(settings: VelocitySettings, state: VelocityState, target: Target, now: float) -> tuple[Array, Array]:
    """Return the commanded pose of the platform at the time *now*, s: position (3,), m, and rotation (3,), rad."""
    if state.time != now or settings.steers:
        return target.position - (settings.lag * state.velocity[:3] if state.time == now else 0.0), target.rotation
    pose = moved(np.concatenate([target.position, target.rotation]), -settings.lag * state.velocity)
    return pose[:3], pose[3:]


def _delay(settings: VelocitySettings, state: VelocityState, now: float, dt: float) -> float:
    """Return how long, s, the platform has yet to move from where it is estimated, until it has followed all commands.

    Winches follow a speed u by v' = (u - v) / T. From a target that moves at u the platform is d away, with d' = u - v
    and so d = T v, from rest on. Steps have constant u, and so an exact v; after a stop v is 0. An estimate may be as
    old as the counts, by A, up to `_OLDEST`: older ones are no matter of this. Feedback of gain K that took (T + A) v
    for an error would move the platform outwards: on a circle of radius R by about v^2 (T + A) / (R K). *now*: s.
    """
    passed = now - state.time
    keep = math.exp(-passed / settings.lag) if settings.lag else 0.0
    state.velocity = state.commanded + keep * (state.velocity - state.commanded) if passed <= 1.5 * dt else np.zeros(6)
    state.time = now
    age = min(max(now - state.counted, 0.0), _OLDEST) if settings.ages and math.isfinite(state.counted) else 0.0
    return settings.lag + age


class _HeldPoint(NamedTuple):
    """Lengths (5, m), m, see `point_velocity_step.hold`, tensions (m,), N, at rest, and that equilibrium if needed."""

    lengths: Array
    tensions: Array
    solved: Equilibrium | None


def _held_point(settings: VelocitySettings, state: VelocityState, target: Target, dt: float) -> _HeldPoint:
    """Return how lengths hold a point on its path, where they can; its own mass alone is accelerated."""
    model = settings.model
    pushed = target.accelerations if settings.leads else np.zeros((2, 3))
    if settings.plain is not None:
        lengths, tensions = np.empty((kernel.HELD, model.m)), np.empty(model.m)
        state.known = kernel.hold(
            settings.plain, model.robot.platform.mass, target.position, target.velocity, pushed, dt,
            state.near, state.at, state.known, lengths, tensions,
        )  # fmt: skip
        return _HeldPoint(lengths, tensions, None)
    held = solve_inverse(model, target.position)
    lengths = np.vstack([held.lengths, np.zeros((kernel.HELD - 1, model.m))])
    if pushed.any():
        places = np.stack([target.position, target.position + dt * target.velocity])
        wrenches = inertia_wrenches(model.robot, places, pushed)
        wrenches = np.concatenate([wrenches, np.zeros_like(wrenches)])
        lengths[1:] = solve_inverse(model, np.concatenate([places, places]), path=True, wrenches=wrenches).lengths
    return _HeldPoint(lengths, held.tensions, held)


def _rates_of_body(
    settings: VelocitySettings,
    state: VelocityState,
    estimate: Estimate,
    target: Target,
    dt: float,
    tensions: Array | None,
    beam: BeamMotion | None,
    delay: float,
    *,
    calms: bool,
) -> Array | None:
    """Return rates (w,), m/s, of the winches' lines of a rigid platform; None where no tensions hold it.

    *delay*: s, see `_delay`: tensions change in it too as the platform goes on.
    """
    if settings.row is not None and beam is None:
        state.known, rates = _rates_of_row(settings, settings.row, state, estimate, target, dt, tensions, delay, calms)
        if state.known:
            return rates
    here = np.concatenate([target.position, target.rotation])
    there = moved(here, dt * np.concatenate([target.velocity, target.rate]))
    retraction = None if beam is None else np.array([beam.length, beam.length + dt * beam.speed])
    pushed = target.accelerations if settings.leads else None
    held = held_at(settings.model, np.stack([here, there]), retraction, pushed)
    if held is None or not np.isfinite(estimate.lengths).all():
        return None
    change = _share(state, target) * (held.tensions[1] - held.tensions[0]) / dt
    state.chosen = held.tensions[0] - settings.lag * change
    tensions = None if tensions is None else tensions + delay * change
    if tensions is not None and np.isfinite(tensions).all():
        state.tension_error = float(np.abs(tensions - held.tensions[0]).max())
    now, then = held.lengths[:, settings.hosts]
    reached = moved(np.concatenate([estimate.position, estimate.rotation]), delay * state.velocity)
    error = length_errors(settings.model, reached, held, retraction, tensions)
    if not np.isfinite(error).all():
        return None
    correction = min(settings.gain, 0.5 / dt) * error
    rates = (then - now) / dt + _bounded(correction, settings.max_correction)
    if calms and settings.stretch is not None:
        rates += _stretch_rates(settings, state, held.solved[0], np.zeros(3), estimate, dt)[settings.hosts]
    return np.asarray(rates)


def _share(state: VelocityState, target: Target) -> float:
    """Return the share of the speed of the path at which the platform moves now."""
    speed = float(np.abs(target.velocity).sum() + np.abs(target.rate).sum())
    return min(float(np.abs(state.velocity).sum()) / speed, 1.0) if speed > 0.0 else 0.0


def _rates_of_row(
    settings: VelocitySettings,
    row: Packed,
    state: VelocityState,
    estimate: Estimate,
    target: Target,
    dt: float,
    tensions: Array | None,
    delay: float,
    calms: bool,
) -> tuple[int, Array | None]:
    """Return whether the lengths of a *row* hold both poses, and what `_rates_of_body` returns, by two kernels."""
    model, gains = settings.model, settings.body_gains
    held = HeldStep(*(np.empty((2, *size)) for size in ((6,), (6,), (model.m, 6), (model.m,), (model.m,))))
    held.poses[0, :3], held.poses[0, 3:] = target.position, target.rotation
    velocity = np.concatenate([target.velocity, target.rate])
    pushed = np.array(target.accelerations, np.float64, order="C") if settings.leads else np.zeros((2, 3))
    if not state.hold_body.call(row, gains, velocity, pushed, dt, state.near[0], state.at, bool(state.known), held):
        return 0, None
    if not np.isfinite(estimate.lengths).all():
        return 1, None
    state.chosen, rates = np.empty(model.m), np.empty(model.m)
    reached = moved(np.concatenate([estimate.position, estimate.rotation]), delay * state.velocity)
    error = state.pursue_body.call(
        row, model.packed, gains, held, reached, _share(state, target),
        _NONE if tensions is None else tensions.copy(), delay, dt, state.chosen, rates,
    )  # fmt: skip
    if math.isnan(error):
        return 1, None
    state.tension_error = error
    if calms and settings.stretch is not None:
        platform, now = row.platform.copy(), (held.poses[:1], held.lengths[:1], held.states[:1])
        PlatformNumbers(platform).wrench += held.wrenches[:1]
        loaded = row._replace(platform=platform)
        solved = Equilibrium(model, loaded, *now, code=_OK, violation=np.zeros(1), iterations=_OK)
        rates += _stretch_rates(settings, state, solved[0], np.zeros(3), estimate, dt)
    return 1, rates


def _stretch_rates(
    settings: VelocitySettings, state: VelocityState, held: Equilibrium, pushed: Array, estimate: Estimate, dt: float
) -> Array:
    """Return rates (m,), m/s, that damp swings in which lines stretch; zeros where these are not damped."""
    if settings.stretch is None:
        return np.zeros(settings.model.m)
    return follow_stretch(settings.stretch, state.stretch, held, pushed, estimate.time, dt)


def _bounded(vector: Array, most: float) -> Array:
    """Return *vector*, shortened to a length of *most*."""
    size = math.sqrt(float(vector @ vector))
    return vector if size <= most else vector * (most / size)


def _slack_term(settings: VelocitySettings, taut: Taut, estimate: Estimate, dt: float) -> Array:
    """Return the paper's term (m,), m/s, limited to `max_correction` and to half of the excess in one step."""
    limit = np.minimum(0.5 * np.abs(estimate.excess - settings.slack.target_excess) / dt, settings.max_correction)
    return np.clip(slack_rates(settings.slack, taut, estimate.excess, estimate.slack), -limit, limit)
