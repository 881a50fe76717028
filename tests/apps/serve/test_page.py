"""The operator's page in a browser: its display, its actions, and its behaviour without input."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

pytest.importorskip("starlette")

from browser import FLAT, Browser, Page, entered, executable
from cases import some
from operator_page import STATE, enable
from served import RING, Served, client

pytestmark = [
    pytest.mark.clock,
    pytest.mark.skipif(executable() is None, reason="no chromium is installed: see README.md"),
]

LOOKS = some([(1280, False), (390, True), (2560, True), (1280, True), (390, False), (2560, False)], 2)
HOLD = """(() => {
  const b = document.querySelectorAll('#jog button')[%d], r = b.getBoundingClientRect();
  b.scrollIntoView({ block: 'center', behavior: 'instant' });
  const s = b.getBoundingClientRect();
  return [s.left + s.width / 2, s.top + s.height / 2];
})()"""
CONTRAST = """(() => {
  const rgb = (text) => text.match(/[\\d.]+/g).map(Number);
  const part = (v) => v <= 10 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4;
  const light = (c) => 0.2126 * part(c[0]) + 0.7152 * part(c[1]) + 0.0722 * part(c[2]);
  const solid = (c) => c.length < 4 || c[3] > 0.9 ? c : null;
  const opaque = (e) => solid(rgb(getComputedStyle(e).backgroundColor));
  const ground = (e) => e ? opaque(e) ?? ground(e.parentElement) : opaque(document.body);
  const says = (e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim());
  const seen = [...document.querySelectorAll('main *, header *')].filter((e) =>
    e.offsetParent && !e.closest('.viewer') && !e.disabled && says(e));
  return seen.map((e) => {
    const [a, b] = [light(rgb(getComputedStyle(e).color)), light(ground(e))];
    return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), `${e.tagName} ${e.id} ${e.className}`];
  }).filter(([ratio]) => ratio < 4.5);
})()"""
UNNAMED = """[...document.querySelectorAll('button, input, select, a, canvas[role], progress')].filter((e) =>
  e.offsetParent && !(e.textContent.trim() || e.getAttribute('aria-label') || e.labels?.length)
).map((e) => e.outerHTML.slice(0, 90))"""


@pytest.fixture(scope="module")
def chromium(server: Served) -> Iterator[Browser]:
    yield from entered(server.address, FLAT)


@pytest.fixture(scope="module")
def chromium_with_views(server: Served) -> Iterator[Browser]:
    yield from entered(server.address)


@contextmanager
def opened(
    chromium: Browser, server: Served, width: int = 1280, dark: bool = False, view: bool = False
) -> Iterator[Page]:
    with chromium.page(f"{server.origin}/", width, dark=dark, touch=width < 500) as page:
        page.until("window.operate && operate.link.page && !document.body.classList.contains('stale')")
        if view:
            page.until("operate.view.view")
        yield page
        assert page.complaints() == []
        assert [
            url for url in page.requests() if not url.startswith((server.origin, f"ws://127.0.0.1:{server.port}"))
        ] == []


def ready(page: Page, name: str = "Ann") -> None:
    page.run(f"document.getElementById('name').value = {name!r}")
    enable(page)


def press(page: Page, x: float, y: float, kind: str) -> None:
    page.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)


@pytest.mark.parametrize(("width", "dark"), LOOKS)
def test_it_fits_is_named_and_can_be_read(chromium_with_views: Browser, server: Served, width: int, dark: bool) -> None:
    with opened(chromium_with_views, server, width, dark, view=True) as page:
        page.until(f"{STATE} !== 'connecting'")
        page.run("document.querySelectorAll('details').forEach((each) => { each.open = true; })")
        page.until("document.querySelector('#first button:not([hidden])')")
        assert page.run("document.documentElement.scrollWidth") <= width
        assert page.run(UNNAMED) == []
        page.until("!document.body.classList.contains('stale')")
        assert page.run(CONTRAST) == []
        assert page.run("getComputedStyle(document.getElementById('stop')).position") != "none"
        assert page.run("document.getElementById('stop').getBoundingClientRect().top") < 200
        page.run("window.scrollTo(0, document.body.scrollHeight)")
        box = page.run("document.getElementById('stop').getBoundingClientRect().toJSON()")
        assert box["top"] >= 0
        assert box["right"] <= width  # Stop is always in view
        page.until("operate.view.drawn > 5")
        assert page.run("[...document.querySelectorAll('#lines tr')].length") == 4
        assert page.run("document.querySelectorAll('#view input[type=range]').length") == 0  # nothing of the live state


def test_states_and_reasons_are_shown(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        ready(page)
        page.until("document.getElementById('reason').textContent === 'The winches are enabled and hold.'")
        page.run("document.getElementById('stop').click()")
        page.until(f"{STATE} === 'fault'")
        page.until("document.getElementById('reason').textContent === 'Emergency stop.'")
        page.until("document.getElementById('events').textContent.includes('emergency stop by Ann')")
        assert page.run("operate.orders.buttons.enable.disabled")


def test_a_jog_ends_when_it_is_let_go(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page, client(server) as watching:
        ready(page)
        x, y = page.run(HOLD % 1)
        press(page, x, y, "mousePressed")
        watching.until(lambda state: state.get("state") == "manual")
        watching.during(1.2)
        press(page, x, y, "mouseReleased")
        watching.until(lambda state: state.get("state") == "idle", 10.0)
        moved = watching.states[-1]["platform"]["position"][0] - watching.states[0]["platform"]["position"][0]
        assert moved > 5e-3  # one lease alone moves it by 1 mm: a jog starts without a swing
        page.run("document.querySelectorAll('#jog button')[0].focus()")
        for kind in ("keyDown", "keyUp"):
            page.send("Input.dispatchKeyEvent", type=kind, key=" ", code="Space", windowsVirtualKeyCode=32)
            watching.during(0.4)
        watching.until(lambda state: state.get("state") == "idle", 10.0)
        assert any(state.get("state") == "manual" for state in watching.states[-60:])


def test_a_page_that_goes_in_a_jog_ends_it(chromium: Browser, server: Served) -> None:
    with client(server) as watching:
        with opened(chromium, server) as page:
            ready(page)
            press(page, *page.run(HOLD % 0), "mousePressed")
            watching.until(lambda state: state.get("state") == "manual")
            watching.during(0.5)
        watching.until(lambda state: state.get("state") == "idle", 10.0)
        last = max(state["jogged"] for state in watching.states if state.get("jogged") is not None)
        ended = next(
            state["time"] for state in watching.states if state.get("time", 0) > last and state["state"] == "idle"
        )
        assert ended - last <= 0.25 + 0.25 / 0.2 + 0.1  # the lease, and a ramp from the largest speed


def test_who_watches_cannot_jog_but_stop(chromium: Browser, server: Served) -> None:
    with client(server) as first, opened(chromium, server) as page:
        first.ready()
        page.until("document.getElementById('operator').textContent.includes('Ann')")
        assert page.run(
            "[...document.querySelectorAll('#jog button, #steps button, #more button')].every((b) => b.disabled)"
        )
        page.run("document.getElementById('stop').click()")
        first.until(lambda state: state["state"] == "fault")


def test_old_values_are_greyed_and_stop_still_gets_through(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page, client(server) as watching:
        ready(page)
        page.run("operate.link.open = () => {}; operate.link.socket.close()")
        began = time.monotonic()
        page.until("document.body.classList.contains('stale')", 5.0)
        assert time.monotonic() - began < 1.5
        page.run("operate.link.seen = performance.now()")  # a connection that is lost shows nothing as of now
        time.sleep(0.2)
        assert page.run("getComputedStyle(document.querySelector('.live')).opacity") == "0.45"
        assert "No news for" in page.run("document.getElementById('stale-told').textContent")
        page.run("document.getElementById('stop').click()")  # by a plain request
        watching.until(lambda state: state.get("state") == "fault", 10.0)


def test_a_bad_and_a_huge_file_are_rejected_by_name(chromium: Browser, server: Served) -> None:
    send = """((name, text) => { const t = new DataTransfer(); t.items.add(new File([text], name));
      document.getElementById('files').files = t.files; document.getElementById('upload').requestSubmit(); })"""
    with opened(chromium, server) as page:
        ready(page)
        page.run(f"{send}('big.toml', '#'.repeat(70000))")
        page.until("document.getElementById('upload-told').textContent.includes('too large')")
        assert "big.toml" in page.run("document.getElementById('upload-told').textContent")
        page.run(f"{send}('bad.toml', 'schema = 1\\nname = 7\\n')")
        page.until("document.querySelector('#jobs').textContent.includes('job.toml: name = 7')")
        page.complaints(), page._browser.events.clear()  # the rejections are in the console, as any status over 400


def test_a_page_without_a_script_stops(chromium: Browser, server: Served) -> None:
    with client(server) as watching:
        watching.ready()
        with chromium.page(f"{server.origin}/stop", 390, touch=True) as page:
            page.run("document.querySelector('form').submit()")
            watching.until(lambda state: state["state"] == "fault", 20.0)
            page.until("location.pathname === '/stop' && document.querySelector('form')")
            assert page.complaints() == []


@pytest.mark.slow
def test_a_job_is_sent_checked_printed_and_reported(chromium_with_views: Browser, server: Served) -> None:
    chromium = chromium_with_views
    ring = RING.replace("layers = 3", "layers = 1")
    send = """((text) => { const t = new DataTransfer(); t.items.add(new File([text], 'ring.toml'));
      document.getElementById('files').files = t.files; document.getElementById('upload').requestSubmit(); })"""
    with opened(chromium, server, view=True) as page:
        ready(page)
        page.run(f"{send}({json.dumps(ring)})")
        page.until("document.querySelector('#jobs').textContent.includes('check: yes')", 300.0)
        page.run("[...document.querySelectorAll('#jobs button')].find((b) => b.textContent === 'Load').click()")
        page.until("operate.state.sitting.job?.name === 'ring' && operate.view.view?.path", 60.0)
        ready(page)
        page.run("operate.orders.buttons.start.click()")
        page.run("document.getElementById('ask-yes').click()")
        page.until(f"{STATE} === 'printing'")
        page.run("operate.orders.give('override', { share: [0.5] })")
        page.until("operate.orders.control.share === 0.5")
        over = "operate.link.order('override', { share: [1.5] })"
        assert "one number from 0 to 1" in page.run(over)
        page.run("operate.orders.give('override', { share: [1] })")
        page.until("document.querySelector('#runs a')", 300.0)
        assert "finished" in page.run("document.getElementById('runs').textContent")
        report = page.run("document.querySelector('#runs a').href")
    with chromium.page(report, 1280) as page:
        page.until("document.querySelector('.verdict')")
        assert page.complaints() == []
        assert np.asarray(page.pixels("h1")).size
