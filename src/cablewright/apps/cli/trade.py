"""`trade`: workspace against lowest frequency, while named numbers of the robot vary."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import (
    AsJson,
    Box,
    Count,
    Criterion,
    Geometric,
    Grid,
    Holding,
    LawOfRetraction,
    Limits,
    LoadName,
    Orientations,
    Plot,
    Point,
    Retracted,
    RobotName,
    Seed,
    Sheave,
    Tolerance,
    Wrench,
    check_plot,
    described,
    retracting,
    turns,
)
from cablewright.apps.cli.output import limits, numbers, print_json, progress, tell
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.robot.design_variables import Change
    from cablewright.studies.trade import Combination, Trade

NO = 1
MAX_VALUES = 10_000  # values of one parameter

Varied = Annotated[
    list[str],
    typer.Option(
        "--vary",
        metavar="NAME=FROM:TO:N",
        help="A number of the robot and its values, SI; or NAME=V1,V2,.. ; several for all their combinations. NAME: "
        "exit-distance, width-x, width-y, width-top-x, width-bottom-x, .., retraction; mass, modulus and others as of "
        "`accuracy`; exit_point.z@LINE for one line; NAME+NAME for names that have the same value.",
    ),
]


BoundaryGrid = Annotated[int, typer.Option("--boundary-grid", metavar="N", help="Nodes along a side, of boundaries.")]
Clearance = Annotated[
    float, typer.Option("--sheave-clearance", metavar="D", help="Distance of exits under which sheaves collide, m.")
]
Inertia = Annotated[
    str, typer.Option("--inertia", help="given, or box: of a box that reaches as far as the platform points.")
]
Cable = Annotated[
    str | None,
    typer.Option("--cable", help="Of frequencies: rigid, elastic or catenary; catenary of static, else elastic."),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="FILE.json", help="Where it is kept how far the sweep is; by default in runs/."),
]


def trade(
    robot: RobotName,
    vary: Varied,
    criterion: Criterion = "exact",
    count: Count = "volume",
    grid: Grid = None,
    tolerance: Tolerance = None,
    boundary_grid: BoundaryGrid = 21,
    geometric: Geometric = True,
    tensions: Holding = None,
    clearance: Clearance = 0.1,
    inertia: Inertia = "given",
    box: Box = None,
    point: Point = "nozzle",
    orientations: Orientations = None,
    retraction: Retracted = None,
    law: LawOfRetraction = None,
    cable: Cable = None,
    sheave: Sheave = None,
    tension_limits: Limits = None,
    load: LoadName = None,
    wrench: Wrench = None,
    seed: Seed = 0,
    out: Out = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """Workspace against lowest natural frequency along its boundary, while numbers of the robot vary."""
    from cablewright.studies.store import folder_name
    from cablewright.studies.trade import TradeSettings
    from cablewright.studies.trade import trade as sweep

    check_plot(plot)
    varied = _varied(vary)
    machine = described(robot, load, wrench)
    laws: dict[str, Any] = {"cable": cable, "sheave": sheave, "tension_limits": limits(tension_limits)}
    ends, rotated = numbers(box, "--box"), turns(orientations)
    asked = TradeSettings(
        criterion=criterion,
        count=count,
        grid=grid,
        tolerance=tolerance,
        box=None if ends is None else tuple(ends),
        point=point,
        orientations=None if rotated is None else tuple(map(tuple, rotated)),
        retraction=retracting(retraction, law, point),
        seed=seed,
        boundary_grid=boundary_grid,
        geometric=geometric,
        holding=tensions,
        clearance=clearance,
        inertia=inertia,
    )
    file = out or Path("runs") / f"{folder_name('trade', machine.name)}.json"
    try:
        with progress() as show:
            found = sweep(machine, varied, asked, file=file, progress=show, **laws)
    except KeyboardInterrupt:
        tell(f"{file} has what is done: the same command goes on")
        raise
    drawn = None if found.status == "empty" else plot
    if drawn is not None:
        found.plot(drawn)
    if as_json:
        print_json(found.to_dict() | {"file": str(file), "plot": None if drawn is None else str(drawn)})
    else:
        _print(found)
    if found.verdict:
        tell(f"cablewright: {found.verdict}")
    return NO if found.verdict else 0


def _varied(given: list[str]) -> dict[Change, tuple[float, ...]]:
    """Changes and their values. Raises `InputError`."""
    from cablewright.robot.design_variables import Change

    varied: dict[Change, tuple[float, ...]] = {}
    for text in given:
        name, equals, values = text.rpartition("=")
        if not equals:
            raise InputError(f"--vary = {text!r}: NAME=FROM:TO:N is wanted, or NAME=V1,V2,..")
        change = Change(name)
        if change in varied:
            raise InputError(f"--vary = {text!r}: {name} is varied more than once")
        varied[change] = _spaced(text, values) if ":" in values else tuple(numbers(values, f"--vary {name}") or ())
    return varied


def _spaced(text: str, values: str) -> tuple[float, ...]:
    """N values from the first to the last. Raises `InputError`."""
    import numpy as np

    try:
        first, last, steps = values.split(":")
        low, high, n = float(first), float(last), int(steps)
    except ValueError:
        raise InputError(f"--vary = {text!r}: NAME=FROM:TO:N is wanted, two numbers and how many values") from None
    if not (np.isfinite([low, high]).all() and low < high):
        raise InputError(f"--vary = {text!r}: finite numbers, FROM below TO, are wanted")
    if not 2 <= n <= MAX_VALUES:
        raise InputError(f"--vary = {text!r}: 2 to {MAX_VALUES} values are allowed")
    return tuple(np.linspace(low, high, n).tolist())


def _print(found: Trade) -> None:
    """For people: a combination a line."""
    asked = found.settings
    counted = "" if asked.geometric else ", without geometric stiffness"
    typer.echo(f"{found.model.robot.name}: {asked.criterion}; lowest frequency along the boundary{counted}")
    heads = [f"{change.name} {change.unit}".removesuffix(" 1") for change in found.varied]
    widths = [max(8, len(head)) for head in heads]
    names = "  ".join(f"{head:>{width}}" for head, width in zip(heads, widths, strict=True))
    typer.echo(f"{names}  {'m^3':>8} {'% of box':>8} {'Hz from':>8} {'median':>7} {'to':>7}  mostly {'exits m':>8}")
    for k, each in enumerate(found.combinations):
        values = "  ".join(f"{value:>{width}.5g}" for value, width in zip(each.values, widths, strict=True))
        told = "not dominated" if found.best[k] else "" if found.clear[k] else "sheaves collide"
        typer.echo(f"{values}  {_line(each)}  {told}".rstrip())


def _line(each: Combination) -> str:
    """What a combination gives, as a part of its line."""
    frequencies = (each.least, each.median, each.greatest)
    lowest, median, greatest = ("-" if value is None else f"{value:.3g}" for value in frequencies)
    distance = "-" if each.exit_distance is None else f"{each.exit_distance:.4g}"
    volume = f"{each.volume:>8.4g} {100.0 * each.fraction:>8.2f}"
    return f"{volume} {lowest:>8} {median:>7} {greatest:>7}  {each.dominant or '-':<6} {distance:>8}"
