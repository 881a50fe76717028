"""The cable on a winch drum of a machine, from the machine file: as regular layers."""

from __future__ import annotations

import numpy as np

from cablewright.foundation.errors import InputError
from cablewright.machine.settings import WinchSettings
from cablewright.models.coil import TURN, Coil, wind
from cablewright.models.drum import drum_of
from cablewright.robot import Line, Robot


def coils_of(robot: Robot, settings: WinchSettings, seed: int | None = None, **walk: float) -> tuple[Coil | None, ...]:
    """Return the cable of each line on its drum, None where a counterweight hangs; raises as `coil_of`.

    The coils are regularly wound, or with random deviations *walk* by *seed*, see `coil_of`.
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

    Where the line's drum has a ``build_up``, radii follow that law, and not the *settings*' pitch.

    Raises `InputError` for a line without drum radius or cable diameter, or with more cable than its build-up allows.
    """
    if line.winch.drum_radius is None or line.cable.diameter is None:
        missing = "winch.drum_radius" if line.winch.drum_radius is None else "cable.diameter"
        raise InputError(
            f"line {line.name!r} has no {missing} in the robot file, which the model of the cable on "
            f"its winch needs: add it"
        )
    core, pitch, growth = line.winch.drum_radius, settings.pitch, 0.0
    drum = drum_of(line)
    if drum is not None and drum.build_up > 0.0:  # its radius is linear in its angle
        core, pitch = float(drum.radii(np.asarray(settings.held))), 0.0
        growth = TURN * drum.build_up * drum.radius**2
    return wind(
        settings.capacity,
        core,
        settings.width,
        line.cable.diameter,
        pitch,
        growth=growth,
        random=random,
        radius_walk=radius_walk,
        sideways_walk=sideways_walk,
        memory=memory,
    )
