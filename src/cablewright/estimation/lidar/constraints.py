"""From the lines in lidar scans to candidate positions: constraints on x and y, and the solution of every pair.

Merlet and Papegay 2023, III.A: a wall that bounds y gives a C-type constraint, one that bounds x a D-type one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from cablewright.estimation.lidar.room import Laser, RoomMap
from cablewright.estimation.lidar.wall_lines import LidarTurn
from cablewright.foundation.arrays import Array, Indices, Mask
from cablewright.kernels.fitting.walls_seen import explain
from cablewright.models.rotation import wrap_angle, wrap_angles

_MIN_ANGLE: Final = math.radians(20.0)  # between the two walls of a candidate
_MAX_CANDIDATES: Final = 40
_FACING: Final = 0.9999  # cosine between the normals of walls that face each other
_SAME_YAW: Final = math.radians(1.0)
_MAX_CONTRADICTION: Final = 0.5  # m; more is another object


class Constraint(NamedTuple):
    """One scanned line matched with one wall: normal . (x, y) = offset, for the platform point."""

    kind: str  # "C" or "D"
    wall: int  # index
    line: int  # index, among those of all turns
    normal: tuple[float, float]
    offset: float  # m
    yaw: float  # rad, of the platform
    yaw_sigma: float  # rad
    variance: float  # m^2, of the points' distances from the line: the paper's quality


class Candidate(NamedTuple):
    """A pose of the platform by one C-type and one D-type constraint."""

    position: tuple[float, float]  # m
    yaw: float  # rad
    constraints: tuple[int, int]
    variance: float  # m^2, of both lines together
    explained: float  # share of the points on a wall less those beyond one; NaN if not scored
    laser_misfit: float  # sigmas, largest of the operator's distances; 0 without any


class Candidates(NamedTuple):
    """Candidate poses of the platform, k of them, as arrays."""

    position: Array  # (k, 2) m
    yaw: Array  # (k,) rad
    constraints: Indices  # (k, 2)
    variance: Array  # (k,) m^2
    explained: Array  # (k,); NaN if not scored
    laser_misfit: Array  # (k,) sigmas; 0 without any

    def select(self, which: Indices) -> Candidates:
        """Return the candidates of those indices, in that order."""
        first = self.position[which], self.yaw[which], self.constraints[which]
        return Candidates(*first, self.variance[which], self.explained[which], self.laser_misfit[which])

    def as_tuple(self) -> tuple[Candidate, ...]:
        """Return each as a `Candidate`."""
        position, yaw, constraints, *rest = (column.tolist() for column in self)
        return tuple(map(Candidate, map(tuple, position), yaw, map(tuple, constraints), *rest))


def find_constraints(
    turns: Sequence[LidarTurn], visible: Mask, room: RoomMap, yaws: tuple[float, float]
) -> list[Constraint]:
    """Match each scanned line with each wall that it can be at a yaw from ``yaws[0]`` to ``yaws[1]``, rad.

    *turns*: lidar scans. ``visible``: (l, w), which walls each lidar can see.
    """
    found, first = [], 0
    middle, half = 0.5 * (yaws[0] + yaws[1]), 0.5 * (yaws[1] - yaws[0])
    walls, rows = list(zip(room.walls, room.azimuths.tolist(), strict=True)), visible.tolist()
    for turn in turns:
        (x, y), row = turn.mount.tolist(), rows[turn.lidar]
        sigmas = np.sqrt(turn.covariances[:, 0, 0])
        each = zip(*(one.tolist() for one in (turn.angles, turn.distances, turn.variances, sigmas)), strict=True)
        for i, (angle, distance, variance, line_sigma) in enumerate(each, first):
            lever = math.cos(angle) * x + math.sin(angle) * y  # of the platform point's distance less the lidar's
            for j, (wall, azimuth) in enumerate(walls):
                yaw = middle + wrap_angle(azimuth - angle - middle)
                if abs(yaw - middle) > half or not row[j]:
                    continue
                # n (p + R mount) + distance = d, and R turns the line's own normal to the wall's
                offset, sigma = wall.distance - distance - lever, math.hypot(line_sigma, wall.angle_sigma)
                found.append(Constraint(wall.kind, j, i, wall.normal, offset, yaw, sigma, variance))
        first += len(turn)
    return found


def contradicting_walls(constraints: Sequence[Constraint], room: RoomMap, gate: float) -> str:
    """Return a sentence on two facing walls whose distance the survey has wrong by over *gate*, m; empty: none.

    Lines at one yaw that may be both walls are compared; the pair that agrees best counts.
    """
    best: dict[tuple[int, int], float] = {}
    for one in constraints:
        for other in constraints:
            facing = one.wall < other.wall and np.dot(one.normal, other.normal) < -_FACING
            if facing and abs(wrap_angle(one.yaw - other.yaw)) < _SAME_YAW:
                off, walls = one.offset + other.offset, (one.wall, other.wall)
                best[walls] = min(off, best.get(walls, math.inf), key=abs)
    wrong = {walls: off for walls, off in best.items() if gate < abs(off) < _MAX_CONTRADICTION}
    if not wrong:
        return ""
    (a, b), off = max(wrong.items(), key=lambda each: abs(each[1]))
    apart = room.walls[a].distance + room.walls[b].distance
    names = f"walls {room.walls[a].name!r} and {room.walls[b].name!r}"
    nearer = ", or something stands before one of them" if off > 0.0 else ""
    return f"{names} are {apart - off:.3f} m apart as they are seen, {apart:.3f} m by the survey{nearer}"


def find_candidates(
    constraints: Sequence[Constraint], room: RoomMap, yaw_tolerance: float, margin: float
) -> Candidates:
    """Solve each C-type with each D-type constraint whose yaws agree within ``yaw_tolerance`` (rad) and three sigma.

    Positions more than ``margin`` (m) beyond a wall are rejected. At most 40, with the smallest variance, are kept.
    """
    c = [i for i, one in enumerate(constraints) if one.kind == "C"]
    d = [i for i, one in enumerate(constraints) if one.kind == "D"]
    if not c or not d:
        return Candidates(np.empty((0, 2)), np.empty(0), np.empty((0, 2), np.intp), *np.empty((3, 0)))
    normals, offsets, yaws, sigmas, variances = map(np.array, list(zip(*constraints, strict=True))[3:])
    i, j = np.repeat(c, len(d)), np.tile(d, len(c))
    det = normals[i, 0] * normals[j, 1] - normals[i, 1] * normals[j, 0]
    turn = wrap_angles(yaws[j] - yaws[i])
    tolerance = yaw_tolerance + 3.0 * np.hypot(sigmas[i], sigmas[j])
    good = (np.abs(det) > math.sin(_MIN_ANGLE)) & (np.abs(turn) <= tolerance)
    i, j, det, turn = i[good], j[good], det[good], turn[good]
    x = (offsets[i] * normals[j, 1] - offsets[j] * normals[i, 1]) / det
    y = (normals[i, 0] * offsets[j] - normals[j, 0] * offsets[i]) / det
    share = sigmas[i] ** 2 / np.maximum(sigmas[i] ** 2 + sigmas[j] ** 2, 1e-300)
    positions, variance = np.stack([x, y], axis=1), variances[i] + variances[j]
    within = np.all(positions @ room.normals.T <= room.distances + margin, axis=1)
    order = np.argsort(variance, kind="stable")
    order = order[within[order]][:_MAX_CANDIDATES]
    unscored = np.full(len(order), math.nan), np.zeros(len(order))
    pairs = np.stack([i, j], axis=1)[order]
    return Candidates(positions[order], (yaws[i] + share * turn)[order], pairs, variance[order], *unscored)


def score_candidates(
    candidates: Candidates,
    points: Sequence[tuple[Array, Mask]],
    room: RoomMap,
    lasers: Sequence[Laser],
    near_distance: float,
    recess: float,
) -> Candidates:
    """Return, for each of the *candidates* (poses), the share of points on walls and the misfit to laser distances.

    ``points``: of each lidar, (n, 2) m in the platform's level frame, with the walls (w,) that the lidar can see. A
    point within ``near_distance`` (m) of a wall counts for a candidate. A point more than ``recess`` (m) beyond a wall
    counts against. The operator enters the distances of ``lasers``.
    """
    c, s = np.cos(candidates.yaw)[:, None], np.sin(candidates.yaw)[:, None]
    x, y = room.normals.T
    # n (p + R q) - d for each candidate, point and wall: first what does not depend on the point
    level = candidates.position @ room.normals.T - room.distances  # (k, w)
    normals = np.stack([c * x + s * y, c * y - s * x], axis=-1)  # (k, w, 2)
    score = np.zeros(len(level))
    for xy, visible in points:
        columns, work = np.ascontiguousarray(xy.T), np.empty((2, len(xy)))
        explain(normals, level, columns, visible, float(near_distance), float(recess), work, score)
    misfit = candidates.laser_misfit
    for laser in lasers:
        j = room.index(laser.wall)
        sigma = math.hypot(laser.sigma, room.walls[j].distance_sigma)
        misfit = np.maximum(misfit, np.abs(level[:, j] + laser.distance) / sigma)
    total = sum(len(xy) for xy, _ in points)
    return candidates._replace(explained=score / max(total, 1), laser_misfit=misfit)
