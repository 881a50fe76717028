"""Malformed requests for `cablewright serve`: no order without the lease, no path outside the folder, no crash.

Some are of slicers with valid keys, which may send jobs and stop, and start nothing.

`python tools/fuzz_server.py --number 100000` starts a server of its own on a simulated machine, whose winches no one
ever enables, and looks afterwards: at the orders that were obeyed, at the files that were written, and at what the
server said. Needs the extra web.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any, Final

from cablewright.apps.serve.slicers.keys import SCOPES, Keys

PATHS: Final = (
    "/", "/enter", "/static/main.js", "/static/../server.py", "/static/..%2f..%2fpyproject.toml", "/static/%2e%2e/x",
    "/jobs", "/jobs/ID/gcode", "/jobs/ID/settings", "/jobs/ID/check", "/jobs/ID/load", "/jobs/ID/report", "/jobs/ID",
    "/api/version", "/api/job", "/api/printer", "/api/files/local", "/api/files/local/x.gcode", "/api/../jobs",
    "/api/login", "/server/info", "/server/files/upload", "/server/files/list", "/server/files/metadata?filename=../x",
    "/printer/info", "/server/files/gcodes/.thumbs/..%2f..%2fkeys.json",
    "/server/files/gcodes/.thumbs/x.gcode-9x9.png", "/websocket",
    "/printer/objects/query?print_stats&toolhead=position", "/printer/print/start?filename=x.gcode", "/printer/restart",
    "/printer/print/resume", "/printer/print/pause", "/printer/print/cancel", "/printer/gcode/script?script=G28",
    "/api/version?apikey=x", "/access/api_key", "/machine/reboot", "/keys", "/keys/00000000", "/reach",
    "/runs/RUN/notes", "/runs/RUN/resume", "/jobs/first", "/jobs/ID/picture",
    "/jobs/../../etc/passwd/report", "/jobs/%2e%2e%2f%2e%2e/report", "/runs",
    "/runs/RUN/report", "/runs/../x/report",
    "/scene", "/close", "/live", "/foxglove/x", "/nothing", "//etc/passwd", "/\x00", "/" + "a" * 3000, "/jobs/\u2028/x",
)  # fmt: skip
METHODS: Final = ("GET", "POST", "PUT", "DELETE", "HEAD", "OPTIONS", "PATCH", "TRACE", "G\u00cbT")
IDS: Final = ("0" * 16, "..", "%2e%2e", "../../x", "a" * 16, "0123456789abcdef", "/etc", "~", "con", "\u202e")
RUNS: Final = ("20260101-000000-x", "..", "%2e%2e", "20260101-000000-../../x", "20260101-000000-" + "a" * 200)
KINDS: Final[tuple[object, ...]] = (
    "enable", "take up", "home", "release", "jog", "go to", "park", "start", "pause", "resume", "override", "refilled",
    "stop", "reset", "emergency", "", None, 7, [], "ENABLE", "a" * 500,
)  # fmt: skip
COMMANDS: Final = (
    {"command": "start"}, {"command": "pause", "action": "resume"}, {"command": "cancel"}, {"command": "restart"},
    {"command": "select", "print": True}, {"script": "G28"}, {"position": [0, 0, 1]}, {"name": "x", "scope": "operate"},
)  # fmt: skip
METHODS_OF_SOCKETS: Final = (
    "printer.print.start", "printer.print.resume", "printer.gcode.script", "printer.print.pause",
    "printer.objects.query", "printer.objects.subscribe", "server.files.metadata", "server.connection.identify",
    "server.info", "printer.restart", "", "x" * 500, None, 7,
)  # fmt: skip
HARMLESS: Final = ("emergency stop", *(f"{kind} of a slicer" for kind in ("emergency stop", "pause", "stop")))
WITHOUT_LEASE: Final = 4  # open pages that send messages


def _value(dice: random.Random, depth: int = 0) -> Any:
    """Anything that JSON has, and a little more."""
    plain = (None, True, 0, -1, 1e308, 2**70, "", "x" * dice.randrange(2000), "\u0000", "../../x", 0.1)
    if depth > 3 or dice.random() < 0.6:
        return dice.choice(plain)
    if dice.random() < 0.5:
        return [_value(dice, depth + 1) for _ in range(dice.randrange(5))]
    return {str(dice.choice(plain)): _value(dice, depth + 1) for _ in range(dice.randrange(5))}


def _message(dice: random.Random, number: int) -> str | bytes:
    """A message of a page, mostly almost right."""
    kind = dice.choice(("order", "jog", "beat", "release", "order", "jog", None, 5))
    made: dict[str, Any] = {"t": kind, "id": number, "seq": number, "beat": dice.choice((0, number, 2**40))}
    made |= {
        "kind": dice.choice(KINDS),
        "arguments": dice.choice(({}, {"velocity": [0.1, 0, 0]}, {"winch": [0, 0.1], "held": [1]}, _value(dice))),
    }
    made["velocity"] = dice.choice(([0.1, 0.0, 0.0], [1e9, 0, 0], [float("nan")] * 3, "fast", _value(dice)))
    if dice.random() < 0.2:
        made["winch"] = dice.choice(([0, 0.1], [-1, 1], [1e9], "first", _value(dice)))
    if dice.random() < 0.3:
        made[dice.choice(tuple(made))] = _value(dice)
    text = json.dumps(made)
    if dice.random() < 0.1:
        text = text[: dice.randrange(len(text))]
    return text.encode("utf-8", "surrogatepass") if dice.random() < 0.05 else text


def _form(dice: random.Random) -> str:
    """A form with a file of malformed name or shape: none of them is accepted."""
    name = dice.choice(
        ("../x.gcode", "a/b.gcode", "x.exe", "", ".gcode", "x" * 300 + ".gcode", "\\x.gcode", "x\x00.gcode")
    )
    field = dice.choice(("print", "path", "root", "file", "x" * 3000))
    text = f'--b\r\nContent-Disposition: form-data; name="{field}"\r\n\r\ntrue\r\n'
    text += f'--b\r\nContent-Disposition: form-data; name="file"; filename="{name}"\r\n\r\nG1 X1\r\n--b--\r\n'
    return text[: dice.randrange(len(text))] if dice.random() < 0.3 else text


class Target:
    """The server that is fuzzed."""

    def __init__(self, address: str, dice: random.Random) -> None:
        """At an *address* with its token."""
        self.port, self.token = int(address.split(":")[2].split("/")[0]), address.partition("#")[2]
        self.dice, self.answers, self.cookie = dice, Counter[str](), ""
        self.gone = 0
        self.keys = ["wrong", ""]  # of slicers, to which `with_keys` adds valid ones

    def with_keys(self, keys: list[str]) -> Target:
        """The same, with valid keys of slicers."""
        self.keys += keys
        return self

    async def request(self) -> None:
        """One malformed request, with a wrong token, or with a right one without a lease."""
        dice = self.dice
        method = dice.choice(METHODS)
        path = dice.choice(PATHS).replace("ID", dice.choice(IDS)).replace("RUN", dice.choice(RUNS))
        host = dice.choice((f"127.0.0.1:{self.port}",) * 6 + ("evil.example", "", f"127.0.0.1:{self.port}, evil"))
        lines = [f"{method} {path} HTTP/1.1", f"Host: {host}"]
        lines += dice.choice(
            ([], [f"Origin: http://127.0.0.1:{self.port}"], ["Origin: https://evil.example"], ["Origin: null"])
        )
        cookie = dice.choice((self.cookie, self.cookie[:-1], "x=" + "y" * 900, ""))
        lines += [f"Cookie: {cookie}"] if cookie else []
        lines += dice.choice(([], [], [f"Authorization: Bearer {self.token}"], ["Authorization: Bearer x"]))
        lines += dice.choice(([], ["X-Page: " + "z" * 32], ["Accept: text/html"], ["Transfer-Encoding: chunked"]))
        lines += [f"X-Api-Key: {dice.choice(self.keys)}"] if dice.random() < 0.4 else []
        body = dice.choice(
            ("", "{}", json.dumps(_value(dice)), "x" * dice.randrange(9000), json.dumps(dice.choice(COMMANDS)))
        )
        if dice.random() < 0.1 and "Transfer-Encoding: chunked" not in lines:
            # with malformed chunks uvicorn itself logs an error, and ends that connection
            lines += ["Content-Type: multipart/form-data; boundary=b"]
            body = _form(dice)
        lines += [f"Content-Length: {dice.choice((len(body),) * 5 + (-1, 10**12))}"] if dice.random() < 0.8 else []
        raw = ("\r\n".join([*lines, "Connection: close"]) + "\r\n\r\n" + body).encode("utf-8", "replace")
        await self.send(raw)

    async def send(self, raw: bytes) -> None:
        """Send bytes, and count the answer."""
        try:
            async with asyncio.timeout(5.0):
                reader, writer = await asyncio.open_connection("127.0.0.1", self.port)
                writer.write(raw)
                writer.write_eof()
                status = await reader.readline()
                writer.close()
            self.answers[status.decode("latin-1")[9:12] or "cut off"] += 1
        except (OSError, TimeoutError):
            self.gone += 1

    async def enter(self) -> None:
        """Get a cookie."""
        reader, writer = await asyncio.open_connection("127.0.0.1", self.port)
        head = f"POST /enter HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\nOrigin: http://127.0.0.1:{self.port}\r\n"
        writer.write(f"{head}Connection: close\r\nContent-Length: {len(self.token)}\r\n\r\n{self.token}".encode())
        answer = (await reader.read()).decode("latin-1")
        writer.close()
        self.cookie = next(line for line in answer.splitlines() if line.lower().startswith("set-cookie:"))[12:].split(
            ";"
        )[0]


async def _page(target: Target, number: int, done: list[int]) -> None:
    """Open pages without the lease that send malformed messages, again and again, as they are thrown out."""
    from websockets.asyncio.client import connect
    from websockets.exceptions import WebSocketException

    dice, sent = random.Random(number), 0
    while sent < number:
        try:
            address, origin = f"ws://127.0.0.1:{target.port}/live", f"http://127.0.0.1:{target.port}"
            async with connect(address, origin=origin, additional_headers={"cookie": target.cookie}) as socket:  # type: ignore[arg-type]
                while sent < number:
                    for _ in range(40):
                        sent += 1
                        done[0] += 1
                        await socket.send(_message(dice, sent))
                    await asyncio.sleep(0.3)
                    while True:
                        try:
                            async with asyncio.timeout(0.001):
                                await socket.recv()
                        except TimeoutError:
                            break
        except (WebSocketException, OSError):
            await asyncio.sleep(0.05)


async def _slicer(target: Target, number: int, done: list[int]) -> None:
    """Open sockets of slicers with valid keys that send malformed messages, again and again, as they are thrown out."""
    from websockets.asyncio.client import connect
    from websockets.exceptions import WebSocketException

    dice, sent = random.Random(number), 0
    while sent < number:
        try:
            key, address = target.keys[-1], f"ws://127.0.0.1:{target.port}/websocket"
            async with connect(address, additional_headers={"x-api-key": key}) as socket:
                while sent < number:
                    given = dice.choice(({}, {"objects": {"print_stats": None}}, _value(dice), {"filename": "../x"}))
                    asked = {"jsonrpc": "2.0", "id": sent, "method": dice.choice(METHODS_OF_SOCKETS), "params": given}
                    await socket.send(json.dumps(asked) if dice.random() < 0.9 else "{" * dice.randrange(99))
                    await asyncio.sleep(0.02)
                    sent += 1
                    done[0] += 1
        except (WebSocketException, OSError):
            await asyncio.sleep(0.1)


async def fuzz_target(target: Target, number: int, messages: int) -> int:
    """Send so many, of which so many are messages of pages; return how many of these were sent."""
    await target.enter()
    done = [0]
    pages = [asyncio.create_task(_page(target, messages // WITHOUT_LEASE, done)) for _ in range(WITHOUT_LEASE)]
    if len(target.keys) > 2:
        pages.append(asyncio.create_task(_slicer(target, messages // 50, done)))
    requests = number - messages
    for k in range(0, requests, 20):
        await asyncio.gather(*(target.request() for _ in range(min(20, requests - k))))
        if k % 2000 == 0:
            print(f"{k} requests, {done[0]} messages", file=sys.stderr, flush=True)
    await asyncio.gather(*pages)
    return done[0]


def named(order: dict[str, Any]) -> str:
    """What was ordered, and whether by a slicer's key."""
    return f"{order['order']} of a slicer" if "(key " in order["by"] else str(order["order"])


def _tree(folder: Path) -> set[str]:
    return {str(each.relative_to(folder)) for each in folder.rglob("*")}


def fuzz(number: int, seed: int) -> dict[str, Any]:
    """Send so many requests and messages; return what was found."""
    with tempfile.TemporaryDirectory() as around:
        folder = Path(around) / "served"
        folder.mkdir()
        keys = [Keys(folder).make(scope, scope)[0] for scope in SCOPES]
        command = [sys.executable, "-m", "cablewright", "serve", "house-printer", "--port", "0", "--out", str(folder)]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=around)
        assert process.stderr is not None
        try:
            target = Target(process.stderr.readline().strip(), random.Random(seed)).with_keys(keys)
            time.sleep(5.0)
            begin = time.monotonic()
            messages = asyncio.run(fuzz_target(target, number, number // 5))
            taken = time.monotonic() - begin
            alive = process.poll() is None
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(timeout=60)
        said = process.stderr.read()
        orders = [json.loads(line) for line in (folder / "orders.jsonl").read_text().splitlines()]
        obeyed = Counter(named(each) for each in orders if "refusal" not in each)
        outside = sorted(_tree(Path(around)) - {"served"} - {f"served/{each}" for each in _tree(folder)})
        kept = sorted(_tree(folder / "jobs"))
        return {
            "requests": sum(target.answers.values()) + target.gone,
            "messages": messages,
            "seconds": round(taken),
            "answers": dict(sorted(target.answers.items())),
            "without an answer": target.gone,
            "alive": alive,
            "servers that ended": said.count("is started again"),
            "errors of the server": said.count("Traceback"),
            "orders obeyed": dict(obeyed),
            "jobs": kept,
            "files outside": outside,
            "said": said[said.find("Traceback") :][:4000] if "Traceback" in said else "",
        }


def failures(found: dict[str, Any]) -> list[str]:
    """What must not be."""
    bad = [f"the order {kind!r} was obeyed" for kind in found["orders obeyed"] if kind not in HARMLESS]
    bad += [
        f"{key}: {found[key]}"
        for key in ("servers that ended", "errors of the server", "jobs", "files outside")
        if found[key]
    ]
    bad += [f"answers {status}" for status in found["answers"] if status.startswith("5") and status != "503"]
    return bad + ([] if found["alive"] else ["the control has ended"])


def main() -> int:
    """Fuzz, and say what was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--number", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    os.environ.setdefault("NUMBA_NUM_THREADS", "1")
    found = fuzz(given.number, given.seed)
    print(json.dumps(found, indent=1))
    bad = failures(found)
    for each in bad:
        print(each, file=sys.stderr)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
