"""The picture of each result, which `Pictured.plot` draws."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Final

from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.foundation.file_output import write_whole
from cablewright.foundation.results import Pictured

PICTURES: Final = {
    "Calibration": ("calibration", "residuals_picture"),
    "Campaign": ("variants", "campaign_picture"),
    "CreepResult": ("tensile", "creep_picture"),
    "Curves": ("curves", "curves_picture"),
    "Designed": ("variants", "design_picture"),
    "InverseDynamics": ("dynamics", "dynamics_picture"),
    "Fit": ("fit", "fit_picture"),
    "Interference": ("interference", "interference_picture"),
    "JobInterference": ("interference", "interference_picture"),
    "MeasuredModes": ("modes", "swing_picture"),
    "Modes": ("modes", "modes_picture"),
    "BracketStress": ("bracket", "bracket_picture"),
    "Boundary": ("modes", "boundary_picture"),
    "Replay": ("simulation", "replay_picture"),
    "Replays": ("simulation", "replay_picture"),
    "RetractionStudy": ("workspace", "retraction_picture"),
    "Simulation": ("simulation", "simulation_picture"),
    "TensionComparison": ("wrench", "tensions_picture"),
    "Trajectory": ("dynamics", "trajectory_picture"),
    "WrenchPolytope": ("wrench", "polytope_picture"),
    "Trade": ("variants", "trade_picture"),
    "Workspace": ("workspace", "volume_picture"),
    "WorkspaceArea": ("workspace", "area_picture"),
    "Survey": ("survey", "survey_picture"),
    "TensileResult": ("tensile", "tensile_picture"),
    "Walls": ("survey", "walls_picture"),
}
"""The module of `apps.pictures` and the function in it that draw a result, by the name of its class."""


def draw(result: Pictured, file: str | Path | None = None) -> Figure:
    """Return the picture of *result*, and write it as PNG to *file* if one is given. Raises `EnvironmentFault`."""
    module, function = PICTURES[type(result).__name__]
    with style.drawing():
        drawn: Figure = getattr(import_module(f"cablewright.apps.pictures.{module}"), function)(result)
        if file is not None:
            write_whole(Path(file), style.png(drawn))
    return drawn
