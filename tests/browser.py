"""Chromium driven over its pipe (DevTools protocol): pages of any size, light or dark, and their errors."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np

NAMES = ("chromium", "chromium-browser", "google-chrome")
OPTIONS = (
    "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--disable-background-networking", "--no-first-run", "--hide-scrollbars",
    "--force-device-scale-factor=1", "--disable-extensions",
)  # fmt: skip
FLAT = "--disable-3d-apis"
"""Option of a browser whose views no test needs: without a graphics card they take most of a core."""
PATIENCE = 60.0  # s
LAUNCH = """
import fcntl, os, sys
reader, writer = (fcntl.fcntl(int(each), fcntl.F_DUPFD, 10) for each in sys.argv[1:3])
os.dup2(reader, 3), os.dup2(writer, 4)
os.execvp(sys.argv[3], sys.argv[3:])
"""  # Chromium reads from 3 and writes to 4


def executable() -> str | None:
    """Where Chromium is, if it is installed."""
    return next((found for name in NAMES if (found := shutil.which(name))), None)


class Browser:
    """One running Chromium. Answers and events come in order over a pipe."""

    def __init__(self, process: subprocess.Popen[bytes], reader: int, writer: int, *, flat: bool = False) -> None:
        self.process, self._reader, self._writer, self.flat = process, reader, writer, flat
        self._count, self._rest, self.events = 0, b"", []

    def send(self, method: str, session: str | None = None, **parameters: Any) -> dict[str, Any]:
        """Call a method and return its result."""
        self._count += 1
        message = {"id": self._count, "method": method, "params": parameters} | (
            {"sessionId": session} if session else {}
        )
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self._writer, data) :]
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            answer = self._read(end - time.monotonic())
            if answer is None:
                continue
            if answer.get("id") == self._count:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)
        raise TimeoutError(method)

    def _read(self, patience: float) -> dict[str, Any] | None:
        while b"\0" not in self._rest:
            if not select.select([self._reader], [], [], patience)[0]:
                return None
            more = os.read(self._reader, 1 << 20)
            if not more:
                raise RuntimeError("Chromium has ended")
            self._rest += more
        message, self._rest = self._rest.split(b"\0", 1)
        return json.loads(message)

    def drain(self) -> None:
        """Take the events that are there, of a page with constant messages for a fifth of a second."""
        end = time.monotonic() + 0.2
        while time.monotonic() < end and (event := self._read(0.05)) is not None:
            self.events.append(event)

    @contextmanager
    def page(
        self, file: Path | str, width: int, height: int = 900, *, dark: bool = False, touch: bool = False
    ) -> Iterator[Page]:
        """A page of a *file* or an address, its size in pixels, until it is ready."""
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.events.clear()
        page = Page(self, session)
        for domain in ("Page", "Runtime", "Network", "Log"):
            page.send(f"{domain}.enable")
        page.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=touch)
        page.send("Emulation.setTouchEmulationEnabled", enabled=touch, maxTouchPoints=5)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        page.send("Emulation.setEmulatedMedia", features=[scheme])
        page.send("Page.navigate", url=file if isinstance(file, str) else file.resolve().as_uri())
        page.until("document.readyState === 'complete'")
        try:
            yield page
        finally:
            self.send("Target.closeTarget", targetId=target)


class Page:
    """One page: its content, its errors, its requests."""

    def __init__(self, browser: Browser, session: str) -> None:
        self._browser, self._session = browser, session

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Call a method for this page."""
        return self._browser.send(method, self._session, **parameters)

    def run(self, script: str) -> Any:
        """Return the value of an expression in the page."""
        found = self.send("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in found:
            raise RuntimeError(f"{script}: {found['exceptionDetails']}")
        return found["result"].get("value")

    def until(self, condition: str, patience: float = PATIENCE) -> None:
        """Wait for a condition."""
        end = time.monotonic() + patience
        while not self.run(f"Boolean({condition})"):
            if time.monotonic() > end:
                raise TimeoutError(condition)
            time.sleep(0.05)

    def settled(self) -> None:
        """Wait until every view of the page is drawn."""
        self.until("[...document.querySelectorAll('.viewer')].every((v) => v.dataset.ready || v.dataset.reason)")
        self.run("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def picture(self, whole: bool = False) -> bytes:
        """A screenshot as PNG, of the visible part or of the *whole* page."""
        return base64.b64decode(self.send("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"])

    def pixels(self, selector: str) -> np.ndarray:
        """The pixels of an element, (rows, columns, 3), 0 to 1."""
        self.run(f"document.querySelector({selector!r}).scrollIntoView({{block: 'center', behavior: 'instant'}})")
        self.run("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        box = self.run(f"document.querySelector({selector!r}).getBoundingClientRect().toJSON()")
        seen = matplotlib.image.imread(BytesIO(self.picture()), format="png")[..., :3]
        top, left = max(0, round(box["top"])), max(0, round(box["left"]))
        return seen[top : round(box["bottom"]), left : round(box["right"])]

    def swipe(self, x: float, y: float, dy: float, dx: float = 0.0, steps: int = 8) -> None:
        """One finger from (x, y) on."""
        self.send("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
        for k in range(1, steps + 1):
            at = {"x": x + dx * k / steps, "y": y + dy * k / steps}
            self.send("Input.dispatchTouchEvent", type="touchMove", touchPoints=[at])
            time.sleep(0.02)
        self.send("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        time.sleep(0.3)

    def complaints(self) -> list[str]:
        """Errors on the console, and uncaught ones; of a browser without views, not that it has none."""
        self._browser.drain()
        found = []
        for event in self._own():
            kind, given = event["method"], event["params"]
            if kind == "Runtime.exceptionThrown":
                found.append(given["exceptionDetails"].get("exception", {}).get("description", "an exception"))
            elif kind == "Runtime.consoleAPICalled" and given["type"] in ("error", "warning"):
                found.append(" ".join(str(each.get("value", each)) for each in given["args"]))
            elif kind == "Log.entryAdded" and given["entry"]["level"] == "error":
                found.append(given["entry"]["text"])
        return [each for each in found if not (self._browser.flat and "WebGL context" in each)]

    def requests(self) -> list[str]:
        """Addresses that the page requested, without its own file."""
        self._browser.drain()
        asked = [
            each["params"]["request"]["url"] for each in self._own() if each["method"] == "Network.requestWillBeSent"
        ]
        return [url for url in asked[1:] if not url.startswith(("data:", "blob:"))]

    def _own(self) -> list[dict[str, Any]]:
        return [event for event in self._browser.events if event.get("sessionId") == self._session]


def entered(address: str, *more: str) -> Iterator[Browser]:
    """A browser, with the options *more*, that has been on the page at *address*: from then on it has the cookie."""
    with browser(*more) as found:
        with found.page(address, 1280) as page:
            page.until("location.pathname === '/' && window.operate")
        yield found


@contextmanager
def browser(*more: str) -> Iterator[Browser]:
    """A Chromium with its own profile; *more*: options."""
    command = executable()
    assert command is not None
    to_read, to_answer = os.pipe()
    to_command, to_write = os.pipe()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        words = [command, *OPTIONS, *more, f"--user-data-dir={profile}"]
        launch = [sys.executable, "-c", LAUNCH, str(to_command), str(to_answer), *words]
        process = subprocess.Popen(launch, pass_fds=(to_command, to_answer), stderr=subprocess.DEVNULL)
        os.close(to_command)
        os.close(to_answer)
        try:
            yield Browser(process, to_read, to_write, flat=FLAT in more)
        finally:
            process.terminate()
            process.wait(timeout=20)
            os.close(to_read)
            os.close(to_write)
