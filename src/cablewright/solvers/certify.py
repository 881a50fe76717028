"""Certificates: that exactly one equilibrium lies near a numerical one, as a theorem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.kernels import batches
from cablewright.kernels.certificates import krawczyk as kernel
from cablewright.models.rows import Rows, by_row, scalar
from cablewright.models.statics import Equilibrium
from cablewright.results import Figure, Result
from cablewright.solvers.arguments import run

TOLERANCE = 1e-9
"""How near the equilibrium has to be unless told otherwise, m and rad."""

REASONS = {
    kernel.CERTIFIED: "exactly one equilibrium lies in the box",
    kernel.NOT_CONTRACTING: "not certified: no box around the solution contracts; it is singular there, or nearly",
    kernel.UNBOUNDED: "not certified: the equations are not bounded in any box around the solution",
    kernel.NO_INVERSE: "not certified: the Jacobian is singular",
    kernel.SLACK: "not certified: a massless line hangs slack and has no shape",
    kernel.IMPRECISE: "not certified: exactly one equilibrium is near, but not within the tolerance",
}

LEVERS = {1: "stable", -1: "unstable", 0: "not sure"}
"""What is proved of all levers together."""


@dataclass(frozen=True, eq=False, repr=False)
class Certificate(Rows, Result):
    """What is proved of an equilibrium, or of each of a batch (a leading axis).

    Where `certified`, the equations of the model, with its numbers taken as the doubles that they are, have exactly one
    solution whose unknowns all lie in a box around the numerical one; its pose lies within `bound` of the equilibrium's
    pose, m, and for a body within a rotation whose vector has components within `bound`, rad. `box` is how far the
    pose may be from it in the box where there is no other.
    """

    FIGURES: ClassVar = (
        Figure("certified", "", "Whether exactly one equilibrium is proved to be near, within the tolerance."),
        Figure(
            "bound",
            "m, rad",
            "Max distance of the true equilibrium from the pose, per coordinate.",
            outward=1,
            digits=2,
        ),
        Figure(
            "box",
            "m, rad",
            "Distance from the pose, per coordinate, within which there is no other.",
            outward=-1,
            digits=2,
        ),
        Figure("levers", "", "Whether every lever is proved stable.", lambda own: by_row(LEVERS.get, own.levers)),
        Figure("reason", "", "Why the proof holds, or does not."),
    )

    code: NDArray[np.int64]  # ()
    bound: Array  # (n,), NaN where nothing is proved; known too where only the tolerance is not met
    box: Array  # (n,)
    levers: NDArray[np.int64]  # () 1: every lever returns when pushed, surely; -1: one does not, surely; 0: not sure

    def __repr__(self) -> str:
        """Why it holds or not, or how many of a batch do."""
        said = self.reason() if self.single else f"{int(self.certified.sum())} of {len(self)} certified"
        return f"Certificate({said})"

    @property
    def certified(self) -> Any:
        """Whether it holds: a bool, or of a batch a mask (N,)."""
        return scalar(self.code == kernel.CERTIFIED)

    def reason(self) -> Any:
        """Why it holds, or does not: a sentence, or of a batch a tuple (N) of them."""
        return by_row(REASONS.get, self.code)


def certify(equilibrium: Equilibrium, tolerance: float = TOLERANCE) -> Certificate:
    """Prove that exactly one equilibrium is near a solved one, or near each of a batch, its pose within *tolerance*.

    *tolerance*: m, and rad for a body. Statuses of the equilibrium do not matter, but that it was solved: an unstable
    one is certified as what it is. Rows without an answer are not certified. Raises `InputError` for rigid cables or a
    tolerance that is not positive.

    Krawczyk's test in interval arithmetic; see `docs/theory/certificates.md`.
    """
    model = equilibrium.model
    model.refuse_rigid()
    if not tolerance > 0.0:
        raise InputError(f"tolerance {tolerance:g}: over 0 is wanted, m")
    lengths, poses, states = equilibrium.solved_arrays()
    rows = len(lengths)
    codes, signs = np.full(rows, kernel.UNBOUNDED), np.zeros(rows, dtype=np.int64)
    bounds, boxes = np.full((rows, model.n), np.nan), np.full((rows, model.n), np.nan)
    arrays = (lengths, poses, states, float(tolerance), codes, bounds, boxes, signs)
    run(batches.certify_rows, batches.certify_sweep, rows, equilibrium.packed, *arrays)
    failed = (codes != kernel.CERTIFIED) & (codes != kernel.IMPRECISE)
    bounds[failed], boxes[failed], signs[failed] = np.nan, np.nan, 0
    found = Certificate(codes, bounds, boxes, signs)
    return found[0] if equilibrium.single else found


def is_only_one(equilibrium: Equilibrium) -> bool:
    """Whether a theorem says that a model with these lengths, of one or all rows, has one equilibrium and no more.

    Theorem 1 of `docs/theory/uniqueness.md`: a point load on eyelets, no dead span modelled, cables that weigh and
    stretch.
    """
    lines = equilibrium.lines
    plain = ~lines.has_dead_span & (lines.radius == 0.0) & (equilibrium.lengths > lines.dead_length)
    real = (lines.weight > 0.0) & (lines.free_compliance > 0.0)
    return bool(equilibrium.model.n == 3 and plain.all() and real.all())
