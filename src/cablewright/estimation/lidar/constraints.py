"""From lines that a lidar saw to where the platform is: constraints on x and y, and every pair of them solved.

Merlet and Papegay 2023, III.A: a wall that bounds y gives a C-type constraint, one that bounds x a D-type one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.lidar.room import Laser, RoomMap
from cablewright.estimation.lidar.wall_lines import WallLine
from cablewright.kernels.fitting.scan_lines import explain

__all__ = [
    "Candidate",
    "Candidates",
    "Constraint",
    "SeenLine",
    "all_wrapped",
    "candidates_of",
    "constraints_of",
    "judged",
    "wrapped",
]

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Bools = NDArray[np.bool_]

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


def all_wrapped(angles: Array) -> Array:
    """Return the angles within half a turn of 0."""
    return np.asarray(np.remainder(angles + math.pi, math.tau) - math.pi)


class Candidates(NamedTuple):
    """k candidates as arrays; `told` makes `Candidate`s of them."""

    position: Array  # (k, 2) m
    yaw: Array  # (k,) rad
    constraints: Index  # (k, 2)
    variance: Array  # (k,) m^2
    explained: Array  # (k,); NaN if not looked at
    laser_misfit: Array  # (k,) sigmas; 0 without any

    def chosen(self, which: Index) -> Candidates:
        """Return those of them, in that order."""
        first = self.position[which], self.yaw[which], self.constraints[which]
        return Candidates(*first, self.variance[which], self.explained[which], self.laser_misfit[which])

    def told(self) -> tuple[Candidate, ...]:
        """Return them one by one."""
        position, yaw, constraints, *rest = (column.tolist() for column in self)
        return tuple(map(Candidate, map(tuple, position), yaw, map(tuple, constraints), *rest))


def constraints_of(seen: Sequence[SeenLine], sees: Bools, room: RoomMap, yaws: tuple[float, float]) -> list[Constraint]:
    """Take each line for each wall that it can be with a yaw from ``yaws[0]`` to ``yaws[1]``, rad.

    ``sees``: (l, w), which walls each lidar can see.
    """
    found = []
    middle, half = 0.5 * (yaws[0] + yaws[1]), 0.5 * (yaws[1] - yaws[0])
    walls, visible = list(zip(room.walls, room.azimuths.tolist(), strict=True)), sees.tolist()
    for i, one in enumerate(seen):
        line, lever, can = one.line, one.lever, visible[one.lidar]
        line_sigma = math.sqrt(line.covariance[0, 0])
        for j, (wall, azimuth) in enumerate(walls):
            yaw = middle + wrapped(azimuth - line.angle - middle)
            if abs(yaw - middle) > half or not can[j]:
                continue
            # n (p + R mount) + distance = d, and R turns the line's own normal to the wall's
            offset, sigma = wall.distance - line.distance - lever, math.hypot(line_sigma, wall.angle_sigma)
            found.append(Constraint(wall.kind, j, i, wall.normal, offset, yaw, sigma, line.variance))
    return found


def candidates_of(constraints: Sequence[Constraint], room: RoomMap, agree: float, outside: float) -> Candidates:
    """Solve each C with each D whose yaws agree within ``agree`` (rad) and three sigma.

    Places more than ``outside`` (m) beyond a wall are left out. Of many, those with the least variance are kept.
    """
    c = [i for i, one in enumerate(constraints) if one.kind == "C"]
    d = [i for i, one in enumerate(constraints) if one.kind == "D"]
    if not c or not d:
        return Candidates(np.empty((0, 2)), np.empty(0), np.empty((0, 2), np.intp), *np.empty((3, 0)))
    normals, offsets, yaws, sigmas, variances = map(np.array, list(zip(*constraints, strict=True))[3:])
    i, j = np.repeat(c, len(d)), np.tile(d, len(c))
    det = normals[i, 0] * normals[j, 1] - normals[i, 1] * normals[j, 0]
    turn = all_wrapped(yaws[j] - yaws[i])
    good = (np.abs(det) > math.sin(_LEAST_ANGLE)) & (np.abs(turn) <= agree + 3.0 * np.hypot(sigmas[i], sigmas[j]))
    i, j, det, turn = i[good], j[good], det[good], turn[good]
    x = (offsets[i] * normals[j, 1] - offsets[j] * normals[i, 1]) / det
    y = (normals[i, 0] * offsets[j] - normals[j, 0] * offsets[i]) / det
    share = sigmas[i] ** 2 / np.maximum(sigmas[i] ** 2 + sigmas[j] ** 2, 1e-300)
    place, both = np.stack([x, y], axis=1), variances[i] + variances[j]
    within = np.all(place @ room.normals.T <= room.distances + outside, axis=1)
    order = np.argsort(both, kind="stable")
    order = order[within[order]][:_MOST_CANDIDATES]
    unjudged = np.full(len(order), math.nan), np.zeros(len(order))
    pairs = np.stack([i, j], axis=1)[order]
    return Candidates(place[order], (yaws[i] + share * turn)[order], pairs, both[order], *unjudged)


def judged(
    candidates: Candidates,
    points: Sequence[tuple[Array, Bools]],
    room: RoomMap,
    lasers: Sequence[Laser],
    near: float,
    recess: float,
) -> Candidates:
    """Say of each candidate what share of the points it explains, and how well it fits the operator's distances.

    ``points``: (n, 2) m in the platform's level frame, of each lidar, with the walls (w,) that it can see. A point
    counts if it is within ``near`` (m) of a wall, and against if it is more than ``recess`` (m) beyond one.
    """
    c, s = np.cos(candidates.yaw)[:, None], np.sin(candidates.yaw)[:, None]
    x, y = room.normals.T
    # n (p + R q) - d for each candidate, point and wall: first what does not depend on the point
    level = candidates.position @ room.normals.T - room.distances  # (k, w)
    turned = np.stack([c * x + s * y, c * y - s * x], axis=-1)  # (k, w, 2)
    score = np.zeros(len(level))
    for xy, sees in points:
        explain(
            turned, level, np.ascontiguousarray(xy.T), sees, float(near), float(recess), np.empty((2, len(xy))), score
        )
    misfit = candidates.laser_misfit
    for laser in lasers:
        j = room.index(laser.wall)
        sigma = math.hypot(laser.sigma, room.walls[j].distance_sigma)
        misfit = np.maximum(misfit, np.abs(level[:, j] + laser.distance) / sigma)
    total = sum(len(xy) for xy, _ in points)
    return candidates._replace(explained=score / max(total, 1), laser_misfit=misfit)
