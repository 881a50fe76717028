"""Drift check: whether anything moved since a calibration, which line and by how much, from a few new measurements.

The calibration predicts the new rows with an uncertainty, from its covariance and the sensors' noise. Poses, which are
unknown, are eliminated, and with a new home the lengths at home too. The remaining differences are tested against
changes of a line's length (a slip, a wrong count), of its exit point, of both, of the scale of all lengths, and against
single wrong readings.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar, Final

import numpy as np

from cablewright.calibration.drift.record import CalibrationRecord, load_record
from cablewright.calibration.judgement.likely_changes import (
    CHANGE_PARTS,
    READING,
    SCALE,
    DriftChange,
    Evidence,
    Suspect,
    beside,
)
from cablewright.calibration.judgement.model_doubt import believed_of_sensors, stretch_of
from cablewright.calibration.judgement.sigmas import kind_of
from cablewright.calibration.measurement_rows.load_cells import check_counterweights, require_tensions
from cablewright.calibration.measurement_rows.measurement_kinds import ON_ONE_DRUM
from cablewright.calibration.measurement_rows.pictures import with_pictures
from cablewright.calibration.measurement_rows.vibrations import AT_START, with_vibrations
from cablewright.calibration.measurements import Measured, read_measured
from cablewright.calibration.plan import STRETCH
from cablewright.calibration.poses.derivatives import Derivatives
from cablewright.calibration.poses.elastic import ElasticProblem, problem_of
from cablewright.calibration.poses.fit import fit, fitted_poses
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.calibration.poses.start_values import best_fit, equilibria_at, straight_plan, unmirrored
from cablewright.calibration.poses.sufficient_data import check_lengths, surplus_per_pose
from cablewright.calibration.sightings.sighted import CAMERA, SightedUnknown
from cablewright.calibration.unknowns import NAMES
from cablewright.foundation.arrays import Array, Indices, Mask
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.results import Figure, Result
from cablewright.models.fidelity import CableLaw
from cablewright.models.plane import turning_axis
from cablewright.models.rotation import yawed
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.robot.parameters import KINDS

_YAWS: Final = tuple(np.radians(range(30, 360, 30)).tolist())
_FITS: Final = 100.0  # max mean square of a pose's residuals over their sigma: beyond, other start values are tried
_BETTER: Final = 0.5  # of the squares, to prefer those of another start
FALSE_ALARM: Final = 0.01
"""Default share of false alarms: checks that report a change although nothing has changed."""

_FREED: Final = ("exit_point", "length_offset")
_OF_LINES: Final = ("exit_point.x", "length_offset")
_NAMED: Final = 2  # redundant numbers of a pose with which its wrong line can be identified


def states_at(problem: CalibrationProblem, theta: Array, new_home: bool) -> tuple[Array, Array]:
    """Return unknowns (k,) and pose states (N, ..) that fit new data; *new_home*: fit home lengths too."""
    straight = problem
    if isinstance(problem, ElasticProblem):
        straight = StraightProblem.of(problem.robot, problem.measured, straight_plan(problem), hold=False)
    known = dict(zip(problem.unknowns, theta.tolist(), strict=True))
    start = np.array([known[each] for each in straight.unknowns])  # those that straight lines have too
    if new_home:
        start = with_new_home(straight, start)
    poses = _poses(straight, start)
    if not isinstance(problem, ElasticProblem):
        free = _camera(problem)  # its place is new
        found = fit(problem.for_poses_only(start, free), start[free], poses)
        start[free] = found.theta
        return start, found.poses
    theta = theta.copy()
    if new_home:
        theta[problem.named("length_offset")] = start[straight.named("length_offset")]
    states = problem.states_of(equilibria_at(problem, Model(problem.robot), poses))
    return theta, fit(problem.for_poses_only(theta), np.zeros(0), states).poses


def _camera(problem: CalibrationProblem) -> Mask:
    """Return which of the unknowns (k,) are the place and the turn of a camera."""
    return problem.named("camera_place") | problem.named("camera_turn")


def _poses(problem: CalibrationProblem, theta: Array) -> Array:
    """Return the poses (N, n) that fit, from the start values in the data, or from the middle of the frame.

    A calibration with azimuths may have turned the frame, so where start values do not fit others are tried that turn
    about the middle with it.
    """
    scene, guess = problem.robot.scene, problem.measured.guess
    middle = 0.5 * (np.array(scene.frame_min) + np.array(scene.frame_max))
    start = np.zeros((problem.poses, problem.robot.n))
    start[:, :3] = middle
    if guess is not None:
        start = np.where(np.isfinite(guess).all(axis=1, keepdims=True), guess, start)
    best, cost = _fitted(problem, theta, start)
    axis = turning_axis(problem.robot.platform.plane)
    for yaw in _YAWS if (cost > _FITS * problem.per_pose).any() else ():
        found, its = _fitted(problem, theta, yawed(start, yaw, middle, axis))
        better = its < _BETTER * cost
        best, cost = np.where(better[:, None], found, best), np.where(better, its, cost)
    return best


def _fitted(problem: CalibrationProblem, theta: Array, start: Array) -> tuple[Array, Array]:
    """Return the poses (N, n) that fit from a *start* (N, n), and their sums (N,) of squared residuals."""
    poses = unmirrored(problem, theta, fitted_poses(problem, theta, start))
    squares = np.sum(problem.derivatives(theta, poses).residual ** 2, axis=1)
    return poses, np.where(np.isfinite(squares), squares, np.inf)


def with_new_home(problem: CalibrationProblem, theta: Array) -> Array:
    """Return the unknowns (k,) with the lengths at home that fit the data, all others held."""
    homes = problem.named("length_offset")
    if not homes.any():  # lengths are absolute
        return theta
    plan = problem.plan.model_copy(
        update={"unknowns": ("length_offset",), "shared": (), "groups": (), "priors": (), "bounds": ()}
    )
    only = StraightProblem.of(problem.robot, problem.measured, plan, hold=False)
    only = replace(only, rows=only.rows._replace(lines=problem.line_numbers(theta)))
    changed = theta.copy()
    changed[homes] = best_fit(only, seed=0, rough=0.0).theta[only.named("length_offset")]
    return changed


@dataclass(frozen=True)
class LineDrift:
    """Apparent length change of a line, if no other changed, and the smallest change that the test detects."""

    line: str
    change: float  # m
    sigma: float  # m
    detectable: float  # m


FIGURES = (
    Figure("verdict", "", "unchanged, moved, or wrong-reading: single readings that do not fit the others."),
    Figure("probability", "1", "Probability of such measurements if nothing changed.", digits=2),
    Figure("false_alarm", "1", "Probability below which something moved.", name="limit"),
    Figure("changes", "", "What explains the measurements, in the order in which it was named.", name="what changed",
           parts=CHANGE_PARTS),
    Figure("rest", "1", "Probability of the unexplained rest.", only=lambda of: bool(of.changes),
           digits=2),
    Figure("lines", "", "The length of each line, as if it alone changed.", parts=(
        Figure("line", "", "The line."),
        Figure("change", "m", "Its length less that of the calibration.", digits=3, shown="mm"),
        Figure("sigma", "m", "Standard deviation of that.", digits=2, shown="mm"),
        Figure("detectable", "m", "Change of this size that nine of ten such checks find.", name="found from", digits=2,
               shown="mm"),
    )),
    Figure("poses", "1", "Number of poses measured.", "measured"),
    Figure("redundancy", "1", "Number of measurements that are left over."),
    Figure("since", "", "Date of the calibration."),
    Figure("notes", "", "What limits the answer.", detail=True),
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Drift(Result):
    """The result of a drift check: `changes` since the calibration.

    There are some if the `probability` of the data without a change is under `false_alarm`.
    """

    FIGURES: ClassVar = FIGURES
    HEADLINES: ClassVar = ("verdict", "probability", "poses")

    probability: float
    false_alarm: float
    changes: tuple[DriftChange, ...]
    rest: float
    lines: tuple[LineDrift, ...]
    measured: int
    redundancy: int
    since: str
    notes: tuple[str, ...]

    @property
    def verdict(self) -> str:
        """Whether anything has moved since the calibration, in one word, such as "unchanged"."""
        if self.probability >= self.false_alarm:
            return "unchanged"
        wrong = bool(self.changes) and all(each.pose is not None for each in self.changes)
        return "wrong-reading" if wrong and self.rest >= self.false_alarm else "moved"

    @property
    def refusal(self) -> str:
        """A sentence that names the detected changes; empty if there are none."""
        if self.verdict == "unchanged":
            return ""
        named = "; ".join(each.sentence for each in self.changes) or "no single change explains how"
        left = "" if self.rest >= self.false_alarm else "; and more that this does not explain"
        return f"{self.verdict.replace('-', ' ')}: {named}{left}"


def check_drift(
    robot: Robot | Model,
    data: str | Path | Measured,
    record: str | Path | CalibrationRecord,
    *,
    false_alarm: float = FALSE_ALARM,
    new_home: bool = False,
) -> Drift:
    """Test new *data* of a calibrated *robot* against the *record* of its calibration.

    *new_home*: whether lengths were set to zero again: then those at home are unknown, and not tested. *false_alarm*:
    the share of checks that find a change where there is none. Positions in the data are start values only.

    Raises `InputError` for a record that is not of this robot, and for data that leave nothing over; `AnswerError` if
    no pose explains a row.

    Examples
    --------
    >>> import cablewright as cw
    >>> from datetime import UTC, datetime
    >>> from cablewright.calibration.drift.record import record_of
    >>> robot, data = cw.load("wang2021"), "examples/calibration.csv"
    >>> found = cw.calibrate(robot, data)
    >>> cw.check_drift(found.robot, data, record_of(found, data, datetime.now(UTC))).verdict
    'unchanged'
    """
    if not 0.0 < false_alarm < 0.5:
        raise InputError(f"false_alarm = {false_alarm:g}: must be over 0 and under 0.5")
    known = record if isinstance(record, CalibrationRecord) else load_record(record)
    where = "the record" if isinstance(record, CalibrationRecord) else str(record)
    model = Model.of(robot, cable=known.cable, default=CableLaw.RIGID)
    known.unknowns_in(model.robot, where)
    measured = data if isinstance(data, Measured) else read_measured(data, model.robot)
    check_lengths(model.robot, measured)
    check_counterweights(model, measured)
    model, measured = _with_pictures(model, measured, known, new_home)
    measured = with_vibrations(model.robot, measured, known.plan, measured.guess, AT_START)
    problem, spread, theta, states = _at_record(model, measured, known, new_home)
    if measured.frequencies is not None:  # their spans are better known now
        measured = with_vibrations(model.robot, measured, known.plan, problem.poses_of(states))
        problem, spread, theta, states = _at_record(model, measured, known, new_home)
    rows = problem.derivatives(theta, states)
    lost = ~np.isfinite(rows.residual).all(axis=1)
    if lost.any():
        raise AnswerError(f"{measured.origin}, {measured.place(int(np.argmax(lost)))}: no pose explains this row")
    eliminated = _Eliminated.of(problem, rows, new_home)
    if len(eliminated.numbers) < 1:
        raise InputError(
            f"{measured.origin}: there are no redundant measurements, so nothing can be tested: measure more poses"
        )
    suspects = list(_suspects(problem, eliminated, new_home))
    through = _through(problem, theta, states, eliminated)
    covariance = np.eye(len(through)) + through @ spread @ through.T
    evidence = Evidence(eliminated.numbers, covariance, suspects, known.freedom)
    found = evidence.explained(false_alarm)
    lines = () if new_home else tuple(_lines(evidence, suspects, false_alarm))
    return Drift(
        found.probability,
        false_alarm,
        found.changes,
        found.rest,
        lines,
        problem.poses,
        len(eliminated.numbers),
        known.date.isoformat(timespec="minutes"),
        tuple(_notes(measured, known, new_home, found.probability < false_alarm)),
    )


def _with_pictures(
    model: Model, measured: Measured, known: CalibrationRecord, new_home: bool
) -> tuple[Model, Measured]:
    """Return model and data with start values by their pictures: the camera's by poses that the lengths determine."""
    if measured.sightings is not None and measured.guess is None:
        alone = replace(measured, sightings=None)
        problem, _, _, states = _at_record(model, alone, known, new_home)
        measured = replace(measured, guess=problem.poses_of(states))
    return with_pictures(model, measured)


def _at_record(
    model: Model, measured: Measured, known: CalibrationRecord, new_home: bool
) -> tuple[CalibrationProblem, Array, Array, Array]:
    """Return the equations, the covariance of `_of_record`, and the unknowns and states of the poses there."""
    problem = known.weighed(_problem(model, replace(measured, pose_sigma=None), known))
    theta, spread = _of_record(problem, known)
    return problem, spread, *states_at(problem, theta, new_home)


def _problem(model: Model, measured: Measured, known: CalibrationRecord) -> CalibrationProblem:
    """Return the equations with the record's unknowns, what it considers, exit points and home lengths.

    And with the assumed errors of sensors that the calibration did not have.
    """
    plan, considered = known.plan, [each for each in known.considered if each.name in NAMES]
    names = (*plan.unknowns, *(each.name.partition(".")[0] for each in considered), *_FREED)
    names += tuple(believed_of_sensors(measured, plan.sigma))
    shared = (*plan.shared, *(each.name for each in considered if each.line is None and KINDS[each.name].per_line))
    plan = plan.model_copy(update={"unknowns": tuple(dict.fromkeys(names)), "shared": tuple(dict.fromkeys(shared))})
    problem = problem_of(model, measured, plan, hold=False)
    if not problem.elastic:
        require_tensions(model.robot, measured)
        if "exit_compliance" in known.unknowns and measured.tensions is None:
            raise InputError(
                f"{measured.origin}: no columns f_1 ..: the calibration has exit_compliance, for which tensions are "
                f"needed; measure them"
            )
    if surplus_per_pose(problem) < 1:
        raise InputError(
            f"{measured.origin}: {problem.robot.m} lines give no redundant measurement at a pose, so nothing can be "
            f"tested: measure tensions too"
        )
    return problem


def _of_record(problem: CalibrationProblem, known: CalibrationRecord) -> tuple[Array, Array]:
    """Return the unknowns (k,) at the record's values, and their covariance (k + 1, k + 1), SI, the stretch's last.

    It is 0 for values without uncertainty in the record, the assumed error for sensors that it does not have, and that
    of their layout for tags, prints and lenses that it does not have. Raises `InputError` for pictures without a camera
    in the record.
    """
    its = {(each.name, each.line): at for at, each in enumerate((*known.values, *known.considered))}
    if problem.measured.sightings is not None and ("camera_place.x", CAMERA) not in its:
        raise InputError(
            f"{problem.measured.origin}: the record is of a calibration without pictures: leave --pictures out, or "
            "calibrate with pictures first"
        )
    mine = [*((each.kind, each.line) for each in problem.unknowns), (STRETCH, None)]
    both = [(here, its[name]) for here, name in enumerate(mine) if name in its]
    here, there = (np.array(side) for side in zip(*both, strict=True))
    theta, by = problem.start.copy(), np.ones(len(both))
    for at, (mine_at, its_at) in enumerate(both):
        if its_at >= len(known.values):  # considered: its value is its possible error
            continue
        value, unknown = known.values[its_at].value, problem.unknowns[mine_at]
        if unknown.name == "modulus":  # relative to the file, which the calibration changed
            by[at] = 1.0 / value
        else:
            theta[mine_at] = value / unknown.size
    believed = believed_of_sensors(problem.measured, known.sigma)
    spread = np.diag([believed.get(each.name, 0.0) ** 2 for each in problem.unknowns] + [0.0])
    spread[np.ix_(here, here)] = known.spread[np.ix_(there, there)] * np.outer(by, by)
    new = [at for at, each in enumerate(problem.unknowns) if isinstance(each, SightedUnknown) and at not in here]
    if new:
        _follow_layout(problem, np.array(new), spread)
    return theta, spread


def _follow_layout(problem: CalibrationProblem, new: Indices, spread: Array) -> None:
    """Put into a covariance (k + 1, k + 1), SI, of *new* unknowns by the rows of their layout, given the others."""
    stated = problem.rows.linear[len(problem.rows.linear) - problem.stated :]
    rows = stated / np.array([each.size for each in problem.unknowns])
    own = np.linalg.pinv(rows[:, new].T @ rows[:, new], hermitian=True)
    by_others = -own @ rows[:, new].T @ np.delete(rows, new, axis=1)
    others = np.delete(np.arange(len(problem.unknowns)), new)
    spread[np.ix_(new, others)] = by_others @ spread[np.ix_(others, others)]
    spread[np.ix_(others, new)] = spread[np.ix_(new, others)].T
    spread[np.ix_(new, new)] = own + by_others @ spread[np.ix_(others, new)]


def _through(problem: CalibrationProblem, theta: Array, states: Array, eliminated: _Eliminated) -> Array:
    """Return how the numbers (d, k + 1) follow unknowns, SI, and a stretch of lines that count as stiff."""
    found = None if problem.elastic else stretch_of(problem, theta, states)
    stretch = np.zeros((problem.poses, problem.robot.m)) if found is None else found
    extra = problem.of_poses(problem.weights) * problem.in_lengths(stretch)
    sizes = [each.size for each in problem.unknowns]
    return np.column_stack([eliminated.unknowns / sizes, eliminated.turned @ extra.ravel()])


@dataclass(frozen=True, eq=False)
class _Eliminated:
    """Return rows without the part that poses, and with a new home its lengths, explain: d numbers of unit noise."""

    numbers: Array  # (d,)
    unknowns: Array  # (d, k) their derivatives
    turned: Array  # (d, N e): how they follow from the rows

    @classmethod
    def of(cls, problem: CalibrationProblem, rows: Derivatives, new_home: bool) -> _Eliminated:
        used, count = problem.of_poses(problem.weights) > 0.0, rows.residual.size
        turned, e = [], problem.per_pose
        for pose, by_pose in enumerate(rows.by_pose):
            own = np.flatnonzero(used[pose])
            free = np.zeros((len(own), count))
            free[:, pose * e + own] = np.eye(len(own))
            turned.append(beside(by_pose[own]).T @ free)
        whole = np.concatenate(turned)
        by_unknown = rows.by_unknown.reshape(count, -1)
        new = _camera(problem) | (problem.named("length_offset") & new_home)
        if new.any():
            whole = beside(whole @ by_unknown[:, new]).T @ whole
        return cls(whole @ rows.residual.ravel(), whole @ by_unknown, whole)


def _suspects(problem: CalibrationProblem, eliminated: _Eliminated, new_home: bool) -> Iterator[Suspect]:
    """Yield the possible changes: lengths first, in the order of lines."""
    m, effects = problem.robot.m, -eliminated.unknowns / np.array([each.size for each in problem.unknowns])
    column, seen = {(one.kind, one.line): at for at, one in enumerate(problem.unknowns)}, problem.measured.sightings
    lines, homes = ([x.name for x in problem.robot.lines if (kind, x.name) in column] for kind in _OF_LINES)
    for name in homes if not new_home else ():
        yield Suspect("length", name, effects[:, [column["length_offset", name]]], m)
    for name in lines:
        moves = effects[:, [column[f"exit_point.{axis}", name] for axis in "xyz"]]
        for tag in seen.tags if seen else ():  # what is on the exit point moves with it
            if tag.line == name:
                moves = moves + effects[:, [column[f"tag_place.{axis}", f"tag {tag.number}"] for axis in "xyz"]]
        yield Suspect("exit point", name, moves, m)
        if not new_home and name in homes:
            longer = effects[:, [column["length_offset", name]]]
            yield Suspect("exit point and length", name, np.hstack([moves, longer]), m, of_alarm=False)
    weights = problem.of_poses(problem.weights)
    out = weights * problem.in_lengths(problem.measured.counted)
    yield Suspect(SCALE, None, eliminated.turned @ out.reshape(-1, 1))
    yield from _readings(problem, eliminated)


def _readings(problem: CalibrationProblem, eliminated: _Eliminated) -> Iterator[Suspect]:
    """Yield single readings that may be wrong; if a pose has one redundant number, its line is unknown."""
    kinds, which = kind_of(problem), problem.rows.line[: problem.per_pose]
    weights = problem.of_poses(problem.weights)
    effects = -eliminated.turned.reshape(-1, problem.poses, problem.per_pose) * weights
    among = int((weights > 0.0).sum())
    for pose in range(problem.poses):
        own = np.flatnonzero((weights[pose] > 0.0) & ~np.isin(kinds, ("sightings", ON_ONE_DRUM)))
        alike = len(np.flatnonzero(weights[pose])) - problem.unknowns_per_pose < _NAMED
        if alike:
            own = own[[int(np.argmax(np.linalg.norm(effects[:, pose, own], axis=0)))]]
        for at in own.tolist():
            named = not alike and kinds[at] not in ("tilts", "yaw angles")
            what = "one of the readings" if alike else f"{READING}{kinds[at]}"
            line = problem.robot.lines[int(which[at])].name if named else None
            yield Suspect(what, line, effects[:, pose, [at]], among, pose, of_alarm=False)
        for index, tag in enumerate(problem.measured.sightings.tags if problem.measured.sightings else ()):
            rows = np.flatnonzero((kinds == "sightings") & (problem.rows.other[: problem.per_pose] == index + 1))
            if weights[pose, rows].any():
                yield Suspect("sighting", f"tag {tag.number}", effects[:, pose, rows], among, pose, of_alarm=False)


def _lines(evidence: Evidence, suspects: list[Suspect], level: float) -> Iterator[LineDrift]:
    for at, each in enumerate(suspects):
        if each.what == "length" and each.line is not None:
            yield LineDrift(each.line, *evidence.alone(at), evidence.detectable(at, level))


def _notes(measured: Measured, known: CalibrationRecord, new_home: bool, moved: bool) -> Iterator[str]:
    told = {each.name.partition(".")[0] for each in (*known.values, *known.considered)}
    new = sorted(set(believed_of_sensors(measured, known.sigma)) - told)
    if new:
        yield f"the calibration did not have these sensors: {', '.join(new)} count as known to about their sigma"
    if measured.pose_sigma is not None:
        yield "measured positions are start values here: they are in a frame of their own"
    if new_home:
        yield "home is new: lengths at home are not tested"
    elif moved:
        yield "if the lengths were zeroed since the calibration, give --new-home"
