"""`design`: search for values of design variables with which a robot serves its part best."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError, UnknownName
from cablewright.foundation.progress import Progress, silent
from cablewright.models.job_poses import on_plane, sampled
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot, load
from cablewright.running.executors.executor import Executor, Serial
from cablewright.running.executors.stored_results import KeptResults, kept_in
from cablewright.running.executors.study import evaluate
from cablewright.running.executors.task import Outcome, Task
from cablewright.studies.design.measures import MEASURES, Prices, measured
from cablewright.studies.design.optimisers import OPTIMISERS, Budget
from cablewright.studies.design.problem import DesignConstraint, DesignProblem, Variable, default_workspace, places_of
from cablewright.studies.design.result import Designed, Tried
from cablewright.studies.trade import TradeSettings

EVALUATIONS: Final = 400
MAX_EVALUATIONS: Final = 1_000_000
MAX_VARIABLES: Final = 60


def design(
    robot: Robot | str | Path,
    job: Job | str | Path | None,
    vary: Sequence[Variable | str],
    objectives: Sequence[str],
    constraints: Sequence[DesignConstraint | str] = (),
    *,
    symmetry: Sequence[str] = (),
    method: str | None = None,
    evaluations: int = EVALUATIONS,
    population: int | None = None,
    workspace: TradeSettings | None = None,
    prices: Mapping[str, float] | None = None,
    seed: int = 0,
    file: Path | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Designed:
    """Search for the robots that are best in *objectives* while *constraints* and the limits of the hardware hold.

    *job*: the part; None for figures that need none. *vary*: variables, or texts ``NAME=LOW:HIGH`` of which *symmetry*
    names the mirrors, x and y; *constraints* may be texts ``FIGURE>=VALUE`` or ``FIGURE<=VALUE``; SI. *method*: of
    `OPTIMISERS`; by default ``de`` for one objective and ``nsga2`` for several. *evaluations*: candidates in all,
    *population* at a time. *workspace*: how workspaces are found. *prices*: prices by the names of `Prices`, for
    ``cost``. *file* keeps what was found; the same search resumes from it. Raises `InputError`, and `AnswerError` where
    an objective has no value for any of the first candidates. A search without a candidate for which everything holds
    raises nothing: see ``status``.
    """
    mirrors = tuple(symmetry)
    variables = tuple(each if isinstance(each, Variable) else Variable.read(each, mirrors) for each in vary)
    bounds = tuple(each if isinstance(each, DesignConstraint) else DesignConstraint.read(each) for each in constraints)
    costs = None if prices is None else Prices.of(prices)
    what = _what(robot, job, variables, tuple(objectives), bounds, workspace, seed, costs)
    name = method or ("de" if len(what.objectives) == 1 else "nsga2")
    if name not in OPTIMISERS:
        raise UnknownName("method", name, OPTIMISERS)
    budget = _budget(len(what.variables), evaluations, population, seed)
    with kept_in(file) as kept:
        search = _Search(what, budget, executor or Serial(), kept, progress or silent)
        original = search.original()
        OPTIMISERS[name](search.batch, len(what.variables), len(what.objectives), budget)
    return Designed(what, name, budget.population, original, tuple(search.tried))


def _what(
    robot: Robot | str | Path,
    job: Job | str | Path | None,
    variables: tuple[Variable, ...],
    objectives: tuple[str, ...],
    constraints: tuple[DesignConstraint, ...],
    workspace: TradeSettings | None,
    seed: int,
    prices: Prices | None,
) -> DesignProblem:
    """Return what is to be designed, with the places of the part. Raises `InputError`."""
    described = robot if isinstance(robot, Robot) else load(str(robot))
    found = workspace or default_workspace()
    if job is None:
        return DesignProblem(described, variables, objectives, constraints, None, (), found, seed, prices)
    loaded = on_plane(described, job if isinstance(job, Job) else load_job(job))
    samples, _ = sampled(described, loaded, loaded.toolpath())
    places = places_of(samples)
    without = loaded.model_copy(update={"gcode": None})  # no worker reads it
    return DesignProblem(described, variables, objectives, constraints, without, places, found, seed, prices)


def _budget(variables: int, evaluations: int, population: int | None, seed: int) -> Budget:
    """Raises `InputError`."""
    if variables > MAX_VARIABLES:
        raise InputError(f"{variables} variables: at most {MAX_VARIABLES} are allowed")
    if not 5 <= evaluations <= MAX_EVALUATIONS:
        raise InputError(f"evaluations = {evaluations}: must be from 5 to {MAX_EVALUATIONS}")
    size = min(max(12, 6 * variables), 60, evaluations) if population is None else population
    if not 5 <= size <= evaluations:
        raise InputError(f"population = {size}: must be from 5 to the number of evaluations, {evaluations}")
    if seed < 0:
        raise InputError(f"seed = {seed}: must be a whole number from 0 on")
    return Budget(evaluations, size, seed)


def judged(shared: DesignProblem, values: tuple[float, ...]) -> dict[str, Any]:
    """Return figures and shortfalls of the candidate with these *values*; none: of the robot as it is."""
    candidate = shared.candidate(values)
    return {"shortfalls": candidate.shortfalls, "figures": measured(candidate, shared.keys)}


class _Search:
    """Answers the batches of an optimiser, and keeps every candidate."""

    def __init__(
        self, what: DesignProblem, budget: Budget, executor: Executor, kept: KeptResults, report: Progress
    ) -> None:
        self._what, self._budget, self._executor, self._kept, self._report = what, budget, executor, kept, report
        self._task = Task(judged, what, "candidate")
        self._low = np.array([each.low for each in what.variables])
        self._span = np.array([each.high - each.low for each in what.variables])
        self.tried: list[Tried] = []

    def original(self) -> Tried:
        """Return the robot as it is."""
        (outcome,) = evaluate(self._task, [()], self._executor, self._kept)
        return self._told((), outcome)

    def batch(self, rows: Array) -> tuple[Array, Array]:
        """Return objectives, to be minimised, and violations of candidates with values from 0 to 1."""
        values = self._low + self._span * np.clip(rows, 0.0, 1.0)
        items = [tuple(row) for row in values.tolist()]
        before, total = len(self.tried), max(self._budget.evaluations, len(self.tried) + len(items))
        outcomes = evaluate(
            self._task,
            items,
            self._executor,
            self._kept,
            lambda stage, done, _: self._report(stage, before + done, total),
        )
        new = [self._told(*each) for each in zip(items, outcomes, strict=True)]
        self.tried += new
        if not before:
            self._require_values(new)
        return np.array([self._what.worth(each.figures) for each in new]), np.array([each.violation for each in new])

    def _told(self, values: tuple[float, ...], outcome: Outcome) -> Tried:
        if outcome.fault:
            return Tried(values, {}, {}, math.inf, outcome.fault)
        told = outcome.value
        figures, shortfalls = told["figures"], told["shortfalls"]
        violation = sum(shortfalls.values()) + sum(
            each.missed_by(figures[each.key]) / MEASURES[each.key].scale for each in self._what.constraints
        )
        return Tried(values, figures, shortfalls, violation, "")

    def _require_values(self, tried: list[Tried]) -> None:
        """Raise `AnswerError` for an objective that no candidate has."""
        for key in self._what.objectives:
            if not any(math.isfinite(each.figures.get(key, math.nan)) for each in tried):
                why = next((f": {each.fault}" for each in tried if each.fault), "")
                raise AnswerError(f"objective {key}: has no value for any of the first {len(tried)} candidates{why}")
