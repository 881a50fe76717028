"""Entry point: one application, one place where errors become a line and an exit code."""

from __future__ import annotations

import errno
import io
import logging
import os
import signal
import sys
import traceback
from importlib import import_module
from types import FrameType
from typing import Annotated, Any, ClassVar

import typer
from typer.core import TyperCommand
from typer.exceptions import TyperException

from cablewright.foundation.errors import AnswerError, CablewrightError, InputError, one_line

COMMANDS = {
    "Model": {
        "show": ("show.show_command", "A robot to look at in a browser, alone or with a job, a run or a log."),
        "inverse": ("statics.inverse_command", "Lengths and tensions of the lines that hold the platform at a pose."),
        "forward": ("statics.forward_command", "Pose of the platform for given unstrained lengths."),
        "equilibria": (
            "statics.equilibria_command",
            "All equilibria of given unstrained lengths that a search finds.",
        ),
    },
    "Analyse": {
        "accuracy": ("accuracy.accuracy_command", "Position error of the nozzle under uncertain parameters."),
        "workspace": ("workspace.workspace_command", "Volume, boundary and slices of the workspace by a criterion."),
        "retraction": ("workspace.retraction_command", "Best retraction length of the end-effector at each height."),
        "modes": ("modes.modes_command", "Stiffness and natural frequencies of the platform on its lines."),
        "trade": ("trade.trade_command", "Workspace against lowest frequency while design parameters vary."),
        "design": ("design.design_command", "Exits, platform and limits with which a robot serves its part best."),
        "interference": (
            "interference.interference_command",
            "Distances of the lines from each other, platform, frame, part.",
        ),
        "bracket": ("bracket.bracket_command", "Stress in the brackets of the sheaves, by finite elements."),
    },
    "Calibrate": {
        "survey": (
            "calibration.room.survey_command",
            "Exit points, sheave axes and walls from a total station's markers.",
        ),
        "poses": ("calibration.poses.poses_command", "Poses to measure for a calibration."),
        "calibrate": (
            "calibration.calibrate.calibrate_command",
            "Exit points and home lengths from length changes at poses.",
        ),
        "simulate-calibration": (
            "calibration.calibrate.simulate_calibration_command",
            "Simulated measurements to try `calibrate` with.",
        ),
        "modulus": ("calibration.tensile.modulus_command", "Young's modulus of a cable from a tensile test."),
        "creep": ("calibration.tensile.creep_command", "Creep and stiffness of a cable from a test that holds a load."),
        "walls": (
            "calibration.room.walls_command",
            "Walls in a lidar's scan, and the lidar's place in a surveyed room.",
        ),
    },
    "Print": {
        "check": ("check.check_command", "Whether a robot can print a job, how far off, and the winch lengths for it."),
        "fit": ("fit.fit_command", "Whether a part fits a robot: where, turned how, how large, and what limits it."),
        "print": ("print_job.print_job_command", "Print a job closed-loop, on a simulated machine or on drives."),
        "campaign": ("campaign.campaign_command", "Print a job on many machines that the tolerances allow."),
        "simulate": ("simulate.simulate_command", "Drive a simulated machine along a path and log its sensors."),
        "drives": ("drives.command.drives_command", "Winches of a real machine on CANopen drives, or virtual ones."),
        "serve": ("serve.serve_command", "Watch and operate a machine in a browser, simulated or on drives."),
        "replay": ("simulate.replay_command", "Run the estimation on a log and compare it with the truth in it."),
    },
    "Tools": {
        "robots": ("robots.robots_command", "Robots of the library, or the file of one."),
        "new": ("robots.new_command", "Files of a robot of your own, from its size, layout, mass and cable."),
        "import": ("exchange.import_command", "A robot from a file of another program."),
        "export": ("exchange.export_command", "A robot, and a job, as files of another program."),
        "machines": ("simulate.machines_command", "Simulated machines of the library, or the file of one."),
        "schema": ("robots.schema_command", "JSON Schema of robot, job, machine and other files, for editors."),
        "warm": ("robots.warm_command", "Compile kernels now, rather than when a command needs them."),
        "curves": ("curves.curves_command", "Random closed curves to print, ranked by how well they cover an area."),
    },
}
"""Commands by group: the function that is each, in a module of `apps.cli`, and what it answers."""

INTERRUPTED, BAD_INPUT, ENVIRONMENT = 130, 2, 3
LOOK_AGAIN = 0.1  # s after an interruption: whether it is handled
NOT_COMPUTED = "cannot be computed with"
NO_ROBOT = "what follows from this input is no robot"
"""Words of errors that no file should cause; the fuzzer looks for them."""


class _Lazy(TyperCommand):
    """A command that is imported when it is run or its own help is shown."""

    home: ClassVar[str]

    def make_context(self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any) -> Any:
        """Parse with the real command."""
        return command(self.name or "").make_context(info_name, args, parent, **extra)


def command(name: str) -> TyperCommand:
    """The command called *name*. Raises `KeyError`."""
    from cablewright.apps.cli.command import command_of

    home, summary = next(commands[name] for commands in COMMANDS.values() if name in commands)
    module, function = home.rsplit(".", 1)
    return command_of(getattr(import_module(f"cablewright.apps.cli.{module}"), function), name, summary)


app = typer.Typer(
    name="cablewright",
    help="Models, checks, calibrates and simulates cable-driven parallel robots that print large parts.",
    epilog="`cablewright COMMAND --help` shows the options of a command and an example.",
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)
for _group, _commands in COMMANDS.items():
    for _name, (_, _summary) in _commands.items():
        app.command(_name, help=_summary, rich_help_panel=_group, cls=_Lazy)(lambda: None)


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
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and (stream.isatty() or stream is sys.stderr):
            stream.reconfigure(errors="replace")  # a terminal that knows no such letter shows something else
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(encoding="utf-8")  # files that are read again
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) != signal.SIG_IGN:  # a job in the background of a shell is asked by nobody
            signal.signal(number, _interrupt)
    if hasattr(signal, "SIGALRM"):
        signal.signal(signal.SIGALRM, _look_again)
        sys.unraisablehook = _without_lost_interrupts
    code = run(sys.argv[1:])
    _look_later(0.0)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # the answer is given; the interpreter, as it ends, would die of them
    try:
        sys.stdout.flush()
    except BrokenPipeError:  # whoever reads has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or the interpreter's last flush complains
        code = 0
    if code == INTERRUPTED:  # Python ends by the signal where that came in the exec of a text, as of dataclasses
        sys.stderr.flush()
        os._exit(code)
    sys.exit(code)


class _Interrupts:
    """The signal by which the person, or the system, has asked the program to end; 0: none did."""

    asked = 0


def _interrupt(number: int, frame: FrameType | None) -> None:
    _Interrupts.asked = number
    _look_later(LOOK_AGAIN)
    if not _is_in_llvm(frame):
        raise KeyboardInterrupt


def _look_again(_number: int, frame: FrameType | None) -> None:
    """Interrupt once more, unless that is being handled.

    It is lost in callbacks from C, where Python cannot raise, as LLVM's while it compiles, and in C code that catches
    everything, as in NumPy's imports.
    """
    _look_later(LOOK_AGAIN)
    error = sys.exc_info()[1]
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__context__
    if error is None and not _is_in_llvm(frame):
        raise KeyboardInterrupt


def _is_in_llvm(frame: FrameType | None) -> bool:
    """Whether *frame* is, or is called by, LLVM's wrapper: what is left half made there may end the process at once.

    The interruption is looked at again until it comes between two of its calls; where nobody looks again, never.
    """
    if not hasattr(signal, "setitimer"):
        return False
    while frame is not None:
        if str(frame.f_globals.get("__name__")).partition(".")[0] == "llvmlite":
            return True
        frame = frame.f_back
    return False


def _look_later(seconds: float) -> None:
    """Call `_look_again` after so many seconds; 0: never. Windows has no such clock."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, seconds)


def _without_lost_interrupts(lost: Any) -> None:
    """Say nothing of an interruption that is lost, which comes again, nor of what it left half made, as in LLVM."""
    if lost.exc_type is not KeyboardInterrupt and not _Interrupts.asked:
        sys.__unraisablehook__(lost)


def run(arguments: list[str]) -> int:
    """Run one command; returns its exit code. Errors become one line on stderr, with --debug a traceback too."""
    debug = "--debug" in arguments
    arguments = [argument for argument in arguments if argument != "--debug"]
    logging.basicConfig(format="%(message)s", level=logging.WARNING)
    logging.getLogger("cablewright").setLevel(logging.INFO)
    try:
        return _answered(arguments, debug)
    except Exception:
        if not _Interrupts.asked:
            raise
        _explain("interrupted", debug)  # a library made something else of the interruption
        return INTERRUPTED


def _answered(arguments: list[str], debug: bool) -> int:
    try:
        code = _called(arguments)
        if code == INTERRUPTED:
            _explain("interrupted", debug=False)
        return code
    except CablewrightError as error:
        if isinstance(error, AnswerError) and "--json" in arguments:
            from cablewright.apps.cli.output import print_refusal

            print_refusal(error)
        _explain(str(error), debug)
        return error.exit_code
    except (typer.Abort, KeyboardInterrupt):
        _explain("interrupted", debug)
        return INTERRUPTED
    except TyperException as error:
        _explain(" ".join(error.format_message().replace("Value error, ", "").split()), debug)
        return BAD_INPUT
    except SystemExit:  # typer's answer to a reader that has seen enough
        return 0
    except OSError as error:
        _explain(f"{error.filename or 'output'}: {error.strerror or error}", debug)
        return BAD_INPUT if error.errno == errno.ENAMETOOLONG else ENVIRONMENT
    except MemoryError:
        _explain("there is not enough memory for this", debug)
        return ENVIRONMENT


def _called(arguments: list[str]) -> int:
    """Call the command. What libraries raise for numbers that they cannot compute with becomes one of our errors."""
    try:
        return app(arguments, prog_name="cablewright", standalone_mode=False) or 0
    except _numeric_errors() as error:
        what = f"{type(error).__name__}: {error}"
        failed = AnswerError(f"the numbers of this input {NOT_COMPUTED} ({what}); --debug shows where")
        failed.known = {"status": "not-computed"}
        raise failed from error
    except _model_errors() as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise InputError(f"{NO_ROBOT}: {where}: {first['msg']}") from error


def _numeric_errors() -> tuple[type[Exception], ...]:
    """Errors of arithmetic: Python's, and NumPy's if it was imported at all."""
    numpy = sys.modules.get("numpy")
    return (ArithmeticError,) if numpy is None else (ArithmeticError, numpy.linalg.LinAlgError)


def _model_errors() -> tuple[type[Any], ...]:
    """Pydantic's error, if it was imported at all."""
    pydantic = sys.modules.get("pydantic")
    return () if pydantic is None else (pydantic.ValidationError,)


def _explain(line: str, debug: bool) -> None:
    _look_later(0.0)
    if debug:
        traceback.print_exc()
    typer.echo(f"cablewright: {one_line(line)}", err=True)
