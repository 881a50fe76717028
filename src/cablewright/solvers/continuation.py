"""Tracking of one equilibrium as the lengths change, for a control loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, Status
from cablewright.foundation.units import LARGEST
from cablewright.kernels import Direct, continuation
from cablewright.kernels.certificates.system_enclosure import certificate_pool
from cablewright.kernels.layout import Code, Packed
from cablewright.kernels.statics import forward as kernel
from cablewright.kernels.statics import taut as straight
from cablewright.kernels.statics.equilibrium import workspace
from cablewright.models.packed_views import LineStates
from cablewright.models.statics import Equilibrium, Model
from cablewright.solvers.arguments import as_rows
from cablewright.solvers.forward import lengths_paid_out, solve_forward
from cablewright.solvers.taut import Taut, taut_of


@dataclass(frozen=True)
class TrackerSettings:
    """Tolerances of one step of a `Tracker`."""

    certify: bool = True
    """Whether each step is certified: exactly one equilibrium is within `tolerance`."""
    tolerance: float = 1e-9
    """Tolerance of the certificate, m and rad."""
    jump: float = 5e-3
    """Largest distance of a step's end from the linear prediction, m and rad; a longer step is divided."""
    fold: float = 1e-6
    """Smallest pivot of the stiffness, relative to its largest entry, below which the equilibrium is near a fold."""

    def __post_init__(self) -> None:
        """Raise `InputError` unless tolerance, jump and fold are positive."""
        for name in ("tolerance", "jump", "fold"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"{name} = {getattr(self, name):g}: over 0 is expected")


class Tracker:
    """One equilibrium, tracked from lengths to lengths, each step predicted by the linearisation and solved by Newton.

    A step stays on the equilibrium if its end is near the linear prediction and no dead span falls into a loop;
    otherwise it is divided, and the status is `Status.JUMPED` if that does not help. It is `Status.FOLD` near a fold
    and `Status.UNCERTIFIED` where the end cannot be certified; the certificate is about the end, not the path. With
    massless lines (elastic cables) a step is only solved: a jump to another equilibrium is not detected. Not safe for
    simultaneous use by two threads. `pose` (n,) and `states` (m, 6) are the last valid solution; `margin` is its
    smallest pivot, see `TrackerSettings.fold`.
    """

    def __init__(
        self,
        model: Model,
        lengths: ArrayLike,
        settings: TrackerSettings | None = None,
        begin: Equilibrium | None = None,
    ) -> None:
        """Start at the equilibrium of *lengths* (m,), m, or *begin*, one of them that is known.

        Raises `AnswerError` if none is found without a guess.
        """
        self.settings = settings or TrackerSettings()
        begin = solve_forward(model, lengths).checked() if begin is None else begin
        self.model = model
        self.pose = begin.pose.copy()
        self.states = begin.states.copy()
        self.margin = np.nan
        self._lengths = begin.lengths.copy()
        self._pulls: tuple[Array, Array] | None = None  # states, and the tensions of these
        self._packed = model.packed
        self._work = workspace(self._packed)
        self._pool: Array | None = None
        self._track, self._draw = Direct(continuation.follow), Direct(straight.draw)

    def step(self, lengths: ArrayLike) -> Status:
        """Track the equilibrium to *lengths* (m,), m. Unless the status is OK, the pose stays as it was.

        Raises `InputError` for lengths of the wrong count, not finite or not positive.
        """
        if not (isinstance(lengths, np.ndarray) and lengths.shape == self._lengths.shape and _are_sound(lengths)):
            rows, single = as_rows(lengths, self.model.m, "lengths", "m")
            if not single or not (rows > 0.0).all():
                raise InputError(f"lengths: {self.model.m} numbers over zero are expected, in m; got {rows.tolist()}")
            lengths = rows[0]
        given, pose, states = np.array(lengths, dtype=np.float64), self.pose.copy(), self.states.copy()
        code, margin = self._follow(given, pose, states)
        if code == Code.OK:
            self.pose, self.states, self.margin, self._lengths = pose, states, margin, given
            return Status.OK
        return Status.of(code)

    def change(self, packed: Packed) -> None:
        """Continue with *packed*, other numbers of the same robot, such as another load or retraction.

        The next step leads to their equilibrium.
        """
        self._packed = packed

    def restart(self, lengths: Array) -> bool:
        """Go to the equilibrium of *lengths* (m,), m, near the present pose; return whether there is one."""
        self._pulls = None  # states may have been loaded
        pose, states = self.pose.copy(), self.states.copy()
        code, _, _ = kernel.solve_near(self._packed, lengths, pose, states, self._work)
        if code == Code.OK:
            self.pose, self.states, self.margin, self._lengths = pose, states, np.nan, lengths.copy()
        return bool(code == Code.OK)

    @property
    def packed(self) -> Packed:
        """The arrays of the robot whose equilibrium is followed."""
        return self._packed

    @property
    def taut(self) -> Taut:
        """The lines, as if straight, at the last pose."""
        return taut_of(self._packed, self.pose, self._draw.call)

    @property
    def tensions(self) -> Array:
        """Tensions (m,) at the sheaves, N, of the last equilibrium."""
        if self._pulls is None or self._pulls[0] is not self.states:
            self._pulls = self.states, np.asarray(LineStates(self.states).tension)
        return self._pulls[1]

    @property
    def solved(self) -> Equilibrium:
        """The last followed equilibrium as a batch of one row."""
        batch = self._packed._replace(lines=self._packed.lines[None], platform=self._packed.platform[None])
        code, none = np.zeros(1, dtype=np.int64), np.zeros(1)
        lengths = lengths_paid_out(self.model, batch, self.states[None], self._lengths[None])
        return Equilibrium(self.model, batch, self.pose[None], lengths, self.states[None], code, none, code)

    def _follow(self, lengths: Array, pose: Array, states: Array) -> tuple[int, float]:
        """Code and margin of one step; *pose* and *states* are updated in place."""
        own, packed = self.settings, self._packed
        if self.model.massless:  # a slack line has no shape to linearise
            (code, _, _), margin = kernel.solve_warm(packed, lengths, pose, states, self._work), np.nan
        else:
            code, margin = self._track.call(
                packed, self._lengths, lengths, pose, states, own.jump, own.fold, self._work
            )
        if own.certify and code == Code.OK:
            if self._pool is None:
                self._pool = certificate_pool(packed)
            if not continuation.is_certified(packed, lengths, pose, states, own.tolerance, self._pool):
                code = Code.UNCERTIFIED
        return int(code), margin


def _are_sound(lengths: Array) -> bool:
    """Whether *lengths* (m,) are numbers over 0 that are not too large: most are, in a loop of control."""
    numbers = lengths.tolist()
    return lengths.dtype == np.float64 and 0.0 < min(numbers) <= max(numbers) <= LARGEST and sum(numbers) > 0.0
