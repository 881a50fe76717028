"""`survey`: winch exits, sheave axes and walls from a total station's file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import typer

from cablewright.apps.cli.options import OutputOptions
from cablewright.apps.cli.output import answer, tell
from cablewright.errors import InputError
from cablewright.file_output import write_whole

if TYPE_CHECKING:
    from cablewright.calibration.survey.result import Survey as Surveyed


@dataclass(frozen=True, kw_only=True)
class SurveyCommand:
    """The frame has y along the west wall and x into the room, unless the plan says otherwise.

    Each result has its standard deviation, and markers that fit badly are marked.
    """

    EXAMPLE: ClassVar = "survey examples/survey.gsi --plan examples/survey.toml"
    ANSWERS: ClassVar = ("calibration.survey.result:Survey",)

    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="File of the total station: Leica GSI-8, GSI-16, or CSV.")
    ]
    plan: Annotated[
        Path | None,
        typer.Option(
            "--plan",
            metavar="PLAN.toml",
            help="What markers are on, the instrument's sigmas and the frame, where not default.",
        ),
    ] = None
    robot: Annotated[
        str | None,
        typer.Option("--robot", metavar="ROBOT", help="Robot whose lines the numbers of the markers count."),
    ] = None
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE.toml", help="Write the robot's file with the exit points that were found."),
    ] = None
    output: OutputOptions

    def run(self) -> int:
        """Evaluate the survey, write the robot, draw and print."""
        from cablewright.calibration.survey.survey import survey
        from cablewright.robot import load

        if self.out is not None and self.robot is None:
            raise InputError(f"--out = {str(self.out)!r}: there is no --robot whose exit points it could have")
        found = survey(self.file, self.plan, robot=None if self.robot is None else load(self.robot))
        self._write(found)
        return answer(found, self.output.as_json, robot=self.out, **self.output.write(found, "Survey"))

    def _write(self, found: Surveyed) -> None:
        """Write the robot as surveyed, and say what could not be taken over."""
        from cablewright.calibration.survey.result import surveyed
        from cablewright.robot import file_text, load, update

        if self.out is None or self.robot is None:
            return
        robot, notes = surveyed(load(self.robot), found)
        write_whole(self.out, update(file_text(self.robot), robot).encode())
        for note in notes:
            tell(f"note: {note}")
