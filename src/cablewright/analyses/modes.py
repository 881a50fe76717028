"""Natural frequencies and modes of the platform, linearised with lengths held."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.equilibrium_figures import FIGURES as EQUILIBRIUM
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.inertia import counterweight_root, mass_root
from cablewright.models.plane import projected
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.stiffness import Stiffness, along_chords, stiffness
from cablewright.robot import Damping, Robot
from cablewright.solvers.inverse import solve_inverse

FREEDOMS = ("x", "y", "z", "rx", "ry", "rz")
"""Names of the degrees of freedom: translations along the world's axes and rotations about them."""

OF_POSE = ("status", "robot", "cable", "sheave", "pose", "lines", "lengths", "tensions")

ROUNDING = 1e-13  # share of the largest eigenvalue below which an eigenvalue counts as zero


def _if_balanced(path: str, transposed: bool = False) -> Callable[[Any], Any]:
    """Return a reader of the attribute *path* of `Modes`; it gives None where a single pose does not balance."""

    def read(found: Modes) -> Any:
        if found.equilibrium.single and not found.has_modes:
            return None
        value = attrgetter(path)(found)
        return np.swapaxes(value, -1, -2) if transposed else value

    return read


@dataclass(frozen=True, eq=False, repr=False)
class Modes(Pictured):
    """Modes of the platform at an equilibrium; a leading axis for a batch, with NaN where a row does not balance.

    n is the number of degrees of freedom; in a plane fewer than the coordinates that shapes and participation have.

    `frequencies` (n,): Hz, ascending. A negative one is of an unstable direction: the platform leaves the equilibrium
    as exp(2 pi |f| t). `shapes` (n, n): each column is a motion of the platform's origin and a rotation, world frame,
    of unit modal mass: column^T M column = 1. `participation` (n, n): each column has the shares of a mode's kinetic
    energy by freedom (see `FREEDOMS`), at the centre of mass; it sums to 1, with counterweights to 1 less their share.
    The energy of products of inertia is divided by the symmetric root of the inertia tensor.

    `elastic_share` (n,): the part of a mode's stiffness from stretch of the lines, beside the size of the rest.
    `inextensible` (n - m,), Hz: frequencies of the motions that m lines with fewer than n leave free where they do not
    stretch, by the geometric stiffness alone (Ida, Briot and Carricato 2021). A line with a counterweight holds none.

    The stiffness is symmetrised, which changes no frequency to first order. `asymmetry` () is the largest entry of its
    skew part between any two modes, relative to their mean eigenvalue: 0 unless an external moment or the papers' rigid
    arc (`docs/theory/statics.md`) acts.
    """

    FIGURES: ClassVar = (
        *(each.of_part("equilibrium") for each in EQUILIBRIUM if each.key in OF_POSE),
        Figure("counts_geometric", "", "Whether the stiffness that tension adds is counted.", "geometric"),
        Figure("freedoms", "", "Degrees of freedom of the platform, in the order of `participation`.", detail=True),
        Figure("frequencies", "Hz", "Natural frequencies, ascending; negative where unstable.",
               _if_balanced("frequencies"), "frequency", 5, along="mode"),
        Figure("dominant", "", "Freedom with the largest share of the mode's kinetic energy.", _if_balanced("mostly"),
               along="mode"),
        Figure("damping", "1", "Share of critical damping of every mode.", "damping.ratio", digits=3, shown="%",
               only=lambda found: found is None or not found.damping.is_assumed),
        Figure("damping", "1", "The same, where the robot file gives none.", "damping.ratio", "damping (assumed)", 3,
               shown="%", only=lambda found: found is not None and found.damping.is_assumed),
        Figure("damping_assumed", "", "Whether the robot file gives no damping.", "damping.is_assumed", detail=True),
        Figure("participation", "1", "Share of the mode's kinetic energy by freedom.", _if_balanced("participation",
               True),
               "energy by freedom", 3, shown="%", along="mode"),
        Figure("elastic_share", "1", "Share of the mode's stiffness from stretch of the lines: 0 of a pendulum.",
               _if_balanced("elastic_share"), "from stretch", 3, shown="%", along="mode"),
        Figure("motion", "", "stretch where more than half of the mode's stiffness is from it, else pendulum.",
               _if_balanced("motion"), along="mode"),
        Figure("inextensible_frequencies", "Hz", "Frequencies of the motions that remain if lines do not stretch.",
               _if_balanced("inextensible"), "if lines do not stretch",
               only=lambda found: found is not None and found.inextensible.size > 0),
        Figure("shapes", "m, rad", "Motion of the platform's origin in each mode, of unit modal mass.",
               _if_balanced("shapes", True), detail=True),
        Figure("stiffness", "N/m, N m/rad", "Tangent stiffness of the platform, winches held.",
               _if_balanced("stiffness.total"), detail=True),
        Figure("elastic", "N/m, N m/rad", "Part of the stiffness from the lines' elasticity along themselves.",
               _if_balanced("stiffness.elastic"), detail=True),
        Figure("geometric", "N/m, N m/rad", "All else: the part from tension and load.",
               _if_balanced("stiffness.geometric"), detail=True),
        Figure("axial_stiffness", "N/m", "Stiffness of each line along itself.", _if_balanced("stiffness.axial"),
               digits=5, along="line"),
        Figure("line_frequencies", "Hz", "Lowest sideways frequency of each free span, ends held.",
               _if_balanced("line_frequencies"), "sideways frequency", 5, along="line"),
        Figure("asymmetry", "1", "Largest asymmetric part of the stiffness between two modes, relative to theirs.",
               _if_balanced("asymmetry"), detail=True),
        Figure("notes", "", "Warnings about the modes.", detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("status", "robot", "frequencies")
    ROWS: ClassVar = "mode"

    equilibrium: Equilibrium
    stiffness: Stiffness
    geometric: bool  # whether the geometric part was counted
    frequencies: Array
    shapes: Array
    participation: Array
    asymmetry: Array
    elastic_share: Array
    inextensible: Array

    @property
    def single(self) -> bool:
        """Whether the modes are of one equilibrium, not of a batch of them."""
        return self.equilibrium.single

    def __len__(self) -> int:
        """The number of equilibria of a batch. Raises `TypeError` for a single one."""
        return len(self.equilibrium)

    @property
    def has_modes(self) -> bool:
        """Whether natural frequencies exist: any pose is in equilibrium."""
        return bool(np.isfinite(self.frequencies).any())

    @property
    def freedoms(self) -> tuple[str, ...]:
        """Names of the platform's degrees of freedom."""
        return FREEDOMS[: self.equilibrium.model.n]

    @property
    def damping(self) -> Damping:
        """Damping ratio of every mode."""
        return self.equilibrium.model.robot.damping

    @property
    def notes(self) -> tuple[str, ...]:
        """A warning where lines vibrate at frequencies of the platform."""
        if not self.has_modes:
            return ()
        lowest = float(np.nanmin(self.line_frequencies, initial=np.inf))
        if not lowest < np.nanmax(self.frequencies):
            return ()
        return (f"lines vibrate sideways from {lowest:.2f} Hz; modes above that may couple with them",)

    @property
    def refusal(self) -> str:
        """Reason why a pose is not held; empty where all are."""
        held = self.equilibrium[None] if self.single else self.equilibrium
        good = held.holds
        return "" if good.all() else held[int(np.argmin(good))].sentence()

    @property
    def mostly(self) -> Any:
        """Names of the degrees of freedom with most energy: a list (n), or a list for each row of a batch."""
        return np.array(FREEDOMS)[self.dominant].tolist()

    @property
    def motion(self) -> Any:
        """The kind of each mode, "stretch" or "pendulum": a list (n), or a list for each row of a batch."""
        return np.where(np.nan_to_num(self.elastic_share) > 0.5, "stretch", "pendulum").tolist()

    @property
    def lowest(self) -> Array:
        """The lowest frequency, Hz: () for a single equilibrium, (N,) for a batch."""
        return np.asarray(self.frequencies[..., 0])

    @property
    def dominant(self) -> NDArray[np.int64]:
        """Index (n,) into `FREEDOMS` of the degree of freedom with the most energy in each mode."""
        return np.asarray(np.nan_to_num(self.participation).argmax(axis=-2))

    @property
    def line_frequencies(self) -> Array:
        """(m,) lowest transverse frequency of each free span between fixed ends, Hz; NaN for a cable without weight.

        That of a taut string, sqrt(T / mu) / 2 l, with the tension at mid-span. The modes do not contain it, as lines
        are massless springs there. Where it is close to a frequency of the platform, the two vibrate together.
        """
        lines, states, tensions = self.equilibrium.lines, self.equilibrium.line_states, self.equilibrium.tensions
        phi, free = states.free_angle, states.free_length
        densities = np.array([line.cable.linear_density for line in self.equilibrium.model.robot.lines])
        middle = np.hypot(tensions * np.cos(phi), tensions * np.sin(phi) + 0.5 * lines.weight * free)
        length = free * (1.0 + middle * lines.free_compliance)
        weighing = np.where(densities > 0.0, densities, np.nan)
        return np.asarray(np.sqrt(middle / weighing) / (2.0 * length))


def modes(
    robot: Robot | Model | Equilibrium,
    poses: ArrayLike | None = None,
    *,
    geometric: bool = True,
    retraction: ArrayLike | None = None,
    preferred: ArrayLike | None = None,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
) -> Modes:
    """Compute natural frequencies and modes of the platform at *poses*, (n,) or (N, n) m and rad, or an `Equilibrium`.

    Poses are solved by `inverse`, with its *retraction*, *preferred* tensions (used as they are where they balance
    within the limits) and laws. *geometric* False: only the elastic part of the stiffness counts, as in Jung 2020, Eq.
    16; a pendulum does not swing then. Lines are massless springs, winches stand still and there is no damping. An
    unstable equilibrium has negative frequencies; one that does not balance has NaN. Raises `InputError` for a body
    whose inertia is not known.

    Examples
    --------
    >>> import cablewright as cw
    >>> cw.modes(cw.load("jung2020"), [0.2, 0.1, 0.9]).mostly[0]
    'rz'
    """
    if isinstance(robot, Equilibrium):
        return _modes(robot, geometric)
    if poses is None:
        raise InputError("poses: a pose, or rows of poses, is expected")
    model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits)
    return _modes(solve_inverse(model, poses, retraction=retraction, preferred=preferred), geometric)


def _modes(equilibrium: Equilibrium, geometric: bool) -> Modes:
    """Modes of one equilibrium, or of each of a batch."""
    robot, n = equilibrium.model.robot, equilibrium.model.n
    parts = stiffness(equilibrium[None] if equilibrium.single else equilibrium)
    parts = parts[0] if equilibrium.single else parts
    root = np.concatenate([mass_root(robot, equilibrium.pose), counterweight_root(robot, parts)], axis=-2)
    whole = parts.total if geometric else parts.elastic
    good = np.asarray(np.isfinite(whole).all(axis=(-2, -1)))
    root = np.where(good[..., None, None], root, np.eye(*root.shape[-2:]))
    free = equilibrium.model.free_directions
    if free is None and root.shape[-2] > n:
        free = np.eye(n)
    if free is None:
        back = np.linalg.inv(root)
    else:  # motions of unit energy that are orthogonal in their energy, (..., n, degrees of freedom)
        moving, upper = np.linalg.qr(root @ free)
        back = free @ np.linalg.inv(upper)
    scaled = np.swapaxes(back, -1, -2) @ np.where(good[..., None, None], whole, 0.0) @ back  # (rad/s)^2
    mirrored = np.swapaxes(scaled, -1, -2)
    values, vectors = np.linalg.eigh(0.5 * (scaled + mirrored))
    values = np.where(np.abs(values) <= ROUNDING * np.abs(values).max(axis=-1, keepdims=True), 0.0, values)
    skew = _left_out(0.5 * (scaled - mirrored), values, vectors)
    elastic = np.swapaxes(back, -1, -2) @ np.where(good[..., None, None], parts.elastic, 0.0) @ back
    loosely = np.swapaxes(back, -1, -2) @ np.where(good[..., None, None], parts.geometric, 0.0) @ back
    shares = _diagonal(elastic, vectors), np.abs(_diagonal(loosely, vectors))
    free_swings = _swings(loosely, _lengths_kept(equilibrium, parts) @ back)
    if free is not None:
        back, vectors = back @ np.swapaxes(moving, -1, -2), moving @ vectors
    vectors = _pointed(vectors)
    arrays = (
        _hertz(values),
        back @ vectors,
        (vectors * vectors)[..., :n, :],
        skew,
        shares[0] / np.maximum(shares[0] + shares[1], 1e-300),
        free_swings,
    )
    return Modes(equilibrium, parts, geometric, *(_only(good, array) for array in arrays))


def _hertz(squares: Array) -> Array:
    """Frequencies, Hz, of squares, (rad/s)^2; negative where these are."""
    return np.asarray(np.sign(squares) * np.sqrt(np.abs(squares)) / (2.0 * np.pi))


def _diagonal(matrix: Array, vectors: Array) -> Array:
    """The quadratic form of a matrix (..., n, n) for each column of *vectors*."""
    return np.asarray(np.einsum("...ik,...ij,...jk->...k", vectors, matrix, vectors))


def _lengths_kept(equilibrium: Equilibrium, parts: Stiffness) -> Array:
    """The gradients (..., m, n) of the lengths of the lines on winches, by the platform's motion."""
    model = equilibrium.model
    held = [i for i in range(model.m) if i not in model.robot.hung]
    wrenches = along_chords(model.n, np.nan_to_num(parts.chords[..., held, :]), parts.arms[..., held, :])
    return np.asarray(projected(model.free_directions, wrenches))


def _swings(stiffness: Array, gradients: Array) -> Array:
    """Frequencies (..., n - m), Hz, of motions in which no length changes; *stiffness* is by unit modal mass."""
    rows = np.linalg.svd(gradients)[2][..., gradients.shape[-2] :, :]
    reduced = rows @ stiffness @ np.swapaxes(rows, -1, -2)
    return _hertz(np.linalg.eigvalsh(0.5 * (reduced + np.swapaxes(reduced, -1, -2))))


def _pointed(vectors: Array) -> Array:
    """Eigenvectors (..., n, n) with the sign that makes the largest entry of each column positive."""
    largest = np.abs(vectors).argmax(axis=-2)[..., None, :]
    signs = np.sign(np.take_along_axis(vectors, largest, axis=-2))
    return np.asarray(vectors * np.where(signs == 0.0, 1.0, signs))


def _left_out(skew: Array, values: Array, vectors: Array) -> Array:
    """Largest entry of the skew part between two modes, relative to the mean of their eigenvalues."""
    between = np.abs(np.swapaxes(vectors, -1, -2) @ skew @ vectors)
    means = 0.5 * (np.abs(values)[..., :, None] + np.abs(values)[..., None, :])
    none = between <= ROUNDING * np.abs(values).max(axis=-1)[..., None, None]
    shares = np.where(none, 0.0, between / np.where(none | (means == 0.0), 1.0, means))
    return np.asarray(np.where(~none & (means == 0.0), np.inf, shares).max(axis=(-2, -1)))


def _only(good: Mask, array: Array) -> Array:
    """*array* with NaN in the rows that are not *good*."""
    return np.where(good.reshape(good.shape + (1,) * (array.ndim - good.ndim)), array, np.nan)
