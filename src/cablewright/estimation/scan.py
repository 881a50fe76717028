"""One turn of a planar lidar: what the unit is, and the points it saw, made level."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.errors import InputError

__all__ = ["Lidar", "Points", "level_mount", "noise_of", "points_of"]

Array = NDArray[np.float64]

_MEDIAN_OF_NORMAL = 0.6745  # of the size of a normal number, in sigmas


@dataclass(frozen=True)
class Lidar:
    """A planar lidar on the platform; the defaults are an RPLIDAR A1M8's, as Merlet and Papegay 2023 give them.

    ``mount``: (3,) m, from the platform point to its centre, platform frame. ``yaw``: rad, where its angle 0 points in
    the platform frame. ``least`` and ``most``: m, its range. ``sigma``: m, of one range; ``angle_sigma``: rad, of one
    bearing; ``bias_sigma``: m, of what all ranges of this unit are off alike. ``masked``: bearings (from, to), rad,
    counter-clockwise, at which the platform itself is seen. ``sees``: names of the walls that it can see; None: any.
    """

    name: str = "lidar"
    mount: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.0
    least: float = 0.15
    most: float = 12.0
    sigma: float = 2e-3
    angle_sigma: float = 0.0
    bias_sigma: float = 2e-3
    masked: tuple[tuple[float, float], ...] = ()
    sees: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        if not (0 <= self.least < self.most < math.inf and 0 < self.sigma < math.inf):
            raise InputError(
                f"lidar {self.name!r}: 0 <= least < most and sigma over 0 are wanted, "
                f"not {self.least:g}, {self.most:g} and {self.sigma:g}"
            )


class Points(NamedTuple):
    """The points of one turn in the order of their bearing, from the widest gap on; level, in the lidar's frame."""

    xy: Array  # (n, 2) m
    ray: Array  # (n, 2) unit, from the lidar to the point
    distance: Array  # (n,) m
    step: Array  # (n,) rad, bearing from this point to the next; of the last one to the first, a turn on

    def __len__(self) -> int:
        return len(self.xy)


def points_of(lidar: Lidar, angles: ArrayLike, ranges: ArrayLike, tilt: tuple[float, float] = (0.0, 0.0)) -> Points:
    """Return the points of a scan that count: finite, within the unit's range, not on the platform.

    ``angles``: (n,) rad, counter-clockwise; ``ranges``: (n,) m, 0 or not finite where nothing came back. ``tilt``: rad,
    rotation vector (x, y) of the platform frame by which the level one became the real one; points are made level.

    Raises `InputError` unless both are one-dimensional and as long as each other.
    """
    a, r = np.asarray(angles, dtype=np.float64), np.asarray(ranges, dtype=np.float64)
    if a.ndim != 1 or a.shape != r.shape:
        raise InputError(f"scan: as many angles as ranges are wanted, not shapes {a.shape} and {r.shape}")
    with np.errstate(invalid="ignore"):
        good = np.isfinite(a) & (r >= lidar.least) & (r <= lidar.most)
        for begin, end in lidar.masked:
            good &= ~((a - begin) % math.tau <= (end - begin) % math.tau)
    a, r = a[good] % math.tau, r[good]
    order = np.argsort(a, kind="stable")
    a, r = a[order], r[order]
    step = np.diff(a, append=a[:1] + math.tau)
    if len(a):
        first = int(step.argmax()) + 1
        a, r, step = np.roll(a, -first), np.roll(r, -first), np.roll(step, -first)
    ray = np.stack([np.cos(a), np.sin(a)], axis=1)
    if tilt == (0.0, 0.0):
        return Points(r[:, None] * ray, ray, r, step)
    c, s = math.cos(lidar.yaw), math.sin(lidar.yaw)
    turn = _turn((c * tilt[0] + s * tilt[1], c * tilt[1] - s * tilt[0]))
    xy = r[:, None] * ray @ turn[:2, :2].T
    level = np.hypot(xy[:, 0], xy[:, 1])
    return Points(xy, xy / level[:, None], level, step)


def noise_of(points: Points, least: float = 5e-4, most: float = 0.05) -> float:
    """Return the sigma of one range (m) from how much ranges bend between neighbours, within ``least`` and ``most``.

    Half of all bends decide, so corners and things in the way do not count. Straight walls bend ranges too, but seen in
    steps of a degree or less by fractions of a millimetre.
    """
    if len(points) < 3:
        return least
    bend = np.abs(np.diff(points.distance, 2))
    return float(np.clip(np.median(bend) / (_MEDIAN_OF_NORMAL * math.sqrt(6.0)), least, most))


def level_mount(lidar: Lidar, tilt: tuple[float, float] = (0.0, 0.0)) -> Array:
    """(2,) m: where the lidar's centre is from the platform point, seen from above, platform frame without its tilt."""
    mount: Array = (_turn(tilt) @ np.array(lidar.mount))[:2]
    return mount


def _turn(tilt: tuple[float, float]) -> Array:
    """(3, 3): the rotation by a level rotation vector."""
    angle = math.hypot(*tilt)
    if angle < 1e-300:
        return np.eye(3)
    x, y = tilt[0] / angle, tilt[1] / angle
    c, s = math.cos(angle), math.sin(angle)
    return np.array(
        [
            [c + x * x * (1 - c), x * y * (1 - c), y * s],
            [x * y * (1 - c), c + y * y * (1 - c), -x * s],
            [-y * s, x * s, c],
        ]
    )
