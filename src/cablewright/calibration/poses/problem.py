"""Calibration as one least-squares problem: every sensor adds rows of equations, with a pose or without.

`CalibrationProblem` is the problem under any cable law. There are two sets of equations: `StraightProblem` for rigid
lines, and `ElasticProblem` for lines that stretch or sag.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, Final, Self

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.measurement_rows.all_rows import ENCODER_SIGMA, every_row, sensor_rows
from cablewright.calibration.measurement_rows.given_numbers import put_known
from cablewright.calibration.measurement_rows.load_cells import (
    balanced_readings,
    exact_counterweights,
    filled_tensions,
    is_unseen,
    load_on,
    with_counterweights,
)
from cablewright.calibration.measurement_rows.without_pose import (
    distance_rows,
    held_by_datum,
    linear_rows,
    mounts_tell_yaw,
)
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.poses.derivatives import Derivatives, of_free, with_unknowns
from cablewright.calibration.poses.ranges_of_unknowns import ranges
from cablewright.calibration.sightings.sighted import bodies_of
from cablewright.calibration.unknowns import (
    Unknown,
    coordinates_of,
    free_directions,
    numbers_of_lines,
    targets,
    unknowns_of,
    with_mounts,
)
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.kernels.fitting import calibration_lengths, calibration_residuals, line_over_sheave, pose_schur
from cablewright.kernels.fitting.calibration_residuals import MeasurementRows
from cablewright.kernels.fitting.pose_schur import StopRule
from cablewright.models.fidelity import CableLaw
from cablewright.models.pack import guided_lines
from cablewright.models.plane import within
from cablewright.models.shared_winches import shares
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.robot.parameters import nominal

SURVEY: Final = "surveyed points and distances"
"""What people call the rows that belong to no pose."""

NO_FRAME: Final = (np.zeros((0, 0)), np.zeros(0))
_EXACT: Final = 1e-8  # m: smaller residuals and sigmas are rounding, however small the others are


@dataclass(frozen=True, eq=False)
class CalibrationProblem(ABC):
    """The equations of a calibration. `weights` are 1 / sigma; a row with weight 0 does not count.

    `held`: the unknowns that the datum holds at their value in `start`; theta and `rows` have the free ones only.
    `frame`: rows (d, k) and values (d,) that hold undetermined combinations, in fits only. The state (N, ..) of a pose
    is stored; its columns `pose_columns` are the pose.
    """

    elastic: ClassVar[bool]  # whether lines stretch or sag, and so have their tensions from equilibria

    model: Model
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
    stated: int = 0  # of these rows, the last ones: of tags and the lens, for which there is no other measurement
    frame: tuple[Array, Array] = NO_FRAME
    found_encoder: float | None = None  # m, the encoders' sigma from the residuals
    factors: Mapping[str, float] = field(default_factory=dict)  # on given sigmas, by kind of measurement

    @classmethod
    def of(
        cls, robot: Robot | Model, measured: Measured, plan: CalibrationPlan | None = None, hold: bool = True
    ) -> Self:
        """Build the rows; *hold*: whether the unknowns that the plan's datum names are held.

        Raises `InputError` for names in the plan that the robot or the data do not have, and a contradictory datum.
        """
        plan, model = plan or CalibrationPlan(), Model.of(robot, default=CableLaw.RIGID)
        if cls.elastic and "exit_compliance" in plan.unknowns:
            model = replace(model, robot=with_mounts(model.robot))
        robot = model.robot
        if not cls.elastic:
            measured = with_counterweights(robot, measured, plan.sigma)
        unknowns = unknowns_of(robot, plan.unknowns, plan.shared, cls.elastic, plan.grouped)
        unknowns = tuple(each for each in unknowns if not is_unseen(robot, each, measured, plan, cls.elastic))
        if not unknowns:
            raise InputError("unknowns: must name at least one number")
        seen = bodies_of(measured.sightings, unknowns)
        lines, target = numbers_of_lines(robot, measured.by_drum, cls.elastic), targets(robot, unknowns)
        put_known(robot, lines, plan)
        exact_counterweights(robot, lines, target, cls.elastic)
        start = np.array([nominal(robot, each) if each.column < 0 else each.entry.nominal or 0.0 for each in unknowns])
        start[target[target >= 0]] = lines[target >= 0]
        unknowns, start = (*unknowns, *seen.unknowns), np.append(start, [each.start for each in seen.unknowns])
        if cls.elastic:  # equilibria include compliance
            lines[:, line_over_sheave.GIVING], target[:, line_over_sheave.GIVING] = 0.0, -1
        held = held_by_datum(robot, unknowns, plan) if hold else np.zeros(len(unknowns), dtype=bool)
        if held.all():
            raise InputError("datum: holds every unknown; nothing is left to calibrate")
        keep_yaw = not held.any() and mounts_tell_yaw(robot, unknowns, plan, measured)
        linear, wanted, prior = linear_rows(robot, unknowns, plan, start, keep_yaw, (seen.linear, seen.wanted))
        blocks = list(sensor_rows(robot, measured, plan, cls.elastic))
        of_rows, per_pose = every_row(blocks, distance_rows(robot, plan)), sum(each.values.shape[1] for each in blocks)
        tensions = filled_tensions(robot, measured, cls.elastic)
        rows = MeasurementRows(
            freedoms=robot.n if cls.elastic else robot.freedoms,  # equilibria of elastic lines stay in the plane
            start=np.arange(len(measured.counted) + 1, dtype=np.int64) * per_pose,
            kind=of_rows["kind"],
            line=of_rows["line"],
            other=of_rows["other"],
            extra=of_rows["extra"],
            lines=lines,
            target=of_free(target, held),
            tensions=np.ascontiguousarray(tensions),
            load=load_on(robot),
            linear=np.ascontiguousarray(linear[:, ~held]),
            wanted=wanted - linear[:, held] @ start[held],
            bodies=seen.table,
            body_target=of_free(seen.target, held),
            guided=guided_lines(robot),
        )
        return cls(
            model,
            measured,
            plan,
            unknowns,
            rows,
            of_rows["values"],
            of_rows["weights"],
            per_pose,
            start,
            held,
            is_prior=np.append(np.zeros(len(plan.distances), dtype=bool), prior),
            stated=len(seen.wanted),
            limits=np.ascontiguousarray(ranges(robot, unknowns, plan, start, measured)[:, ~held]),
        )

    def with_plan(self, plan: CalibrationPlan, hold: bool = True) -> Self:
        """Return the problem of the same data under another plan. *hold*: keep the unknowns of its datum fixed."""
        return self.of(self.model, self.measured, plan, hold)

    def without_datum(self) -> Self:
        """Return the problem with no unknown held."""
        return self.with_plan(self.plan, hold=False)

    def weighed_as(self, other: CalibrationProblem) -> Self:
        """Return the problem with the weights of *other*, a problem with the same rows."""
        again = self.with_survey_weighed(self.factors.get(SURVEY, 1.0) / other.factors.get(SURVEY, 1.0))
        return replace(again, weights=other.weights, found_encoder=other.found_encoder, factors=other.factors)

    def with_survey_weighed(self, share: float) -> Self:
        """Return the problem with *share* times the weight of surveyed points and level; that of distances stays."""
        by, rows = np.where(self.is_prior[len(self.plan.distances) :], 1.0, share), self.rows
        return replace(self, rows=rows._replace(linear=rows.linear * by[:, None], wanted=rows.wanted * by))

    def for_poses_only(self, theta: Array, but: Mask | None = None) -> Self:
        """Return the problem with all unknowns held at *theta* (k,) *but* some (k,), so that only poses are free."""
        fixed = np.ones(len(theta), dtype=bool) if but is None else np.logical_not(but)
        free, linear = np.logical_not(fixed), self.rows.linear
        rows = self.rows._replace(
            lines=self.line_numbers(theta),
            target=of_free(self.rows.target, fixed),
            bodies=self.bodies(theta),
            body_target=of_free(self.rows.body_target, fixed),
            linear=np.ascontiguousarray(linear[:, free] if free.any() else np.zeros((0, 0))),
            wanted=self.rows.wanted - linear[:, fixed] @ theta[fixed] if free.any() else np.zeros(0),
        )
        held = np.ones_like(self.held)
        held[~self.held] = fixed
        limits = np.ascontiguousarray(self.limits[:, free])
        return replace(self, rows=rows, limits=limits, start=self.whole(theta), held=held, frame=NO_FRAME)

    @property
    def robot(self) -> Robot:
        """The robot, whose numbers are the start values."""
        return self.model.robot

    @property
    def poses(self) -> int:
        """The number N of poses."""
        return len(self.measured.counted)

    @property
    def cable(self) -> str:
        """The cable law: rigid, elastic or catenary."""
        return self.model.fidelity.cable.value

    @property
    def lengths_per_pose(self) -> int:
        """The number of rows of each pose that are lengths: those of encoders, and of lines on one drum."""
        return self.robot.m + len(self.robot.sharing)

    def in_lengths(self, lengths: Array) -> Array:
        """Return changes of *lengths* (N, m), m, as changes of the rows (N, e) of a pose, m: 0 of other sensors."""
        found = np.zeros((len(lengths), self.per_pose))
        found[:, : self.robot.m] = lengths
        for at, (own, other, sense, _) in enumerate(shares(self.robot).tolist(), self.robot.m):
            found[:, at] = lengths[:, int(own)] - sense * lengths[:, int(other)]
        return found

    @property
    def unknowns_per_pose(self) -> int:
        """The number p of unknowns of each pose: its degrees of freedom, or the lengths of lines that stretch.

        The length of a line with a counterweight is none: its weight decides it.
        """
        return self.robot.m - len(self.robot.hung) if self.elastic else self.robot.freedoms

    @property
    def pose_columns(self) -> slice:
        """The columns of a state that are the pose: all, or those after the lengths of lines that stretch."""
        before = self.robot.m if self.elastic else 0
        return slice(before, before + self.robot.n)

    @abstractmethod
    def is_finite(self, theta: Array, states: Array) -> bool:
        """Return whether every sensor's equation has a value at the poses' states (N, ..)."""

    @abstractmethod
    def lengths(self, theta: Array, states: Array) -> Array:
        """Return the length (N, m) of each line's cable that encoders count, m: of all its spans together."""

    def known_tensions(self, theta: Array, states: Array) -> Array | None:
        """Return the tensions (N, m) that are measured, N, or those of equilibria at *states*; None for neither."""
        del states
        return None if self.measured.tensions is None else self.tensions(theta)

    def balanced(self, theta: Array, states: Array) -> Self:
        """Return the problem with measured tensions, if any, replaced by the nearest ones that balance the load.

        An unbalanced force would turn with the frame, and so seem to determine its direction. At an equilibrium
        tensions are balanced.
        """
        del theta, states
        return self

    @abstractmethod
    def derivatives(self, theta: Array, states: Array, weights: Array | None = None) -> Derivatives:
        """Return residuals and derivatives at free unknowns *theta* and *states* (N, ..)."""

    @abstractmethod
    def adjust(
        self, theta: Array, states: Array, weights: Array, settings: StopRule
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Minimise the cost from starts *theta* (B, k), *states* (B, N, ..), in place: codes, steps and costs (B,)."""

    def poses_of(self, states: Array) -> Array:
        """Return the poses (N, n) in the states (N, ..) of the poses."""
        return states[..., self.pose_columns]

    def with_poses(self, states: Array, poses: Array) -> Array:
        """Return the states (N, ..) with other *poses* (N, n) in them."""
        moved = states.copy()
        moved[..., self.pose_columns] = poses
        return moved

    def in_frame(self) -> Self:
        """Return the problem with rows that fix the undetermined combinations, which would drift from step to step."""
        held, wanted = self.frame
        return self if not len(held) else self.with_linear(held, wanted)

    def with_linear(self, linear: Array, wanted: Array) -> Self:
        """Return the problem with more rows *linear* (d, k) in the unknowns, and their values (d,)."""
        rows = self.rows
        both = np.concatenate([rows.linear, linear]), np.append(rows.wanted, wanted)
        return replace(self, rows=rows._replace(linear=both[0], wanted=both[1]))

    @property
    def encoder_sigma(self) -> float:
        """The standard deviation of the encoders that their weights assume, m."""
        return self.found_encoder or self.plan.sigma.encoder or ENCODER_SIGMA

    @property
    def floor(self) -> float:
        """The smallest sigma of a row relative to that of its weight, for data without noise."""
        return _EXACT / self.encoder_sigma

    @property
    def has_other_sensors(self) -> bool:
        """Whether there are rows beside those of encoders that need a weight: of sensors, and of lines on one drum."""
        return self.per_pose > self.robot.m or len(self.is_prior) > 0

    def line_numbers(self, theta: Array) -> Array:
        """Return the numbers of all lines (m, COLUMNS), with free unknowns *theta*."""
        return with_unknowns(self.rows.lines, self.rows.target, theta)

    def counts_at(self, theta: Array, states: Array, given: Array | float = 0.0) -> Array:
        """Return the expected readings of the encoders (N, m) at these states of the poses, m.

        *given* (N, m): by how much mounts of exit points and springs shorten the cable beyond the winches, m.
        """
        lines = self.line_numbers(theta)
        offset, wound = lines[:, line_over_sheave.OFFSET], lines[:, line_over_sheave.WOUND]
        out, twice = self.lengths(theta, states) - offset - given, 2.0 * lines[:, line_over_sheave.BUILD_UP]
        first = 1.0 - twice * np.where(wound == 0.0, 0.0, offset - wound)  # square of the radius, as a share
        left = first - twice * out
        first = 2.0 * out / (np.sqrt(np.maximum(first, line_over_sheave.LEAST_SQUARE)) + np.sqrt(np.maximum(left, 0.0)))
        return np.asarray(first / lines[:, line_over_sheave.SCALE])

    def bodies(self, theta: Array) -> Array:
        """Return the numbers of the camera and of each tag (b, BODY_COLUMNS), with the unknowns *theta* put in."""
        return with_unknowns(self.rows.bodies, self.rows.body_target, theta)

    @property
    def free(self) -> Array:
        """Start values of the free unknowns."""
        return np.ascontiguousarray(self.start[~self.held])

    @cached_property
    def free_unknowns(self) -> tuple[Unknown, ...]:
        """The unknowns that are not held, in the order of theta."""
        return tuple(each for each, held in zip(self.unknowns, self.held, strict=True) if not held)

    def named(self, name: str) -> Mask:
        """Return which of the free unknowns have this name, as ``exit_point``."""
        return np.array([each.name == name for each in self.free_unknowns], dtype=bool)

    def whole(self, theta: Array) -> Array:
        """Return all unknowns (..., k): the free ones from *theta*, the held ones at their values."""
        found = np.broadcast_to(self.start, (*theta.shape[:-1], len(self.start))).copy()
        found[..., ~self.held] = theta
        return found

    @property
    def is_soft(self) -> bool:
        """Return whether mounts of exit points or springs yield beyond the compliance in the equilibrium."""
        unknown, known = (each[:, line_over_sheave.GIVING] for each in (self.rows.target >= 0, self.rows.lines))
        return bool(unknown.any() or known.any())

    def given(self, theta: Array, states: Array, tensions: Array | None = None) -> Array:
        """Return by how much mounts and springs shorten the cable beyond the winches at N poses (N, m), m.

        By *tensions* (N, m), N, or those that are measured.
        """
        if not self.is_soft:
            return np.zeros(1)
        poses = np.ascontiguousarray(self.poses_of(states))
        found = np.zeros((len(poses), self.robot.m))
        calibration_lengths.given_at(self.rows, np.ascontiguousarray(theta), poses, found)
        return found * (self.tensions(theta) if tensions is None else tensions)

    def tensions(self, theta: Array) -> Array:
        """Return the tensions (N, m) that load cells measured, N, with their offsets and scales in *theta*."""
        lines = self.line_numbers(theta)
        scale, offset = lines[:, line_over_sheave.TENSION_SCALE], lines[:, line_over_sheave.TENSION_OFFSET]
        return np.asarray(scale * self.rows.tensions + offset)

    def points(self, theta: Array, kind: str = "exit_point") -> Array:
        """Return the exit points or platform points (m, 3), m, with free unknowns *theta*."""
        points = np.array([getattr(line, kind) for line in self.robot.lines])
        which, coordinates = coordinates_of(self.robot, self.unknowns, kind)
        points.flat[coordinates] = self.whole(theta)[which]
        return points

    def of_poses(self, weights: Array) -> Array:
        """Return the part (N, e) of row *weights* that belongs to poses; a view."""
        return weights[: self.poses * self.per_pose].reshape(self.poses, self.per_pose)

    @property
    def row_counts(self) -> NDArray[np.int64]:
        """The number (N,) of rows of each pose that count."""
        return np.asarray((self.of_poses(self.weights) > 0.0).sum(axis=1))

    def rows_at(self, theta: Array, poses: Array, weights: Array | None, directions: Array) -> Derivatives:
        """Return residuals and derivatives at *poses* (N, n), along *directions* (n, p), of straight lines."""
        used = self.weights if weights is None else weights
        count, e, k = self.poses, self.per_pose, len(theta)
        residuals, slopes = np.zeros(len(used)), np.zeros((len(used), self.rows.freedoms))
        gradients = np.zeros((len(used), k))
        theta, poses = np.ascontiguousarray(theta), np.ascontiguousarray(poses)
        calibration_residuals.derivatives(
            self.rows, directions, theta, poses, self.values, used, residuals, slopes, gradients
        )
        return Derivatives(
            residuals[: count * e].reshape(count, e),
            slopes[: count * e].reshape(count, e, -1),
            gradients[: count * e].reshape(count, e, k),
            np.append(residuals[count * e :], self.rows.linear @ theta - self.rows.wanted),
            np.concatenate([gradients[count * e :], self.rows.linear]),
        )


@dataclass(frozen=True, eq=False)
class StraightProblem(CalibrationProblem):
    """The calibration equations of straight, rigid lines: the state of a pose is the pose itself."""

    elastic: ClassVar = False

    @cached_property
    def _directions(self) -> Array:
        """A basis (n, p) of the directions in which poses are free, its columns orthonormal."""
        return free_directions(self.robot)

    def is_finite(self, theta: Array, states: Array) -> bool:
        """Return whether no platform point is inside a sheave at any pose."""
        return bool(np.isfinite(self.lengths(theta, states)).all())

    def lengths(self, theta: Array, states: Array) -> Array:
        """Return the length (N, m) of each line's cable beyond its exit point, m: of all its spans."""
        found = np.zeros((len(states), self.robot.m))
        calibration_lengths.lengths_at(self.rows, np.ascontiguousarray(theta), np.ascontiguousarray(states), found)
        return found

    def balanced(self, theta: Array, states: Array) -> Self:
        """Return the problem with measured tensions, if any, replaced by the nearest ones that balance the load."""
        if self.measured.tensions is None:
            return self
        readings = balanced_readings(self.robot, self.rows, self.line_numbers(theta), self.tensions(theta), states)
        return replace(self, rows=self.rows._replace(tensions=np.ascontiguousarray(readings)))

    def derivatives(self, theta: Array, states: Array, weights: Array | None = None) -> Derivatives:
        """Return residuals and derivatives at free unknowns *theta* and poses *states* (N, n)."""
        return self.rows_at(theta, states, weights, self._directions)

    def adjust(
        self, theta: Array, states: Array, weights: Array, settings: StopRule
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Minimise the cost by the kernel, from all starts together; see `CalibrationProblem.adjust`."""
        states[:] = within(self.robot.platform.plane, states)
        codes, steps, costs = (*np.zeros((2, len(theta)), dtype=np.int64), np.zeros(len(theta)))
        pose_schur.adjust_runs(
            self.rows,
            self._directions,
            self.limits,
            theta,
            states,
            self.values[None],
            np.ascontiguousarray(weights)[None],
            settings,
            codes,
            steps,
            costs,
        )
        return codes, steps, costs
