"""Following one equilibrium as lengths change: what a control loop holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cablewright.arrays import Array
from cablewright.errors import InputError, Status
from cablewright.kernels import continuation
from cablewright.kernels.certificates.krawczyk import CERTIFIED, certify
from cablewright.kernels.certificates.system_enclosure import certificate_pool, unfold
from cablewright.kernels.layout import Code
from cablewright.kernels.statics import forward as kernel
from cablewright.kernels.statics.equilibrium import workspace
from cablewright.models.statics import Model
from cablewright.solvers.arguments import as_rows
from cablewright.solvers.forward import solve_forward


@dataclass(frozen=True)
class TrackerSettings:
    """What a step of a `Tracker` has to hold to."""

    certify: bool = True
    """Whether each step is certified: that exactly one equilibrium is there, within `tolerance`."""
    tolerance: float = 1e-9
    """How near the equilibrium has to be, m and rad."""
    jump: float = 5e-3
    """How far the end of a step may be from what the linearisation says, m and rad; else the step is cut in parts."""
    fold: float = 1e-6
    """Least pivot of the stiffness, as a share of its largest entry, under which the equilibrium is about to vanish."""

    def __post_init__(self) -> None:
        """Refuse what is no bound."""
        for name in ("tolerance", "jump", "fold"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"{name} = {getattr(self, name):g}: over 0 is wanted")


class Tracker:
    """One equilibrium, followed from lengths to lengths, each step by the linearisation and then Newton.

    A step is held to be on the same equilibrium while its end is near what the linearisation says and no dead span
    falls into a loop; else it is cut in parts, and `Status.JUMPED` where that does not help. `Status.FOLD` comes near a
    fold, `Status.UNCERTIFIED` where the end cannot be certified; the certificate is of the end, not of the way. With
    massless lines (elastic cables) a step is only solved: nothing guards against another equilibrium. Not for use by
    two threads at once. `pose` (n,) and `states` (m, 6) are the last sound solution; `margin` its least pivot, see
    `settings.fold`.
    """

    def __init__(self, model: Model, lengths: ArrayLike, settings: TrackerSettings | None = None) -> None:
        """Begin at the equilibrium of *lengths* (m,), found cold. Raises `AnswerError` where there is none."""
        begin = solve_forward(model, lengths).checked()
        self.model = model
        self.settings = settings or TrackerSettings()
        self.pose = begin.pose.copy()
        self.states = begin.states.copy()
        self.margin = np.nan
        self._lengths = begin.lengths.copy()
        self._packed = model.packed
        self._work = workspace(self._packed)
        self._pool = certificate_pool(self._packed)

    def step(self, lengths: ArrayLike) -> Status:
        """Follow to *lengths* (m,), m. Unless the status is OK the pose stays as it was.

        Raises `InputError` for lengths of the wrong count, not finite or not positive.
        """
        rows, single = as_rows(lengths, self.model.m, "lengths", "m")
        if not single or not (rows > 0.0).all():
            raise InputError(f"lengths: {self.model.m} numbers over zero are wanted, in m; got {rows.tolist()}")
        pose, states = self.pose.copy(), self.states.copy()
        code, margin = self._follow(rows[0], pose, states)
        if code == Code.OK:
            self.pose, self.states, self.margin, self._lengths = pose, states, margin, rows[0]
            return Status.OK
        return Status.of(code)

    def _follow(self, lengths: Array, pose: Array, states: Array) -> tuple[int, float]:
        """Code and margin of one step; *pose* and *states* are improved in place."""
        settings, packed = self.settings, self._packed
        tolerance = settings.tolerance if settings.certify else 0.0
        if self.model.massless:
            return self._follow_massless(lengths, pose, states, tolerance), np.nan
        bounds = (settings.jump, settings.fold, tolerance)
        code, margin = continuation.follow(
            packed, self._lengths, lengths, pose, states, *bounds, self._work, self._pool
        )
        return code, margin

    def _follow_massless(self, lengths: Array, pose: Array, states: Array, tolerance: float) -> int:
        """As `_follow`, with massless lines: a slack one has no shape, to linearise or to certify."""
        code, _, _ = kernel.solve_warm(self._packed, lengths, pose, states, self._work)
        if code == Code.OK and tolerance > 0.0:
            pool = unfold(self._packed, self._pool)
            if certify(self._packed, lengths, pose, states, tolerance, pool) != CERTIFIED:
                return int(Code.UNCERTIFIED)
        return int(code)
