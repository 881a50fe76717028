"""Observability of a calibration: determined and undetermined parameters, sigmas, useful further measurements.

Poses are eliminated by orthogonal projection, not by the normal equations, so that small singular values keep digits.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, islice
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.measurement_rows.without_pose import tilt_rows
from cablewright.calibration.poses.derivatives import Derivatives
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.sightings.sighted import motions_of
from cablewright.calibration.unknowns import Unknown, coordinates_of, exit_rows
from cablewright.foundation.arrays import Array, Mask
from cablewright.models.plane import basis
from cablewright.robot import Robot
from cablewright.robot.parameter_values import AXES

_NULL: Final = 1e-9
"""Relative size under which a singular value counts as zero: rounding leaves 1e-15, the smallest sheave 1e-6."""

_ALIKE: Final = 0.9
"""Min projection of a unit direction on a named motion to be called by its name."""

_WEAKEST: Final = 3
_SURVEYED: Final = 1e-3  # m: sigma of a suggested distance or surveyed point
_LEVEL: Final = 1e-3  # rad: sigma of a suggested level
_MAX_PAIRS: Final = 28
_TILTS: Final = ("tilt about x", "tilt about y")
_TURNS: Final = {"x": _TILTS[0], "y": _TILTS[1], "z": "yaw"}
_BEYOND: Final = 1e-4  # size of the part of an open direction beyond the motions of frames


@dataclass(frozen=True)
class Direction:
    """A combination of unknowns and its standard deviation.

    Its unit is that of the largest part, or rad for a tilt.
    """

    words: str
    sigma: float
    unit: str
    vector: tuple[float, ...]  # (k,) of length 1


@dataclass(frozen=True)
class Suggestion:
    """One more measurement, and its effect on the sigma of the exit points and the undetermined degrees of freedom."""

    words: str
    before: float  # m, root mean square over coordinates of exit points, under the inner constraint
    after: float
    open_before: int
    open_after: int


@dataclass(frozen=True, eq=False)
class Information:
    """The information in the data on k free unknowns, with the poses eliminated, at the sigmas in the weights."""

    robot: Robot
    unknowns: tuple[Unknown, ...]
    exits: Array  # (m, 3) m, the fitted exit points
    ties: Array  # (m, 3) m, the fitted platform points
    rows: Array  # (r, k): their Gram matrix is the information matrix
    null: Array  # (k, d): an orthonormal basis of the undetermined space
    rank: int  # of all unknowns, those of the poses included
    total: int  # number of all unknowns, those of the poses included
    measurements: int
    covariance: Array  # (k, k), under the inner constraint: 0 along what is open
    with_frames: Array  # (2, 6, k): how bodies in pictures move with the world's frame, and with the platform's

    @property
    def redundancy(self) -> int:
        """The number of measurements less the rank."""
        return self.measurements - self.rank


def projected(found: Derivatives) -> tuple[Array, Array, NDArray[np.int64]]:
    """Return residuals (N, e) and derivatives (N, e, k) after elimination of the poses, and the poses' ranks (N,).

    The rows are rotated within each pose; those that the pose explains are zero.
    """
    count, e, _ = found.by_pose.shape
    whole = found.whole
    if not whole.all():  # nothing explains such a pose
        found = found.blank(np.logical_not(whole))
    left, values, _ = np.linalg.svd(found.by_pose, full_matrices=True)
    largest = values.max(axis=1, initial=0.0, keepdims=True)
    kept = np.zeros((count, e), dtype=bool)
    kept[:, : values.shape[1]] = values > _NULL * np.maximum(largest, 1e-300)
    free = np.swapaxes(left, 1, 2) * ~kept[:, :, None]
    off = np.einsum("nre,ne->nr", free, found.residual)
    off[~whole] = np.inf
    return off, free @ found.by_unknown, kept.sum(axis=1)


def information(
    problem: CalibrationProblem, theta: Array, poses: Array, weights: Array, priors: bool = False
) -> Information:
    """Return the information at a solution; *priors*: whether prior knowledge counts.

    Rows of weight 0 do not count, nor do poses all of whose rows have it.
    """
    found = problem.balanced(theta, poses).derivatives(theta, poses, weights)
    told = np.logical_not(problem.is_prior)
    told[len(told) - problem.stated :] = True
    others = found.others_by_unknown if priors else found.others_by_unknown[told]
    _, reduced, ranks = projected(found)
    rows = np.concatenate([reduced.reshape(-1, reduced.shape[-1]), others])
    if len(rows) > rows.shape[1]:
        rows = np.asarray(np.linalg.qr(rows, mode="r"))  # the same Gram matrix in fewer rows
    used = problem.of_poses(weights) > 0.0
    alive = used.any(axis=1)
    values, right, kept = _spectrum(rows)
    inverse = right[kept].T / values[kept]
    return Information(
        problem.robot,
        problem.free_unknowns,
        problem.points(theta, "exit_point"),
        problem.points(theta, "platform_point"),
        rows,
        right[~kept].T,
        int(ranks[alive].sum() + kept.sum()),
        rows.shape[1] + int(alive.sum()) * problem.unknowns_per_pose,
        int(used.sum()) + len(others),
        inverse @ inverse.T,
        motions_of(problem.rows.body_target, problem.bodies(theta), rows.shape[1]),
    )


def _spectrum(rows: Array) -> tuple[Array, Array, Mask]:
    """Return singular values (k,) of *rows* (r, k), right vectors (k, k), and which values (k,) are not zero."""
    k = rows.shape[1]
    padded = np.concatenate([rows, np.zeros((max(0, k - len(rows)), k))])
    _, values, right = np.linalg.svd(padded, full_matrices=False)
    return values, right, np.asarray(values > _NULL * max(values.max(initial=0.0), 1e-300))


def motions(found: Information) -> dict[str, Array]:
    """Return, by name, the changes of the unknowns (k,) in rigid motions of a frame, which encoders hardly measure.

    Those of everything in the world; and those of the platform's own frame, where its points are unknown. Of a platform
    in a plane they are those that keep the plane.
    """
    moves, turns = _of_frame(found.robot)
    of_platform = [f"shift of the platform's frame along {way}" for way in moves]
    of_platform += [f"turn of the platform's frame about {way}" for way in turns]
    of_world, named = world_motions(found.robot), {}
    frames = ("exit_point", of_world, found.exits), ("platform_point", of_platform, found.ties)
    for (kind, names, points), seen in zip(frames, found.with_frames, strict=True):
        which, coordinates = coordinates_of(found.robot, found.unknowns, kind)
        arms = points - points.mean(axis=0)
        every = [np.tile(way, len(points)) for way in moves.values()]
        every += [np.cross(axis, arms).ravel() for axis in turns.values()]
        for name, motion in zip(names, every, strict=True):
            named[name] = np.zeros(len(found.unknowns))
            named[name][which] = motion[coordinates]
        for name, way in zip(names, moves.values(), strict=False):
            named[name] += way @ seen[:3] * named[name].any()
        for name, axis in zip(names[len(moves) :], turns.values(), strict=True):
            turn = axis @ seen[3:] - np.cross(axis, points.mean(axis=0)) @ seen[:3]
            named[name] += turn * named[name].any()
    if "yaw" in named:
        named["yaw"] += azimuth_offsets(found.unknowns) * named["yaw"].any()
    return {name: motion for name, motion in named.items() if motion.any()}


def _of_frame(robot: Robot) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return unit vectors along which a frame moves, and about which it turns, by their names."""
    plane, axes = robot.platform.plane, dict(zip(AXES, np.eye(3), strict=True))
    if plane is None:
        return axes, {name: axes[name] for name in "zxy"}
    ways = [*basis(plane, 3).T, np.array(plane.across)]
    named = {}
    for way in ways:
        along = [name for name, axis in axes.items() if abs(float(way @ axis)) == 1.0]
        numbers = ", ".join(f"{number:.2g}" for number in (way.round(9) + 0.0).tolist())
        named[along[0] if along else f"({numbers})"] = axes[along[0]] if along else way
    return dict(list(named.items())[:2]), dict(list(named.items())[2:])


def world_motions(robot: Robot) -> tuple[str, ...]:
    """Return the names of the rigid motions of everything in the world: translations, then rotations."""
    moves, turns = _of_frame(robot)
    return (*(f"translation along {way}" for way in moves), *(_TURNS.get(way, f"turn about {way}") for way in turns))


def azimuth_offsets(unknowns: Sequence[Unknown]) -> Array:
    """Return a vector (k,): 1 for an offset of swivel or yaw angles, which changes with a yaw of the frame, else 0."""
    return np.array([float(each.name in ("swivel_offset", "yaw_offset")) for each in unknowns])


def beyond_frames(found: Information) -> Array:
    """Return the undetermined combinations of unknowns (k, d) that are no rigid motion of a frame."""
    known = np.array(list(motions(found).values())).reshape(-1, len(found.unknowns))
    left, values, _ = np.linalg.svd(known.T, full_matrices=False)
    span = left[:, values > 1e-9 * max(values.max(initial=0.0), 1e-300)]
    rest, sizes, _ = np.linalg.svd(found.null - span @ (span.T @ found.null), full_matrices=False)
    return np.asarray(rest[:, sizes > _BEYOND])


def frame_rows(found: Information, start: Array, weight: float) -> tuple[Array, Array]:
    """Return rows (d, k) and values (d,) that fix the undetermined directions near *start* (k,): the inner constraint.

    What a robot file does not have, home lengths and offsets of sensors, does not count.
    """
    rows = weight * found.null.T * [each.in_file for each in found.unknowns]
    return np.ascontiguousarray(rows), rows @ start


def open_freedoms(found: Information) -> tuple[str, ...]:
    """Return the undetermined combinations in words: named rigid motions first, then combinations of unknowns."""
    null, words, named = found.null, [], np.zeros((len(found.unknowns), 0))
    for name, vector in motions(found).items():
        unit = vector / np.linalg.norm(vector)
        rest = unit - named @ (named.T @ unit)  # motions need not be at right angles
        if np.linalg.norm(null.T @ unit) > 1.0 - 1e-6 and np.linalg.norm(rest) > 1e-3:
            words.append(name)
            named = np.column_stack([named, rest / np.linalg.norm(rest)])
    left = without(null, named)
    return (*words, *(combination(found.unknowns, left[:, d]) for d in range(left.shape[1])))


def without(basis: Array, part: Array) -> Array:
    """Return the part of an orthonormal *basis* (k, d) orthogonal to *part* (k, c), another basis in its span."""
    left, values, _ = np.linalg.svd(basis - part @ (part.T @ basis), full_matrices=False)
    return np.asarray(left[:, values > 0.5])


def combination(unknowns: Sequence[Unknown], vector: Array) -> str:
    """Return the largest parts of a combination of unknowns in words."""
    order = np.argsort(-np.abs(vector))[:3]
    sign = np.sign(vector[order[0]])
    return ", ".join(f"{sign * vector[at]:+.2f} {unknowns[at].label}" for at in order if abs(vector[at]) > 0.05)


def weakest(found: Information) -> tuple[Direction, ...]:
    """Return the determined combinations of unknowns with the largest sigmas, the worst first."""
    values, right, kept = _spectrum(found.rows)
    moves = motions(found)
    tilts = np.array([moves[name] for name in _TILTS if name in moves]).reshape(-1, right.shape[1])
    tilts = tilts - (tilts @ found.null) @ found.null.T
    sizes = np.linalg.norm(tilts, axis=1)
    directions = []
    for at in np.flatnonzero(kept)[::-1][:_WEAKEST]:
        vector, sigma = right[at], 1.0 / float(values[at])
        unit = found.unknowns[int(np.argmax(np.abs(vector)))].unit
        direction = Direction(combination(found.unknowns, vector), sigma, unit, tuple(map(float, vector)))
        if len(tilts) == 2 and (sizes > 0.5 * np.linalg.norm(moves[_TILTS[0]])).all():
            turn = np.linalg.lstsq(tilts.T, vector, rcond=None)[0]
            if np.linalg.norm(turn @ tilts) > _ALIKE:
                azimuth = np.degrees(np.arctan2(turn[1], turn[0])) % 180.0
                words = f"tilt about the horizontal axis at {azimuth:.0f} deg from x"
                direction = replace(direction, words=words, sigma=sigma * float(np.linalg.norm(turn)), unit="rad")
        directions.append(direction)
    return tuple(directions)


def suggestions(found: Information, scale: float) -> tuple[Suggestion, ...]:
    """Return further measurements, each with its effect on sigmas, the most helpful first.

    *scale*: sigma over that of the weights. Rows of the measurement are added to the information. Sigmas before and
    after are in one frame: under the inner constraint of the space that is undetermined without the measurement.
    """
    exits, _ = exit_rows(found.robot, found.unknowns)
    if not len(exits):
        return ()
    before, open_before = _spread(found.rows / scale, found.null, exits)
    made = []
    for words, rows in _measurements(found):
        after, open_after = _spread(np.concatenate([found.rows / scale, rows]), found.null, exits)
        made.append(Suggestion(words, before, after, open_before, open_after))
    return tuple(sorted(made, key=lambda each: (each.after * (1 + each.open_after), each.after)))


def _spread(rows: Array, null: Array, exits: Array) -> tuple[float, int]:
    """Return the rms sigma of *exits* (a, k), m, without motions in *null*, and the number of undetermined motions."""
    values, right, kept = _spectrum(rows)
    inverse = right[kept].T / values[kept]
    inverse = inverse - null @ (null.T @ inverse)
    variances = np.sum((exits @ inverse) ** 2, axis=1)
    return float(np.sqrt(variances.mean())), int((~kept).sum())


def remedy(found: Information) -> str:
    """Return in words the smallest measurement that determines more than the frames; empty for none."""
    before, closing = beyond_frames(found).shape[1], []
    for words, rows in _measurements(found):
        _, right, kept = _spectrum(np.concatenate([found.rows, rows]))
        if beyond_frames(replace(found, null=right[~kept].T)).shape[1] < before:
            closing.append((len(rows), words))
    return min(closing, default=(0, ""))[1]


def _measurements(found: Information) -> Iterator[tuple[str, Array]]:
    """Yield possible measurements in words, with their weighted rows (r, k)."""
    robot, unknowns = found.robot, found.unknowns
    known = {(each.line, each.axis): at for at, each in enumerate(unknowns) if each.name == "exit_point"}
    order = [line.name for line in robot.lines]
    names = [name for name in order if all((name, axis) in known for axis in range(3))]
    if all((name, 2) in known for name in order):
        yield f"exit points levelled, {_LEVEL * 1e3:g} mrad", tilt_rows(robot, unknowns) / _LEVEL

    def point(name: str) -> Array:
        """Return the rows (3, k) of a surveyed exit point."""
        return np.array([np.eye(len(unknowns))[known[name, axis]] for axis in range(3)]) / _SURVEYED

    sigma = f"{_SURVEYED * 1e3:g} mm"
    if names:
        yield f"the exit point of {names[0]} surveyed, {sigma}", point(names[0])
    if len(names) >= 3:
        rows = np.concatenate([point(name) for name in names[:3]])
        yield f"three exit points surveyed ({', '.join(names[:3])}), {sigma}", rows
    for a, b in islice(combinations(names, 2), _MAX_PAIRS):
        apart = found.exits[order.index(a)] - found.exits[order.index(b)]
        row = (apart @ point(a) - apart @ point(b)) / max(float(np.linalg.norm(apart)), 1e-12)
        yield f"the distance from exit point {a} to {b}, {sigma}", row[None]
