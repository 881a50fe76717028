"""What a wrong model adds to sigmas: numbers of the robot file that count as known, and scatter from pose to pose.

Known numbers are considered (Schmidt 1966): each is assumed to a standard deviation, the data estimate its error, and
the shift by that error adds to the covariance. Each kind of number has an even chance to be exact, so the result is an
average over all subsets of kinds, weighted by their evidence (Bayesian model averaging): a kind that the data deny adds
next to nothing, one that they show or cannot determine adds its part. So it is with effects that cross-validation
weighed: the number of one that was chosen is as wrong as the data leave it, and one that was not is believed as wide
as one pose shows it (the unit information prior of Kass and Wasserman 1995), so that the choice itself is in sigma.

The covariance by the scatter of poses and of surveyed points (a sandwich, clustered, HC3) replaces a smaller one where
it exceeds what noise explains.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Final, NamedTuple

import numpy as np

from cablewright.calibration.measurement_rows.given_numbers import known_deviation, uncertain
from cablewright.calibration.measurements import SENSORS, Measured
from cablewright.calibration.plan import STRETCH, Sigmas
from cablewright.calibration.poses.derivatives import Derivatives
from cablewright.calibration.poses.fit import PoseFit
from cablewright.calibration.poses.observability import Information, projected
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.unknowns import Unknown
from cablewright.foundation.arrays import Array
from cablewright.models.creep import hour_compliance
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.free_coordinates import as_held
from cablewright.models.statics import Model
from cablewright.robot import Eyelet, Line, Robot
from cablewright.solvers.inverse import solve_inverse

RADIUS: Final = 0.03  # of a sheave's radius: the cable's own radius may be in it or not
IMPORTED: Final = 0.1  # of the build-up in the file, as a drum's width or a cable's packing is known
BUILD_UP: Final = 2e-3  # 1/m: a layer of 4 mm cable on a drum of 0.1 m, every 20 m
ENTIRELY: Final = 1.0  # of that by the file's stiffness, where lines count as stiff
MODULUS: Final = 0.2  # of the file's, where lines stretch
CELL: Final = 0.01  # of a load cell's scale: the class of ordinary ones
MOUNT: Final = 0.2  # of the compliance in the file, where mounts give
_STRETCH_WORDS: Final = "stretch of all lines over that by the file"
_WIDE: Final = 1e3  # sigmas of a number by the data: so wide a belief says nothing
_LEAST: Final = 0.05  # of the information: min that is left without a pose
_CHANCE: Final = 2.0  # standard deviations of a variance by scatter, up to which noise explains it


@dataclass(frozen=True)
class Considered:
    """A number of the robot file that counts as known, with its possible error."""

    name: str  # in the registry, or `STRETCH`
    line: str | None
    words: str
    unit: str
    value: float  # its error, by prior and data
    sigma: float
    shift: float  # m, what that does to a coordinate of an exit point, at most
    probability: float = 0.0  # that its kind is in error, by the data, from an even chance
    share: float = 0.0  # of the variance of the least known coordinate of an exit point
    of_effect: bool = False  # that cross-validation weighed
    fitted: bool = False  # and that is in the model


class Alternative(NamedTuple):
    """An effect that cross-validation compared: its value may be wrong, or the effect may be missing.

    ``usual``: how large it may be on a machine of which nothing is known, SI.
    """

    name: str
    words: str
    unit: str
    column: Array  # (N, e) derivative of the weighted residuals
    usual: float
    fitted: bool  # its number is in the model


@dataclass(frozen=True, eq=False)
class ModelDoubt:
    """The covariance of the free unknowns with the contribution of a wrong model, and the q considered numbers.

    `largest`: the variances (k,) if every number were in error as assumed, and scatter counted in full.
    """

    joint: Array  # (k + q, k + q): of the unknowns, then of the errors of these numbers
    considered: tuple[Considered, ...]
    assumed: Array  # (k, k) covariance of the unknowns by these numbers, which more poses hardly make smaller
    largest: Array

    @property
    def covariance(self) -> Array:
        """The covariance (k, k) of the free unknowns."""
        k = len(self.joint) - len(self.considered)
        return self.joint[:k, :k]


def model_doubt(
    problem: CalibrationProblem,
    found: PoseFit,
    posterior: Information,
    scale: float,
    effects: Sequence[Alternative] = (),
) -> ModelDoubt:
    """Return the covariance of the unknowns at a solution, with the contribution of a wrong model.

    *scale*: sigma of a row over that of its weight. *effects*: effects that cross-validation compared, in the model or
    not. It is NaN where the fit has no solution, or a pose has no value there: there is nothing to linearise about.
    """
    noise, here = posterior.covariance * scale**2, problem.derivatives(found.theta, found.poses, found.weights)
    if found.code != 0 or not here.whole.all():
        nothing = np.full_like(noise, np.nan)
        return ModelDoubt(nothing, (), nothing, np.diag(nothing))
    if not (np.isfinite(found.cost) and 0.0 < scale < np.inf):
        return ModelDoubt(noise, (), np.zeros_like(noise), np.diag(noise))
    rows, by_numbers, numbers = _considered(problem, found, effects)
    k = len(found.theta)
    by_all = np.concatenate([rows.by_unknown[..., :k], by_numbers], axis=2)
    off, reduced, _ = projected(replace(rows, by_unknown=by_all))
    flat = reduced.reshape(-1, reduced.shape[-1])
    known, other = flat[:, :k], flat[:, k:]
    others = here.others_by_unknown
    motion = -posterior.covariance @ (known.T @ other)  # (k, q): of the unknowns, as the numbers change
    exits, joint = problem.named("exit_point"), np.zeros((k + len(numbers),) * 2)
    joint[:k, :k] = noise
    largest, considered = np.diag(noise).copy(), tuple[Considered, ...]()
    if numbers:
        left = np.concatenate([other + known @ motion, others @ motion]) / scale  # of the rows, as unknowns follow
        numbers = list(_as_wide_as_told(numbers, left, problem.poses))
        found_off = _found_off(left, -(other.T @ off.ravel()) / scale**2, numbers)
        shown = np.concatenate([motion, np.eye(len(numbers))])
        joint += shown @ found_off.averaged @ shown.T
        largest += np.sum((motion @ found_off.full) * motion, axis=1)
        considered = tuple(_told(numbers, found_off, motion[exits], np.diag(noise)[exits]))
    distances, points = len(problem.plan.distances), len(problem.plan.points)  # their rows have no pose
    alone = np.arange(distances)[:, None], distances + np.arange(3 * points).reshape(-1, 3)
    clusters = _Clusters(off, reduced[..., :k]), *(_Clusters(here.others[at], others[at]) for at in alone)
    unmeasured = np.delete(others, np.concatenate([at.ravel() for at in alone]), axis=0)
    scatter, explained = _by_scatter(clusters, unmeasured, posterior, scale)
    assumed = joint[:k, :k] - noise
    variances = np.diag(joint)[:k].copy()
    joint[range(k), range(k)] += np.where(scatter > explained, np.maximum(scatter - variances, 0.0), 0.0)
    return ModelDoubt(joint, considered, assumed, np.maximum(largest, scatter))


def _as_wide_as_told(numbers: Sequence[Considered], rows: Array, poses: int) -> Iterator[Considered]:
    """Yield *numbers*, those of effects with the sigma that is believed of them, by their *rows* (g, q) of sigma 1.

    Of those that are fitted: so wide that the data decide. Of others: as one of the *poses* shows them beside the
    fitted ones, or what is usual.
    """
    fitted = np.array([each.fitted for each in numbers])
    span = np.linalg.qr(rows[:, fitted])[0]
    beside = np.linalg.norm(rows - span @ (span.T @ rows), axis=0)
    for each, own, alone in zip(numbers, np.linalg.norm(rows, axis=0), beside, strict=True):
        if each.fitted:
            yield replace(each, sigma=_WIDE / max(float(own), 1e-300))
        elif each.of_effect:
            yield replace(each, sigma=min(each.sigma, math.sqrt(poses) / max(float(alone), 1e-300)))
        else:
            yield each


def _spread(gram: Array, believed: Array) -> tuple[Array, float]:
    """Return the covariance (q, q) of numbers believed to their sigmas (q,), by the *gram* (q, q) of rows of sigma 1.

    By eigenvalues that are 1 at least: data without noise leave no variance, and none below zero. Beside it: the
    logarithm by which the data make the volume of the belief smaller, squared.
    """
    values, vectors = np.linalg.eigh(gram * np.outer(believed, believed))
    values = np.maximum(values, 0.0)
    root = believed[:, None] * vectors / np.sqrt(1.0 + values)
    return np.asarray(root @ root.T), float(np.log1p(values).sum())


class _FoundOff(NamedTuple):
    """Errors of the q numbers that are considered: value and covariance with all in error, and averages."""

    value: Array  # (q,)
    spread: Array  # (q, q)
    averaged: Array  # (q, q) second moment, over which kinds are in error
    probability: Array  # (q,) that each is in error

    @property
    def full(self) -> Array:
        """The second moment (q, q) of the considered numbers if all are in error as assumed."""
        return self.spread + np.outer(self.value, self.value)


def _found_off(rows: Array, pull: Array, numbers: Sequence[Considered]) -> _FoundOff:
    """Return the errors of *numbers* by *rows* (g, q) of sigma 1 and their *pull* (q,), the rows times the residuals.

    Each kind is in error or exact, with even chances before the data; sensors count as one kind each.
    """
    kinds = [_kind(each) for each in numbers]
    of = np.array([list(dict.fromkeys(kinds)).index(kind) for kind in kinds])
    surely = {kind for kind, each in zip(kinds, numbers, strict=True) if each.fitted}
    believed = np.array([each.sigma for each in numbers])
    gram, ways = rows.T @ rows, [(True,) if kind in surely else (True, False) for kind in dict.fromkeys(kinds)]
    spread, _ = _spread(gram, believed)
    value, best, total = spread @ pull, -math.inf, 0.0
    averaged, probability = np.zeros_like(spread), np.zeros(len(of))
    for chosen in product(*ways):  # summed as they come: there may be many thousands
        subset = np.array(chosen)[of]
        its_spread, smaller = _spread(gram, believed * subset)
        its_value = its_spread @ pull
        evidence = 0.5 * (float(pull @ its_value) - smaller)
        before, now = math.exp(min(best - evidence, 0.0)), math.exp(min(evidence - best, 0.0))
        best, total = max(best, evidence), before * total + now
        averaged = before * averaged + now * (its_spread + np.outer(its_value, its_value))
        probability = before * probability + now * subset
    return _FoundOff(value, spread, averaged / total, probability / total)


def _kind(number: Considered) -> str:
    """Return the kind of a *number* that is in error with others of its kind; an effect on one line is its own."""
    if number.of_effect:
        return number.name
    return number.name.partition("_" if number.name.partition("_")[0] in SENSORS else ".")[0]


def _told(numbers: Sequence[Considered], off: _FoundOff, motion: Array, noise: Array) -> Iterator[Considered]:
    """Yield *numbers* with their errors, by the *motion* (e, q) and the variance by *noise* (e,) of exit points."""
    parts = motion * (motion @ off.averaged)
    total = noise + parts.sum(axis=1)
    share = parts[np.argmax(total)] / total.max() if len(total) and total.max() > 0.0 else np.zeros(len(numbers))
    for at, each in enumerate(numbers):
        shift = float(np.abs(motion[:, at] * off.value[at]).max(initial=0.0))
        yield replace(
            each,
            value=float(off.value[at]),
            sigma=float(off.spread[at, at] ** 0.5),
            shift=shift,
            probability=float(off.probability[at]),
            share=float(share[at]),
        )


class _Clusters(NamedTuple):
    """Rows that may be off together: of c poses or surveyed points, r each."""

    off: Array  # (c, r) residuals
    rows: Array  # (c, r, k)


def _by_scatter(
    clusters: Sequence[_Clusters], others: Array, posterior: Information, scale: float
) -> tuple[Array, Array]:
    """Return the variances (k,) by how *clusters* scatter, as if each were left out once, and *others* by sigma.

    Beside them: the variances up to which noise alone explains the scatter, *scale* its sigma over that of the weights.
    """
    values, vectors = np.linalg.eigh(posterior.covariance)
    kept = values > 1e-14 * max(values.max(initial=0.0), 1e-300)
    root = vectors[:, kept] * np.sqrt(values[kept])  # (k, r): unknowns of sigma 1
    found = np.sum((others @ root @ root.T) ** 2, axis=0)
    expected, spread = found.copy(), np.zeros_like(found)
    for off, rows in clusters:
        own = rows @ root
        left = np.eye(own.shape[1]) - own @ np.swapaxes(own, 1, 2)
        sizes, turned = np.linalg.eigh(left)
        whole = (turned / np.maximum(sizes, _LEAST)[:, None]) @ np.swapaxes(turned, 1, 2)
        by_row = root @ np.swapaxes(own, 1, 2) @ whole
        found += np.sum(np.einsum("nkf,nf->nk", by_row, np.where(np.isfinite(off), off, 0.0)) ** 2, axis=0)
        by_noise = scale**2 * np.sum((by_row @ left) * by_row, axis=2)
        expected += by_noise.sum(axis=0)
        spread += 2.0 * np.sum(by_noise**2, axis=0)
    return found, expected + _CHANCE * np.sqrt(spread)


def _considered(
    problem: CalibrationProblem, found: PoseFit, effects: Sequence[Alternative]
) -> tuple[Derivatives, Array, list[Considered]]:
    """Return the rows with more unknowns, their derivatives (N, e, q) by the considered numbers, and these."""
    robot, plan, names = problem.robot, problem.plan, []
    if "sheave_radius" not in plan.unknowns and any(not isinstance(line.sheave, Eyelet) for line in robot.lines):
        names.append("sheave_radius")
    if "build_up" not in plan.unknowns and ("drum_radius" not in plan.unknowns or problem.measured.by_drum):
        names.append("build_up")
    if problem.elastic and "modulus" not in plan.unknowns:
        names.append("modulus")
    if "exit_compliance" not in plan.unknowns and any(_gives(line) for line in robot.lines):
        names.append("exit_compliance")
    wound = any(line.winch.build_up for line in robot.lines)
    shared = tuple(name for name in names if name in ("build_up", "modulus") and not (wound and name == "build_up"))
    sensors = believed_of_sensors(problem.measured, plan.sigma)
    names += [name for name in sensors if name not in plan.unknowns]
    names += dict.fromkeys(name for name in uncertain(plan) if name not in (*names, STRETCH))
    wider, rows, more = with_more(problem, found, names, shared)
    share = max(creep_share(line) for line in robot.lines)
    sigmas = {"modulus": math.hypot(MODULUS, share)} | sensors
    numbers, columns = [], []
    for at, each in enumerate(more, len(found.theta)):
        start = float(wider.start[wider.unknowns.index(each)]) * each.size
        assumed = sigmas.get(each.name) or _believed(robot, each, start)
        sigma = known_deviation(plan, each.name, each.line, assumed)
        if sigma > 0.0:
            numbers.append(Considered(each.kind, each.line, each.label, each.unit, 0.0, sigma, 0.0))
            columns.append(rows.by_unknown[..., at] / each.size)
    fitted = {each.name for each in effects if each.fitted}
    stretch = None if problem.elastic or STRETCH in fitted else stretch_of(problem, found.theta, found.poses)
    sigma = known_deviation(plan, STRETCH, None, math.hypot(ENTIRELY, share))
    if stretch is not None and sigma > 0.0:
        columns.append(problem.of_poses(found.weights) * problem.in_lengths(stretch))
        numbers.append(Considered(STRETCH, None, _STRETCH_WORDS, "1", 0.0, sigma, 0.0))
    already = {each.name.partition(".")[0] for each in numbers}
    for effect in effects:
        if effect.name not in already and known_deviation(plan, effect.name, None, effect.usual) > 0.0:
            columns.append(effect.column)
            named = effect.name, None, effect.words, effect.unit
            numbers.append(Considered(*named, 0.0, effect.usual, 0.0, of_effect=True, fitted=effect.fitted))
    return rows, np.stack(columns, axis=2) if columns else np.zeros((problem.poses, problem.per_pose, 0)), numbers


def with_more(
    problem: CalibrationProblem, found: PoseFit, names: Sequence[str], shared: Sequence[str]
) -> tuple[CalibrationProblem, Derivatives, list[Unknown]]:
    """Return the calibration problem with more unknowns *names*, some *shared* by all lines, and its rows.

    The rows are those at a fit and at the file. In them the further unknowns, which are the last of the result, come
    after those of the fit.
    """
    plan = problem.plan
    more = {"unknowns": (*plan.unknowns, *names), "shared": (*plan.shared, *shared)}
    wider = problem.with_plan(plan.model_copy(update=more))
    place = {each: at for at, each in enumerate(wider.free_unknowns)}
    before = [place.pop(each) for each in problem.free_unknowns]
    theta, order = wider.free.copy(), [*before, *place.values()]
    theta[before] = found.theta
    rows = wider.derivatives(theta, found.poses, found.weights)
    return wider, replace(rows, by_unknown=rows.by_unknown[..., order]), list(place)


def _believed(robot: Robot, number: Unknown, start: float) -> float:
    """Return the standard deviation assumed of a number of lines, by its value in the file or in the fit, *start*."""
    if number.name == "build_up":
        own = [line.winch.build_up or 0.0 for line in robot.lines if number.of_line(line.name)]
        return IMPORTED * max(own) or BUILD_UP
    return (MOUNT if number.name == "exit_compliance" else RADIUS) * start


def creep_share(line: Line) -> float:
    """Return a cable's creep after an hour under load, by the robot file, relative to its elastic stretch."""
    return hour_compliance(line.cable.creep) * line.cable.stiffness


def _gives(line: Line) -> bool:
    """Whether the mount of a line gives by one number."""
    return isinstance(line.exit_compliance, float) and line.exit_compliance > 0.0


def believed_of_sensors(measured: Measured, sigma: Sigmas) -> dict[str, float]:
    """Return the assumed errors of the sensors that measured: a zero as large as their noise, and a scale."""
    sensors = [name for name in SENSORS if measured.has(name)]
    found = {f"{name}_offset": float(getattr(sigma, name)) for name in sensors}
    return found | ({"tension_scale": CELL} if "tension" in sensors else {})


def stretch_of(problem: CalibrationProblem, theta: Array, poses: Array) -> Array | None:
    """Return the elastic stretch (N, m) of each line, m, by the file's stiffness; None if tensions are unknown."""
    tensions = loads_of(problem, theta, poses)
    compliance = 1.0 / np.array([line.cable.stiffness for line in problem.robot.lines])
    return None if tensions is None else np.asarray(tensions * problem.lengths(theta, poses) * compliance)


def loads_of(problem: CalibrationProblem, theta: Array, poses: Array) -> Array | None:
    """Return the tensions (N, m), N: of equilibria, measured ones, or the smallest that hold the pose.

    They are 0 where none hold it. None where no load is described.
    """
    robot = problem.robot
    tensions = problem.known_tensions(theta, poses)
    if tensions is None:
        if not (robot.scene.gravity > 0.0 and robot.m >= robot.freedoms):
            return None
        exits = np.broadcast_to(problem.points(theta), (problem.poses, robot.m, 3))
        model = Model(robot, Fidelity.of(CableLaw.RIGID))
        held = solve_inverse(model, as_held(robot, poses), exit_points=np.ascontiguousarray(exits))
        tensions = held.tensions
    return np.asarray(np.nan_to_num(tensions))
