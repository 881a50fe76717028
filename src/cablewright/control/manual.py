"""Motion of the platform by hand: a jog while a key is held, or a straight line to a position."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from cablewright.control.speed_smoothing import PeriodAt, RampMean
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Order, OrderKind
from cablewright.models.plane import leaving, within
from cablewright.robot.plane import OFF_PLANE, Plane

LEASE: Final = 0.2
"""Time for which one order to jog is obeyed, s: whoever holds a button repeats it, and whoever is gone does not."""

MAX_SPEED: Final = 0.25
"""Largest speed by hand, m/s (ISO 10218-1 for manual operation at reduced speed)."""

_AHEAD: Final = 0.02  # m that a rigid platform can go beyond where it stops
_AT: Final = 1e-6  # m from a place that counts as there
_SETTLED: Final = 1e-4  # m that the platform may be off a place at which it has arrived
_SETTLING: Final = 10.0  # s for which that is waited for
_ASIDE: Final = 1e-3  # share of a jog's speed that may lead out of the platform's plane: rounding of its direction


@dataclass(frozen=True)
class ManualSettings:
    """Limits of motions by hand. ``acceleration``: m/s^2. ``max_speed``: m/s. ``park``: (3,) m; None: there is none.

    ``deceleration``: m/s^2, of a jog that is let go; None: ``acceleration``. ``max_run_out``: m, from the last order to
    jog to rest. ``delay``: s from a target to its motion. ``holds``: whether the lines hold a rigid platform with its
    nozzle at a place (3,), m, at a rotation (3,), rad; None: no order. ``period``: period of the mode for which a
    motion from rest is shaped; None: it is not. A jog that is let go or is to slow down, and a stop before lines cannot
    hold, are not. ``plane``: plane in which the moved point stays; None: it may leave every plane.
    """

    min_position: tuple[float, float, float]
    max_position: tuple[float, float, float]
    acceleration: float
    max_speed: float = MAX_SPEED
    park: tuple[float, float, float] | None = None
    deceleration: float | None = None
    max_run_out: float = math.inf
    delay: float = 0.0
    holds: Callable[[Array, Array], bool] | None = None
    period: PeriodAt | None = None
    plane: Plane | None = None

    def require_run_out(self, speed: float) -> None:
        """Raise `InputError` for a *speed*, m/s, from which a jog would not stop in time."""
        require_run_out(speed, self.deceleration or self.acceleration, self.delay, self.max_run_out)


def require_run_out(speed: float, deceleration: float, delay: float, most: float) -> None:
    """Raise `InputError` for a jog that runs on by more than *most*, m, after the last order: its lease, then slowing.

    *speed*: m/s; *deceleration*: m/s^2; *delay*: s from an order to the motion.
    """
    found = speed * (LEASE + delay) + speed * speed / (2.0 * deceleration)
    if found > most:
        why = f"at most {most:g} m is allowed (drives.jog_run_out): go slower"
        raise InputError(f"jog: from {speed:g} m/s it runs on by {found:.3f} m after the last order; {why}")


@dataclass(eq=False)
class ManualState:
    """State of a motion by hand, changed in place."""

    position: Array = field(default_factory=lambda: np.zeros(3))  # m, of the target
    velocity: Array = field(default_factory=lambda: np.zeros(3))  # m/s
    goal: Array | None = None  # m; None: a jog
    wish: Array = field(default_factory=lambda: np.zeros(3))  # m/s, of a jog
    lease_end: float = -math.inf  # s
    rotation: Array = field(default_factory=lambda: np.zeros(3))  # rad, that a rigid platform keeps
    mean: RampMean = field(default_factory=RampMean)  # of the velocity
    arrival: float = math.inf  # s, of the target at its goal


class TargetMotion(NamedTuple):
    """Position and velocity of the target over the next step, and whether it has come to rest as ordered.

    ``failure``: why it, or the platform, has come to rest elsewhere.
    """

    position: Array  # (3,) m
    velocity: Array  # (3,) m/s
    done: bool
    accelerations: Array  # (2, 3) m/s^2, in the last step and in this one, of a shaped motion; else zero
    failure: str = ""


def refusal(settings: ManualSettings, order: Order, now: float) -> str:
    """Return why a motion by hand may not begin at *now*, s; empty: it may."""
    try:
        if order.kind is OrderKind.JOG:
            speed = float(np.linalg.norm(_vector(order, "velocity")))
            if speed > settings.max_speed:
                return f"jog: velocity: {speed:g} m/s; at most {settings.max_speed:g} is allowed by hand"
            settings.require_run_out(speed)
            wish = _vector(order, "velocity")
            aside = float(np.linalg.norm(leaving(settings.plane, wish)))
            if aside > _ASIDE * speed:
                return f"jog: velocity: leaves the plane {settings.plane} by {aside:.3g} m/s: move along the plane"
            return "" if now - order.time < LEASE else f"jog: it was ordered over {LEASE:g} s ago"
        goal = _goal(settings, order)
    except InputError as error:
        return str(error)
    for axis, low, at, high in zip("xyz", settings.min_position, goal.tolist(), settings.max_position, strict=True):
        if not low <= at <= high:
            return f"{order.kind}: {axis} = {at:g} m is outside {low:g} to {high:g} m"
    foot = within(settings.plane, goal)
    if (off := float(np.linalg.norm(goal - foot))) > OFF_PLANE:
        nearest = ", ".join(f"{x:.6f}" for x in foot.tolist())
        return (
            f"{order.kind}: position is {1e3 * off:.4g} mm off the plane {settings.plane}; nearest in it: {nearest} m"
        )
    return ""


def begin(
    settings: ManualSettings, state: ManualState, order: Order, now: float, at: tuple[Array, Array] | None
) -> None:
    """Begin the motion of an accepted order by hand.

    *at*: position of the platform, or of a rigid one's nozzle, (3,) m, and its rotation (3,), rad; None: it moves
    already.
    """
    if at is not None:
        state.position, state.velocity, state.rotation = at[0].copy(), np.zeros(3), at[1].copy()
        state.mean.rest()
    if order.kind is OrderKind.JOG:
        state.goal, state.lease_end = None, min(now, order.time) + LEASE
        wish = _vector(order, "velocity")
        state.wish = wish - leaving(settings.plane, wish)
    else:
        if state.goal is None:  # it comes to rest first as a jog does, within its limits
            state.mean.rest()
        state.goal, state.arrival = within(settings.plane, _goal(settings, order)), math.inf


def step(settings: ManualSettings, state: ManualState, now: float, dt: float, off: float = 0.0) -> TargetMotion:
    """Return the target's motion over the next *dt* (s), with bounded acceleration; *state* changes in place.

    *off*: m, distance of the platform from the target; at an ordered position it settles first.
    """
    wish = _towards(settings, state, dt) if state.goal is not None else _jog(settings, state, now, dt)
    stuck = (
        settings.holds is not None and wish.any() and not settings.holds(_ahead(settings, state, wish), state.rotation)
    )
    if stuck:
        wish = np.zeros(3)
    before = state.velocity
    slows = state.goal is None and float(wish @ wish) < float(before @ before)
    change = (settings.deceleration or settings.acceleration if slows else settings.acceleration) * dt
    if settings.period is None or stuck or _is_prompt(state, wish):
        state.mean.rest()
        state.velocity = _nearer(before, wish, change)
    else:
        period, place = settings.period, state.position
        asked = _nearer(state.mean.asked(before), wish, change)
        mean = state.mean.take(before, asked, lambda: period(place), dt)
        fast = state.goal is None and float(mean @ mean) > float(wish @ wish)  # it has come near its limits
        state.velocity = wish if fast else mean
    here = state.position
    state.position = here + dt * state.velocity
    still = not state.velocity.any()
    if stuck and still:
        return TargetMotion(here, state.velocity, True, np.zeros((2, 3)), "no tensions hold the platform farther on")
    there = state.goal is None or float(np.linalg.norm(state.goal - state.position)) <= _AT
    done = still and (there if state.goal is not None else now >= state.lease_end)
    rates = np.broadcast_to(state.mean.rates, (2, 3))
    if state.goal is None or not done:
        state.arrival = math.inf
        return TargetMotion(here, state.velocity, done, rates)
    state.arrival = min(state.arrival, now)
    if off <= _SETTLED:
        return TargetMotion(here, state.velocity, True, rates)
    left = f"the platform stands {1e3 * off:.2g} mm off its goal: it has not come nearer in {_SETTLING:g} s"
    return TargetMotion(here, state.velocity, now - state.arrival >= _SETTLING, rates, left)


def _is_prompt(state: ManualState, wish: Array) -> bool:
    """Whether the velocity follows its *wish* (3,), m/s, without delay: it slows down, turns, or goes on to a place."""
    if state.goal is None:
        return float(wish @ state.velocity) < float(state.velocity @ state.velocity)
    return not state.mean.has_begun and bool(state.velocity.any())


def _nearer(velocity: Array, wish: Array, change: float) -> Array:
    """Return the *velocity* (3,), m/s, nearer to the *wish* (3,), m/s, by *change*, m/s."""
    more = wish - velocity
    size = float(np.linalg.norm(more))
    return wish if size <= change else velocity + more * (change / size)


def _ahead(settings: ManualSettings, state: ManualState, wish: Array) -> Array:
    """A position (3,), m, in the direction of a *wish* (3,), m/s, just beyond the stopping distance of the target."""
    speed = float(np.linalg.norm(state.velocity))
    return np.asarray(
        state.position + (_AHEAD + speed * speed / (2.0 * settings.acceleration)) * wish / np.linalg.norm(wish)
    )


def _jog(settings: ManualSettings, state: ManualState, now: float, dt: float) -> Array:
    """Velocity (3,), m/s, of a jog: none when it was not repeated, and so slow that it can stop within the limits."""
    if now >= state.lease_end:
        return np.zeros(3)
    limits = zip(settings.min_position, settings.max_position, strict=True)
    shares = np.ones(3)
    for axis, (low, high) in enumerate(limits):
        at, wish = float(state.position[axis]), float(state.wish[axis])
        most = _stopping(settings, high - at if wish > 0.0 else at - low, dt)
        shares[axis] = min(1.0, most / abs(wish)) if wish else 1.0
    return state.wish * (shares if settings.plane is None else shares.min())


def _stopping(settings: ManualSettings, left: float, dt: float) -> float:
    """Speed, m/s, from which a motion along one axis stops within *left*, m, in whole steps."""
    change = settings.acceleration / math.sqrt(3.0) * dt  # the three axes share the acceleration
    return max(math.sqrt(change * change + 2.0 * change / dt * max(left, 0.0)) - change, 0.0)


def _towards(settings: ManualSettings, state: ManualState, dt: float) -> Array:
    """Velocity (3,), m/s, towards the goal, from which it can still stop there, in whole steps."""
    assert state.goal is not None
    way = state.goal - state.position - state.mean.pending(state.velocity, dt)
    left = float(np.linalg.norm(way))
    if left <= _AT:
        return np.zeros(3)
    change = settings.acceleration * dt
    stopping = math.sqrt(change * change + 2.0 * settings.acceleration * left) - change
    return np.asarray(way * (min(settings.max_speed, max(stopping, _AT / dt), left / dt) / left))


def _goal(settings: ManualSettings, order: Order) -> Array:
    if order.kind is OrderKind.PARK:
        if settings.park is None:
            raise InputError("park: the machine file sets no parking position")
        return np.array(settings.park)
    return _vector(order, "position")


def _vector(order: Order, key: str) -> Array:
    """A vector of an order's arguments. Raises `InputError` unless it has three finite numbers."""
    values = order.arguments.get(key, ())
    if len(values) != 3 or not all(map(math.isfinite, values)):
        raise InputError(f"{order.kind}: {key} = {values}: three finite numbers are expected")
    return np.array(values, dtype=np.float64)
