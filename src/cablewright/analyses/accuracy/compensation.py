"""Cable lengths commanded by a controller's model, and the poses that these lengths reach on the full model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import UnknownName
from cablewright.kernels.layout import Code
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.statics import Equilibrium, Model
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse


@dataclass(frozen=True)
class Compensation:
    """The model by which a controller computes the cable lengths that it commands.

    `words` complete a phrase such as "error without ...".
    """

    name: str
    fidelity: Fidelity
    words: str

    @classmethod
    def of(cls, name: str) -> Compensation:
        """Return the compensation (the model that computed the lengths) called *name*. Raises `UnknownName`."""
        if name not in COMPENSATIONS:
            raise UnknownName("compensation", name, COMPENSATIONS)
        return COMPENSATIONS[name]

    def lengths(
        self, held: Equilibrium, poses: Array, *, retraction: Array | None = None, home: Equilibrium | None = None
    ) -> Array:
        """Return the lengths (N, m), m, commanded for *poses* (N, n), which the full model has solved as *held*.

        *retraction* (N,), m, is the platform's retraction length. *home*, an equilibrium of the full model, is where
        the machine was zeroed: the commanded lengths are exact there. Raises `AnswerError` where the model of this
        compensation has no answer at home.
        """
        full = held.model
        if self.fidelity == full.fidelity:
            return held.lengths
        found = self.solved(full, poses, retraction=retraction).lengths
        if home is None:
            return found
        return found + (home.lengths - self.solved(full, home.pose, path=False).checked().lengths)

    def solved(self, full: Model, poses: Array, *, retraction: Array | None = None, path: bool = True) -> Equilibrium:
        """Solve *poses* by the model of this compensation of the robot of *full*; *path*: they are neighbours."""
        model = Model(full.robot, self.fidelity, full.tension_limits)
        return solve_inverse(model, poses, path=path, retraction=retraction)


COMPENSATIONS: Final = {
    each.name: each
    for each in (
        Compensation("none", Fidelity(CableLaw.RIGID), "without compensation"),
        Compensation("elastic", Fidelity(CableLaw.ELASTIC), "with stretch alone compensated"),
        Compensation("eyelets", Fidelity(CableLaw.CATENARY, SheaveLaw.EYELET), "with all but sheaves compensated"),
        Compensation("full", Fidelity(), "with full compensation"),
    )
}
"""The compensations by name; ``none`` computes lengths with rigid cables."""


@dataclass(frozen=True, eq=False)
class Reached:
    """The poses that N rows of cable lengths reach; NaN where there is no equilibrium."""

    codes: NDArray[np.int64]  # (N,) of `Status`
    poses: Array  # (N, n)
    equilibria: Equilibrium  # the rows whose code is 0

    @classmethod
    def of(
        cls, full: Model, lengths: Array, near: Array, *, retraction: Array | None = None, path: bool = False
    ) -> Self:
        """Solve the *full* model for *lengths* (N, m), m (NaN is allowed), starting *near* poses (N, n).

        *path* states that consecutive rows are neighbours on a path.
        """
        codes, poses = np.full(len(lengths), int(Code.NOT_FINITE)), np.full(near.shape, np.nan)
        some = (lengths > 0.0).all(axis=1)  # false for NaN
        retracted = None if retraction is None else retraction[some]
        solved = solve_forward(full, lengths[some], guess=near[some], path=path, retraction=retracted)
        codes[some] = solved.code
        poses[codes == 0] = solved.pose[solved.ok]
        return cls(codes, poses, solved[solved.ok])
