"""The figures of an equilibrium: what JSON, terminal and reports say of one, or of a batch by rows."""

from __future__ import annotations

from typing import Any

from cablewright.results import Figure


def _word(found: Any) -> str | list[str]:
    """What became of the solve, in the words of commands."""
    return found.status.word if found.single else [each.word for each in found.status]


FIGURES = (
    Figure("status", "", "What became of the solve.", _word),
    Figure("robot", "", "Name of the robot.", "model.robot.name"),
    Figure("cable", "", "Cable law.", "model.fidelity.cable"),
    Figure("sheave", "", "Sheave law; none where sheaves are as built.", "model.fidelity.sheave"),
    Figure("pose", "m, rad", "Position and, of a body, rotation vector of the platform."),
    Figure("nozzle", "m", "Position of the point that prints."),
    Figure("lengths", "m", "Unstrained lengths from winch exit to platform."),
    Figure("tensions", "N", "Tensions at the sheaves."),
    Figure("platform_tensions", "N", "Tensions at the platform."),
    Figure("winch_tensions", "N", "Tensions at the winches."),
    Figure("residual", "m", "Largest residual of the geometry.", "residual_norm"),
    Figure("unbalanced_force", "N", "Largest unbalanced force on the platform."),
    Figure("margin", "N", "Smallest distance of a tension from its limits; negative where one is broken."),
    Figure("violation", "N", "How far an inverse solution breaks the limits; 0 of a forward one."),
)
