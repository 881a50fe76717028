"""A print that a person in the barrier, an empty drum and a loss of power interrupt: each has a way on."""

from __future__ import annotations

import os
import re
import signal
import time
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

import pytest

pytest.importorskip("starlette")

from browser import Browser, Page, browser, executable
from cablewright.apps.serve.uploads import Uploads
from cablewright.live.serve.jobs import JobCheck, subject_of, write_check
from cablewright.machine.log.log import read_log
from cablewright.robot import load
from operator_page import STATE
from served import RING, Served, served

pytestmark = [
    pytest.mark.clock,
    pytest.mark.slow,
    pytest.mark.skipif(executable() is None, reason="no chromium is installed: see README.md, Tests"),
]

JOB = RING.replace("layers = 3", "layers = 12").replace('name = "ring"', 'name = "ring"\norigin = [0.0, 0.0, 5.5]')
INTRUSION = (26.0, 29.0)  # s of the machine's time
ACT, NEXT = "document.getElementById('act')", "document.getElementById('next').textContent"
CONTROL = "operate.orders.control"


def machine_file() -> str:
    """The house-printer with a drum that empties every few seconds, and a person who walks into its barrier."""
    text = (resources.files("cablewright.machine") / "library" / "house-printer.toml").read_text()
    text = re.sub(r"\[extrusion\][^\[]*", "", text)
    powder = (
        'powder = "9 kg"\ncapacity = "9 kg"\npowder_density = "1500 kg/m^3"\nradius = "0.18 m"\npowder_bottom = "0.3 m"'
    )
    text = text.replace("flow = 0.7354", f"{powder}\nflow = 0.7354")
    return text + f"\n[simulation.barrier]\nintrusions = [[{INTRUSION[0]}, {INTRUSION[1]}]]\n"


@pytest.fixture(scope="module")
def arguments(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, tuple[str, ...]]:
    folder = tmp_path_factory.mktemp("interrupted")
    (folder / "machine.toml").write_text(machine_file())
    return folder / "out", ("house-printer", "--machine", str(folder / "machine.toml"), "--seed", "1")


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as found:
        yield found


def entered(chromium: Browser, server: Served) -> None:
    with chromium.page(server.address, 1280) as page:
        page.until("location.pathname === '/' && window.operate")


def press(page: Page, text: str, then: str) -> None:
    """Press the primary action of this text, confirm what it asks, until the condition *then* is met.

    A busy computer loses the lease, or withdraws a question: then a person begins again.
    """
    end, there = time.monotonic() + 150.0, f"!{ACT}.hidden && {ACT}.textContent === {text!r}"
    while not page.run(f"Boolean({then})"):
        told = "[document.getElementById('state').textContent, document.getElementById('answer').textContent]"
        assert time.monotonic() < end, (text, page.run(NEXT), page.run(told))
        if page.run("!operate.orders.mine && !document.getElementById('take').disabled"):
            page.run("document.getElementById('take').click()")
        elif page.run(f"!document.getElementById('ask').open && {there}"):
            page.run(f"{ACT}.click()")
        elif page.run("document.getElementById('ask').open"):
            page.run("document.getElementById('ask-yes').click()")
            time.sleep(1.0)
        time.sleep(0.2)


def reset_and_enable(page: Page) -> None:
    press(page, "Reset", f"{CONTROL}.state !== 'fault'")
    press(page, "Enable", f"{CONTROL}.state === 'idle' && {CONTROL}.known")


def waiting_job(server: Served) -> None:
    uploads = Uploads(server.folder)
    number = uploads.new_job("ring")
    uploads.put_whole(number, "settings", JOB.encode())
    subject = subject_of(uploads.job(number), load("house-printer"))
    write_check(uploads.job(number), JobCheck(subject=subject, answer="yes", why="it can", expected_error=8.3e-3))


def test_barrier_refill_and_loss_of_power_have_a_way_on(
    chromium: Browser, arguments: tuple[Path, tuple[str, ...]]
) -> None:
    folder, words = arguments
    with served(folder, *words) as server:
        waiting_job(server)
        entered(chromium, server)
        with chromium.page(f"{server.origin}/", 1280) as page:
            page.until("window.operate && operate.link.page && !document.body.classList.contains('stale')")
            reset_and_enable(page)
            press(page, "Print ring", f"{CONTROL}.state === 'printing'")
            seen: set[str] = set()
            end = time.monotonic() + 240.0
            while seen != {"refilled", "somebody"}:
                assert time.monotonic() < end, (seen, page.run(f"[{STATE}, {NEXT}]"))
                state, reason = page.run(f"[{CONTROL}.state, {CONTROL}.reason]")
                if state == "refilling":
                    assert "powder" in page.run("document.getElementById('reason').textContent")
                    press(page, "Refilled", f"['printing', 'paused'].includes({CONTROL}.state)")
                    assert page.run(f"{CONTROL}.powder") > 5.0
                    seen.add("refilled")
                elif state == "paused" and "barrier" in reason:
                    page.until(f"{STATE} === 'paused'")
                    assert page.run("document.getElementById('reason').textContent").startswith("Somebody is in")
                    page.until(f"{CONTROL}.barrier === false", 30.0)  # they have left
                    press(page, "Resume", f"{CONTROL}.state !== 'paused'")
                    seen.add("somebody")
                time.sleep(0.1)
            page.until(f"{CONTROL}.state === 'printing'", 90.0)
            time.sleep(1.5)  # a checkpoint
            before = page.run(f"{CONTROL}.distance")
            run = page.run("operate.state.sitting.run")
            os.kill(server.process.pid, signal.SIGKILL)  # the power is lost
            page.until("document.body.classList.contains('stale')", 10.0)
    with served(folder, *words) as server:
        entered(chromium, server)
        with chromium.page(f"{server.origin}/", 1280) as page:
            page.until("window.operate && operate.link.page && !document.body.classList.contains('stale')")
            press(page, "Operate", "operate.orders.mine")
            page.until(f"{NEXT}.includes('was cut off')", 30.0)
            assert "was cut off" in page.run("document.getElementById('runs').textContent")
            press(page, "Resume or leave it", f"operate.state.sitting.resumed && {CONTROL}.fresh")
            reset_and_enable(page)
            press(page, "Start", f"{CONTROL}.state === 'printing'")
            assert page.run(f"{CONTROL}.distance") == pytest.approx(before, abs=1.0)
            page.until(f"{CONTROL}.distance > {before} + 0.3 || {CONTROL}.state === 'refilling'", 60.0)
            assert page.run("operate.state.sitting.run") == run
            page.run("document.getElementById('stop').click()")
            page.until(f"{CONTROL}.state === 'fault'", 10.0)
            away = "[...document.querySelectorAll('#jobs button')].find((b) => b.textContent === 'Put away')"
            page.until(f"{away} && !{away}.disabled && {CONTROL}.speeds.every((each) => each === 0)")
            page.run(f"{away}.click()")
            page.until("!operate.state.sitting.job", 60.0)
    assert [each.name for each in (folder / "runs").iterdir()] == [run]
    with read_log(folder / "runs" / run) as log:
        laid = [each.progress.distance for each in log.entries() if each.progress is not None]
    assert max(laid) > before
