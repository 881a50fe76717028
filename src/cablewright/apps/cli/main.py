"""Entry point: one application, one place where errors become a line and an exit code."""

from __future__ import annotations

import logging
import sys
import traceback
from typing import Annotated

import typer
from typer.exceptions import TyperException

from cablewright.apps.cli import (
    accuracy,
    bracket,
    calibrate,
    check,
    curves,
    equilibria,
    interference,
    modes,
    modulus,
    poses,
    print_job,
    replay,
    retraction,
    robots,
    simulate,
    statics,
    survey,
    trade,
    walls,
    workspace,
)
from cablewright.errors import CablewrightError

app = typer.Typer(
    name="cablewright",
    help="Models, checks and simulates cable-driven parallel robots that print large parts.",
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command("accuracy")(accuracy.accuracy)
app.command("bracket")(bracket.bracket)
app.command("calibrate")(calibrate.calibrate)
app.command("check")(check.check)
app.command("curves")(curves.curves)
app.command("equilibria")(equilibria.equilibria)
app.command("forward")(statics.forward)
app.command("interference")(interference.interference)
app.command("inverse")(statics.inverse)
app.command("machines")(simulate.machines)
app.command("modes")(modes.modes)
app.command("modulus")(modulus.modulus)
app.command("poses")(poses.poses)
app.command("print")(print_job.print_job)
app.command("replay")(replay.replay)
app.command("retraction")(retraction.retraction)
app.command("robots")(robots.robots)
app.command("schema")(robots.schema)
app.command("simulate-calibration")(calibrate.simulate_calibration)
app.command("simulate")(simulate.simulate)
app.command("survey")(survey.survey)
app.command("trade")(trade.trade)
app.command("walls")(walls.walls)
app.command("workspace")(workspace.workspace)

INTERRUPTED, BAD_INPUT, ENVIRONMENT = 130, 2, 3


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
    _debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    if version:
        from importlib.metadata import version as installed

        typer.echo(f"cablewright {installed('cablewright')}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def main() -> None:
    """Run the command line; never returns."""
    sys.exit(run(sys.argv[1:]))


def run(arguments: list[str]) -> int:
    """Run one command; returns its exit code. Errors become one line on stderr, with --debug a traceback too."""
    debug = "--debug" in arguments
    arguments = [argument for argument in arguments if argument != "--debug"]
    logging.basicConfig(format="%(message)s", level=logging.WARNING)
    logging.getLogger("cablewright").setLevel(logging.INFO)
    try:
        code = app(arguments, prog_name="cablewright", standalone_mode=False) or 0
        if code == INTERRUPTED:
            _explain("interrupted", debug=False)
        return code
    except CablewrightError as error:
        _explain(str(error), debug)
        return error.exit_code
    except TyperException as error:
        _explain(" ".join(error.format_message().split()), debug)
        return BAD_INPUT
    except SystemExit:  # typer's answer to a reader that has seen enough
        return 0
    except OSError as error:
        _explain(f"{error.filename or 'output'}: {error.strerror or error}", debug)
        return ENVIRONMENT


def _explain(line: str, debug: bool) -> None:
    if debug:
        traceback.print_exc()
    typer.echo(f"cablewright: {line}", err=True)
