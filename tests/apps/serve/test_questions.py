"""Questions of the operator's page: none is in the way of Stop, Pause or the state, and none outlives its situation."""

from __future__ import annotations

import itertools
import json
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("starlette")

from browser import FLAT, Browser, Page, browser, executable
from cablewright.live.serve.jobs import JobCheck, subject_of, write_check
from cablewright.robot import load
from cases import often, some
from served import RING, Served, client, served

pytestmark = [
    pytest.mark.clock,
    pytest.mark.skipif(executable() is None, reason="no chromium is installed: see README.md"),
    pytest.mark.skipif(sys.platform != "linux", reason="looks at processes in /proc"),
]

ROOT = Path(__file__).parents[3]
WIDTHS = {1280: False, 390: True}  # with touch
INPUTS = ("mouse", "touch", "Esc")
SOON = 0.25  # s of machine time, until a stop is obeyed
QUESTIONS = {
    **{kind: f"operate.orders.asked({kind!r})" for kind in ("start", "resume", "refilled", "take up", "home", "stop")},
    "speed from 0 %": "operate.orders.sure('Move on?', 'The platform moves at 50 % of the planned speed.', 'Yes')",
    "a check that said no": "operate.jobs.load({ id: '0', name: 'vase', check: "
    "{ answer: 'no', why: 'too near. '.repeat(99), subject: '' } })",
}  # fmt: skip
PILL = "document.getElementById('state').textContent"
OPEN = "document.getElementById('ask').open"
MIDDLE = """((id) => { const r = document.getElementById(id).getBoundingClientRect();
  return [r.left + r.width / 2, r.top + r.height / 2]; })"""
COVERED = """['stop', 'pause', 'state'].filter((id) => {
  const r = document.getElementById(id).getBoundingClientRect();
  const on = [[0.1, 0.2], [0.5, 0.5], [0.9, 0.8]].map(([u, v]) =>
    document.elementFromPoint(r.left + u * r.width, r.top + v * r.height));
  return r.top < 0 || r.right > innerWidth || on.some((e) => e?.id !== id);
})"""
RECORD = """window.seen = []; window.sent = []; window.began = null;
for (const kind of ['pointerdown', 'keydown'])
  window.addEventListener(kind, () => { window.began ??= operate.orders.control.time; }, true);
operate.link.on('state', ({ control }) => control && window.seen.push([control.state, control.since]));
{ const send = operate.link.send; operate.link.send = function (message) {
    if (message.t === 'order') window.sent.push(message.kind); return send.call(this, message); }; }"""
JOB = RING.replace('name = "ring"', 'name = "ring"\norigin = [0.0, 0.0, 5.9]').replace('"0.25 m/s"', '"0.1 m/s"')


@pytest.fixture(scope="module")
def chromium(server: Served) -> Iterator[Browser]:
    with browser(FLAT) as found:
        enter(found, server)
        yield found


def enter(chromium: Browser, server: Served) -> None:
    with chromium.page(server.address, 1280) as page:
        page.until("location.pathname === '/' && window.operate")


@contextmanager
def opened(chromium: Browser, server: Served, width: int = 1280, *, touch: bool = False) -> Iterator[Page]:
    with chromium.page(f"{server.origin}/", width, touch=touch) as page:
        page.until("window.operate && operate.link.page && !document.body.classList.contains('stale')")
        page.run(RECORD)
        page.until("operate.orders.control && !document.getElementById('take').disabled")
        page.run("document.getElementById('take').click()")
        page.until("operate.orders.mine")
        yield page
        page.run("operate.jog.end(); operate.link.send({ t: 'release' })")


def idle(page: Page) -> None:
    for kind, state in (("reset", "fault"), ("enable", "off")):
        page.until(f"operate.orders.control.state !== {state!r} || !operate.orders.buttons[{kind!r}].disabled")
        while page.run(f"operate.orders.control.state === {state!r}"):
            page.run(f"operate.orders.buttons[{kind!r}].click()")
            time.sleep(0.1)
    page.until("operate.orders.control.state === 'idle' && operate.orders.control.known")


def ask(page: Page, question: str) -> None:
    page.run(f"void ({QUESTIONS[question]})")
    page.until(OPEN, 10.0)


def touched(page: Page, identity: str) -> None:
    x, y = page.run(f"{MIDDLE}({identity!r})")
    page.send("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
    page.send("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])


def clicked(page: Page, identity: str, count: int = 1) -> None:
    x, y = page.run(f"{MIDDLE}({identity!r})")
    for kind in ("mousePressed", "mouseReleased"):
        page.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=count)


def pressed(page: Page, key: str, number: int) -> None:
    for kind in ("keyDown", "keyUp"):
        page.send("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=number)


def stopped_after(page: Page, way: str) -> float:
    """Stop in one *way*; return the machine time until the fault, s, since the last state that the page had seen.

    That is the state as the input reaches the page: the time in which a browser without a graphics card hands a touch
    to it is not that of the page, and was 10 to 700 ms on two busy cores.
    """
    x, y = page.run(f"{MIDDLE}('stop')")
    page.run("window.began = null")
    if way == "mouse":
        page.send("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", clickCount=1)
    elif way == "touch":
        page.send("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
    else:
        page.send("Input.dispatchKeyEvent", type="keyDown", key="Escape", code="Escape", windowsVirtualKeyCode=27)
    stopped = "window.seen.find(([state, since]) => state === 'fault' && since > window.began)"
    page.until(f"window.began !== null && {stopped}", 10.0)
    for method, given in (
        ("Mouse", {"type": "mouseReleased", "x": x, "y": y, "button": "left", "clickCount": 1}),
        ("Touch", {"type": "touchEnd", "touchPoints": []}),
        ("Key", {"type": "keyUp", "key": "Escape", "code": "Escape", "windowsVirtualKeyCode": 27}),
    ):
        if method.lower() == way or (method, way) == ("Key", "Esc"):
            page.send(f"Input.dispatch{method}Event", **given)
    return page.run(f"{stopped}[1] - window.began")


@pytest.mark.parametrize("width", WIDTHS)
def test_no_question_covers_stop_pause_or_the_state_and_no_is_its_default(
    chromium: Browser, server: Served, width: int
) -> None:
    with opened(chromium, server, width, touch=WIDTHS[width]) as page:
        idle(page)
        for question, scrolled in itertools.product(QUESTIONS, (0, 700)):
            page.run(f"window.scrollTo({{ top: {scrolled}, behavior: 'instant' }})")
            ask(page, question)
            assert page.run(COVERED) == [], question
            assert page.run("document.activeElement.id") == "ask-no"
            assert page.run("document.documentElement.scrollWidth") <= width
            for button in ("ask-yes", "ask-no"):  # within the window, whatever the text
                on = f"((at) => document.elementFromPoint(...at)?.id)({MIDDLE}({button!r}))"  # before the page moves
                assert page.run(on) == button
            pressed(page, "Enter", 13)  # No
            page.run("document.getElementById('ask-no').click()")
            page.until(f"!{OPEN}")
        assert page.run("window.sent.filter((kind) => !['reset', 'enable'].includes(kind))") == []


@pytest.mark.parametrize("way", INPUTS)
def test_stop_works_with_every_question_open(chromium: Browser, server: Served, way: str) -> None:
    with opened(chromium, server, 390 if way == "touch" else 1280, touch=way == "touch") as page:
        turn = slice(often(INPUTS.index(way), 0), None, often(len(INPUTS), 1))  # each way its share
        for question in list(QUESTIONS)[turn]:
            idle(page)
            ask(page, question)
            assert stopped_after(page, way) <= SOON, question
            page.until(f"!{OPEN}", 10.0)
        for state in ("manual", *("off", "fault")[turn]):  # while it moves, and where it stands with closed brakes
            if state == "manual":
                idle(page)
                page.run("operate.jog.begin(document.querySelector('#jog button'), [0, 0, 1])")
            elif state == "off":
                page.until("!operate.orders.buttons.reset.disabled")
                while page.run("operate.orders.control.state === 'fault'"):
                    page.run("operate.orders.buttons.reset.click()")
                    time.sleep(0.1)
            page.until(f"operate.orders.control.state === {state!r}")
            ask(page, "home")
            assert stopped_after(page, way) <= SOON, state
            page.until("operate.orders.control.reason === 'emergency stop'")


@pytest.mark.parametrize("focus", some(["name", "files", "ask-yes", "place", "share", "jog-speed", "pause"], 3))
def test_esc_stops_wherever_the_focus_is(chromium: Browser, server: Served, focus: str) -> None:
    with opened(chromium, server) as page:
        idle(page)
        ask(page, "home")
        page.run(f"document.getElementById({focus!r}).focus()")
        if focus in ("name", "place"):
            page.send("Input.insertText", text="1, 2")
        assert stopped_after(page, "Esc") <= SOON


def test_a_question_ends_with_its_situation_and_orders_nothing_in_another(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        for ends in (
            "operate.link.order('release')",  # another state
            "operate.link.send({ t: 'release' })",  # another operates, or no user
            "operate.link.socket.close()",  # the state is unknown
        ):
            page.until("!document.getElementById('take').disabled")
            if not page.run("operate.orders.mine"):
                page.run("document.getElementById('take').click()")
            page.until("operate.orders.mine")
            idle(page)
            ask(page, "home")
            page.run(f"void {ends}")
            page.until(f"!{OPEN}", 10.0)
            page.run("document.getElementById('ask-yes').click()")
        page.until(
            "document.getElementById('take').textContent === 'Operate' && !document.body.classList.contains('stale')"
        )
        page.run("document.getElementById('take').click()")
        page.until("operate.orders.mine")
        idle(page)
        page.run("window.sent.length = 0")
        ask(page, "home")
        page.run(
            "operate.orders.control = { ...operate.orders.control, state: 'off' };"
            "document.getElementById('ask-yes').click()"
        )
        page.until("operate.orders.control.state === 'idle'")  # by the next message
        ask(page, "home")
        clicked(page, "ask-yes", count=2)  # the second click of a double click on the asking button
        assert page.run(OPEN)
        assert "home" not in page.run("window.sent")
        clicked(page, "ask-yes")
        page.until("window.sent.includes('home')")


def test_all_that_moves_asks_and_nothing_that_stops_does(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        idle(page)
        for kind in ("start", "resume", "refilled", "take up", "home"):
            page.run(f"void operate.orders.asked({kind!r})")
            assert page.run(OPEN), kind
            page.run("document.getElementById('ask-no').click()")
        asked = page.run(  # without delay: the next message ends the situation, and the question with it
            "operate.orders.control = { ...operate.orders.control, share: 0, state: 'printing' };"
            f"void operate.orders.shared(0.5), {OPEN}"
        )
        assert asked
        page.until(f"!{OPEN}")
        page.run("window.sent.length = 0; void operate.orders.asked('pause')")
        page.until("window.sent.includes('pause')")
        assert not page.run(OPEN)


def test_state_words_say_whether_it_moves_and_that_a_fresh_machine_is_healthy(
    chromium: Browser, server: Served
) -> None:
    named = """((state, speeds, more = {}) => { operate.state.show({ control: { state, speeds, reason: '', ...more } });
      const pill = document.getElementById('state'); return [pill.textContent, pill.className]; })"""
    with opened(chromium, server) as page:
        page.run("operate.link.take = () => {}")  # nothing that comes from now on is shown
        states = ["ready", "printing", "manual", "tensioning", "homing", "idle", "paused", "stopped", "refilling"]
        for state in states:
            moving, shown = page.run(f"{named}({state!r}, [0, 0.1, 0, 0])")
            standing, _ = page.run(f"{named}({state!r}, [0, 0, 0, 0])")
            assert shown == "pill moves", state
            assert any(word in moving for word in ("mov", "ing")), moving
            assert state in ("tensioning", "homing") or moving != standing
        assert page.run(f"{named}('ready', [0.1])")[0] == "moving to the path"
        assert page.run(f"{named}('fault', [0, 0], {{ fresh: true }})") == ["off: reset to begin", "pill "]
        assert page.run(f"{named}('fault', [0, 0])") == ["fault", "pill bad"]
        assert page.run(f"{named}('closed', undefined, {{ opening: true }})") == ["opening", "pill "]
        assert page.run(f"{named}('closed', undefined)") == ["closed", "pill bad"]


def test_a_name_typed_after_operate_is_used_and_start_says_what_it_waits_for(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        page.run("document.getElementById('name').value = ''; document.getElementById('name').focus()")
        page.send("Input.insertText", text="Berta")
        pressed(page, "Tab", 9)
        page.until("document.getElementById('operator').textContent.includes('Berta')", 5.0)
        assert (
            page.run("document.querySelector('#steps li:last-child small').textContent") == "load a job first: see Jobs"
        )


def test_a_file_picker_cannot_be_opened_while_the_machine_moves(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        idle(page)
        assert not page.run("document.getElementById('files').disabled")
        page.run("operate.jog.begin(document.querySelector('#jog button'), [0, 0, 1])")
        page.until("operate.orders.control.state === 'manual' && document.getElementById('files').disabled", 5.0)
        assert "drop files" in page.run("document.getElementById('upload-note').textContent")
        page.run("operate.jog.end()")
        page.until("!document.getElementById('files').disabled")


def test_why_a_job_was_not_loaded_is_said_at_its_button(chromium: Browser, server: Served) -> None:
    far = JOB.replace("5.9", "500.0")  # a check would say no; where it says yes the machine still cannot go there
    told = "document.querySelector('#jobs [role=alert]')?.textContent"
    with opened(chromium, server) as page:
        idle(page)
        sent = sent_job(page, server, far, "yes")
        page.until(f"operate.jobs.list() && document.getElementById('jobs').textContent.includes({sent!r})")
        page.run("[...document.querySelectorAll('#jobs button')].find((b) => b.textContent === 'Load').click()")
        page.until(f"{told}?.includes('Not loaded: ')", 30.0)
        page.until("operate.orders.control.fresh", 30.0)
        assert page.run(told).startswith("Not loaded: ")
        page.run("[...document.querySelectorAll('#jobs button')].find((b) => b.textContent === 'Remove').click()")
        page.until("!document.querySelector('#jobs li button')")


def sent_job(page: Page, server: Served, text: str, answer: str) -> str:
    """Send a job whose check has the answer; return its name."""
    own = {"authorization": f"Bearer {server.token}", "x-page": page.run("operate.link.page")}
    name = f"job-{time.monotonic_ns()}"
    number = json.loads(server.ask("POST", "/jobs", json.dumps({"name": name}), **own)[1])["id"]
    assert server.ask("PUT", f"/jobs/{number}/settings", text, **own)[0] == 200
    folder = server.folder / "jobs" / number
    subject = subject_of(folder, load("house-printer"))
    write_check(folder, JobCheck(subject=subject, answer=answer, why="too heavy"))
    return name


@pytest.mark.slow
def test_stop_and_pause_in_every_state_of_a_print(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        idle(page)
        sent_job(page, server, JOB, "no")
        page.until("operate.jobs.list() && document.getElementById('jobs').textContent.includes('check: no')")
        page.run("[...document.querySelectorAll('#jobs button')].find((b) => b.textContent === 'Load').click()")
        page.until(OPEN)
        assert "too heavy" in page.run("document.getElementById('ask-text').textContent")
        clicked(page, "ask-yes")
        page.until("operate.state.sitting.job && operate.orders.control.fresh", 60.0)

        def order(kind: str, state: str) -> None:
            page.until(f"!operate.orders.buttons[{kind!r}].disabled")
            page.run(f"operate.orders.buttons[{kind!r}].click()")
            if page.run(OPEN):
                page.run("document.getElementById('ask-yes').click()")
            page.until(f"operate.orders.control.state === {state!r}")

        for state, way in itertools.product(("ready", "printing", "paused", "stopped"), INPUTS):
            page.send("Emulation.setTouchEmulationEnabled", enabled=way == "touch", maxTouchPoints=5)
            idle(page)
            order("start", "ready")
            if state != "ready":
                page.until("operate.orders.control.state === 'printing'")
            if state == "paused":
                ask(page, "stop")
                (touched if way == "touch" else clicked)(page, "pause")  # with a question open
                page.until("operate.orders.control.state === 'paused'", 5.0)
                page.until(f"!{OPEN}", 10.0)
            elif state == "stopped":
                order("stop", "stopped")
            ask(page, "resume" if state in ("paused", "stopped") else "stop")
            assert page.run("operate.orders.control.state") == state
            assert stopped_after(page, way) <= SOON, (state, way)
        page.until("!document.querySelector('#jobs .loaded button').disabled")
        page.until("operate.jobs.orders.control.speeds.every((speed) => speed === 0)")
        page.run("[...document.querySelectorAll('#jobs button')].find((b) => b.textContent === 'Put away').click()")
        page.until("!operate.state.sitting.job", 60.0)


@pytest.mark.slow
def test_stop_while_lines_are_taken_up_on_virtual_drives(tmp_path: Path) -> None:
    machine = str(ROOT / "examples" / "virtual-drives.toml")
    with served(tmp_path / "out", "merlet2023", "--machine", machine, "--try") as server, browser(FLAT) as chromium:
        enter(chromium, server)
        with opened(chromium, server) as page:
            for way in INPUTS:
                page.send("Emulation.setTouchEmulationEnabled", enabled=way == "touch", maxTouchPoints=5)
                for kind, state in (("reset", "off"), ("enable", "idle"), ("take up", "tensioning")):
                    page.until(f"!operate.orders.buttons[{kind!r}].disabled")
                    while page.run(f"operate.orders.control.state !== {state!r}"):
                        page.run(f"operate.orders.buttons[{kind!r}].click()")
                        page.run(f"{OPEN} && document.getElementById('ask-yes').click()")
                        time.sleep(0.2)
                ask(page, "stop")
                assert stopped_after(page, way) <= SOON, way


def test_who_only_watches_is_asked_nothing_and_stops_by_esc(chromium: Browser, server: Served) -> None:
    with client(server) as first, chromium.page(f"{server.origin}/", 1280) as page:
        first.ready()
        page.until("window.operate && operate.orders.operator && !operate.orders.mine")
        page.run("void operate.orders.asked('start')")
        assert not page.run(OPEN)
        pressed(page, "Escape", 27)
        first.until(lambda state: state["state"] == "fault", 10.0)
