"""Entry point of the command line: builds the application, and turns errors into one line and an exit code."""

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
        "show": ("show.show_command", "Show a robot in a browser, alone or with a job, a run or a log."),
        "inverse": ("statics.inverse_command", "Compute cable lengths and tensions from a pose."),
        "forward": ("statics.forward_command", "Compute the pose of the platform from cable lengths."),
        "equilibria": (
            "statics.equilibria_command",
            "Find all equilibria of given cable lengths.",
        ),
    },
    "Analyse": {
        "accuracy": ("accuracy.accuracy_command", "Compute the position error for uncertain parameters."),
        "workspace": ("workspace.workspace_command", "Compute volume, boundary and slices of the workspace."),
        "retraction": ("workspace.retraction_command", "Find the best retraction of the end-effector by height."),
        "modes": ("modes.modes_command", "Compute stiffness, natural frequencies and modes."),
        "trade": ("trade.trade_command", "Compare workspace and lowest frequency over designs."),
        "design": ("design.design_command", "Optimise exit points, platform and limits for a part."),
        "interference": (
            "interference.interference_command",
            "Compute distances between lines and obstacles.",
        ),
        "bracket": ("bracket.bracket_command", "Compute the stress in sheave brackets (finite elements)."),
    },
    "Calibrate": {
        "survey": (
            "calibration_commands.survey_and_walls.survey_command",
            "Compute exit points from markers of a total station.",
        ),
        "tags": ("calibration_commands.tags_and_camera.tags_command", "Write printable pages of tags for a camera."),
        "camera": (
            "calibration_commands.tags_and_camera.camera_command",
            "Find the lens of a camera from pictures of tags.",
        ),
        "poses": ("calibration_commands.poses.poses_command", "Choose the poses to measure for a calibration."),
        "calibrate": (
            "calibration_commands.calibrate.calibrate_command",
            "Estimate exit points and home lengths from data.",
        ),
        "simulate-calibration": (
            "calibration_commands.calibrate.simulate_calibration_command",
            "Simulate the measurements of a calibration.",
        ),
        "modulus": (
            "calibration_commands.tensile_tests.modulus_command",
            "Compute Young's modulus of a cable from a tensile test.",
        ),
        "vibration": ("vibration.vibration_command", "Compute the tension of a line from its natural frequency."),
        "creep": (
            "calibration_commands.tensile_tests.creep_command",
            "Compute creep of a cable from a test under load.",
        ),
        "walls": (
            "calibration_commands.survey_and_walls.walls_command",
            "Find walls in a lidar scan, and the lidar's position.",
        ),
    },
    "Print": {
        "check": ("check.check_command", "Check whether a robot can print a job, and how accurately."),
        "fit": ("fit.fit_command", "Find position, rotation and scale at which a part fits."),
        "stages": ("check.stages_command", "Find the fewest moves of the exit points for a tall part."),
        "print": ("print_job.print_job_command", "Print a job on a simulated machine or on drives."),
        "campaign": ("campaign.campaign_command", "Print a job on many simulated machines with tolerances."),
    },
    "Operate": {
        "simulate": ("simulate.simulate_command", "Simulate a machine along a path and log its sensors."),
        "drives": ("drives.command.drives_command", "Scan, enable, home and jog the drives of a machine."),
        "serve": ("serve.serve_command", "Operate a machine, simulated or real, in a browser."),
        "replay": ("simulate.replay_command", "Run the estimators on a log and report their errors."),
    },
    "Tools": {
        "robots": ("robots.robots_command", "List the robots of the library, or print one's file."),
        "new": ("robots.new_command", "Create the files of a new robot."),
        "import": ("exchange.import_command", "Convert a robot file of another program."),
        "export": ("exchange.export_command", "Write a robot or a job for another program."),
        "machines": ("simulate.machines_command", "List the machines of the library, or print one's file."),
        "schema": ("robots.schema_command", "Print the JSON Schema of a kind of file, for editors."),
        "warm": ("robots.warm_command", "Compile the numerical kernels before their first use."),
        "curves": ("curves.curves_command", "Draw random closed curves to print."),
    },
}
"""Commands by group: the function in a module of `apps.cli`, and the first line of the help."""

INTERRUPTED, BAD_INPUT, ENVIRONMENT = 130, 2, 3
LOOK_AGAIN = 0.1  # s after an interruption: whether it is handled
NOT_COMPUTED = "cannot be computed with"
NO_ROBOT = "what follows from this input is no robot"
"""Words of errors that no file should cause; the fuzzer looks for them."""


class _Lazy(TyperCommand):
    """A command that is imported when it is run or its own help is shown."""

    home: ClassVar[str]

    def make_context(self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any) -> Any:
        """Load the real command and parse its arguments."""
        return command(self.name or "").make_context(info_name, args, parent, **extra)


def command(name: str) -> TyperCommand:
    """Return the command called *name*. Raises `KeyError`."""
    from cablewright.apps.cli.command import command_of

    home, summary = next(commands[name] for commands in COMMANDS.values() if name in commands)
    module, function = home.rsplit(".", 1)
    return command_of(getattr(import_module(f"cablewright.apps.cli.{module}"), function), name, summary)


app = typer.Typer(
    name="cablewright",
    help="Model, check, calibrate, simulate and operate cable-driven parallel robots that print large parts.",
    epilog="`cablewright COMMAND --help` shows the options of a command and examples.",
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
        if signal.getsignal(number) != signal.SIG_IGN:  # a background job of a shell ignores it
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
    """Whether *frame* is, or is called by, LLVM's wrapper: an object left half made there may end the process.

    The interruption is looked at again until it comes between two of its calls; without another check, never.
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
    """Say nothing of an interruption that is lost, which comes again, nor of a half-made object, as in LLVM."""
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
        failed = AnswerError(
            f"the numbers of this input {NOT_COMPUTED} ({what}); change extreme values, or locate "
            f"the cause with --debug"
        )
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
