"""The states of a robot along a path, each an equilibrium that is solved here: what the viewer's time slider shows."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.apps.web.states import States
from cablewright.arrays import Array, Indices
from cablewright.errors import Status
from cablewright.models.statics import Model
from cablewright.solvers.inverse import solve_inverse

MOST: Final = 300
"""States along a path."""


def chosen(count: int, time: Array | None = None, worst: int | None = None, most: int = MOST) -> Indices:
    """Return the samples, of *count*, that get a state: even in *time* (or by number), first, last and worst too."""
    if time is None or not np.isfinite(time).all() or count < 2 or time[-1] <= time[0]:
        at = np.linspace(0, count - 1, min(count, most)).round().astype(np.intp)
    else:
        at = np.searchsorted(time, np.linspace(time[0], time[-1], min(count, most))).clip(0, count - 1)
    extra = [] if worst is None else [worst]
    return np.unique(np.concatenate([at, [0, count - 1], extra]).astype(np.intp))


def states_along(
    model: Model,
    poses: Array,
    *,
    retraction: Array | None = None,
    tensions: Array | None = None,
    time: Array | None = None,
    worst: int | None = None,
) -> States:
    """Return states at some of *poses* (k, n), all at rest, with tensions nearest to *tensions* (k, m), N, if given.

    *retraction* (k,), m; *time* (k,), s. A pose that cannot be held has a note that says so.
    """
    at = chosen(len(poses), time, worst)
    preferred = None if tensions is None else np.where(np.isfinite(tensions[at]), tensions[at], 0.0)
    own = None if retraction is None else retraction[at]
    found = solve_inverse(model, poses[at], path=True, preferred=preferred, retraction=own)
    notes = tuple("" if code == 0 else f"Not in equilibrium here: {Status.of(int(code)).value}." for code in found.code)
    shown = int(np.searchsorted(at, worst)) if worst is not None else 0
    return States.held(
        found,
        None if tensions is None else tensions[at],
        times=None if time is None else time[at],
        samples=at,
        notes=notes if any(notes) else (),
        shown=shown,
    )
