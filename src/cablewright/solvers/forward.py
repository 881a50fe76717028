"""Forward problem: the pose of the platform for given unstrained lengths."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.kernels import batches
from cablewright.kernels.layout import Packed
from cablewright.models.batch_rows import rows_of
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.packed_views import blank_states
from cablewright.models.parameters import varied
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot, parameters_of
from cablewright.solvers.arguments import as_lengths, as_poses, given_numbers, given_rows
from cablewright.solvers.row_threads import run


def forward(
    robot: Robot | Model,
    lengths: ArrayLike,
    *,
    guess: ArrayLike | None = None,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    modulus_factors: ArrayLike | None = None,
    retraction: ArrayLike | None = None,
) -> Equilibrium:
    """Compute pose and tensions for unstrained *lengths*, (m,) or (N, m) in m, from winch exit to platform.

    *guess*: a pose, or one for each row; without it the solver finds its own start. Where a rigid body could hang in
    several poses, it finds the one near the guess, or without a guess one with a small rotation. *modulus_factors*
    multiply each line's Young's modulus, (m,) or one row each. *retraction*: the platform's retraction length, m, one
    for all or one for each row. Tensions follow from the lengths: limits are not enforced, but a line over its breaking
    load has status OVERSTRETCHED. The length of a line with a counterweight is not read, and may be NaN: the answer has
    it. Raises `InputError` for numbers of the wrong count, not finite or not positive, and for rigid cables, whose
    tensions do not follow from lengths.
    """
    model = Model.of(robot, cable=cable, sheave=sheave)
    return solve_forward(model, lengths, guess=guess, modulus_factors=modulus_factors, retraction=retraction)


def solve_forward(
    model: Model,
    lengths: ArrayLike,
    *,
    guess: ArrayLike | None = None,
    modulus_factors: ArrayLike | None = None,
    retraction: ArrayLike | None = None,
    path: bool = False,
) -> Equilibrium:
    """Solve `forward` for a model. *path*: consecutive rows are neighbours on a path, each near its guess."""
    model.refuse_rigid()
    length, single = as_lengths(model, lengths)
    rows = len(length)
    packed = model.rows(retraction=given_numbers(retraction, rows, "retraction", "m"))
    if modulus_factors is not None:
        factors = given_rows(modulus_factors, rows, model.m, "modulus factors", "1")
        if not (factors > 0.0).all():
            raise InputError(f"modulus factors: every factor must be over zero; got {factors[factors <= 0.0][0]:g}")
        packed, length = varied(model.robot, packed, parameters_of(model.robot, "modulus"), factors, length)
    pose = np.zeros((rows, model.n))
    start = batches.COLD
    if guess is not None:
        given, _ = as_poses(model, guess, "guess")
        pose[:] = given_rows(given, rows, model.n, "guess", "m and rad")
        start = batches.CHAIN if path else batches.NEAR
    batch = _solve(model, packed, length, pose, blank_states(rows, model.m), start)
    return batch[0] if single else batch


def solve_again(solved: Equilibrium, packed: Packed, lengths: Array, each: int) -> Equilibrium:
    """Solve *each* changed problems for each row of the batch *solved*, from its pose and states.

    *packed* and *lengths* (N * each, m), m, hold the changed problems row by row. Where the start fails, the solver
    starts from the pose alone, then without a guess. Rows that were not solved stay unsolved.
    """
    pose, states = np.repeat(solved.pose, each, axis=0), np.repeat(solved.states, each, axis=0)
    return solve_from(solved.model, packed, lengths, pose, states, np.repeat(solved.code, each) == 0)


def solve_from(model: Model, packed: Packed, lengths: Array, poses: Array, states: Array, again: Mask) -> Equilibrium:
    """Solve forward problems of *lengths* (N, m), m, from given *poses* (N, n) and *states* (N, m, 6).

    *packed*: arrays of the robot. Rows that fail are solved *again* (N,) from the pose alone, then without a guess.
    """
    found = _solve(model, packed, lengths, poses.copy(), states.copy(), batches.WARM)
    lost = np.flatnonzero((found.code != 0) & again)
    if len(lost):
        late = _solve(model, rows_of(packed, lost), lengths[lost], poses[lost], states[lost], batches.NEAR)
        for old, new in zip((found.pose, found.states, found.code), (late.pose, late.states, late.code), strict=True):
            old[lost] = new
    return found


def _solve(model: Model, packed: Packed, lengths: Array, pose: Array, states: Array, start: int) -> Equilibrium:
    """Solve a batch from *pose* and *states*, both overwritten, which *start* (of `batches`) interprets."""
    rows = len(lengths)
    codes, iterations = np.zeros(rows, dtype=np.int64), np.zeros(rows, dtype=np.int64)
    arrays = (lengths, pose, states, codes, iterations, np.zeros(rows))
    run(batches.forward_rows, rows, packed, *arrays, start)
    lengths = lengths_paid_out(model, packed, states, lengths)
    return Equilibrium(model, packed, pose, lengths, states, codes, np.zeros(rows), iterations)


def lengths_paid_out(model: Model, packed: Packed, states: Array, given: Array) -> Array:
    """Return the *given* lengths (N, m), m; of lines with a counterweight those of *states* (N, m, 6)."""
    if not model.lines.counterweight.any():
        return given
    lengths = given.copy()
    batches.read_length_rows(packed, states, lengths)
    return lengths
