"""`simulate` and `machines`: a machine with real imperfections, driven along a path, and its log."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import typer

from cablewright.apps.cli.options import AsJson, MachineName, OutputOptions, Plant, RobotName, Seed, Severity
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import check_suffix, numbers
from cablewright.apps.cli.robots import LibraryFile
from cablewright.errors import InputError
from cablewright.results import Figure, Result

if TYPE_CHECKING:
    from cablewright.machine.simulated.settings import FaultPlan, TwinSettings


@dataclass(frozen=True, kw_only=True)
class MachinesCommand:
    """The file of a machine has its drum, winches, room and sensors, and its simulation; --machine takes one.

    Start your own from one of them, `cablewright machines NAME > mine.toml`, or for your own robot from
    `cablewright machines --for ROBOT > mine.toml`.
    """

    EXAMPLE: ClassVar = "machines merlet2023"
    ANSWERS: ClassVar = ("apps.cli.simulate:MachineList", "apps.cli.robots:LibraryFile")

    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="Machine whose file is printed; without it, all are listed.")
    ] = None
    robot: Annotated[
        str | None,
        typer.Option(
            "--for", metavar="ROBOT", help="Robot for which a machine file is printed, with assumed numbers marked."
        ),
    ] = None
    as_json: AsJson = False

    def run(self) -> int:
        """Print the list, or the file."""
        from cablewright.machine.files import machine_names, machine_text
        from cablewright.machine.simulated.machine_file import machine_file
        from cablewright.robot import load

        if self.name is not None and self.robot is not None:
            raise InputError("machines: expected NAME or --for ROBOT, not both")
        if self.robot is not None:
            described = load(self.robot)
            return LibraryFile(described.name, machine_file(described)).show(self.as_json)
        if self.name is not None:
            return LibraryFile(self.name, machine_text(self.name)).show(self.as_json)
        return answer(MachineList(tuple(machine_names())), self.as_json)


@dataclass(frozen=True, repr=False)
class MachineList(Result):
    """The simulated machines of the library."""

    FIGURES: ClassVar = (Figure("machines", "", "Names of the simulated machines of the library."),)

    machines: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class DriveOptions:
    """Where and how the machine is driven."""

    PANEL: ClassVar = "Path"

    loop: Annotated[
        float | None, typer.Option("--loop", metavar="L", help="Length of a random closed path to follow, m.")
    ] = None
    hold: Annotated[
        str | None, typer.Option("--hold", metavar="X,Y,Z", help="Position to stay at instead of a path, m.")
    ] = None
    height: Annotated[float, typer.Option("--height", metavar="Z", help="Height of the path, m.")] = 1.2
    speed: Annotated[float, typer.Option("--speed", metavar="V", help="Speed along the path, m/s.")] = 0.03
    duration: Annotated[
        float | None, typer.Option("--duration", metavar="T", help="Duration, s; by default once along the path.")
    ] = None
    slack: Annotated[
        float, typer.Option("--slack", metavar="E", help="Excess over a taut line of the line that is slackest, m.")
    ] = 0.03
    valve: Annotated[
        float, typer.Option("--valve", metavar="O", help="Opening of the powder's valve, 0 (shut) to 1 (open).")
    ] = 1.0

    def require(self) -> None:
        """Refuse what contradicts itself, before any work. Raises `InputError`."""
        if (self.loop is None) == (self.hold is None):
            raise InputError("simulate: expected either --loop or --hold")
        if self.hold is not None and self.duration is None:
            raise InputError("--hold needs --duration")
        if len(numbers(self.hold or "0,0,0", "--hold") or []) != 3:
            raise InputError(f"--hold = {self.hold}: expected X,Y,Z, m")


@dataclass(frozen=True, kw_only=True)
class FaultOptions:
    """What fails on the way."""

    PANEL: ClassVar = "Faults"

    fault: Annotated[
        list[str] | None,
        typer.Option(
            "--fault",
            metavar="SOURCE,FROM,TO[,KIND[,SIZE]]",
            help="Sensor that is silent, or repeats its reading with `stuck`, between two times, s; may be repeated. "
            "line_angles:LINE is the sensor of one line, as is load_cells:LINE. encoders:LINE,5,100,slip,0.02 counts "
            "20 mm too much, load_cells:LINE,5,100,offset,50 shows 50 N too much; line:LINE,5,100,broken breaks a "
            "line, and off_sheave lets it fall off its sheave.",
        ),
    ] = None
    wifi_gap: Annotated[
        list[str] | None,
        typer.Option(
            "--wifi-gap", metavar="FROM,TO", help="Times, s, between which the wireless link is down; may be repeated."
        ),
    ] = None

    def of(self, settings: TwinSettings) -> TwinSettings:
        """The machine with these faults besides its own. Raises `InputError`."""
        from cablewright.machine.simulated.settings import Link
        from cablewright.validation import validated

        wifi = settings.simulation.wifi
        gaps = (*wifi.gaps, *(tuple(numbers(text, "--wifi-gap", 2) or []) for text in self.wifi_gap or ()))
        wifi = validated(Link, wifi.model_dump() | {"gaps": gaps}, "--wifi-gap")
        faults = (*settings.simulation.faults, *map(_fault, self.fault or ()))
        return settings.with_simulation(faults=faults, wifi=wifi)


@dataclass(frozen=True, kw_only=True)
class SimulateCommand:
    """The machine is built at random within its tolerances, and its winches are driven by their true lengths.

    So the log shows a machine that moves as intended, for estimators to be tested on. A robot without a machine of its
    name gets that of merlet2023.
    """

    EXAMPLE: ClassVar = "simulate merlet2023 --loop 28 --duration 20 --plant quasi-static"
    ANSWERS: ClassVar = ("studies.simulate:Simulation",)

    robot: RobotName
    machine: MachineName = None
    plant: Plant = "dynamic"
    severity: Severity = None
    seed: Seed = 0
    path: DriveOptions
    faults: FaultOptions
    out: Annotated[Path | None, typer.Option("--out", metavar="LOG.mcap", help="Write a log of the drive.")] = None
    epoch: Annotated[
        str | None,
        typer.Option(
            "--epoch",
            metavar="TIME",
            help="Time 0 of the log: ISO 8601 in UTC, like 2026-05-01T12:00:00Z, or now; by default 1970, so that the "
            "same seed gives the same bytes.",
        ),
    ] = None
    output: OutputOptions

    def __post_init__(self) -> None:
        """Refuse a log that is no MCAP file, before any work. Raises `InputError`, `EnvironmentFault`."""
        check_suffix(self.out, "--out", ".mcap")

    def run(self) -> int:
        """Drive, draw and print."""
        from cablewright.robot import load
        from cablewright.studies.drive import DriveSettings
        from cablewright.studies.simulate import machine_of, simulate

        self.path.require()
        described, path = load(self.robot), self.path
        with progress() as show:
            found = simulate(
                described,
                self.faults.of(machine_of(described, self.machine)),
                loop=path.loop,
                hold=numbers(path.hold, "--hold"),
                height=path.height,
                duration=path.duration,
                seed=self.seed,
                plant=self.plant,
                severity=self.severity,
                driving=DriveSettings(speed=path.speed, slack=path.slack, valve=path.valve),
                log=self.out,
                epoch=self.began(),
                progress=show,
            )
        return answer(found, self.output.as_json, out=self.out, **self.output.write(found, "Simulated drive"))

    def began(self) -> datetime | None:
        """Time 0 of the log. Raises `InputError`."""
        if self.epoch is None:
            return None
        if self.epoch == "now":
            return datetime.now(UTC).replace(microsecond=0)
        try:
            told = datetime.fromisoformat(self.epoch)
        except ValueError:
            told = None
        if told is None or told.utcoffset() != timedelta(0):
            raise InputError(f"--epoch = {self.epoch!r}: expected `now`, or a time in UTC like 2026-05-01T12:00:00Z")
        return told


def _fault(text: str) -> FaultPlan:
    """One --fault. Raises `InputError`."""
    from cablewright.machine.simulated.settings import FaultPlan
    from cablewright.validation import validated

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
