"""One turn of a planar lidar: what the unit is, and the points it saw, made level."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.errors import InputError

__all__ = ["LidarModel", "Points", "level_mount", "noise_of", "points_of"]

Array = NDArray[np.float64]

_MEDIAN_OF_NORMAL = 0.6745  # of the size of a normal number, in sigmas


@dataclass(frozen=True)
class LidarModel:
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
    lidar: LidarModel,
    angles: ArrayLike,
    ranges: ArrayLike,
    tilt: ArrayLike = (0.0, 0.0),
    drift: ArrayLike | None = None,
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
    good = np.isfinite(a) & (r >= lidar.least) & (r <= lidar.most)
    for each in (leaning, moved):
        if each is not None and each.ndim == 2 and not np.isfinite(each).all():
            good &= np.isfinite(each).all(axis=1)
    with np.errstate(invalid="ignore"):
        for begin, end in lidar.masked:
            good &= ~((a - begin) % math.tau <= (end - begin) % math.tau)
    if not np.isfinite(leaning.reshape(-1, 2)[-1:]).all():
        good[:] = False  # which way the lidar leans at the end is not known
    chosen = np.flatnonzero(good)
    bearing = a[chosen] % math.tau
    order = np.argsort(bearing, kind="stable")
    chosen, bearing = chosen[order], bearing[order]
    step = np.append(bearing[1:], bearing[:1] + math.tau) - bearing
    if len(step):
        first = int(step.argmax()) + 1
        chosen, bearing, step = (np.concatenate([each[first:], each[:first]]) for each in (chosen, bearing, step))
    ray, far = _columns(np.cos(bearing), np.sin(bearing)), r[chosen]
    xy = far[:, None] * ray
    if moved is None and not leaning.any():
        return Points(xy, ray, far, step)
    xy = _at_the_end(
        lidar, xy, leaning[chosen] if leaning.ndim == 2 else leaning, None if moved is None else moved[chosen],
        leaning[-1] if leaning.ndim == 2 and len(leaning) else leaning,
    )  # fmt: skip
    far = np.hypot(xy[:, 0], xy[:, 1])
    return Points(xy, xy / np.maximum(far, 1e-12)[:, None], far, step)


def _columns(x: Array, y: Array) -> Array:
    """Put two columns side by side."""
    both = np.empty((len(x), 2))
    both[:, 0], both[:, 1] = x, y
    return both


def _at_the_end(lidar: LidarModel, xy: Array, tilt: Array, drift: Array | None, last: Array) -> Array:
    """Bring points (n, 2) of the lidar's plane to where its centre is at the end, level, along its level axes."""
    c, s = math.cos(lidar.yaw), math.sin(lidar.yaw)
    turn = np.array([[c, -s], [s, c]])
    level = _tilted(xy @ turn.T + lidar.mount[:2], lidar.mount[2], np.broadcast_to(tilt, (len(xy), 2)))
    if drift is not None:
        c_, s_ = np.cos(drift[:, 2]), np.sin(drift[:, 2])
        x, y = level.T
        level = _columns(c_ * x - s_ * y, s_ * x + c_ * y) + drift[:, :2]
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


def level_mount(lidar: LidarModel, tilt: ArrayLike = (0.0, 0.0)) -> Array:
    """(2,) m: where the lidar's centre is from the platform point, seen from above, platform frame without its tilt."""
    leaning = np.asarray(tilt, dtype=np.float64).reshape(-1, 2)[-1:]
    there: Array = _tilted(np.array([lidar.mount[:2]]), lidar.mount[2], leaning)[0]
    return there


def _tilted(xy: Array, z: float, tilt: Array) -> Array:
    """Turn each point (n, 2), at height z, by its level rotation vector (n, 2): Rodrigues' formula, seen from above."""
    (x, y), (tx, ty) = xy.T, tilt.T
    angle = np.hypot(tx, ty)
    size = np.maximum(angle, 1e-300)
    ax, ay = tx / size, ty / size
    c, s = np.cos(angle), np.sin(angle)
    along = (1.0 - c) * (ax * x + ay * y)
    return _columns(c * x + s * (ay * z) + along * ax, c * y - s * (ax * z) + along * ay)
