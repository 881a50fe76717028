"""What a controller's model leaves out: the lengths that it commands, and where they take the machine as it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.errors import UnknownName
from cablewright.kernels.layout import Code
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.statics import Equilibrium, Model
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse


@dataclass(frozen=True)
class Compensation:
    """A model that a controller takes its lengths from. `words` follow what it is said of: "error without ..."."""

    name: str
    fidelity: Fidelity
    words: str

    @classmethod
    def of(cls, name: str) -> Compensation:
        """The one of that name. Raises `UnknownName`."""
        if name not in COMPENSATIONS:
            raise UnknownName("compensation", name, COMPENSATIONS)
        return COMPENSATIONS[name]

    def lengths(
        self, held: Equilibrium, poses: Array, *, retraction: Array | None = None, home: Equilibrium | None = None
    ) -> Array:
        """Lengths (N, m), m, that it commands for *poses* (N, n), which the full model has *held*.

        *retraction* (N,) m is the platform's. Where *home*, of the full model, the machine was zeroed: there the
        lengths are true. Raises `AnswerError` where its own model cannot be at home.
        """
        full = held.model
        if self.fidelity == full.fidelity:
            return held.lengths
        model = Model(full.robot, self.fidelity, full.tension_limits)
        found = solve_inverse(model, poses, path=True, retraction=retraction).lengths
        return found if home is None else found + (home.lengths - solve_inverse(model, home.pose).checked().lengths)


COMPENSATIONS: Final = {
    each.name: each
    for each in (
        Compensation("none", Fidelity(CableLaw.RIGID), "without compensation"),
        Compensation("elastic", Fidelity(CableLaw.ELASTIC), "with stretch alone compensated"),
        Compensation("eyelets", Fidelity(CableLaw.CATENARY, SheaveLaw.EYELET), "with all but sheaves compensated"),
        Compensation("full", Fidelity(), "with full compensation"),
    )
}
"""By name. Without compensation the lengths are those of rigid cables."""


@dataclass(frozen=True, eq=False)
class Reached:
    """Where N rows of lengths take the machine; of rows that lead nowhere the pose is NaN and the code says why."""

    codes: NDArray[np.int64]  # (N,)
    poses: Array  # (N, n)
    equilibria: Equilibrium  # of the rows whose code is 0

    @classmethod
    def of(
        cls, full: Model, lengths: Array, near: Array, *, retraction: Array | None = None, path: bool = False
    ) -> Self:
        """What the *full* model says of *lengths* (N, m), m, which may be NaN, *near* poses (N, n).

        *path* says that neighbouring rows are neighbours on a path.
        """
        codes, poses = np.full(len(lengths), int(Code.NOT_FINITE)), np.full(near.shape, np.nan)
        some = (lengths > 0.0).all(axis=1)  # false for NaN
        drawn = None if retraction is None else retraction[some]
        solved = solve_forward(full, lengths[some], guess=near[some], path=path, retraction=drawn)
        codes[some] = solved.code
        poses[codes == 0] = solved.pose[solved.ok]
        return cls(codes, poses, solved[solved.ok])
