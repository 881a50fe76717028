"""From a new machine to its first square on the page, and how long a verdict and a start take."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("starlette")

from browser import Browser, Page, browser, executable
from cablewright.printing.first_part import first_part
from cablewright.robot import load
from served import Served, form, make_key, served

pytestmark = [
    pytest.mark.clock,
    pytest.mark.skipif(executable() is None, reason="no chromium is installed: see README.md, Tests"),
]

ROOT = Path(__file__).parents[3]
CONTROL = "operate.orders.control"
ROW = "document.querySelectorAll('#first li')[%d]"


@pytest.fixture(scope="module")
def chromium(server: Served) -> Iterator[Browser]:
    with browser() as found:
        with found.page(server.address, 1280) as page:
            page.until("location.pathname === '/' && window.operate")
        yield found


def step(page: Page, number: int, text: str, then: str, patience: float = 60.0) -> None:
    """Press the button of a step with this text until the condition is met; a busy computer may lose an order."""
    end = time.monotonic() + patience
    find = f"[...{ROW % number}.querySelectorAll('button:not([hidden])')].find((e) => e.textContent === {text!r})"
    while not page.run(f"Boolean({then})"):
        assert time.monotonic() < end, (text, page.run(f"{ROW % number}.textContent"))
        if page.run("!operate.orders.mine && !document.getElementById('take').disabled"):
            page.run("document.getElementById('take').click()")
        page.run(f"{find} && !{find}.disabled && {find}.click()")
        time.sleep(0.3)


def done(number: int) -> str:
    return f"{ROW % number}.querySelector('.tag.yes')"


def test_each_step_of_the_first_run_has_a_picture_a_check_and_a_way_back(chromium: Browser, server: Served) -> None:
    with chromium.page(f"{server.origin}/", 1280) as page:
        page.until("window.operate && operate.link.page && !document.body.classList.contains('stale')")
        page.run("document.getElementById('first-run').open = true")
        page.until("operate.orders.control?.platform")
        rows = page.run("document.querySelectorAll('#first li').length")
        assert rows == 6
        assert page.run("[...document.querySelectorAll('#first svg')].filter((e) => e.clientWidth > 40).length") == rows
        step(page, 0, "It is this one", done(0))
        step(page, 0, "It is another", f"!{done(0)}")  # and back
        step(page, 1, "Reset", f"{CONTROL}.state === 'off'")
        step(page, 1, "Enable", f"{CONTROL}.state === 'idle'")
        page.until(done(1))
        step(page, 1, "Release", f"{CONTROL}.state === 'off'")
        step(page, 1, "Enable", f"{CONTROL}.state === 'idle'")
        page.until(f"{done(2)} && {done(3)}")
        here = page.run("operate.jog.here")
        for measured, near in (([here[0] + 0.05, *here[1:]], False), (here, True)):
            page.run(f"{ROW % 4}.querySelector('input').value = {', '.join(map(str, measured))!r}")
            step(page, 4, "Compare", f"{ROW % 4}.textContent.includes({'good enough' if near else 'over 10 mm'!r})")
            assert bool(page.run(f"Boolean({done(4)})")) is near
        step(page, 5, "Make and check it", "operate.jobs.jobs.some(({ name }) => name === 'first square')")
        made = page.run("operate.jobs.jobs.find(({ name }) => name === 'first square')")
        assert made["parts"] == ["gcode", "settings"]
        folder = server.folder / "jobs" / made["id"]
        scene = load("house-printer").scene
        assert (folder / "part.gcode").read_text() == first_part("house-printer", scene.frame_min, scene.frame_max)[1]


@pytest.mark.slow
def test_three_megabytes_have_their_verdict_in_twenty_seconds(server: Served) -> None:
    scene = load("house-printer").scene
    whole = first_part("house-printer", scene.frame_min, scene.frame_max)[1].encode()
    head, _, layer = whole.partition(b";LAYER:2\n")
    lines = layer * (3_000_000 // len(layer) + 1)
    key = make_key(server)
    for name in ("compiles.gcode", "three.gcode"):  # kernels may be compiled by the first one
        content = (
            whole if name == "compiles.gcode" else head + b";LAYER:2\n" + lines[: lines.rfind(b"\n", 0, 3 << 20) + 1]
        )
        kind, body = form(name, content)
        began = time.monotonic()
        assert server.ask("POST", "/api/files/local", body, x_api_key=key, content_type=kind)[0] == 201
        check = None
        while check is None:
            time.sleep(0.2)
            assert time.monotonic() - began < 300.0
            check = next(each for each in json.loads(server.ask("GET", "/jobs")[1]) if each["file"] == name)["check"]
        taken = time.monotonic() - began
        print(f"{name}: {len(content) / 1e6:.2f} MB, {check['answer']} after {taken:.1f} s")
    assert check["answer"] in ("yes", "no"), check
    assert taken <= 20.0


@pytest.mark.slow
def test_from_the_demo_to_a_print_that_was_confirmed_once_takes_less_than_five_minutes(tmp_path: Path) -> None:
    began = time.monotonic()
    ended = subprocess.run([sys.executable, ROOT / "tools" / "demo.py"], cwd=ROOT, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    demo = time.monotonic() - began
    scene = load("house-printer").scene
    send = """((text) => { const t = new DataTransfer(); t.items.add(new File([text], 'square.gcode'));
      document.getElementById('files').files = t.files; document.getElementById('upload').requestSubmit(); })"""
    part = first_part("house-printer", scene.frame_min, scene.frame_max)[1]
    with served(tmp_path / "out", "house-printer") as own, browser() as found, found.page(own.address, 1280) as page:
        page.until("window.operate && operate.link.page && !document.body.classList.contains('stale')")
        page.run("document.getElementById('take').click()")
        page.until("operate.orders.mine && !document.getElementById('files').disabled")
        page.run(f"{send}({json.dumps(part)})")
        page.until("operate.jobs.candidate", 240.0)
        checked = time.monotonic() - began
        while page.run(f"!['ready', 'printing'].includes({CONTROL}.state)"):
            assert time.monotonic() - began < 300.0, page.run("document.getElementById('answer').textContent")
            page.run("operate.orders.mine || document.getElementById('take').click()")
            page.run(
                "operate.printing.told || document.getElementById('ask').open || document.getElementById('act').click()"
            )
            page.run("document.getElementById('ask').open && document.getElementById('ask-yes').click()")
            time.sleep(0.3)
        taken = time.monotonic() - began
        page.run("document.getElementById('stop').click()")
    print(f"demo {demo:.0f} s, checked {checked:.0f} s, started {taken:.0f} s")
    assert taken < 300.0
