"""Certificates: proofs that exactly one equilibrium lies near a numerical one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Result
from cablewright.kernels import batches
from cablewright.kernels.certificates import krawczyk as kernel
from cablewright.kernels.statics.line import enclosure
from cablewright.kernels.statics.line.vertical_plane import NO_PLANE
from cablewright.models.batch_rows import Rows, by_row, scalar
from cablewright.models.statics import Equilibrium
from cablewright.solvers.row_threads import run

TOLERANCE = 1e-9  # default tolerance of a certificate, m and rad

STRAIGHT_DOWN = 100  # a code beside the kernel's
REASONS = {
    kernel.CERTIFIED: "exactly one equilibrium lies in the box",
    kernel.NOT_CONTRACTING: "not certified: no box around the solution contracts; it is singular there, or nearly",
    kernel.UNBOUNDED: "not certified: the equations are not bounded in any box around the solution",
    STRAIGHT_DOWN: "not certified: a line hangs straight down, where it has no plane; the proof is by lines in planes",
    kernel.NO_INVERSE: "not certified: the Jacobian is singular",
    enclosure.SLACK: "not certified: a massless line hangs slack and has no shape",
    kernel.IMPRECISE: "not certified: exactly one equilibrium is near, but not within the tolerance",
}

LEVERS = {1: "stable", -1: "unstable", 0: "not sure"}
"""Proved stability of all levers, by the sign in `Certificate.levers`."""


@dataclass(frozen=True, eq=False, repr=False)
class Certificate(Rows, Result):
    """Result of a certification: the proof about an equilibrium, or about each of a batch (a leading axis).

    If `certified`, the equations of the model, whose numbers are taken as exact doubles, have exactly one solution with
    all its unknowns in a box around the numerical one. Its position is within `bound` of the equilibrium's, m, and for
    a body the rotation between the two has a rotation vector with components within `bound`, rad. `box` is the half
    width of the region around the pose without another solution.
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
    bound: Array  # (n,) NaN where nothing is proved; also known where only the tolerance is not met
    box: Array  # (n,)
    levers: NDArray[np.int64]  # () 1: every lever is proved stable; -1: one is proved unstable; 0: neither

    def __repr__(self) -> str:
        """The reason, or the number of certified rows of a batch."""
        text = self.reason() if self.single else f"{int(self.certified.sum())} of {len(self)} certified"
        return f"Certificate({text})"

    @property
    def certified(self) -> Any:
        """Whether the equilibrium is proved: a bool, or a mask (N,) for a batch."""
        return scalar(self.code == kernel.CERTIFIED)

    def reason(self) -> Any:
        """Return the reason why the equilibrium is proved or not: a sentence, or a tuple (N) of them for a batch."""
        return by_row(REASONS.get, self.code)


def certify(equilibrium: Equilibrium, tolerance: float = TOLERANCE) -> Certificate:
    """Prove that exactly one equilibrium is near a solved one, or near each of a batch.

    *tolerance* of its pose: m, and rad for a body. The equilibrium must be solved; its status is otherwise ignored, so
    an unstable one can be certified. Unsolved rows are not certified. Raises `InputError` for rigid cables or a
    tolerance that is not positive.

    Krawczyk's test in interval arithmetic; see `docs/theory/certificates.md`.
    """
    model = equilibrium.model
    model.refuse_rigid()
    if not tolerance > 0.0:
        raise InputError(f"tolerance {tolerance:g}: over 0 is expected, m")
    lengths, poses, states = equilibrium.solved_arrays()
    rows = len(lengths)
    codes, signs = np.full(rows, kernel.UNBOUNDED), np.zeros(rows, dtype=np.int64)
    bounds, boxes = np.full((rows, model.n), np.nan), np.full((rows, model.n), np.nan)
    arrays = (lengths, poses, states, float(tolerance), codes, bounds, boxes, signs)
    run(batches.certify_rows, rows, equilibrium.packed, *arrays)
    unproved = np.isin(codes, (kernel.UNBOUNDED, kernel.NOT_CONTRACTING))
    codes[unproved & _straight_down(equilibrium)] = STRAIGHT_DOWN
    failed = (codes != kernel.CERTIFIED) & (codes != kernel.IMPRECISE)
    bounds[failed], boxes[failed], signs[failed] = np.nan, np.nan, 0
    found = Certificate(codes, bounds, boxes, signs)
    return found[0] if equilibrium.single else found


def _straight_down(equilibrium: Equilibrium) -> Mask:
    """Whether the platform point of a line in a vertical plane is below or above its exit point, in each row (N,)."""
    away = equilibrium.platform_points - equilibrium.lines.exit_point
    aside = np.linalg.norm(away[..., :2], axis=-1)
    return np.atleast_1d(((aside < NO_PLANE) & equilibrium.lines.in_plane).any(axis=-1))


def is_only_one(equilibrium: Equilibrium) -> bool:
    """Return whether a theorem proves that each row's equilibrium is the only one for its lengths.

    Theorem 1 of `docs/theory/uniqueness.md`: a point load on eyelets, no modelled dead span, cables with weight and
    finite stiffness.
    """
    lines = equilibrium.lines
    plain = lines.in_plane & ~lines.has_dead_span & (lines.radius == 0.0) & (equilibrium.lengths > lines.dead_length)
    real = (lines.weight > 0.0) & (lines.free_compliance > 0.0) & (lines.spring == 0.0)
    real &= (lines.mount == 0.0).all(axis=-1)
    free = equilibrium.model.n == 3 and equilibrium.model.robot.platform.plane is None
    return bool(free and plain.all() and real.all())
