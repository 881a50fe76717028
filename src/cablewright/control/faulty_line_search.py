"""Search for the line of wrong length, with one line more than degrees of freedom: its offset is equal at all poses.

At one pose each line could be the wrong one, by an offset of its own. The platform moves slowly to two further
positions; the offset of the line that is wrong stays, those of the others change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.control.length_check import LengthCheck
from cablewright.foundation.arrays import Array
from cablewright.models.plane import directions
from cablewright.models.statics import Model
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import taut_at

WAY: Final = 0.4
"""From the first place to each of the others, m."""

_SPEED: Final = 0.05  # m/s
_RAMP: Final = 0.05  # m/s^2
_GAIN: Final = 2.0  # 1/s, of lengths towards their targets
_CLOSER: Final = 0.4  # spread of the offsets of the line that is named, over that of the next
_SURE: Final = 2e-3  # m, spread that the others must have at least


def places(model: Model, low: Array, high: Array, here: Array) -> list[Array]:
    """Return two poses (n,) near *here* (n,) that can be reached and held, for the search; empty: there are none.

    One is along x and one along y, or along the two directions of the platform's plane. *low*, *high*: (3,) m, between
    which the platform has to stay.
    """
    found = []
    for along in directions(model.robot.platform.plane, 3)[:, :2].T:
        inward = sorted((along, -along), key=lambda way: float(way @ (here[:3] - 0.5 * (low + high))))
        for way in inward:
            steps = here + np.outer(np.linspace(0.25, 1.0, 4), WAY * np.pad(way, (0, model.n - 3)))
            inside = bool(((steps[:, :3] >= low) & (steps[:, :3] <= high)).all())
            if inside and bool(solve_inverse(model, steps).holds.all()):
                found.append(steps[-1])
                break
    return found if len(found) == 2 else []


@dataclass(eq=False)
class SlowWay:
    """A slow straight motion between two poses of nearly the same rotation, by lengths.

    Changed in place by `speeds`.
    """

    begin: Array  # (n,) m and rad
    end: Array  # (n,) m and rad
    lengths: Array  # (m,) m, at the beginning, by the counts
    radius: float  # m, of the drums
    gone: float = 0.0  # m
    pace: float = 0.0  # m/s
    arrived: bool = False

    def speeds(self, model: Model, lengths: Array, dt: float) -> Array:
        """Return the speeds (w,), rad/s, of the winches for the next *dt*, s, at measured *lengths* (m,), m."""
        way = self.end - self.begin
        whole = float(np.linalg.norm(way[:3]))
        left = whole - self.gone
        self.pace = min(self.pace + _RAMP * dt, _SPEED, float(np.sqrt(2.0 * _RAMP * max(left, 0.0))) + 1e-4)
        self.gone = min(self.gone + self.pace * dt, whole)
        nominal = taut_at(model, self.begin + way * (self.gone / whole)).lengths
        target = self.lengths + nominal - taut_at(model, self.begin).lengths
        off = (target - lengths)[list(model.robot.hosts)]
        self.arrived = self.gone >= whole and float(np.abs(off).max()) < 5e-4
        return np.asarray(np.clip(_GAIN * off, -2.0 * _SPEED, 2.0 * _SPEED) / self.radius)


def sentence(checks: Sequence[LengthCheck], names: Sequence[str]) -> str:
    """Return the diagnosis by checks at several positions: one line if its offset stays constant, or all candidates."""
    first = checks[0]
    lines = [i for i in first.suspects if all(i in check.suspects for check in checks[1:])]
    if len(checks) < 2 or not lines:
        return first.sentence(names)
    spread = {i: float(np.ptp([check.suspects[i] for check in checks])) for i in lines}
    best, *others = sorted(lines, key=lambda i: spread[i])
    sure = not others or (spread[best] < _CLOSER * spread[others[0]] and spread[others[0]] > _SURE)
    chosen = [best] if sure else sorted(lines, key=lambda i: spread[i])
    offsets = {i: float(np.mean([check.suspects[i] for check in checks])) for i in chosen}
    return LengthCheck(first.pose, first.misfit, offsets, first.tested).sentence(names)
