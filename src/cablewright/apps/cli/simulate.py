"""`simulate` and `machines`: a machine with real imperfections, driven along a path, and its log."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import AsJson, Plot, RobotName, check_plot
from cablewright.apps.cli.output import numbers, print_json, progress, tell
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.machine.simulated.settings import FaultPlan, MachineSettings


def machines(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="Print this machine's file.")] = None,
    as_json: AsJson = False,
) -> None:
    """List the machines of the library: tolerances, drum, winches, room, sensors. Or print the file of one."""
    from cablewright.machine.simulated.settings import machine_names, machine_text

    if name is not None:
        text = machine_text(name)
        if as_json:
            print_json({"name": name, "file": text})
        else:
            typer.echo(text, nl=False)
    elif as_json:
        print_json({"machines": list(machine_names())})
    else:
        typer.echo("\n".join(machine_names()))


def simulate(
    robot: RobotName,
    machine: Annotated[
        str | None, typer.Option("--machine", metavar="NAME", help="A file, or a name that `machines` lists.")
    ] = None,
    loop: Annotated[
        float | None, typer.Option("--loop", metavar="L", help="Go round a random closed path this long, m.")
    ] = None,
    hold: Annotated[str | None, typer.Option("--hold", metavar="X,Y,Z", help="Stay there instead, m.")] = None,
    height: Annotated[float, typer.Option("--height", metavar="Z", help="Height of the loop, m.")] = 1.2,
    speed: Annotated[float, typer.Option("--speed", metavar="V", help="Along the loop, m/s.")] = 0.03,
    duration: Annotated[
        float | None, typer.Option("--duration", metavar="T", help="How long, s; once round the loop when left out.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", help="Decides on the robot as built, the loop and all noise.")] = 0,
    plant: Annotated[str, typer.Option("--plant", help="dynamic or quasi-static.")] = "dynamic",
    valve: Annotated[float, typer.Option("--valve", metavar="O", help="Opening of the powder's valve, 0 to 1.")] = 1.0,
    slack: Annotated[
        float, typer.Option("--slack", metavar="E", help="How far the slackest line is let out, m.")
    ] = 0.03,
    fault: Annotated[
        list[str] | None,
        typer.Option(
            "--fault",
            metavar="SOURCE,FROM,TO[,stuck]",
            help="A sensor that is silent (or stuck) for a time, s; one line's is line_angles:LINE.",
        ),
    ] = None,
    wifi_gap: Annotated[
        list[str] | None, typer.Option("--wifi-gap", metavar="FROM,TO", help="Nothing comes over the wireless link, s.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="LOG.mcap", help="Write a log.")] = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """Drive a simulated machine, built by --seed within its tolerances, along a path; its log is what sensors told."""
    from cablewright.robot import load
    from cablewright.studies.drive import DriveSettings
    from cablewright.studies.simulate import machine_of
    from cablewright.studies.simulate import simulate as run

    check_plot(plot)
    described = load(robot)
    with progress() as tells:
        found = run(
            described,
            _with_faults(machine_of(described, machine), fault or [], wifi_gap or []),
            loop=loop,
            hold=numbers(hold, "--hold"),
            height=height,
            duration=duration,
            seed=seed,
            plant=plant,  # type: ignore[arg-type]
            driving=DriveSettings(speed=speed, slack=slack, valve=valve),
            log=out,
            progress=tells,
        )
    if plot is not None:
        found.plot(plot)
    values = found.to_dict() | {"out": _text(out), "plot": _text(plot)}
    if as_json:
        print_json(values)
    else:
        _print(values)
    return 0


def _with_faults(settings: MachineSettings, faults: list[str], gaps: list[str]) -> MachineSettings:
    """The settings with what the command line breaks."""
    from cablewright.machine.simulated.settings import Link
    from cablewright.validation import validated

    plans = tuple(_fault(text) for text in faults)
    given = tuple(tuple(_numbers(text, 2, "--wifi-gap")) for text in gaps)
    wifi = validated(Link, {**settings.wifi.model_dump(), "gaps": (*settings.wifi.gaps, *given)}, "--wifi-gap")
    return settings.model_copy(update={"faults": (*settings.faults, *plans), "wifi": wifi})


def _fault(text: str) -> FaultPlan:
    from cablewright.machine.simulated.settings import FaultPlan
    from cablewright.validation import validated

    parts = text.split(",")
    if len(parts) not in (3, 4):
        raise InputError(f"--fault = {text!r}: SOURCE,FROM,TO[,stuck] is wanted, like north,10,20")
    source, _, line = parts[0].partition(":")
    begin, end = _numbers(",".join(parts[1:3]), 2, "--fault")
    table: dict[str, Any] = {"source": source, "begin": begin, "end": end, "line": line or None}
    return validated(FaultPlan, table | ({"kind": parts[3]} if len(parts) == 4 else {}), f"--fault {text}")


def _numbers(text: str, count: int, option: str) -> list[float]:
    values = numbers(text, option) or []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise InputError(f"{option} = {text!r}: {count} finite numbers with commas between them are wanted")
    return values


def _text(path: Path | None) -> str | None:
    return None if path is None else str(path)


def _print(values: dict[str, Any]) -> None:
    """The summary for people."""
    typer.echo(f"{values['robot']}: {values['duration']:.1f} s of the {values['plant']} plant, seed {values['seed']}")
    typer.echo(f"went      {values['distance']:.2f} m; {values['powder']:.2f} kg of powder left")
    low, high = (math.degrees(angle) for angle in values["yaw"])
    typer.echo(f"drum      tilted by {math.degrees(values['max_tilt']):.2f}° at most, yaw {low:.1f} to {high:.1f}°")
    shares = (f"{name} {100 * share:.0f} %" for name, share in zip(values["lines"], values["slack_share"], strict=True))
    typer.echo(f"slack     {', '.join(shares)} of the time by over 5 mm")
    typer.echo(f"tension   {values['max_tension']:.0f} N at most")
    typer.echo("readings  " + ", ".join(f"{name} {count}" for name, count in values["readings"].items()))
    for name, count in values["notices"].items():
        typer.echo(f"notice    {name.removeprefix(': ')}, in {count} steps")
    for what in ("out", "plot"):
        if values[what] is not None:
            typer.echo(f"written   {values[what]}")
    tell(f"{values['real_time_ratio']:.0f} x real time")
