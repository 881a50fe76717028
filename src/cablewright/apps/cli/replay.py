"""`replay`: estimation run again on a machine's log, and its errors where the log has the truth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import OutputOptions
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import lasers
from cablewright.choices import ReplayName


@command("replay examples/merlet2023-loop.mcap --estimator both", "studies.replay:Replay", "studies.replay:Replays")
def replay_command(
    *,
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A machine's MCAP log, or the run folder of a print.")],
    estimator: Annotated[
        ReplayName,
        typer.Option(
            "--estimator",
            help="Chain of Merlet and Papegay 2023, Kalman filter of all sensors, or both beside each other.",
        ),
    ] = "paper",
    laser: Annotated[
        str | None,
        typer.Option(
            "--laser", metavar="WALL=D[,..]", help="Distances from B to walls at the start, measured by hand, m."
        ),
    ] = None,
    output: OutputOptions,
) -> int:
    """The estimation finds position, slack lines and winch drum radii from the sensors in the log alone.

    A log without the truth gives no errors. The answer is no (exit 1) if no step has a valid estimate.
    """
    from cablewright.studies.replay import Replays

    names = ("paper", "filter") if estimator == "both" else (estimator,)
    measured = lasers(laser)
    with progress() as show:
        each = [cw.replay(log, name, lasers=measured, progress=show) for name in names]
    found = each[0] if len(each) == 1 else Replays(tuple(each))
    return answer(found, output.as_json, **output.write(found, f"Replay of {log.name}"))
