"""A machine on which everything goes wrong at random, and people who operate it: the world of `random_orders`."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from cablewright.control.guard import GuardSettings
from cablewright.control.manual import ManualSettings
from cablewright.control.path_follower import TimedPath
from cablewright.control.procedure import ProcedureStep
from cablewright.control.stop import StopSettings
from cablewright.control.supervisor import SupervisorSettings
from cablewright.control.velocity import VelocitySettings
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import (
    Barrier,
    Command,
    Condition,
    Encoders,
    Estimate,
    Inputs,
    Notice,
    OrderKind,
    PrintState,
    Reading,
    SensorFrame,
    Tensions,
    WinchMode,
    frozen,
)
from cablewright.live.prints.loop import PrintPlan
from cablewright.live.serve.events import Events
from cablewright.live.serve.latest_shared_message import shared
from cablewright.live.serve.link import LEASE, ControlLink, ServerLink
from cablewright.live.serve.messages import ChannelName, OrderMessage
from cablewright.live.serve.page_orders import PageOperator
from cablewright.machine.interface import Abilities
from cablewright.models.rotation import moved
from cablewright.models.statics import Model
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load
from cablewright.solvers.taut import taut_at

PERIOD = 0.05  # s
LIMIT = 300.0  # N
USUAL = 100.0  # N
COUNTS = 1000.0  # per radian of a drum
RADIUS = 0.05  # m
STOP = StopSettings(ramp_time=0.2, hold_time=0.2)
BARRIER_TIMEOUT = 0.5  # s
HUNG, HANG = 0.3, 12.0  # s that a control hangs, at least and at most
BY_HAND = (OrderKind.JOG, OrderKind.GO_TO, OrderKind.PARK)

_MIDDLE = np.array([0.3, -0.5, 1.0])  # m
_FAULTS = ("tension", "quiet", "person", "dark", "stale", "overtaken", "ahead", "estop", "drive", "lost", "clock")
_SENSIBLE = {
    PrintState.FAULT: (OrderKind.RESET,),
    PrintState.OFF: (OrderKind.ENABLE,),
    PrintState.IDLE: (OrderKind.START, *BY_HAND, OrderKind.JOG, OrderKind.TAKE_UP, OrderKind.HOME),
    PrintState.MANUAL: (OrderKind.JOG, OrderKind.STOP),
    PrintState.PAUSED: (OrderKind.RESUME,),
    PrintState.STOPPED: (OrderKind.RESUME, OrderKind.RESET),
    PrintState.REFILLING: (OrderKind.REFILLED,),
}
_HUNG = tuple(each for each in Condition if each.value == "the control hung")


@cache
def plan(body: bool = False) -> PrintPlan:
    """A ring on a point robot, or with a *body*, with short times so that a sequence sees every state."""
    ring = Job(
        name="ring",
        origin=(0.3, -0.5, 0.0),
        helix=Helix(radius=0.05, layers=1, layer_height=0.001, first_height=1.0),
        motion=Motion(print_speed=0.2, travel_speed=0.2, acceleration=1.0),
    )
    robot = load("ipanema" if body else "merlet2023")
    path = TimedPath.of(ring, nozzle=robot.platform.own_nozzle)
    scene = robot.scene
    limits = SupervisorSettings(
        scene.frame_min,
        scene.frame_max,
        1.0,
        barrier_timeout=BARRIER_TIMEOUT,
        settling_time=0.1,
        position_timeout=1.0,
        tensioning_timeout=0.3,
    )
    guard = GuardSettings(np.full(robot.m, LIMIT), max_drum_speed=20.0, counts_per_radian=COUNTS, stop=STOP)
    manual = ManualSettings(scene.frame_min, scene.frame_max, 1.0, park=(0.0, 0.0, 1.0))
    velocity = VelocitySettings(Model(robot), 10.0, "model" if body else "paper")
    return PrintPlan(path, velocity, limits, guard, manual, powder=0.5, flow=0.5)


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
    """A machine that moves as it is commanded, with faults for a while, and with a control that hangs now and then.

    ``wall``: s, of the computer's clock; ``active``: s, without the times in which the control hung. The machine's own
    clock is one of them: a simulated one stands still while the control hangs.
    """

    period = PERIOD

    def __init__(self, random: np.random.Generator, *, calm: bool = False, body: bool = False) -> None:
        """Begin with everything well, at the start of the path; *calm*: nothing ever goes wrong. *body*: see `plan`."""
        self.calm, self.model = calm, plan(body).velocity.model
        self.random, self.time, self.m = random, 0.0, self.model.m
        self.wall = self.active = 0.0
        self.simulated = bool(random.random() < 0.5)
        self.pose = plan(body).path.start_pose.copy()
        self.angles = np.zeros(self.m)
        self.tensions = np.full(self.m, USUAL)
        self.jammed = 0  # line that pulls too hard during such a fault
        self.wrong: dict[str, float] = {}  # s until which a fault lasts
        self.hang_due = 0.0  # s, for which the control hangs in the next step
        self.unseen = 0.0  # s of the last step that its own clock did not see
        self.hung = False  # whether it hung in the last one
        self.cleared = 0.0  # s, of the last reading of a clear barrier that the control may believe
        self.known_broken = False  # whether the newest reading that was sent is of a broken one

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
        elapsed = PERIOD * (3.0 if self._happens(0.03) else 1.0)
        self._move(command.winch_speeds, elapsed)  # drives stop by themselves while the control hangs
        self.wall += elapsed + self.hang_due
        self.active += elapsed
        self.unseen = self.hang_due if self.simulated else 0.0
        self.time += elapsed + self.hang_due - self.unseen
        self.hung, self.hang_due = self.hang_due > 1.0, 0.0
        if self._happens(0.03):
            fault = str(self.random.choice(_FAULTS))
            self.wrong[fault] = self.time + float(self.random.exponential(self.random.choice([0.3, 1.5])))
            if fault == "overtaken":
                self.wrong["person"] = self.wrong[fault]
        self.tensions = np.full(self.m, USUAL)
        if self.is_wrong("tension"):
            self.tensions[self.jammed] = LIMIT * float(self.random.uniform(1.05, 2.0))
        else:
            self.jammed = int(self.random.integers(self.m))
        readings: list[Reading] = [Tensions("load_cells", self.time, frozen(self.tensions))]
        if not self.is_wrong("quiet"):
            readings.append(Encoders(self.time, np.rint(COUNTS * self.angles).astype(np.int64)))
        readings += self._barrier()
        if self.random.random() < 0.5 or self.is_wrong("estop"):
            readings.append(Inputs(self.time, not self.is_wrong("estop"), False, True, ()))
        notices = [Notice(Condition.DRIVE_FAULT, "line 1")] if self.is_wrong("drive") else []
        if self.hung:
            notices += [Notice(each, "12 s") for each in _HUNG]
        now = self.time - (1.0 if self.is_wrong("clock") else 0.0)
        return SensorFrame(now, tuple(readings), tuple(notices))

    def _happens(self, chance: float) -> bool:
        return bool(self.random.random() < chance) and not self.calm

    def _move(self, speeds: Array, elapsed: float) -> None:
        self.angles += elapsed * speeds
        along = taut_at(self.model, self.pose).per_motion
        motion = np.linalg.lstsq(along, RADIUS * speeds, rcond=None)[0]
        self.pose = moved(self.pose, np.asarray(elapsed * motion, dtype=np.float64))

    def _barrier(self) -> list[Reading]:
        """Readings of the light barrier: none, one that is repeated, overtaken or ahead, or that of now."""
        broken = self.is_wrong("person")
        if self.is_wrong("dark"):
            return []
        if self.is_wrong("stale"):
            return [Barrier(self.cleared, False)]
        if self.is_wrong("ahead"):
            return [Barrier(self.time + 5.0, False)]
        self.known_broken = broken
        if not broken:
            self.cleared = self.time
        found = [Barrier(self.time, broken)]
        return [*found, Barrier(self.time - 0.2, False)] if self.is_wrong("overtaken") else list(found)

    @property
    def is_watched(self) -> bool:
        """Whether the control can know by a fresh reading that the barrier is clear."""
        unseen = any(map(self.is_wrong, ("dark", "stale", "ahead")))
        return not (unseen or self.known_broken)


class Followed:
    """An estimator that knows where the machine is, unless the position is lost."""

    tensions: Array | None = None

    def __init__(self, machine: Shaken) -> None:
        """Of that *machine*."""
        self.machine = machine

    def step(self, frame: SensorFrame) -> Estimate:
        """As `Estimator`."""
        pose, m = self.machine.pose, self.machine.m
        place, lengths = frozen(pose[:3]), taut_at(self.machine.model, pose).lengths
        zeros, none = frozen(np.zeros(3)), frozen(np.zeros(m))
        slack, radii = np.zeros(m, dtype=np.bool_), frozen(np.full(m, RADIUS))
        valid = not self.machine.is_wrong("lost")
        turned = frozen(pose[3:]) if len(pose) == 6 else zeros
        return Estimate(frame.time, place, zeros, turned, frozen(lengths), none, slack, radii, valid=valid)


@dataclass(frozen=True)
class Sent:
    """An order as it was given: its kind, when, s of the computer's clock, under which lease."""

    kind: OrderKind
    wall: float
    lease: int


@dataclass(eq=False)
class Desk:
    """Two people, of whom one operates, and the server's end of the link. ``sent``: their orders, the latest last."""

    random: np.random.Generator
    machine: Shaken
    control: ControlLink
    server: ServerLink
    lease: int = 0
    ended: float = 0.0  # s of the machine's active time, when the last lease ended
    person: str = "anna"
    haste: float = 0.4  # share of the steps in which people give orders
    sent: list[Sent] = field(default_factory=list)
    state: PrintState = PrintState.FAULT
    _acted: float = 0.0  # s
    _count: int = 0

    def act(self) -> None:
        """What people do before a step, and have done while the control hung in the last one."""
        now, begin = self.machine.wall, self._acted
        if now - begin > HUNG:
            for wall in sorted(self.random.uniform(begin, now, 4)):
                self._act(float(wall))
        self._act(now)
        self._acted = now
        self.machine.hang_due = float(self.random.uniform(HUNG, HANG)) if self.random.random() < 0.01 else 0.0

    def _act(self, wall: float) -> None:
        chance = self.random.random()
        if self.lease and chance < 0.02:
            self.lease, self.ended = 0, self.machine.active
        elif not self.lease and chance < 0.4:
            self._count += 1
            self.lease, self.person = self._count, str(self.random.choice(["anna", "ben"]))
        self._tell(wall)
        if self.random.random() < self.haste:
            for kind in self._kinds():
                self._send(kind, wall)

    def _tell(self, wall: float) -> None:
        self.server.clock = lambda: wall
        self.server.tell_lease(self.lease)

    def _kinds(self) -> list[OrderKind]:
        """One order that the state suggests, or one or two of any kind."""
        usual = _SENSIBLE.get(self.state)
        if usual is not None and self.random.random() < 0.7:
            return [usual[int(self.random.integers(len(usual)))]]
        kinds = np.array([*OrderKind], dtype=object)
        return list(self.random.choice(kinds, int(self.random.integers(1, 3))))

    def _send(self, kind: OrderKind, wall: float) -> None:
        self._count += 1
        if self.random.random() < 0.05:  # it was long on its way
            wall = max(0.0, wall - float(self.random.uniform(0.0, 3.0)))
        place = tuple((_MIDDLE + self.random.normal(0.0, 0.3, 3)).tolist())
        arguments = {
            OrderKind.JOG: {"velocity": tuple(self.random.normal(0.0, 0.1, 3).tolist())},
            OrderKind.GO_TO: {"position": place},
            OrderKind.OVERRIDE: {"share": (float(self.random.uniform(-0.2, 1.3)),)},
        }.get(kind, {})
        self.sent = [*self.sent[-40:], Sent(kind, wall, self.lease)]
        channel: ChannelName = "stops" if kind is OrderKind.EMERGENCY else "orders"
        about = {"by": self.person, "number": self._count, "at": wall, "lease": self.lease}
        self.server.send(OrderMessage.model_validate(about | {"kind": kind, "arguments": arguments}), channel)


@contextmanager
def desk(random: np.random.Generator, machine: Shaken) -> Iterator[tuple[Desk, PageOperator]]:
    """People at a page, and what makes orders of their messages."""
    control = ControlLink(shared(64), shared(64), shared(LEASE.size), clock=lambda: machine.wall)
    orders, stops = control.connect()
    for each in (orders, stops):
        each.setblocking(False)
    server = ServerLink(control.state, control.sitting, control.told_lease, orders, stops)
    events = Events.at(Path(os.devnull))
    operator = PageOperator(control, events, True, lambda _: "", lambda: None, lambda: False)
    try:
        yield Desk(random, machine, control, server, haste=float(random.choice([0.02, 0.1, 0.4]))), operator
    finally:
        for each in (orders, stops):
            each.close()
        events.close()
        control.close()
