"""A calibration as rows of equations: every sensor adds rows to one least-squares problem, with a pose or without."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array, Mask
from cablewright.calibration.measured import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.poses.bounds import ranges
from cablewright.calibration.sensors.exit_points import held_by_datum, linear_rows, mounts_tell_yaw
from cablewright.calibration.sensors.positions import free_directions
from cablewright.calibration.sensors.rows import ENCODER_SIGMA, distance_rows, load_on, sensor_rows
from cablewright.calibration.unknowns import (
    Unknown,
    coordinates_of,
    numbers_of_lines,
    require_covered,
    targets,
    unknowns_of,
)
from cablewright.errors import InputError
from cablewright.kernels.fitting import calibration_residuals, pose_schur, straight_line
from cablewright.kernels.fitting.calibration_residuals import MeasurementRows
from cablewright.kernels.fitting.pose_schur import StopRule
from cablewright.models.plane import within
from cablewright.models.rotation import placed
from cablewright.robot import Robot

SURVEY: Final = "surveyed points and distances"
"""What people call the rows that belong to no pose."""

NO_FRAME: Final = (np.zeros((0, 0)), np.zeros(0))


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Weighted residuals and their derivatives: e rows at each of N poses, and g rows without a pose.

    The p unknowns of a pose are its freedoms for straight lines, n or those in a plane; its m lengths for elastic ones.
    """

    residual: Array  # (N, e)
    by_pose: Array  # (N, e, p)
    by_unknown: Array  # (N, e, k)
    others: Array  # (g,) residuals without a pose: distances, then linear rows
    others_by_unknown: Array  # (g, k)

    @property
    def whole(self) -> Mask:
        """Which poses (N,) have a value: not those inside a sheave, or without an equilibrium."""
        finite = np.isfinite(self.by_pose).all(axis=(1, 2)) & np.isfinite(self.residual).all(axis=1)
        return np.asarray(finite)

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
    and the state of a pose is the pose; `elastic.elastic_lines.ElasticProblem` is for elastic lines.
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
        """The number p of unknowns of each pose: its freedoms."""
        return self.robot.freedoms

    def poses_of(self, states: Array) -> Array:
        """Return the poses (N, n) in the states (N, ..) of the poses."""
        return states

    def in_plane(self, states: Array) -> Array:
        """Return the states (.., N, ..) of poses with each pose moved into the platform's plane, if there is one."""
        return within(self.robot.platform.plane, states)

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
        return states + by @ self.directions.T

    def adjust(
        self, theta: Array, states: Array, weights: Array, settings: StopRule, rows: MeasurementRows | None = None
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Minimise the cost from starts *theta* (B, k), *states* (B, N, ..), in place: codes, steps and costs (B,)."""
        runs = len(theta)
        codes, steps, costs = np.zeros(runs, dtype=np.int64), np.zeros(runs, dtype=np.int64), np.zeros(runs)
        values, weight = self.values[None], np.ascontiguousarray(weights)[None]
        pose_schur.adjust_runs(
            self.in_frame(rows or self.rows),
            self.directions,
            self.limits,
            theta,
            states,
            values,
            weight,
            settings,
            codes,
            steps,
            costs,
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

    def counts_at(self, theta: Array, states: Array, given: Array | float = 0.0) -> Array:
        """Return what the encoders (N, m) should read at these states of the poses, m.

        *given* (N, m): how much less cable lies beyond the winches as mounts of exits and springs give, m.
        """
        lines = self.line_numbers(theta)
        out = self.lengths(theta, states) - lines[:, straight_line.OFFSET] - given
        left = 1.0 - 2.0 * lines[:, straight_line.BUILD_UP] * out  # square of the radius, as a share
        first = 2.0 * out / (1.0 + np.sqrt(np.maximum(left, 0.0)))
        return np.asarray(first / lines[:, straight_line.SCALE])

    @cached_property
    def directions(self) -> Array:
        """A basis (n, p) of the directions in which the rows' poses are free, its columns orthonormal."""
        return np.eye(self.robot.n) if self.elastic else free_directions(self.robot)

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
        """Return the length (N, m) of each line's cable beyond its exit point, m: of all its spans."""
        found = np.zeros((len(poses), self.robot.m))
        calibration_residuals.lengths_at(self.rows, np.ascontiguousarray(theta), np.ascontiguousarray(poses), found)
        return found

    def given(self, theta: Array, states: Array) -> Array:
        """Return how much less cable (N, m) lies beyond the winches as mounts and springs give, m, at all N poses."""
        return self.tensions(theta) * self.given_per_tension(theta, states) if self.is_soft else np.zeros(1)

    @property
    def is_soft(self) -> bool:
        """Whether mounts of exits or springs give, or may give, besides what an equilibrium counts."""
        unknown, known = (each[:, straight_line.GIVING] for each in (self.rows.target >= 0, self.rows.lines))
        return bool(unknown.any() or known.any())

    def given_per_tension(self, theta: Array, states: Array) -> Array:
        """Return by how much less cable (N, m) lies beyond the winches per tension, m/N."""
        poses = np.ascontiguousarray(self.poses_of(states))
        found = np.zeros((len(poses), self.robot.m))
        calibration_residuals.given_at(self.rows, np.ascontiguousarray(theta), poses, found)
        return found

    def tensions(self, theta: Array) -> Array:
        """Return the tensions (N, m) that load cells measured, N, with their offsets and scales in *theta*."""
        lines = self.line_numbers(theta)
        scale, offset = lines[:, straight_line.TENSION_SCALE], lines[:, straight_line.TENSION_OFFSET]
        return np.asarray(scale * self.rows.tensions + offset)

    def known_tensions(self, theta: Array, states: Array) -> Array | None:
        """Return the tensions (N, m) that are measured, N, or those of equilibria at *states*; None for neither."""
        del states
        return None if self.measured.tensions is None else self.tensions(theta)

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
        residuals, slopes, gradients = np.zeros(total), np.zeros((total, self.rows.freedoms)), np.zeros((total, k))
        theta, poses = np.ascontiguousarray(theta), np.ascontiguousarray(poses)
        calibration_residuals.derivatives(
            self.rows, self.directions, theta, poses, self.values, used, residuals, slopes, gradients
        )
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
        m, cables = self.robot.m, np.array([line.cables for line in self.robot.lines])
        found = self.derivatives(theta, poses, np.ones(len(self.values)))
        u = np.swapaxes(found.by_pose[:, :m], 1, 2) * cables  # (N, p, m): lengths change as forces and moments do
        true, scale = self.tensions(theta), self.line_numbers(theta)[:, straight_line.TENSION_SCALE]
        left = _loads(self.rows.load, poses) @ self.directions - np.einsum("nam,nm->na", u, true)
        readings = self.rows.tensions + np.einsum("nma,na->nm", np.linalg.pinv(u), left) / scale
        return replace(self, rows=self.rows._replace(tensions=np.ascontiguousarray(readings)))

    def of_poses(self, weights: Array) -> Array:
        """Return the part (N, e) of row *weights* that belongs to poses; a view."""
        return weights[: self.poses * self.per_pose].reshape(self.poses, self.per_pose)


def equations(
    robot: Robot, measured: Measured, plan: CalibrationPlan, hold: bool, elastic: bool
) -> tuple[tuple[Unknown, ...], MeasurementRows, Array, Array, int, Array, Mask, Mask, Array]:
    """Return the fields of a `CalibrationProblem` from `unknowns` on; *elastic*: whether lines stretch or sag."""
    require_covered(robot, elastic)
    unknowns = unknowns_of(robot, plan.unknowns, plan.shared, elastic, plan.grouped)
    if not unknowns:
        raise InputError("unknowns: must name at least one number")
    lines, target = numbers_of_lines(robot), targets(robot, unknowns)
    start = np.array([each.entry.nominal or 0.0 for each in unknowns])
    start[target[target >= 0]] = lines[target >= 0]
    if elastic:  # equilibria count what gives
        lines[:, straight_line.GIVING], target[:, straight_line.GIVING] = 0.0, -1
    held = held_by_datum(robot, unknowns, plan) if hold else np.zeros(len(unknowns), dtype=bool)
    if held.all():
        raise InputError("datum: holds every unknown; nothing is left to calibrate")
    count, distances = len(measured.counted), distance_rows(robot, plan)
    blocks = list(sensor_rows(robot, measured, plan, elastic))
    per_pose = sum(block.values.shape[1] for block in blocks)
    keep_yaw = not held.any() and mounts_tell_yaw(robot, unknowns, plan, measured)
    linear, wanted, prior = linear_rows(robot, unknowns, plan, start, keep_yaw)
    limits = np.ascontiguousarray(ranges(robot, unknowns, plan, start, measured)[:, ~held])

    def of_rows(name: str, dtype: type, *shape: int) -> Any:
        """A field of the blocks for all R rows: those of the poses in their order, then distances."""
        full: list[NDArray[Any]] = [
            np.broadcast_to(np.asarray(getattr(block, name), dtype=dtype), (*block.values.shape, *shape))
            for block in (*blocks, distances)
        ]
        both = np.concatenate(full[:-1], axis=1), full[-1]
        return np.concatenate([each.reshape(-1, *shape) for each in both])

    rows = MeasurementRows(
        freedoms=robot.n if elastic else robot.freedoms,  # equilibria of elastic lines stay in the plane
        start=np.arange(count + 1, dtype=np.int64) * per_pose,
        kind=of_rows("kind", np.int64),
        line=of_rows("line", np.int64),
        other=of_rows("other", np.int64),
        extra=of_rows("extra", np.float64, 6),
        lines=lines,
        target=np.where((target >= 0) & ~held[target], (np.cumsum(~held) - 1)[target], -1),
        tensions=np.zeros((count, robot.m)) if measured.tensions is None else np.ascontiguousarray(measured.tensions),
        load=load_on(robot),
        linear=np.ascontiguousarray(linear[:, ~held]),
        wanted=wanted - linear[:, held] @ start[held],
    )
    is_prior = np.append(np.zeros(len(plan.distances), dtype=bool), prior)
    values, weights = of_rows("values", np.float64), of_rows("weights", np.float64)
    return unknowns, rows, values, weights, per_pose, start, held, is_prior, limits


def _loads(load: Array, poses: Array) -> Array:
    """Return the wrench (N, n) of a load at *poses* (N, n) about the platform's origin, N and N m."""
    weight = np.array([0.0, 0.0, -load[6]])
    found = np.tile(load[:6], (len(poses), 1))
    found[:, :3] += weight
    arms = placed(poses, [load[7:]])[:, 0] - poses[:, :3]
    found[:, 3:] += np.cross(arms, weight)
    return found[:, : poses.shape[1]]
