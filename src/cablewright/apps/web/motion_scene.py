"""Scene of a machine in motion: true and estimated positions of its platform, and its lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.apps.quantities import enlargement
from cablewright.apps.web.check_scene import extent
from cablewright.apps.web.path_scene import PathScene, Quantity
from cablewright.apps.web.scene import SceneBody, SceneDescription
from cablewright.apps.web.viewer_states import States
from cablewright.foundation.arrays import Array, Mask
from cablewright.live.logged_line_shapes import hanging_lines
from cablewright.machine.log.head import LogHead
from cablewright.models.statics import Model
from cablewright.solvers.inverse import solve_inverse

_MOTION: Final = (
    "The machine moves: its lines are drawn as they hang by the logged lengths between exit point and platform, and "
    "the platform need not be in equilibrium. Tensions are those of the log."
)
_GUESSED: Final = (
    "The log has no truth: what is drawn is where the estimation took the platform to be, with lines as they would "
    "hold it there at rest; it need not have been in equilibrium. Tensions are not known."
)
_ONE_SIGMA_GOAL: Final = 0.03  # of the scene's extent


_MOST_OF_A_TRACK: Final = 5000  # points


@dataclass(frozen=True, eq=False)
class Gone:
    """Path of the nozzle so far, k steps; NaN: unknown."""

    time: Array  # (k,) s
    true: Array  # (k, 3) m
    told: Array  # (k, 3) m, by the estimation
    layer: NDArray[np.int64]  # (k,)
    prints: Mask  # (k,)


@dataclass(frozen=True, eq=False)
class MotionSteps:
    """Some steps of a motion, F, with the data to draw; NaN: not known. Poses are of the platform's origin."""

    time: Array  # (F,) s
    true: Array  # (F, 6) m and rad
    told: Array  # (F, 6) m and rad
    lengths: Array  # (F, m) m, unstrained
    tensions: Array  # (F, m) N
    covariances: Array  # (F, 3, 3) m^2, of the estimated position
    scans: tuple[Array, ...] | None = None  # F arrays (k, 3) m: points that lidars saw


def motion_scene(
    title: str,
    head: LogHead,
    gone: Gone,
    moments: MotionSteps,
    faults: Sequence[str] = (),
    bodies: Sequence[SceneBody] = (),
) -> SceneDescription:
    """Return the scene of a machine in motion.

    *faults*: faults in its log, a sentence each; *bodies*: other objects in the scene.
    """
    has_truth = bool(np.isfinite(gone.true).any())
    more = list(bodies)
    if has_truth and np.isfinite(gone.told).any():
        track = gone.told[:: max(1, len(gone.told) // _MOST_OF_A_TRACK)]
        more.append(SceneBody("path of the estimate", "--estimate", track=track, shown=False))
    notes = (_MOTION if has_truth else _GUESSED, *(f"{each[:1].upper()}{each[1:]}." for each in faults))
    return SceneDescription(
        title,
        head.robot,
        _states(head, moments, gone.time, has_truth),
        _path(head, gone, has_truth),
        walls=walls_of(head),
        bodies=tuple(more),
        drum=drum_of(head),
        notes=notes,
    )


def _path(head: LogHead, gone: Gone, has_truth: bool) -> PathScene:
    """The path of the platform, coloured by estimation error, by speed and by height."""
    places = gone.true if has_truth else gone.told
    apart = np.linalg.norm(gone.told - gone.true, axis=1)
    known = bool(np.isfinite(apart).any())
    quantities = [Quantity.of("estimation", "error of the estimate", "m", apart)] if known else []
    step = np.diff(gone.time, prepend=gone.time[:1])
    way = np.linalg.norm(np.diff(places, axis=0, prepend=places[:1]), axis=1)
    speed = np.divide(way, step, out=np.full(len(step), np.nan), where=step > 0.0)
    quantities += [Quantity.of("speed", "speed", "m/s", speed), Quantity.of("height", "height", "m", places[:, 2])]
    extrusion = head.settings.extrusion
    bead = None if extrusion is None else (extrusion.bead.width, extrusion.bead.height)
    worst = int(np.nanargmax(apart)) if known else None
    size = extent(head.robot)
    laid = (
        gone.prints if gone.prints.any() else np.ones(len(places), dtype=bool)
    )  # a drive lays nothing: all of it counts
    return PathScene(places, laid, gone.layer, size, quantities, gone.time, bead=bead, worst=worst)


def walls_of(head: LogHead) -> tuple[tuple[str, Array], ...]:
    """Return the vertical walls of the machine's room up to its ceiling: name and corners (4, 3), m."""
    low, high = head.robot.scene.frame_min[2], head.settings.room.ceiling
    return tuple(
        (wall.name, np.array([(*wall.start, low), (*wall.end, low), (*wall.end, high), (*wall.start, high)]))
        for wall in head.settings.room.walls
    )


def drum_of(head: LogHead) -> tuple[float, float] | None:
    """Return radius and depth, m, of the container that hangs from a point platform; None of a body."""
    drum = head.settings.drum
    return None if drum is None else (drum.radius, drum.valve)


def _states(head: LogHead, moments: MotionSteps, time: Array, has_truth: bool) -> States:
    """The states of the moments whose pose is known."""
    poses, model, width = (moments.true if has_truth else moments.told), Model(head.robot), head.robot.n
    known = np.isfinite(poses).all(axis=1)
    poses, flat = poses[known], poses[known][:, :width]
    if has_truth:
        states = hanging_lines(model, flat, moments.lengths[known])
    else:
        states = solve_inverse(model, flat).states
    when = moments.time[known]
    samples = np.searchsorted(time, when)
    drawn = States.drawn(model.packed, head.robot, flat, states, moments.tensions[known], times=when, samples=samples)
    scans = None if moments.scans is None else tuple(moments.scans[k] for k in np.flatnonzero(known))
    drawn = replace(drawn, poses=poses, scans=scans)  # with the rotation of a drum that hangs from a point
    told, covariances = moments.told[known], moments.covariances[known]
    if not has_truth or not np.isfinite(told).any():
        return drawn
    some = covariances if np.isfinite(covariances).any() else None
    return drawn.with_estimates(told, some, _enlargement(covariances, extent(head.robot)))


def _enlargement(covariances: Array, size: float) -> float:
    """How many times larger ellipsoids are drawn, so that they are seen: 1, 2 or 5 times a power of ten."""
    known = covariances[np.isfinite(covariances).all(axis=(1, 2))]
    if not len(known):
        return 1.0
    largest = float(np.sqrt(np.median(np.trace(known, axis1=1, axis2=2))))
    return enlargement(_ONE_SIGMA_GOAL * size, max(largest, 1e-9))
