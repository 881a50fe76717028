"""One scan of the vertical lidar: positions of its points by the estimate, and the mean height that some measure."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from cablewright.estimation.height import HeightSettings, tilted
from cablewright.estimation.kalman.lidar_update import noise_factor
from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import FilterState, MotionSince, moving_velocity
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.signals import Scan

CONE: Final = 70.0
"""Degrees from the drum's axis, within which ground is seen."""

GATE: Final = 3.0
"""Sigmas from the expected value, of points and heights."""


class VerticalTurn(NamedTuple):
    """The rays of one vertical lidar scan with an echo, and the platform's pose at each."""

    axis_cosine: Array  # (k,) cosine of each ray's angle from the drum's axis, downwards
    rays: Array  # (k, 3) unit, level, along the drum's axes
    points: Array  # (k, 3) m from B, level, along the drum's axes
    beams: Array  # (k, 3) m from the lidar, likewise
    yaw: Array  # (k,) rad
    gyro_time: Array  # (k,) s over which the gyro is integrated since
    rotation: Array  # (k, m) rad, of the winch drums since
    coasting_time: Array  # (k,) s without encoders since ...
    counted_time: Array  # (k,) ... and with them
    position: Array  # (k, 3) m, world, of B, by the estimate at ...
    estimate: Array  # ... (3,) m


def turn_of(
    state: FilterState, height: HeightSettings, scan: Scan, attitudes: Array, motion: MotionSince
) -> VerticalTurn:
    """Return the rays of one *scan* with an echo, by *attitudes* (k, 3), rad, of the platform and its *motion*."""
    x, y = np.array(height.axes)
    good = np.flatnonzero(np.isfinite(scan.ranges) & (scan.ranges > 0.0))
    angles = scan.angles[good]
    straight = np.cos(angles)[:, None] * x + np.sin(angles)[:, None] * y
    tilts = attitudes[good, 1:]
    rays = tilted(straight, tilts)
    place, turn = state.built.vertical_mount_error[:3], state.built.vertical_mount_error[3:]
    rays = rays + np.cross(turn, rays)
    beams = scan.ranges[good, None] * rays
    arms = tilted(np.broadcast_to(height.mount + place, rays.shape), tilts)
    yaw = state.attitude.yaw - state.attitude.gyro_yaw + attitudes[good, 0]
    gyro_time = state.attitude.last_imu_time - scan.times[good]
    return VerticalTurn(
        -straight[:, 2],
        rays,
        arms + beams,
        beams,
        yaw,
        gyro_time,
        motion.rotation[good],
        motion.coasting_time[good],
        state.motion.last_encoder_time - scan.times[good] - motion.coasting_time[good],
        state.motion.position - motion.displacement[good],
        state.motion.position.copy(),
    )


def moved(state: FilterState, turn: VerticalTurn) -> Array:
    """Return by how much (3,), m, updates and clock corrections have moved B at the rays of a scan."""
    return state.motion.position - turn.estimate - state.built.clock_error * moving_velocity(state)


def heights_of(state: FilterState, height: HeightSettings, turn: VerticalTurn) -> Array:
    """Return the heights (k,), m, above the floor of the points of a vertical scan."""
    place = turn.position + moved(state, turn)
    return np.asarray(
        place[:, 2] + turn.points[:, 2] - height.floor - float(state.built.range_bias[-1]) * turn.rays[:, 2]
    )


def places_of(state: FilterState, turn: VerticalTurn, chosen: Mask) -> Array:
    """Return the positions (j, 2), m, world, of the *chosen* points (k,) of a vertical scan, j of them."""
    c, s = np.cos(turn.yaw[chosen]), np.sin(turn.yaw[chosen])
    x, y, _ = turn.points[chosen].T
    away = np.stack([c * x - s * y, s * x + c * y], axis=1)
    return np.asarray((turn.position[chosen] + moved(state, turn))[:, :2] + away)


def range_sigma(settings: FilterSettings, height: HeightSettings) -> float:
    """Return the standard deviation, m, of the noise of one range."""
    return height.sigma or settings.height_bias_sigma


def mean_height(
    settings: FilterSettings, state: FilterState, height: HeightSettings, turn: VerticalTurn, good: Mask
) -> tuple[Array, Array]:
    """Return the Jacobian (1, n) of the mean height, m, of the *good* points, and its noise variance (1, 1), m^2."""
    lay, sigma = state.layout, range_sigma(settings, height)
    x, y, _ = turn.points[good].mean(axis=0).tolist()
    steep = turn.rays[good, 2]
    H = np.zeros((1, lay.size))
    H[0, lay.position][2] = 1.0
    H[0, lay.radii] = -state.hung.jacobian[2] * state.lines.radii * turn.rotation[good].mean(axis=0)
    coasting_time = float(turn.coasting_time[good].mean())
    H[0, lay.velocity][2] = -coasting_time
    H[0, lay.stretch] = -state.hung.jacobian[2] * turn.counted_time[good].mean()
    H[0, lay.attitude] = y, -x, 0.0
    H[0, lay.gyro_bias] = turn.gyro_time[good].mean() * H[0, lay.attitude]
    H[0, lay.range_bias.stop - 1] = -float(steep.mean())
    bx, by, _ = turn.beams[good].mean(axis=0).tolist()
    H[0, lay.vertical_mount] = 0.0, 0.0, 1.0, by, -bx, 0.0
    H[0, lay.clock] = -float(moving_velocity(state)[2])
    own = settings.height_sigma**2 + coasting_variance(settings, coasting_time)
    R = noise_factor(state) * np.array([[sigma**2 * float(steep @ steep) / len(steep) ** 2 + own]])
    return H, R


def level_sigma(state: FilterState) -> float:
    """Return the standard deviation, m, of the summed errors of a vertical ray: height, range bias and mount."""
    lay = state.layout
    below = [lay.position.start + 2, lay.range_bias.stop - 1, lay.vertical_mount.start + 2]
    return math.sqrt(max(0.0, float(state.P[np.ix_(below, below)].sum())))


def coasting_variance(settings: FilterSettings, coasting_time: float) -> float:
    """Return the variance, m^2, of B's position after a prediction without encoders over *coasting_time*, s."""
    return settings.velocity_noise**2 * coasting_time**3
