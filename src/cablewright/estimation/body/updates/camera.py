"""Pose of the platform by a camera in the room, late: the encoders' motion since the picture is added to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, Self

import numpy as np

from cablewright.estimation.body.updates.update import OF_MEDIAN, HeldBody, Slopes, Update, UpdatePart, middle
from cablewright.estimation.camera import ERRORS, KnownCamera
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import CameraPose, Reading
from cablewright.models.rotation import motion_between, moved

if TYPE_CHECKING:
    from cablewright.estimation.body.estimated_constants import BodyLayout
    from cablewright.estimation.body.settings import BodySettings
    from cablewright.estimation.body.state import BodyState

_STEP: Final = 1e-6  # rad, of a difference quotient


@dataclass(frozen=True)
class Seeing(Update):
    """A camera in the room: its readings are poses (6,), m and a rotation vector, rad."""

    READING: ClassVar[type[Reading]] = CameraPose
    UNKNOWNS: ClassVar[int] = ERRORS

    camera: KnownCamera

    def __post_init__(self) -> None:
        """Accept what the data sheet has accepted."""

    @classmethod
    def told(cls, source: str, sheet: Any) -> Self:
        return cls(KnownCamera.told(sheet))

    def read(self, settings: BodySettings, state: BodyState, reading: Reading) -> Array | None:
        """Return the pose (6,) that a reading shows, moved to now; see `Update.read`. The window keeps its noise."""
        assert isinstance(reading, CameraPose)  # its kind
        if not (state.judged.camera_used and np.isfinite(reading.pose).all() and np.isfinite(reading.covariance).all()):
            return None
        (then,) = state.motion.ways.at([reading.time])
        state.window.seen.append(self.camera.noise(reading, state.motion.velocity))
        return moved(reading.pose, motion_between(then, state.motion.way))

    def shown(self, there: HeldBody) -> Array:
        return there.pose

    def as_known(self, state: BodyState, shown: Array) -> Array:
        errors = state.belief.unknowns[state.layout.own[Seeing]]
        return moved(shown, self.camera.slopes(shown[:3], state.motion.velocity) @ errors)

    def set_prior(self, settings: BodySettings, layout: BodyLayout, variances: Array) -> None:
        variances[layout.own[Seeing]] = self.camera.sigmas**2

    def part(
        self, settings: BodySettings, state: BodyState, slopes: Slopes, read: Array, acceleration: float
    ) -> UpdatePart:
        layout, by_motion = state.layout, np.eye(6)
        for axis in range(3):  # a rotation vector by a rotation in space
            turned = moved(state.pose, _STEP * np.eye(6)[3 + axis])
            by_motion[3:, 3 + axis] = (turned - state.pose)[3:] / _STEP
        gradients = slopes.pose @ state.belief.gradients
        gradients[:, layout.load] = slopes.pose_by_wrench
        gradients[:, layout.own[Seeing]] = self.camera.slopes(state.pose[:3], state.motion.velocity)
        swing = slopes.pose_by_wrench[:, :3] * (settings.model.robot.platform.mass * acceleration)
        noise = np.mean(state.window.seen, axis=0) * (OF_MEDIAN if len(read) > 2 else 1.0) / len(read) + swing @ swing.T
        return UpdatePart(middle(read), by_motion @ gradients, by_motion @ noise @ by_motion.T, np.arange(6))
