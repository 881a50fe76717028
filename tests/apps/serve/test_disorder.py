"""What goes wrong around a machine that works: two slicers, an upload in a print, a foreign job, clocks, a camera."""

from __future__ import annotations

import asyncio
import json
import threading
import time
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("starlette")

from browser import FLAT, browser, executable
from cablewright.apps.serve.application import Page
from cablewright.apps.serve.check_worker import check_job
from cablewright.apps.serve.uploads import Uploads
from cablewright.live.serve.jobs import JobCheck, digest_of, subject_of, write_check
from cablewright.robot import load
from operator_page import enable
from served import RING, Served, client, make_key, send, sliced

pytestmark = pytest.mark.clock
needs_chromium = pytest.mark.skipif(executable() is None, reason="no chromium is installed: see README.md, Tests")
LATER = """{ const Own = Date; window.Date = class extends Own {
  constructor(...given) { if (given.length) super(...given); else super(Own.now() + 3.6e6); }
  static now() { return Own.now() + 3.6e6; } }; }"""


def kept(server: Served, text: str, **check: Any) -> str:
    """Keep a job with an answer; return its number."""
    uploads = Uploads(server.folder)
    number = uploads.new_job("ring")
    uploads.put_whole(number, "settings", text.encode())
    subject = subject_of(uploads.job(number), load("house-printer"))
    if check:
        write_check(uploads.job(number), JobCheck(**({"subject": subject, "why": "it can"} | check)))
    return number


def jobs(server: Served) -> list[dict[str, Any]]:
    return list(json.loads(server.ask("GET", "/jobs")[1]))


def test_two_slicers_that_send_together_are_both_taken(server: Served) -> None:
    keys = [make_key(server, name=f"slicer {k}") for k in range(2)]
    answers: list[int] = []

    def upload(k: int) -> None:
        answers.append(send(server, "/api/files/local", keys[k], f"at-once-{k}.gcode", sliced())[0])

    threads = [threading.Thread(target=upload, args=(k,)) for k in range(2)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert answers == [201] * 2
    found = {each["file"]: each["by"].partition(" (")[0] for each in jobs(server)}
    assert found == {"at-once-0.gcode": "slicer 0", "at-once-1.gcode": "slicer 1"}


def test_an_upload_while_it_prints_is_kept_and_waits(server: Served) -> None:
    ring = RING.replace('name = "ring"', 'name = "ring"\norigin = [0.0, 0.0, 5.5]').replace("layers = 3", "layers = 9")
    number, key = kept(server, ring, answer="yes"), make_key(server)
    with client(server) as page:
        page.ready()
        own = {"authorization": f"Bearer {server.token}", "x_page": page.page}
        assert server.ask("POST", f"/jobs/{number}/load", b"{}", **own)[0] == 200
        page.until(lambda state: (page.sitting["job"] or {}).get("id") == number and state["state"] == "fault")
        page.ready()
        assert page.order("start") == ""
        page.until(lambda state: state["state"] in ("ready", "printing"))
        assert send(server, "/api/files/local", key, "meanwhile.gcode", sliced(), print="true")[0] == 201
        page.during(1.0)
        assert page.state["state"] in ("ready", "printing")
        assert page.sitting["job"]["id"] == number
        newest = jobs(server)[0]
        assert (newest["file"], newest["wants_print"]) == ("meanwhile.gcode", True)
        own["x_page"] = page.page
        status, why, _ = server.ask("POST", f"/jobs/{newest['id']}/load", b"{}", **own)
        assert status == 409
        assert "not at rest" in why or "not checked" in why
        page.send(t="stop")
        page.until(lambda state: state["state"] == "fault" and not any(state["speeds"]))
        end = time.monotonic() + 30.0
        while server.ask("POST", "/close", b"{}", **own)[0] != 200:
            assert time.monotonic() < end
            page.take()
            page.during(0.5)
        page.until(lambda _state: page.sitting["job"] is None)


def test_a_job_for_another_machine_is_rejected_by_name(server: Served) -> None:
    number = kept(server, RING.replace('name = "ring"', 'name = "ring"\nrobot = "merlet2023"'))
    found = check_job(server.folder, number)
    assert found.answer == "failed"
    assert "merlet2023" in found.why
    assert "house-printer" in found.why
    other = JobCheck(subject="0" * 64, answer="yes", why="", robot=digest_of(load("merlet2023")))
    assert "another robot" in other.refusal("0" * 64, "", digest_of(load("house-printer")))
    assert other.refusal("0" * 64, "", digest_of(load("merlet2023"))) == ""
    number = kept(server, RING, answer="yes", robot=digest_of(load("merlet2023")))
    with client(server) as page:
        page.ready()
        own = {"authorization": f"Bearer {server.token}", "x_page": page.page}
        status, why, _ = server.ask("POST", f"/jobs/{number}/load", b"{}", **own)
    assert (status, "another robot" in why) == (409, True)


@needs_chromium
def test_a_browser_whose_clock_is_an_hour_off_operates_and_shows_the_time_of_the_machine(server: Served) -> None:
    with browser(FLAT) as chromium, chromium.page("about:blank", 1280) as page:
        page.send("Page.addScriptToEvaluateOnNewDocument", source=LATER)
        page.send("Page.navigate", url=server.address)
        page.until("location.pathname === '/' && window.operate && !document.body.classList.contains('stale')")
        enable(page)
        page.run("document.getElementById('stop').click()")
        page.until("operate.orders.control.state === 'fault'", 10.0)
        stamp, now = page.run("[operate.orders.control.events.at(-1)[1], Date.now() / 1e3]")
        assert now - stamp == pytest.approx(3600.0, abs=30.0)
        shown = page.run("document.querySelector('#events time').textContent")
        assert shown == page.run(f"new Date({stamp} * 1e3).toLocaleTimeString()")


@needs_chromium
def test_a_camera_that_is_gone_is_said_and_the_page_goes_on(server: Served) -> None:
    with browser(FLAT) as chromium, chromium.page(server.address, 1280) as page:
        page.until("location.pathname === '/' && window.operate && !document.body.classList.contains('stale')")
        page.run("operate.camera.begin('/static/none.png?snapshot')")
        page.until("document.querySelector('#camera-section p').textContent.includes('No picture comes')", 20.0)
        assert page.run("document.getElementById('camera').hidden")
        before = page.run("operate.link.beat")
        page.until(f"operate.link.beat > {before}", 5.0)


def test_a_run_goes_on_only_after_its_report_is_written() -> None:
    """Its folder is locked until then: the machine would be closed, and say that another program works there."""
    run = "20260101-000000-ring"
    page = SimpleNamespace(checks=SimpleNamespace(busy={run: "is being written"}), _operator=lambda _request: "Ann")
    answer = asyncio.run(Page.resume(page, SimpleNamespace(path_params={"run": run})))  # type: ignore[arg-type]
    assert answer.status_code == 409
    assert b"report is being written" in answer.body
