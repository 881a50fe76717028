"""What a wrong model adds to sigmas: numbers of the robot file that count as known, and scatter from pose to pose.

Known numbers are considered (Schmidt 1966): each is believed to a standard deviation, the data say how far off it is,
and what that shifts is added to the covariance: little where data deny a shift, all of it where they show one or cannot
tell. Beside it stands the covariance by the scatter of poses and of surveyed points (a sandwich, clustered, HC3).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np

from cablewright.calibration.measurements import SENSORS, Measured
from cablewright.calibration.plan import Sigmas
from cablewright.calibration.poses.fit import PoseFit
from cablewright.calibration.poses.observability import Information, projected
from cablewright.calibration.poses.problem import CalibrationProblem, Derivatives
from cablewright.foundation.arrays import Array
from cablewright.models.creep import hour_compliance
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Eyelet, Line
from cablewright.solvers.inverse import solve_inverse

RADIUS: Final = 0.03  # of a sheave's radius: the cable's own radius may be in it or not
BUILD_UP: Final = 2e-3  # 1/m: a layer of 4 mm cable on a drum of 0.1 m, every 20 m
STRETCH: Final = 1.0  # of that by the file's stiffness, where lines count as stiff
MODULUS: Final = 0.2  # of the file's, where lines stretch
CELL: Final = 0.01  # of a load cell's scale: the class of ordinary ones
MOUNT: Final = 0.2  # of the compliance in the file, where mounts give
STRETCH_NAME: Final = "stretch"
_STRETCH_WORDS: Final = "stretch of all lines over that by the file"
_LEAST: Final = 0.05  # of the information: min that is left without a pose


@dataclass(frozen=True)
class Considered:
    """A number of the file that counts as known: how far off the data say it is."""

    name: str  # in the registry, or `STRETCH_NAME`
    line: str | None
    words: str
    unit: str
    value: float  # how far off, as far as it is believed and the data say
    sigma: float
    shift: float  # m, what that does to a coordinate of an exit point, at most


@dataclass(frozen=True, eq=False)
class ModelDoubt:
    """The covariance of the free unknowns with what a wrong model adds, and the q numbers that were considered."""

    joint: Array  # (k + q, k + q): of the unknowns, then of how far off these numbers are
    considered: tuple[Considered, ...]
    assumed: Array  # (k, k) covariance of the unknowns by these numbers, which more poses hardly make smaller

    @property
    def covariance(self) -> Array:
        """The covariance (k, k) of the free unknowns."""
        k = len(self.joint) - len(self.considered)
        return self.joint[:k, :k]


def model_doubt(problem: CalibrationProblem, found: PoseFit, posterior: Information, scale: float) -> ModelDoubt:
    """Return the covariance of the unknowns at a solution; *scale*: sigma of a row over that of its weight.

    It is NaN where the fit ended at none, or a pose has no value there: there is nothing to linearise about.
    """
    noise, here = posterior.covariance * scale**2, problem.derivatives(found.theta, found.poses, found.weights)
    if found.code != 0 or not here.whole.all():
        nothing = np.full_like(noise, np.nan)
        return ModelDoubt(nothing, (), nothing)
    if not (np.isfinite(found.cost) and 0.0 < scale < np.inf):
        return ModelDoubt(noise, (), np.zeros_like(noise))
    rows, by_numbers, numbers = _considered(problem, found)
    k = len(found.theta)
    by_all = np.concatenate([rows.by_unknown[..., :k], by_numbers], axis=2)
    off, reduced, _ = projected(replace(rows, by_unknown=by_all))
    known, other = reduced[..., :k].reshape(-1, k), reduced[..., k:].reshape(-1, len(numbers))
    others = here.others_by_unknown
    motion = -posterior.covariance @ (known.T @ other)  # (k, q): of the unknowns, as the numbers change
    considered, exits = [], problem.named("exit_point")
    joint = np.zeros((k + len(numbers),) * 2)
    joint[:k, :k] = noise
    if len(numbers):
        left = np.concatenate([other + known @ motion, others @ motion])  # of the rows, once the unknowns follow
        spread = _spread(left / scale, np.array([each.sigma for each in numbers]))
        value = -spread @ (other.T @ off.ravel()) / scale**2
        shown = np.concatenate([motion, np.eye(len(numbers))])
        joint += shown @ (spread + np.outer(value, value)) @ shown.T
        for at, each in enumerate(numbers):
            shift = float(np.abs(motion[exits, at] * value[at]).max(initial=0.0))
            considered.append(replace(each, value=float(value[at]), sigma=float(spread[at, at] ** 0.5), shift=shift))
    distances, points = len(problem.plan.distances), len(problem.plan.points)  # their rows have no pose
    alone = np.arange(distances)[:, None], distances + np.arange(3 * points).reshape(-1, 3)
    clusters = _Clusters(off, reduced[..., :k]), *(_Clusters(here.others[at], others[at]) for at in alone)
    unmeasured = np.delete(others, np.concatenate([at.ravel() for at in alone]), axis=0)
    scatter = _by_scatter(clusters, unmeasured, posterior)
    assumed = joint[:k, :k] - noise
    larger = np.sqrt(np.maximum(np.diag(scatter) / np.maximum(np.diag(joint)[:k], 1e-300), 1.0))
    larger = np.append(larger, np.ones(len(numbers)))
    return ModelDoubt(joint * np.outer(larger, larger), tuple(considered), assumed)


def _spread(rows: Array, believed: Array) -> Array:
    """Return the covariance (q, q) of numbers believed to their sigmas (q,), by *rows* (g, q) of sigma 1.

    By eigenvalues that are 1 at least: data without noise leave no variance, and none below zero.
    """
    scaled = rows * believed
    values, vectors = np.linalg.eigh(scaled.T @ scaled)
    root = believed[:, None] * vectors / np.sqrt(1.0 + np.maximum(values, 0.0))
    return np.asarray(root @ root.T)


class _Clusters(NamedTuple):
    """Rows that may be off together: of c poses or surveyed points, r each."""

    off: Array  # (c, r) residuals
    rows: Array  # (c, r, k)


def _by_scatter(clusters: Sequence[_Clusters], others: Array, posterior: Information) -> Array:
    """Return the covariance (k, k) by how *clusters* scatter, as if each were left out once, and *others* by sigma."""
    values, vectors = np.linalg.eigh(posterior.covariance)
    kept = values > 1e-14 * max(values.max(initial=0.0), 1e-300)
    root = vectors[:, kept] * np.sqrt(values[kept])  # (k, r): unknowns of sigma 1
    known = others @ root
    found = known.T @ known
    for off, rows in clusters:
        own = rows @ root
        left = np.eye(own.shape[1]) - np.einsum("nea,nfa->nef", own, own)
        sizes, turned = np.linalg.eigh(left)
        whole = np.einsum("nef,nf,ngf->neg", turned, 1.0 / np.maximum(sizes, _LEAST), turned)
        change = np.einsum("nea,nef,nf->na", own, whole, np.where(np.isfinite(off), off, 0.0))
        found = found + change.T @ change
    return np.asarray(root @ found @ root.T)


def _considered(problem: CalibrationProblem, found: PoseFit) -> tuple[Derivatives, Array, list[Considered]]:
    """Return the rows with more unknowns, their derivatives (N, e, q) by what is considered, and what that is."""
    robot, plan, names = problem.robot, problem.plan, []
    if "sheave_radius" not in plan.unknowns and any(not isinstance(line.sheave, Eyelet) for line in robot.lines):
        names.append("sheave_radius")
    if not {"build_up", "drum_radius"} & set(plan.unknowns):
        names.append("build_up")
    if problem.elastic and "modulus" not in plan.unknowns:
        names.append("modulus")
    if "exit_compliance" not in plan.unknowns and any(_gives(line) for line in robot.lines):
        names.append("exit_compliance")
    shared = tuple(name for name in names if name not in ("sheave_radius", "exit_compliance"))
    sensors = believed_of_sensors(problem.measured, plan.sigma)
    names += [name for name in sensors if name not in plan.unknowns]
    more = {"unknowns": (*plan.unknowns, *names), "shared": (*plan.shared, *shared)}
    wider = problem.with_plan(plan.model_copy(update=more))
    theta = np.append(found.theta, wider.free[len(problem.free_unknowns) :])  # those found, and the file's
    rows = wider.derivatives(theta, found.poses, found.weights)
    share = max(creep_share(line) for line in robot.lines)
    sigmas = {"build_up": BUILD_UP, "modulus": math.hypot(MODULUS, share)} | sensors
    numbers, columns = [], []
    for at, each in enumerate(wider.free_unknowns[len(found.theta) :], len(found.theta)):
        start = float(wider.start[wider.unknowns.index(each)]) * each.size
        sigma = sigmas.get(each.name, (MOUNT if each.name == "exit_compliance" else RADIUS) * start)
        if sigma > 0.0:
            numbers.append(Considered(each.kind, each.line, each.label, each.unit, 0.0, sigma, 0.0))
            columns.append(rows.by_unknown[..., at] / each.size)
    stretch = None if problem.elastic else stretch_of(problem, found.theta, found.poses)
    if stretch is not None:
        columns.append(np.zeros((problem.poses, problem.per_pose)))
        columns[-1][:, : robot.m] = problem.of_poses(found.weights)[:, : robot.m] * stretch
        sigma = math.hypot(STRETCH, share)
        numbers.append(Considered(STRETCH_NAME, None, _STRETCH_WORDS, "1", 0.0, sigma, 0.0))
    return rows, np.stack(columns, axis=2) if columns else np.zeros((problem.poses, problem.per_pose, 0)), numbers


def creep_share(line: Line) -> float:
    """Return the creep of a line's cable after an hour under a load, as the file has it, over its stretch by EA."""
    return hour_compliance(line.cable.creep) * line.cable.stiffness


def _gives(line: Line) -> bool:
    """Whether the mount of a line gives by one number."""
    return isinstance(line.exit_compliance, float) and line.exit_compliance > 0.0


def believed_of_sensors(measured: Measured, sigma: Sigmas) -> dict[str, float]:
    """Return what is believed of the sensors that measured: a zero that is off by as much as their noise, a scale."""
    sensors = [name for name in SENSORS if measured.has(name)]
    found = {f"{name}_offset": float(getattr(sigma, name)) for name in sensors}
    return found | ({"tension_scale": CELL} if "tension" in sensors else {})


def stretch_of(problem: CalibrationProblem, theta: Array, poses: Array) -> Array | None:
    """Return by how much each line (N, m) stretches by the file's stiffness, m; None if nothing says what loads them.

    With the tensions of equilibria, measured ones, or the least that hold the pose.
    """
    robot = problem.robot
    lengths = problem.lengths(theta, poses)
    compliance = 1.0 / np.array([line.cable.stiffness for line in robot.lines])
    tensions = problem.known_tensions(theta, poses)
    if tensions is None:
        if not (robot.scene.gravity > 0.0 and robot.m >= robot.freedoms):  # nothing loads them, or says how
            return None
        exits = np.broadcast_to(problem.points(theta), (problem.poses, robot.m, 3))
        model = Model(robot, Fidelity.of(CableLaw.RIGID))
        tensions = solve_inverse(model, poses, exit_points=np.ascontiguousarray(exits)).tensions
    return np.asarray(np.nan_to_num(tensions) * lengths * compliance)
