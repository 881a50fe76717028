"""The nozzle's error: the lengths that a controller's model commands, evaluated on the full model.

Paty 2021, section 2.3: the error when cables are taken as rigid, and the uncertainty that their moduli leave.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple, Self, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.analyses.accuracy.compensation import Compensation, Reached
from cablewright.analyses.accuracy.corners import ALL_VERTICES
from cablewright.analyses.accuracy.spread import FirstOrder, Method, MonteCarlo, Spread, SpreadProblem, Vertices
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import AnswerError, InputError, Status, UnknownName
from cablewright.foundation.memory_mapped import Room, blocks, let_go, room_for, write_rows
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure, Result
from cablewright.models.rotation import angle_between
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.robot.uncertainty import Range
from cablewright.solvers.arguments import as_poses, given_numbers
from cablewright.solvers.inverse import BLOCK, solve_inverse

METHODS: dict[str, Method] = {each.name: each for each in (Vertices(), FirstOrder(), MonteCarlo())}


def _most(values: Array) -> float:
    """The largest of *values* that is not NaN; NaN if there is none."""
    return float("nan") if np.isnan(values).all() else float(np.nanmax(values))


class Contribution(NamedTuple):
    """One uncertain parameter: its range, and the displacement of the nozzle that it causes alone."""

    range: Range
    offset: Array  # (3,) m, displacement of the nozzle by half the range, at the pose where it is largest
    at_max_error: float  # value at the largest error, in the parameter's unit; NaN where there is none

    @property
    def effect(self) -> float:
        """Distance that this uncertain number moves the nozzle, m: the length of `offset`."""
        return float(np.linalg.norm(self.offset))


CONTRIBUTION = (
    Figure("parameter", "", "Label of the uncertain parameter.", "range.parameter.label", "uncertain parameter"),
    Figure("unit", "", "Unit of its values.", "range.parameter.unit"),
    Figure("nominal", "SI", "Nominal value, of the robot file.", "range.nominal", digits=7),
    Figure("low", "SI", "Min of its range.", "range.low", "min", 7),
    Figure("high", "SI", "Max of its range.", "range.high", "max", 7),
    Figure("standard_deviation", "SI", "Standard deviation of a normal distribution; null where it is uniform.",
           "range.deviation", digits=6),
    Figure("at_max_error", "SI", "Value at the largest error; null where there is none.", name="at the largest error",
           digits=7),
    Figure("effect", "m", "Displacement of the nozzle by half the range, largest of all poses, in first order.",
           shown="mm"),
    Figure("vertical_effect", "m", "Vertical part of that displacement.", lambda of: abs(of.offset[2]),
           "vertical part", shown="mm"),
    Figure("offset", "m", "x, y and z of that displacement.", detail=True),
)  # fmt: skip
TOO_CURVED = 0.05
"""Share of the spread by which first order may be off before a note says so."""


@dataclass(frozen=True, eq=False, repr=False)
class Accuracy(Result):
    """Errors of the nozzle at N poses due to k uncertain parameters, in SI units; NaN in rows without an answer.

    A code other than 0 states that the full model cannot hold the pose within the tension limits, or that the commanded
    lengths have no equilibrium. `len()` is N.
    """

    FIGURES: ClassVar = (
        Figure("robot", "", "Name of the robot.", "robot.name"),
        Figure("compensation", "", "Model from which the commanded lengths are."),
        Figure("parameters", "", "Labels of the uncertain parameters.", "labels", detail=True),
        Figure("places", "1", "Number of places.", len),
        Figure("answered", "1", "Number of places with an answer.", lambda found: int(found.ok.sum())),
        Figure("refused", "1", "Number of places without an answer, by status.", "_refused"),
        Figure("nominal_error", "m", "Largest error if all parameters are nominal (Paty's delta p_n).",
               lambda at: _most(at.nominal_error), shown="mm"),
        Figure("max_error", "m", "Largest error (Paty's delta p_max).", lambda at: _most(at.spread.max_error),
               shown="mm"),
        Figure("max_error_at", "m", "Expected position of the nozzle where the error is largest.",
               lambda at: _at(at.wanted_nozzle, at.spread.max_error), shown="m"),
        Figure("max_error_values", "", "Values of the uncertain parameters there.", "_worst_values", detail=True),
        Figure("smallest_max_error", "m", "Largest error of the best place.",
               lambda at: -_most(-at.spread.max_error), shown="mm"),
        Figure("smallest_max_error_at", "m", "Expected position of the nozzle at the best place.",
               lambda at: _at(at.wanted_nozzle, -at.spread.max_error), shown="m"),
        Figure("difference", "m", "Largest difference of a place's largest and nominal error (Paty's delta p).",
               lambda at: _most(at.difference), shown="mm"),
        Figure("max_deviation", "m", "Largest distance of the nozzle from its nominal position.",
               lambda at: _most(at.spread.max_deviation), shown="mm"),
        Figure("lowest_error", "m", "Min of x, y and z of the error.", lambda at: _ends(np.fmin, at.spread.low),
               "min error, x, y, z", shown="mm"),
        Figure("highest_error", "m", "Max of x, y and z of the error.", lambda at: _ends(np.fmax, at.spread.high),
               "max error, x, y, z", shown="mm"),
        Figure("max_horizontal_error", "m", "Largest horizontal part of a place's largest error.",
               lambda at: _most(np.linalg.norm(at.worst_offset[:, :2], axis=1)), shown="mm"),
        Figure("max_vertical_error", "m", "Largest vertical part of a place's largest error.",
               lambda at: _most(np.abs(at.worst_offset[:, 2])), shown="mm"),
        Figure("max_turn", "rad", "Largest angle of the platform from its expected rotation; 0 for a point platform.",
               lambda at: _most(at.spread.max_turn)),
        Figure("nonlinearity", "1", "Largest error of the first-order estimate, as a share of the spread.",
               lambda at: _most(at.spread.nonlinearity), digits=2, shown="%"),
        Figure("unsolved", "1", "Number of solves without a sound equilibrium, which are left out.",
               lambda at: int(at.spread.unsolved.sum())),
        Figure("contributions", "", "Effect of each uncertain parameter alone, largest first.",
               parts=CONTRIBUTION),
    )  # fmt: skip
    HEADLINES: ClassVar = ("robot", "compensation", "places", "nominal_error", "max_error")

    robot: Robot
    ranges: tuple[Range, ...]
    compensation: str
    method: str  # name of the method that found the spread
    wanted: Array  # (N, n) poses
    commanded: Array  # (N, m) lengths
    codes: NDArray[np.int64]  # (N,)
    nominal: Array  # (N, n) poses reached if all parameters are nominal
    spread: Spread

    def __len__(self) -> int:
        """Number of poses."""
        return len(self.codes)

    def __getitem__(self, index: int | slice) -> Accuracy:
        """Return some of its poses; a single index gives one row."""
        rows = index if isinstance(index, slice) else np.arange(len(self))[[index]]
        spread = Spread(**{name: values[rows] for name, values in self.spread.__dict__.items()})
        own = {name: getattr(self, name)[rows] for name in ("wanted", "commanded", "codes", "nominal")}
        return replace(self, spread=spread, **own)

    @property
    def columns(self) -> dict[str, Array]:
        """Columns (N,) of `to_frame`: wanted positions of the nozzle, m, and errors there, m."""
        places = dict(zip("xyz", Model(self.robot).nozzle(self.wanted).T, strict=True))
        own = {"nominal_error": self.nominal_error, "max_error": self.spread.max_error, "difference": self.difference}
        return places | own | {"max_deviation": self.spread.max_deviation}

    @property
    def labels(self) -> list[str]:
        """Labels (k,) of the uncertain parameters."""
        return [each.parameter.label for each in self.ranges]

    @property
    def ok(self) -> Mask:
        """Mask (N,) of poses at which the error could be computed."""
        return np.asarray(self.codes == 0)

    @property
    def wanted_nozzle(self) -> Array:
        """(N, 3) commanded position of the nozzle, m."""
        return Model(self.robot).nozzle(self.wanted)

    @property
    def nominal_offset(self) -> Array:
        """(N, 3) error of the nozzle if all parameters are nominal, m: Paty's delta p_n."""
        model = Model(self.robot)
        return self._by_blocks(lambda of: model.nozzle(of.nominal) - of.wanted_nozzle)

    @property
    def nominal_error(self) -> Array:
        """Nozzle error (N,), m, with all parameters nominal: the length of `nominal_offset`."""
        return np.asarray(np.linalg.norm(self.nominal_offset, axis=1))

    @property
    def nominal_turn(self) -> Array:
        """(N,) angle of the platform from the commanded rotation, rad; 0 for a point platform."""
        if self.robot.n == 3:
            return np.where(self.ok, 0.0, np.nan)
        return angle_between(self.wanted[:, 3:], self.nominal[:, 3:])

    @property
    def difference(self) -> Array:
        """(N,) largest error less the nominal one, m: the delta p of Paty's Table 1."""
        return self.spread.max_error - self.nominal_error

    @property
    def worst_offset(self) -> Array:
        """(N, 3) the largest error of the nozzle as a vector, m: Paty's delta p_max."""
        return self._by_blocks(lambda of: of.spread.worst - of.wanted_nozzle)

    def _by_blocks(self, values: Callable[[Accuracy], Array]) -> Array:
        """What *values* gives of the poses, some at a time: they may lie in files."""
        found = np.empty((len(self), 3))
        for at in blocks(len(self)):
            found[at] = values(self[at])
            let_go(self)
        return found

    def _refused(self) -> dict[str, int]:
        return {Status.of(int(code)).word: int((self.codes == code).sum()) for code in np.unique(self.codes) if code}

    def _worst_values(self) -> Array | None:
        return _at(self.spread.worst_values, self.spread.max_error)

    @property
    def contributions(self) -> tuple[Contribution, ...]:
        """Each uncertain parameter with the displacement that it causes, largest first."""
        offsets = np.full((len(self.ranges), 3), np.nan if len(self) else 0.0)
        largest = np.full(len(offsets), -1.0)
        for rows in blocks(len(self)):
            effects = self.spread.effects[rows]
            sizes = np.nan_to_num(np.linalg.norm(effects, axis=1), nan=-1.0)
            at, every = sizes.argmax(axis=0), np.arange(len(offsets))
            larger = sizes[at, every] > largest
            offsets[larger], largest[larger] = effects[at, :, every][larger], sizes[at, every][larger]
            let_go(self.spread.effects)
        worst = self._worst_values()
        values = np.full(len(offsets), np.nan) if worst is None else worst
        order = np.argsort(-largest, kind="stable")
        return tuple(Contribution(self.ranges[k], offsets[k], float(values[k])) for k in order)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes that caution about the figures of the result."""
        curved, lost = _most(self.spread.nonlinearity), int(self.spread.unsolved.sum())
        off = f"first order deviates by up to {100.0 * curved:.2g} % of the spread"
        notes = []
        if curved > TOO_CURVED and self.method == "first-order":
            notes.append(f"{off}: all figures of the spread are estimates; --method vertices solves the corners")
        if curved > TOO_CURVED and self.method == "vertices" and len(self.ranges) > ALL_VERTICES:
            notes.append(f"{off}, and chose the corners that were solved")
        notes += [
            f"{each.parameter.label}: the robot file's {each.nominal:g} is outside its range"
            for each in self.ranges
            if not each.low <= each.nominal <= each.high
        ]
        if any(line.mount_gives for line in self.robot.lines):
            notes.append(
                "each mount deflects under its own line only: coupled mounts, as two on one post, are not included"
            )
        if lost:
            solves = "solve has" if lost == 1 else "solves have"
            notes.append(
                f"{lost} {solves} no sound equilibrium and are left out: errors may be larger than the figures"
            )
        return tuple(notes)


def _at(rows: Array, values: Array) -> Array | None:
    """The row with the largest of *values* (N,); None where all are NaN."""
    return None if np.isnan(values).all() else np.asarray(rows[int(np.nanargmax(values))])


def _ends(choose: np.ufunc, rows: Array) -> Array:
    """The smallest or largest (by *choose*) of each column, without NaN."""
    return np.asarray(choose.reduce(rows, axis=0, initial=np.nan))


class AccuracyOptions(TypedDict, total=False):
    """Options (keyword arguments) of `accuracy`."""

    compensation: str
    method: Method | str
    tension_limits: tuple[float, float] | None
    home: ArrayLike | None
    retraction: ArrayLike | None
    seed: int
    progress: Progress | None


class HeldPoses(NamedTuple):
    """N commanded poses and their equilibria on the full model."""

    wanted: Array  # (N, n) as given; NaN for degrees of freedom that gravity decides
    retraction: Array | None  # (N,) m
    equilibria: Equilibrium


@dataclass(frozen=True, eq=False)
class _Errors:
    """The arrays of an `Accuracy`."""

    wanted: Array
    commanded: Array
    codes: NDArray[np.int64]
    nominal: Array
    spread: Spread


@dataclass(frozen=True, eq=False)
class AccuracyQuestion:
    """The settings of an accuracy analysis, independent of poses; `of` checks them."""

    model: Model  # the full one
    ranges: tuple[Range, ...]
    compensation: Compensation
    method: Method
    home: Equilibrium | None  # of the full model, where the machine was zeroed; None: commanded lengths are not offset
    progress: Progress

    @classmethod
    def of(
        cls,
        robot: Robot | Model,
        ranges: Sequence[Range] | None = None,
        compensation: str = "none",
        method: Method | str = "vertices",
        tension_limits: tuple[float, float] | None = None,
        home: ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> Self:
        """Return the settings for the arguments of `accuracy`. Raises `InputError` for invalid ones."""
        model = Model.full(robot, tension_limits=tension_limits)
        known = tuple(model.robot.ranges() if ranges is None else ranges)
        if not known:
            raise InputError("ranges: none are given; give the range of at least one uncertain parameter")
        if isinstance(method, str):
            if method not in METHODS:
                raise UnknownName("method", method, METHODS)
            method = METHODS[method]
        law = Compensation.of(compensation)
        zeroed = None if home is None else solve_inverse(model, as_poses(model, home, "home")[0][0])
        if zeroed is not None and not zeroed.ok:
            raise InputError(f"home: {zeroed.sentence()}")
        return cls(model, known, law, method, zeroed, progress or silent)

    def hold(self, poses: ArrayLike, retraction: ArrayLike | None = None) -> HeldPoses:
        """Solve the inverse problem at *poses*, (n,) or (N, n), on the full model; *retraction*, m, one or (N,)."""
        wanted, _ = as_poses(self.model, poses, "pose", free=True)
        retracted = given_numbers(retraction, len(wanted), "retraction", "m")
        return HeldPoses(wanted, retracted, solve_inverse(self.model, wanted, path=True, retraction=retracted))

    def answer(self, there: HeldPoses) -> Accuracy:
        """Return the nozzle errors at the poses. Raises `AnswerError` if no pose has an equilibrium."""
        return self._answered(self._errors(there, self.progress), there.wanted, there.retraction)

    def answer_in(self, room: Room, poses: Array, retraction: Array | None) -> Accuracy:
        """Return the errors at neighbouring poses, solved in blocks, with arrays in a *room*; as `answer` of `hold`."""
        rows = len(poses)
        found: _Errors | None = None
        for at in blocks(rows, BLOCK):
            own = None if retraction is None else retraction[at]
            block = self._errors(self.hold(poses[at], own), _shifted(self.progress, at.start, rows))
            found = room_for(block, rows, room) if found is None else found
            write_rows(block, found, at.start)
            let_go((found, poses))
        assert found is not None  # a job has samples
        return self._answered(found, poses, retraction)

    def problem(self, there: HeldPoses) -> SpreadProblem:
        """Return the `SpreadProblem` of the poses with an answer."""
        return self._problem(there)[0]

    def _problem(self, there: HeldPoses) -> tuple[SpreadProblem, Array, Reached, NDArray[np.int64]]:
        """The same, with lengths (N, m), what these reach, and codes (N,)."""
        held, found_codes = there.equilibria, there.equilibria.judged_code
        some = found_codes == 0
        retracted = None if there.retraction is None else there.retraction[some]
        lengths = np.full_like(held.lengths, np.nan)
        lengths[some] = self.compensation.lengths(held[some], there.wanted[some], retraction=retracted, home=self.home)
        reached = Reached.of(self.model, lengths, held.pose, retraction=there.retraction)
        codes = np.where(some, reached.codes, found_codes)
        ok = codes == 0
        found = SpreadProblem(reached.equilibria, lengths[ok], held.pose[ok], self.ranges)
        return found, lengths, reached, codes

    def _errors(self, there: HeldPoses, progress: Progress) -> _Errors:
        problem, lengths, reached, codes = self._problem(there)
        spread = _scattered(self.method(replace(problem, progress=progress)), codes == 0)
        return _Errors(there.equilibria.pose, lengths, codes, reached.poses, spread)

    def _answered(self, found: _Errors, poses: Array, retraction: Array | None) -> Accuracy:
        if len(found.codes) and found.codes.all():
            raise AnswerError(self._refusal(found.codes, poses, retraction))
        return Accuracy(
            robot=self.model.robot,
            ranges=self.ranges,
            compensation=self.compensation.name,
            method=self.method.name,
            **found.__dict__,
        )

    def _refusal(self, codes: NDArray[np.int64], poses: Array, retraction: Array | None) -> str:
        """The most frequent reason why the poses have no answer, with the sentence of the first such pose."""
        commonest = int(np.bincount(codes).argmax())
        first = int(np.argmax(codes == commonest))
        held = self.hold(poses[first], None if retraction is None else retraction[first]).equilibria[0]
        why = held.sentence() if not held.holds else f"with these lengths, {Status.of(commonest).value}"
        return why if len(codes) == 1 else f"none of the {len(codes)} poses has an answer: {why}"


def _shifted(progress: Progress, first: int, rows: int) -> Progress:
    """Progress of poses from the *first* on, as part of all *rows*."""
    return lambda stage, done, _total: progress(stage, first + done, rows)


def _scattered(spread: Spread, ok: Mask) -> Spread:
    """*spread* of the poses that are *ok* (N,), as rows among all; the others are NaN."""
    values = {}
    for name, known in spread.__dict__.items():
        wide = np.full((len(ok), *known.shape[1:]), 0 if known.dtype == np.int64 else np.nan, dtype=known.dtype)
        wide[ok] = known
        values[name] = wide
    return Spread(**values)
