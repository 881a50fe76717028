"""Declared figures (key, unit, words) of an equilibrium, or of a batch by rows, for JSON, terminal and reports."""

from __future__ import annotations

from typing import Any

from cablewright.foundation.errors import Status
from cablewright.foundation.results import Figure
from cablewright.models.batch_rows import by_row


def _in_plane(found: Any) -> bool:
    """Whether a plane carries the platform."""
    return found.model.robot.platform.plane is not None


def _turns_in_plane(found: Any) -> bool:
    """Whether a plane carries a body."""
    return _in_plane(found) and found.model.n == 6


FIGURES = (
    Figure(
        "status",
        "",
        "What became of the solve.",
        lambda found: by_row(lambda code: Status.of(code).word, found.judged_code),
    ),
    Figure("robot", "", "Name of the robot.", "model.robot.name"),
    Figure("cable", "", "Cable law.", "model.fidelity.cable"),
    Figure("sheave", "", "Sheave law; null where each sheave is as built.", "model.fidelity.sheave", detail=True),
    Figure("pose", "m, rad", "Position and, of a rigid platform, rotation vector of its origin.", digits=7),
    Figure("nozzle", "m", "Position of the nozzle, world.", digits=7, shown="m"),
    Figure(
        "lines",
        "",
        "Names of the lines.",
        lambda of: [line.name for line in of.model.robot.lines],
        "line",
        along="line",
    ),
    Figure("lengths", "m", "Unstrained lengths from winch exit to platform.", "", "length", 8, shown="m", along="line"),
    Figure("tensions", "N", "Tensions at the sheaves.", "", "tension", 6, shown="N", along="line"),
    Figure("platform_tensions", "N", "Tensions at the platform.", "", "at platform", 6, shown="N", along="line"),
    Figure("winch_tensions", "N", "Tensions at the winches.", "", "at winch", 6, shown="N", along="line"),
    Figure(
        "preferred_tensions",
        "N",
        "Tensions to which these are nearest, where the limits let redundant lines hang slack.",
        "lines.preferred_tension",
        "preferred",
        only=lambda of: bool(of.lines.preferred_tension.any()),
        shown="N",
        along="line",
    ),
    Figure("residual", "m", "Largest residual of the geometric equations.", "residual_norm", digits=2, shown="m"),
    Figure("unbalanced_force", "N", "Largest unbalanced force on the platform.", digits=2),
    Figure(
        "plane_force",
        "N",
        "Force of lines and loads on the plane along its normal. With the normal out of a board, negative presses on "
        "it; positive lifts off, which needs a guide.",
        only=_in_plane,
        shown="N",
    ),
    Figure(
        "plane_moments",
        "N m",
        "Moment of lines and loads on the plane about the platform's origin, world.",
        only=_turns_in_plane,
    ),
    Figure("margin", "N", "Smallest distance of a tension from its limits; negative where one is broken."),
    Figure("violation", "N", "How far an inverse solution breaks the limits; 0 of a forward one.", detail=True),
)
