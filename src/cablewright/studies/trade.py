"""`trade`: workspace and lowest natural frequency for all combinations of values of design variables."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any, ClassVar, get_args

import numpy as np
from pydantic import TypeAdapter, ValidationError

from cablewright.analyses.workspace.boundary_frequencies import FREQUENCIES, GRID, boundary_modes, straight
from cablewright.analyses.workspace.criterion import RetractionLaw
from cablewright.analyses.workspace.workspace import count_nodes, workspace
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.choices import CountName, InertiaName
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.progress import Progress
from cablewright.foundation.results import Figure, Pictured, plain
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.robot.design_variables import Change, changed, nearest_exits, require_different, with_box_inertia
from cablewright.running.executors.executor import Executor, Serial
from cablewright.running.executors.stored_results import kept_in
from cablewright.running.executors.study import evaluate, require_all
from cablewright.running.executors.task import Task

COUNTS: tuple[str, ...] = get_args(CountName)
INERTIAS: tuple[str, ...] = get_args(InertiaName)
MAX_COMBINATIONS = 10_000  # combinations


@dataclass(frozen=True)
class TradeSettings:
    """Settings of the workspace and the modes of each combination. Raises `InputError` for a contradiction.

    ``count``: ``volume`` computes volumes by `workspace`, ``nodes`` by `count_nodes`. ``boundary_grid``, ``geometric``,
    ``holding``: see `boundary_modes`. ``clearance``: m, smallest allowed distance between exit points, for their
    sheaves. ``inertia``: ``given`` by the file, or that of a ``box`` about the platform points. All others: see
    `workspace`.
    """

    criterion: str = "exact"
    count: str = "volume"
    grid: int | None = None
    tolerance: float | None = None
    box: tuple[float, ...] | None = None
    point: str = "nozzle"
    orientations: tuple[tuple[float, ...], ...] | None = None
    retraction: float | RetractionLaw | None = None
    seed: int = 0
    boundary_grid: int = GRID
    geometric: bool = True
    holding: str | None = None
    clearance: float = 0.1
    inertia: str = "given"

    def __post_init__(self) -> None:
        if self.count not in COUNTS:
            raise UnknownName("count", self.count, COUNTS)
        if self.inertia not in INERTIAS:
            raise UnknownName("inertia", self.inertia, INERTIAS)
        if self.tolerance is not None and self.count == "nodes":
            raise InputError("tolerance: cannot be combined with count nodes, whose error depends on its grid")
        if not (math.isfinite(self.clearance) and self.clearance >= 0.0):
            raise InputError(f"sheave clearance {self.clearance:g}: must be at least 0 m")
        if self.inertia == "box" and isinstance(self.retraction, RetractionLaw):
            raise InputError("inertia box: cannot be combined with a retraction law, along which the box would change")

    @property
    def of_workspace(self) -> dict[str, Any]:
        """Options that volumes and boundaries share."""
        names = ("box", "point", "orientations", "retraction")
        return {name: getattr(self, name) for name in names}


SETTINGS = (
    Figure("criterion", "", "Criterion of the workspace."),
    Figure("count", "", "How volumes are found: volume, or nodes of a grid."),
    Figure("grid", "1", "Nodes along each side of the box for volumes; null for the default."),
    Figure("tolerance", "1", "Error of each volume as a share of it; null for the default."),
    Figure("box", "m", "Box that is searched; null for the robot's frame."),
    Figure("point", "", "Point of the platform at a place: nozzle or origin."),
    Figure("orientations", "rad", "Rotation vectors under each of which the criterion must hold; null for none."),
    Figure("retraction", "m", "Retraction length, or its law; null where the robot's own holds."),
    Figure("seed", "1", "Seed of the random places."),
    Figure("boundary_grid", "1", "Nodes along each side, for boundaries."),
    Figure("counts_geometric", "", "Whether the stiffness that tension adds is counted.", "geometric"),
    Figure(
        "tensions", "", "Which tensions hold the boundary's poses: least or middle; null for the default.", "holding"
    ),
    Figure("sheave_clearance", "m", "Distance of exit points under which sheaves collide.", "clearance"),
    Figure("inertia", "", "Inertia of the platform: given, or box."),
)

COMBINATION = (
    Figure("parameters", "SI", "Values of the parameters.", digits=5),
    Figure("volume", "m^3", "Volume of the workspace."),
    Figure("volume_error", "m^3", "Estimated error of the volume.", detail=True),
    Figure("fraction", "1", "Share of the box that is inside.", name="of the box", shown="%"),
    Figure("converged", "", "Whether the error of the volume is within the tolerance.", detail=True),
    Figure("lowest_frequency", "", "Lowest frequencies along the boundary.", name="frequency", parts=(
        Figure("n", "1", "Number of poses along the boundary.", detail=True),
        Figure("unheld", "1", "Poses that cannot be held; they are not counted.", detail=True),
        *(replace(each, detail=each.key not in ("min", "dominant")) for each in FREQUENCIES),
    )),
    Figure("sheaves", "", "The two nearest exit points.", name="of exit points", parts=(
        Figure("distance", "m", "Distance of the two; null for a single line.", shown="m"),
        Figure("lines", "", "Names of their lines.", detail=True),
        Figure("margin", "m", "Distance beyond the clearance; null for a single line.", detail=True),
        Figure("collide", "", "Whether the margin is negative."),
    )),
    Figure("not_dominated", "", "Whether no other without collision has more volume and a higher frequency."),
)  # fmt: skip


@dataclass(frozen=True)
class Combination:
    """Result for one combination of values.

    Frequencies, Hz: lowest modes along the boundary; None without any.
    """

    values: tuple[float, ...]  # of the changes, SI
    volume: float  # m^3
    volume_error: float  # m^3
    fraction: float  # of the box
    converged: bool
    n: int  # poses along the boundary
    unheld: int  # of these, without an equilibrium
    least: float | None
    median: float | None
    greatest: float | None
    dominant: str | None  # freedom that most often dominates the lowest mode
    shares: dict[str, float]  # share of the poses by dominant freedom
    worst_pose: tuple[float, ...] | None  # pose of `least`, m and rad
    exit_distance: float | None  # m, the smallest of any two exit points; None for a single line
    exits: tuple[str, str] | None  # the lines whose exit points these are


_COMBINATION = TypeAdapter(Combination)


@dataclass(frozen=True, eq=False, repr=False)
class Trade(Pictured):
    """Results of all combinations; the values of the last variable vary fastest."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok; empty: no place is inside; not-converged: a volume's error is over the tolerance."),
        Figure("robot", "", "Name of the robot.", "model.robot.name"),
        Figure("cable", "", "Cable law of the modes.", "model.fidelity.cable"),
        Figure("sheave", "", "Sheave law; null where each is as built.", "model.fidelity.sheave", detail=True),
        *(replace(each, value=f"settings.{each.value or each.key}", detail=True) for each in SETTINGS),
        Figure(
            "varied",
            "",
            "What varies.",
            "variations",
            detail=True,
            parts=(
                Figure("name", "", "Name of the parameter."),
                Figure("unit", "", "Its SI unit."),
                Figure("values", "SI", "Its values."),
            ),
        ),
        Figure("combinations", "", "Each combination of values.", "records", parts=COMBINATION),
        Figure(
            "not_dominated",
            "1",
            "Indices of the combinations that are not dominated.",
            lambda of: np.flatnonzero(of.best),
            detail=True,
        ),
    )
    HEADLINES: ClassVar = ("status", "robot", "not_dominated")

    model: Model
    varied: Mapping[Change, tuple[float, ...]]
    settings: TradeSettings
    combinations: tuple[Combination, ...]

    def __len__(self) -> int:
        """How many combinations there are."""
        return len(self.combinations)

    @property
    def status(self) -> str:
        """Status of the comparison: ok, empty or not-converged."""
        if not any(each.volume for each in self.combinations):
            return "empty"
        return "ok" if all(each.converged for each in self.combinations if each.volume) else "not-converged"

    @property
    def refusal(self) -> str:
        """Reason for a no, in a sentence; empty for a yes."""
        return {
            "ok": "",
            "empty": "no combination has a workspace within the box",
            "not-converged": "some volumes have an error above the tolerance, even on the finest lattice",
        }[self.status]

    @property
    def variations(self) -> list[dict[str, Any]]:
        """Design variables and their tried values, as in JSON."""
        return [{"name": each.name, "unit": each.unit, "values": values} for each, values in self.varied.items()]

    @property
    def records(self) -> list[dict[str, Any]]:
        """The tried combinations with their figures, as JSON objects."""
        return [self._record(k, each) for k, each in enumerate(self.combinations)]

    def _record(self, k: int, each: Combination) -> dict[str, Any]:
        lowest = {"n": each.n, "unheld": each.unheld, "min": each.least, "median": each.median, "max": each.greatest}
        return {
            "parameters": {change.name: value for change, value in zip(self.varied, each.values, strict=True)},
            **{key: getattr(each, key) for key in ("volume", "volume_error", "fraction", "converged")},
            "lowest_frequency": lowest | {key: getattr(each, key) for key in ("dominant", "shares", "worst_pose")},
            "sheaves": {
                "distance": each.exit_distance,
                "lines": each.exits,
                "margin": self.margins[k],
                "collide": not self.clear[k],
            },
            "not_dominated": self.best[k],
        }

    @cached_property
    def margins(self) -> Array:
        """Smallest distance between exit points less the clearance (C,), m; infinite for a single line."""
        far = [math.inf if each.exit_distance is None else each.exit_distance for each in self.combinations]
        return np.round(np.array(far) - self.settings.clearance, 12) + 0.0  # a rounding error is no collision

    @property
    def clear(self) -> Mask:
        """Mask (C,) of combinations without colliding sheaves."""
        return self.margins >= 0.0

    @cached_property
    def best(self) -> Mask:
        """Mask (C,) of Pareto-optimal combinations in volume and lowest frequency, without colliding sheaves."""
        least = [math.nan if each.least is None else each.least for each in self.combinations]
        return best_of([each.volume for each in self.combinations], least, self.clear)


def best_of(volumes: Sequence[float], frequencies: Sequence[float], allowed: Mask) -> Mask:
    """Return which of the *allowed* combinations are Pareto-optimal in two quantities.

    None of these has more of one and at least as much of the other. Those without a volume, or with a frequency that is
    NaN, are not.
    """
    v, f = np.asarray(volumes, dtype=np.float64), np.asarray(frequencies, dtype=np.float64)
    best = np.zeros(len(v), dtype=np.bool_)
    candidates = np.flatnonzero(allowed & (v > 0.0) & np.isfinite(f))
    highest = -np.inf  # frequency of all with a larger volume
    for volume in np.unique(v[candidates])[::-1]:
        level = candidates[v[candidates] == volume]
        top = f[level].max()
        if top > highest:
            best[level[f[level] == top]] = True
            highest = top
    return best


def trade(
    robot: Robot | Model,
    varied: Mapping[Change, Sequence[float]] | Mapping[str, Sequence[float]],
    settings: TradeSettings | None = None,
    *,
    file: Path | None = None,
    executor: Executor | None = None,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
    progress: Progress | None = None,
) -> Trade:
    """Compute volume and lowest frequencies of *robot* for all combinations of values (SI) of the *varied* variables.

    Frequencies follow the laws *cable* (default: ``catenary`` for the criterion ``static``, else ``elastic``) and
    *sheave*; volumes are those of straight lines unless the criterion is ``static``. *file* keeps the finished
    combinations, also after an interruption; a sweep with the same combinations resumes from it. *executor*: who
    computes; by default this program. Raises `InputError`; for a value that the robot cannot have, before anything is
    computed; `AnswerError` for a combination that fails, while the others are kept.
    """
    settings = settings or TradeSettings()
    default = CableLaw.CATENARY if settings.criterion == "static" else CableLaw.ELASTIC
    model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits, default=default)
    named = {Change(each) if isinstance(each, str) else each: values for each, values in varied.items()}
    ranges = {change: tuple(float(value) for value in values) for change, values in named.items()}
    combinations = _combinations(model.robot, ranges, settings)
    with kept_in(file) as kept:
        task = Task(combination_of, (model, tuple(ranges), settings), "combination")
        outcomes = evaluate(task, combinations, executor or Serial(), kept, progress)
    require_all(outcomes, [_words(ranges, values) for values in combinations])
    try:
        found = tuple(_COMBINATION.validate_json(each.text) for each in outcomes)
    except ValidationError:
        raise InputError(f"{file}: holds no results of a trade study; remove it or choose another --out") from None
    return Trade(model, ranges, settings, found)


def _words(ranges: Mapping[Change, Any], values: Sequence[float]) -> str:
    return ", ".join(f"{change.name} = {value:g}" for change, value in zip(ranges, values, strict=True))


def _combinations(
    robot: Robot, ranges: Mapping[Change, tuple[float, ...]], settings: TradeSettings
) -> list[tuple[float, ...]]:
    """Return the values of each combination. Raises `InputError`, also for one that the robot cannot have."""
    count = math.prod(len(values) for values in ranges.values())
    if not ranges or not count:
        raise InputError("vary: give at least one parameter with values")
    if count > MAX_COMBINATIONS:
        raise InputError(f"{count} combinations: at most {MAX_COMBINATIONS} are allowed")
    require_different(ranges)
    if settings.retraction is not None and any(part == "retraction" for change in ranges for part, _ in change.parts):
        raise InputError("retraction: cannot vary while a length or a law of it is given")
    combinations = list(dict.fromkeys(product(*ranges.values())))
    for values in combinations:
        _robot(robot, tuple(ranges), values, settings)
    return combinations


def _robot(robot: Robot, changes: Sequence[Change], values: Sequence[float], settings: TradeSettings) -> Robot:
    """Return the robot of a combination. Raises `InputError`."""
    made = changed(robot, dict(zip(changes, values, strict=True)))
    if settings.inertia == "box":
        if settings.retraction is not None:
            assert not isinstance(settings.retraction, RetractionLaw)  # `TradeSettings` rejects it
            made = made.retracted(settings.retraction)
        made = with_box_inertia(made)
    return made


def combination_of(shared: tuple[Model, tuple[Change, ...], TradeSettings], values: tuple[float, ...]) -> Any:
    """Return a `Combination` of *values* as a JSON table: model, changes and settings are *shared*."""
    model, changes, settings = shared
    robot = _robot(model.robot, changes, values, settings)
    return asdict(found_for(replace(model, robot=robot), values, settings))


def found_for(model: Model, values: tuple[float, ...], settings: TradeSettings) -> Combination:
    """Return workspace volume, boundary frequencies and exit point distance for values of the variables."""
    lines = model if settings.criterion == "static" else straight(model)
    if settings.count == "nodes":
        nodes = count_nodes(lines, settings.criterion, grid=settings.grid, **settings.of_workspace)
        volume, error, fraction, converged = nodes.volume, nodes.volume_error, nodes.fraction, True
    else:
        more: dict[str, Any] = {"tolerance": settings.tolerance, "grid": settings.grid, "seed": settings.seed}
        found = workspace(lines, settings.criterion, **more, **settings.of_workspace)
        volume, error, fraction, converged = found.volume, found.volume_error, found.fraction, found.converged
    of_modes: dict[str, Any] = {
        "grid": settings.boundary_grid,
        "geometric": settings.geometric,
        "holding": settings.holding,
    }
    held = boundary_modes(model, settings.criterion, **of_modes, **settings.of_workspace)
    least, median, greatest = plain(held.spread)
    exit_distance, exits = nearest_exits(model.robot) or (None, None)
    return Combination(
        values=values,
        volume=volume,
        volume_error=error,
        fraction=fraction,
        converged=converged,
        n=len(held.lowest),
        unheld=int((~held.known).sum()),
        least=least,
        median=median,
        greatest=greatest,
        dominant=held.dominant,
        shares=held.shares,
        worst_pose=None if held.worst is None else tuple(held.modes.equilibrium.pose[held.worst].tolist()),
        exit_distance=exit_distance,
        exits=exits,
    )
