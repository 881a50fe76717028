"""Virtual drives on one bus, and the simulated plant that they move, in virtual time or by the clock."""

from __future__ import annotations

import heapq
import math
import time
from collections import deque
from collections.abc import Callable
from itertools import count
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Command, WinchMode
from cablewright.machine.drives.can_bus import BusError, CanFrame, Port
from cablewright.machine.drives.drives_of_winches import require_drives
from cablewright.machine.drives.objects import SYNC
from cablewright.machine.drives.virtual.virtual_drive import VirtualDrive
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Robot

_TICKS: Final = 5  # of the drives, in a step of the plant
MADE_UP: Final = 0.5
"""Time that is made up for after the computer was held up, s."""

_YIELD: Final = 0.2  # share of a line's stiffness by which a motor under torque yields in a step

Disturb = Callable[[CanFrame, float], tuple[float, ...]]
"""Delays, s, of the copies in which a frame sent at a time arrives: ``(0.0,)`` as it should, ``()`` lost."""


class VirtualRig:
    """Drives with a simulated machine behind them, each winch at its drive's speed.

    ``reversed_lines``: lines whose motor turns the other way than the machine file says.
    """

    def __init__(
        self,
        robot: Robot,
        settings: TwinSettings,
        start: ArrayLike,
        *,
        seed: int = 0,
        reversed_lines: tuple[str, ...] = (),
    ) -> None:
        """A platform at rest at *start* (3,), m, with brakes closed. Raises as `SimulatedMachine`."""
        owner = settings.owner
        drives, winch = require_drives(owner, robot), owner.winch
        self.plant = SimulatedMachine(robot, settings, start, seed=seed)
        self.names, self._lines = robot.winch_names, WinchLines.of(robot)
        flipped = np.array([-1.0 if name in reversed_lines else 1.0 for name in self.names])
        self.signs = np.array([drives.nodes[name].direction for name in self.names]) * flipped
        self.per_radian = winch.counts * winch.ratio / math.tau
        self.ratio, self.ticks = winch.ratio, 0
        self._phase: int | None = None
        unit = float(winch.counts) if drives.speed_unit is None else drives.speed_unit
        self.drives = tuple(
            VirtualDrive(drives.nodes[name].id, drives.rated_torque, winch.counts, unit, 0.5 * drives.brake_time)
            for name in self.names
        )
        self._valve = drives.valve
        for drive in self.drives:
            drive.keeps_outputs = drives.valve is not None and not drives.valve.closes_alone
        self._cables = np.array([float(line.cables) for line in robot.lines])
        self._axial = self._cables * np.array([line.cable.stiffness for line in robot.lines])
        self._base = np.zeros(len(self.drives))
        self._turned = np.zeros(len(self.drives))
        self._load()

    @property
    def tick(self) -> float:
        """Time step of the virtual drives, s."""
        return self.plant.period / _TICKS

    @property
    def now(self) -> float:
        """Virtual time, s."""
        return self.ticks * self.plant.period / _TICKS

    def hear(self, frame: CanFrame, now: float) -> list[CanFrame]:
        """Pass a frame to all drives; return their answers.

        Each SYNC, from the first on, ends a step of the plant.
        """
        if frame.id == SYNC and self._phase is None:
            self._phase = self.ticks % _TICKS
        for drive in self.drives:
            drive.hear(frame, now)
        return self._said()

    def advance(self, now: float | None = None) -> list[CanFrame]:
        """Advance by a tick, to *now* (None: virtual time); return frames that drives send by themselves."""
        self.ticks += 1
        at = self.now if now is None else now
        for i, drive in enumerate(self.drives):
            drive.tick(at, self.tick)
            self._turned[i] += drive.speed / _TICKS
        if self.ticks % _TICKS == (self._phase or 0):
            speeds = self.signs * self._turned / self.per_radian
            self._turned[:] = 0.0
            modes = tuple(
                WinchMode.OFF if drive.brake_closed and speed == 0.0 else WinchMode.VELOCITY
                for drive, speed in zip(self.drives, speeds, strict=True)
            )
            self.plant.step(Command(self.plant.time, speeds, float(self.valve_open), modes))
            self._load()
        return self._said()

    @property
    def valve_open(self) -> bool:
        """Whether the output of the valve is set."""
        valve = self._valve
        return valve is not None and bool(self.drives[self.names.index(valve.line)].outputs >> valve.bit & 1)

    def warm(self) -> None:
        """Compile or load the kernels of the plant, and leave its state unchanged."""
        for _ in range(3):
            self.plant.step(Command(self.plant.time, np.zeros(len(self.drives))))
        self._load()

    def refill(self) -> None:
        """Fill the container to its initial level."""
        self.plant.refill(self.plant.settings.carrier.powder)
        self._load()

    def turn_by_hand(self, line: str, length: float) -> None:
        """Pay out *length* (m) of a line, as if a person turned its drum by hand with all power off."""
        i, steps = self.names.index(line), 50
        speeds = np.zeros(len(self.names))
        speeds[i] = length / self.plant.truth.radii[self._lines.hosts[i]] / (steps * self.plant.period)
        before = self._counts()
        for given in (*(speeds,) * steps, *(np.zeros(len(speeds)),) * steps):  # at the end it stands
            self.plant.step(Command(self.plant.time, given))
        self._base -= self._counts() - before  # no encoder has seen it
        self._load()

    def _counts(self) -> Array:
        return np.asarray(self.signs * self.plant.rig.winches.counts)

    def _load(self) -> None:
        truth, positions = self.plant.truth, self._base + self._counts()
        arms = self._cables * truth.radii
        torques = self.signs * self._lines.torques(truth.tensions, arms) / self.ratio
        stiff = self._axial / np.maximum(truth.lengths, 0.1)  # N/m
        stiff = np.abs(self._lines.senses) @ (stiff * truth.radii**2)  # N m/rad
        mobilities = _YIELD / (stiff * self.plant.period) * self.ratio * self.per_radian
        for drive, *own in zip(self.drives, positions.tolist(), torques.tolist(), mobilities.tolist(), strict=True):
            drive.position, drive.load, drive.mobility = own

    def _said(self) -> list[CanFrame]:
        said = []
        for drive in self.drives:
            if not drive.dead:
                said += drive.outbox
            drive.outbox.clear()
        return said


class VirtualPort:
    """A `Port` to a rig in virtual time, which advances only while a member waits."""

    def __init__(self, rig: VirtualRig, disturb: Disturb | None = None) -> None:
        """*disturb* loses, delays or doubles frames."""
        self.rig, self._disturb = rig, disturb
        self._order = count()
        self._late: list[tuple[float, int, bool, CanFrame]] = []  # to be delivered: time, order, to the drives, frame
        self._arrived: deque[CanFrame] = deque()
        self.down = False  # bus off

    def now(self) -> float:
        """Return the time, s, by the clock of `receive`; see `Port.now`."""
        return self.rig.now

    def send(self, frame: CanFrame) -> None:
        """Send one frame; see `Port.send`."""
        if self.down:
            raise BusError("bus off")
        self._pass(frame, to_drives=True)

    def receive(self, until: float) -> CanFrame | None:
        """Return the next frame of other members until a time, s; see `Port.receive`."""
        while True:
            if self._arrived and not self.down:
                return self._arrived.popleft()
            if self.rig.now >= until - 1e-9:
                return None
            for frame in self.rig.advance():
                self._pass(frame, to_drives=False)
            while self._late and self._late[0][0] <= self.rig.now + 1e-9:
                _, _, to_drives, frame = heapq.heappop(self._late)
                self._deliver(frame, to_drives)

    def close(self) -> None:
        """Leave the bus; see `Port.close`."""

    def inject(self, frame: CanFrame) -> None:
        """Add a frame of a foreign device to the bus."""
        self._deliver(frame, to_drives=True)
        self._arrived.append(frame)

    def _pass(self, frame: CanFrame, to_drives: bool) -> None:
        delays = (0.0,) if self._disturb is None else self._disturb(frame, self.rig.now)
        for delay in delays:
            if delay <= 0.0:
                self._deliver(frame, to_drives)
            else:
                heapq.heappush(self._late, (self.rig.now + delay, next(self._order), to_drives, frame))

    def _deliver(self, frame: CanFrame, to_drives: bool) -> None:
        if self.down:
            return
        if not to_drives:
            self._arrived.append(frame)
            return
        for answer in self.rig.hear(frame, self.rig.now):
            self._pass(answer, to_drives=False)


def run_rig(rig: VirtualRig, port: Port, ends: Callable[[], bool] = lambda: False) -> None:
    """Run virtual drives by the clock on the bus behind *port*, until *ends*; a longer standstill is skipped."""
    due = port.now()
    while not ends():
        due += rig.tick
        while (frame := port.receive(due)) is not None:
            _answer(port, rig.hear(frame, port.now()))
        now = port.now()
        due = max(due, now - MADE_UP)
        _answer(port, rig.advance(now))


def _answer(port: Port, frames: list[CanFrame]) -> None:
    for frame in frames:
        try:
            port.send(frame)
        except BusError:
            time.sleep(0.01)
