"""Whether measured tensions carry the platform where it is said to be: a test that needs no lengths.

It is coarse, as tensions are, but knows nothing of the lengths, so that it also sees what all of them agree on: a place
that was measured, or typed, wrong.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.statics import Model
from cablewright.solvers.taut import taut_at

_STEP: Final = 1e-3  # m, of a derivative
_MEAN: Final = 0.5  # s, over which forces of a platform that moves are averaged
_EVERY: Final = 0.05  # s
_MOVING: Final = 1.5  # times what is allowed at rest: it speeds up and slows down


@dataclass(frozen=True, eq=False)
class ForceBalance:
    """``off``: (3,) N, what the lines carry beyond the ``weight``, N. ``limit``: N, the size that is allowed.

    ``reach``: m, how far off a place must be at least before it is sure to show.
    """

    place: Array
    off: Array
    weight: float
    limit: float
    reach: float

    @property
    def holds(self) -> bool:
        """Whether nothing speaks against the place."""
        return float(np.linalg.norm(self.off)) <= self.limit

    def sentence(self) -> str:
        """What is wrong, with numbers."""
        x, y, z = self.place.tolist()
        size = float(np.linalg.norm(self.off))
        ways = ", ".join(f"{force:+.0f}" for force in self.off.tolist())
        what = (
            f"the tensions do not fit the place {x:.2f}, {y:.2f}, {z:.2f} m: beyond the weight of {self.weight:.0f} N"
        )
        allowed = f"at most {self.limit:.0f} N is allowed (drives.tension_error)"
        return f"{what} the lines pull by {ways} N, {size:.0f} N; {allowed}: place, load or a tension is wrong"


def balance(model: Model, place: Array, tensions: Array, share: float, laid: float = 0.0) -> ForceBalance:
    """Judge *tensions* (m,), N, at the sheaves, with the platform at *place* (3,), m; *share*: of its weight.

    *laid*: kg that have left the model's platform.
    """
    weight = weight_of(model, laid)
    off = excess(model, place, tensions, laid)
    ways = np.eye(3) * _STEP
    slope = np.column_stack(
        [(_force(model, place + way, tensions) - _force(model, place - way, tensions)) / (2.0 * _STEP) for way in ways]
    )
    softest = float(np.linalg.svd(slope, compute_uv=False)[-1]) if np.isfinite(slope).all() else 0.0
    limit = share * weight
    return ForceBalance(place, off, weight, limit, 2.0 * limit / softest if softest > 0.0 else np.inf)


def weight_of(model: Model, laid: float = 0.0) -> float:
    """Weight of the platform, N, from which *laid* kg have left."""
    return float(model.robot.scene.gravity * (model.robot.platform.mass - laid))


def excess(model: Model, place: Array, tensions: Array, laid: float = 0.0) -> Array:
    """What the lines carry beyond the weight, (3,) N, of the platform from which *laid* kg have left."""
    return np.asarray(_force(model, place, tensions) - np.array([0.0, 0.0, weight_of(model, laid)]))


@dataclass(eq=False)
class CarriedWatch:
    """Whether the lines go on carrying the platform where it is reckoned to be, over a while. Changed in place."""

    model: Model
    share: float  # of the weight, allowed
    _mean: Array | None = None  # (3,) N
    _time: float = -math.inf  # s
    _since: float = 0.0  # s

    def forget(self) -> None:
        """Begin anew."""
        self._mean, self._time = None, -math.inf

    def is_due(self, time: float) -> bool:
        """Whether it is time to judge again: every reading would say no more."""
        return time - self._time >= _EVERY

    def judge(self, place: Array, tensions: Array, time: float, laid: float = 0.0) -> str:
        """Why the platform, without *laid* kg, cannot be at *place* (3,), m, at *time*, s; an empty text: it can."""
        weight, off = weight_of(self.model, laid), excess(self.model, place, tensions, laid)
        if self._mean is None:
            self._mean, self._since = off, time
        else:
            self._mean = self._mean + (off - self._mean) * min((time - self._time) / _MEAN, 1.0)
        self._time = time
        found = ForceBalance(place, self._mean, weight, _MOVING * self.share * weight, 0.0)
        return found.sentence() if time - self._since > _MEAN and not found.holds else ""


def _force(model: Model, place: Array, tensions: Array) -> Array:
    """What the lines pull the platform with, (3,) N: along their chords, with half of their own weight."""
    taut, scene, spans, pulls = taut_at(model, place), model.robot.scene, model.lines.spans, model.lines.pulls
    weights = scene.gravity * np.array([line.cable.linear_density for line in model.robot.lines]) * taut.free
    up = -taut.toward[:, 2] / spans  # from the platform to the sheave
    middle = np.maximum(tensions - 0.5 * weights * up, 0.0)
    carried = 0.5 * float((pulls * weights).sum())
    return np.asarray(-((pulls / spans * middle) @ taut.toward) - np.array([0.0, 0.0, carried]))
