"""Optimisers by name: each proposes batches of values between 0 and 1, and receives their objective values.

All are deterministic by their seed, so that a search that was interrupted asks again for what it asked before, and
finds the answers on the disk.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import EnvironmentFault, InputError

BAD: Final = 1e30
"""Worse than any objective: where the score of candidates that break constraints begins."""

Batch = Callable[[Array], tuple[Array, Array]]
"""Values (k, d) from 0 to 1 give objectives (k, n), which are to be small, and violations (k,), 0 where all holds."""


@dataclass(frozen=True)
class Budget:
    """Budget of a search: candidates in all, candidates at a time, and the seed."""

    evaluations: int
    population: int
    seed: int

    @property
    def generations(self) -> int:
        """Number of batches of candidates that the search evaluates."""
        return max(1, self.evaluations // self.population)


Optimiser = Callable[[Batch, int, int, Budget], None]
"""Searches in so many dimensions for so many objectives; who answers the batches keeps what was found."""


def scores(objectives: Array, violations: Array) -> Array:
    """Return the score (k,) of each candidate design: the objective, or for infeasible ones their violation.

    Any feasible candidate is better than all infeasible ones (Deb 2000).
    """
    broken = BAD * (1.0 + np.minimum(np.nan_to_num(violations, nan=np.inf), 1e6))
    return np.where((violations > 0.0) | ~np.isfinite(objectives[:, 0]), broken, objectives[:, 0])


def first_rows(dimensions: int, budget: Budget) -> Array:
    """Return the first population of a search: a Latin hypercube."""
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(dimensions, rng=np.random.default_rng(budget.seed)).random(budget.population))


def differential_evolution(batch: Batch, dimensions: int, objectives: int, budget: Budget) -> None:
    """SciPy's differential evolution (Storn and Price 1997), a generation at a time; for one objective."""
    from scipy import optimize

    _require_one(objectives, "de")
    optimize.differential_evolution(
        lambda rows: scores(*batch(np.asarray(rows).T)),
        [(0.0, 1.0)] * dimensions,
        init=first_rows(dimensions, budget),
        maxiter=budget.generations - 1,
        rng=np.random.default_rng([budget.seed, 1]),
        tol=0.0,
        atol=-1.0,  # it does not end before its budget
        polish=False,
        updating="deferred",
        vectorized=True,
    )


def cma_es(batch: Batch, dimensions: int, objectives: int, budget: Budget) -> None:
    """CMA-ES (Hansen) of the package cma, for one objective and at least two variables."""
    _require_one(objectives, "cma-es")
    if dimensions < 2:
        raise InputError("method cma-es: needs at least two variables; de takes one")
    try:
        import cma
    except ImportError:
        raise _absent("cma-es", "cma") from None
    random = np.random.default_rng([budget.seed, 2])
    options: dict[str, Any] = {
        "bounds": [0.0, 1.0], "popsize": budget.population, "verbose": -9, "seed": np.nan,
        "randn": lambda count, size: random.standard_normal((count, size)),  # its own would set NumPy's global seed
    }  # fmt: skip
    search = cma.CMAEvolutionStrategy(dimensions * [0.5], 0.25, options)
    for _ in range(budget.generations):
        rows = search.ask()
        search.tell(rows, scores(*batch(np.array(rows))).tolist())


def nsga2(batch: Batch, dimensions: int, objectives: int, budget: Budget) -> None:
    """NSGA-II (Deb et al. 2002) of the package pymoo, for any number of objectives."""
    try:
        from pymoo.algorithms.moo.nsga2 import NSGA2
        from pymoo.core.problem import Problem
        from pymoo.problems.static import StaticProblem
    except ImportError:
        raise _absent("nsga2", "pymoo") from None
    problem = Problem(n_var=dimensions, n_obj=objectives, n_ieq_constr=1, xl=0.0, xu=1.0)
    search = NSGA2(pop_size=budget.population, sampling=first_rows(dimensions, budget))
    search.setup(problem, termination=("n_gen", budget.generations), seed=budget.seed, verbose=False)
    while search.has_next():
        asked = search.ask()
        values, violations = batch(asked.get("X"))
        known = np.nan_to_num(values, nan=BAD, posinf=BAD, neginf=-BAD)
        broken = np.minimum(np.nan_to_num(violations, nan=np.inf), 1e6)
        search.evaluator.eval(StaticProblem(problem, F=known, G=broken[:, None]), asked)
        search.tell(infills=asked)


def _require_one(objectives: int, name: str) -> None:
    if objectives != 1:
        raise InputError(f"method {name}: is for one objective; nsga2 takes {objectives}")


def _absent(method: str, package: str) -> EnvironmentFault:
    return EnvironmentFault(f"method {method}: needs the package {package}; pip install 'cablewright[design]'")


OPTIMISERS: Final[Mapping[str, Optimiser]] = MappingProxyType(
    {"de": differential_evolution, "cma-es": cma_es, "nsga2": nsga2}
)
