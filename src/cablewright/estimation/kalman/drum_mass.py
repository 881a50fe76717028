"""Change of the platform's mass as powder leaves or is refilled."""

from __future__ import annotations

import math
from typing import Final

from cablewright.estimation.kalman.line_update import update_jacobian
from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import FilterState, diagonal
from cablewright.kernels import Direct
from cablewright.kernels.filtering import predict as kernel

_SHARE: Final = 0.05  # of the weight, up to which lines' stiffnesses are as before
_MUCH: Final = 1e-3  # m in one step, after which B bounces
_BOUNCE: Final = 0.5  # s, of steps in which one can be seen
_MOST_PARTS: Final = 50
_SINK: Final = Direct(kernel.sink)


def weigh(settings: FilterSettings, state: FilterState, mass: float) -> None:
    """Set the platform's mass to *mass*, kg, and predict its motion: lines stretch, which no encoder measures.

    With K the stiffness of all lines at B, B moves by K^-1 times the change of weight. Much of it changes K: slack
    lines get taut. An error of the same share in each of many small changes is not counted: B is measured meanwhile.
    """
    before, state.motion.mass = state.motion.mass, mass
    if mass == before or state.taut is None:
        return
    parts = min(math.ceil(abs(mass - before) / (_SHARE * before)), _MOST_PARTS)
    part, (x, _, at) = float(before - mass) * settings.machine.tilt.gravity / parts, state.mean
    start, squared = state.motion.coasted[:3].copy() if parts > 1 else None, 0.0
    for _ in range(parts):
        squared = _SINK.call(
            x, state.P, at, state.hung.rising, state.taut.toward, part,
            float(settings.load_sigma) if start is None else 0.0, state.lines.loosened, state.motion.coasted,
        )  # fmt: skip
        if start is not None:
            update_jacobian(settings, state, at_once=True)
    if start is not None:
        sunk = state.motion.coasted[:3] - start
        squared = float(sunk @ sunk)
        diagonal(state.P)[state.layout.position] += settings.load_sigma**2 * squared
    if squared > _MUCH**2:
        state.motion.bounce_end, state.turns.extracted = state.time + (0.0 if state.has_long_steps else _BOUNCE), None
