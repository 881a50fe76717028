"""Selection of the poses to measure: those with most information on the unknowns, in an order with short travel."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final, get_args

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, plan_of
from cablewright.calibration.poses.observability import projected
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import random_poses
from cablewright.calibration.poses.sufficient_data import min_poses
from cablewright.calibration.unknowns import exit_rows
from cablewright.foundation.arrays import Array
from cablewright.foundation.choices import PoseCriterion
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.results import Figure, Result
from cablewright.models.fidelity import CableLaw
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

CRITERIA: Final = get_args(PoseCriterion)

MAX_CANDIDATES: Final = 20_000
MAX_POSES: Final = 500
_PASSES: Final = 12  # max passes of exchanging poses
_RIDGE: Final = 1e-6  # of the mean information, so that it is regular before there are enough poses
_NULL: Final = 1e-9
_DRAWS: Final = 20  # of random poses, to compare with


@dataclass(frozen=True, eq=False, repr=False)
class CalibrationPoses(Result):
    """Poses to measure, in order of travel and home first, and the sigmas of exit points predicted for them."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok.", lambda _: "ok"),
        Figure("robot", "", "Name of the robot.", "robot.name"),
        Figure("criterion", "", "What was made small: d-optimal or worst-sigma."),
        Figure("count", "1", "Number of poses.", lambda found: len(found.poses), "poses"),
        Figure("sigma_rms", "m", "Sigma of the exit points' coordinates, root mean square.", "", "sigma, rms", 3,
               shown="mm"),
        Figure("sigma_worst", "m", "The largest of these sigmas.", "", "sigma, worst", 3, shown="mm"),
        Figure("random_sigma_rms", "m", "Sigma with as many random poses, root mean square.", "random_rms",
               "sigma of random poses, rms", 3, shown="mm"),
        Figure("random_sigma_worst", "m", "The largest of these sigmas.", "random_worst",
               "sigma of random poses, worst", 3,
               shown="mm"),
        Figure("travel", "m", "Length of the way from pose to pose."),
        Figure("travel_unordered", "m", "Length of the way in the order in which the poses were drawn.", detail=True),
        Figure("poses", "m, rad", "The poses, world.", detail=True),
        Figure("counted", "m", "Length changes of the lines since the first pose.", detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("robot", "criterion", "count", "sigma_rms", "sigma_worst")

    robot: Robot
    criterion: str
    poses: Array  # (N, n) m and rad
    counted: Array  # (N, m) m: length changes since the first pose
    sigma_rms: float  # m, over coordinates of exit points, under the inner constraint
    sigma_worst: float  # m, the largest
    random_rms: float  # m, as sigma_rms for as many random poses: the median of some draws
    random_worst: float  # m
    travel: float  # m, from pose to pose
    travel_unordered: float  # m, in the order in which the candidates were drawn


def calibration_poses(
    robot: Robot | Model,
    count: int = 40,
    *,
    criterion: str = "d-optimal",
    candidates: int = 1000,
    sigma: float = 1e-4,
    plan: str | Path | CalibrationPlan | None = None,
    tension_limits: tuple[float, float] | None = None,
    seed: int = 0,
) -> CalibrationPoses:
    """Select *count* of random *candidates* in the workspace to measure for a calibration of *robot*.

    *criterion*: one of `CRITERIA`. *sigma*: standard deviation of the encoders, m. *plan*: plan that names the
    unknowns, or a TOML file. Candidates are feasible with straight rigid lines within *tension_limits* (N), by default
    those of the lines. Poses are added greedily, then exchanged while that improves the criterion. Raises `InputError`
    for too few poses or candidates.

    Examples
    --------
    >>> import cablewright as cw
    >>> found = cw.calibration_poses(cw.load("wang2021"), 14, candidates=100)
    >>> found.sigma_rms < found.random_rms
    True
    """
    if criterion not in CRITERIA:
        raise UnknownName("criterion", criterion, CRITERIA)
    for name, value, maximum in (("count", count, MAX_POSES), ("candidates", candidates, MAX_CANDIDATES)):
        if not 1 <= value <= maximum:
            raise InputError(f"{name} = {value}: must be from 1 to {maximum}")
    if seed < 0:
        raise InputError(f"seed = {seed}: must not be negative")
    if not 0.0 < sigma < 1.0:
        raise InputError(f"sigma = {sigma:g}: must be over 0 and under 1 m")
    model = Model.of(robot, tension_limits=tension_limits, default=CableLaw.RIGID)
    robot, plan = model.robot, plan_of(plan)
    rng = np.random.default_rng(seed)
    places = random_poses(model, candidates, rng)
    problem = StraightProblem.of(robot, Measured(np.zeros((candidates, robot.m)), places), plan, hold=False)
    needed = min_poses(problem)
    if not needed <= count <= candidates:
        raise InputError(
            f"{count} poses: must be from {needed}, which {robot.name!r} requires, to {candidates}, the candidates"
        )
    _, rows, ranks = projected(problem.derivatives(problem.start, places))
    rows = np.ascontiguousarray(rows[:, int(ranks.min()) :]) * (problem.encoder_sigma / sigma)
    search = _CriterionSearch(rows, exit_rows(robot, problem.free_unknowns)[0], criterion)
    chosen = np.sort(search.exchanged(search.greedy(count)))  # sorted: the order in which they are found is rounding
    path = places[chosen][_ordered(places[chosen, :3])]
    random = [search.sigmas(rng.choice(candidates, count, replace=False)) for _ in range(_DRAWS)]
    random_rms, random_worst = np.median(random, axis=0).tolist()
    lengths = problem.lengths(problem.start, path)
    if problem.is_soft:
        lengths -= problem.given(problem.start, path, solve_inverse(model, path).tensions)
    changes, travels = lengths - lengths[0], (_travel(path), _travel(places[chosen]))
    return CalibrationPoses(robot, criterion, path, changes, *search.sigmas(chosen), random_rms, random_worst, *travels)


class PoseSearch:
    """Search for a set of poses, in the space of the d combinations of unknowns that the poses can determine.

    They are those that *known* rows and all candidates determine.
    """

    def __init__(self, rows: Array, exits: Array, known: Array | None = None) -> None:
        every = rows.reshape(-1, rows.shape[2])
        every = every if known is None else np.concatenate([known, every])
        _, values, right = np.linalg.svd(np.linalg.qr(every, mode="r"))
        kept = values > _NULL * values[0]
        self.values = values[kept]  # (d,)
        self.basis = right[kept].T  # (k, d)
        self.rows = rows @ self.basis  # (C, r, d) of each candidate, its pose eliminated
        self.exits = exits @ self.basis  # (a, d)
        self.assumed: Array | float = 0.0  # (a,) variances that more poses hardly make smaller

    def variances(self, inverse: Array) -> Array:
        """Return the variance (a,) of each coordinate of an exit point."""
        return np.asarray(np.sum((self.exits @ inverse) * self.exits, axis=1) + self.assumed)

    def after(self, inverse: Array) -> Array:
        """Return the largest variance (C,) of a coordinate of an exit point with each candidate added."""
        across = self.rows @ inverse  # (C, r, d)
        inner = np.linalg.inv(np.eye(self.rows.shape[1]) + across @ np.swapaxes(self.rows, 1, 2))
        seen = across @ self.exits.T  # (C, r, a)
        fallen = np.sum((inner @ seen) * seen, axis=1)
        return np.asarray((self.variances(inverse) - fallen).max(axis=1))


class _CriterionSearch(PoseSearch):
    """Search for the set of poses that makes the *criterion*, a name of `PoseCriterion`, smallest."""

    def __init__(self, rows: Array, exits: Array, criterion: str) -> None:
        super().__init__(rows, exits)
        self.criterion = criterion
        self.ridge = _RIDGE * float(np.mean(self.values**2)) / len(rows)

    def greedy(self, count: int) -> list[int]:
        """Return poses chosen greedily: each adds most information to those before it."""
        chosen: list[int] = []
        inverse = np.eye(self.rows.shape[2]) / self.ridge
        for _ in range(count):
            gain = self._gains(inverse)
            gain[chosen] = -np.inf
            best = int(np.argmax(gain))
            chosen.append(best)
            across = self.rows[best] @ inverse  # Woodbury
            inner = np.eye(len(across)) + across @ self.rows[best].T
            inverse = inverse - across.T @ np.linalg.solve(inner, across)
        return chosen

    def exchanged(self, chosen: list[int]) -> NDArray[np.int64]:
        """Return the poses after exchanging them one by one while the criterion decreases."""
        size = self._size(chosen)
        for _ in range(_PASSES):
            before = size
            for at in range(len(chosen)):
                rest = chosen[:at] + chosen[at + 1 :]
                inverse = _inverse(self._information(rest))
                better = -self._gains(inverse) if self.criterion == "d-optimal" else self.after(inverse)
                better[rest] = np.inf
                trial = [*chosen[:at], int(np.argmin(better)), *chosen[at + 1 :]]
                then = self._size(trial)
                if then < size - 1e-12 * abs(size):
                    chosen, size = trial, then
            if not size < before - 1e-9 * abs(before):
                break
        return np.array(chosen, dtype=np.int64)

    def sigmas(self, chosen: NDArray[np.int64]) -> tuple[float, float]:
        """Return the rms and the largest sigma of the exit points' coordinates, m."""
        variances = self.variances(_inverse(self._information(chosen)))
        return float(np.sqrt(variances.mean())), float(np.sqrt(variances.max()))

    def _information(self, chosen: list[int] | NDArray[np.int64]) -> Array:
        rows = self.rows[chosen].reshape(-1, self.rows.shape[2])
        return np.asarray(rows.T @ rows + self.ridge * 1e-6 * np.eye(rows.shape[1]))

    def _size(self, chosen: list[int]) -> float:
        """Return the criterion, which is minimised."""
        information = self._information(chosen)
        if self.criterion == "d-optimal":
            return -float(np.linalg.slogdet(information)[1])
        return float(self.variances(_inverse(information)).max())

    def _gains(self, inverse: Array) -> Array:
        """Return the increase (C,) of the logarithm of the determinant by adding each candidate."""
        spread = self.rows @ inverse @ np.swapaxes(self.rows, 1, 2)
        return np.asarray(np.linalg.slogdet(np.eye(spread.shape[1]) + spread)[1])


def _inverse(matrix: Array) -> Array:
    return np.asarray(np.linalg.inv(matrix), dtype=np.float64)


def _travel(path: Array) -> float:
    return float(np.linalg.norm(np.diff(path[:, :3], axis=0), axis=1).sum())


def nearest_order(points: Array, begin: Array) -> list[int]:
    """Return an order to visit points (N, 3), m: first the nearest to *begin* (3,), then the nearest left."""
    left, order, here = list(range(len(points))), list[int](), begin
    while left:
        order.append(left.pop(int(np.argmin(np.linalg.norm(points[left] - here, axis=1)))))
        here = points[order[-1]]
    return order


def _ordered(points: Array) -> NDArray[np.int64]:
    """Return an order of points (N, 3) with short travel: from the middle to the nearest next, improved by 2-opt."""
    apart = np.pad(np.linalg.norm(points[:, None] - points, axis=2), (0, 1))
    order = [*nearest_order(points, points.mean(axis=0)), len(points)]  # the end, at no distance from any point
    better = True
    while better:
        better = False
        for i in range(1, len(points) - 1):
            for j in range(i + 1, len(points)):
                before, first, last, after = order[i - 1], order[i], order[j], order[j + 1]
                if apart[before, last] + apart[first, after] < apart[before, first] + apart[last, after] - 1e-12:
                    order[i : j + 1] = reversed(order[i : j + 1])
                    better = True
    return np.array(order[:-1])
