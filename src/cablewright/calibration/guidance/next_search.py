"""Choice of the poses to measure next: each reduces the largest standard deviation of an exit point most."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from cablewright.calibration.guidance.pictures_to_take import CameraView
from cablewright.calibration.guidance.pose_selection import PoseSearch
from cablewright.calibration.guidance.present_knowledge import Knowledge
from cablewright.calibration.measurement_rows.pictures import as_body
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.poses.observability import projected
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.sightings.sighted import Sightings
from cablewright.calibration.unknowns import Unknown, exit_rows
from cablewright.foundation.arrays import Array

_MAX_MORE: Final = 60  # poses within which the required accuracy must be reached
_RIDGE: Final = (1e-8, 1e-12)  # of the mean information, so that it is regular: before there are enough poses, and then


class NextSearch(PoseSearch):
    """Choice of poses one by one, in the space that data and candidates determine together.

    *places* (C, n): the candidates. *view*: what pictures there will show. *like*: candidates near which poses are
    measured that do not count in *known* yet.
    """

    def __init__(
        self, known: Knowledge, places: Array, view: CameraView | None = None, like: Sequence[int] = ()
    ) -> None:
        self.view, self.robot = view, known.problem.robot
        self.seen = None if view is None else view.at(places)
        rows, told, unknowns = _rows_of(known, places, self.seen)
        exits, self.line_of = exit_rows(self.robot, unknowns)
        super().__init__(rows, exits, told)
        self.lines, self.known = self.robot.m, known.found is not None
        if known.found is not None:
            own = exits[:, : known.rows.shape[1]]
            self.assumed = np.sum((own @ known.found.doubt.assumed) * own, axis=1)
        own = np.concatenate([told @ self.basis, *self.rows[list(like)]])
        ridge = _RIDGE[known.found is not None] * float(np.mean(np.sum(own**2, axis=0)))
        self.root = _root(own, np.sqrt(ridge) * np.eye(own.shape[1]))

    def sigmas(self, inverse: Array | None = None) -> Array:
        """Return the largest standard deviation of each exit point's coordinates (m,), m."""
        found = np.zeros(self.lines)
        np.maximum.at(found, self.line_of, self.variances(_inverse(self.root) if inverse is None else inverse))
        return np.asarray(np.sqrt(found))

    def chosen(self, size: int, need: float) -> tuple[list[int], Array, int | None]:
        """Return the *size* best poses, sigmas (m,) after them, and how many more reach *need*; None if never."""
        root, made = self.root, list[int]()
        inverse = _inverse(root)
        then = self.sigmas()
        for _ in range(min(size + _MAX_MORE * self.known, len(self.rows))):
            if len(made) >= size and float(self.sigmas(inverse).max()) <= need:
                return made[:size], then, len(made) - size
            after = self.after(inverse)
            after[made] = np.inf
            best = int(np.argmin(after))
            made.append(best)
            root = _root(root, self.rows[best])
            inverse = _inverse(root)
            if len(made) == size:
                then = self.sigmas(inverse)
        return made[:size], then, None

    def whys(self, ordered: list[int], poses: int) -> Iterator[str]:
        """Yield what each pose brings, after the *poses* that are measured and those before it."""
        root, before = self.root, self.sigmas()
        for number, at in enumerate(ordered, poses + 1):
            root = _root(root, self.rows[at])
            after = self.sigmas(_inverse(root))
            worst = int(np.argmax(before))
            gain = (
                f"exit point {self.robot.lines[worst].name}: {1e3 * before[worst]:.3g} to {1e3 * after[worst]:.3g} mm"
            )
            gain = gain if self.known else "needed for a first result"
            if self.seen is not None and (picture := self.seen.pictures[at]) is not None:
                tags = ", ".join(str(each.number) for each in picture.sightings)
                gain = f"pose-{number:02d}.jpg, with tags {tags or '(none)'}; {gain}"
            yield gain
            before = after


def variance_with(known: Knowledge, places: Array, view: CameraView) -> float:
    """Return the sum of the variances of exit points, m^2, after pictures at *places* (C, n) from a *view*.

    Before there is a result: the file's exit points are known to a few centimetres, so that all is determined.
    """
    rows, told, unknowns = _rows_of(known, places, view.at(places))
    every = np.concatenate([told, rows.reshape(-1, rows.shape[2])])
    information = every.T @ every
    information += _RIDGE[0] * np.mean(np.diag(information)) * np.eye(len(information))
    exits, _ = exit_rows(known.problem.robot, unknowns)
    return float(np.sum(exits @ np.linalg.inv(information) * exits))


def _rows_of(known: Knowledge, places: Array, seen: Sightings | None) -> tuple[Array, Array, tuple[Unknown, ...]]:
    """Return rows (C, e, k) of measurements at *places*, poses eliminated, known rows (r, k), and the k unknowns.

    They are the unknowns of the problem, then those that only pictures there bring, with the prior knowledge of them.
    """
    problem, body = known.problem, known.problem.robot if seen is None else as_body(known.problem.robot)
    states = np.pad(places, ((0, 0), (0, body.n - places.shape[1])))
    blank, kept = Measured(np.zeros((len(places), body.m)), states, sightings=seen), problem.plan
    sigma = kept.sigma.model_copy(update={"encoder": known.sigma})
    plan = CalibrationPlan(
        unknowns=kept.unknowns, shared=kept.shared, groups=kept.groups, datum=kept.datum, sigma=sigma
    )
    wanted = StraightProblem.of(body, blank, plan, hold=bool(problem.held.any()))
    old, new = problem.free_unknowns, wanted.free_unknowns
    at = {(each.kind, each.line): index for index, each in enumerate(old)}
    at |= {
        key: index
        for index, key in enumerate(((one.kind, one.line) for one in new if (one.kind, one.line) not in at), len(at))
    }
    column = np.array([at[each.kind, each.line] for each in new])
    theta = np.append(known.theta, np.zeros(len(at) - len(old)))[column]
    theta = np.where(column < len(old), theta, wanted.free)
    rows, linear = (
        np.zeros((*shape, len(at))) for shape in ((len(places), wanted.per_pose), wanted.rows.linear.shape[:1])
    )
    rows[..., column] = projected(wanted.derivatives(theta, states))[1]
    linear[:, column] = wanted.rows.linear
    told = np.pad(known.rows, ((0, 0), (0, len(at) - known.rows.shape[1])))
    told = np.concatenate([told, linear[linear[:, len(old) :].any(axis=1)]])
    return rows, told, (*old, *(each for each, index in zip(new, column.tolist(), strict=True) if index >= len(old)))


def _root(*rows: Array) -> Array:
    """Return a triangle (d, d) with the Gram matrix of all *rows* (.., d): the information that they have together.

    Beside what nothing determines yet, rounding would take the rest from the information itself, and from its inverse.
    """
    return np.asarray(np.linalg.qr(np.concatenate(rows), mode="r"))


def _inverse(root: Array) -> Array:
    """Return the covariance (d, d) by the *root* (d, d) of an information."""
    half = np.linalg.inv(root)
    return np.asarray(half @ half.T)
