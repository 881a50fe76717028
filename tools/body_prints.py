"""Print with a rigid platform on machines as built by many seeds, with all sensors and by lengths alone: a table.

    python tools/body_prints.py                                # the table of docs/bodies.md, in a quarter of an hour
    python tools/body_prints.py --plant dynamic --seeds 500:503 --duration 60
    python tools/body_prints.py --fault line:broken --plant dynamic --seeds 500:510 --duration 60

True values: distance of the nozzle from its target and turn from the schedule, in each step since the first that
prints; least tension in them. With a fault, of the line 1 + seed modulo 8 from 20 s on, the state and its reason are
shown.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from cablewright.control.guide import TimedPath
from cablewright.machine.simulated.settings import FaultPlan, TwinSettings, whole_machine
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.rotation import angle_between
from cablewright.printing.job import Job, load_job
from cablewright.robot import load
from cablewright.signals import PrintState
from cablewright.studies.estimators import estimator
from cablewright.studies.prints.attendant import Attendant
from cablewright.studies.prints.loop import Printer
from cablewright.studies.prints.plan import PrintOptions, plan_print, twin_of

HOUSE = Path(__file__).resolve().parent.parent / "examples" / "house.toml"
SCALE = 12.0
SIZES = {"slip": 0.02, "offset": 150.0}  # m, N


def faulty(machine: TwinSettings, fault: str, seed: int) -> TwinSettings:
    """Return the *machine* with a *fault*, ``source:kind``, of one line."""
    source, _, kind = fault.partition(":")
    given = {"source": source, "kind": kind, "line": str(1 + seed % 8), "begin": 20.0, "size": SIZES.get(kind)}
    return machine.with_simulation(faults=(FaultPlan.model_validate(given),))


def printed(job: Job, machine: TwinSettings, options: PrintOptions, duration: float) -> tuple[str, Printer]:
    """Print for a *duration*, s; return the figures as text, and the printer."""
    twin = twin_of(load("cogiro"), job, machine, options)
    plan, path = plan_print(twin), twin.path
    rig = SimulatedMachine(twin.robot, twin.settings, path.start_pose, seed=options.seed, plant=options.plant)
    printer = Printer(
        plan, rig, lambda place, radii: estimator(twin.estimator, twin.robot, rig.settings, place, (), radii)
    )
    attendant = Attendant(lambda: None)
    rows: list[tuple[float, float, float]] = []
    while rig.time < duration:
        step = printer.step(attendant.orders(printer, rig.time))
        if rows or step.progress.state is PrintState.PRINTING:
            rows.append(_errors(path, rig, step.progress.target))
        if attendant.is_over(printer):
            break
    errors = np.array(rows)
    away, turn, least = 1e3 * errors[:, 0], np.degrees(errors[:, 1].max()), errors[:, 2].min()
    rms = np.sqrt((away**2).mean())
    return f"rms {rms:.2f} mm, max {away.max():.2f} mm, turn {turn:.2f} deg, least tension {least:.0f} N", printer


def _errors(path: TimedPath, rig: SimulatedMachine, target: np.ndarray) -> tuple[float, float, float]:
    truth, attitude = rig.truth, path.attitude
    assert attitude is not None
    away = path.printing_point(truth.position, truth.rotation) - target
    turn = angle_between(attitude.rotation(float(target[2])), truth.rotation)
    return float(np.linalg.norm(away)), float(turn), float(truth.tensions.min())


def main() -> None:
    """Print a line for each seed and estimator."""
    parser = argparse.ArgumentParser(description="Prints with a rigid platform by seeds.")
    parser.add_argument("--seeds", default="400:410", help="first and the one after the last")
    parser.add_argument("--plant", default="quasi-static", choices=("dynamic", "quasi-static"))
    parser.add_argument("--period", type=float, default=0.2, help="s, of a quasi-static step")
    parser.add_argument("--duration", type=float, default=250.0, help="s")
    parser.add_argument("--fault", default="", help="source:kind, as in a machine file; then only the filter")
    given = parser.parse_args()
    first, last = map(int, given.seeds.split(":"))
    job, machine = load_job(HOUSE).model_copy(update={"scale": SCALE}), whole_machine("cogiro")
    for seed in range(first, last):
        own = faulty(machine, given.fault, seed) if given.fault else machine
        for name in ("filter",) if given.fault else ("filter", "encoders"):
            options = PrintOptions(name, layers=2, plant=given.plant, period=given.period, seed=seed)
            text, printer = printed(job, own, options, given.duration)
            said = [fault.sentence for fault in printer.estimator.step(printer.machine.step(printer.command)).faults]
            state = printer.supervisor.state
            print(f"{seed} {name}: {text}; {state} {printer.supervisor.reason} {'; '.join(said)}", flush=True)


if __name__ == "__main__":
    main()
