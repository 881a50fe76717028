"""Which poses to measure: those that tell most of the unknowns, in an order that moves little."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final, get_args

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array, Mask
from cablewright.calibration.checks import min_poses
from cablewright.calibration.observability import projected
from cablewright.calibration.plan import CalibrationPlan, plan_of
from cablewright.calibration.problem import CalibrationProblem, Measured
from cablewright.calibration.simulation import random_poses
from cablewright.choices import PoseCriterion
from cablewright.errors import InputError, UnknownName
from cablewright.models.fidelity import CableLaw
from cablewright.models.statics import Model
from cablewright.results import Figure, Result
from cablewright.robot import Robot

CRITERIA: Final = get_args(PoseCriterion)

MOST_CANDIDATES: Final = 20_000
MOST_POSES: Final = 500
_PASSES: Final = 12  # of exchanging poses
_RIDGE: Final = 1e-6  # of the mean information: lets the first poses be compared
_NULL: Final = 1e-9
_DRAWS: Final = 20  # of random poses, to compare with


@dataclass(frozen=True, eq=False, repr=False)
class CalibrationPoses(Result):
    """Poses (N, n) in the order to go to them, home first, and what they promise, at *sigma* (m) of the encoders."""

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
    poses: Array
    counted: Array  # (N, m) m: length changes since the first pose
    sigma_rms: float  # m, over coordinates of exit points, in the inner constraint
    sigma_worst: float
    random_rms: float  # m, of as many random poses: the middle of some draws
    random_worst: float
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
    """Choose which *count* of random *candidates* in the workspace to measure for a calibration of *robot*.

    *criterion*: one of `CRITERIA`. *sigma*: standard deviation of the encoders, m. *plan*: what is unknown, or the TOML
    that says so. Poses are held within *tension_limits* (N), by default those of the lines, by straight rigid lines.
    Greedy first, then poses are exchanged while that helps. Raises `InputError` for too few poses or candidates.

    Examples
    --------
    >>> import cablewright as cw
    >>> found = cw.calibration_poses(cw.load("wang2021"), 14, candidates=100)
    >>> found.sigma_rms < found.random_rms
    True
    """
    if criterion not in CRITERIA:
        raise UnknownName("criterion", criterion, CRITERIA)
    for name, value, most in (("count", count, MOST_POSES), ("candidates", candidates, MOST_CANDIDATES)):
        if not 1 <= value <= most:
            raise InputError(f"{name} = {value}: from 1 to {most} are wanted")
    if seed < 0:
        raise InputError(f"seed = {seed}: must not be negative")
    if not 0.0 < sigma < 1.0:
        raise InputError(f"sigma = {sigma:g}: over 0 and under 1 m is wanted")
    model = Model.of(robot, tension_limits=tension_limits, default=CableLaw.RIGID)
    robot, plan = model.robot, plan_of(plan)
    rng = np.random.default_rng(seed)
    places = random_poses(model, candidates, rng)
    problem = CalibrationProblem.of(robot, Measured(np.zeros((candidates, robot.m)), places), plan, hold=False)
    needed = min_poses(problem)
    if not needed <= count <= candidates:
        raise InputError(f"{count} poses: from {needed}, which {robot.name!r} needs, to {candidates} candidates")
    rows = _reduced(problem, places) * (problem.encoder_sigma / sigma)
    exits = np.array([each.name == "exit_point" for each in problem.unknowns])
    search = _PoseSearch(rows, exits, criterion)
    chosen = np.sort(search.exchanged(search.greedy(count)))  # rounding decides in which order they are found
    ordered = _ordered(places[chosen, :3])
    path = places[chosen][ordered]
    random = [search.sigmas(rng.choice(candidates, count, replace=False)) for _ in range(_DRAWS)]
    rms, worst = search.sigmas(chosen)
    lengths = problem.lengths(problem.start, path)
    middle = np.median(np.array(random), axis=0)
    return CalibrationPoses(
        robot,
        criterion,
        path,
        lengths - lengths[0],
        rms,
        worst,
        float(middle[0]),
        float(middle[1]),
        _travel(path),
        _travel(places[chosen]),
    )


def _reduced(problem: CalibrationProblem, places: Array) -> Array:
    """What each pose says of the unknowns (C, r, k), by itself out of the way."""
    _, rows, ranks = projected(problem.derivatives(problem.start, places))
    return np.ascontiguousarray(rows[:, int(ranks.min()) :])


class _PoseSearch:
    """Sets of poses and what they promise, in the space of what all candidates together can tell."""

    def __init__(self, rows: Array, exits: Mask, criterion: str) -> None:
        _, values, right = np.linalg.svd(np.linalg.qr(rows.reshape(-1, rows.shape[2]), mode="r"))
        self.basis = right[values > _NULL * values[0]].T  # (k, d)
        self.rows = rows @ self.basis  # (C, r, d)
        self.exits = self.basis[exits]
        self.criterion = criterion
        self.ridge = _RIDGE * float(np.mean(values[values > _NULL * values[0]] ** 2)) / len(rows)

    def greedy(self, count: int) -> list[int]:
        """Poses one after the other, each the one that tells most beside those before it."""
        chosen: list[int] = []
        inverse = np.eye(self.rows.shape[2]) / self.ridge
        for _ in range(count):
            gain = self._gains(inverse)
            gain[chosen] = -np.inf
            best = int(np.argmax(gain))
            chosen.append(best)
            inverse = _added(inverse, self.rows[best])
        return chosen

    def exchanged(self, chosen: list[int]) -> NDArray[np.int64]:
        """Poses exchanged one by one while the criterion falls."""
        size = self._size(chosen)
        for _ in range(_PASSES):
            before = size
            for at in range(len(chosen)):
                rest = chosen[:at] + chosen[at + 1 :]
                inverse = _inverse(self._information(rest))
                better = self._after(inverse)
                better[rest] = np.inf
                best = int(np.argmin(better))
                trial = [*chosen[:at], best, *chosen[at + 1 :]]
                then = self._size(trial)
                if then < size - 1e-12 * abs(size):
                    chosen, size = trial, then
            if not size < before - 1e-9 * abs(before):
                break
        return np.array(chosen, dtype=np.int64)

    def sigmas(self, chosen: NDArray[np.int64]) -> tuple[float, float]:
        """Root mean square and largest sigma of the exit points' coordinates, m."""
        variances = self._variances(_inverse(self._information(chosen)))
        return float(np.sqrt(variances.mean())), float(np.sqrt(variances.max()))

    def _information(self, chosen: list[int] | NDArray[np.int64]) -> Array:
        rows = self.rows[chosen].reshape(-1, self.rows.shape[2])
        return np.asarray(rows.T @ rows + self.ridge * 1e-6 * np.eye(rows.shape[1]))

    def _variances(self, inverse: Array) -> Array:
        return np.asarray(np.einsum("ad,de,ae->a", self.exits, inverse, self.exits))

    def _size(self, chosen: list[int]) -> float:
        """What is to be small."""
        information = self._information(chosen)
        if self.criterion == "d-optimal":
            return -float(np.linalg.slogdet(information)[1])
        return float(self._variances(_inverse(information)).max())

    def _gains(self, inverse: Array) -> Array:
        """By how much each candidate's pose raises the logarithm of the determinant."""
        spread = np.einsum("crd,de,cse->crs", self.rows, inverse, self.rows)
        return np.asarray(np.linalg.slogdet(np.eye(spread.shape[1]) + spread)[1])

    def _after(self, inverse: Array) -> Array:
        """What is to be small, with each candidate added: up to a constant."""
        if self.criterion == "d-optimal":
            return -self._gains(inverse)
        across = self.rows @ inverse  # (C, r, d)
        inner = np.linalg.inv(np.eye(self.rows.shape[1]) + np.einsum("crd,csd->crs", across, self.rows))
        seen = across @ self.exits.T  # (C, r, a)
        fallen = np.einsum("cra,crs,csa->ca", seen, inner, seen)
        return np.asarray((self._variances(inverse) - fallen).max(axis=1))


def _inverse(matrix: Array) -> Array:
    return np.asarray(np.linalg.inv(matrix), dtype=np.float64)


def _added(inverse: Array, rows: Array) -> Array:
    """The inverse information with the rows of one more pose (Woodbury)."""
    across = rows @ inverse
    return np.asarray(inverse - across.T @ np.linalg.solve(np.eye(len(rows)) + across @ rows.T, across))


def _travel(path: Array) -> float:
    return float(np.linalg.norm(np.diff(path[:, :3], axis=0), axis=1).sum())


def _ordered(points: Array) -> NDArray[np.int64]:
    """An order that moves little: from the point nearest to their middle to the nearest next, then 2-opt."""
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    order = [int(np.argmin(np.linalg.norm(points - points.mean(axis=0), axis=1)))]
    left = set(range(len(points))) - set(order)
    while left:
        order.append(min(left, key=lambda at: (apart[order[-1], at], at)))
        left.remove(order[-1])
    better = True
    while better:
        better = False
        for i in range(1, len(order) - 1):
            for j in range(i + 1, len(order)):
                tail = apart[order[j], order[j + 1]] if j + 1 < len(order) else 0.0
                new_tail = apart[order[i], order[j + 1]] if j + 1 < len(order) else 0.0
                if apart[order[i - 1], order[j]] + new_tail < apart[order[i - 1], order[i]] + tail - 1e-12:
                    order[i : j + 1] = reversed(order[i : j + 1])
                    better = True
    return np.array(order)
