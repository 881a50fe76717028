"""`trade`: workspace against lowest frequency, while design parameters of the robot vary."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import typer

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
from cablewright.apps.cli.parsing import numbers
from cablewright.choices import InertiaName
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.robot.design_variables import Change
    from cablewright.studies.trade import TradeSettings

MAX_VALUES = 10_000  # values of one parameter


@dataclass(frozen=True, kw_only=True)
class FrequencyOptions:
    """How the frequencies along the boundary are found."""

    PANEL: ClassVar = "Frequencies"

    boundary_grid: Annotated[
        int, typer.Option("--boundary-grid", metavar="N", help="Nodes along each side of the box, for boundaries.")
    ] = 21
    geometric: Geometric = True
    tensions: Tensions = None
    inertia: Annotated[
        InertiaName,
        typer.Option("--inertia", help="Inertia of the platform: the file's, or that of a box about its points."),
    ] = "given"


@dataclass(frozen=True, kw_only=True)
class TradeCommand:
    """Each combination of values gives a robot; its workspace and the modes along the boundary are found.

    A combination is best (not dominated) if no other without colliding sheaves has more volume and a higher lowest
    frequency. The sweep can be interrupted: the same command resumes it from --out.
    """

    EXAMPLE: ClassVar = "trade jung2020 --vary exit-distance=0.2,0.3 --count nodes --grid 5 --boundary-grid 5"
    ANSWERS: ClassVar = ("studies.trade:Trade",)

    robot: RobotOptions
    vary: Annotated[
        list[str],
        typer.Option(
            "--vary",
            metavar="NAME=FROM:TO:N",
            help="A parameter and its values, SI; or NAME=V1,V2,..; repeat it for all combinations. NAME: "
            "exit-distance, width-x, width-y, width-top-x, width-bottom-x, .., retraction; mass, modulus and others as "
            "in `accuracy`; exit_point.z@LINE for one line; NAME+NAME for two that share the value.",
        ),
    ]
    clearance: Annotated[
        float,
        typer.Option(
            "--sheave-clearance", metavar="D", help="Distance of exit points, m, under which sheaves collide."
        ),
    ] = 0.1
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", metavar="FILE.jsonl", help="Results by combination, to resume from; by default in runs/."
        ),
    ] = None
    region: OrientedRegionOptions
    volume: CountOptions
    frequencies: FrequencyOptions
    executor: ExecutorOptions
    output: OutputOptions

    def run(self) -> int:
        """Sweep, draw and print."""
        from cablewright.studies.store import folder_name
        from cablewright.studies.trade import trade

        varied, machine = _varied(self.vary), self.robot.loaded()
        file = self.out or Path("runs") / f"{folder_name('trade', machine.name)}.jsonl"
        options = {"file": file, **self.region.laws()}
        with self.executor.working(file) as (executor, show):
            found = trade(machine, varied, self.settings(), executor=executor, progress=show, **options)
        return answer(
            found,
            self.output.as_json,
            file=file,
            **self.output.write(found, f"Trade of {machine.name}", when=found.status != "empty"),
        )

    def settings(self) -> TradeSettings:
        """What is found for each combination. Raises `InputError`."""
        from cablewright.studies.trade import TradeSettings

        region, volume, frequencies = self.region.places(), self.volume, self.frequencies
        box, orientations = region["box"], region["orientations"]
        return TradeSettings(
            criterion=self.region.criterion_name,
            count=volume.count,
            grid=volume.grid,
            tolerance=volume.tolerance,
            box=None if box is None else tuple(box),
            point=region["point"],
            orientations=None if orientations is None else tuple(map(tuple, orientations)),
            retraction=region["retraction"],
            seed=volume.seed,
            boundary_grid=frequencies.boundary_grid,
            geometric=frequencies.geometric,
            holding=frequencies.tensions,
            clearance=self.clearance,
            inertia=frequencies.inertia,
        )


def _varied(given: list[str]) -> dict[Change, tuple[float, ...]]:
    """Parameters and their values. Raises `InputError`."""
    from cablewright.robot.design_variables import Change

    varied: dict[Change, tuple[float, ...]] = {}
    for text in given:
        name, equals, values = text.rpartition("=")
        if not equals:
            raise InputError(f"--vary = {text!r}: expected NAME=FROM:TO:N, or NAME=V1,V2,..")
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
        raise InputError(f"--vary = {text!r}: expected NAME=FROM:TO:N, two numbers and how many values") from None
    if not (np.isfinite([low, high]).all() and low < high):
        raise InputError(f"--vary = {text!r}: expected finite numbers, FROM below TO")
    if not 2 <= n <= MAX_VALUES:
        raise InputError(f"--vary = {text!r}: 2 to {MAX_VALUES} values are allowed")
    return tuple(np.linspace(low, high, n).tolist())
