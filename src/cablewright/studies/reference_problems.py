"""Benchmark problems with independent answers, on which programs for cable robots can be compared."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from itertools import combinations
from types import MappingProxyType
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.rigidity import natural_frequencies
from cablewright.analyses.workspace.workspace import workspace
from cablewright.analyses.wrench_polytope import available_wrenches
from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.results import Figure, Result
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Cable, Robot
from cablewright.solvers.forward import forward
from cablewright.solvers.tension import tension_distribution

_STRONG: Final = 1e12  # N: a cable that does not break, nor stretch where no stiffness is given
_MANY: Final = (0.0, 1e6)  # N: limits where the problem has none


@dataclass(frozen=True, eq=False, repr=False)
class Problem(Result):
    """A benchmark problem: its inputs, an independent answer, and the required accuracy.

    ``inputs``: arrays in SI by name, which say all. Cables leave eyelets; without a ``linear_density`` they have no
    mass, without an ``axial_stiffness`` they do not stretch. Gravity is 9.81 m/s^2. ``answer`` (k,) is in ``unit``.
    """

    FIGURES: ClassVar = (
        Figure("name", "", "Name."),
        Figure("kind", "", "Kind."),
        Figure("question", "", "The question in words."),
        Figure("answer", "SI", "The answer."),
        Figure("unit", "", "Its unit."),
        Figure("tolerance", "SI", "How near to it an answer has to be, in its unit."),
        Figure("oracle", "", "Where the answer is from."),
    )
    HEADLINES: ClassVar = ("name", "question", "unit")

    name: str
    kind: str
    question: str
    inputs: Mapping[str, Array]
    answer: Array
    unit: str
    tolerance: float
    oracle: str

    def error(self, answer: ArrayLike) -> float:
        """Return the largest difference of an *answer* (k,) from the known answer, in its unit. Raises `InputError`."""
        given = np.asarray(answer, dtype=np.float64)
        if given.shape != self.answer.shape:
            raise InputError(f"problem {self.name}: {len(self.answer)} numbers are expected, not shape {given.shape}")
        return float(np.abs(given - self.answer).max())

    def solve(self) -> tuple[Array, float]:
        """Return cablewright's answer (k,), and the time of the call in s, without the construction of the robot."""
        robot, solver = self.robot, _SOLVERS[self.kind]
        begin = time.perf_counter()
        found = solver(self, robot)
        return np.asarray(found, dtype=np.float64), time.perf_counter() - begin

    @property
    def robot(self) -> Robot:
        """The robot of the test problem."""
        given = self.inputs
        cable = Cable(
            axial_stiffness=float(given.get("axial_stiffness", _STRONG)),
            linear_density=float(given.get("linear_density", 0.0)),
            breaking_load=_STRONG,
        )
        body: dict[str, Any] = {"inertia": tuple(given["inertia"].tolist())} if "inertia" in given else {}
        return Robot.from_points(
            given["exit_points"],
            given.get("platform_points"),
            mass=float(given.get("mass", 1.0)),
            cable=cable,
            tension_limits=tuple(given.get("tension_limits", np.array(_MANY)).tolist()),
            frame=given.get("frame"),
            name=self.name,
            **body,
        )


def problems(kind: str | None = None) -> tuple[Problem, ...]:
    """Return the thirty problems, or those of a *kind*. Raises `UnknownName`.

    Kinds: ``forward`` (points on sagging cables), ``tensions``, ``acceleration``, ``margin``, ``volume``,
    ``calibration``, ``frequencies``. Answers are of mpmath with 50 digits, of linear and quadratic programs, of random
    places, or known because the data were made from them; none is of cablewright.

    Examples
    --------
    >>> import cablewright as cw
    >>> problem = cw.problems("forward")[0]
    >>> answer, seconds = problem.solve()
    >>> problem.error(answer) <= problem.tolerance
    True
    """
    every = _read()
    kinds = list(dict.fromkeys(each.kind for each in every))
    if kind is not None and kind not in kinds:
        raise UnknownName("kind of problem", kind, kinds)
    return tuple(each for each in every if kind in (None, each.kind))


@cache
def _read() -> tuple[Problem, ...]:
    rows = json.loads(resources.files(__package__).joinpath("problems.json").read_text("utf-8"))["problems"]
    return tuple(_problem(**row) for row in rows)


def _problem(inputs: Mapping[str, Any], answer: list[float], **told: Any) -> Problem:
    arrays = {key: np.array(value, dtype=np.float64) for key, value in inputs.items()}
    return Problem(inputs=MappingProxyType(arrays), answer=np.array(answer, dtype=np.float64), **told)


def _hanging(problem: Problem, robot: Robot) -> Array:
    return np.asarray(forward(robot, problem.inputs["lengths"]).checked().pose)


def _tensions(problem: Problem, robot: Robot) -> Array:
    return np.asarray(tension_distribution(robot, problem.inputs["pose"]).tensions)


def _acceleration(problem: Problem, robot: Robot) -> Array:
    found = available_wrenches(robot, problem.inputs["pose"])
    push = np.zeros(robot.n)
    push[:3] = float(problem.inputs["mass"]) * problem.inputs["direction"]
    across = found.normals @ push
    out = across > 1e-12 * np.abs(across).max()
    return np.array([np.min(found.distances(found.required)[out] / across[out])])


def _margin(problem: Problem, robot: Robot) -> Array:
    return np.array([available_wrenches(robot, problem.inputs["pose"]).margin])


def _volume(_problem: Problem, robot: Robot) -> Array:
    return np.array([workspace(robot, "exact", cable="rigid").volume])


def _distances(problem: Problem, robot: Robot) -> Array:
    found = calibrate(robot, Measured(problem.inputs["counted"], problem.inputs["guess"]))
    exits = np.array([line.exit_point for line in found.robot.lines])
    return np.array([np.linalg.norm(a - b) for a, b in combinations(exits, 2)])


def _frequencies(problem: Problem, robot: Robot) -> Array:
    held = forward(Model(robot, Fidelity.of("elastic")), problem.inputs["lengths"], guess=problem.inputs["pose"])
    return np.asarray(natural_frequencies(held.checked()))


_SOLVERS: Final[Mapping[str, Callable[[Problem, Robot], Array]]] = {
    "forward": _hanging,
    "tensions": _tensions,
    "acceleration": _acceleration,
    "margin": _margin,
    "volume": _volume,
    "calibration": _distances,
    "frequencies": _frequencies,
}
