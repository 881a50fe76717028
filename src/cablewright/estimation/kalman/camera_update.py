"""Update by a camera in the room: the position of B at the time of the picture, which shows the camera's errors too.

Encoders have measured how B moved since, so that a picture that arrives late counts at its own time.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.estimation.kalman.lidar_update import displacement_variance, gated_update
from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import FilterState, inflate_position, moving_velocity
from cablewright.foundation.signals import CameraPose

_DOUBTFUL: Final = 3  # rejections in a row after which B may be elsewhere, ...
_ELSEWHERE: Final = 0.01  # m, ... and how far
MOVED: Final = ("camera", "moved")  # fault that lasts: nothing shows whether the camera or B is elsewhere


def update(settings: FilterSettings, state: FilterState, reading: CameraPose) -> None:
    """Update by one *reading*; one that contradicts the state is reported."""
    camera = settings.machine.camera
    bounces = reading.time < state.motion.bounce_end  # as a refill makes the drum swing
    if camera is None or bounces or not (np.isfinite(reading.pose).all() and np.isfinite(reading.covariance).all()):
        return
    lay, J, m = state.layout, state.hung.jacobian, len(state.lines.radii)
    changes = state.change_since([reading.time])
    change, since = changes[0], state.displacement(changes)[0]
    position, coasted = state.motion.position - since, float(change[m + 3])
    velocity = np.concatenate([moving_velocity(state), np.zeros(3)])
    slopes = camera.slopes(position, velocity)[:3]
    H = np.zeros((3, lay.size))
    H[:, lay.position], H[:, lay.camera] = np.eye(3), slopes
    H[:, lay.radii] = -J * state.lines.radii * change[:m]
    H[:, lay.velocity] = -coasted * np.eye(3)
    H[:, lay.stretch] = -J * max(state.motion.last_encoder_time - reading.time - coasted, 0.0)
    R = camera.noise(reading, velocity)[:3, :3] + displacement_variance(settings, math.hypot(*since)) * np.eye(3)
    off = reading.pose[:3] - position - slopes @ state.mean.x[lay.camera]
    sentence = "its positions contradict the estimate: not used; was the camera, or a tag on the platform, moved?"
    if gated_update(state, "camera", H, off, R, ("camera", "gate"), sentence):
        state.judged.last_position_time = state.time
    elif state.judged.rejections["camera"] >= _DOUBTFUL and not settings.machine.lidars:
        inflate_position(state, _ELSEWHERE)
        what = "its positions contradicted the encoders: measure the position, mend what moved, and start again"
        state.monitor.report(*MOVED, what)
