"""Balance of measured tensions and weight at the assumed pose: a test of the pose that needs no lengths.

A plane carries what is across it. Of a rigid platform moments count too, as forces at the arm of its farthest line.
Errors of opposing lines may exceed the weight of a light platform: what all tensions are
together is allowed for then.

It is coarse, as tensions are, but knows nothing of the lengths, so that it also sees what all of them agree on: a place
that was measured, or typed, wrong.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.plane import directions, projected
from cablewright.models.rotation import moved, placed
from cablewright.models.statics import Model
from cablewright.solvers.taut import taut_of

_ERROR: Final = 0.1  # of weight or tensions, that measured tensions which may be right leave
_STEP: Final = 1e-3  # m and rad, of a derivative
_MEAN: Final = 0.5  # s, over which forces of a platform that moves are averaged
_EVERY: Final = 0.05  # s
_MOVING: Final = 1.5  # times what is allowed at rest: it speeds up and slows down


@dataclass(frozen=True, eq=False)
class ForceBalance:
    """Balance of measured tensions. ``off``: (n,) N and N m, surplus over ``weight``, N. ``limit``: N, allowed size.

    ``arm``: m, at which moments count as forces; 0 of a point. ``reach``: m, the smallest error of position that the
    test is sure to detect; ``turn``: rad, that of a rotation of a rigid platform.
    """

    pose: Array
    off: Array
    weight: float
    limit: float
    reach: float
    arm: float = 0.0
    turn: float = np.inf

    @property
    def size(self) -> float:
        """Size of ``off``, N."""
        return float(np.linalg.norm(_as_forces(self.off, self.arm)))

    @property
    def holds(self) -> bool:
        """Whether measured tensions and weight balance, so that nothing contradicts the pose."""
        return self.size <= self.limit

    def sentence(self) -> str:
        """Sentence on the error of the balance, with numbers."""
        x, y, z = self.pose[:3].tolist()
        ways = ", ".join(f"{force:+.0f}" for force in self.off[:3].tolist())
        turns = ", ".join(f"{moment:+.0f}" for moment in self.off[3:].tolist())
        turning = f" and turn by {turns} N m" if turns else ""
        what = (
            f"the tensions do not fit the place {x:.2f}, {y:.2f}, {z:.2f} m: beyond the weight of {self.weight:.0f} N"
        )
        allowed = f"at most {self.limit:.0f} N is allowed (drives.tension_error)"
        pulls = f"the lines pull by {ways} N{turning}, {self.size:.0f} N"
        return f"{what} {pulls}; {allowed}: place, load or a tension is wrong"


def balance(
    model: Model, pose: Array, tensions: Array | Callable[[Array], Array], share: float, laid: float = 0.0
) -> ForceBalance:
    """Judge *tensions* (m,), N, at the sheaves, with the platform at *pose* (n,), m and rad.

    *share*: allowed deviation as a share of the platform's weight. A function gives those of a pose: lines on one drum
    share its torque by where they are thought to be. *laid*: kg that have left the model's platform.
    """

    def tensions_at(at: Array) -> Array:
        return tensions(at) if callable(tensions) else tensions

    held, arm = tensions_at(pose), model.robot.arm
    off = excess(model, pose, held, laid)
    free, slopes = directions(model.robot.platform.plane, model.n), []
    for way in free.T * _STEP:
        there, back = (_wrench(model, at, tensions_at(at)) for at in (moved(pose, way), moved(pose, -way)))
        slopes.append(_as_forces(projected(model.free_directions, there - back), arm) / (2.0 * _STEP))
    slope = np.column_stack(slopes)
    limit = share * _scale(model, held, laid)
    turns = free[3:].any(axis=0)
    reach, turn = (_reach(limit, slope[:, columns]) for columns in (~turns, turns))
    return ForceBalance(pose, off, weight_of(model, laid), limit, reach, arm, turn)


def _reach(limit: float, slope: Array) -> float:
    """How far to go by the *slope* (k, c) of forces, N by m or rad, until they change by twice the *limit*, N."""
    known = slope.size and np.isfinite(slope).all()
    softest = float(np.linalg.svd(slope, compute_uv=False)[-1]) if known else 0.0
    return 2.0 * limit / softest if softest > 0.0 else np.inf


def weight_of(model: Model, laid: float = 0.0) -> float:
    """Weight of the platform, N, from which *laid* kg have left."""
    return float(model.robot.scene.gravity * (model.robot.platform.mass - laid))


def cleared(
    model: Model,
    pose: Array,
    inferred: Array,
    measured: Array,
    limits: Array,
    laid: float = 0.0,
    beam: float | None = None,
) -> Array:
    """Return *inferred* tensions (m,), N, by the lengths, but those *measured* of lines that these clear.

    Measured tensions may be right if they carry a platform without *laid* kg at *pose* (n,): the error is at most 10 %
    of its weight, or of all tensions where lines pull against each other. They clear a line that is within its limit
    with as much to spare. A length of a stiff line that is wrong by 1 mm means tens of newtons. *beam*: m, of a
    platform that retracts.
    """
    off = _as_forces(excess(model, pose, measured, laid, beam), model.robot.arm)
    allowed = _ERROR * _scale(model, measured, laid)
    if not np.linalg.norm(off) <= allowed:
        return inferred
    return np.asarray(np.where(measured + allowed <= limits, measured, inferred))


def excess(model: Model, pose: Array, tensions: Array, laid: float = 0.0, beam: float | None = None) -> Array:
    """Return the surplus (n,), N and N m, of the lines' wrench over the weight of a platform without *laid* kg.

    In a plane along its free directions alone: the plane carries the rest. *beam*: m, of a platform that retracts.
    """
    weight, platform = weight_of(model, laid), model.robot.platform
    x, y, _ = (placed(pose, [platform.centre_of_mass])[0] - pose[:3]).tolist()
    down = np.array([0.0, 0.0, -weight, -y * weight, x * weight, 0.0])
    return projected(model.free_directions, _wrench(model, pose, tensions, beam) + down[: model.n])


@dataclass(eq=False)
class CarriedWatch:
    """Watch over whether the lines go on carrying the platform at its assumed position. Changed in place."""

    model: Model
    share: float  # of the weight, allowed
    _mean: Array | None = None  # (n,) N and N m
    _time: float = -math.inf  # s
    _since: float = 0.0  # s

    def forget(self) -> None:
        """Forget earlier judgements."""
        self._mean, self._time = None, -math.inf

    def is_due(self, time: float) -> bool:
        """Whether the next judgement is due: not every reading is judged."""
        return time - self._time >= _EVERY

    def judge(self, pose: Array, tensions: Array, time: float, laid: float = 0.0) -> str:
        """Return why the platform, without *laid* kg, cannot be at *pose* (n,) at *time*, s; empty: it can."""
        off = excess(self.model, pose, tensions, laid)
        if self._mean is None:
            self._mean, self._since = off, time
        else:
            self._mean = self._mean + (off - self._mean) * min((time - self._time) / _MEAN, 1.0)
        self._time = time
        limit = _MOVING * self.share * _scale(self.model, tensions, laid)
        found = ForceBalance(pose, self._mean, weight_of(self.model, laid), limit, 0.0, self.model.robot.arm)
        return found.sentence() if time - self._since > _MEAN and not found.holds else ""


def _scale(model: Model, tensions: Array, laid: float) -> float:
    """Return the force, N, of which the limit is a share.

    The weight, or the norm of all tensions where lines may pull against each other and it is larger.
    """
    opposed = model.robot.arm > 0.0 or model.robot.platform.plane is not None
    return max(weight_of(model, laid), float(np.linalg.norm(tensions)) if opposed else 0.0)


def _as_forces(wrench: Array, arm: float) -> Array:
    """Return a *wrench* (n,), N and N m, with its moments as forces, N, at an *arm*, m."""
    return np.asarray(np.concatenate([wrench[:3], wrench[3:] / arm]) if arm > 0.0 else wrench[:3])


def _wrench(model: Model, pose: Array, tensions: Array, beam: float | None = None) -> Array:
    """What the lines pull the platform with, (n,) N and N m: along their chords, with half of their own weight."""
    robot, spans, pulls, packed = model.robot, model.lines.spans, model.lines.pulls, model.packed
    if beam is not None:
        packed = packed._replace(lines=model.rows(retraction=np.array([beam])).lines[0])
    taut = taut_of(packed, pose)
    weights = robot.scene.gravity * np.array([line.cable.linear_density for line in robot.lines]) * taut.free
    up = -taut.toward[:, 2] / spans  # from the platform to the sheave
    middle = np.maximum(tensions - 0.5 * weights * up, 0.0)
    carried = 0.5 * pulls * weights
    x, y, _ = (placed(pose, [line.platform_point for line in robot.lines]) - pose[:3]).T
    down = np.array([0.0, 0.0, -carried.sum(), -(y @ carried), x @ carried, 0.0])
    return np.asarray(down[: model.n] - (pulls / spans * middle) @ taut.per_motion)
