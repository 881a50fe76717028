"""The cable on a winch drum of a machine, from what its owner knows: as layers that lie regularly."""

from __future__ import annotations

import numpy as np

from cablewright.foundation.errors import InputError
from cablewright.machine.settings import WinchSettings
from cablewright.models.coil import Coil, wind
from cablewright.robot import Line, Robot


def coils_of(robot: Robot, settings: WinchSettings, seed: int | None = None, **walk: float) -> tuple[Coil | None, ...]:
    """Return the cable of each line on its drum, None where a counterweight hangs; raises as `coil_of`.

    Regularly wound, or by *seed* with the deviations *walk* of `coil_of`.
    """
    randoms = (None if seed is None else np.random.default_rng([seed, 1, i]) for i in range(robot.m))
    return tuple(
        None if line.counterweight is not None else coil_of(line, settings, random=random, **walk)
        for line, random in zip(robot.lines, randoms, strict=True)
    )


def coil_of(
    line: Line,
    settings: WinchSettings,
    *,
    random: np.random.Generator | None = None,
    radius_walk: float = 0.0,
    sideways_walk: float = 0.0,
    memory: float = 1.0,
) -> Coil:
    """Return the cable of a *line* on its drum, regularly wound, or with the deviations of `wind` by *random*.

    Raises `InputError` for a line without drum radius or cable diameter, or with a build-up of its own.
    """
    if line.winch.drum_radius is None or line.cable.diameter is None:
        missing = "winch.drum_radius" if line.winch.drum_radius is None else "cable.diameter"
        raise InputError(f"line {line.name!r} gives no {missing}, which the cable on its winch needs")
    if line.winch.build_up is not None:
        raise InputError(f"line {line.name!r} gives winch.build_up; a machine file's [winch] has layers in its place")
    return wind(
        settings.capacity,
        line.winch.drum_radius,
        settings.width,
        line.cable.diameter,
        settings.pitch,
        random=random,
        radius_walk=radius_walk,
        sideways_walk=sideways_walk,
        memory=memory,
    )
