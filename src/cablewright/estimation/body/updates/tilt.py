"""Correction of the estimate by the direction of gravity, from the accelerometer of the inertial unit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, Self

import numpy as np

from cablewright.estimation.body.updates.update import OF_MEDIAN, HeldBody, Slopes, Update, UpdatePart, middle
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Inertial, Reading
from cablewright.models.rotation import matrix_of

if TYPE_CHECKING:
    from cablewright.estimation.body.estimated_constants import BodyLayout
    from cablewright.estimation.body.settings import BodySettings
    from cablewright.estimation.body.state import BodyState

_LEAST: Final = 1e-4  # m/s^2 and rad: no unit is known better
_SHAKING_TIME: Final = 1.0  # s over which the platform's swing is watched
_SUDDEN: Final = 0.2  # share of one change of the specific force that counts immediately
UPWARD: Final = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
"""What a turn in space does to the upward unit vector as the platform sees it, in world axes."""


@dataclass(frozen=True)
class Tilt(Update):
    """The accelerometer: standard deviations of noise and bias, m/s^2, and of its mounting's rotation, rad."""

    READING: ClassVar[type[Reading]] = Inertial

    deviation: float
    bias: float
    turn: float

    @classmethod
    def told(cls, source: str, sheet: Any) -> Self:
        given = (sheet.acceleration_deviation, sheet.acceleration_bias, sheet.turn_deviation)
        return cls(*(max(each, _LEAST) for each in given))

    def read(self, settings: BodySettings, state: BodyState, reading: Reading) -> Array | None:
        """Return the two accelerations along x and y of the platform; see `Update.read`.

        The swing is recorded.
        """
        assert isinstance(reading, Inertial)  # its kind
        force = reading.acceleration
        size = math.sqrt(float(force @ force))
        if not size > 0.0:
            return None
        _shake(state, force, reading.time)
        return force[:2] / size

    def shown(self, there: HeldBody) -> Array:
        return np.asarray(matrix_of(there.pose[3:])[2, :2])

    def as_known(self, state: BodyState, shown: Array) -> Array:
        return shown + state.belief.unknowns[state.layout.tilt]

    def set_prior(self, settings: BodySettings, layout: BodyLayout, variances: Array) -> None:
        variances[layout.tilt] = self.turn**2 + (self.bias / settings.model.robot.scene.gravity) ** 2

    def part(
        self, settings: BodySettings, state: BodyState, slopes: Slopes, read: Array, acceleration: float
    ) -> UpdatePart:
        layout, gravity = state.layout, settings.model.robot.scene.gravity
        by_turn = (matrix_of(state.pose[3:]).T @ UPWARD)[:2]
        gradients = by_turn @ slopes.pose[3:] @ state.belief.gradients
        gradients[:, layout.tilt] = np.eye(2)
        gradients[:, layout.load] = by_turn @ slopes.pose_by_wrench[3:]
        each = ((self.deviation**2) * OF_MEDIAN / len(read) + acceleration**2) / gravity**2
        return UpdatePart(middle(read), gradients, each * np.eye(2), np.arange(2))


def _shake(state: BodyState, force: Array, now: float) -> None:
    """Follow the mean of the specific force, and how much it changes: a platform that swings."""
    if state.motion.force is None:
        state.motion.force, state.motion.time = force.copy(), now
        return
    share = min(1.0, (now - state.motion.time) / _SHAKING_TIME)
    state.motion.time = now
    change = force - state.motion.force
    state.motion.force = state.motion.force + share * change
    size = float(change @ change)
    state.motion.shaking = max(state.motion.shaking + share * (size - state.motion.shaking), _SUDDEN * size)
