"""A calibration as rows of equations: every sensor adds rows to one least-squares problem, at a pose or at none."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array, Mask
from cablewright.calibration.fixed import distances_of, held_by_datum, linear_rows
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.unknowns import Unknown, numbers_of_lines, targets, unknowns_of
from cablewright.errors import InputError
from cablewright.kernels.fitting import calibration_residuals, pose_schur
from cablewright.kernels.fitting.calibration_residuals import MeasurementRows
from cablewright.kernels.fitting.pose_schur import StopRule
from cablewright.models.rotation import placed
from cablewright.robot import RigidPlatform, Robot

ENCODER_SIGMA = 1e-4
"""Taken for the encoders' standard deviation beside other sensors, m, where nobody gives one."""


@dataclass(frozen=True, eq=False)
class Measured:
    """What was measured at N poses. `guess` are poses to start from; with `pose_sigma` they are measurements too."""

    counted: Array  # (N, m) m: length changes since home, by encoders
    guess: Array | None = None  # (N, n) m and rad
    pose_sigma: Array | None = None  # (N, n) m and rad
    tensions: Array | None = None  # (N, m) N
    swivel: Array | None = None  # (N, m) rad: azimuth of each free cable, 0 is world +x
    tilt: Array | None = None  # (N, 2) rad: the platform against the plumb line, about x and y
    places: Sequence[int] = field(default=())  # (N,) line of the file of each pose
    origin: str = "the data"

    def place(self, pose: int) -> str:
        """Say where a pose (counted from 0) stands."""
        return f"line {self.places[pose]}" if len(self.places) else f"pose {pose + 1}"


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Weighted residuals and their derivatives, e rows for each of N poses and g of none.

    p are the unknowns of a pose by itself: the n of straight lines, or the m lengths of lines that hang.
    """

    residual: Array  # (N, e)
    by_pose: Array  # (N, e, p)
    by_unknown: Array  # (N, e, k)
    others: Array  # (g,) residuals without a pose: distances, then linear rows
    others_by_unknown: Array  # (g, k)


@dataclass(frozen=True, eq=False)
class CalibrationProblem:
    """The equations of a calibration. `weights` are 1 / sigma; a row with weight 0 does not count.

    `held` says which of `unknowns` keep the value of `start`: the datum's. `rows` has the others alone. Here lines are
    straight and stiff, and what is unknown of a pose by itself is the pose; `hanging.Hanging` has lines that give.
    """

    robot: Robot
    measured: Measured
    plan: CalibrationPlan
    unknowns: tuple[Unknown, ...]
    rows: MeasurementRows
    values: Array  # (R,)
    weights: Array  # (R,)
    per_pose: int  # e
    start: Array  # (k,) of all unknowns, held ones too
    held: Mask  # (k,)
    is_prior: Mask  # (g,) which rows without a pose were known before

    @classmethod
    def of(
        cls, robot: Robot, measured: Measured, plan: CalibrationPlan | None = None, hold: bool = True
    ) -> CalibrationProblem:
        """Build the rows; with *hold*, what the plan's datum names is no unknown.

        Raises `InputError` for what the plan names and the robot or the data do not have, and a contradictory datum.
        """
        return cls(
            robot,
            measured,
            plan or CalibrationPlan(),
            *equations(robot, measured, plan or CalibrationPlan(), hold, hangs=False),
        )

    def freed(self) -> CalibrationProblem:
        """The same without a datum."""
        return CalibrationProblem.of(self.robot, self.measured, self.plan, hold=False)

    def alone(self, theta: Array) -> CalibrationProblem:
        """The same with all unknowns held at *theta*: what is left are the poses."""
        lines, target = self.rows.lines.copy(), self.rows.target
        lines[target >= 0] = theta[target[target >= 0]]
        nothing = np.full_like(target, -1)
        rows = self.rows._replace(lines=lines, target=nothing, linear=np.zeros((0, 0)), wanted=np.zeros(0))
        return replace(self, rows=rows, start=self.whole(theta), held=np.ones_like(self.held))

    @property
    def poses(self) -> int:
        """The number N of poses."""
        return len(self.measured.counted)

    @property
    def hangs(self) -> bool:
        """Whether lines stretch or sag, and so have their tensions from equilibria."""
        return False

    @property
    def cable(self) -> str:
        """The cable law."""
        return "rigid"

    @property
    def own(self) -> int:
        """How many numbers p of a pose are unknown beside what all poses share."""
        return self.robot.n

    def poses_of(self, own: Array) -> Array:
        """The poses (N, n) among what is kept of each pose."""
        return own

    def with_poses(self, own: Array, poses: Array) -> Array:
        """What is kept of each pose, with other *poses* (N, n) in it."""
        del own
        return poses

    def reaches(self, theta: Array, own: Array) -> bool:
        """Whether every sensor has a value there."""
        return bool(np.isfinite(self.lengths(theta, own)).all())

    def followed(self, theta: Array, own: Array, change: Array, by: Array) -> Array:
        """What is kept of each pose once unknowns *change* (k,) and those of each pose go *by* (N, p)."""
        del theta, change
        return own + by

    def adjust(
        self, theta: Array, own: Array, weights: Array, settings: StopRule, rows: MeasurementRows | None = None
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Move *theta* (B, k) and *own* (B, N, ..) in place to least costs; codes, steps and costs (B,)."""
        runs = len(theta)
        codes, steps, costs = np.zeros(runs, dtype=np.int64), np.zeros(runs, dtype=np.int64), np.zeros(runs)
        values, weight = self.values[None], np.ascontiguousarray(weights)[None]
        pose_schur.adjust_runs(rows or self.rows, theta, own, values, weight, settings, codes, steps, costs)
        return codes, steps, costs

    @property
    def encoder_sigma(self) -> float:
        """The standard deviation that the encoders' weights stand for, m."""
        return self.plan.sigma.encoder or ENCODER_SIGMA

    @property
    def free(self) -> Array:
        """The start of the unknowns that are not held."""
        return np.ascontiguousarray(self.start[~self.held])

    def whole(self, theta: Array) -> Array:
        """All unknowns (..., k) from those that are not held."""
        found = np.broadcast_to(self.start, (*theta.shape[:-1], len(self.start))).copy()
        found[..., ~self.held] = theta
        return found

    def lengths(self, theta: Array, poses: Array) -> Array:
        """Length (N, m) of each line from its exit point to the platform, m."""
        found = np.zeros((len(poses), self.robot.m))
        calibration_residuals.lengths_at(self.rows, np.ascontiguousarray(theta), np.ascontiguousarray(poses), found)
        return found

    def exit_points(self, theta: Array) -> Array:
        """The exit points (m, 3), m, with unknowns *theta* that are not held."""
        names = [line.name for line in self.robot.lines]
        points = np.array([line.exit_point for line in self.robot.lines])
        for unknown, value in zip(self.unknowns, self.whole(theta), strict=True):
            if unknown.name == "exit_point":
                points[names.index(unknown.line or ""), unknown.axis or 0] = value
        return points

    def derivatives(self, theta: Array, poses: Array, weights: Array | None = None) -> Derivatives:
        """Residuals and derivatives at unknowns *theta* that are not held, and *poses* (N, n)."""
        used = self.weights if weights is None else weights
        total, k = len(self.values), len(theta)
        residuals, slopes, gradients = np.zeros(total), np.zeros((total, self.robot.n)), np.zeros((total, k))
        theta, poses = np.ascontiguousarray(theta), np.ascontiguousarray(poses)
        calibration_residuals.derivatives(self.rows, theta, poses, self.values, used, residuals, slopes, gradients)
        count, e = self.poses, self.per_pose
        linear = self.rows.linear @ theta - self.rows.wanted
        return Derivatives(
            residuals[: count * e].reshape(count, e),
            slopes[: count * e].reshape(count, e, -1),
            gradients[: count * e].reshape(count, e, k),
            np.append(residuals[count * e :], linear),
            np.concatenate([gradients[count * e :], self.rows.linear]),
        )

    def balanced(self, theta: Array, poses: Array) -> CalibrationProblem:
        """The problem with measured tensions, if any, replaced by the nearest ones that balance the load.

        A force left unbalanced turns with the frame, and would seem to tell its direction.
        """
        if self.measured.tensions is None:
            return self
        m = self.robot.m
        found = self.derivatives(theta, poses, np.ones(len(self.values)))
        u = np.swapaxes(found.by_pose[:, :m], 1, 2)  # (N, n, m): lengths change as forces and moments do
        left = _loads(self.rows.load, poses) - np.einsum("nam,nm->na", u, self.rows.tensions)
        tensions = self.rows.tensions + np.einsum("nma,na->nm", np.linalg.pinv(u), left)
        return replace(self, rows=self.rows._replace(tensions=np.ascontiguousarray(tensions)))

    def of_poses(self, weights: Array) -> Array:
        """The part (N, e) of row *weights* that belongs to poses; a view."""
        return weights[: self.poses * self.per_pose].reshape(self.poses, self.per_pose)


def equations(
    robot: Robot, measured: Measured, plan: CalibrationPlan, hold: bool, hangs: bool
) -> tuple[tuple[Unknown, ...], MeasurementRows, Array, Array, int, Array, Mask, Mask]:
    """All of a `CalibrationProblem` after its plan, from `unknowns` on; *hangs* says that lines stretch or sag."""
    unknowns = unknowns_of(robot, plan.unknowns, plan.shared, elastic=hangs)
    lines, target = numbers_of_lines(robot), targets(robot, unknowns)
    start = _start(unknowns, lines, target)
    held = held_by_datum(robot, unknowns, plan) if hold else np.zeros(len(unknowns), dtype=bool)
    blocks = list(_blocks(robot, measured, plan, hangs))
    per_pose = sum(block.values.shape[1] for block in blocks)
    distances = distances_of(robot, plan)
    linear, wanted, prior = linear_rows(robot, unknowns, plan, start)
    keep = ~held
    place = np.where(keep, np.cumsum(keep) - 1, -1)
    for i, c in np.argwhere(target >= 0):
        if held[target[i, c]]:
            lines[i, c] = start[target[i, c]]
    rows = _rows(robot, measured, blocks, distances)._replace(
        lines=lines,
        target=np.where(target >= 0, place[target], -1),
        linear=np.ascontiguousarray(linear[:, keep]),
        wanted=wanted - linear[:, held] @ start[held],
    )
    values = np.append(np.concatenate([block.values for block in blocks], axis=1), [each[2] for each in distances])
    weights = np.concatenate([block.weights for block in blocks], axis=1)
    weights = np.append(weights, [1.0 / each[3] for each in distances])
    is_prior = np.append(np.zeros(len(distances), dtype=bool), prior)
    return unknowns, rows, values, weights, per_pose, start, held, is_prior


@dataclass(frozen=True)
class _Block:
    """Rows of one sensor at all poses."""

    kind: NDArray[np.int64]  # (N, r)
    line: NDArray[np.int64]
    other: NDArray[np.int64]
    extra: Array  # (N, r, 6)
    values: Array
    weights: Array


def _rows(
    robot: Robot, measured: Measured, blocks: Sequence[_Block], distances: Sequence[tuple[int, int, float, float]]
) -> MeasurementRows:
    """What the rows are of, without unknowns: those of poses in their order, then distances."""
    count = len(measured.counted)
    per_pose = sum(block.values.shape[1] for block in blocks)
    whole = [np.array([each[k] for each in distances], dtype=np.int64) for k in range(2)]
    kinds = np.concatenate([block.kind for block in blocks], axis=1).ravel()
    lines = np.concatenate([block.line for block in blocks], axis=1).ravel()
    others = np.concatenate([block.other for block in blocks], axis=1).ravel()
    extra = np.concatenate([block.extra for block in blocks], axis=1).reshape(-1, 6)
    nothing = np.zeros((robot.m, calibration_residuals.COLUMNS))
    return MeasurementRows(
        freedoms=robot.n,
        start=np.arange(count + 1, dtype=np.int64) * per_pose,
        kind=np.append(kinds, np.full(len(distances), calibration_residuals.BETWEEN, dtype=np.int64)),
        line=np.append(lines, whole[0]),
        other=np.append(others, whole[1]),
        extra=np.concatenate([extra, np.zeros((len(distances), 6))]),
        lines=nothing,
        target=np.full(nothing.shape, -1, dtype=np.int64),
        tensions=np.zeros((count, robot.m)) if measured.tensions is None else np.ascontiguousarray(measured.tensions),
        load=_load(robot),
        linear=np.zeros((0, 0)),
        wanted=np.zeros(0),
    )


def _block(kind: int, values: Array, weights: Array, line: object = 0, other: object = 0, extra: object = 0) -> _Block:
    shape = values.shape
    return _Block(
        np.full(shape, kind, dtype=np.int64),
        np.broadcast_to(np.asarray(line, dtype=np.int64), shape),
        np.broadcast_to(np.asarray(other, dtype=np.int64), shape),
        np.broadcast_to(np.asarray(extra, dtype=np.float64), (*shape, 6)),
        values,
        np.broadcast_to(weights, shape),
    )


def _blocks(robot: Robot, measured: Measured, plan: CalibrationPlan, hangs: bool) -> Iterator[_Block]:
    """Yield the rows of each sensor that there is: the encoders first, then tensions where they stand by themselves."""
    sigma, lines = plan.sigma, np.arange(robot.m)
    one = np.ones(1)
    encoder = calibration_residuals.PAID_OUT if hangs else calibration_residuals.ENCODER
    yield _block(encoder, measured.counted, one / (sigma.encoder or ENCODER_SIGMA), lines)
    if hangs and measured.tensions is not None:
        yield _block(calibration_residuals.TENSION, measured.tensions, one / sigma.tension, lines)
    if measured.pose_sigma is not None:
        assert measured.guess is not None
        extra = np.zeros((*measured.guess.shape, 6))
        if robot.n == 6:
            extra[:, 3:, :3] = measured.guess[:, None, 3:]
        weights = 1.0 / measured.pose_sigma
        yield _block(calibration_residuals.COORDINATE, measured.guess, weights, other=np.arange(robot.n), extra=extra)
    if measured.swivel is not None:
        yield _block(calibration_residuals.SWIVEL, measured.swivel, one / sigma.swivel, lines)
    if measured.tilt is not None:
        if robot.n == 3:
            raise InputError(
                f"{measured.origin}: tilt_x, tilt_y: {robot.name!r} is a point platform, which has no tilt"
            )
        yield _block(calibration_residuals.TILT, measured.tilt, one / sigma.tilt, other=np.arange(2))
    if not hangs and measured.tensions is not None:
        yield _balance(robot, measured, sigma.tension)
    nozzle = robot.platform.nozzle if isinstance(robot.platform, RigidPlatform) else robot.lines[0].platform_point
    for index, plane in enumerate(plan.planes):
        at = _at_poses(measured, plane.poses, f"planes[{index}]")
        normal = np.asarray(plane.normal) / math.hypot(*plane.normal)
        weights = at[:, None] / plane.deviation
        values = np.full(weights.shape, float(normal @ plane.point))
        yield _block(calibration_residuals.PLANE, values, weights, extra=np.append(normal, nozzle))
    for index, reach in enumerate(plan.ranges):
        at = _at_poses(measured, reach.poses, f"ranges[{index}]")
        values = np.zeros((len(at), 1))
        values[np.asarray(reach.poses) - 1, 0] = reach.values
        yield _block(
            calibration_residuals.REACH, values, at[:, None] / reach.deviation, extra=np.append(reach.point, nozzle)
        )


def _at_poses(measured: Measured, poses: Sequence[int], where: str) -> Array:
    """1 at each of the poses (counted from 1), 0 at the others, (N,)."""
    if max(poses) > len(measured.counted):
        raise InputError(f"{where}.poses: there is no pose {max(poses)}; the data have {len(measured.counted)}")
    at = np.zeros(len(measured.counted))
    at[np.asarray(poses) - 1] = 1.0
    return at


def _balance(robot: Robot, measured: Measured, sigma: float) -> _Block:
    """Rows for measured tensions: what they leave unbalanced, along directions in which errors do not go together.

    A tension's error goes along its line, so force and moment have the covariance sigma^2 sum w w^T, w = (u, r x u).
    Directions of lines are those from the file to the guess of the pose.
    """
    guess, count, n = measured.guess, len(measured.counted), robot.n
    if guess is None:
        raise InputError(f"{measured.origin}: tensions f_1.. need columns x,y,z, guesses of the poses, to be weighed")
    points = placed(guess, [line.platform_point for line in robot.lines])
    away = points - np.array([line.exit_point for line in robot.lines])
    u = away / np.linalg.norm(away, axis=2)[..., None]
    w = np.concatenate([u, np.cross(points - guess[:, None, :3], u)], axis=2)[..., :n]
    spread = np.einsum("nmi,nmj->nij", w, w)
    size = np.einsum("nii->ni", spread)[:, None] * np.eye(n)  # m and N: what is next to nothing is so of its own row
    extra = np.zeros((count, n, 6))
    extra[..., :n] = np.linalg.inv(np.linalg.cholesky(spread + 1e-6 * size)) / sigma
    return _block(calibration_residuals.BALANCE, np.zeros((count, n)), np.ones(1), extra=extra)


def _load(robot: Robot) -> Array:
    """Force and moment on the platform besides the lines and its weight, N and N m; the weight, and where it acts."""
    platform, load = robot.platform, np.zeros(10)
    load[:3], load[6] = platform.force, platform.mass * robot.scene.gravity
    if isinstance(platform, RigidPlatform):
        load[3:6], load[7:] = platform.moment, platform.centre_of_mass
    return load


def _loads(load: Array, poses: Array) -> Array:
    """The same at *poses* (N, n) about the platform's origin, (N, n), N and N m."""
    weight = np.array([0.0, 0.0, -load[6]])
    found = np.tile(load[:6], (len(poses), 1))
    found[:, :3] += weight
    arms = placed(poses, [load[7:]])[:, 0] - poses[:, :3]
    found[:, 3:] += np.cross(arms, weight)
    return found[:, : poses.shape[1]]


def _start(unknowns: Sequence[Unknown], lines: Array, target: NDArray[np.int64]) -> Array:
    start = np.array([each.entry.nominal or 0.0 for each in unknowns])
    for i, c in np.argwhere(target >= 0):
        start[target[i, c]] = lines[i, c]
    return start
