"""`trade`: workspace and lowest frequency while design parameters of the robot vary."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command, options
from cablewright.apps.cli.options import (
    CountOptions,
    ExecutorOptions,
    Geometric,
    OrientedRegionOptions,
    OutputOptions,
    RobotOptions,
    Tensions,
)
from cablewright.apps.cli.output import answer
from cablewright.apps.cli.parsing import numbers, run_path
from cablewright.foundation.choices import InertiaName
from cablewright.foundation.errors import InputError

MAX_VALUES = 10_000  # values of one parameter


@options("Frequencies")
class FrequencyOptions:
    """Options of the frequencies along the boundary."""

    boundary_grid: Annotated[
        int,
        typer.Option(
            "--boundary-grid",
            metavar="N",
            help="Number of grid nodes along each side of the search box, for the boundary of the workspace.",
        ),
    ] = 21
    geometric: Geometric = True
    tensions: Tensions = None
    inertia: Annotated[
        InertiaName,
        typer.Option(
            "--inertia",
            help="Inertia of the platform: the robot file's (given), or that of a box about the platform points (box).",
        ),
    ] = "given"


@command("trade jung2020 --vary exit-distance=0.2,0.3 --count nodes --grid 5 --boundary-grid 5", "studies.trade:Trade")
def trade_command(
    *,
    robot: RobotOptions,
    vary: Annotated[
        list[str],
        typer.Option(
            "--vary",
            metavar="NAME=FROM:TO:N",
            help="A parameter and its values in SI units, or NAME=V1,V2,..; repeat the option: all combinations are "
            "computed. NAME: "
            "exit-distance, width-x, width-y, width-top-x, width-bottom-x, .., retraction; mass, modulus and others "
            "as "
            "in `accuracy`; exit_point.z@LINE for one line; NAME+NAME for two that share the value.",
        ),
    ],
    clearance: Annotated[
        float,
        typer.Option(
            "--sheave-clearance",
            metavar="D",
            help="Minimum distance between exit points, m; at a smaller distance sheaves collide.",
        ),
    ] = 0.1,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="FILE.jsonl",
            help="File for the result of each combination, from which the same command resumes; by default in runs/.",
        ),
    ] = None,
    region: OrientedRegionOptions,
    volume: CountOptions,
    frequencies: FrequencyOptions,
    executor: ExecutorOptions,
    output: OutputOptions,
) -> int:
    """Each combination of values gives a robot, with its workspace and its modes along the boundary.

    A combination is not dominated if no other without colliding sheaves has more volume and a higher lowest frequency.
    The same command resumes an interrupted sweep from --out.
    """
    varied, machine = _varied(vary), robot.loaded()
    file = run_path(out, "trade", machine.name, suffix=".jsonl")
    with executor.working(file) as (works, show):
        settings = _settings(region, volume, frequencies, clearance)
        found = cw.trade(machine, varied, settings, file=file, executor=works, progress=show, **region.laws())
    return answer(
        found,
        output.as_json,
        file=file,
        **output.write(found, f"Trade of {machine.name}", when=found.status != "empty"),
    )


def _settings(
    region: OrientedRegionOptions, volume: CountOptions, frequencies: FrequencyOptions, clearance: float
) -> cw.TradeSettings:
    """The figures to compute for each combination. Raises `InputError`."""
    places = region.places()
    box, orientations = places["box"], places["orientations"]
    return cw.TradeSettings(
        criterion=region.criterion_name,
        count=volume.count,
        grid=volume.grid,
        tolerance=volume.tolerance,
        box=None if box is None else tuple(box),
        point=places["point"],
        orientations=None if orientations is None else tuple(map(tuple, orientations)),
        retraction=places["retraction"],
        seed=volume.seed,
        boundary_grid=frequencies.boundary_grid,
        geometric=frequencies.geometric,
        holding=frequencies.tensions,
        clearance=clearance,
        inertia=frequencies.inertia,
    )


def _varied(given: list[str]) -> dict[cw.Change, tuple[float, ...]]:
    """Parameters and their values. Raises `InputError`."""
    varied: dict[cw.Change, tuple[float, ...]] = {}
    for text in given:
        name, equals, values = text.rpartition("=")
        if not equals:
            raise InputError(f"--vary = {text!r}: expected NAME=FROM:TO:N, or NAME=V1,V2,..")
        change = cw.Change(name)
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
        raise InputError(f"--vary = {text!r}: expected NAME=FROM:TO:N, two numbers and how many values") from None
    if not (np.isfinite([low, high]).all() and low < high):
        raise InputError(f"--vary = {text!r}: expected finite numbers, FROM below TO")
    if not 2 <= n <= MAX_VALUES:
        raise InputError(f"--vary = {text!r}: 2 to {MAX_VALUES} values are allowed")
    return tuple(np.linspace(low, high, n).tolist())
