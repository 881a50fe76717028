"""A calibration as rows of equations: every sensor adds rows to one least-squares problem, with a pose or without."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.arrays import Array, Mask
from cablewright.calibration.bounds import ranges
from cablewright.calibration.fixed import held_by_datum, line_index, linear_rows
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.unknowns import Unknown, coordinates_of, numbers_of_lines, targets, unknowns_of
from cablewright.errors import InputError
from cablewright.kernels.fitting import calibration_residuals, pose_schur
from cablewright.kernels.fitting.calibration_residuals import MeasurementRows
from cablewright.kernels.fitting.pose_schur import StopRule
from cablewright.models.rotation import placed
from cablewright.robot import RigidPlatform, Robot

ENCODER_SIGMA = 1e-4
"""Default standard deviation of the encoders, m, which weighs them against other sensors."""

SURVEY: Final = "surveyed points and distances"
"""What people call the rows that belong to no pose."""

NO_FRAME: Final = (np.zeros((0, 0)), np.zeros(0))


@dataclass(frozen=True, eq=False)
class Measured:
    """The measurements at N poses. `guess`: start values of the poses; with `pose_sigma`, measurements of them.

    A row of `guess` is NaN where nothing is known of the pose, one of `pose_sigma` where it was not measured.
    """

    counted: Array  # (N, m) m: length changes since home, by encoders
    guess: Array | None = None  # (N, n) m and rad
    pose_sigma: Array | None = None  # (N, n) m and rad
    tensions: Array | None = None  # (N, m) N
    swivel: Array | None = None  # (N, m) rad: azimuth of each free cable, 0 is world +x
    tilt: Array | None = None  # (N, 2) rad: of the platform against the plumb line, about x and y
    places: Sequence[int] = field(default=())  # (N,) line number of each pose in the file
    origin: str = "the data"  # the name in messages

    @property
    def positioned(self) -> int:
        """The number of poses whose position is measured."""
        return 0 if self.pose_sigma is None else int(np.isfinite(self.pose_sigma).all(axis=1).sum())

    def place(self, pose: int) -> str:
        """Return where a pose (counted from 0) is: ``line 7`` of the file, or ``pose 7``."""
        return f"line {self.places[pose]}" if len(self.places) else f"pose {pose + 1}"


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Weighted residuals and their derivatives: e rows at each of N poses, and g rows without a pose.

    The p unknowns of a pose are its n coordinates for straight lines, its m lengths for elastic ones.
    """

    residual: Array  # (N, e)
    by_pose: Array  # (N, e, p)
    by_unknown: Array  # (N, e, k)
    others: Array  # (g,) residuals without a pose: distances, then linear rows
    others_by_unknown: Array  # (g, k)

    def blank(self, poses: Mask) -> Derivatives:
        """Return the same without anything of some *poses* (N,)."""
        residual, by_pose, by_unknown = (
            np.where(poses[(..., *(None,) * (part.ndim - 1))], 0.0, part)
            for part in (self.residual, self.by_pose, self.by_unknown)
        )
        return Derivatives(residual, by_pose, by_unknown, self.others, self.others_by_unknown)


@dataclass(frozen=True, eq=False)
class CalibrationProblem:
    """The equations of a calibration. `weights` are 1 / sigma; a row with weight 0 does not count.

    `held`: the unknowns that the datum holds at their value in `start`; theta and `rows` have the free ones only.
    `frame`: rows (d, k) and values (d,) that hold what the data leave open, in fits only. Lines are straight and rigid,
    and the state of a pose is the pose; `elastic_lines.ElasticProblem` is for elastic lines.
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
    is_prior: Mask  # (g,) rows without a pose that are prior knowledge, not measurements
    limits: Array  # (2, k) min and max of the free unknowns
    frame: tuple[Array, Array] = field(default=NO_FRAME, kw_only=True)
    found_encoder: float | None = field(default=None, kw_only=True)  # m, the encoders' sigma from the residuals
    factors: Mapping[str, float] = field(default_factory=dict, kw_only=True)  # on told sigmas, by kind of measurement

    @classmethod
    def of(
        cls, robot: Robot, measured: Measured, plan: CalibrationPlan | None = None, hold: bool = True
    ) -> CalibrationProblem:
        """Build the rows; *hold*: whether the unknowns that the plan's datum names are held.

        Raises `InputError` for names in the plan that the robot or the data do not have, and a contradictory datum.
        """
        plan = plan or CalibrationPlan()
        return cls(robot, measured, plan, *equations(robot, measured, plan, hold, elastic=False))

    def without_datum(self) -> CalibrationProblem:
        """Return the same problem with no unknown held."""
        return CalibrationProblem.of(self.robot, self.measured, self.plan, hold=False)

    def with_plan(self, plan: CalibrationPlan) -> CalibrationProblem:
        """Return the same data with another plan, whose datum is held."""
        return CalibrationProblem.of(self.robot, self.measured, plan)

    def weighed_as(self, other: CalibrationProblem) -> Self:
        """Return the same problem with the weights of another one of the same rows."""
        share = self.factors.get(SURVEY, 1.0) / other.factors.get(SURVEY, 1.0)
        again = self.with_survey_weighed(share)
        return replace(again, weights=other.weights, found_encoder=other.found_encoder, factors=other.factors)

    def with_survey_weighed(self, share: float) -> Self:
        """Return the same with *share* times the weight of surveyed points and the level; that of distances stays."""
        by, rows = np.where(self.is_prior[len(self.plan.distances) :], 1.0, share), self.rows
        return replace(self, rows=rows._replace(linear=rows.linear * by[:, None], wanted=rows.wanted * by))

    def for_poses_only(self, theta: Array) -> CalibrationProblem:
        """Return the same problem with all unknowns held at *theta* (k,), so that only the poses are free."""
        lines, nothing = self.line_numbers(theta), np.full_like(self.rows.target, -1)
        rows = self.rows._replace(lines=lines, target=nothing, linear=np.zeros((0, 0)), wanted=np.zeros(0))
        whole, held = self.whole(theta), np.ones_like(self.held)
        return replace(self, rows=rows, limits=np.zeros((2, 0)), start=whole, held=held, frame=NO_FRAME)

    @property
    def poses(self) -> int:
        """The number N of poses."""
        return len(self.measured.counted)

    @property
    def elastic(self) -> bool:
        """Whether lines stretch or sag, and so have their tensions from equilibria."""
        return False

    @property
    def cable(self) -> str:
        """The cable law: rigid, elastic or catenary."""
        return "rigid"

    @property
    def unknowns_per_pose(self) -> int:
        """The number p of unknowns of each pose."""
        return self.robot.n

    def poses_of(self, states: Array) -> Array:
        """Return the poses (N, n) in the states (N, ..) of the poses."""
        return states

    def with_poses(self, states: Array, poses: Array) -> Array:
        """Return the states (N, ..) with other *poses* (N, n) in them."""
        del states
        return poses

    def is_finite(self, theta: Array, states: Array) -> bool:
        """Whether every sensor has a value at these states (N, ..)."""
        return bool(np.isfinite(self.lengths(theta, states)).all())

    def stepped(self, theta: Array, states: Array, change: Array, by: Array) -> Array:
        """Return the states after the free unknowns change by *change* (k,) and those of the poses by *by* (N, p)."""
        del theta, change
        return states + by

    def adjust(
        self, theta: Array, states: Array, weights: Array, settings: StopRule, rows: MeasurementRows | None = None
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Minimise the cost from starts *theta* (B, k), *states* (B, N, ..), in place: codes, steps and costs (B,)."""
        runs = len(theta)
        codes, steps, costs = np.zeros(runs, dtype=np.int64), np.zeros(runs, dtype=np.int64), np.zeros(runs)
        values, weight = self.values[None], np.ascontiguousarray(weights)[None]
        pose_schur.adjust_runs(
            self.in_frame(rows or self.rows), self.limits, theta, states, values, weight, settings, codes, steps, costs
        )
        return codes, steps, costs

    def in_frame(self, rows: MeasurementRows) -> MeasurementRows:
        """Return *rows* with those that hold what the data leave open: without them it creeps from step to step."""
        held, wanted = self.frame
        if not len(held):
            return rows
        return rows._replace(linear=np.concatenate([rows.linear, held]), wanted=np.append(rows.wanted, wanted))

    @property
    def encoder_sigma(self) -> float:
        """The standard deviation in the encoders' weights, m."""
        return self.found_encoder or self.plan.sigma.encoder or ENCODER_SIGMA

    @property
    def has_other_sensors(self) -> bool:
        """Whether there are rows of known sigma besides the encoders'."""
        return self.per_pose > self.robot.m or len(self.is_prior) > 0

    def line_numbers(self, theta: Array) -> Array:
        """Return the numbers of all lines (m, COLUMNS), with free unknowns *theta*."""
        lines, target = self.rows.lines.copy(), self.rows.target
        lines[target >= 0] = theta[target[target >= 0]]
        return lines

    def counts_at(self, theta: Array, states: Array) -> Array:
        """Return what the encoders (N, m) should read at these states of the poses, m."""
        lines = self.line_numbers(theta)
        out = (self.lengths(theta, states) - lines[:, calibration_residuals.OFFSET]) / lines[
            :, calibration_residuals.SCALE
        ]
        left = 1.0 - 2.0 * lines[:, calibration_residuals.BUILD_UP] * out  # square of the radius, as a share
        return np.asarray(2.0 * out / (1.0 + np.sqrt(np.maximum(left, 0.0))))

    @property
    def free(self) -> Array:
        """Start values of the free unknowns."""
        return np.ascontiguousarray(self.start[~self.held])

    @cached_property
    def free_unknowns(self) -> tuple[Unknown, ...]:
        """The unknowns that are not held, in the order of theta."""
        return tuple(each for each, held in zip(self.unknowns, self.held, strict=True) if not held)

    def named(self, name: str) -> Mask:
        """Return which of the free unknowns have a name, as ``exit_point``."""
        return np.array([each.name == name for each in self.free_unknowns], dtype=bool)

    def whole(self, theta: Array) -> Array:
        """Return all unknowns (..., k), of which *theta* has the free ones."""
        found = np.broadcast_to(self.start, (*theta.shape[:-1], len(self.start))).copy()
        found[..., ~self.held] = theta
        return found

    def lengths(self, theta: Array, poses: Array) -> Array:
        """Return the length (N, m) of each line from its exit point to the platform, m."""
        found = np.zeros((len(poses), self.robot.m))
        calibration_residuals.lengths_at(self.rows, np.ascontiguousarray(theta), np.ascontiguousarray(poses), found)
        return found

    def exit_points(self, theta: Array) -> Array:
        """Return the exit points (m, 3), m, with free unknowns *theta*."""
        return self.points(theta, "exit_point")

    def points(self, theta: Array, kind: str) -> Array:
        """Return the exit points or platform points (m, 3), m, with free unknowns *theta*."""
        points = np.array([getattr(line, kind) for line in self.robot.lines])
        which, coordinates = coordinates_of(self.robot, self.unknowns, kind)
        points.flat[coordinates] = self.whole(theta)[which]
        return points

    def derivatives(self, theta: Array, poses: Array, weights: Array | None = None) -> Derivatives:
        """Return residuals and derivatives at free unknowns *theta* and *poses* (N, n)."""
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
        """Return the problem with measured tensions, if any, replaced by the nearest ones that balance the load.

        An unbalanced force would turn with the frame, and so seem to determine its direction.
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
        """Return the part (N, e) of row *weights* that belongs to poses; a view."""
        return weights[: self.poses * self.per_pose].reshape(self.poses, self.per_pose)


def equations(
    robot: Robot, measured: Measured, plan: CalibrationPlan, hold: bool, elastic: bool
) -> tuple[tuple[Unknown, ...], MeasurementRows, Array, Array, int, Array, Mask, Mask, Array]:
    """Return the fields of a `CalibrationProblem` from `unknowns` on; *elastic*: whether lines stretch or sag."""
    robot.require_plain("calibration")
    unknowns = unknowns_of(robot, plan.unknowns, plan.shared, elastic=elastic)
    if not unknowns:
        raise InputError("unknowns: must name at least one number")
    lines, target = numbers_of_lines(robot), targets(robot, unknowns)
    start = np.array([each.entry.nominal or 0.0 for each in unknowns])
    start[target[target >= 0]] = lines[target >= 0]
    held = held_by_datum(robot, unknowns, plan) if hold else np.zeros(len(unknowns), dtype=bool)
    if held.all():
        raise InputError("datum: holds every unknown; nothing is left to calibrate")
    count, distances = len(measured.counted), _distances(robot, plan)
    blocks = list(_blocks(robot, measured, plan, elastic))
    per_pose = sum(block.values.shape[1] for block in blocks)
    linear, wanted, prior = linear_rows(robot, unknowns, plan, start)
    limits = np.ascontiguousarray(ranges(robot, unknowns, plan, start, measured.counted)[:, ~held])

    def of_rows(name: str, dtype: type, *shape: int) -> Any:
        """A field of the blocks for all R rows: those of the poses in their order, then distances."""
        full: list[NDArray[Any]] = [
            np.broadcast_to(np.asarray(getattr(block, name), dtype=dtype), (*block.values.shape, *shape))
            for block in (*blocks, distances)
        ]
        both = np.concatenate(full[:-1], axis=1), full[-1]
        return np.concatenate([each.reshape(-1, *shape) for each in both])

    rows = MeasurementRows(
        freedoms=robot.n,
        start=np.arange(count + 1, dtype=np.int64) * per_pose,
        kind=of_rows("kind", np.int64),
        line=of_rows("line", np.int64),
        other=of_rows("other", np.int64),
        extra=of_rows("extra", np.float64, 6),
        lines=lines,
        target=np.where((target >= 0) & ~held[target], (np.cumsum(~held) - 1)[target], -1),
        tensions=np.zeros((count, robot.m)) if measured.tensions is None else np.ascontiguousarray(measured.tensions),
        load=_load(robot),
        linear=np.ascontiguousarray(linear[:, ~held]),
        wanted=wanted - linear[:, held] @ start[held],
    )
    is_prior = np.append(np.zeros(len(plan.distances), dtype=bool), prior)
    values, weights = of_rows("values", np.float64), of_rows("weights", np.float64)
    return unknowns, rows, values, weights, per_pose, start, held, is_prior, limits


class _Block(NamedTuple):
    """Rows of one sensor, r at each of N poses; what is not an array is the same in all rows, see `MeasurementRows`."""

    kind: int
    values: Array  # (N, r)
    weights: Array | float
    line: ArrayLike = 0
    other: ArrayLike = 0
    extra: ArrayLike = 0


def _distances(robot: Robot, plan: CalibrationPlan) -> _Block:
    """Return the rows (1, d) of measured distances between exit points, which belong to no pose."""
    ends = [
        line_index(robot, name, f"distances[{at}]") for at, each in enumerate(plan.distances) for name in each.between
    ]
    values, sigmas = (np.array([[getattr(each, name) for each in plan.distances]]) for name in ("value", "deviation"))
    return _Block(calibration_residuals.BETWEEN, values, 1.0 / sigmas, ends[::2], ends[1::2])


def _blocks(robot: Robot, measured: Measured, plan: CalibrationPlan, elastic: bool) -> Iterator[_Block]:
    """Yield the rows of each sensor that the data have: encoders first, then tensions if each is a row of its own."""
    sigma, lines = plan.sigma, np.arange(robot.m)
    encoder = calibration_residuals.PAID_OUT if elastic else calibration_residuals.ENCODER
    yield _Block(encoder, measured.counted, 1.0 / (sigma.encoder or ENCODER_SIGMA), lines)
    if elastic and measured.tensions is not None:
        yield _Block(calibration_residuals.TENSION, measured.tensions, 1.0 / sigma.tension, lines)
    if measured.pose_sigma is not None:
        assert measured.guess is not None
        places = np.nan_to_num(measured.guess)
        extra = np.zeros((*places.shape, 6))
        if robot.n == 6:
            extra[:, 3:, :3] = places[:, None, 3:]
        weights = np.nan_to_num(1.0 / measured.pose_sigma)  # 0 where it is blank
        yield _Block(calibration_residuals.COORDINATE, places, weights, other=np.arange(robot.n), extra=extra)
    if measured.swivel is not None:
        yield _Block(calibration_residuals.SWIVEL, measured.swivel, 1.0 / sigma.swivel, lines)
    if measured.tilt is not None:
        if robot.n == 3:
            raise InputError(
                f"{measured.origin}: tilt_x, tilt_y: {robot.name!r} is a point platform, which has no tilt"
            )
        yield _Block(calibration_residuals.TILT, measured.tilt, 1.0 / sigma.tilt, other=np.arange(2))
    if not elastic and measured.tensions is not None:
        yield _balance(robot, measured, sigma.tension)
    nozzle = robot.platform.nozzle if isinstance(robot.platform, RigidPlatform) else robot.lines[0].platform_point
    for index, plane in enumerate(plan.planes):
        at = _at_poses(measured, plane.poses, f"planes[{index}]")
        normal = np.asarray(plane.normal) / math.hypot(*plane.normal)
        weights = at[:, None] / plane.deviation
        values = np.full(weights.shape, float(normal @ plane.point))
        yield _Block(calibration_residuals.PLANE, values, weights, extra=np.append(normal, nozzle))
    for index, reach in enumerate(plan.ranges):
        at = _at_poses(measured, reach.poses, f"ranges[{index}]")
        values = np.zeros((len(at), 1))
        values[np.asarray(reach.poses) - 1, 0] = reach.values
        yield _Block(
            calibration_residuals.REACH, values, at[:, None] / reach.deviation, extra=np.append(reach.point, nozzle)
        )


def _at_poses(measured: Measured, poses: Sequence[int], where: str) -> Array:
    """Return 1 at each of the poses (counted from 1), 0 at the others, (N,)."""
    if max(poses) > len(measured.counted):
        raise InputError(f"{where}.poses: there is no pose {max(poses)}; the data have {len(measured.counted)}")
    at = np.zeros(len(measured.counted))
    at[np.asarray(poses) - 1] = 1.0
    return at


def _balance(robot: Robot, measured: Measured, sigma: float) -> _Block:
    """Return the rows of measured tensions: the wrench they leave unbalanced, along directions of independent errors.

    A tension's error acts along its line, so the wrench has the covariance sigma^2 sum w w^T, w = (u, r x u). The
    directions u are those from the file's exit points to the platform points at the start values of the poses.
    """
    guess, count, n = measured.guess, len(measured.counted), robot.n
    if guess is None:
        raise InputError(f"{measured.origin}: tensions f_1.. require columns x,y,z, start values of the poses")
    if np.isnan(guess).any():
        row = measured.place(int(np.argmax(np.isnan(guess).any(axis=1))))
        raise InputError(f"{measured.origin}, {row}: x, y, z are blank; with tensions f_1.. a start value is required")
    points = placed(guess, [line.platform_point for line in robot.lines])
    away = points - np.array([line.exit_point for line in robot.lines])
    u = away / np.linalg.norm(away, axis=2)[..., None]
    w = np.concatenate([u, np.cross(points - guess[:, None, :3], u)], axis=2)[..., :n]
    spread = np.einsum("nmi,nmj->nij", w, w)
    size = np.einsum("nii->ni", spread)[:, None] * np.eye(n)  # m and N: small is relative to the same row
    extra = np.zeros((count, n, 6))
    extra[..., :n] = np.linalg.inv(np.linalg.cholesky(spread + 1e-6 * size)) / sigma
    return _Block(calibration_residuals.BALANCE, np.zeros((count, n)), 1.0, extra=extra)


def _load(robot: Robot) -> Array:
    """Return the load (10,) on the platform: external force (N) and moment (N m), weight (N) and its centre (m)."""
    platform, load = robot.platform, np.zeros(10)
    load[:3], load[6] = platform.force, platform.mass * robot.scene.gravity
    if isinstance(platform, RigidPlatform):
        load[3:6], load[7:] = platform.moment, platform.centre_of_mass
    return load


def _loads(load: Array, poses: Array) -> Array:
    """Return the wrench (N, n) of a load at *poses* (N, n) about the platform's origin, N and N m."""
    weight = np.array([0.0, 0.0, -load[6]])
    found = np.tile(load[:6], (len(poses), 1))
    found[:, :3] += weight
    arms = placed(poses, [load[7:]])[:, 0] - poses[:, :3]
    found[:, 3:] += np.cross(arms, weight)
    return found[:, : poses.shape[1]]
