"""`simulate`, `machines` and `replay`: a simulated machine with imperfections, its log, and estimation on that log."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import typer

import cablewright as cw
from cablewright.apps.cli.command import command, options
from cablewright.apps.cli.options import AsJson, MachineName, OutputOptions, Plant, RobotName, Seed, Severity
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import check_suffix, lasers, numbers
from cablewright.apps.cli.robots import LibraryFile
from cablewright.foundation.choices import ReplayName
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Result

if TYPE_CHECKING:
    from cablewright.machine.simulated.settings import FaultPlan


@command("machines merlet2023", "apps.cli.simulate:MachineList", "apps.cli.robots:LibraryFile")
def machines_command(
    *,
    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="Machine of the library; without it, list all machines.")
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option(
            "--for",
            metavar="ROBOT",
            help="Robot for which to print a machine file, in which assumed numbers are marked.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """A machine file describes platform, winches, room and sensors, and the simulation. Use it with --machine.

    Start your own from one of them, `cablewright machines NAME > mine.toml`, or for your robot with `cablewright
    machines --for ROBOT > mine.toml`.
    """
    from cablewright.machine.files import machine_text
    from cablewright.machine.simulated.machine_file import machine_file

    if name is not None and robot is not None:
        raise InputError("machines: expected NAME or --for ROBOT, not both")
    if robot is not None:
        described = cw.load(robot)
        return LibraryFile(described.name, machine_file(described)).show(as_json)
    if name is not None:
        return LibraryFile(name, machine_text(name)).show(as_json)
    return answer(MachineList(tuple(cw.machine_names())), as_json)


@dataclass(frozen=True, repr=False)
class MachineList(Result):
    """The simulated machines of the library."""

    FIGURES: ClassVar = (Figure("machines", "", "Names of the simulated machines of the library."),)

    machines: tuple[str, ...]


@options("Path")
class DriveOptions:
    """Options of the machine's motion."""

    loop: Annotated[
        float | None, typer.Option("--loop", metavar="L", help="Length of a random closed path to follow, m.")
    ] = None
    hold: Annotated[
        str | None, typer.Option("--hold", metavar="X,Y,Z", help="Position to hold instead of a path, m.")
    ] = None
    height: Annotated[float, typer.Option("--height", metavar="Z", help="Height of the path, m.")] = 1.2
    speed: Annotated[float, typer.Option("--speed", metavar="V", help="Speed along the path, m/s.")] = 0.03
    duration: Annotated[
        float | None,
        typer.Option(
            "--duration",
            metavar="T",
            help="Duration of the simulation, s; by default until the path has been followed once.",
        ),
    ] = None
    slack: Annotated[
        float,
        typer.Option("--slack", metavar="E", help="Target for the control: excess length of the slackest line, m."),
    ] = 0.03
    valve: Annotated[
        float, typer.Option("--valve", metavar="O", help="Opening of the powder's valve, 0 (shut) to 1 (open).")
    ] = 1.0

    def require(self) -> None:
        """Reject contradictory options, before any work. Raises `InputError`."""
        if (self.loop is None) == (self.hold is None):
            raise InputError("simulate: expected either --loop or --hold")
        if self.hold is not None and self.duration is None:
            raise InputError("--hold needs --duration, the time to hold the position in s")
        if len(numbers(self.hold or "0,0,0", "--hold") or []) != 3:
            raise InputError(f"--hold = {self.hold}: expected X,Y,Z, m")


@options("Faults")
class FaultOptions:
    """Options of faults during the run."""

    fault: Annotated[
        list[str] | None,
        typer.Option(
            "--fault",
            metavar="FAULT",
            help="SOURCE,FROM,TO[,KIND[,SIZE]]: silence a sensor between two times, s; repeat the option for more. "
            "With `stuck` it "
            "repeats its reading. SOURCE:LINE is the sensor of one line. encoders:LINE,5,100,slip,0.02"
            " counts 20 mm too much; load_cells:LINE,5,100,offset,50 shows 50 N too much; "
            "line:LINE,5,100,broken breaks a line; off_sheave takes it off its sheave.",
        ),
    ] = None
    wifi_gap: Annotated[
        list[str] | None,
        typer.Option(
            "--wifi-gap",
            metavar="FROM,TO",
            help="Start and end of a time, s, in which the wireless link is down; repeat the option for more.",
        ),
    ] = None

    def of(self, settings: cw.TwinSettings) -> cw.TwinSettings:
        """Return the machine with the faults of the options added to its own. Raises `InputError`."""
        from cablewright.foundation.validation import validated
        from cablewright.machine.simulated.settings import Link

        wifi = settings.simulation.wifi
        gaps = (*wifi.gaps, *(tuple(numbers(text, "--wifi-gap", 2) or []) for text in self.wifi_gap or ()))
        wifi = validated(Link, wifi.model_dump() | {"gaps": gaps}, "--wifi-gap")
        faults = (*settings.simulation.faults, *map(_fault, self.fault or ()))
        return settings.with_simulation(faults=faults, wifi=wifi)


@command("simulate merlet2023 --loop 28 --duration 20 --plant quasi-static", "live.simulate:Simulation")
def simulate_command(
    *,
    robot: RobotName,
    machine: MachineName = None,
    plant: Plant = "dynamic",
    severity: Severity = None,
    seed: Seed = 0,
    path: DriveOptions,
    faults: FaultOptions,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="LOG.mcap", help="MCAP log to write, with the simulated motion.")
    ] = None,
    epoch: Annotated[
        str | None,
        typer.Option(
            "--epoch",
            metavar="TIME",
            help="Start time that the log records: ISO 8601 in UTC, like 2026-05-01T12:00:00Z, or now; by default "
            "1970, so that the same seed gives the same bytes.",
        ),
    ] = None,
    output: OutputOptions,
) -> int:
    """Builds a random machine within its tolerances and drives its winches by their true lengths.

    So the log shows ideal motion, for tests of estimators. A robot without a machine of its name uses that of
    merlet2023.
    """
    from cablewright.live.simulate import machine_of

    check_suffix(out, "--out", ".mcap")
    path.require()
    described = cw.load(robot)
    with progress() as show:
        found = cw.simulate(
            described,
            faults.of(machine_of(described, machine)),
            loop=path.loop,
            hold=numbers(path.hold, "--hold"),
            height=path.height,
            duration=path.duration,
            seed=seed,
            plant=plant,
            severity=severity,
            driving=cw.DriveSettings(speed=path.speed, slack=path.slack, valve=path.valve),
            log=out,
            epoch=_began(epoch),
            progress=show,
        )
    return answer(found, output.as_json, out=out, **output.write(found, "Simulated drive"))


def _began(epoch: str | None) -> datetime | None:
    """Time 0 of the log. Raises `InputError`."""
    if epoch is None:
        return None
    if epoch == "now":
        return datetime.now(UTC).replace(microsecond=0)
    try:
        told = datetime.fromisoformat(epoch)
    except ValueError:
        told = None
    if told is None or told.utcoffset() != timedelta(0):
        raise InputError(f"--epoch = {epoch!r}: expected `now`, or a time in UTC like 2026-05-01T12:00:00Z")
    return told


def _fault(text: str) -> FaultPlan:
    """One --fault. Raises `InputError`."""
    from cablewright.foundation.validation import validated
    from cablewright.machine.simulated.settings import FaultPlan

    parts = text.split(",")
    if len(parts) not in (3, 4, 5):
        raise InputError(f"--fault = {text!r}: expected SOURCE,FROM,TO[,KIND[,SIZE]], like north,10,20")
    source, _, line = parts[0].partition(":")
    begin, end = numbers(",".join(parts[1:3]), "--fault", 2) or []
    table = {"source": source, "begin": begin, "end": end, "line": line or None}
    if len(parts) > 3:
        table["kind"] = parts[3]
    if len(parts) > 4:
        table["size"] = (numbers(parts[4], "--fault", 1) or [])[0]
    return validated(FaultPlan, table, f"--fault {text}")


@command("replay examples/merlet2023-loop.mcap --estimator both", "live.replay:Replay", "live.replay:Replays")
def replay_command(
    *,
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A machine's MCAP log, or the run folder of a print.")],
    estimator: Annotated[
        ReplayName | None,
        typer.Option(
            "--estimator",
            help="Estimator of the platform's position: that of Merlet and Papegay 2023 (paper), a Kalman filter of "
            "all sensors (filter), both side by side, or encoders alone; by default the first for which the "
            "machine has the sensors.",
        ),
    ] = None,
    laser: Annotated[
        str | None,
        typer.Option(
            "--laser",
            metavar="WALL=D[,..]",
            help="Distances from the platform point B to walls at the start, measured by hand, m.",
        ),
    ] = None,
    output: OutputOptions,
) -> int:
    """Estimates position, slack lines and winch drum radii from the sensors of the log.

    A log without the true state gives no errors. The answer is no (exit 1) if no step has a valid estimate.
    """
    from cablewright.live.replay import Replays

    names = ("paper", "filter") if estimator == "both" else (estimator,)
    measured = lasers(laser)
    with progress() as show:
        each = [cw.replay(log, name, lasers=measured, progress=show) for name in names]
    found = each[0] if len(each) == 1 else Replays(tuple(each))
    return answer(found, output.as_json, **output.write(found, f"Replay of {log.name}"))
