"""Tensions that control holds where lines are redundant: a print chooses them, and a check judges them."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array, Indices
from cablewright.models.statics import Model
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.preferred_tensions import preferred_tensions

PREFERRED: Final = 2.5
"""Tensions, as multiples of the least that is to be kept, to which those of a rigid platform stay near."""

_SAMPLES: Final = 400  # places of a path at which tensions are judged
_MARGINS: Final = (1.0, 0.75, 0.5, 0.35, 0.25, 0.15, 0.1, 0.05, 0.0)  # of the least tension, kept above it
_TAUT: Final = 0.1  # of the range of tensions, kept above the least in a plane, where lines pull against each other
_PRESSED: Final = 0.5  # of the least press on a plane that only pushes, as least tensions leave it, kept for motion
_BELOW: Final = 0.05  # of the range of tensions, kept below the largest


def chosen_rows(count: int) -> Indices:
    """Return indices of positions on a path of *count* positions at which tensions are judged: all, or 400 evenly."""
    return np.linspace(0, count - 1, min(count, _SAMPLES)).astype(np.int64)


def with_margin(
    model: Model,
    poses: Array,
    retraction: Array | None,
    above: Array | float = 0.0,
    below: Array | float = 0.0,
) -> tuple[Model, float]:
    """Return the model with tension limits narrowed as far as all *poses* (k, n) stay feasible.

    Inverse solutions of it are the tensions that control holds: the least ones within those limits, of a rigid platform
    those nearest to `PREFERRED` times the least. *above* the least and *below* the largest tension, (m,) N, is their
    reserve; the share of it that they get is returned, too. *retraction* (k,), m. As it is where lines are not
    redundant; the limits of a line with a counterweight, whose tension is given, stay as they are. On a plane that only
    pushes, at least half of the press under the least tensions remains.
    """
    robot = model.robot
    if robot.winches <= model.freedoms:
        return model, 0.0
    taut = 0.0 if robot.platform.plane is None else _TAUT
    low, high = np.array([line.tension_limits for line in robot.lines]).T
    wide, hung = high - low, np.isin(np.arange(robot.m), robot.hung)
    pressed = 0.0  # N
    if robot.platform.may_lift:
        pressed = -_PRESSED * float(np.max(solve_inverse(model, poses, path=True, retraction=retraction).plane_force))
    for share in _MARGINS:
        least = low + share * np.maximum(np.maximum(low, taut * wide), above)
        most = high - np.maximum(_BELOW * wide, share * np.asarray(below))
        least, most = np.where(hung, low, least), np.where(hung, high, most)
        if (least >= most).any():
            continue
        lines = [
            line.model_copy(update={"tension_limits": own})
            for line, own in zip(robot.lines, zip(least.tolist(), most.tolist(), strict=True), strict=True)
        ]
        narrow = _near(replace(model, robot=robot.model_copy(update={"lines": tuple(lines)})))
        held = solve_inverse(narrow, poses, path=True, retraction=retraction)
        if held.ok.all() and (not pressed > 0.0 or float(np.max(held.plane_force)) <= -pressed):
            return narrow, share
    return _near(model), 0.0


def _near(model: Model) -> Model:
    """Return the model of a rigid platform with preferred tensions, unless it has some by itself."""
    if model.n == 3 or preferred_tensions(model) is not None:
        return model
    return replace(model, preferred=tuple((PREFERRED * model.lines.tension_min).tolist()))
