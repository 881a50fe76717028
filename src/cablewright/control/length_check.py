"""Test of saved lengths: whether lengths and tensions of taut lines fit together at one pose.

The pose where the lengths meet best leaves residuals, of which only the part across all motions of the platform is
informative: with m lines and p degrees of freedom m - p numbers. With two or more, a wrong line shows by the residual
without it; with one, each line could be the wrong one, by another offset; with none, nothing can be tested. Lines on
one drum are wrong together; the length of a line with a counterweight is not counted, and says nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.plane import directions, within
from cablewright.models.rotation import moved
from cablewright.models.statics import Model
from cablewright.models.winch_lines import WinchLines
from cablewright.solvers.taut import given, taut_at

LIMIT: Final = 5e-3
"""Root of the sum of squares of the residuals, m, from which lengths do not fit: errors of a millimetre or two of the
exit points stay below it."""

_STEPS: Final = 60
_LONGEST: Final = 0.5  # m and rad of a step
_THERE: Final = 1e-7  # m and rad
_UNSEEN: Final = 0.02  # share of an offset's square that shows at least


@dataclass(frozen=True, eq=False)
class LengthCheck:
    """Result of a length check. ``pose``: (n,) m and rad, best fit. ``misfit``: m. ``suspects``: offsets, m, by winch.

    ``tested``: whether there are more counted lines than degrees of freedom.
    """

    pose: Array
    misfit: float
    suspects: dict[int, float]
    tested: bool

    @property
    def fits(self) -> bool:
        """Whether the check found no error of the lengths."""
        return self.misfit <= LIMIT

    def sentence(self, names: Sequence[str]) -> str:
        """Sentence on the error of the lengths, with numbers."""
        offsets = [f"{names[i]} by {1e3 * offset:+.0f} mm" for i, offset in self.suspects.items()]
        what = f"the lengths do not fit together: {1e3 * self.misfit:.0f} mm; at most {1e3 * LIMIT:g} are allowed"
        if len(offsets) == 1:
            return f"{what}; it is line {offsets[0]}"
        if offsets:
            return f"{what}; if one line is wrong, it is {' or '.join(offsets)}"
        return f"{what}; more than one line is wrong, or a tension"


def check_lengths(model: Model, lengths: Array, tensions: Array, guess: Array) -> LengthCheck | None:
    """Test whether unstrained *lengths* (m,), m, fit a pose at *tensions* (m,), N, near the pose *guess* (n,).

    Return None if the search for this pose fails. The pose of a platform in a plane is searched in that plane.
    """
    plane, winches = model.robot.platform.plane, WinchLines.of(model.robot)
    free, counted = directions(plane, model.n), winches.winch >= 0
    pose = within(plane, np.array(guess, dtype=np.float64))
    for _ in range(_STEPS):
        taut = taut_at(model, pose)
        if not np.isfinite(taut.toward).all():
            return None
        off = (lengths - lengths_at(model, pose, tensions))[counted]
        step = free @ np.linalg.lstsq(taut.per_motion[counted] @ free, off, rcond=None)[0]
        size = float(np.linalg.norm(step))
        pose = moved(pose, np.asarray(step * min(1.0, _LONGEST / max(size, _THERE)), dtype=np.float64))
        if size < _THERE:
            break
    else:
        return None
    off = (lengths - lengths_at(model, pose, tensions))[counted]
    motions = taut_at(model, pose).per_motion[counted] @ free
    across = np.eye(len(off)) - motions @ np.linalg.pinv(motions)
    rest = across @ off
    squared, suspects = float(rest @ rest), {}
    if math.sqrt(squared) > LIMIT:
        for i, turned in enumerate(winches.senses[:, counted]):
            seen, told = float(turned @ across @ turned), float(turned @ rest)
            if seen > _UNSEEN and squared - told**2 / seen <= LIMIT**2:
                suspects[i] = told / seen
    return LengthCheck(within(plane, pose), math.sqrt(squared), suspects, tested=len(off) > model.freedoms)


def lengths_at(model: Model, pose: Array, tensions: Array) -> Array:
    """Return unstrained lengths (m,), m, of lines to the platform at *pose* (n,), m and rad, with *tensions* (m,), N.

    With their stretch, a flat sag, springs, and compliant mounts, to first order.
    """
    taut, scene = taut_at(model, pose), model.robot.scene
    cables = [line.cable for line in model.robot.lines]
    stiff = np.array([cable.stiffness for cable in cables])
    weight = scene.gravity * np.array([cable.linear_density for cable in cables])
    pull = np.maximum(tensions, 1.0)
    level = taut.free * np.cos(taut.angles)
    sag = model.lines.spans * (weight * level) ** 2 * taut.free / (24.0 * pull**2)
    soft = given(model.lines, taut) + model.lines.spring
    return np.asarray(taut.lengths / (1.0 + tensions / stiff) + sag - soft * tensions)
