"""The figures of an equilibrium: what JSON, terminal and reports say of one, or of a batch by rows."""

from __future__ import annotations

from operator import attrgetter, methodcaller
from typing import Any

from cablewright.results import Figure

__all__ = ["FIGURES"]


def _word(found: Any) -> str | list[str]:
    """What became of the solve, in the words of commands."""
    return found.status.word if found.single else [each.word for each in found.status]


FIGURES = (
    Figure("status", "status", "", "What became of the solve.", _word),
    Figure("robot", "robot", "", "Name of the robot.", attrgetter("model.robot.name")),
    Figure("cable", "cable", "", "Cable law.", attrgetter("model.fidelity.cable")),
    Figure("sheave", "sheave", "", "Sheave law; none where sheaves are as built.", attrgetter("model.fidelity.sheave")),
    Figure("pose", "pose", "m, rad", "Position and, of a body, rotation vector of the platform."),
    Figure("nozzle", "nozzle", "m", "Position of the point that prints."),
    Figure("lengths", "length", "m", "Unstrained lengths from winch exit to platform."),
    Figure("tensions", "tension", "N", "Tensions at the sheaves."),
    Figure("platform_tensions", "at platform", "N", "Tensions at the platform."),
    Figure("winch_tensions", "at winch", "N", "Tensions at the winches."),
    Figure("residual", "residual", "m", "Largest residual of the geometry.", methodcaller("residual_norm")),
    Figure("unbalanced_force", "unbalanced", "N", "Largest unbalanced force.", methodcaller("unbalanced_force")),
    Figure("margin", "margin", "N", "Smallest distance of a tension from its limits.", methodcaller("margin")),
    Figure("violation", "violation", "N", "How far an inverse solution breaks the limits; 0 of a forward one."),
)
