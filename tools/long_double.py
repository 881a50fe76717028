"""Residuals of many claimed equilibria at once, in extended precision and by formulas that the kernels do not use.

All is read from the description of the robot and from an answer: pose, lengths, tensions, angles, lengths
of spans. Where NumPy's long double is a plain double the residuals are no finer than the answers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Eyelet, Line, RigidPlatform, Swivel, UniversalJoint

Long = NDArray[np.longdouble]
PI = np.arctan2(np.longdouble(0), np.longdouble(-1))
LEAST = np.longdouble("1e-300")  # divides in place of 0


@dataclass(frozen=True)
class Lines:
    """What robots say of their lines: points (N, m, 3), all else (N, m). Without a winch exit that is NaN."""

    exit_point: Long
    platform_point: Long
    winch_exit: Long
    radius: Long
    lever: Long
    lever_moment: Long
    side: Long
    eyelet: Long
    joint: Long
    dead_length: Long
    weight: Long
    free_stretch: Long  # 1 / EA
    dead_stretch: Long
    arc_stretch: Long
    least: Long
    most: Long

    @classmethod
    def of(cls, models: Sequence[Model]) -> Lines:
        """Return the numbers of the lines of *models*, one row each."""
        rows = [[_numbers(model, line) for line in model.robot.lines] for model in models]
        return cls(*(_long([[line[k] for line in row] for row in rows]) for k in range(len(fields(cls)))))


@dataclass(frozen=True)
class Claims:
    """What answers claim: poses (N, n), lengths and tensions (N, m), states of lines (N, m, 6); and the load (N, n)."""

    lines: Lines
    pose: Long
    load: Long
    lengths: Long
    tensions: Long
    states: Long

    @classmethod
    def of(cls, answers: Sequence[Equilibrium]) -> Claims:
        """Return what single *answers* claim, all of them OK, of robots with as many lines and degrees of freedom."""
        pose = _long([answer.pose for answer in answers])
        loads = [_load(answer.model, turned) for answer, turned in zip(answers, _rotations(pose), strict=True)]
        parts = ([getattr(answer, key) for answer in answers] for key in ("lengths", "tensions", "states"))
        return cls(Lines.of([answer.model for answer in answers]), pose, np.array(loads), *map(_long, parts))


@dataclass(frozen=True)
class Residuals:
    """By how much claims miss, (N,) each."""

    metres: Array  # ends of spans and lengths, m; of a line without tension by how much it is too short for that
    geometry: Array  # the same over the size of the line
    force: Array  # unbalanced force, or moment over the longest arm, over the largest force at play
    lever: Array  # moment on a lever, over lever and the larger of tension and lever's weight
    limits: Array  # by how much a tension is outside its limits, over the largest tension


class _Spans(NamedTuple):
    """One span of each line: by how much its end misses in x and z (m), its size (m), its extremes of tension (N)."""

    x: Long
    z: Long
    size: Long
    low: Long
    high: Long


def judge(claims: Claims) -> Residuals:
    """Return by how much *claims* miss."""
    lines, T = claims.lines, claims.tensions
    phi, _, free, dead, psi, beta = np.moveaxis(claims.states, 2, 0)
    arms, away = _placed(claims)
    reach = np.hypot(away[..., 0], away[..., 1])
    toward = np.where(reach[..., None] > 0, away[..., :2] / np.maximum(reach, LEAST)[..., None], _long([1, 0]))
    modelled = np.isfinite(lines.winch_exit[..., 0])
    psi = np.where(modelled, psi, -lines.side * PI / 2)
    beta = np.where(lines.joint > 0, beta, 0)
    spans = [_span(lines, T, phi, free, beta, lines.free_stretch, (reach, away[..., 2]), lines.side)]
    if modelled.any():
        there = _winch(lines, toward)
        dead_span = _span(lines, T, psi, dead, beta, lines.dead_stretch, there, -lines.side)
        spans.append(_Spans(*(np.where(modelled, b, a) for a, b in zip(_nothing(spans[0]), dead_span, strict=True))))
    arc = lines.radius * (lines.side * (psi - phi) + PI) / (1 + T * lines.arc_stretch)
    over = free + np.where(modelled, dead, lines.dead_length) + arc - claims.lengths
    misses = [np.abs(miss) for each in spans for miss in (each.x, each.z)]
    miss = np.max([*misses, np.where(T > 0, np.abs(over), np.maximum(over, 0))], axis=0)
    miss = np.where((T > 0) | (lines.weight == 0), miss, np.inf)  # a line with weight has tension
    low, high = np.min([each.low for each in spans], axis=0), np.max([each.high for each in spans], axis=0)
    outside = np.maximum(lines.least - low, high - lines.most).max(1)
    H, V = T * np.cos(phi), T * np.sin(phi) + np.where(T > 0, lines.weight * free, 0)
    found = (
        miss.max(1),
        (miss / np.max([each.size for each in spans], axis=0)).max(1),
        _unbalanced(claims, arms, np.stack([-H * toward[..., 0], -H * toward[..., 1], -V], axis=-1)),
        _on_levers(lines, T, phi, psi, beta),
        np.maximum(outside, 0) / np.maximum(high.max(1), LEAST),
    )
    return Residuals(*(np.asarray(each, dtype=np.float64) for each in found))


def span(H: Long, V: Long, L: Long, w: Long, stretch: Long) -> tuple[Long, Long]:
    """Return the end (x, z) of hanging spans that begin with the tension vectors (H, V), N: Irvine's catenary.

    Its asinh(b) - asinh(a) is taken as it stands where the cable turns much, and as 2 atanh(w L / (T0 + T1)) where it
    turns little and the difference would cancel.
    """
    end = V + w * L
    first, last = np.hypot(H, V), np.hypot(H, end)
    both, level = np.maximum(first + last, LEAST), np.maximum(np.abs(H), LEAST)
    share = w * L / both
    bent = np.arcsinh(end / level) - np.arcsinh(V / level)
    bent = np.where(share > 0.5, bent, 2 * np.arctanh(np.minimum(share, 0.75)))
    swept = np.where(w > 0, bent / np.where(w > 0, w, 1), L / np.maximum(first, LEAST))  # the integral of ds / T
    return H * (L * stretch + swept), L * (V + end) * (stretch / 2 + 1 / both)


def _numbers(model: Model, line: Line) -> list[Any]:
    """The numbers of one line in the order of `Lines`."""
    sheave, law = line.sheave, model.fidelity.cable.value
    joint = sheave if isinstance(sheave, UniversalJoint) else None
    radius = 0.0 if isinstance(sheave, Eyelet) else sheave.radius
    stretch = 0.0 if law == "rigid" else 1 / np.longdouble(line.cable.stiffness)
    weight = np.longdouble(model.robot.scene.gravity) * np.longdouble(line.cable.linear_density)
    return [
        line.exit_point,
        line.platform_point,
        (np.nan,) * 3 if line.winch_exit is None else line.winch_exit,
        radius,
        joint.lever if joint else radius,
        np.longdouble(joint.lever_weight) * np.longdouble(joint.lever_mass_centre) if joint else 0.0,
        -1.0 if isinstance(sheave, Swivel | UniversalJoint) and sheave.wrap == "under" else 1.0,
        float(isinstance(sheave, Eyelet)),
        float(joint is not None),
        line.dead_length,
        weight if law == "catenary" else 0.0,
        stretch,
        stretch if line.dead_elastic else 0.0,
        stretch if line.arc_elastic else 0.0,
        *(model.tension_limits or line.tension_limits),
    ]


def _long(rows: Any) -> Long:
    return np.array(rows, dtype=np.longdouble)


def _rotations(pose: Long) -> Long:
    """Rotations (N, 3, 3) of poses (N, n): Rodrigues."""
    unit = np.broadcast_to(np.eye(3, dtype=np.longdouble), (len(pose), 3, 3))
    if pose.shape[1] == 3:
        return unit
    x, y, z = pose[:, 3:].T
    nil = np.zeros_like(x)
    cross = np.moveaxis(np.array([[nil, -z, y], [z, nil, -x], [-y, x, nil]]), 2, 0)
    angle = np.maximum(np.sqrt(x * x + y * y + z * z), LEAST)[:, None, None]
    return np.asarray(unit + np.sin(angle) / angle * cross + 2 * (np.sin(angle / 2) / angle) ** 2 * (cross @ cross))


def _load(model: Model, rotation: Long) -> Long:
    """Weight and external wrench (n,) on a platform that is turned."""
    platform = model.robot.platform
    falls = _long([0, 0, -np.longdouble(platform.mass) * np.longdouble(model.robot.scene.gravity)])
    force = falls + _long(platform.force)
    if not isinstance(platform, RigidPlatform):
        return force
    return np.concatenate([force, np.cross(rotation @ _long(platform.centre_of_mass), falls) + _long(platform.moment)])


def _placed(claims: Claims) -> tuple[Long, Long]:
    """Arms (N, m, 3) of the lines on the platform, and where their platform points are from their exit points."""
    arms = claims.lines.platform_point
    if claims.pose.shape[1] == 6:
        arms = np.einsum("nij,nkj->nki", _rotations(claims.pose), arms)
    return arms, claims.pose[:, None, :3] + arms - claims.lines.exit_point


def _winch(lines: Lines, toward: Long) -> tuple[Long, Long]:
    """Winch exit points (x, z) from the exit points; an eyelet's dead span has a plane of its own."""
    away = lines.winch_exit - lines.exit_point
    own = np.hypot(away[..., 0], away[..., 1])
    return np.where(lines.eyelet > 0, own, (away[..., :2] * toward).sum(-1)), away[..., 2]


def _span(
    lines: Lines,
    T: Long,
    angle: Long,
    L: Long,
    beta: Long,
    stretch: Long,
    there: tuple[Long, Long],
    side: Long,
) -> _Spans:
    """Spans that leave their sheaves at *angle* and should end *there*; straight where there is no tension."""
    taut = T > 0
    pull, w = np.where(taut, T, 1), np.where(taut, lines.weight, 0)
    H, V = pull * np.cos(angle), pull * np.sin(angle)
    x, z = span(H, V, L, w, np.where(taut, stretch, 0))
    x += lines.lever * np.cos(beta) - side * lines.radius * np.sin(angle) - there[0]
    z += lines.lever * np.sin(beta) + side * lines.radius * np.cos(angle) - there[1]
    first, last = np.hypot(H, V), np.hypot(H, V + w * L)
    low = np.where(V * (V + w * L) < 0, np.abs(H), np.minimum(first, last))
    return _Spans(x, z, np.hypot(*there), np.where(taut, low, 0), np.where(taut, np.maximum(first, last), 0))


def _nothing(beside: _Spans) -> _Spans:
    """Spans that are not modelled: they miss nothing, and their tensions are those beside the sheave."""
    nil = np.zeros_like(beside.x)
    return _Spans(nil, nil, nil, beside.low, beside.high)


def _unbalanced(claims: Claims, arms: Long, forces: Long) -> Long:
    """Unbalanced force on each platform over the largest force, for *forces* (N, m, 3) of the lines."""
    left = np.abs(claims.load[:, :3] + forces.sum(1)).max(1)
    if claims.pose.shape[1] == 6:
        turning = claims.load[:, 3:] + np.cross(arms, forces).sum(1)
        longest = np.sqrt((arms * arms).sum(-1)).max(1)
        left = np.maximum(left, np.abs(turning).max(1) / longest)
    return np.asarray(left / np.maximum(np.abs(claims.load[:, :3]).max(1), np.abs(forces).max((1, 2))))


def _on_levers(lines: Lines, T: Long, phi: Long, psi: Long, beta: Long) -> Long:
    """The largest moment on a lever, over lever and the larger of tension and lever's weight."""
    lever = np.where(lines.joint > 0, lines.lever, 1)
    falls = lines.lever_moment / lever
    up, out = T * (np.sin(phi) + np.sin(psi)), T * (np.cos(phi) + np.cos(psi))
    moment = np.abs(np.cos(beta) * (up - falls) - np.sin(beta) * out) / np.maximum(np.maximum(T, falls), LEAST)
    return np.asarray(np.where((lines.joint > 0) & (T > 0), moment, 0).max(1))
