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


def points_of(
    lidar: Lidar, angles: ArrayLike, ranges: ArrayLike, tilt: ArrayLike = (0.0, 0.0), drift: ArrayLike | None = None
) -> Points:
    """Return the points of a scan that count: finite, within the unit's range, not on the platform.

    ``angles``: (n,) rad, counter-clockwise; ``ranges``: (n,) m, 0 or not finite where nothing came back. ``tilt``: (2,)
    or (n, 2) rad, rotation vector (x, y) of the platform frame by which the level one became the real one, at the end
    or at each ray. ``drift``: (n, 3) m and rad, where the platform was at each ray, x, y and yaw from where it is at
    the end, along its level axes there. Points are made level and brought to where the lidar is at the end.

    Raises `InputError` unless the arrays fit each other.
    """
    a, r = np.asarray(angles, dtype=np.float64), np.asarray(ranges, dtype=np.float64)
    if a.ndim != 1 or a.shape != r.shape:
        raise InputError(f"scan: as many angles as ranges are wanted, not shapes {a.shape} and {r.shape}")
    leaning = np.asarray(tilt, dtype=np.float64)
    moved = None if drift is None else np.asarray(drift, dtype=np.float64)
    if leaning.shape not in ((2,), (len(a), 2)) or (moved is not None and moved.shape != (len(a), 3)):
        shapes = f"{leaning.shape} and {None if moved is None else moved.shape}"
        raise InputError(f"scan: a tilt (2,) or (n, 2) and a drift (n, 3) are wanted, not {shapes}")
    with np.errstate(invalid="ignore"):
        good = np.isfinite(a) & (r >= lidar.least) & (r <= lidar.most)
        for each in (leaning, moved):
            if each is not None and each.ndim == 2:
                good &= np.isfinite(each).all(axis=1)
        for begin, end in lidar.masked:
            good &= ~((a - begin) % math.tau <= (end - begin) % math.tau)
    bearing = a[good] % math.tau
    order = np.argsort(bearing, kind="stable")
    step = np.diff(bearing[order], append=bearing[order][:1] + math.tau)
    if len(order):
        first = int(step.argmax()) + 1
        order, step = np.roll(order, -first), np.roll(step, -first)
    if not np.isfinite(leaning.reshape(-1, 2)[-1:]).all():
        order, step = order[:0], step[:0]  # which way the lidar leans at the end is not known
    chosen = np.flatnonzero(good)[order]
    ray, far = np.stack([np.cos(bearing[order]), np.sin(bearing[order])], axis=1), r[chosen]
    xy = far[:, None] * ray
    if moved is None and not leaning.any():
        return Points(xy, ray, far, step)
    xy = _at_the_end(
        lidar, xy, leaning[chosen] if leaning.ndim == 2 else leaning, None if moved is None else moved[chosen],
        leaning[-1] if leaning.ndim == 2 and len(leaning) else leaning,
    )  # fmt: skip
    far = np.hypot(*xy.T)
    return Points(xy, xy / np.maximum(far, 1e-12)[:, None], far, step)


def _at_the_end(lidar: Lidar, xy: Array, tilt: Array, drift: Array | None, last: Array) -> Array:
    """Bring points (n, 2) of the lidar's plane to where its centre is at the end, level, along its level axes."""
    c, s = math.cos(lidar.yaw), math.sin(lidar.yaw)
    turn = np.array([[c, -s], [s, c]])
    on_platform = np.column_stack([xy @ turn.T, np.zeros(len(xy))]) + np.array(lidar.mount)
    level = _tilted(on_platform, np.broadcast_to(tilt, (len(xy), 2)))[:, :2]
    if drift is not None:
        c_, s_ = np.cos(drift[:, 2]), np.sin(drift[:, 2])
        x, y = level.T
        level = np.stack([c_ * x - s_ * y, s_ * x + c_ * y], axis=1) + drift[:, :2]
    there: Array = (level - level_mount(lidar, last)) @ turn
    return there


def noise_of(points: Points, least: float = 5e-4, most: float = 0.05) -> float:
    """Return the sigma of one range (m) from how little ranges go on as before, within ``least`` and ``most``.

    From third differences of neighbours: a straight wall bends ranges, but seen in steps of two degrees or less hardly
    changes how they bend. Half of all decide, so corners and things in the way do not count.
    """
    if len(points) < 4:
        return least
    jerk = np.abs(np.diff(points.distance, 3))
    return float(np.clip(np.median(jerk) / (_MEDIAN_OF_NORMAL * math.sqrt(20.0)), least, most))


def level_mount(lidar: Lidar, tilt: ArrayLike = (0.0, 0.0)) -> Array:
    """(2,) m: where the lidar's centre is from the platform point, seen from above, platform frame without its tilt."""
    leaning = np.asarray(tilt, dtype=np.float64).reshape(-1, 2)[-1:]
    return _tilted(np.array([lidar.mount]), leaning)[0, :2]


def _tilted(points: Array, tilt: Array) -> Array:
    """Turn each point (n, 3) by its level rotation vector (n, 2): Rodrigues' formula."""
    angle = np.hypot(*tilt.T)
    axis = np.column_stack([tilt, np.zeros(len(tilt))]) / np.maximum(angle, 1e-300)[:, None]
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = np.einsum("ni,ni->n", axis, points)[:, None]
    turned: Array = c * points + s * np.cross(axis, points) + (1 - c) * along * axis
    return turned
