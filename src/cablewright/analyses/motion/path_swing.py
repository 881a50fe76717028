"""Swing of a platform about its path, and the changes of tension, while the lengths are paid out.

A linear model follows the pose: mass matrix with counterweights, tangent stiffness of the full model, and a share of
critical damping in each mode. Lengths go linearly in time between samples, as winches do, so that the pose which they
hold at rest goes almost linearly too: between two samples the platform vibrates freely about it, and at each sample
the velocity jumps. This is solved exactly, mode by mode (`kernels/motion/swing.py`). Tensions follow from the motion,
with the sag that cables gain as they lose tension. Counterweights move with their cables as if these did not stretch.
Cables, sheaves and winches have no inertia, and winches follow without a lag.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Self

import numpy as np

from cablewright.analyses.motion.sag_correction import with_sag
from cablewright.foundation.arrays import Array, Mask
from cablewright.kernels.motion.swing import CARRIED, swing_rows
from cablewright.models.inertia import moving_masses, with_inertia
from cablewright.models.rotation import rotations, turn_between
from cablewright.models.statics import Equilibrium, Model
from cablewright.solvers.linearise import Linearisation, tension_changes
from cablewright.solvers.parameter_effects import at_nozzle

DEEP: Final = 0.05
"""Share of a tension up to which its fall is that by stiffness alone: sag then keeps less than a tenth of it."""


@dataclass(frozen=True, eq=False)
class SwingExtremes:
    """Largest effects of the swing up to each of b samples, and in its dwell, with m lines; zero where unknown."""

    tension_drop: Array  # (b, m) N, at most 0: the largest fall of the tension at the sheave
    tension_rise: Array  # (b, m) N, at least 0: the largest rise
    displacement: Array  # (b,) m, the largest of the nozzle from where it should be; NaN where it is not known
    frequency: Array  # (b,) Hz, of the mode with most of it; 0 at rest
    plane_rise: Array  # (b,) N, at least 0: what these changes together add at most to the force along a plane's normal

    def beside(self, changes: Array) -> Self:
        """Return the extremes for tensions at the centre of the swing that differ from those at rest (b, m), N."""
        drop, rise = self.tension_drop + np.minimum(changes, 0.0), self.tension_rise + np.maximum(changes, 0.0)
        return replace(self, tension_drop=drop, tension_rise=rise)


class PathSwing:
    """Simulation of the swing along a path that begins at rest, block by block.

    Each mode has the robot's share of critical damping. A body whose inertia is not known has that of `with_inertia`.
    """

    def __init__(self, model: Model) -> None:
        self._robot, self._free = with_inertia(model.robot), model.free_directions
        freedoms = model.n if self._free is None else self._free.shape[1]
        self._carried = np.zeros((CARRIED, freedoms))
        self._last: Array | None = None  # (n,) the pose before
        self._held = False  # whether it was held

    def take(
        self,
        held: Equilibrium,
        regular: Mask,
        linear: Linearisation,
        spent: Array,
        dwell: Array,
        compensated: Array | None = None,
    ) -> SwingExtremes:
        """Return the extremes at the next b samples of the path, *held* in its poses at rest.

        *regular* (b,): which are solved, with the *linear* behaviour there. *spent* (b,): s from the sample before.
        *dwell* (b,): s at the sample. *compensated* (b, 3): m/s^2, accelerations under whose forces the lengths hold
        the pose, where they do; then tensions are those under these forces.
        """
        rows, m = held.lengths.shape
        moves = self._moves(held.pose)
        fresh = ~np.concatenate([[self._held], regular[:-1]])[regular]
        self._held = bool(regular[-1])
        there, count = held[regular], int(regular.sum())
        mass, heavy = moving_masses(self._robot, there)
        pull = by_pose = tension_changes(there).by_pose
        point, tangent = self._at_nozzle(there), linear.stiffness
        offsets = np.zeros((count, held.model.n))
        if compensated is not None:
            forced = mass[..., :3] @ compensated[regular][:, :, None]
            offsets = linear.motion_under(forced)[..., 0]
        if (free := self._free) is not None:
            mass, tangent, heavy = free.T @ mass @ free, free.T @ tangent @ free, heavy @ free
            pull, point, moves, offsets = pull @ free, point @ free, moves @ free, offsets @ free
        drop, rise, codes = np.zeros((count, m)), np.zeros((count, m)), np.zeros(count, np.int64)
        displacement, frequency = np.zeros(count), np.zeros(count)
        arrays = (mass, tangent, point, pull, heavy, moves[regular], offsets, spent[regular], dwell[regular])
        state = fresh, self._robot.damping.ratio, self._carried
        swing_rows(
            *(np.require(each, requirements=("C", "W")) for each in arrays),
            *state,
            displacement,
            frequency,
            drop,
            rise,
            codes,
        )
        deep = (drop < -DEEP * there.tensions).any(axis=1)
        drop[deep] = with_sag(there[deep], by_pose[deep], drop[deep])
        unknown, still = np.full(rows, np.nan), np.zeros((rows, m))
        found = SwingExtremes(still, still.copy(), unknown, unknown.copy(), np.zeros(rows))
        found.displacement[regular], found.frequency[regular] = displacement, frequency
        found.tension_drop[regular], found.tension_rise[regular] = drop, rise
        found.plane_rise[regular] = _plane_rise(there, drop, rise)
        return found

    def _moves(self, poses: Array) -> Array:
        """The way (b, n) to each pose from the one before, m and rad; none to the first of the path."""
        before = np.concatenate([poses[:1] if self._last is None else self._last[None], poses[:-1]])
        self._last = poses[-1].copy()
        turned = turn_between(rotations(before), rotations(poses))
        return np.hstack([poses[:, :3] - before[:, :3], turned])[:, : poses.shape[1]]

    def _at_nozzle(self, held: Equilibrium) -> Array:
        """The motion (k, 3, n) of the nozzle per motion of the platform."""
        n = held.model.n
        return at_nozzle(held, np.broadcast_to(np.eye(n), (len(held.pose), n, n)))


def _plane_rise(held: Equilibrium, drop: Array, rise: Array) -> Array:
    """What changes of tensions together add at most (k,), N, to the force along the normal of a plane; 0 without."""
    plane = held.model.robot.platform.plane
    if plane is None:
        return np.zeros(len(drop))
    chords = held.lines.exit_point - held.platform_points
    across = held.lines.pulls * (chords @ np.array(plane.across)) / np.linalg.norm(chords, axis=2)
    return np.asarray(np.maximum(across * drop, across * rise).sum(axis=1))
