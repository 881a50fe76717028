"""State of one winch's drive, as its messages on the bus report it."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from cablewright.machine.drives import objects as o
from cablewright.machine.drives.cia402 import (
    ENERGISED,
    FAULT_RESET,
    IN_FAULT,
    PowerState,
    Wish,
    controlword,
    state_of,
)
from cablewright.machine.drives.drum_units import Scale
from cablewright.machine.drives.faults import fault_line
from cablewright.machine.drives.object_transfers import Transfer, Transfers
from cablewright.machine.drives.objects import Mode
from cablewright.machine.drives.parameters import ObjectParameter

STANDS: Final = 0.02
"""Speed of a drum that stands, rad/s."""

FRESH: Final = 0.2
"""Time for which a statusword is believed, s."""


class Setpoint(NamedTuple):
    """Setpoint of a winch for the next cycle. ``speed``: rad/s, ``torque``: N m, of the drum; positive pays out.

    The valve is that of the drive which has its output; of the others it is not read.
    """

    wish: Wish = Wish.OFF
    mode: Mode = Mode.VELOCITY
    speed: float = 0.0
    torque: float = 0.0
    valve: bool = False  # open


@dataclass(eq=False)
class Axis:
    """A drive: its last reported state, and the requests to it.

    ``rest``: s without torque after which its brake has closed. ``valve``: the bit of its outputs, as a mask, that
    opens the valve; 0: it has none.
    """

    name: str
    node: int
    scale: Scale
    rest: float = 0.0
    valve: int = 0
    transfers: Transfers = field(default_factory=Transfers, init=False)
    statusword: int = 0
    mode: int = 0
    counts: int = 0  # of the motor, paying out is positive
    velocity: float = math.nan  # rad/s of the drum, as all angles
    torque: float = math.nan  # N m
    error_code: int = 0
    following_error: float = math.nan  # rad
    inputs: int = 0
    heard: float = -math.inf  # s, of the last complete answer
    state_heard: float = -math.inf  # s, of the last statusword
    inputs_heard: float = -math.inf  # s
    energised: float = math.inf  # s, when it last had torque, or may have had it
    commanded: float = 0.0  # rad/s of the drum, as sent
    restarted: bool = False  # it lost its settings, and they were not written again
    pending: int = 0  # PDOs that this cycle has not brought yet, a bit each
    failure: str = ""  # of its parameters
    notes: list[str] = field(default_factory=list)
    checks: deque[tuple[ObjectParameter, Transfer | None, Transfer]] = field(default_factory=deque)
    _resetting: bool = False

    @property
    def state(self) -> PowerState:
        """State of the drive by its statusword."""
        return state_of(self.statusword)

    @property
    def fault(self) -> str:
        """Text of the drive's fault; empty: none."""
        return fault_line(self.error_code) if self.state in IN_FAULT else ""

    def rests(self, now: float) -> bool:
        """Whether the drive is known to be without torque long enough that its brake has closed."""
        return now - self.state_heard <= FRESH and now - self.energised >= self.rest

    def begin(self, now: float) -> None:
        """Forget the reported state: the drive may have torque."""
        self.statusword, self.mode, self.restarted = 0, 0, False
        self.heard = self.state_heard = self.inputs_heard = -math.inf
        self.energised = now
        self.notes.clear()

    def begin_cycle(self) -> None:
        """Begin a bus cycle: all PDOs (process data) of the drive are expected."""
        self.pending = (1 << len(o.FROM_DRIVES)) - 1

    def take_pdo(self, which: int, data: bytes, now: float) -> bool:
        """Process a PDO (process data) of the drive; False: it has a wrong length."""
        values = o.unpacked(o.FROM_DRIVES[which], data)
        if values is None:
            return False
        scale = self.scale
        if which == 0:
            self.statusword, self.mode, counts = values
            self.counts = counts if scale.counts > 0.0 else -counts
            self.state_heard = now
            if self.state in ENERGISED or self.state is PowerState.NOT_READY:
                self.energised = now
        elif which == 1:
            self.velocity, self.torque = values[0] / scale.speed, values[1] / scale.torque
            self.error_code = values[2]
        else:
            self.following_error, self.inputs = values[0] / scale.counts, values[1]
            self.inputs_heard = now
        self.pending &= ~(1 << which)
        if not self.pending:
            self.heard = now
        return True

    @property
    def mapped(self) -> tuple[tuple[o.Object, ...], ...]:
        """Objects that the PDOs carry to the drive."""
        return o.TO_DRIVE_WITH_VALVE if self.valve else o.TO_DRIVES

    def commands(self, setpoint: Setpoint, now: float, *, reset: bool) -> tuple[bytes, bytes]:
        """Return the PDOs that command *setpoint* at *now*, s.

        *reset*: whether to reset a fault, once the brake has closed. The valve is open only of a drive that is enabled.
        """
        rests, moves = self.rests(now), setpoint.wish is Wish.ENABLED
        held = self.mode == Mode.VELOCITY and abs(self.velocity) < STANDS
        word = controlword(setpoint.wish, self.state, rests=rests, held=held)
        if reset and rests and self.state is PowerState.FAULT and not self._resetting:
            word = FAULT_RESET
        self._resetting = word == FAULT_RESET
        speed = round(setpoint.speed * self.scale.speed) if moves and setpoint.mode is Mode.VELOCITY else 0
        torque = round(setpoint.torque * self.scale.torque) if moves and setpoint.mode is Mode.TORQUE else 0
        self.commanded = speed / self.scale.speed
        control = o.CONTROLWORD.pack(word) + o.MODE.pack(setpoint.mode) + o.TARGET_VELOCITY.pack(speed)
        opens = moves and setpoint.valve and self.state is PowerState.ENABLED
        outputs = o.OUTPUTS.pack(self.valve if opens else 0) if self.valve else b""
        return control, o.TARGET_TORQUE.pack(torque) + outputs

    def check(self, parameters: list[ObjectParameter], *, write: bool) -> None:
        """Start to read parameters back, after writing them if *write*; `failure` has the reason of an error."""
        for each in parameters:
            written = self.transfers.add(Transfer(each.object, each.value)) if write and not each.given else None
            self.checks.append((each, written, self.transfers.add(Transfer(each.object))))

    @property
    def checking(self) -> bool:
        """Return whether parameters are still being transferred; judge finished ones."""
        while self.checks and self.checks[0][2].done:
            self._judge(*self.checks.popleft())
        return bool(self.checks)

    def _judge(self, parameter: ObjectParameter, written: Transfer | None, read: Transfer) -> None:
        what = str(parameter.object)
        if read.absent and parameter.optional:
            self.notes.append(f"has no {what}")
            return
        if read.failure:
            self._fail(f"{what}: {read.failure}")
        elif not parameter.agrees(read.result):
            why = f" ({written.failure})" if written is not None and written.failure else ""
            self._fail(f"{what} = {read.result}, not {parameter.value} as it should be{why}")

    def _fail(self, why: str) -> None:
        self.failure = self.failure or why
        self.transfers.clear()
        self.checks.clear()
