"""`equilibria`: every pose in which given lengths may hang."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import AsJson, Lengths, Retraction, RobotOptions, Seed, SheaveChoice
from cablewright.apps.cli.output import answer, progress, tell
from cablewright.apps.cli.parsing import numbers
from cablewright.errors import InputError

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
            help="Search the whole box of a point platform for others; loops in dead spans are not covered.",
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
            help="State of --exhaustive, from which the same command resumes; by default runs/equilibria-ROBOT.state.",
        ),
    ] = None,
    sheave: SheaveChoice = None,
    retraction: Retraction = None,
    as_json: AsJson = False,
) -> int:
    """Lines may be taut or slack, equilibria stable or not. They are found from many starts.

    The starts may miss some: `complete for` says what is proved.

    The answer is no (exit 1) if none is found, if a line is over its breaking load in every stable one, or if an
    exhaustive search is not finished.
    """
    model = cw.Model.of(robot.loaded(retraction), sheave=sheave)
    given, within = numbers(lengths, "--lengths") or [], numbers(box, "--box")
    if not exhaustive and (time_limit is not None or out is not None):
        raise InputError("--time-limit and --out: only with --exhaustive")
    found = cw.equilibria(model, given, box=within, starts=starts, seed=seed)
    return answer(_searched(found, within, out, time_limit) if exhaustive else found, as_json)


def _searched(
    found: cw.Equilibria, box: list[float] | None, out: Path | None, time_limit: float | None
) -> cw.Equilibria:
    """With what a search of the whole box adds."""
    from cablewright.studies.equilibria import search_all
    from cablewright.studies.store import folder_name

    file = out or Path("runs") / f"{folder_name('equilibria', found.solutions.model.robot.name)}.state"
    limit = TIME_LIMIT if time_limit is None else time_limit
    with progress() as show:
        every = search_all(found, box, file, time_limit=limit, progress=show)
    if not every.finished:
        tell(f"the search ended after {limit:g} s; {file} keeps its state, and the same command resumes it")
    return every
