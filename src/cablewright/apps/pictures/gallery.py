"""Table of the picture of each result, drawn by `Pictured.plot`."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from matplotlib.figure import Figure

from cablewright.apps import style as look
from cablewright.apps.pictures.data_tables import table_of
from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import write_whole
from cablewright.foundation.results import Pictured

PICTURES: Final = {
    "Calibration": ("calibration", "residuals_picture"),
    "Campaign": ("variants", "campaign_picture"),
    "CreepResult": ("tensile", "creep_picture"),
    "Curves": ("random_curves", "curves_picture"),
    "Designed": ("variants", "design_picture"),
    "InverseDynamics": ("trajectory", "dynamics_picture"),
    "Fit": ("part_fit", "fit_picture"),
    "Guidance": ("calibration", "guidance_picture"),
    "Interference": ("interference", "interference_picture"),
    "JobInterference": ("interference", "interference_picture"),
    "LoopComparison": ("simulation", "loops_picture"),
    "MeasuredModes": ("modes", "swing_picture"),
    "Modes": ("modes", "modes_picture"),
    "BracketStress": ("bracket", "bracket_picture"),
    "Boundary": ("modes", "boundary_picture"),
    "Replay": ("simulation", "replay_picture"),
    "Replays": ("simulation", "replay_picture"),
    "RetractionStudy": ("workspace", "retraction_picture"),
    "Simulation": ("simulation", "simulation_picture"),
    "TensionComparison": ("wrench", "tensions_picture"),
    "Trajectory": ("trajectory", "trajectory_picture"),
    "WrenchPolytope": ("wrench", "polytope_picture"),
    "Trade": ("variants", "trade_picture"),
    "Workspace": ("workspace", "volume_picture"),
    "WorkspaceArea": ("workspace", "area_picture"),
    "Stages": ("stages", "stages_picture"),
    "Survey": ("survey", "survey_picture"),
    "TensileResult": ("tensile", "tensile_picture"),
    "Walls": ("survey", "walls_picture"),
}
"""The module of `apps.pictures` and the function in it that draw a result, by the name of its class."""


ONE_POSE: Final = ("Modes", "WrenchPolytope", "Interference")
"""Results that are drawn at one pose alone."""


def draw(
    result: Pictured,
    file: str | Path | None = None,
    *,
    width: float | str | None = None,
    style: str | Path | Mapping[str, Any] | None = None,
) -> Figure:
    """Return the picture of a *result*; write it and its data to *file*, if one is given: see `Pictured.plot`."""
    path, name = None if file is None else look.picture_file(file), type(result).__name__
    if name in ONE_POSE and not getattr(result, "single", True):
        raise InputError(f"plot: the picture of {name} is of one pose; take a row of the batch")
    module, function = PICTURES[name]
    with look.drawing(width, style):
        drawn: Figure = getattr(import_module(f"cablewright.apps.pictures.{module}"), function)(result)
        look.finish(drawn)
        if path is None:
            drawn.draw_without_rendering()  # ticks, which are made late, have this style too
        else:
            save(drawn, path)
    return drawn


def save(drawn: Figure, path: Path) -> None:
    """Write a picture in the format of its file ending, and its data as CSV. Raises `EnvironmentFault`."""
    write_whole(path, look.written(drawn, path.suffix.lower()))
    write_whole(path.with_name(f"{path.name}.csv"), table_of(drawn))
