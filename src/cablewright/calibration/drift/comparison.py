"""A calibration beside the one before it: which exit points moved by more than both sigmas explain.

Both are moved onto one another by the best translation and yaw, which encoders do not determine.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.drift.record import CalibrationRecord
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.judgement.suspects import Evidence, Explanation, Suspect, beside
from cablewright.calibration.poses.observability import azimuth_offsets, motions, open_freedoms
from cablewright.errors import InputError
from cablewright.models.rotation import wrap_angles

LEVEL: Final = 0.01
"""The share of comparisons that say that something moved though nothing did."""

_SHIFTS: Final = ("translation", "yaw")  # beginnings of their names
_ROUNDING: Final = 1e-8  # m: of numbers in a robot's file


def compared(found: Calibration, last: CalibrationRecord, level: float = LEVEL) -> Explanation:
    """Return what changed since the *last* calibration. Raises `InputError` where they have no unknown in common."""
    before = {(each.name, each.line): at for at, each in enumerate(last.values)}
    both = [
        (at, before[each.kind, each.line])
        for at, each in enumerate(found.unknowns)
        if each.name not in ("length_offset", "modulus") and (each.kind, each.line) in before
    ]
    if not both:
        raise InputError("the last calibration has no unknown in common with this one")
    new, old = (np.array(side) for side in zip(*both, strict=True))
    named = motions(found.alone)
    open_ones = set(open_freedoms(found.alone))
    free = [motion[new] for name, motion in named.items() if name.startswith(_SHIFTS) or name in open_ones]
    kept = beside(np.array(free).reshape(len(free), len(new)).T)
    change = found.values[new] - last.amounts[old]
    around = azimuth_offsets([found.unknowns[at] for at in new]) > 0.0
    change[around] = wrap_angles(change[around])  # the same zero a turn away
    spread = found.covariance[np.ix_(new, new)] + last.spread[np.ix_(old, old)]
    size = np.eye(kept.shape[1]) * _ROUNDING**2
    freedom = min(float(max(found.posterior.redundancy, 1)), last.freedom)
    suspects = list(_suspects(found, new, kept))
    return Evidence(kept.T @ change, kept.T @ spread @ kept + size, suspects, freedom).explained(level)


def _suspects(found: Calibration, which: Array, kept: Array) -> Iterator[Suspect]:
    """Yield what may have changed: each exit point, and each other unknown."""
    unknowns = [found.unknowns[at] for at in which.tolist()]
    points = [(each.name, each.line) for each in unknowns if each.axis is not None]
    for name, line in dict.fromkeys(points):
        own = [at for at, each in enumerate(unknowns) if (each.name, each.line) == (name, line)]
        yield Suspect(name.replace("_", " "), line, kept[own].T, len(set(points)))
    alone = [at for at, each in enumerate(unknowns) if each.axis is None]
    for at in alone:
        yield Suspect(unknowns[at].name.replace("_", " "), unknowns[at].line, kept[[at]].T, len(alone))
