"""From lines that a lidar saw to where the platform is: constraints on x and y, and every pair of them solved.

Merlet and Papegay 2023, III.A: a wall that bounds y gives a C-type constraint, one that bounds x a D-type one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.room import Laser, Room
from cablewright.estimation.scan import Lidar
from cablewright.estimation.wall_lines import WallLine

__all__ = ["Candidate", "Constraint", "SeenLine", "candidates_of", "constraints_of", "judged", "wrapped"]

Array = NDArray[np.float64]

_LEAST_ANGLE: Final = math.radians(20.0)  # between the two walls of a candidate
_MOST_CANDIDATES: Final = 40


class SeenLine(NamedTuple):
    """A line as the platform sees it: of which lidar, in the platform's level frame."""

    lidar: int
    mount: Array  # (2,) m, of the lidar, level
    line: WallLine  # its angle in the platform frame

    @property
    def lever(self) -> float:
        """By how much more the platform point than the lidar is away from the line, m."""
        a = self.line.angle
        return float(math.cos(a) * self.mount[0] + math.sin(a) * self.mount[1])


class Constraint(NamedTuple):
    """One seen line taken for one wall: normal . (x, y) = offset, for the platform point."""

    kind: str  # "C" or "D"
    wall: int
    seen: int  # which line
    normal: tuple[float, float]
    offset: float  # m
    yaw: float  # rad, of the platform if the line is that wall
    yaw_sigma: float  # rad
    variance: float  # m^2, of the points' distances from the line: the paper's quality

    @property
    def coefficients(self) -> tuple[float, float, float]:
        """(a, b, c) of a x + b y + c = 0, with b = 1 for C and a = 1 for D, as the paper writes it."""
        lead = self.normal[1] if self.kind == "C" else self.normal[0]
        return self.normal[0] / lead, self.normal[1] / lead, -self.offset / lead


class Candidate(NamedTuple):
    """A place of the platform point by one C-type and one D-type constraint."""

    position: tuple[float, float]  # m
    yaw: float  # rad
    constraints: tuple[int, int]
    variance: float  # m^2, of both lines together
    explained: float  # share of the points on a wall less those beyond one; NaN if not looked at
    laser_misfit: float  # sigmas, the worst of the operator's distances; 0 without any


def wrapped(angle: float) -> float:
    """Return the angle within half a turn of 0."""
    return math.remainder(angle, math.tau)


def constraints_of(
    seen: Sequence[SeenLine], lidars: Sequence[Lidar], room: Room, yaws: tuple[float, float]
) -> list[Constraint]:
    """Take each line for each wall that it can be with a yaw from ``yaws[0]`` to ``yaws[1]``, rad."""
    found = []
    middle, half = 0.5 * (yaws[0] + yaws[1]), 0.5 * (yaws[1] - yaws[0])
    for i, one in enumerate(seen):
        line, sees = one.line, lidars[one.lidar].sees
        for j, wall in enumerate(room.walls):
            yaw = middle + wrapped(wall.azimuth - line.angle - middle)
            if abs(yaw - middle) > half or (sees is not None and wall.name not in sees):
                continue
            # n (p + R mount) + distance = d, and R turns the line's own normal to the wall's
            offset = wall.distance - line.distance - one.lever
            sigma = math.hypot(math.sqrt(line.covariance[0, 0]), wall.angle_sigma)
            found.append(Constraint(wall.kind, j, i, wall.normal, offset, yaw, sigma, line.variance))
    return found


def candidates_of(constraints: Sequence[Constraint], room: Room, agree: float, outside: float) -> list[Candidate]:
    """Solve each C with each D whose yaws agree within ``agree`` (rad) and three sigma.

    Places more than ``outside`` (m) beyond a wall are left out. Of many, those with the least variance are kept.
    """
    c = [i for i, one in enumerate(constraints) if one.kind == "C"]
    d = [i for i, one in enumerate(constraints) if one.kind == "D"]
    if not c or not d:
        return []
    pairs = np.array([(i, j) for i in c for j in d])
    normals = np.array([one.normal for one in constraints])
    offsets = np.array([one.offset for one in constraints])
    yaws = np.array([one.yaw for one in constraints])
    sigmas = np.array([one.yaw_sigma for one in constraints])
    variances = np.array([one.variance for one in constraints])
    i, j = pairs.T
    det = normals[i, 0] * normals[j, 1] - normals[i, 1] * normals[j, 0]
    turn = np.remainder(yaws[j] - yaws[i] + math.pi, math.tau) - math.pi
    good = (np.abs(det) > math.sin(_LEAST_ANGLE)) & (np.abs(turn) <= agree + 3.0 * np.hypot(sigmas[i], sigmas[j]))
    i, j, det, turn = i[good], j[good], det[good], turn[good]
    x = (offsets[i] * normals[j, 1] - offsets[j] * normals[i, 1]) / det
    y = (normals[i, 0] * offsets[j] - normals[j, 0] * offsets[i]) / det
    share = sigmas[i] ** 2 / np.maximum(sigmas[i] ** 2 + sigmas[j] ** 2, 1e-300)
    yaw = yaws[i] + share * turn
    place = np.stack([x, y], axis=1)
    within = np.all(place @ room.normals.T <= room.distances + outside, axis=1)
    both = variances[i] + variances[j]
    order = [k for k in np.argsort(both, kind="stable") if within[k]][:_MOST_CANDIDATES]
    return [
        Candidate((float(x[k]), float(y[k])), float(yaw[k]), (int(i[k]), int(j[k])), float(both[k]), math.nan, 0.0)
        for k in order
    ]


def judged(
    candidates: Sequence[Candidate],
    points: Sequence[tuple[Array, NDArray[np.bool_]]],
    room: Room,
    lasers: Sequence[Laser],
    near: float,
    recess: float,
) -> list[Candidate]:
    """Say of each candidate what share of the points it explains, and how well it fits the operator's distances.

    ``points``: (n, 2) m in the platform's level frame, of each lidar, with the walls (w,) that it can see. A point
    counts if it is within ``near`` (m) of a wall, and against if it is more than ``recess`` (m) beyond one.
    """
    if not candidates:
        return []
    place = np.array([one.position for one in candidates])  # (k, 2)
    yaw = np.array([one.yaw for one in candidates])
    c, s = np.cos(yaw), np.sin(yaw)
    turn = np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], axis=1)  # (k, 2, 2)
    score, total = np.zeros(len(candidates)), 0
    # n (p + R q) - d for each candidate, point and wall: first what does not depend on the point
    level = place @ room.normals.T - room.distances  # (k, w)
    turned = np.einsum("wi,kij->kwj", room.normals, turn)  # (k, w, 2)
    for xy, sees in points:
        off = turned @ xy.T + level[:, :, None]  # (k, w, n)
        on = np.any(np.abs(off[:, sees]) <= near, axis=1)
        beyond = np.any(off > recess, axis=1)
        score += np.count_nonzero(on & ~beyond, axis=1) - np.count_nonzero(beyond, axis=1)
        total += len(xy)
    misfit = np.zeros(len(candidates))
    for laser in lasers:
        j = room.index(laser.wall)
        sigma = math.hypot(laser.sigma, room.walls[j].distance_sigma)
        misfit = np.maximum(misfit, np.abs(level[:, j] + laser.distance) / sigma)
    return [
        one._replace(explained=float(score[k]) / max(total, 1), laser_misfit=float(misfit[k]))
        for k, one in enumerate(candidates)
    ]
