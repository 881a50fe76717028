"""The way of a lidar's turn through a running print is the one that docs/architecture.md describes."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import is_dataclass
from pathlib import Path
from types import FrameType
from typing import Any

import cablewright
from cablewright.estimation.lidar.wall_lines import LidarTurn
from cablewright.foundation.signals import Command, Estimate, Scan
from cablewright.live.estimators import estimator
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load

SOURCE = Path(cablewright.__file__).parent
PAGE = Path(__file__).parents[2] / "docs" / "architecture.md"
RING = Job(
    name="ring",
    origin=(0.3, -0.5, 0.0),
    helix=Helix(radius=0.4, layers=1, layer_height=0.001, first_height=1.0),
    motion=Motion(print_speed=0.03, travel_speed=0.03, acceleration=0.02),
)
WITHOUT_ITS_OBJECTS = {  # they have the frame, arrays or numbers of the turn, but no turn as such
    "live/prints/loop.py",
    "kernels/fitting/scan_lines.py",
    "kernels/filtering/wall_matches.py",
    "kernels/filtering/estimate.py",
    "control/velocity.py",
}
FORWARDING = {"foundation/signals/reading.py"}  # gives it a time by another clock


def described() -> tuple[list[str], list[str], str]:
    """Files and containers of the section, and the section."""
    text = PAGE.read_text().partition("\n## From a lidar point to a winch speed\n")[2].partition("\n## ")[0]
    files = list(dict.fromkeys(re.findall(r"\*\*`(\S+\.py)`\.?\*\*", text)))
    return files, re.findall(r"(?<!\*)\*(\w+)\*(?!\*)", text), text


def of_a_turn(value: object) -> bool:
    """Whether a value is a horizontal lidar's turn, or has one in it."""
    if isinstance(value, list | tuple):
        return any(map(of_a_turn, value))
    return isinstance(value, LidarTurn) or (isinstance(value, Scan) and value.source != "vertical")


def inside(value: object) -> list[object]:
    """What is in a dataclass or named tuple."""
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return list(value)
    return list(vars(value).values()) if is_dataclass(value) else []


class Watch:
    """Notes files of functions that had a turn in a local variable, or its ranges, and classes that held one."""

    def __init__(self) -> None:
        self.files: set[str] = set()
        self.containers: set[str] = set()
        self.ranges: Any = None
        self.turns: set[str] = set()

    def __call__(self, frame: FrameType, event: str, _: object) -> None:
        path = Path(frame.f_code.co_filename)
        if event != "return" or not path.is_relative_to(SOURCE):
            return
        file = path.relative_to(SOURCE).as_posix()
        if file.startswith("machine/"):
            return
        for value in list(frame.f_locals.values()):
            for part in (value, *inside(value)):
                if isinstance(part, Scan | LidarTurn) or any(map(of_a_turn, inside(part))):
                    self.containers.add(type(part).__name__)
            if of_a_turn(value) or (self.ranges is not None and value is self.ranges):
                self.files.add(file)
            if isinstance(value, Scan) and of_a_turn(value):
                self.ranges = value.ranges
            elif isinstance(value, LidarTurn) and value.source:
                self.turns.add(value.source)


def printing() -> Iterator[Printer]:
    """A print by the filter, on a machine whose drum has a clock of its own; each step once its path has begun."""
    robot = load("merlet2023")
    made = twin_of(robot, RING, None, PrintOptions("filter", severity="typical", seed=3))
    machine = SimulatedMachine(made.robot, made.settings, made.path.track.at(0.0).position, seed=3, plant="dynamic")
    printer = Printer(
        plan_print(made),
        machine,
        lambda place, radii: estimator(made.estimator, made.robot, machine.settings, place, (), radii),
        now=machine.time,
    )
    attendant = Attendant(lambda: machine.refill(printer.plan.powder), refill_time=10.0)
    while True:
        step = printer.step(attendant.orders(printer, machine.time))
        if step.command.winch_speeds.any():
            yield printer


def test_a_turn_passes_through_the_files_that_are_described_and_no_others() -> None:
    files, containers, text = described()
    watch, steps = Watch(), printing()
    next(steps)
    sys.setprofile(watch)
    try:
        for _ in zip(range(120), steps, strict=False):
            pass
    finally:
        sys.setprofile(None)
    assert watch.turns == {"north", "south"}
    assert watch.files - FORWARDING == set(files) - WITHOUT_ITS_OBJECTS
    assert set(files) > WITHOUT_ITS_OBJECTS
    assert f"**{len(files)} files, {len(containers)} containers**" in text
    assert len(files) <= 12
    assert watch.containers == set(containers[:4]) == {"SensorFrame", "Scan", "LidarTurn", "Turns"}
    assert containers[4:] == [Estimate.__name__, Command.__name__]
    assert len(containers) <= 6
