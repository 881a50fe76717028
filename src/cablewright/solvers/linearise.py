"""Linearisation of a solved equilibrium: stiffness, and motion and tension per length and parameter of a line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import AnswerError, Status
from cablewright.kernels import batches
from cablewright.kernels.layout import EXIT, LENGTH, MODULUS, PARAMETERS, POINT, SHEAVE, WEIGHT_FACTOR
from cablewright.models.batch_rows import Rows
from cablewright.models.statics import Equilibrium
from cablewright.solvers.row_threads import run


@dataclass(frozen=True, eq=False, repr=False)
class Linearisation(Rows):
    """First-order behaviour at an equilibrium with lengths held; a leading axis for a batch, see `Rows`.

    `stiffness` (n, n): restoring wrench per platform motion, N/m and N m/rad; not symmetrised, as rigid arcs over the
    sheaves make it slightly unsymmetric; directions that a plane blocks have none. `motion` (n, m, 10): motion of the
    platform per parameter of each line, see the properties.
    """

    SINGLE: ClassVar = ("stiffness", 2)

    stiffness: Array
    motion: Array
    free: Array | None = None  # (n, f) basis of the motions that a plane leaves

    @property
    def per_length(self) -> Array:
        """Motion (n, m) per unstrained length paid out, m/m and rad/m."""
        return self.motion[..., LENGTH]

    @property
    def per_modulus(self) -> Array:
        """Motion (n, m) per relative change of each line's Young's modulus, m."""
        return self.motion[..., MODULUS]

    @property
    def per_exit_point(self) -> Array:
        """(n, m, 3) motion per exit point coordinate, m/m. A modelled winch exit follows it, except in height."""
        return self.motion[..., EXIT : EXIT + 3]

    @property
    def per_sheave_radius(self) -> Array:
        """(n, m) motion per radius of each sheave, m/m; 0 without a sheave. A swivel's centre moves with the radius."""
        return self.motion[..., SHEAVE]

    @property
    def per_weight(self) -> Array:
        """Motion (n, m) per relative change of each cable's linear density, m."""
        return self.motion[..., WEIGHT_FACTOR]

    @property
    def per_platform_point(self) -> Array:
        """Motion (n, m, 3) per platform point coordinate, platform frame, m/m."""
        return self.motion[..., POINT : POINT + 3]

    @property
    def per_wrench(self) -> Array:
        """(n, n) motion per external wrench: the compliance, m/N and rad/(N m); 0 across a plane."""
        if self.free is None:
            return np.asarray(np.linalg.inv(self.stiffness))
        back = np.swapaxes(self.free, -1, -2)
        return np.asarray(self.free @ np.linalg.inv(back @ self.stiffness @ self.free) @ back)

    def motion_under(self, wrenches: Array) -> Array:
        """Return the motion (..., n, k) under *wrenches* (..., n, k), N and N m, on the platform."""
        if self.free is None:
            return np.asarray(np.linalg.solve(self.stiffness, wrenches), np.float64)
        return self.per_wrench @ wrenches


def linearise(equilibrium: Equilibrium) -> Linearisation:
    """Linearise a solved equilibrium, or each of a batch.

    Raises `AnswerError` if a row was not solved or is singular, `InputError` if its cables are rigid.
    """
    found, codes = linearise_where_regular(equilibrium)
    _check(codes)
    return found[0] if equilibrium.single else found


def linearise_where_regular(equilibrium: Equilibrium) -> tuple[Linearisation, NDArray[np.int64]]:
    """Linearise a batch, see `linearise`, with a status code for each row instead of an error for a singular one."""
    equilibrium.model.refuse_rigid()
    equilibrium.checked()
    model, rows = equilibrium.model, equilibrium.code.size
    stiffness = np.zeros((rows, model.n, model.n))
    motion = np.zeros((rows, model.n, model.m, PARAMETERS))
    codes = np.zeros(rows, dtype=np.int64)
    solved = equilibrium.solved_arrays()
    run(batches.linearise_rows, rows, equilibrium.packed, *solved, stiffness, motion, codes)
    free = model.free_directions
    return Linearisation(stiffness, motion, None if free is None else np.repeat(free[None], rows, axis=0)), codes


def linearise_solved(equilibrium: Equilibrium) -> tuple[Mask, Linearisation]:
    """Return a mask (N,) of equilibria that are solved and regular, and their linearisation."""
    regular = equilibrium.ok.copy()
    linear, codes = linearise_where_regular(equilibrium[regular])
    regular[regular] = codes == 0
    return regular, linear[codes == 0]


@dataclass(frozen=True, eq=False, repr=False)
class TensionChanges(Rows):
    """First-order changes of the tensions at the sheaves, N, at the N solved rows of a batch.

    `own` (N, m, 10): per parameter of each line, as in `Linearisation.motion`, with the platform held. `by_pose`
    (N, m, n): per motion of the platform, N/m, and N per rad about world axes.
    """

    SINGLE: ClassVar = ("own", 2)

    own: Array
    by_pose: Array

    @property
    def per_length(self) -> Array:
        """Change (N, m) of tension per unstrained length of the line, N/m."""
        return self.own[..., LENGTH]

    def following(self, motion: Array) -> Array:
        """Return the tension changes (N, m, k), N, that a *motion* (N, n, k) of the platform, m and rad, causes."""
        return np.asarray(np.einsum("nmc,nck->nmk", self.by_pose, motion))


def tension_changes(equilibrium: Equilibrium) -> TensionChanges:
    """Linearise the tensions of a solved batch. Raises the same errors as `linearise`."""
    equilibrium.model.refuse_rigid()
    equilibrium.checked()
    rows, m = equilibrium.lengths.shape
    own, by_pose = np.zeros((rows, m, PARAMETERS)), np.zeros((rows, m, equilibrium.model.n))
    codes = np.zeros(rows, dtype=np.int64)
    batches.tension_rows(equilibrium.packed, *equilibrium.solved_arrays(), own, by_pose, codes)
    _check(codes)
    tensions = equilibrium.tensions[..., None]
    return TensionChanges(own * tensions, by_pose * tensions)


def _check(codes: NDArray[np.int64]) -> None:
    """Raise `AnswerError` for the first row whose code is not 0."""
    if codes.any():
        row = int(np.flatnonzero(codes)[0])
        raise AnswerError(f"row {row}: {Status.of(int(codes[row])).value}")
