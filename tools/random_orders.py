"""Run machines through random orders and injected faults, and hold the loop of a print to its promises.

    python tools/random_orders.py --sequences 100000 --seed 1

Promised, of every step: winches turn only after an order that lets them, and never beside a person; after a stop has
had its time they stand until a reset was accepted, with no cause left and brakes closed; brakes close on winches that
were held, or at once where one has no torque, and open by an order alone; no line is wound in whose measured tension
was over its limit for longer than a stop takes. A sequence is determined by its seed. Exit code 1, and the seed, if a
promise was broken.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import cache

import numpy as np

from cablewright.arrays import Array
from cablewright.control.guard import CONFIRMED, GuardSettings
from cablewright.control.guide import TimedPath
from cablewright.control.manual import ManualSettings
from cablewright.control.procedure import ProcedureStep
from cablewright.control.stop import StopSettings
from cablewright.control.supervisor import SupervisorSettings
from cablewright.control.velocity import VelocitySettings
from cablewright.machine.interface import Abilities
from cablewright.models.statics import Model
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load
from cablewright.signals import (
    Barrier,
    Command,
    Condition,
    Encoders,
    Estimate,
    Inputs,
    Notice,
    Order,
    OrderKind,
    PrintState,
    Reading,
    SensorFrame,
    Tensions,
    WinchMode,
    frozen,
)
from cablewright.solvers.taut import taut_at
from cablewright.studies.prints.loop import Printer, PrintPlan, Step

PERIOD = 0.05  # s
STEPS = 80  # of a sequence
LIMIT = 300.0  # N
USUAL = 100.0  # N
COUNTS = 1000.0  # per radian of a drum
RADIUS = 0.05  # m
STOP = StopSettings(ramp_time=0.2, hold_time=0.2)
_MOVE = (PrintState.READY, PrintState.PRINTING, PrintState.MANUAL, PrintState.TENSIONING, PrintState.HOMING)
_STANDS = tuple(state for state in PrintState if state not in _MOVE)
_RELEASING = (OrderKind.JOG, OrderKind.GO_TO, OrderKind.PARK, OrderKind.TAKE_UP, OrderKind.HOME)
LEASE = 0.2  # s that a jog lasts
SLOWING = 1.0  # s that a controlled stop may take


@cache
def plan() -> PrintPlan:
    """A ring on a point robot, with short times so that a sequence sees every state."""
    ring = Job(
        name="ring",
        origin=(0.3, -0.5, 0.0),
        helix=Helix(radius=0.05, layers=1, layer_height=0.001, first_height=1.0),
        motion=Motion(print_speed=0.2, travel_speed=0.2, acceleration=1.0),
    )
    robot, path = load("merlet2023"), TimedPath.of(ring)
    scene = robot.scene
    limits = SupervisorSettings(
        scene.frame_min, scene.frame_max, 1.0, barrier_timeout=0.5, settling_time=0.1, position_timeout=1.0
    )
    guard = GuardSettings(np.full(robot.m, LIMIT), max_drum_speed=20.0, counts_per_radian=COUNTS, stop=STOP)
    manual = ManualSettings(scene.frame_min, scene.frame_max, 1.0, park=(0.0, 0.0, 1.0))
    velocity = VelocitySettings(Model(robot), 10.0, "paper")
    return PrintPlan(path, velocity, limits, guard, manual, powder=1.0, flow=0.5)


class TakeUp:
    """A procedure that winds all lines in for a while, and fails now and then."""

    def __init__(self, random: np.random.Generator) -> None:
        """*random* draws how long it takes, and whether it fails."""
        self.random, self.end = random, math.inf

    def begin(self, now: float) -> None:
        """As `Procedure`."""
        self.end = now + float(self.random.uniform(0.1, 0.6))

    def step(self, frame: SensorFrame, estimate: Estimate, dt: float) -> ProcedureStep:
        """As `Procedure`."""
        m, done = len(estimate.lengths), frame.time + dt > self.end
        fails = "a line does not come" if done and self.random.random() < 0.3 else ""
        return ProcedureStep(np.full(m, 0.0 if done else -0.1), finished=done, failure=fails)


class Shaken:
    """A machine on which everything goes wrong at random, for a while; its tensions are what a fault makes them."""

    def __init__(self, random: np.random.Generator) -> None:
        """Begin with everything well."""
        self.random, self.time, self.m = random, 0.0, plan().velocity.model.m
        self.angles = np.zeros(self.m)
        self.tensions = np.full(self.m, USUAL)
        self.jammed = 0  # line that pulls too hard during such a fault
        self.wrong: dict[str, float] = {}  # s until which a fault lasts

    period = PERIOD

    @property
    def abilities(self) -> Abilities:
        """With brakes, and without anything of a simulation."""
        return Abilities(self.m, frozenset({"encoders"}), frozenset(WinchMode) - {WinchMode.TENSION}, brakes=True)

    def open(self) -> None:
        """As `Machine`."""

    def stop(self) -> None:
        """As `Machine`."""

    def close(self) -> None:
        """As `Machine`."""

    def is_wrong(self, fault: str) -> bool:
        """Whether that fault is present."""
        return self.wrong.get(fault, -1.0) >= self.time

    def step(self, command: Command) -> SensorFrame:
        """As `Machine`."""
        late = self.random.random() < 0.03
        self.time += PERIOD * (3.0 if late else 1.0)
        if self.random.random() < 0.04:
            fault = str(self.random.choice(["tension", "quiet", "person", "dark", "estop", "drive", "lost", "clock"]))
            self.wrong[fault] = self.time + float(self.random.exponential(0.4))
        self.angles += PERIOD * (3.0 if late else 1.0) * command.winch_speeds
        self.tensions = np.full(self.m, USUAL)
        if self.is_wrong("tension"):
            self.tensions[self.jammed] = LIMIT * float(self.random.uniform(1.05, 2.0))
        else:
            self.jammed = int(self.random.integers(self.m))
        readings: list[Reading] = [Tensions("load_cells", self.time, frozen(self.tensions))]
        if not self.is_wrong("quiet"):
            readings.append(Encoders(self.time, np.rint(COUNTS * self.angles).astype(np.int64)))
        if not self.is_wrong("dark"):
            readings.append(Barrier(self.time, self.is_wrong("person")))
        if self.random.random() < 0.5 or self.is_wrong("estop"):
            readings.append(Inputs(self.time, not self.is_wrong("estop"), False, True, ()))
        notices = (Notice(Condition.DRIVE_FAULT, "line 1"),) if self.is_wrong("drive") else ()
        now = self.time - (1.0 if self.is_wrong("clock") else 0.0)
        return SensorFrame(now, tuple(readings), notices)


class Followed:
    """An estimator of a machine that follows its target exactly, unless the position is lost."""

    def __init__(self, machine: Shaken) -> None:
        """Begin at the start of the path."""
        self.machine, self.printer = machine, None
        self.place = plan().path.track.at(0.0).position
        self.tensions: Array | None = None

    printer: Printer | None

    def step(self, frame: SensorFrame) -> Estimate:
        """As `Estimator`."""
        target = None if self.printer is None else self.printer.target
        if target is not None:
            self.place = target.position
        lengths = taut_at(plan().velocity.model, self.place).lengths
        zeros, none = frozen(np.zeros(3)), frozen(np.zeros(self.machine.m))
        valid = not self.machine.is_wrong("lost")
        slack, radii = np.zeros(self.machine.m, dtype=np.bool_), frozen(np.full(self.machine.m, RADIUS))
        return Estimate(frame.time, frozen(self.place), zeros, zeros, frozen(lengths), none, slack, radii, valid=valid)


def random_orders(random: np.random.Generator, now: float) -> tuple[Order, ...]:
    """None in most steps; else one or two, sensible or not."""
    if random.random() < 0.6:
        return ()
    usual = [OrderKind.RESET, OrderKind.ENABLE, OrderKind.START, OrderKind.RESUME, OrderKind.REFILLED, OrderKind.JOG]
    kinds = random.choice(np.array([*usual * 3, *OrderKind], dtype=object), int(random.integers(1, 3)))
    place = tuple((np.array([0.3, -0.5, 1.0]) + random.normal(0.0, 0.3, 3)).tolist())
    arguments = {
        OrderKind.JOG: {"velocity": tuple(random.normal(0.0, 0.1, 3).tolist())},
        OrderKind.GO_TO: {"position": place},
        OrderKind.OVERRIDE: {"share": (float(random.uniform(-0.2, 1.3)),)},
    }
    by = str(random.choice(["anna", "ben"]))
    return tuple(Order(kind, by, now, arguments.get(kind, {})) for kind in kinds)


class Watch:
    """The promises, told by what goes in and out alone."""

    def __init__(self) -> None:
        """Nothing has been ordered yet, and brakes are closed."""
        m = plan().velocity.model.m
        self.released = False  # whether an order lets the winches turn
        self.still_by = -math.inf  # s, when they are to stand
        self.over_since = np.full(m, math.inf)  # s
        self.person_since = math.inf  # s, in the light barrier, or unseen
        self.before = Command(0.0, np.zeros(m), modes=(WinchMode.OFF,) * m)
        self.zero_since = -math.inf  # s, of the first of the last commands of zero
        self.off_since = -math.inf  # s, of a state in which brakes are to close
        self.hand, self.hand_time = OrderKind.STOP, -math.inf  # last order to move by hand, and when, s
        self.state = PrintState.FAULT

    def see(self, machine: Shaken, step: Step, command: Command) -> None:
        """Judge one step, which was answered by *command*. Raises `AssertionError`."""
        state = step.progress.state
        accepted = {order.kind for order in step.orders if not order.refusal}
        self._reset(machine, state, accepted)
        if state in _STANDS and state is not self.state:
            self.still_by = machine.time + (3.0 * STOP.ramp_time if state is PrintState.FAULT else SLOWING)
        ends = (PrintState.FAULT, PrintState.OFF, PrintState.IDLE, PrintState.STOPPED)
        if state in ends and state is not self.state:
            self.released = False
        by_hand = [order.kind for order in step.orders if not order.refusal and order.kind in _RELEASING]
        if by_hand:
            self.hand, self.hand_time = by_hand[-1], machine.time
        if accepted & {OrderKind.START, OrderKind.RESUME, OrderKind.REFILLED, *_RELEASING}:
            self.released = True
        self._motion(machine, state, command)
        self._brakes(machine, state, command, accepted)
        self._tensions(machine, state, command)
        self.state, self.before = state, command

    def _reset(self, machine: Shaken, state: PrintState, accepted: set[OrderKind]) -> None:
        if self.state is not PrintState.FAULT:
            return
        if state is not PrintState.FAULT:
            assert OrderKind.RESET in accepted, f"left the fault for {state} by {sorted(accepted)}"
        if OrderKind.RESET in accepted:
            assert OrderKind.EMERGENCY not in accepted, "reset beside an emergency stop"
            assert state is not PrintState.FAULT, "a reset, and the fault stays"
            for fault in ("drive", "estop"):
                assert not machine.is_wrong(fault), f"reset with a cause: {fault}"
            assert WinchMode.OFF in self.before.modes, "reset before brakes are closed"

    def _motion(self, machine: Shaken, state: PrintState, command: Command) -> None:
        bad = machine.is_wrong("person") or machine.is_wrong("dark")
        self.person_since = min(self.person_since, machine.time) if bad else math.inf
        if not command.winch_speeds.any():
            return
        assert np.isfinite(command.winch_speeds).all()
        assert machine.time - self.person_since < 0.5 + SLOWING, f"{state}: it turns beside a person"
        if state is PrintState.MANUAL and self.hand is OrderKind.JOG:
            assert machine.time - self.hand_time < LEASE + SLOWING, "a jog that nobody repeats goes on"
        if state in _MOVE:
            assert self.released, f"the winches turn in {state} without an order"
        else:
            assert machine.time <= self.still_by + 3.0 * PERIOD, f"the winches turn in {state} long after a stop"
        if state is PrintState.FAULT is self.state:
            faster = np.abs(command.winch_speeds) > np.abs(self.before.winch_speeds) + 1e-12
            assert not faster.any(), "a winch turns faster in a fault"

    def _brakes(self, machine: Shaken, state: PrintState, command: Command, accepted: set[OrderKind]) -> None:
        now = machine.time  # whatever its clock tells
        closed, were = WinchMode.OFF in command.modes, WinchMode.OFF in self.before.modes
        if were and not closed:
            assert OrderKind.ENABLE in accepted, f"brakes open in {state} without an order"
        if closed and not were:
            held = now - self.zero_since >= STOP.hold_time - 1e-9
            assert held or machine.is_wrong("drive"), f"brakes close in {state} on winches that were not held"
        if state not in (PrintState.FAULT, PrintState.OFF):
            self.off_since = math.inf
        elif self.off_since == math.inf:
            self.off_since = now
        if now - max(self.zero_since, self.off_since) > 3.0 * STOP.hold_time + 4.0 * PERIOD:  # all steps may be late
            assert closed, f"brakes stay open in {state}"
        if command.winch_speeds.any():
            self.zero_since = math.inf
        elif self.zero_since == math.inf:
            self.zero_since = now

    def _tensions(self, machine: Shaken, state: PrintState, command: Command) -> None:
        over = machine.tensions > LIMIT
        self.over_since = np.where(over, np.minimum(self.over_since, machine.time), math.inf)
        long = over & (machine.time - self.over_since > STOP.ramp_time + CONFIRMED * 3.0 * PERIOD)
        assert not (long & (command.winch_speeds < 0.0)).any(), "a line over its limit is wound in"
        assert not (long.any() and state in _MOVE), f"{state} with a line over its limit"


def run_sequence(seed: int) -> set[PrintState]:
    """Run one sequence; return the states it saw. Raises `AssertionError`."""
    random = np.random.default_rng(seed)
    machine = Shaken(random)
    estimator = Followed(machine)
    procedures = dict.fromkeys((PrintState.TENSIONING, PrintState.HOMING), TakeUp(random))
    printer = Printer(replace(plan(), procedures=procedures), machine, lambda _place, _radii: estimator)
    estimator.printer = printer
    watch, seen = Watch(), set()
    for _ in range(STEPS):
        step = printer.step(random_orders(random, printer.time))
        watch.see(machine, step, printer.command)
        seen.add(step.progress.state)
    return seen


def _broken(seeds: range) -> str:
    """The first promise that is broken in these sequences; an empty text: none."""
    for seed in seeds:
        try:
            run_sequence(seed)
        except AssertionError as error:
            return f"seed {seed}: {error}"
    return ""


def main() -> int:
    """Run as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sequences", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0, help="of the first sequence; the others follow")
    given = parser.parse_args()
    last = given.seed + given.sequences
    chunks = [range(first, min(first + 500, last)) for first in range(given.seed, last, 500)]
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for number, broken in enumerate(pool.map(_broken, chunks), start=1):
            if broken:
                sys.stdout.write(f"{broken}\n")
                return 1
            if number % 20 == 0:
                sys.stdout.write(f"{chunks[number - 1].stop - given.seed} sequences\n")
                sys.stdout.flush()
    sys.stdout.write(f"{given.sequences} sequences of {STEPS} steps from seed {given.seed}: no promise broken\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
