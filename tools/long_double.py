"""Residuals of many claimed equilibria at once, in extended precision and by formulas that the kernels do not use.

Everything is read from the description of the robot and from what an answer states: pose, lengths, tensions, angles,
lengths of spans. The catenary is the textbook's, with its differences of hyperbolic arcs and roots; a test holds it to
50 digits. Arrays have one row for each answer, of robots with the same number of lines and of freedoms.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Eyelet, Line, RigidPlatform, UniversalJoint

Long = NDArray[np.longdouble]


@dataclass(frozen=True)
class Lines:
    """What robots say of their lines: points (N, m, 3), all else (N, m). Without a winch exit it is NaN."""

    exit_point: Long
    platform_point: Long
    winch_exit: Long
    radius: Long
    lever: Long
    lever_weight: Long
    lever_mass_centre: Long
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
        return cls(*(np.array(column, dtype=np.longdouble) for column in _columns(rows)))

    def repeated(self, times: int) -> Lines:
        """Return each row *times* times."""
        return Lines(*(np.repeat(getattr(self, field.name), times, axis=0) for field in fields(self)))


@dataclass(frozen=True)
class Claims:
    """What answers claim: poses (N, n); lengths, tensions (N, m); angles and lengths of the spans (N, m, 6)."""

    lines: Lines
    pose: Long
    load: Long  # (N, n): weight and external wrench, at the pose
    lengths: Long
    tensions: Long
    states: Long
    margin: NDArray[np.float64]

    @classmethod
    def of(cls, answers: Sequence[Equilibrium]) -> Claims:
        """Return what single *answers* claim, all of them OK."""
        pose = _long([answer.pose for answer in answers])
        return cls(
            Lines.of([answer.model for answer in answers]),
            pose,
            np.array([_load(a.model, rotation) for a, rotation in zip(answers, _rotations(pose), strict=True)]),
            _long([answer.lengths for answer in answers]),
            _long([answer.tensions for answer in answers]),
            _long([answer.states for answer in answers]),
            np.array([answer.margin() for answer in answers]),
        )


@dataclass(frozen=True)
class Residuals:
    """By how much claims miss, (N,) each.

    ``geometry``: ends of spans and lengths, over the size of the answer's lines; ``force``: unbalanced force, or moment
    over the longest arm, over the largest force at play; ``lever``: moment on a lever over tension and lever;
    ``limits``: by how much a tension is outside its limits, over the largest tension; ``slack``: by how much a line
    with no tension is too short for that, over its size; ``margin``: as the answer states it, N.
    """

    geometry: NDArray[np.float64]
    force: NDArray[np.float64]
    lever: NDArray[np.float64]
    limits: NDArray[np.float64]
    slack: NDArray[np.float64]
    margin: NDArray[np.float64]
    metres: NDArray[np.float64]  # the largest geometric miss


def _columns(rows: list[list[list[Any]]]) -> list[list[list[Any]]]:
    """Turn rows of lines of numbers into columns of rows of lines."""
    return [[[line[k] for line in row] for row in rows] for k in range(len(fields(Lines)))]


def _numbers(model: Model, line: Line) -> list[Any]:
    """The numbers of one line in the order of `Lines`."""
    sheave, law = line.sheave, model.fidelity.cable.value
    turns = not isinstance(sheave, Eyelet)
    joint = sheave if isinstance(sheave, UniversalJoint) else None
    stretch = 0.0 if law == "rigid" else np.longdouble(1) / np.longdouble(line.cable.stiffness)
    gravity = np.longdouble(model.robot.scene.gravity)
    limits = model.tension_limits or line.tension_limits
    return [
        line.exit_point,
        line.platform_point,
        (np.nan,) * 3 if line.winch_exit is None else line.winch_exit,
        sheave.radius if not isinstance(sheave, Eyelet) else 0.0,
        joint.lever if joint else sheave.radius if not isinstance(sheave, Eyelet) else 0.0,
        joint.lever_weight if joint else 0.0,
        joint.lever_mass_centre if joint else 0.0,
        -1.0 if turns and sheave.wrap == "under" else 1.0,
        0.0 if turns else 1.0,
        1.0 if joint else 0.0,
        line.dead_length,
        gravity * np.longdouble(line.cable.linear_density) if law == "catenary" else 0.0,
        stretch,
        stretch if line.dead_elastic else 0.0,
        stretch if line.arc_elastic else 0.0,
        *limits,
    ]


def _long(rows: Any) -> Long:
    return np.array(rows, dtype=np.longdouble)


def _rotations(pose: Long) -> Long:
    """Rotations (N, 3, 3) of poses (N, n): Rodrigues."""
    unit = np.broadcast_to(np.eye(3, dtype=np.longdouble), (len(pose), 3, 3)).copy()
    if pose.shape[1] == 3:
        return unit
    x, y, z = pose[:, 3:].T
    nil = np.zeros_like(x)
    cross = np.moveaxis(np.array([[nil, -z, y], [z, nil, -x], [-y, x, nil]]), 2, 0)
    angle = np.sqrt(x * x + y * y + z * z)[:, None, None]
    safe = np.where(angle > 0, angle, 1)
    square = np.einsum("nij,njk->nik", cross, cross)
    return np.where(angle > 0, unit + np.sin(safe) / safe * cross + 2 * (np.sin(safe / 2) / safe) ** 2 * square, unit)


def _load(model: Model, rotation: Long) -> Long:
    """Weight and external wrench (n,) at a rotation."""
    platform = model.robot.platform
    falls = _long([0, 0, -np.longdouble(platform.mass) * np.longdouble(model.robot.scene.gravity)])
    force = falls + _long(platform.force)
    if not isinstance(platform, RigidPlatform):
        return force
    centre = np.einsum("ij,j->i", rotation, _long(platform.centre_of_mass))
    return np.concatenate([force, np.cross(centre, falls) + _long(platform.moment)])


def span(H: Long, V: Long, L: Long, w: Long, stretch: Long) -> tuple[Long, Long]:
    """Return the end (x, z) of hanging spans that begin with the tension vectors (H, V), N: Irvine's catenary.

    asinh(a) - asinh(b) is taken as it stands where the cable turns much, as 2 atanh(w L / (T0 + T1)) where it does not
    and the difference would cancel.
    """
    end = V + w * L
    first, last = np.hypot(H, V), np.hypot(H, end)
    level = np.maximum(np.abs(H), np.longdouble(1e-4000))
    share = w * L / (first + last)
    bent = np.where(
        share > 0.5,
        np.arcsinh(end / level) - np.arcsinh(V / level),
        2 * np.arctanh(np.minimum(share, np.longdouble(0.75))),
    )
    heavy = np.where(w > 0, w, 1)
    swept = np.where(w > 0, bent / heavy, L / np.where(first > 0, first, 1))  # the integral of ds / T
    x = H * (L * stretch + swept)
    z = L * (V + end) * (stretch / 2 + 1 / (first + last))
    return x, z


def _extremes(H: Long, V: Long, carried: Long) -> tuple[Long, Long]:
    """Smallest and largest tension along spans."""
    end = V + carried
    first, last = np.hypot(H, V), np.hypot(H, end)
    lowest = np.where(V * end < 0, np.abs(H), np.minimum(first, last))
    return lowest, np.maximum(first, last)


def judge(claims: Claims, *, limited: bool = True) -> Residuals:
    """Return by how much *claims* miss; tensions are held to their limits where they are *limited*."""
    lines, T = claims.lines, claims.tensions
    taut = T > 0
    phi, _, free, dead, psi, beta = np.moveaxis(claims.states, 2, 0)
    rotation = _rotations(claims.pose)
    arms = np.einsum("nij,nkj->nki", rotation, lines.platform_point)
    if claims.pose.shape[1] == 3:
        arms = lines.platform_point
    away = claims.pose[:, None, :3] + arms - lines.exit_point
    reach = np.hypot(away[..., 0], away[..., 1])
    toward = away[..., :2] / np.where(reach > 0, reach, 1)[..., None]
    toward = np.where(reach[..., None] > 0, toward, _long([1, 0]))
    hasdead = np.isfinite(lines.winch_exit[..., 0])
    psi = np.where(hasdead, psi, -lines.side * np.longdouble(np.pi) / 2)
    beta = np.where(lines.joint > 0, beta, 0)
    turn = lines.side * lines.radius
    hub = lines.lever * np.cos(beta), lines.lever * np.sin(beta)
    H, V = T * np.cos(phi), T * np.sin(phi)
    x, z = span(H, V, free, lines.weight, lines.free_stretch)
    misses = [hub[0] - turn * np.sin(phi) + x - reach, hub[1] + turn * np.cos(phi) + z - away[..., 2]]
    size = np.maximum(np.hypot(reach, away[..., 2]), np.hypot(x, z))
    low, high = _extremes(H, V, lines.weight * free)
    moment = np.zeros_like(T)
    if hasdead.any():
        span_end = span(T * np.cos(psi), T * np.sin(psi), dead, lines.weight, lines.dead_stretch)
        from_exit = np.where(hasdead[..., None], lines.winch_exit - lines.exit_point, 0)
        along = np.where(
            lines.eyelet > 0,
            np.hypot(from_exit[..., 0], from_exit[..., 1]),
            (from_exit[..., :2] * toward).sum(-1),
        )
        for miss, axis in (
            (hub[0] + turn * np.sin(psi) + span_end[0] - along, 0),
            (hub[1] - turn * np.cos(psi) + span_end[1] - from_exit[..., 2], 1),
        ):
            del axis
            misses.append(np.where(hasdead, miss, 0))
        size = np.maximum(size, np.where(hasdead, np.hypot(along, from_exit[..., 2]), 0))
        low2, high2 = _extremes(T * np.cos(psi), T * np.sin(psi), lines.weight * dead)
        low, high = np.where(hasdead, np.minimum(low, low2), low), np.where(hasdead, np.maximum(high, high2), high)
        lever = np.where(lines.lever > 0, lines.lever, 1)
        pull_x, pull_z = np.cos(phi) + np.cos(psi), np.sin(phi) + np.sin(psi)
        falls = lines.lever_mass_centre * lines.lever_weight / (np.where(taut, T, 1) * lever)
        moment = np.abs(np.cos(beta) * pull_z - np.sin(beta) * pull_x - falls * np.cos(beta))
        moment = np.where((lines.joint > 0) & taut, moment, 0)
    arc = lines.radius * (lines.side * (psi - phi) + np.longdouble(np.pi)) / (1 + T * lines.arc_stretch)
    misses.append(free + np.where(hasdead, dead, lines.dead_length) + arc - claims.lengths)
    geometry = np.where(taut, np.max(np.abs(misses), axis=0), 0)
    chord = np.hypot(reach, away[..., 2]) 
    slack = np.where(taut | (lines.eyelet == 0) | hasdead, 0, chord + lines.dead_length - claims.lengths)
    force = np.stack([-H * toward[..., 0], -H * toward[..., 1], -(V + lines.weight * free)], axis=-1)
    force = np.where(taut[..., None], force, 0)
    left = claims.load[:, :3] + force.sum(1)
    scale = np.maximum(np.abs(claims.load[:, :3]).max(1), np.abs(force).max((1, 2)))
    unbalanced = np.abs(left).max(1)
    if claims.pose.shape[1] == 6:
        turning = claims.load[:, 3:] + np.cross(arms, force).sum(1)
        arm = np.linalg.norm(arms.astype(np.float64), axis=-1).max(1)
        unbalanced = np.maximum(unbalanced, np.abs(turning).max(1) / arm)
    outside = np.maximum(lines.least - low, high - lines.most) if limited else np.zeros_like(T)
    outside = np.where(taut, outside, np.where(lines.least > 0, lines.least, 0) if limited else 0)
    results = (
        (geometry / size).max(1),
        unbalanced / scale,
        moment.max(1),
        outside.max(1) / np.maximum(high.max(1), np.longdouble(1e-300)),
        (slack / size).max(1),
        claims.margin,
        geometry.max(1),
    )
    return Residuals(*(np.asarray(result, dtype=np.float64) for result in results))
