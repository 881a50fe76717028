"""The machine that was really built: its description, off by the tolerances."""

from __future__ import annotations

import numpy as np

from cablewright.errors import InputError
from cablewright.machine.simulated.settings import Tolerances
from cablewright.robot import KINDS, Line, Robot
from cablewright.robot.parameter_values import with_exit_point


def as_built(robot: Robot, tolerances: Tolerances, seed: int) -> Robot:
    """Return a robot that *robot* may be the description of: the same seed gives the same one.

    Each coordinate of an anchor (exit point; a winch exit stays on its vertical) and each sheave's radius is off by a
    normal law, each modulus by a uniform one. Raises `InputError` where a tolerance asks for an impossible robot.
    """
    if seed < 0:
        raise InputError(f"seed = {seed}: a whole number from 0 on is wanted")
    random = np.random.default_rng([seed, 0])
    lines = tuple(_off(line, tolerances, random) for line in robot.lines)
    return robot.model_copy(update={"lines": lines})


def _off(line: Line, tolerances: Tolerances, random: np.random.Generator) -> Line:
    # one draw of each number whatever the tolerances are, so that changing one leaves the others as they were
    moved, radius, modulus = random.standard_normal(4), random.standard_normal(), random.uniform(-1.0, 1.0)
    x, y, z, rise = (tolerances.anchor * moved).tolist()
    a, b, c = line.exit_point
    built = with_exit_point(line, (a + x, b + y, c + z), rise)
    was, sheave = KINDS["sheave_radius"].value(line), KINDS["sheave_radius"]
    if was is not None:
        size = was + tolerances.sheave_radius * radius
        if not sheave.allows(size):
            raise InputError(f"sheave_radius = {tolerances.sheave_radius:g}: leaves line {line.name!r} no sheave")
        built = sheave.put(built, size)
    return KINDS["modulus"].put(built, 1.0 + tolerances.modulus * modulus)
