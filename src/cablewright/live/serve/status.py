"""Status messages to all pages: the latest state as JSON, and the latest message of each topic of the log."""

from __future__ import annotations

import json
import math
import struct
import time
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic_core import to_json

from cablewright.control import supervisor
from cablewright.control.path_follower import TimedPath
from cablewright.control.transitions import TRANSITIONS
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import EnvironmentFault
from cablewright.foundation.signals import (
    Barrier,
    Drives,
    Estimate,
    Inputs,
    OrderKind,
    PrintState,
    Scan,
    Tensions,
    WinchMode,
)
from cablewright.live.prints.loop import Printer, Step, StepRecorder
from cablewright.live.serve.events import Events
from cablewright.live.serve.link import ControlLink
from cablewright.live.serve.operated_machines import Sitting
from cablewright.live.serve.page_orders import PageOperator
from cablewright.machine.log.head import written_head
from cablewright.machine.log.messages import encode, encode_frame
from cablewright.machine.log.segments import CLOSING_TOPIC
from cablewright.machine.log.topics import Signal
from cablewright.models.plane import directions
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Plane

STATE_STEPS: Final = 2
"""Steps between two states that are sent."""

TOPIC_STEPS: Final = 5
"""Steps between two messages of a topic."""

_LENGTHS: Final = struct.Struct("=II")


def packed_state(state: bytes, topics: bytes) -> bytes:
    """Return state and topics as one message of bytes."""
    return _LENGTHS.pack(len(state), len(topics)) + state + topics


def unpacked_state(message: bytes) -> tuple[bytes, bytes]:
    """Return the JSON of the state, and that of the topics, from one message."""
    first, second = _LENGTHS.unpack_from(message, 0)
    begin = _LENGTHS.size
    return message[begin : begin + first], message[begin + first : begin + first + second]


@dataclass(eq=False)
class Telling:
    """A `StepRecorder` that sends each step to the pages, in addition to one that saves it.

    ``lost``: why that one cannot keep the run any more. The machine is stopped then, and `gives_up` once it is at rest.
    """

    link: ControlLink
    sitting: Sitting
    operator: PageOperator
    events: Events
    kept: StepRecorder | None = None
    number: int = 0  # of the sitting
    lost: EnvironmentFault | None = None
    _steps: int = 0
    _last: dict[str, Any] = field(default_factory=dict, repr=False)  # last readings by key of the state
    _signals: dict[str, Signal] = field(default_factory=dict, repr=False)  # by topic
    _topics: dict[str, bytes] = field(default_factory=dict, repr=False)
    _shown: dict[str, Any] = field(default_factory=dict, repr=False)

    def add(self, printer: Printer, step: Step, *, last: bool) -> None:
        """Record one step for the operator's page; see `StepRecorder.add`."""
        if self.kept is not None:
            try:
                self.kept.add(printer, step, last=last)
            except EnvironmentFault as fault:
                self.kept, self.lost = None, fault
                supervisor.fail(printer.supervisor, step.frame.time, f"the run cannot be kept: {fault}")
        self._steps += 1
        self.operator.answered(printer, step.orders, step.frame.time)
        self._read(step)
        self._note(step)
        if self._steps % TOPIC_STEPS == 0:
            self._encode(step)
        if last or self._steps % STATE_STEPS == 0:
            state = to_json(self._state(printer, step), inf_nan_mode="null")
            self.link.state.write(packed_state(state, b"[" + b",".join(self._topics.values()) + b"]"))

    @property
    def begun(self) -> bool:
        """Whether the machine has run a step."""
        return self._steps > 0

    def gives_up(self, printer: Printer) -> bool:
        """Whether the sitting ends because its run cannot be saved: once the winches are at rest and brakes closed."""
        if self.lost is None:
            return False
        brakes = WinchMode.OFF in printer.machine.abilities.modes
        standing = WinchMode.OFF in printer.command.modes if brakes else not printer.command.winch_speeds.any()
        return standing or printer.supervisor.state is not PrintState.FAULT

    def _read(self, step: Step) -> None:
        for reading in step.frame.readings:
            if isinstance(reading, Tensions):
                self._last["measured"] = reading.tensions.tolist()
            elif isinstance(reading, Drives):
                torques = _numbers(reading.torques)
                self._last["drives"] = {"states": reading.states, "faults": reading.faults, "torques": torques}
            elif isinstance(reading, Inputs):
                self._last["inputs"] = {
                    "chain": reading.chain_closed,
                    "torque_off": reading.torque_off,
                    "brakes": reading.brakes_closed,
                }
            elif isinstance(reading, Barrier):
                self._last["barrier"] = reading.broken
            if isinstance(reading, Scan):
                self._signals[f"scan {reading.source}"] = reading
            elif isinstance(reading, Tensions):
                self._signals[f"tensions {reading.source}"] = reading
            else:
                self._signals[type(reading).__name__] = reading
        for order in step.orders:
            self._signals["order"] = order

    def _encode(self, step: Step) -> None:
        """Encode the latest of each topic, once."""
        head, now = self.sitting.head, step.frame.time
        winches = head.robot.winch_names
        signals: dict[str, Signal] = {"command": step.command, "estimate": step.estimate, "progress": step.progress}
        for key, signal in (self._signals | signals).items():
            topic, data = encode(signal, winches, head.settings.winch.counts, head.epoch_ns)
            self._put(key, topic, now, data)
        self._put("frame", *_told_frame(step))
        self._signals.clear()

    def _put(self, key: str, topic: str, now: float, data: bytes) -> None:
        stamp = self.sitting.head.epoch_ns + round(now * 1e9)
        self._topics[key] = b'["%s",%d,%s]' % (topic.encode(), stamp, data)

    def _note(self, step: Step) -> None:
        """Send changes of state, faults and notices as events."""
        state = f"{step.progress.state.value}{f': {step.progress.reason}' if step.progress.reason else ''}"
        if self._shown.get("state") != state:
            self._shown["state"] = state
            self.events.tell("state", state)
        faults = {f"{each.source}: {each.sentence}" for each in step.estimate.faults}
        notices = {f"{each.condition}{f': {each.subject}' if each.subject else ''}" for each in step.frame.notices}
        for kind, now in (("fault", faults), ("notice", notices)):
            before = self._shown.get(kind, set())
            for text in sorted(now - before):
                self.events.tell(kind, text)
            self._shown[kind] = now if kind == "fault" else before | now
        self._shown["notices"] = notices

    def _state(self, printer: Printer, step: Step) -> dict[str, Any]:
        progress, estimate, supervised = step.progress, step.estimate, printer.supervisor
        path, path_time = self.sitting.path, printer.guide.path_time
        return {
            "sitting": self.number,
            "steps": self._steps,
            "clock": time.monotonic(),
            "utc": time.time(),
            "time": step.frame.time,
            "state": progress.state,
            "reason": progress.reason,
            "fresh": supervised.is_new,
            "since": supervised.state_start if math.isfinite(supervised.state_start) else 0.0,
            "finished": printer.finished,
            "layer": progress.layer,
            "distance": progress.distance,
            "piece": path.track.piece(progress.distance),
            "path_time": path_time,
            "left": (path.duration - path_time) / printer.speed_share if printer.speed_share > 0.0 else None,
            "share": printer.speed_share,
            "error": progress.error,
            "target": progress.target.tolist(),
            "known": math.isfinite(supervised.valid_since),
            "powder": printer.load.left,
            "waiting": supervised.resume_ordered,
            "jogged": self.operator.jogged,
            "modes": [mode.value for mode in step.command.modes],
            "speeds": step.command.winch_speeds.tolist(),
            "valve": step.command.valve,
            "damping": printer.damps and bool(step.command.winch_speeds.any()),
            "lines": _lines(estimate, printer.estimator.tensions if path.attitude is None else printer.tensions),
            "platform": _platform(path, estimate),
            "faults": [f"{each.source}: {each.sentence}" for each in estimate.faults],
            "notices": sorted(self._shown.get("notices", ())),
            "events": list(self.events.told),
            "answers": list(self.events.answers),
        } | self._last


def _told_frame(step: Step) -> tuple[str, float, bytes]:
    return CLOSING_TOPIC, step.frame.time, encode_frame(step.frame)


def _lines(estimate: Estimate, tensions: Array | None) -> dict[str, Any]:
    return {
        "tensions": _numbers(tensions),
        "lengths": _numbers(estimate.lengths),
        "excess": _numbers(estimate.excess),
        "slack": estimate.slack.tolist(),
    }


def _platform(path: TimedPath, estimate: Estimate) -> dict[str, Any]:
    covariance = estimate.covariance
    deviation = None if covariance is None else np.sqrt(np.diag(covariance)[:3]).tolist()
    return {
        "valid": estimate.valid,
        "position": estimate.position.tolist(),
        "velocity": estimate.velocity.tolist(),
        "rotation": estimate.rotation.tolist(),
        "nozzle": None
        if path.attitude is None
        else path.attitude.nozzle_at(estimate.position, estimate.rotation).tolist(),
        "deviation": deviation,
    }


def _numbers(values: Array | None) -> list[float] | None:
    return None if values is None else values.tolist()


def told_sitting(
    number: int,
    sitting: Sitting,
    job: str | None,
    run: str | None,
    rejected: tuple[str, str] | None = None,
    *,
    resumed: bool = False,
) -> bytes:
    """Return the data of a sitting that stay constant, as JSON.

    *job*: number of its folder. *run*: name of the run's folder. *rejected*: number of a job that the machine could not
    take up before this sitting, and why. *resumed*: the run was cut off, and goes on.
    """
    printer, path, owner = sitting.printer, sitting.path, sitting.head.settings
    plan, numbers = printer.plan, np.unique(path.track.layer[path.track.laying])
    about = {
        "sitting": number,
        "rejected": None if rejected is None else {"job": rejected[0], "why": rejected[1]},
        "head": written_head(sitting.head),
        "kind": sitting.head.kind,
        "robot": sitting.head.robot.name,
        "machine": owner.name,
        "lines": [line.name for line in sitting.head.robot.lines],
        "winches": WinchLines.of(sitting.head.robot).winch.tolist(),
        "hosts": sitting.head.robot.hosts,
        "limits": [list(line.tension_limits) for line in sitting.head.robot.lines],
        "stops_at": plan.guard.max_tensions.tolist(),
        "cable": owner.winch.held,
        "frame": [list(plan.manual.min_position), list(plan.manual.max_position)],
        "jog_speed": plan.manual.max_speed,
        "winch_names": list(sitting.head.robot.winch_names) if sitting.winches else None,
        "plane": None if plan.manual.plane is None else _plane_of(plan.manual.plane),
        "park": plan.manual.park is not None,
        "procedures": sitting.procedures,
        "orders": allowed_orders(),
        "damped": plan.velocity.damps,
        "powder": plan.powder if math.isfinite(plan.powder) else None,
        "period": printer.machine.period,
        "job": None if sitting.job is None else {"id": job, "name": sitting.job.name},
        "run": run,
        "resumed": resumed,
        "path": _path_of(path, numbers) if sitting.job is not None else None,
    }
    return to_json(about, inf_nan_mode="null")


def _plane_of(plane: Plane) -> dict[str, Any]:
    """The plane of motions by hand: unit normal, distance, m, and two directions in it."""
    along = directions(plane, 3).T
    return {"normal": plane.across, "distance": plane.distance, "along": along.tolist()}


def allowed_orders() -> dict[str, list[str]]:
    """Return the states in which each order is allowed, from the supervisor's table."""
    found = {kind.value: [state.value for state in PrintState if (state, kind) in TRANSITIONS] for kind in OrderKind}
    found[OrderKind.RESUME.value] = [PrintState.PAUSED.value, PrintState.STOPPED.value]
    found[OrderKind.REFILLED.value] = [PrintState.REFILLING.value]
    return found


def _path_of(path: TimedPath, numbers: NDArray[np.int32]) -> dict[str, Any]:
    return {"length": path.track.length, "duration": path.duration, "layers": len(numbers)}


def waiting_state(number: int, what: str, events: Events, *, opening: bool = False) -> bytes:
    """Return the state between two sittings, in which no machine is open: nothing moves.

    *opening*: the next one begins.
    """
    told = {
        "sitting": number,
        "clock": time.monotonic(),
        "utc": time.time(),
        "state": "closed",
        "opening": opening,
        "reason": what,
        "events": list(events.told),
        "answers": list(events.answers),
    }
    return packed_state(json.dumps(told).encode(), b"[]")
