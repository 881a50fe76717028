"""`cablewright serve` as a process of its own, a client of its page that is no browser, and what a slicer sends."""

from __future__ import annotations

import base64
import http.client
import json
import os
import signal
import struct
import subprocess
import sys
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cablewright.printing.trial_part import first_part
from cablewright.robot import load

PATIENCE = 90.0  # s
FRESH = 1.5  # s, of a state
RING = """
schema = 1
name = "ring"
[helix]
radius = "0.5 m"
layers = 3
layer_height = "20 mm"
first_height = "20 mm"
[bead]
width = "60 mm"
height = "20 mm"
[motion]
print_speed = "0.25 m/s"
travel_speed = "0.25 m/s"
acceleration = "0.5 m/s^2"
"""


@dataclass
class Served:
    """A server that runs: its address with the token, and its folder."""

    process: subprocess.Popen[str]
    address: str
    view: str  # address of the live log
    folder: Path
    said: list[str] = field(default_factory=list)

    @property
    def token(self) -> str:
        return self.address.partition("#")[2]

    @property
    def port(self) -> int:
        return int(self.address.split(":")[2].split("/")[0])

    @property
    def origin(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def ask(self, method: str, path: str, body: bytes | str | None = None, **headers: str) -> tuple[int, str, Any]:
        """Status, text and headers of one request; by the token unless other headers are given."""
        given = {name.replace("_", "-"): value for name, value in headers.items()} or {
            "authorization": f"Bearer {self.token}"
        }
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        try:
            connection.putrequest(method, path, skip_host="host" in given)
            data = body.encode() if isinstance(body, str) else body
            for name, value in given.items():
                connection.putheader(name, value)
            if data is not None:
                connection.putheader("content-length", str(len(data)))
            connection.endheaders()
            with suppress(BrokenPipeError, ConnectionResetError):
                if data is not None:
                    connection.send(data)
            answer = connection.getresponse()
            return answer.status, answer.read().decode("utf-8", "replace"), dict(answer.getheaders())
        finally:
            connection.close()

    def cookie(self) -> str:
        """A cookie as a browser gets it."""
        status, _, headers = self.ask("POST", "/enter", self.token, origin=self.origin)
        assert status == 200
        return str(headers["set-cookie"]).split(";")[0]

    def server(self) -> int:
        """The process of the page's server."""
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        for thread in Path(f"/proc/{self.process.pid}/task").iterdir():
            children += (thread / "children").read_text().split()
        return next(int(each) for each in children if b"serve.server" in Path(f"/proc/{each}/cmdline").read_bytes())


@contextmanager
def served(folder: Path, *arguments: str, ready: bool = True) -> Iterator[Served]:
    """A server of *arguments* at a free port, until its machine is open."""
    command = [sys.executable, "-m", "cablewright", "serve", *arguments, "--port", "0", "--out", str(folder)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=os.environ | {"NUMBA_NUM_THREADS": "1"})
    assert process.stderr is not None
    before, address = "", process.stderr.readline()
    while address and "/enter#" not in address:  # such as that kernels are compiled
        before, address = before + address, process.stderr.readline()
    if not address:
        raise AssertionError(before)
    made = Served(process, address.strip(), process.stderr.readline().split()[-1], folder)
    reading = threading.Thread(target=lambda: made.said.extend(process.stderr or ()), daemon=True)
    reading.start()
    try:
        if ready:
            with client(made) as watching:
                watching.until(lambda state: state.get("state") not in (None, "closed"))
        yield made
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        with suppress(subprocess.TimeoutExpired):
            process.wait(timeout=30)
        process.kill()
        process.wait()
        reading.join(timeout=5)
        process.stderr.close()


class Client:
    """One page that is open, without a browser."""

    def __init__(self, socket: Any) -> None:
        self.socket = socket
        self.page, self.beat, self.operator, self.sitting = "", 0, None, {}
        self.states: list[dict[str, Any]] = []
        self.told: list[dict[str, Any]] = []
        self._count = 0

    @property
    def state(self) -> dict[str, Any]:
        return self.states[-1] if self.states else {}

    def hear(self, patience: float = 0.2) -> bool:
        """Take one message; whether one came."""
        try:
            message = json.loads(self.socket.recv(timeout=patience))
        except TimeoutError:
            return False
        if message is None:  # the control has no state yet
            return False
        if message["t"] == "state":
            self.beat, self.operator = message["beat"], message["operator"]
            if message["control"] is not None:
                self.states.append(message["control"])
        elif message["t"] == "hello":
            self.page = message["page"]
        elif message["t"] == "sitting":
            self.sitting = message
        else:
            self.told.append(message)
        return True

    def until(self, condition: Callable[[dict[str, Any]], Any], patience: float = PATIENCE) -> None:
        """Hear until the state is so, and is no old unread one."""
        end = time.monotonic() + patience
        while not (time.monotonic() - self.state.get("clock", -1e9) < FRESH and condition(self.state)):
            self.hear()
            assert time.monotonic() < end, self.state

    def during(self, seconds: float) -> None:
        """Hear for a while, and be there."""
        self.send(t="beat")
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.hear(0.02)

    def send(self, **message: Any) -> None:
        self.socket.send(json.dumps(message))

    def order(self, kind: str, **arguments: Any) -> str:
        """Give an order; returns why it was rejected, or an empty text."""
        return self._answer("answer", self.ask(kind, **arguments))

    def ask(self, kind: str, **arguments: Any) -> int:
        """Give an order; returns its number, without waiting for the answer."""
        self._count += 1
        self.send(t="order", id=self._count, kind=kind, arguments=arguments)
        return self._count

    def take(self, name: str = "Ann") -> str:
        """Operate."""
        self.told.clear()
        self.send(t="take", name=name)
        return self._answer("lease", None)

    def ready(self) -> None:
        """Operate, reset and enable the machine, until its position is known."""
        self.until(lambda state: state.get("state") not in (None, "closed"))
        end = time.monotonic() + 20.0  # until the page before has gone
        while why := self.take():
            assert time.monotonic() < end, why
            self.during(0.2)
        if self.state["state"] == "fault":
            self.until(lambda state: self.order("reset") == "" or state["state"] != "fault")
        self.until(lambda state: state["state"] in ("off", "idle"))
        if self.state["state"] == "off":
            assert self.order("enable") == ""
        self.until(lambda state: state["state"] == "idle" and state["known"])

    def jog(self, velocity: Any, number: int, beat: int | None = None) -> None:
        """Send one lease of a jog, on the latest state."""
        while self.hear(0.0):
            pass
        self.send(t="jog", seq=number, beat=self.beat if beat is None else beat, velocity=list(velocity))

    def hold(self, velocity: Any, number: int, until: Callable[[dict[str, Any]], Any]) -> int:
        """Hold the button of a jog until the state is so; returns the number of the last lease."""
        end = time.monotonic() + PATIENCE
        while not until(self.state):
            number += 1
            self.jog(velocity, number)
            self.during(0.04)
            assert time.monotonic() < end, self.state
        return number

    def _answer(self, kind: str, number: int | None) -> str:
        end = time.monotonic() + 20.0
        while time.monotonic() < end:
            for message in self.told:
                if message["t"] == kind and message.get("id") == number:
                    self.told.remove(message)
                    return str(message["refusal"])
            self.hear()
        raise AssertionError(f"no answer of the kind {kind}")


@contextmanager
def client(server: Served, cookie: str | None = None, **more: Any) -> Iterator[Client]:
    """An open page."""
    from websockets.sync.client import connect

    headers = {"cookie": cookie or server.cookie()}
    address = f"ws://127.0.0.1:{server.port}/live"
    origin = more.pop("origin", server.origin)
    with connect(
        address, additional_headers=headers, origin=origin, max_size=1 << 24, close_timeout=1, open_timeout=PATIENCE
    ) as socket:
        made = Client(socket)
        while not made.page:
            made.hear(5.0)
        yield made


BOUNDARY = "------------------------d74496d66958873e"


def picture() -> bytes:
    """A PNG of one pixel."""
    chunks = (
        (b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0)),
        (b"IDAT", zlib.compress(b"\0\0")),
        (b"IEND", b""),
    )
    parts = [struct.pack(">I", len(d)) + n + d + struct.pack(">I", zlib.crc32(n + d)) for n, d in chunks]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def sliced() -> bytes:
    """G-code that a PrusaSlicer might have written for the house-printer."""
    scene = load("house-printer").scene
    body = first_part("house-printer", scene.frame_min, scene.frame_max)[1]
    text = base64.b64encode(picture()).decode()
    picture_lines = f"; thumbnail begin 16x16 {len(text)}\n; {text}\n; thumbnail end\n"
    head = f"; generated by PrusaSlicer 2.9.1 on 2026-11-29\n;\n{picture_lines}"
    end = "; estimated printing time (normal mode) = 1h 2m 3s\n; layer_height = 0.6\n; filament used [mm] = 12.5\n"
    return (head + body + end).encode()


def form(name: str, content: bytes, /, **fields: str) -> tuple[str, bytes]:
    """Content type and body of a form as libcurl sends it: fields first, then the file."""
    parts = [
        f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="{key}"\r\n\r\n{value}\r\n'
        for key, value in fields.items()
    ]
    file = f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="file"; filename="{name}"\r\n'
    body = "".join(parts) + file + "Content-Type: application/octet-stream\r\n\r\n"
    return f"multipart/form-data; boundary={BOUNDARY}", body.encode() + content + f"\r\n--{BOUNDARY}--\r\n".encode()


def make_key(server: Served, scope: str = "upload", name: str = "slicer") -> str:
    """Make a key on the page."""
    with client(server) as page:
        end = time.monotonic() + 20.0
        while why := page.take():
            assert time.monotonic() < end, why
            page.during(0.2)
        cookie = server.cookie()
        about = json.dumps({"name": name, "scope": scope})
        headers = {"cookie": cookie, "origin": server.origin, "x_page": page.page}
        status, text, _ = server.ask("POST", "/keys", about, **headers)
        assert status == 200, text
        return str(json.loads(text)["key"])


def send(server: Served, path: str, key: str, name: str, content: bytes, /, **fields: str) -> tuple[int, str, Any]:
    kind, body = form(name, content, **fields)
    return server.ask("POST", path, body, x_api_key=key, content_type=kind)
