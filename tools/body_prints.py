"""Print with a rigid platform on machines as built by many seeds: tables of docs/bodies.md.

    python tools/body_prints.py                                # with all sensors, and by lengths alone
    python tools/body_prints.py --seeds 600:620                # of other machines
    python tools/body_prints.py --without inertial,swivels     # with fewer sensors
    python tools/body_prints.py --no-tour                      # without the machine's tour
    python tools/body_prints.py --faults --plant dynamic       # faults of a cell, an encoder and a line

True values: distance of the nozzle from its target and turn from the schedule, in each step since the first that
prints; least tension in them. With ``--faults``, one line, 1 + seed modulo 8, has a fault from 20 s after the first
step that prints on: when the machine says so first, whether it names the line and no other, the largest error from then
until 2 s after the stop, or the end.
"""

from __future__ import annotations

import argparse
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.foundation.signals import PrintState
from cablewright.live.estimators import estimator
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.machine.simulated.settings import FaultPlan, TwinSettings, whole_machine
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.rotation import angle_between
from cablewright.printing.job import load_job
from cablewright.robot import load

HOUSE = Path(__file__).resolve().parent.parent / "examples" / "house.toml"
JOB = load_job(HOUSE).model_copy(update={"scale": 12.0})
FAULTS: Final[dict[str, dict[str, object]]] = {
    "a load cell shows 150 N too much": {"source": "load_cells", "kind": "offset", "size": 150.0},
    "a load cell is silent": {"source": "load_cells", "kind": "silent"},
    "an encoder slips 20 mm": {"source": "encoders", "kind": "slip", "size": 0.02},
    "a line leaves its sheave": {"source": "line", "kind": "off_sheave"},
    "a line breaks": {"source": "line", "kind": "broken"},
}
AFTER: Final = 20.0  # s since the first step that prints, at which a fault begins
WATCHED: Final = 40.0  # s that are printed from then on, if nothing stops the machine
REST: Final = 2.0  # s after a stop


class Trial:
    """A print of one machine as built, step by step."""

    def __init__(self, machine: TwinSettings, options: PrintOptions) -> None:
        """Stand at the beginning of the house."""
        twin = twin_of(load("cogiro"), JOB, machine, options)
        plan, self.path = plan_print(twin), twin.path
        self.rig = rig = SimulatedMachine(
            twin.robot, twin.settings, self.path.start_pose, seed=options.seed, plant=options.plant
        )
        self.printer = Printer(
            plan, rig, lambda place, radii: estimator(twin.estimator, twin.robot, rig.settings, place, (), radii)
        )
        self.attendant = Attendant(lambda: None)

    def steps(self) -> Iterator[Step]:
        """Yield steps for as long as somebody runs it; after a stop the machine stands."""
        while True:
            yield self.printer.step(self.attendant.orders(self.printer, self.rig.time))

    def errors(self, target: np.ndarray) -> tuple[float, float, float]:
        """Distance of the true nozzle from its target, m, turn from the schedule, rad, and least true tension, N."""
        truth, attitude = self.rig.truth, self.path.attitude
        assert attitude is not None
        away = self.path.printing_point(truth.position, truth.rotation) - target
        turn = angle_between(attitude.rotation(float(target[2])), truth.rotation)
        return float(np.linalg.norm(away)), float(turn), float(truth.tensions.min())


def printed(machine: TwinSettings, options: PrintOptions, duration: float) -> np.ndarray:
    """Return the errors (k, 3) of a *duration*, s, since the first step that prints, in m, rad and N."""
    trial = Trial(machine, options)
    rows: list[tuple[float, float, float]] = []
    for step in trial.steps():
        if rows or step.progress.state is PrintState.PRINTING:
            rows.append(trial.errors(step.progress.target))
        if len(rows) * trial.rig.period >= duration or trial.attendant.is_over(trial.printer):
            return np.array(rows)
    raise AssertionError  # it runs for ever


@dataclass(frozen=True)
class Outcome:
    """Of a fault. ``after``: s until a report or a stop, NaN: never; ``named``: s until its cause was named.

    ``error``: m, the largest; ``said``: the cause, or why the machine stopped.
    """

    after: float
    named: float
    error: float
    said: str
    state: PrintState


def faulted(machine: TwinSettings, options: PrintOptions, given: dict[str, object]) -> Outcome:
    """Let one line of a machine have a fault, and watch."""
    begin = _first_print(machine, options) + AFTER
    plan = FaultPlan.model_validate({**given, "line": str(1 + options.seed % 8), "begin": begin})
    trial = Trial(machine.with_simulation(faults=(plan,)), options)
    after, named, said, largest, over = float("nan"), float("nan"), "", 0.0, float("inf")
    for step in trial.steps():
        now, state = trial.rig.time, trial.printer.supervisor.state
        if now < begin:
            continue
        largest = max(largest, trial.errors(step.progress.target)[0])
        heard = [fault.sentence for fault in step.estimate.faults]
        if heard or state is PrintState.FAULT:
            after = float(np.fmin(after, now - begin))
        if not said and (heard or trial.attendant.is_over(trial.printer)):
            named, said = now - begin, "; ".join(heard) or trial.printer.supervisor.reason
        if state is PrintState.FAULT:
            over = min(over, now)
        if now > min(over + REST, begin + WATCHED):
            return Outcome(after, named, largest, said, state)
    raise AssertionError  # it runs for ever


def _first_print(machine: TwinSettings, options: PrintOptions) -> float:
    """Return the time of the first step that prints, s: on a machine of long steps, as it does not depend on them."""
    trial = Trial(machine, replace(options, plant="quasi-static", period=0.2))
    return next(step.frame.time for step in trial.steps() if step.progress.state is PrintState.PRINTING)


def names_the_line(outcome: Outcome, line: str) -> bool:
    """Whether that line, and no other, is named."""
    return {name for pair in re.findall(r"\bline (\d)|\bor (\d)", outcome.said) for name in pair if name} == {line}


def fault_table(machine: TwinSettings, options: PrintOptions, seeds: range, *, each: bool) -> None:
    """Print a row for each fault; *each*: one for each seed, too."""
    print("| fault | told after: median, most | named after: most | of that line | largest error: median, most | end |")
    print("| --- | --- | --- | --- | --- | --- |", flush=True)
    for name, given in FAULTS.items():
        found = []
        for seed in seeds:
            found.append(faulted(machine, replace(options, seed=seed), given))
            if each:
                one = found[-1]
                told = f"{one.after:.2f}, {one.named:.2f} s, {1e3 * one.error:.1f} mm, {one.state}: {one.said}"
                print(f"{seed} {name}: {told}", flush=True)
        keys = ("after", "named", "error")
        after, late, errors = (np.array([getattr(one, key) for one in found]) for key in keys)
        named = sum(names_the_line(one, str(1 + seed % 8)) for one, seed in zip(found, seeds, strict=True))
        count = int(np.isfinite(after).sum())
        times = f"{np.nanmedian(after):.2f}, {np.nanmax(after):.2f} s" if count else "never"
        missed = "" if count == len(found) else f", {len(found) - count} never"
        end = ", ".join(f"{many} {state}" for state, many in Counter(one.state for one in found).items())
        size = f"{1e3 * np.median(errors):.1f}, {1e3 * errors.max():.1f} mm"
        last = f"{np.nanmax(late):.2f} s" if count else "never"
        print(f"| {name} | {times}{missed} | {last} | {named} of {len(found)} | {size} | {end} |", flush=True)


def print_table(machine: TwinSettings, options: PrintOptions, seeds: range, duration: float) -> None:
    """Print a row for each seed: with all sensors, and by lengths alone."""
    print("| seed | `filter`: rms, max | turn | least tension | `encoders`: rms, max | turn | least tension |")
    print("| --- | --- | --- | --- | --- | --- | --- |", flush=True)
    for seed in seeds:
        cells = []
        for name in ("filter", "encoders"):
            errors = printed(machine, replace(options, estimator=name, seed=seed), duration)
            away, turn, least = 1e3 * errors[:, 0], np.degrees(errors[:, 1].max()), errors[:, 2].min()
            rms = np.sqrt((away**2).mean())
            cells.append(f"{rms:.2f}, {away.max():.2f} mm | {turn:.2f} deg | {least:.0f} N")
        print(f"| {seed} | {' | '.join(cells)} |", flush=True)


def main() -> None:
    """Print one of the tables."""
    parser = argparse.ArgumentParser(description="Prints with a rigid platform by seeds.")
    parser.add_argument("--seeds", default="400:410", help="first and the one after the last")
    parser.add_argument("--plant", default="quasi-static", choices=("dynamic", "quasi-static"))
    parser.add_argument("--period", type=float, default=0.2, help="s, of a quasi-static step")
    parser.add_argument("--duration", type=float, default=250.0, help="s, since the first step that prints")
    parser.add_argument("--without", default="", help="sensors that the machine does not have, by commas")
    parser.add_argument("--no-tour", action="store_true", help="without the machine's tour before the print")
    parser.add_argument("--faults", action="store_true", help="the table of faults")
    parser.add_argument("--each", action="store_true", help="of faults, a line for each seed too")
    given = parser.parse_args()
    machine = whole_machine("cogiro").with_owner(**dict.fromkeys(filter(None, given.without.split(","))))
    if given.no_tour:
        assert machine.owner.body is not None
        machine = machine.with_owner(body=machine.owner.body.model_copy(update={"tour": ()}))
    options = PrintOptions("filter", layers=2, plant=given.plant, period=given.period)
    seeds = range(*map(int, given.seeds.split(":")))
    if given.faults:
        fault_table(machine, options, seeds, each=given.each)
    else:
        print_table(machine, options, seeds, given.duration)


if __name__ == "__main__":
    main()
