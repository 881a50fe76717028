"""Preferred tensions, near which inverse solutions stay where the limits let redundant lines hang slack.

The least norm then lies where lines carry nothing: their shapes are many, and the solution jumps between them.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.layout import Packed
from cablewright.kernels.wrench_feasibility import distribution
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.plane import within
from cablewright.models.statics import Model
from cablewright.solvers.row_threads import run

SLACK: Final = 1e-3
"""Share of the weight that each cable carries: a smaller minimum tension lets a line hang slack."""


def preferred_tensions(model: Model) -> Array | None:
    """Return the tensions (1, m), N, that solutions of *model* are nearest to by default; None: the least norm.

    Those of the model where it has some. Else they are for robots with more lines than degrees of freedom of which any
    line has a minimum tension of 0, or nearly. Where the lines can pull against each other in the middle of the frame:
    the middle of the limits of each line, as in Jung 2020, Eq. 8. Where they hang the platform, more tension in some
    lines slackens others: an equal share of its weight.
    """
    if model.preferred is not None:
        return np.array([model.preferred])
    share = _share(model)
    if model.m <= model.freedoms or (model.lines.tension_min > SLACK * share).all():
        return None
    if model.robot.sharing or model.robot.hung:
        return None
    if _pulls_against_itself(model):
        return np.asarray(model.lines.tension_limits.mean(axis=-1)[None])
    return np.full((1, model.m), share)


def preferred_note(tensions: Array | None) -> str:
    """Return the note that tensions are those nearest to preferred *tensions*, N; empty if these are None or 0."""
    if tensions is None or not tensions.any():
        return ""
    low, high = f"{tensions.min():.4g}", f"{tensions.max():.4g}"
    near = f"{low} N" if low == high else f"{low} to {high} N"
    return (
        f"tensions are those nearest to {near}, the preferred tension: the least ones would let lines hang slack, as "
        "tension_limits allow; a larger min in the robot file gives the least tensions above it"
    )


def _share(model: Model) -> float:
    """The weight by cable and span, N."""
    return model.robot.platform.mass * model.robot.scene.gravity / float(model.lines.pulls.sum())


@lru_cache(maxsize=32)
def _pulls_against_itself(model: Model) -> bool:
    """Whether straight lines have wrench closure in the middle of the frame."""
    straight = Model(model.robot, Fidelity(CableLaw.RIGID, model.fidelity.sheave))
    scene, m = model.robot.scene, model.m
    middle = np.add(scene.frame_min, scene.frame_max)[None] / 2.0
    pose = within(model.robot.platform.plane, straight.unrotated_at(middle))
    packed: Packed = straight.rows()
    codes = np.zeros(1, np.int64)
    arrays = (np.ones(m), np.zeros(m), np.zeros((1, m)), np.zeros(1), codes)
    run(distribution.distribute_rows, 1, packed, pose, distribution.CLOSURE, *arrays)
    return bool(codes[0] == 0)
