"""`modes`: stiffness and natural frequencies of the platform at a pose, or along the boundary of a workspace."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import Geometric, OrientedRegionOptions, OutputOptions, Pose, RobotOptions, Tensions
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import pose_of
from cablewright.errors import InputError

OF_BOUNDARY = ("criterion", "box", "point", "orientations", "retraction_law")


@dataclass(frozen=True, kw_only=True)
class ModesCommand:
    """The platform swings on its lines as on springs without mass; winches stand still and nothing damps.

    Either at one pose, --at, or with --boundary at the outermost nodes of a grid over the workspace, with all modes
    at the pose whose lowest frequency is the lowest.
    """

    EXAMPLE: ClassVar = "modes jung2020 --at 0.2,0.1,0.9"
    ANSWERS: ClassVar = ("analyses.modes:Modes", "analyses.workspace.boundary_modes:Boundary")

    robot: RobotOptions
    at: Pose = None
    boundary: Annotated[
        bool, typer.Option("--boundary", help="Modes along the boundary of the workspace instead of at one pose.")
    ] = False
    geometric: Geometric = True
    grid: Annotated[
        int | None, typer.Option("--grid", metavar="N", help="With --boundary: nodes along each side; by default 21.")
    ] = None
    tensions: Tensions = None
    region: OrientedRegionOptions
    output: OutputOptions

    def run(self) -> int:
        """Find the modes, draw and print them."""
        from cablewright.analyses.modes import modes
        from cablewright.analyses.workspace.boundary_modes import GRID, boundary_modes

        if (self.at is None) != self.boundary:
            raise InputError("modes: give either --at X,Y,Z or --boundary")
        machine, given = self.robot.loaded(), self.region.as_arguments()
        if self.at is not None:
            self._refuse_boundary_options()
            laws = {key: given[key] for key in ("cable", "sheave", "tension_limits", "retraction")}
            found = modes(machine, pose_of(self.at, machine) or [], geometric=self.geometric, **laws)
            return answer(
                found, self.output.as_json, **self.output.write(found, f"Modes of {machine.name}", when=found.has_modes)
            )
        with progress() as show:
            along = boundary_modes(
                machine,
                self.region.criterion_name,
                grid=GRID if self.grid is None else self.grid,
                geometric=self.geometric,
                holding=self.tensions,
                progress=show,
                **given,
            )
        return answer(
            along, self.output.as_json, **self.output.write(along, f"Modes of {machine.name}", when=along.has_modes)
        )

    def _refuse_boundary_options(self) -> None:
        """Raise `InputError` for an option that only a boundary has."""
        given = {key: asdict(self.region)[key] for key in OF_BOUNDARY} | {"grid": self.grid, "tensions": self.tensions}
        for key, value in given.items():
            if value is not None:
                raise InputError(f"--{key.replace('_', '-')}: only with --boundary")
