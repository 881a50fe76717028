"""`inverse`, `forward` and `equilibria`: from a pose to lengths, and from lengths to a pose or to all poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import (
    AsJson,
    LawOptions,
    Lengths,
    LengthsOrLog,
    Pose,
    Retraction,
    RobotOptions,
    Seed,
    SheaveChoice,
)
from cablewright.apps.cli.output import answer, compiling, progress, tell
from cablewright.apps.cli.parsing import lengths_of, numbers, pose_of, run_path, slack_excess
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Result
from cablewright.models.fidelity import CableLaw


@command("inverse merlet2023 --at 0,0,1", "studies.one_pose:SolvedPose", "studies.one_pose:SlackSets")
def inverse_command(
    *,
    robot: RobotOptions,
    at: Pose,
    laws: LawOptions,
    retraction: Retraction = None,
    slack: Annotated[
        str | None,
        typer.Option(
            "--slack",
            metavar="LINE=EXCESS[,LINE=EXCESS]",
            help="Slack lines, each by name or by number from 1, with its excess of length over a taut line, m.",
        ),
    ] = None,
    all_slack_sets: Annotated[
        bool, typer.Option("--all-slack-sets", help="List every set of lines that can be slack at this pose.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """All lines are taut if their limits allow it, unless --slack or --all-slack-sets is given.

    The answer is no (exit 1) if the lines cannot hold the pose, or if the pose violates a limit of the robot.
    """
    from cablewright.solvers.inverse import solve_inverse
    from cablewright.studies.one_pose import SlackSets, SolvedPose

    with compiling("inverse", "residuals"):
        model = cw.Model.of(robot.loaded(), **laws.laws())
        pose = pose_of(at, model.robot) or []
        if slack is not None and all_slack_sets:
            raise InputError("--slack and --all-slack-sets: give one of them, not both")
        if slack is None and not all_slack_sets:
            return answer(SolvedPose.judged(solve_inverse(model, pose, retraction=retraction)), as_json)
        if retraction is not None:
            model = replace(model, robot=model.robot.retracted(retraction))
        if slack is None:
            return answer(SlackSets(model, tuple(pose), cw.slack_sets(model, pose)), as_json)
        found = cw.solve_with_slack(model, pose, slack_excess(model.robot, slack))
        return answer(SolvedPose.judged(found, slack=True), as_json)


@command(
    "forward merlet2023 --lengths 10.43,10.43,10.43,10.43 --certify",
    "studies.one_pose:SolvedPose",
    "exchange.length_log:LoggedPoses",
)
def forward_command(
    *,
    robot: RobotOptions,
    lengths: LengthsOrLog,
    guess: Annotated[
        str | None,
        typer.Option("--guess", metavar="X,Y,Z[,RX,RY,RZ]", help="Pose from which the solver starts, m and rad."),
    ] = None,
    cable: Annotated[CableLaw, typer.Option("--cable", help="Cable law: elastic or catenary; rigid is an error.")] = (
        CableLaw.CATENARY
    ),
    sheave: SheaveChoice = None,
    modulus_factors: Annotated[
        str | None,
        typer.Option(
            "--modulus-factors",
            metavar="F1,..,Fm",
            help="Factors on the Young's modulus of the lines, one for each line.",
        ),
    ] = None,
    retraction: Retraction = None,
    certify: Annotated[
        bool,
        typer.Option(
            "--certify",
            help="Prove that exactly one equilibrium is near the solution, and print a bound on its distance.",
        ),
    ] = False,
    length_error: Annotated[
        str | None,
        typer.Option(
            "--length-error",
            metavar="D[,..,Dm]",
            help="Largest error of each line's length, m; prints a box that is proved to contain the pose for all "
            "such errors.",
        ),
    ] = None,
    budget: Annotated[
        int | None,
        typer.Option(
            "--budget", help="Maximum number of subdivisions for the box of --length-error; by default 20000."
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Lines may be slack. Without --guess the solver needs no start pose; of several equilibria it finds one.

    --lengths can be a CSV file: the log of a machine, or lengths.csv of a check, solved row by row.

    The answer is no (exit 1) if there is no equilibrium, if a cable would break, or if a requested proof fails.
    """
    from cablewright.solvers.forward import solve_forward
    from cablewright.studies.one_pose import SolvedPose

    with compiling("forward", "residuals", *(["certify"] if certify else [])):
        model = cw.Model.of(robot.loaded(), cable=cable, sheave=sheave)
        start = numbers(guess, "--guess")
        if lengths.lower().endswith(".csv"):
            single = {
                f"--modulus-factors = {modulus_factors}": modulus_factors,
                f"--retraction = {retraction}": retraction,
                f"--length-error = {length_error}": length_error,
                "--certify": certify or None,
            }
            return answer(_logged(model, Path(lengths), start, single), as_json)
        found = solve_forward(
            model,
            lengths_of(lengths, model.robot),
            guess=start,
            modulus_factors=numbers(modulus_factors, "--modulus-factors"),
            retraction=retraction,
        )
        proof = cw.certify(found) if certify else None
        box = _pose_box(found, length_error, budget) if length_error is not None and found.ok else None
        return answer(SolvedPose.reached(found, proof, box), as_json)


def _logged(model: cw.Model, file: Path, start: list[float] | None, single: Mapping[str, object]) -> Result:
    """Solve a file of lengths. Raises `InputError` if an option of a *single* set of lengths, by its text, is given."""
    from cablewright.exchange.length_log import forward_log, read_lengths

    for option, given in single.items():
        if given is not None:
            raise InputError(f"{option}: is only for one set of lengths, not for a file of several; leave it out")
    model.refuse_rigid()
    return forward_log(model, read_lengths(file, model.robot), start)


def _pose_box(found: cw.Equilibrium, length_error: str, budget: int | None) -> cw.PoseBox:
    """Where the pose is for all lengths within their error."""
    from cablewright.solvers.pose_hull import BUDGET

    errors = numbers(length_error, "--length-error") or []
    with progress() as show:
        return cw.enclose_poses(
            found, errors[0] if len(errors) == 1 else errors, budget=BUDGET if budget is None else budget, progress=show
        )


TIME_LIMIT = 600.0  # s


@command("equilibria merlet2023 --lengths 10.1187,9.3676,10.9961,11.3476", "solvers.equilibria:Equilibria")
def equilibria_command(
    *,
    robot: RobotOptions,
    lengths: Lengths,
    box: Annotated[
        str | None,
        typer.Option(
            "--box",
            metavar="X0,X1,Y0,Y1,Z0,Z1",
            help="Box in which the platform is, m; by default the frame and a quarter of its size beyond each side.",
        ),
    ] = None,
    starts: Annotated[
        int | None,
        typer.Option(
            "--starts",
            help="Number of random start poses for each pattern of upside-down levers; by default 12 for a point "
            "platform, 400 for a rigid one.",
        ),
    ] = None,
    seed: Seed = 0,
    exhaustive: Annotated[
        bool,
        typer.Option(
            "--exhaustive",
            help="Search the whole box for all equilibria of a point platform; loops in dead spans are not covered.",
        ),
    ] = False,
    time_limit: Annotated[
        float | None,
        typer.Option("--time-limit", metavar="S", help=f"Time limit of --exhaustive, s; by default {TIME_LIMIT:g}."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="FILE",
            help="File for the state of --exhaustive, from which the same command resumes; by default in runs/, "
            "named for the robot.",
        ),
    ] = None,
    sheave: SheaveChoice = None,
    retraction: Retraction = None,
    as_json: AsJson = False,
) -> int:
    """Lines may be taut or slack, equilibria stable or not. The search starts from many poses.

    It can miss some: `complete for` states the scope of the proof.

    The answer is no (exit 1) if none is found, if a line is over its breaking load in every stable one, or if an
    exhaustive search is unfinished.
    """
    model = cw.Model.of(robot.loaded(retraction), sheave=sheave)
    given, within = numbers(lengths, "--lengths") or [], numbers(box, "--box")
    if not exhaustive and (time_limit is not None or out is not None):
        raise InputError("--time-limit and --out: are only for --exhaustive; leave them out")
    found = cw.equilibria(model, given, box=within, starts=starts, seed=seed)
    return answer(_searched(found, within, out, time_limit) if exhaustive else found, as_json)


def _searched(
    found: cw.Equilibria, box: list[float] | None, out: Path | None, time_limit: float | None
) -> cw.Equilibria:
    """Return the *found* equilibria and all others in the *box*, by an exhaustive search that *out* keeps."""
    from cablewright.studies.equilibria import search_all

    file = run_path(out, "equilibria", found.solutions.model.robot.name, suffix=".state")
    limit = TIME_LIMIT if time_limit is None else time_limit
    with progress() as show:
        every = search_all(found, box, file, time_limit=limit, progress=show)
    if not every.finished:
        tell(f"the search ended after {limit:g} s; {file} keeps its state, and the same command resumes it")
    return every
