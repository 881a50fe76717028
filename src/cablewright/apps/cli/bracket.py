"""`bracket`: stress in the brackets of the sheaves, on universal joints and with the second rotation blocked."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import Limits, OutputOptions, Pose, Retraction, RobotOptions
from cablewright.apps.cli.output import answer, progress, refused
from cablewright.apps.cli.parsing import check_suffix, pose_of, tension_limits
from cablewright.errors import EnvironmentFault, InputError
from cablewright.file_output import write_whole
from cablewright.models.fidelity import CableLaw


@dataclass(frozen=True, kw_only=True)
class BracketCommand:
    """The most stressed bracket as built, beside the same one in a design whose sheave only swivels.

    The answer is no (exit 1) if the bracket as built yields, or if the pose cannot be held. This command needs the
    optional dependencies "fem".
    """

    EXAMPLE: ClassVar = "bracket house-printer --at=-2.25,-6.75,13 --times 1"
    ANSWERS: ClassVar = ("studies.bracket:BracketStress",)

    robot: RobotOptions
    at: Pose = None
    job: Annotated[
        Path | None,
        typer.Option("--job", metavar="JOB", help="Job whose most stressed sample is taken, instead of --at."),
    ] = None
    workspace: Annotated[
        float | None,
        typer.Option(
            "--workspace",
            metavar="STEP",
            help="Step, m, of a grid over the workspace whose most stressed node is taken.",
        ),
    ] = None
    bracket: Annotated[
        Path | None, typer.Option("--bracket", metavar="FILE.toml", help="Bracket instead of the robot file's.")
    ] = None
    times: Annotated[
        int, typer.Option("--times", metavar="N", help="Mesh refinement, 1 or 2; 2 also estimates the error.")
    ] = 2
    sensitivity: Annotated[
        bool, typer.Option("--sensitivity", help="Also compute stresses with each assumed size a quarter off.")
    ] = False
    cable: Annotated[CableLaw, typer.Option("--cable", help="Cable law of the lines.")] = CableLaw.CATENARY
    tension_limits: Limits = None
    retraction: Retraction = None
    vtu: Annotated[
        Path | None, typer.Option("--vtu", metavar="FILE.vtu", help="Write displacement and stress for ParaView.")
    ] = None
    output: OutputOptions

    def run(self) -> int:
        """Compute the stresses, write what is requested, and print."""
        from cablewright.models.statics import Model
        from cablewright.printing.job import load_job

        self._check()
        limits = tension_limits(self.tension_limits)
        model = Model.of(self.robot.loaded(), cable=self.cable, tension_limits=limits)
        _require_fem(self.vtu is not None)
        from cablewright.studies.bracket import bracket

        pose = pose_of(self.at, model.robot)
        known = {"robot": model.robot.name, "pose": pose, "universal_joint": None, "conventional": None}
        with refused("infeasible", **known), progress() as show:
            found = bracket(
                model,
                pose if self.job is None else load_job(self.job),
                step=self.workspace,
                bracket=self.bracket,
                times=self.times,
                sensitivities=self.sensitivity,
                retraction=self.retraction,
                progress=show,
            )
        if self.vtu is not None:
            from cablewright.apps.report.bracket_vtu import vtu

            write_whole(self.vtu, vtu(found.designs))
        return answer(
            found, self.output.as_json, **self.output.write(found, f"Brackets of {model.robot.name}"), vtu=self.vtu
        )

    def _check(self) -> None:
        """Raise `InputError` unless the options go together."""
        check_suffix(self.vtu, "--vtu", ".vtu")
        if sum(given is not None for given in (self.at, self.job, self.workspace)) != 1:
            raise InputError("bracket: expected one of --at X,Y,Z, --job JOB and --workspace STEP")
        if self.at is None and self.retraction is not None:
            raise InputError("--retraction is for --at; a job's schedule sets it")


def _require_fem(writing: bool) -> None:
    """Raise `EnvironmentFault` where the extra is not installed."""
    for module in ("skfem", "meshio") if writing else ("skfem",):
        if find_spec(module) is None:
            raise EnvironmentFault("finite elements are an extra that is not installed: pip install cablewright[fem]")
