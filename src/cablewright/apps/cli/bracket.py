"""`bracket`: stress in the brackets of the sheaves, on universal joints and with the second rotation blocked."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import Limits, OutputOptions, Pose, Retraction, RobotOptions
from cablewright.apps.cli.output import answer, progress, refused
from cablewright.apps.cli.parsing import check_suffix, pose_of, tension_range
from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.file_output import write_whole
from cablewright.models.fidelity import CableLaw


@command("bracket house-printer --at=-2.25,-6.75,13 --times 1", "studies.bracket:BracketStress")
def bracket_command(
    *,
    robot: RobotOptions,
    at: Pose = None,
    job: Annotated[
        Path | None, typer.Option("--job", metavar="JOB", help="Compute at the most stressed sample of this job.")
    ] = None,
    workspace: Annotated[
        float | None,
        typer.Option(
            "--workspace",
            metavar="STEP",
            help="Compute at the most stressed node of a grid over the workspace, with this step in m.",
        ),
    ] = None,
    bracket: Annotated[
        Path | None,
        typer.Option("--bracket", metavar="FILE.toml", help="TOML file that replaces the robot file's [bracket]."),
    ] = None,
    times: Annotated[
        int, typer.Option("--times", metavar="N", help="Mesh refinement, 1 or 2; 2 also estimates the stresses' error.")
    ] = 2,
    sensitivity: Annotated[
        bool,
        typer.Option("--sensitivity", help="Also compute the stresses with each assumed size changed by a quarter."),
    ] = False,
    cable: Annotated[
        CableLaw, typer.Option("--cable", help="Cable law of the lines, from which their tensions follow.")
    ] = CableLaw.CATENARY,
    tension_limits: Limits = None,
    retraction: Retraction = None,
    vtu: Annotated[
        Path | None,
        typer.Option("--vtu", metavar="FILE.vtu", help="VTU file to write for ParaView, with displacement and stress."),
    ] = None,
    output: OutputOptions,
) -> int:
    """The most stressed bracket as built, beside the same one in a design whose sheave only swivels.

    The answer is no (exit 1) if the bracket as built yields, or if the pose cannot be held. This command needs the
    optional dependencies "fem".
    """
    check_suffix(vtu, "--vtu", ".vtu")
    if sum(given is not None for given in (at, job, workspace)) != 1:
        raise InputError("bracket: expected one of --at X,Y,Z, --job JOB and --workspace STEP")
    if at is None and retraction is not None:
        raise InputError("--retraction is only for --at: a job's schedule sets the retraction; leave it out")
    model = cw.Model.of(robot.loaded(), cable=cable, tension_limits=tension_range(tension_limits))
    _require_fem(vtu is not None)

    pose = pose_of(at, model.robot)
    known = {"robot": model.robot.name, "pose": pose, "universal_joint": None, "conventional": None}
    with refused("infeasible", **known), progress() as show:
        found = cw.bracket(
            model,
            pose if job is None else cw.load_job(job),
            step=workspace,
            bracket=bracket,
            times=times,
            sensitivities=sensitivity,
            retraction=retraction,
            progress=show,
        )
    if vtu is not None:
        from cablewright.apps.report.bracket_vtu import vtu_file

        write_whole(vtu, vtu_file(found.designs))
    return answer(found, output.as_json, **output.write(found, f"Brackets of {model.robot.name}"), vtu=vtu)


def _require_fem(writing: bool) -> None:
    """Raise `EnvironmentFault` where the extra is not installed."""
    for module in ("skfem", "meshio") if writing else ("skfem",):
        if find_spec(module) is None:
            raise EnvironmentFault("finite elements are an extra that is not installed: pip install cablewright[fem]")
