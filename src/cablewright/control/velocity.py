"""Winch speeds that keep a point platform on its way, from what is believed of its state.

Two laws. ``paper`` (Merlet and Papegay 2023, III): the wanted velocity, corrected by the path error, times the inverse
Jacobian of the lines, and for slack lines a term that keeps them nearly taut. ``model``: the same velocity, and in what
it leaves open (more lines than freedoms have ways to change that move nothing) each line towards the excess or stretch
that the full model gives it at the tensions chosen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from cablewright.control.guide import Target
from cablewright.control.slack import SlackSettings, planned, term
from cablewright.errors import InputError, UnknownName
from cablewright.models.statics import Model
from cablewright.signals import Estimate
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import Taut, taut_at

__all__ = ["LAWS", "LawName", "VelocitySettings", "VelocityState", "start", "step"]

Array = NDArray[np.float64]
LawName = Literal["paper", "model"]
LAWS: Final = ("paper", "model")


@dataclass(frozen=True, eq=False)
class VelocitySettings:
    """How the platform is kept on its way.

    ``gain``: share of the path error that is driven out, 1/s; ``most``: m/s of a correction at most. ``stiffen``: share
    of the lines' error within what moves nothing that is driven out, 1/s. ``fastest``: rad/s of a winch drum.
    ``manage_slack``: whether a line is to be slack; without it the model's tensions are all to hold.
    """

    model: Model
    fastest: float
    law: LawName = "paper"
    gain: float = 0.5
    most: float = 0.02
    stiffen: float = 0.5
    manage_slack: bool = True
    slack: SlackSettings = field(default_factory=SlackSettings)

    def __post_init__(self) -> None:
        """Refuse what is no controller."""
        if self.law not in LAWS:
            raise UnknownName("law", self.law, LAWS)
        if self.model.n != 3:
            raise InputError(f"robot {self.model.robot.name!r}: only a point platform can be driven")
        for name in ("gain", "most", "stiffen", "fastest"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"{name} = {getattr(self, name):g}: a finite number over 0 is wanted")


@dataclass(eq=False)
class VelocityState:
    """What `step` changes."""

    plan: Array  # (m,) m of excess that each line is given on purpose
    chosen: int = -1  # the line that is to be slack


def start(settings: VelocitySettings) -> VelocityState:
    """Return the state before the first step."""
    return VelocityState(np.zeros(settings.model.m))


def step(settings: VelocitySettings, state: VelocityState, estimate: Estimate, target: Target, dt: float) -> Array:
    """Speeds of the winch drums (m,), rad/s, for the next *dt* (s); positive pays out.

    Where more is asked of a winch than it has, all are slowed down alike, so that the platform stays on its way.
    Zeros where the estimate has no place or the platform is in no place where lines can be drawn.
    """
    taut = taut_at(settings.model, estimate.position)
    if not (np.isfinite(taut.toward).all() and np.isfinite(estimate.lengths).all()):
        return np.zeros(settings.model.m)
    error = target.position - estimate.position
    push = min(settings.gain, 0.5 / dt) * error
    size = math.sqrt(float(push @ push))
    if size > settings.most:
        push *= settings.most / size
    rates = taut.toward @ (target.velocity + push)
    if settings.law == "paper":
        rates += _slack_term(settings, taut, estimate, dt)
    else:
        rates += _stiffened(settings, state, taut, estimate, target, dt)
    speeds = rates / estimate.radii
    fastest = float(np.abs(speeds).max())
    return speeds * (settings.fastest / fastest) if fastest > settings.fastest else speeds


def _slack_term(settings: VelocitySettings, taut: Taut, estimate: Estimate, dt: float) -> Array:
    """The paper's term, no faster than a correction may be, nor than half of the excess in one step."""
    most = np.minimum(0.5 * np.abs(estimate.excess - settings.slack.wanted) / dt, settings.most)
    return np.clip(term(settings.slack, taut, estimate.excess, estimate.slack), -most, most)


def _stiffened(
    settings: VelocitySettings, state: VelocityState, taut: Taut, estimate: Estimate, target: Target, dt: float
) -> Array:
    """Rates (m,), m/s, that bring excess and stretch of all lines to what the model wants and move nothing."""
    model = settings.model
    held = solve_inverse(model, target.position)
    if not np.isfinite(held.lengths).all():
        return np.zeros(model.m)
    if settings.manage_slack:
        state.chosen = planned(settings.slack, held.tensions, state.chosen)
        goal = np.where(np.arange(model.m) == state.chosen, settings.slack.plan, 0.0)
        change = settings.slack.ease * dt
        state.plan = state.plan + np.clip(goal - state.plan, -change, change)
    there = taut_at(model, target.position)
    wanted = held.lengths - there.lengths + state.plan
    off = np.where(np.isfinite(estimate.excess), wanted - estimate.excess, 0.0)
    basis, _ = np.linalg.qr(taut.toward)
    free = min(settings.stiffen, 0.5 / dt) * (off - basis @ (basis.T @ off))
    return np.asarray(np.clip(free, -settings.most, settings.most))
