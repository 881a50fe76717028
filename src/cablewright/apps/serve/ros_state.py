"""The machine's latest state for ROS 2: readings, estimate, transforms, joint states, diagnostics; read only.

DDS has no password here: who can reach the domain can read it. The names are those of `export ros2`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Final

from pydantic_core import from_json, to_json

from cablewright.apps.serve.feed import STALE, Feed
from cablewright.exchange.ros.messages import RosMessage, RosMessages
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Estimate, PrintState, Tensions
from cablewright.machine.log.messages import decode

STATUS_EVERY: Final = 0.5
"""Between two messages of an unchanged status, s."""

_OK, _WARNING, _ERROR, _STALE = range(4)  # levels of diagnostic_msgs/msg/DiagnosticStatus
_VALUES: Final = ("layer", "distance", "error", "left", "powder", "share")


class RosState:
    """Publisher of the machine's state to ROS 2."""

    def __init__(self, feed: Feed, write: Callable[[RosMessage], None]) -> None:
        """*write*: takes each message."""
        self.feed, self.write = feed, write
        self._sitting: object = None
        self._messages: RosMessages | None = None
        self._sent: dict[str, int] = {}  # time of the last message, by topic of the log
        self._tensions: dict[str, Tensions] = {}  # as measured last, by source
        self._status: tuple[float, Any] = (-1e9, None)  # when the last one was sent, and what it said

    async def run(self) -> None:
        """Publish until cancelled. Raises `EnvironmentFault` where the network rejects it."""
        version = 0
        while True:
            version = await self.feed.next(version)
            self.step()

    def step(self) -> None:
        """Publish the parts of the state that are new."""
        feed = self.feed
        if feed.sitting is not self._sitting:
            self._sitting = feed.sitting
            self._messages = None if feed.head is None else RosMessages(feed.head)
            self._sent.clear()
            self._tensions.clear()
        if self._messages is not None:
            for topic, stamp, data in from_json(feed.topics):
                if self._sent.get(topic) != stamp:
                    self._sent[topic] = stamp
                    signal = decode(topic, to_json(data), "the control")
                    if isinstance(signal, Tensions):
                        self._tensions[signal.source] = signal
                    efforts = self._efforts(signal.time) if isinstance(signal, Estimate) else None
                    for message in self._messages.latest(signal, efforts):
                        self.write(message)
        self._send_status()

    def _efforts(self, now: float) -> Array | None:
        """Return the tensions (m,), N, of the first source with a reading no older than `STALE` at *now*, s."""
        found = (self._tensions.get(source.name) for source in Tensions.SOURCES)
        return next((each.tensions for each in found if each is not None and now - each.time <= STALE), None)

    def _send_status(self) -> None:
        """Send the status where it has changed, and regularly."""
        state, now = self.feed.state, time.monotonic()
        stale = now - float(state.get("clock", -1e9)) > STALE
        content = _status(state, self.feed.sitting, stale=stale)
        since, before = self._status
        key = (content["level"], content["message"])
        if key == before and now - since < STATUS_EVERY:
            return
        self._status = now, key
        at = time.time_ns()
        sec, nanosec = divmod(at, 1_000_000_000)
        fields = {"header": {"stamp": {"sec": sec, "nanosec": nanosec}}, "status": [content]}
        self.write(RosMessage("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", at, fields))


def _status(state: dict[str, Any], sitting: dict[str, Any], *, stale: bool) -> dict[str, Any]:
    """One status: of the machine, in the control's words."""
    told = str(state.get("state", "the control does not answer"))
    message = f"{told}: {state['reason']}" if state.get("reason") else told
    faults = [*state.get("faults", ()), *state.get("notices", ())]
    broken = (told == PrintState.FAULT and not state.get("fresh")) or (told == "closed" and not state.get("opening"))
    halted = told == PrintState.STOPPED or (told == PrintState.PAUSED and bool(state.get("reason")))
    level = _ERROR if broken else _WARNING if halted or faults else _OK
    values = {name: state[name] for name in _VALUES if state.get(name) is not None}
    listed = {f"fault {number}": text for number, text in enumerate(faults, 1)}
    return {
        "level": _STALE if stale else level,
        "name": f"cablewright: {sitting.get('machine', 'machine')}",
        "message": message,
        "hardware_id": str(sitting.get("robot", "")),
        "values": [{"key": key, "value": str(value)} for key, value in (values | listed).items()],
    }
