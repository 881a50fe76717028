"""What a machine's measures buy: its workspace against its lowest frequency, while named numbers of it vary."""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from importlib.metadata import version
from itertools import product
from pathlib import Path
from typing import Any, ClassVar, get_args

import numpy as np
from pydantic import TypeAdapter, ValidationError

from cablewright.analyses.workspace.boundary_modes import FREQUENCIES, GRID, boundary_modes, straight
from cablewright.analyses.workspace.criterion import RetractionLaw
from cablewright.analyses.workspace.workspace import count_nodes, workspace
from cablewright.arrays import Array, Mask
from cablewright.choices import CountName, InertiaName
from cablewright.errors import InputError, UnknownName
from cablewright.file_output import write_whole
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.statics import Model
from cablewright.progress import Progress, silent
from cablewright.results import Figure, Pictured, plain
from cablewright.robot import Robot
from cablewright.robot.design_variables import Change, changed, nearest_exits, with_box_inertia

COUNTS: tuple[str, ...] = get_args(CountName)
INERTIAS: tuple[str, ...] = get_args(InertiaName)
MAX_COMBINATIONS = 10_000  # combinations
MAX_BYTES = 1 << 26
WRITTEN_EVERY = 10.0  # s


@dataclass(frozen=True)
class TradeSettings:
    """What is asked of each combination. Raises `InputError` for what no workspace is asked for.

    ``count``: how volumes are found, by `workspace` or by `count_nodes`. ``boundary_grid``, ``geometric``, ``holding``:
    how frequencies are, see `boundary_modes`. ``clearance``: m, how far exits have to be apart, for their sheaves.
    ``inertia``: ``given`` keeps that of the file, ``box`` takes that of a box about the platform's points. All others
    as in `workspace`.
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
            raise InputError("tolerance: does not go with count nodes, whose error is that of its grid")
        if not (math.isfinite(self.clearance) and self.clearance >= 0.0):
            raise InputError(f"sheave clearance {self.clearance:g}: a length of 0 or more is wanted, m")
        if self.inertia == "box" and isinstance(self.retraction, RetractionLaw):
            raise InputError("inertia box: does not go with a retraction law, along which the box would change")

    @property
    def of_workspace(self) -> dict[str, Any]:
        """What volumes and boundaries are both asked with."""
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
    Figure("min_frequency", "Hz", "Lowest frequency along the boundary."),
    Figure("lowest_frequency", "Hz", "Lowest frequencies along the boundary.", detail=True, parts=(
        Figure("n", "1", "Number of poses along the boundary."),
        Figure("unheld", "1", "Poses that cannot be held; they are not counted."),
        *FREQUENCIES,
    )),
    Figure("sheaves", "", "The two nearest exit points.", detail=True, parts=(
        Figure("distance", "m", "Their distance; null for a single line."),
        Figure("lines", "", "Their lines."),
        Figure("margin", "m", "Distance beyond the clearance; null for a single line."),
        Figure("collide", "", "Whether the margin is negative."),
    )),
    Figure("sheaves_collide", "", "Whether the nearest exit points are nearer than the clearance."),
    Figure("not_dominated", "", "Whether no other without collision has more volume and a higher frequency."),
)  # fmt: skip


@dataclass(frozen=True)
class Combination:
    """What one set of values gives. Frequencies, Hz, are the lowest at places of the boundary; None without any."""

    values: tuple[float, ...]  # of the changes, SI
    volume: float  # m^3
    volume_error: float  # m^3
    fraction: float  # of the box
    converged: bool
    n: int  # poses along the boundary
    unheld: int  # of them, at which nothing balances
    least: float | None
    median: float | None
    greatest: float | None
    dominant: str | None  # the freedom that the lowest mode has most often
    shares: dict[str, float]  # how often each has it
    worst_pose: tuple[float, ...] | None  # where `least` is, m and rad
    exit_distance: float | None  # m, the smallest of any two exits; None for a single line
    exits: tuple[str, str] | None  # the lines whose exits these are


@dataclass(frozen=True, eq=False, repr=False)
class Trade(Pictured):
    """All combinations, the last change's values varying fastest."""

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
        """ok, empty or not-converged."""
        if not any(each.volume for each in self.combinations):
            return "empty"
        return "ok" if all(each.converged for each in self.combinations if each.volume) else "not-converged"

    @property
    def refusal(self) -> str:
        """Why the answer is no, in a sentence; empty where it is yes."""
        sentences = {"ok": "", "empty": "no combination has a place in the box that is inside"}
        wide = "some volumes have a larger error than what was asked for, even on the finest lattice"
        return sentences.get(self.status, wide)

    @property
    def variations(self) -> list[dict[str, Any]]:
        """What varies, as JSON has it."""
        return [{"name": each.name, "unit": each.unit, "values": values} for each, values in self.varied.items()]

    @property
    def records(self) -> list[dict[str, Any]]:
        """The combinations as JSON has them."""
        return [self._record(k, each) for k, each in enumerate(self.combinations)]

    def _record(self, k: int, each: Combination) -> dict[str, Any]:
        lowest = {"n": each.n, "unheld": each.unheld, "min": each.least, "median": each.median, "max": each.greatest}
        return {
            "parameters": {change.name: value for change, value in zip(self.varied, each.values, strict=True)},
            **{key: getattr(each, key) for key in ("volume", "volume_error", "fraction", "converged")},
            "min_frequency": each.least,
            "lowest_frequency": lowest | {key: getattr(each, key) for key in ("dominant", "shares", "worst_pose")},
            "sheaves": {
                "distance": each.exit_distance,
                "lines": each.exits,
                "margin": self.margins[k],
                "collide": not self.clear[k],
            },
            "sheaves_collide": not self.clear[k],
            "not_dominated": self.best[k],
        }

    @cached_property
    def margins(self) -> Array:
        """How far apart the nearest exits are beyond the clearance (C,), m; infinite for a single line."""
        far = [math.inf if each.exit_distance is None else each.exit_distance for each in self.combinations]
        return np.round(np.array(far) - self.settings.clearance, 12) + 0.0  # no rounding that looks like a collision

    @property
    def clear(self) -> Mask:
        """In which combinations (C,) no sheaves collide."""
        return self.margins >= 0.0

    @cached_property
    def best(self) -> Mask:
        """Which combinations (C,) are not dominated: no other without collision has more of one and no less of both."""
        least = [math.nan if each.least is None else each.least for each in self.combinations]
        return best_of([each.volume for each in self.combinations], least, self.clear)


def best_of(volumes: Sequence[float], frequencies: Sequence[float], allowed: Mask) -> Mask:
    """Which of the *allowed* are not dominated: none of those has more of one and at least as much of the other.

    Without a volume, or with a frequency that is NaN, nothing is among the best.
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
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
    progress: Progress | None = None,
) -> Trade:
    """Volume and lowest frequencies of *robot* for all combinations of the values (SI) of what is *varied*, by name.

    Frequencies are those of the laws asked for (*cable*: ``elastic``, or ``catenary`` for ``static``); volumes are
    asked of straight lines unless the criterion is ``static``. *file* has the combinations that are done, also when
    interrupted; the same sweep goes on with them. Raises `InputError`, for a value that the robot cannot have before
    anything is computed.
    """
    asked = settings or TradeSettings()
    default = CableLaw.CATENARY if asked.criterion == "static" else CableLaw.ELASTIC
    model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits, default=default)
    named = {Change(each) if isinstance(each, str) else each: values for each, values in varied.items()}
    ranges = {change: tuple(float(value) for value in values) for change, values in named.items()}
    robots = _robots(model.robot, ranges, asked)
    question = _question(model, ranges, asked)
    done = _Done(file, question)
    left = [values for values in robots if values not in done.known]
    report = progress or silent
    try:
        for k, values in enumerate(left):
            report("combinations", k, len(left))
            done.add(_combination(replace(model, robot=robots[values]), values, asked))
        report("combinations", len(left), len(left))
    finally:
        if left and done.known:
            done.write()
    return Trade(model, ranges, asked, tuple(done.known[values] for values in robots))


def _robots(
    robot: Robot, ranges: Mapping[Change, tuple[float, ...]], asked: TradeSettings
) -> dict[tuple[float, ...], Robot]:
    """The robot of each combination. Raises `InputError`."""
    count = math.prod(len(values) for values in ranges.values())
    if not ranges or not count:
        raise InputError("nothing varies: at least one parameter with a value is wanted")
    if count > MAX_COMBINATIONS:
        raise InputError(f"{count} combinations: at most {MAX_COMBINATIONS} are allowed")
    names = [part for change in ranges for part in change.parts]
    twice = [part[0] for part in names if names.count(part) > 1]
    if twice:
        raise InputError(f"{twice[0]}: it is varied more than once")
    if asked.retraction is not None and any(name == "retraction" for name, _ in names):
        raise InputError("retraction: cannot vary while a length or a law of it is given")
    robots = {}
    for values in product(*ranges.values()):
        made = changed(robot, dict(zip(ranges, values, strict=True)))
        if asked.inertia == "box":
            if asked.retraction is not None:
                assert not isinstance(asked.retraction, RetractionLaw)  # `TradeSettings` refuses it
                made = made.retracted(asked.retraction)
            made = with_box_inertia(made)
        robots[values] = made
    return robots


def _combination(model: Model, values: tuple[float, ...], asked: TradeSettings) -> Combination:
    lines = model if asked.criterion == "static" else straight(model)
    if asked.count == "nodes":
        nodes = count_nodes(lines, asked.criterion, grid=asked.grid, **asked.of_workspace)
        volume, error, fraction, converged = nodes.volume, nodes.volume_error, nodes.fraction, True
    else:
        more: dict[str, Any] = {"tolerance": asked.tolerance, "grid": asked.grid, "seed": asked.seed}
        found = workspace(lines, asked.criterion, **more, **asked.of_workspace)
        volume, error, fraction, converged = found.volume, found.volume_error, found.fraction, found.converged
    held = boundary_modes(
        model,
        asked.criterion,
        grid=asked.boundary_grid,
        geometric=asked.geometric,
        holding=asked.holding,
        **asked.of_workspace,
    )
    least, median, greatest = plain(held.spread)
    exits = nearest_exits(model.robot)
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
        exit_distance=None if exits is None else exits[0],
        exits=None if exits is None else exits[1],
    )


def _question(model: Model, ranges: Mapping[Change, tuple[float, ...]], asked: TradeSettings) -> str:
    """What the sweep is of, as a hash: the robot, the physics, the values, what is asked, and the version."""
    parts: dict[str, Any] = {
        "version": version("cablewright"),
        "robot": model.robot.model_dump(),
        "fidelity": asdict(model.fidelity),
        "limits": model.tension_limits,
        "varied": [(change.name, values) for change, values in ranges.items()],
        "asked": asdict(asked),
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class _Stored:
    """What a file has."""

    question: str
    combinations: list[Combination]


_STORED = TypeAdapter(_Stored)


@dataclass
class _Done:
    """The combinations that are known, and the file that has them."""

    file: Path | None
    question: str
    known: dict[tuple[float, ...], Combination] = field(default_factory=dict)
    written: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        """Read what the file has of the same sweep. Raises `InputError` if it is something else than a sweep."""
        if self.file is None or not self.file.exists():
            return
        if self.file.stat().st_size > MAX_BYTES:
            raise InputError(f"{self.file}: more than {MAX_BYTES} bytes; no sweep has as many")
        try:
            stored = _STORED.validate_json(self.file.read_bytes())
        except (OSError, ValidationError):
            raise InputError(f"{self.file}: not a sweep of this program; remove it or choose another --out") from None
        if stored.question == self.question:
            self.known.update((each.values, each) for each in stored.combinations)

    def add(self, found: Combination) -> None:
        """Keep one more; written every few seconds."""
        self.known[found.values] = found
        if time.monotonic() - self.written > WRITTEN_EVERY:
            self.write()

    def write(self) -> None:
        """Write all that are known; the file appears whole, by rename."""
        if self.file is None:
            return
        held = _Stored(self.question, list(self.known.values()))
        content = (json.dumps(asdict(held), indent=1) + "\n").encode()
        write_whole(self.file, content, parents=True)
        self.written = time.monotonic()
