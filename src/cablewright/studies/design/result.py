"""The result of a design search: every candidate, the Pareto-optimal ones, and three to look at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.results import Figure, Pictured
from cablewright.foundation.units import is_unit, unit_size
from cablewright.robot import Robot
from cablewright.studies.design.measures import MEASURES
from cablewright.studies.design.problem import DesignProblem

SHOWN: Final = 3
"""Candidates that are written and looked at."""

APART: Final = 0.1
"""How far candidates to look at are apart, as a share of the bounds, root mean square."""


@dataclass(frozen=True)
class Tried:
    """One candidate design: values of the variables, SI; figures and shortfalls by name.

    0 ``violation``: all constraints and limits hold.
    """

    values: tuple[float, ...]
    figures: dict[str, float]
    shortfalls: dict[str, float]
    violation: float
    fault: str  # why it has no figures; empty where it has

    @property
    def holds(self) -> bool:
        """Whether the candidate satisfies all constraints and limits."""
        return self.violation == 0.0


VARIABLE = (
    Figure("name", "", "Name of the variable."),
    Figure("unit", "", "Its SI unit."),
    Figure("low", "SI", "Lowest value that was allowed."),
    Figure("high", "SI", "Highest value that was allowed."),
)
CANDIDATE = (
    Figure("parameters", "SI", "Values of the variables; none for the robot as it was.", digits=5),
    Figure("figures", "SI", "Values of the objectives and of figures with a constraint.", digits=4),
    Figure("holds", "", "Whether all constraints and limits hold."),
    Figure("limits_broken", "1", "Limits that it breaks, and by which share.", "broken"),
)


@dataclass(frozen=True, eq=False, repr=False)
class Designed(Pictured):
    """Result of a design search: all candidates, in their order."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok, or infeasible: no candidate meets all constraints and limits."),
        Figure("answer", "", "The first candidate and its objectives, beside those of the robot as it was."),
        Figure("robot", "", "Name of the robot that was changed.", "what.robot.name"),
        Figure("job", "", "Name of the job; null without one.", "what.job.name"),
        Figure("method", "", "Optimiser: de, cma-es or nsga2."),
        Figure("seed", "1", "Seed of the search.", "what.seed", detail=True),
        Figure("evaluations", "1", "Number of candidates.", lambda of: len(of.tried), name="candidates tried"),
        Figure("holding", "1", "How many of them meet all constraints and limits.", lambda of: len(of.holding)),
        Figure("failed", "1", "How many of them are no robot, or have no figures.",
               lambda of: sum(bool(each.fault) for each in of.tried)),
        Figure("variables", "", "What varied.", "what.variables", parts=VARIABLE),
        Figure("objectives", "", "Figures that were to be good.",
               lambda of: [f"{key}, {'high' if MEASURES[key].higher else 'low'}" for key in of.what.objectives]),
        Figure("constraints", "", "What had to hold besides the limits of the hardware.",
               lambda of: [str(each) for each in of.what.constraints]),
        Figure("original", "", "The robot as it was.", lambda of: [of.record(of.original)], "robot as it was",
               parts=CANDIDATE),
        Figure("chosen", "", "Candidates that are written, the best, or most balanced, first.",
               lambda of: [of.record(each) for each in of.chosen], "candidates", parts=CANDIDATE),
        Figure("front", "", "Candidates that hold, and that no other beats in one objective without losing in another.",
               lambda of: [of.record(each) for each in of.front], parts=CANDIDATE, detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("status", "robot", "answer", "evaluations", "holding")

    what: DesignProblem
    method: str
    population: int
    original: Tried
    tried: tuple[Tried, ...]

    @cached_property
    def holding(self) -> tuple[Tried, ...]:
        """Candidates that meet all constraints and limits and have all objectives."""
        return tuple(each for each in self.tried if each.holds and np.isfinite(self.what.worth(each.figures)).all())

    @property
    def status(self) -> str:
        """Status of the search: "ok", or "infeasible"."""
        return "ok" if self.holding else "infeasible"

    @property
    def answer(self) -> str:
        """The first candidate and its objectives, beside those of the original robot; empty for a no."""
        if not self.chosen:
            return ""
        first, aims = self.chosen[0], self.what.objectives
        values = (
            f"{each.name} = {value:.4g} {each.unit}"
            for each, value in zip(self.what.variables, first.values, strict=True)
        )
        read = (f"{key} {_read(key, first)} instead of {_read(key, self.original)}" for key in aims)
        return (
            f"The {'best' if len(aims) == 1 else 'most balanced'} candidate has {', '.join(values)}: {', '.join(read)}"
        )

    @property
    def refusal(self) -> str:
        """Conflicting constraints, and violation of the nearest candidate; empty if a candidate meets all."""
        if self.holding:
            return ""
        known = [each for each in self.tried if not each.fault]
        if not known:
            return f"no candidate is a robot with figures: {self.tried[0].fault}"
        nearest = min(known, key=lambda each: each.violation)
        broken = [*self._missed(nearest), *(f"limit {name} by {share:.1%}" for name, share in broken_by(nearest))]
        alone = [each for each in self.what.constraints if any(each.missed_by(t.figures[each.key]) == 0 for t in known)]
        never = [str(each) for each in self.what.constraints if each not in alone]
        why = (
            f"; no candidate at all meets {' or '.join(never)}" if never else "; each can be met, but not all together"
        )
        return f"no candidate of {len(self.tried)} meets all constraints: the nearest misses {', '.join(broken)}{why}"

    def _missed(self, nearest: Tried) -> list[str]:
        return [
            f"{each} (it has {nearest.figures[each.key]:.4g} {MEASURES[each.key].figure.unit})"
            for each in self.what.constraints
            if each.missed_by(nearest.figures[each.key]) > 0.0
        ]

    @cached_property
    def front(self) -> tuple[Tried, ...]:
        """Candidates that are not dominated, sorted by the first objective; each set of figures once."""
        if not self.holding:
            return ()
        worth = np.array([self.what.worth(each.figures) for each in self.holding])
        _, first = np.unique(worth, axis=0, return_index=True)
        rows = worth[first]
        beaten = [((rows <= row).all(axis=1) & (rows < row).any(axis=1)).any() for row in rows]
        return tuple(self.holding[k] for k, is_beaten in zip(first, beaten, strict=True) if not is_beaten)

    @cached_property
    def chosen(self) -> tuple[Tried, ...]:
        """The best candidate and others unlike it; of several objectives the most balanced one and the extremes."""
        if not self.front:
            return ()
        if len(self.what.objectives) > 1:
            worth = np.array([self.what.worth(each.figures) for each in self.front])
            low, span = worth.min(axis=0), np.maximum(np.ptp(worth, axis=0), 1e-300)
            balanced = int(np.linalg.norm((worth - low) / span, axis=1).argmin())
            ends = [int(column.argmin()) for column in worth.T]
            return tuple(self.front[k] for k in dict.fromkeys([balanced, *ends]))[:SHOWN]
        found: list[Tried] = []
        for each in sorted(self.holding, key=lambda each: float(self.what.worth(each.figures)[0])):
            if all(self._apart(each, other) >= APART for other in found):
                found.append(each)
            if len(found) == SHOWN:
                break
        return tuple(found)

    def shares(self, values: Sequence[float]) -> Array:
        """Return the values' positions between their bounds, (d,), from 0 to 1."""
        bounds = [(each.low, each.high) for each in self.what.variables]
        return np.array([(value - low) / (high - low) for value, (low, high) in zip(values, bounds, strict=True)])

    def _apart(self, one: Tried, other: Tried) -> float:
        return float(np.sqrt(np.mean((self.shares(one.values) - self.shares(other.values)) ** 2)))

    def robot_of(self, tried: Tried) -> Robot:
        """Return the robot of a candidate; its name says that it was designed, unless the job requires its name."""
        made = self.what.made(tried.values)
        bound = self.what.job is not None and self.what.job.robot is not None
        return made if bound else made.model_copy(update={"name": f"{made.name}-designed"})

    def record(self, tried: Tried) -> dict[str, Any]:
        """Return a candidate of the design search as a JSON object."""
        names = [each.name for each in self.what.variables]
        return {
            "parameters": dict(zip(names, tried.values, strict=True)) if tried.values else {},
            "figures": tried.figures,
            "holds": tried.holds,
            "limits_broken": dict(broken_by(tried)),
        }


def _read(key: str, tried: Tried) -> str:
    """Return the figure *key* of a candidate as text with its unit."""
    unit = MEASURES[key].figure.shown or MEASURES[key].figure.unit
    return f"{tried.figures.get(key, np.nan) / (unit_size(unit) if is_unit(unit) else 1.0):.3g} {unit}"


def broken_by(tried: Tried) -> list[tuple[str, float]]:
    """Return the hardware limits that a candidate violates, with the share of each violation."""
    return [(name, share) for name, share in tried.shortfalls.items() if share > 0.0]
