"""Run machines through random lives, and hold the loop of a print to its promises.

    python tools/random_orders.py --sequences 300000 --seed 1

A life has random orders of two people who hand over to each other, a control that hangs, steps that come late, readings
that are repeated, overtaken or ahead, and faults. Promised, of every step: winches turn only after an order that lets
them, and never beside a person; nothing begins to move but by an order that was given at most a second ago, under the
lease that still holds, and after the last pause; whatever moves by hand or by a procedure ends with its lease; a hang
of the control ends in a fault; no motion ends by its distance from a target of another; after a stop has had its time
winches stand until a reset was accepted, with no cause left and brakes closed; brakes close on winches that
were held, or immediately where one has no torque, and open by an order alone; no line is wound in whose measured
tension was over its limit for longer than a stop takes. A life is determined by its seed. Exit code 1, and the seed, if
a promise was broken.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
from tools.random_world import (
    BARRIER_TIMEOUT,
    BY_HAND,
    LIMIT,
    PERIOD,
    STOP,
    Desk,
    Followed,
    Sent,
    Shaken,
    TakeUp,
    desk,
    plan,
)

from cablewright.control.guard import CONFIRMED
from cablewright.foundation.signals import Command, OrderKind, PrintState, WinchMode
from cablewright.live.prints.loop import Printer, Step

STEPS = 100  # of a life
LIFE = 1.0  # s, of an order
LEASE = 0.2  # s that a jog lasts
SLOWING = 1.0  # s that a controlled stop may take
LATE = 3.0 * PERIOD  # s, of a step that comes late
_MOVE = (PrintState.READY, PrintState.PRINTING, PrintState.MANUAL, PrintState.TENSIONING, PrintState.HOMING)
_STANDS = tuple(state for state in PrintState if state not in _MOVE)
_HANDLED = (PrintState.MANUAL, PrintState.TENSIONING, PrintState.HOMING)
_PROCEDURES = {PrintState.TENSIONING: OrderKind.TAKE_UP, PrintState.HOMING: OrderKind.HOME}
_ENDS = (PrintState.FAULT, PrintState.OFF, PrintState.IDLE, PrintState.STOPPED)
_RELEASING = (*BY_HAND, *_PROCEDURES.values())
_PAUSES = (OrderKind.PAUSE, OrderKind.STOP, OrderKind.EMERGENCY)
_RESUMES = (OrderKind.START, OrderKind.RESUME, OrderKind.REFILLED)
_LOST = "the position is not known"


class Watch:
    """The promises, judged by inputs and outputs alone."""

    def __init__(self, machine: Shaken, people: Desk) -> None:
        """Nothing has been ordered yet, and brakes are closed."""
        m = machine.m
        self.machine, self.people = machine, people
        self.released = False  # whether an order lets the winches turn
        self.still_by = -math.inf  # s, when they are to stand
        self.over_since = np.full(m, math.inf)  # s
        self.person_since = math.inf  # s, in the light barrier, or unseen
        self.before = Command(0.0, np.zeros(m), modes=(WinchMode.OFF,) * m)
        self.zero_since = -math.inf  # s, of the first of the last commands of zero
        self.off_since = -math.inf  # s, of a state in which brakes are to close
        self.hand, self.hand_time = OrderKind.STOP, -math.inf  # last order to move by hand, and when, s
        self.state = PrintState.FAULT
        self.held_back = -math.inf  # s of the computer's clock, of the last pause or stop that the control has read
        self.found_again = True  # whether a lost position that is found again lets the print go on

    def see(self, step: Step, command: Command, *, waits: bool) -> None:
        """Judge one step, which was answered by *command*; *waits*: an order to go on. Raises `AssertionError`."""
        machine, state = self.machine, step.progress.state
        accepted = {order.kind for order in step.orders if not order.refusal}
        self._reset(state, accepted)
        if state in _STANDS and state is not self.state:
            self.still_by = machine.active + (3.0 * STOP.ramp_time if state is PrintState.FAULT else SLOWING)
        if state in _ENDS and state is not self.state:
            self.released = False
        by_hand = [order.kind for order in step.orders if not order.refusal and order.kind in _RELEASING]
        if by_hand:
            self.hand, self.hand_time = by_hand[-1], machine.active
        if accepted & {*_RESUMES, *_RELEASING}:
            self.released = True
        self._pauses(step, accepted)
        self._begins(step, waits=waits)
        self._leases(state)
        assert not (machine.hung and state is not PrintState.FAULT), f"{state} after the control hung"
        assert "from its target" not in step.progress.reason, "stopped by a target that is not its own"
        self._motion(state, command)
        self._brakes(state, command, accepted)
        self._tensions(state, command)
        self.state, self.before = state, command

    def _pauses(self, step: Step, accepted: set[OrderKind]) -> None:
        """A pause is obeyed in every state in which something moves, or might go on."""
        for order in step.orders:
            if order.kind is OrderKind.PAUSE and order.refusal and not accepted & {*_PAUSES}:
                quiet = step.progress.state in (PrintState.FAULT, PrintState.OFF, PrintState.IDLE)
                assert quiet, f"{step.progress.state} goes on: {order.refusal}"
        if accepted & {*_PAUSES}:
            paused = [each.wall for each in self.people.sent if each.kind in _PAUSES]
            self.held_back, self.found_again = max([*paused, self.held_back]), False
        elif self.state is PrintState.PRINTING:
            self.found_again = True
        unseen = self.machine.active - self.person_since > BARRIER_TIMEOUT + LATE
        if self.machine.known_broken or (unseen and not self.machine.is_watched):
            self.found_again = False

    def _begins(self, step: Step, *, waits: bool) -> None:
        """Whatever begins to move does so by an order that lives.

        Of a hang that a simulated machine's clock does not see, an order grows older from the next step on.
        """
        state, wall = step.progress.state, self.machine.wall - self.machine.unseen
        live = [each for each in self.people.sent if self._is_live(each, wall)]
        assert not waits or {each.kind for each in live} & {*_RESUMES}, "an order waits that lives no more"
        begins = state in _MOVE and self.state not in _MOVE
        if self.state is PrintState.OFF and state is PrintState.IDLE:
            assert any(each.kind is OrderKind.ENABLE for each in live), "brakes open by an order that lives no more"
        if not begins or (self.state is PrintState.PAUSED and self.found_again):
            return
        kinds = BY_HAND if state is PrintState.MANUAL else (_PROCEDURES[state],) if state in _HANDLED else _RESUMES
        assert any(each.kind in kinds for each in live), f"{state} by an order that lives no more"
        assert not self.machine.known_broken, f"{state} begins beside a person"

    def _is_live(self, sent: Sent, wall: float) -> bool:
        """Whether an order is young, its lease goes on, and no pause came since the control read it."""
        young = wall - sent.wall <= LIFE + LATE
        return young and sent.lease == self.people.lease and sent.wall >= self.held_back

    def _leases(self, state: PrintState) -> None:
        """What moves by hand, or by a procedure, ends with the lease under which it was ordered."""
        if state in _HANDLED and not self.people.lease:
            gone = self.machine.active - self.people.ended
            assert gone <= 2.0 * LATE, f"{state} goes on {gone:.2f} s after its lease"

    def _reset(self, state: PrintState, accepted: set[OrderKind]) -> None:
        if self.state is not PrintState.FAULT:
            return
        if state is not PrintState.FAULT:
            assert OrderKind.RESET in accepted, f"left the fault for {state} by {sorted(accepted)}"
        if OrderKind.RESET in accepted:
            assert OrderKind.EMERGENCY not in accepted, "reset beside an emergency stop"
            assert state is not PrintState.FAULT, "a reset, and the fault stays"
            for fault in ("drive", "estop"):
                assert not self.machine.is_wrong(fault), f"reset with a cause: {fault}"
            assert WinchMode.OFF in self.before.modes, "reset before brakes are closed"

    def _motion(self, state: PrintState, command: Command) -> None:
        machine = self.machine
        self.person_since = math.inf if machine.is_watched else min(self.person_since, machine.active)
        if not command.winch_speeds.any():
            return
        assert np.isfinite(command.winch_speeds).all()
        assert machine.active - self.person_since < BARRIER_TIMEOUT + SLOWING, f"{state}: it turns beside a person"
        if state is PrintState.MANUAL and self.hand is OrderKind.JOG:
            assert machine.active - self.hand_time < LEASE + SLOWING, "a jog goes on without repetition"
        if state in _MOVE:
            assert self.released, f"the winches turn in {state} without an order"
        else:
            assert machine.active <= self.still_by + 3.0 * PERIOD, f"the winches turn in {state} long after a stop"
        if state is PrintState.FAULT is self.state:
            faster = np.abs(command.winch_speeds) > np.abs(self.before.winch_speeds) + 1e-12
            assert not faster.any(), "a winch turns faster in a fault"

    def _brakes(self, state: PrintState, command: Command, accepted: set[OrderKind]) -> None:
        machine, now = self.machine, self.machine.active  # whatever its clock shows
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

    def _tensions(self, state: PrintState, command: Command) -> None:
        machine = self.machine
        over = machine.tensions > LIMIT
        self.over_since = np.where(over, np.minimum(self.over_since, machine.active), math.inf)
        long = over & (machine.active - self.over_since > STOP.ramp_time + CONFIRMED * 3.0 * PERIOD)
        assert not (long & (command.winch_speeds < 0.0)).any(), "a line over its limit is wound in"
        assert not (long.any() and state in _MOVE), f"{state} with a line over its limit"


def run_sequence(seed: int, body: bool = False) -> set[PrintState]:
    """Run one life, of a point or a *body*; return the states it saw. Raises `AssertionError`."""
    random = np.random.default_rng(seed)
    machine, seen = Shaken(random, body=body), set()
    procedures = dict.fromkeys((PrintState.TENSIONING, PrintState.HOMING), TakeUp(random))
    printer = Printer(replace(plan(body), procedures=procedures), machine, lambda _pose, _radii: Followed(machine))
    with desk(random, machine) as (people, operator):
        watch = Watch(machine, people)
        for _ in range(STEPS):
            people.act()
            step = printer.step(operator.orders(printer, printer.time))
            operator.answered(printer, step.orders, step.frame.time)
            watch.see(step, printer.command, waits=printer.supervisor.resume_ordered)
            people.state = step.progress.state
            seen.add(people.state)
    return seen


def _broken(seeds: range, body: bool) -> str:
    """The first promise that is broken in these sequences; an empty text: none."""
    for seed in seeds:
        try:
            run_sequence(seed, body)
        except AssertionError as error:
            return f"seed {seed}: {error}"
    return ""


def main() -> int:
    """Run as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sequences", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0, help="of the first sequence; the others follow")
    parser.add_argument("--body", action="store_true", help="of a rigid platform instead of a point")
    given = parser.parse_args()
    last = given.seed + given.sequences
    chunks = [range(first, min(first + 500, last)) for first in range(given.seed, last, 500)]
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for number, broken in enumerate(pool.map(_broken, chunks, [given.body] * len(chunks)), start=1):
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
