"""The latest state for all pages: read from the control's memory, with the shapes of the lines."""

from __future__ import annotations

import asyncio
import json
import logging
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from pydantic_core import from_json, to_json

from cablewright.apps.serve.live_scene import Shapes, live_scene
from cablewright.apps.serve.operators import Operators
from cablewright.foundation.errors import CablewrightError
from cablewright.live.serve.control_process import JOBS
from cablewright.live.serve.jobs import SCENE
from cablewright.live.serve.link import ServerLink
from cablewright.live.serve.status import unpacked_state
from cablewright.machine.log.head import LogHead, read_head

EVERY: Final = 0.04
"""Between two states that a page gets, s."""

STALE: Final = 0.5
"""Age from which a state counts as old, s."""


@dataclass(eq=False)
class Feed:
    """Reader of the control's latest state, once for all pages. `text` is the message to them."""

    link: ServerLink
    operators: Operators
    folder: Path
    text: str = ""
    version: int = 0
    state: dict[str, Any] = field(default_factory=dict)
    sitting: dict[str, Any] = field(default_factory=dict)
    sitting_text: str = "null"
    head: LogHead | None = None
    shapes: Shapes | None = None
    scene: bytes | None = None
    topics: bytes = b"[]"
    stops: int = 0  # that were sent, by whoever
    _seen: int = 0
    _sitting_seen: int = 0
    _news: asyncio.Condition = field(default_factory=asyncio.Condition)
    _begin: float = field(default_factory=time.monotonic)
    _draws: asyncio.Task[None] | None = None

    def beat(self) -> int:
        """Time now, ms since the server began; pages report the beat that they have seen."""
        return round(1e3 * (time.monotonic() - self._begin))

    async def run(self) -> None:
        """Read the machine control's latest state repeatedly."""
        while True:
            self.refresh()
            async with self._news:
                self._news.notify_all()
            await asyncio.sleep(EVERY)

    def refresh(self) -> None:
        """Read the latest state, and make the text of it."""
        number, data = self.link.sitting.read()
        if number and number != self._sitting_seen:
            self._sitting_seen = number
            self._begin_sitting(data)
        number, data = self.link.state.read()
        if number:
            state, self.topics = unpacked_state(data)
            if number != self._seen:
                self._seen, self.state = number, from_json(state)
        else:
            state = b"null"
        self.link.tell_lease(self.operators.lease)
        age = time.monotonic() - float(self.state.get("clock", -1e9))
        told = {
            "t": "state",
            "beat": self.beat(),
            "age": min(age, 1e6),
            "operator": self._operator(),
            "stops": self.stops,
            "watching": len(self.operators.clients),
            "curves": self._curves() if self.operators.clients else None,
        }
        self.text = f'{json.dumps(told)[:-1]},"control":{state.decode()}}}'
        self.version += 1

    async def next(self, version: int) -> int:
        """Wait for a later version of the state, and return it."""
        async with self._news:
            await self._news.wait_for(lambda: self.version > version)
        return self.version

    def answer_of(self, number: int, by: str) -> str | None:
        """Return the control's answer to a message; None: none yet."""
        for known, who, refusal in reversed(self.state.get("answers", ())):
            if known == number and who == by:
                return str(refusal)
        return None

    def _begin_sitting(self, data: bytes) -> None:
        self.sitting = from_json(data)
        self.head, self.shapes, self.scene = read_head(self.sitting.pop("head"), "the control"), None, None
        self.sitting_text = json.dumps({"t": "sitting"} | self.sitting)
        self._draws = asyncio.get_running_loop().create_task(self._draw(self.sitting, self.head))

    async def _draw(self, sitting: dict[str, Any], head: LogHead) -> None:
        """Make the scene of a sitting and the solver of its lines in a thread: kernels may be compiled."""
        try:
            scene, shapes = await asyncio.to_thread(_drawn, head, self._scene_file(sitting))
        except CablewrightError as error:
            logging.getLogger("cablewright").warning("the view: %s", error)
            return
        if sitting is self.sitting:
            self.scene, self.shapes = scene, shapes
            self.sitting_text = json.dumps({"t": "sitting", "scene": True} | self.sitting)

    def _scene_file(self, sitting: dict[str, Any]) -> Path | None:
        job = sitting.get("job")
        return None if job is None else self.folder / JOBS / str(job["id"]) / SCENE

    def _operator(self) -> dict[str, str] | None:
        found = self.operators.operator
        return None if found is None else {"number": found.number, "title": found.title}

    def _curves(self) -> list[int] | None:
        if self.shapes is None or "lines" not in self.state or self.state.get("sitting") != self.sitting.get("sitting"):
            return None
        return self.shapes.curves(self.state)


def _drawn(head: LogHead, file: Path | None) -> tuple[bytes, Shapes]:
    """The scene as JSON: that in the *file* of a job's check, or of the robot alone; and its lines, once drawn."""
    scene = live_scene(head) if file is None or not file.is_file() else from_json(file.read_bytes())
    text = to_json(scene)
    shapes = Shapes(head, scene)
    rest = {"platform": {"position": head.robot.scene.frame_min, "rotation": (0.0, 0.0, 0.0)}}
    shapes.curves(rest | {"lines": {"lengths": [1.0] * head.robot.m}})  # compiled here
    return text, shapes
