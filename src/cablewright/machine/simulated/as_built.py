"""A robot as built: its description with random deviations within the tolerances."""

from __future__ import annotations

import numpy as np

from cablewright.foundation.errors import InputError
from cablewright.machine.simulated.as_built_parts import RADII, drawn
from cablewright.machine.simulated.settings import Tolerances
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import KINDS, Line, Robot
from cablewright.robot.parameter_values import with_exit_point


def as_built(robot: Robot, tolerances: Tolerances, seed: int) -> Robot:
    """Return a random robot as built whose description could be *robot*; equal seeds yield equal robots.

    Each coordinate of an anchor (exit point; a winch exit stays on its vertical) and each sheave's radius has a normal
    error, each modulus and each winch drum's radius a uniform one. Raises `InputError` where a robot with these errors
    is impossible.
    """
    if seed < 0:
        raise InputError(f"seed = {seed}: must be a whole number from 0 on")
    random = np.random.default_rng([seed, 0])
    lines = tuple(_deviating(line, tolerances, random) for line in robot.lines)
    sizes = 1.0 + tolerances.drum_radius * drawn(seed, RADII).uniform(-1.0, 1.0, robot.m)
    sizes = sizes[WinchLines.of(robot).host]  # lines on one drum have one radius
    lines = tuple(_wound_on(line, size) for line, size in zip(lines, sizes.tolist(), strict=True))
    return robot.model_copy(update={"lines": lines})


def _wound_on(line: Line, size: float) -> Line:
    """*line* with a winch drum of that *size*, relative to the specified one."""
    radius = line.winch.drum_radius
    if radius is None or size == 1.0:
        return line
    return line.model_copy(update={"winch": line.winch.model_copy(update={"drum_radius": radius * size})})


def _deviating(line: Line, tolerances: Tolerances, random: np.random.Generator) -> Line:
    # every number is drawn whatever the tolerances are, so that changing one leaves the other errors as they are
    moved, radius, modulus = random.standard_normal(4), random.standard_normal(), random.uniform(-1.0, 1.0)
    x, y, z, rise = (tolerances.anchor * moved).tolist()
    a, b, c = line.exit_point
    built = with_exit_point(line, (a + x, b + y, c + z), rise)
    was, sheave = KINDS["sheave_radius"].value(line), KINDS["sheave_radius"]
    if was is not None:
        size = was + tolerances.sheave_radius * radius
        if not sheave.allows(size):
            raise InputError(
                f"sheave_radius = {tolerances.sheave_radius:g}: line {line.name!r} would have a sheave "
                f"without radius; give a smaller tolerance"
            )
        built = sheave.put(built, size)
    return KINDS["modulus"].put(built, 1.0 + tolerances.modulus * modulus)
