"""Damping of a container that swings below a point platform: the point follows the container.

With the angle f of the swing, its rate w and the length L = g / w^2 of the pendulum, f'' + w^2 f = -x'' / L where the
platform is at x. If it moves at x' = 2 z w L f, then f'' + 2 z w f' + w^2 f = 0: it adds the share z of critical
damping. The mean angle of the last while is left out: it is that of a sensor, and the platform would drift by it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final, Self

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.control.point_velocity_step import calm

ADDED: Final = 0.1
"""Share of critical damping that is added. With a delay of 40 ms and a lag of 20 ms, seven times as much is stable."""

MOST_SPEED: Final = 0.03
"""Largest speed, m/s, at which the platform follows."""

_PERIODS: Final = 2.0  # of the swing, over which the mean is taken


@dataclass(frozen=True)
class SwingDamping:
    """A pendulum: ``rate``, rad/s, and ``length``, m; and the share of critical damping that is added to its own."""

    rate: float
    length: float
    added: float = ADDED

    @classmethod
    def of(cls, gravity: float, centre: float, gyration: float) -> Self:
        """Return the pendulum of a container whose mass *centre* is so far below the platform point, m.

        *gyration*: its radius of gyration, m.
        """
        length = (centre * centre + gyration * gyration) / centre
        return cls(math.sqrt(gravity / length), length)


@dataclass(eq=False)
class SwingState:
    """State of the swing damping, changed in place by `follow`.

    ``mean``: (2,) horizontal part of the container's axis, over the last while.
    """

    mean: Array = field(default_factory=lambda: np.full(2, np.nan))


def gains(settings: SwingDamping, dt: float) -> tuple[float, float]:
    """Return the arguments *share* and *faster* of `point_velocity_step.calm` for steps of *dt*, s."""
    share, faster = min(dt * settings.rate / (_PERIODS * math.tau), 1.0), 2.0 * settings.added * settings.rate
    return share, faster * settings.length


def follow(settings: SwingDamping, state: SwingState, rotation: Array, dt: float) -> Array:
    """Return the velocity (3,), m/s, of the point that follows a container of *rotation* (3,), rad, for *dt*, s."""
    return np.array([*calm(rotation.copy(), state.mean, *gains(settings, dt), MOST_SPEED), 0.0])
