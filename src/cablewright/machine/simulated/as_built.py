"""The machine that was really built: its description, off by the tolerances."""

from __future__ import annotations

from typing import Any

import numpy as np

from cablewright.errors import InputError
from cablewright.machine.simulated.settings import Tolerances
from cablewright.robot import Eyelet, Line, Robot

__all__ = ["as_built"]


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
    x, y, z = (float(c + tolerances.anchor * d) for c, d in zip(line.exit_point, moved, strict=False))
    changes: dict[str, Any] = {"exit_point": (x, y, z)}
    if line.winch_exit is not None:
        cx, cy, cz = line.winch_exit
        dx, dy = x - line.exit_point[0], y - line.exit_point[1]
        changes["winch_exit"] = (cx + dx, cy + dy, float(cz + tolerances.anchor * moved[3]))
    if not isinstance(line.sheave, Eyelet):
        size = line.sheave.radius + tolerances.sheave_radius * float(radius)
        if not size > 0.0:
            raise InputError(f"sheave_radius = {tolerances.sheave_radius:g}: leaves line {line.name!r} no sheave")
        changes["sheave"] = line.sheave.model_copy(update={"radius": size})
    changes["cable"] = line.cable.model_copy(update=_stiffness(line, 1.0 + tolerances.modulus * float(modulus)))
    return line.model_copy(update=changes)


def _stiffness(line: Line, factor: float) -> dict[str, float]:
    """The cable's key that a modulus times *factor* changes."""
    if line.cable.axial_stiffness is not None:
        return {"axial_stiffness": factor * line.cable.axial_stiffness}
    assert line.cable.young_modulus is not None  # the description sees to it
    return {"young_modulus": factor * line.cable.young_modulus}
