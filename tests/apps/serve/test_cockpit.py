"""Tasks of an operator in a browser, each to its end: one primary action at a time, and a reason at each grey
button."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("starlette")

from browser import FLAT, Browser, Page, entered, executable
from cablewright.apps.serve.uploads import Uploads
from cablewright.live.serve.jobs import JobCheck, subject_of, write_check
from cablewright.robot import load
from cases import some
from operator_page import STATE, enable
from served import RING, Served, client

pytestmark = [
    pytest.mark.clock,
    pytest.mark.skipif(executable() is None, reason="no chromium is installed: see README.md, Tests"),
]

PAGE = Path(__file__).parents[3] / "src" / "cablewright" / "apps" / "serve" / "page"
ACT, NEXT = "document.getElementById('act')", "document.getElementById('next').textContent"
MOVES = "['ready', 'printing'].includes(operate.orders.control.state)"
OVERLAPS = """(() => {
  const all = ['section', 'button', 'input', 'select', 'h2'].map((tag) => `main ${tag}`).join() + ', header button';
  const boxes = [...document.querySelectorAll(all)]
    .filter((e) => e.offsetParent && !e.closest('.viewer') && !e.closest('details:not([open])'))
    .map((e) => [e, e.getBoundingClientRect(), Boolean(e.closest('header'))]);
  const found = [];
  for (const [i, [a, r, above]] of boxes.entries()) for (const [b, s, other] of boxes.slice(i + 1)) {
    if (a.contains(b) || b.contains(a) || above !== other) continue;
    const wide = Math.min(r.right, s.right) - Math.max(r.left, s.left);
    const tall = Math.min(r.bottom, s.bottom) - Math.max(r.top, s.top);
    if (wide > 1 && tall > 1) found.push([a, b].map((e) => `${e.tagName} ${e.id} ${e.textContent.slice(0, 20)}`));
  }
  return found;
})()"""
CLIPPED = """(() => {
  const all = ['section', 'button', 'p', 'td', 'dd', 'h2'].map((tag) => `main ${tag}`).join() + ', header button';
  return [...document.querySelectorAll(all)]
    .filter((e) => e.offsetParent && !e.closest('.viewer') && getComputedStyle(e).display !== 'inline')
    .filter((e) => e.scrollWidth > e.clientWidth + 1 || e.getBoundingClientRect().right > innerWidth + 1)
    .map((e) => `${e.tagName} ${e.id} ${e.textContent.slice(0, 30)}`);
})()"""
GREY = """[...document.querySelectorAll('#steps button:disabled, #more button:disabled')].filter((e) => e.offsetParent)
  .filter((e) => !e.title || e.nextElementSibling.textContent !== e.title).map((e) => e.textContent)"""


@pytest.fixture(scope="module")
def chromium(server: Served) -> Iterator[Browser]:
    yield from entered(server.address, FLAT)


@pytest.fixture(scope="module")
def chromium_with_views(server: Served) -> Iterator[Browser]:
    yield from entered(server.address)


@contextmanager
def opened(
    chromium: Browser, server: Served, width: int = 1280, *, dark: bool = False, mine: bool = True
) -> Iterator[Page]:
    with chromium.page(f"{server.origin}/", width, dark=dark, touch=width < 500) as page:
        page.until("window.operate && operate.link.page && !document.body.classList.contains('stale')")
        if mine:
            enable(page)
        yield page
        assert page.complaints() == []


def wait(page: Page, condition: str, patience: float = 60.0) -> None:
    """Wait for a condition; where it does not come, say what the page shows instead."""
    try:
        page.until(condition, patience)
    except TimeoutError:
        parts = ["state", "next", "act", "reason", "answer", "operator"]
        shown = f"{parts}.map((i) => document.getElementById(i).textContent)"
        raise AssertionError(f"{condition}: {page.run(shown)}") from None


def done(page: Page, act: Callable[[], object], condition: str, begun: str = "false") -> None:
    """Do something until a condition holds, again only while it has not *begun*: a late page loses the lease."""
    end = time.monotonic() + 120.0
    while True:
        enable(page)
        act()
        try:
            page.until(f"{condition} || {begun}", 10.0)
        except TimeoutError:
            assert time.monotonic() < end, page.run("document.getElementById('answer').textContent")
            continue
        return wait(page, condition)


def press(page: Page, text: str) -> None:
    """Press the primary action, once it has this text."""
    wait(page, f"!{ACT}.hidden && {ACT}.textContent === {text!r}")
    page.run(f"{ACT}.click()")


def printed(page: Page, name: str) -> str:
    """Print a job by one confirmation; return what was confirmed.

    A computer that is too busy loses the lease, or sees old states: the page shows it, and the person begins again.
    """
    end = time.monotonic() + 240.0
    told = ""
    while not page.run(MOVES):
        assert time.monotonic() < end, page.run("document.getElementById('answer').textContent")
        if page.run("Boolean(operate.printing.told)"):
            time.sleep(0.2)
            continue
        enable(page)
        loaded = page.run("Boolean(operate.state.sitting.job)")
        press(page, "Start" if loaded else f"Print {name}")
        now = confirm(page)
        told = told or now
        page.until(f"{MOVES} || !operate.printing.told", 150.0)
    return told


def confirm(page: Page) -> str:
    page.until("document.getElementById('ask').open")
    told = str(page.run("document.getElementById('ask-text').textContent"))
    page.run("document.getElementById('ask-yes').click()")
    return told


def job(page: Page, server: Served, name: str, text: str, answer: str, why: str = "it can") -> str:
    """Keep a job whose check has the answer; return its number."""
    uploads = Uploads(server.folder)
    number = uploads.new_job(name)
    uploads.put_whole(number, "settings", text.encode())
    folder = uploads.job(number)
    subject = subject_of(folder, load("house-printer"))
    given: dict[str, Any] = {"expected_error": 8.3e-3, "duration": 372.0} if answer == "yes" else {}
    write_check(folder, JobCheck(subject=subject, answer=answer, why=why, **given))  # type: ignore[arg-type]
    page.run("operate.jobs.list()")
    return number


@pytest.mark.parametrize(
    ("width", "dark"), some([(390, True), (2560, False), (1280, False), (390, False), (2560, True)], 3)
)
def test_nothing_overlaps_or_is_cut(chromium_with_views: Browser, server: Served, width: int, dark: bool) -> None:
    with opened(chromium_with_views, server, width, dark=dark, mine=False) as page:
        page.until("operate.view.view")
        page.run("document.getElementById('first-run').open = true")
        page.until("document.querySelector('#first button:not([hidden])')")
        assert page.run("document.documentElement.scrollWidth") <= width
        assert page.run(OVERLAPS) == []
        assert page.run(CLIPPED) == []
        assert page.run(GREY) == []
        asked = """performance.getEntriesByType('resource').filter((e) => /static|scene/.test(e.name))
          .reduce((sum, e) => sum + e.decodedBodySize, document.documentElement.outerHTML.length)"""
        assert page.run(asked) > 1e5
        assert page.run(asked) < 1.2e6


def test_every_text_is_in_the_table_and_every_text_is_used() -> None:
    table = set(re.findall(r'"([a-z][\w. ]*)": "', (PAGE / "texts.js").read_text()))
    pages = "".join(each.read_text() for each in PAGE.iterdir() if each.name != "texts.js")
    named = set(re.findall(r'data-t(?:-label|-hint)?="([^"]+)"', pages)) | set(re.findall(r'\bt\("([^"]+)"', pages))
    assert named <= table
    begins = set(re.findall(r"`([a-z]+)\.\$\{|worded\(\"([a-z]+)\"", pages))  # of keys that are made up
    begins = {each for pair in begins for each in pair}
    whole = set(re.findall(r'"([a-z][\w. ]+)"', pages))
    unused = {key for key in table - named - whole if key.split(".")[0] not in begins}
    assert unused == set()


def test_the_first_minute_has_one_primary_action_at_a_time(chromium: Browser, server: Served) -> None:
    with opened(chromium, server, mine=False) as page:
        page.until("!document.getElementById('take').disabled")
        assert "press Operate" in page.run(NEXT)
        press(page, "Operate")
        if page.run("operate.orders.control.state !== 'idle'"):
            press(page, "Reset")
            press(page, "Enable")
        page.until(f"{STATE} === 'idle'")
        assert page.run("document.querySelectorAll('.next').length") <= 1
        assert page.run(GREY) == []


def test_a_step_goes_to_a_corner_and_no_farther(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        begin = page.run("operate.jog.here")
        page.run("document.querySelectorAll('#step input')[3].click()")  # 100 mm
        press_x = (
            "document.querySelectorAll('#jog button')[1].dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter' }))"
        )
        x = "operate.jog.here[0]"
        there = f"{STATE} === 'idle' && Math.abs({x} - {begin[0] + 0.1}) < 2e-3"
        done(page, lambda: page.run(press_x), there, f"{x} > {begin[0] + 2e-3}")

        def press_left() -> None:
            page.run("document.querySelector('#jog button').focus()")
            for kind in ("keyDown", "keyUp"):
                page.send(
                    "Input.dispatchKeyEvent", type=kind, key="ArrowLeft", code="ArrowLeft", windowsVirtualKeyCode=37
                )

        back = f"{STATE} === 'idle' && Math.abs({x} - {begin[0]}) < 4e-3"
        done(page, press_left, back, f"{x} < {begin[0] + 0.096}")
        assert page.run("operate.jog.here")[0] == pytest.approx(begin[0], abs=4e-3)


def test_a_click_in_the_plan_is_checked_before_it_moves(chromium: Browser, server: Served) -> None:
    click = """((x, y) => {
      const p = document.getElementById('plan'), q = new DOMPoint(x, -y).matrixTransform(p.getScreenCTM());
      p.dispatchEvent(new MouseEvent('click', { clientX: q.x, clientY: q.y, bubbles: true })); })"""
    with opened(chromium, server) as page, client(server) as watching:
        done(page, lambda: page.run(f"{click}(0.2, -0.1)"), "document.getElementById('ask').open")
        told = confirm(page)
        assert "within their limits" in told
        watching.until(lambda state: state["state"] == "manual")
        page.until("Math.hypot(operate.jog.here[0] - 0.2, operate.jog.here[1] + 0.1) < 0.03")  # a pixel
        page.until(f"{STATE} === 'idle'")
        for place, why in (("0, 0, 99", "is outside"), ("0, 0, 15", "no tensions within the limits")):
            page.run(f"document.getElementById('goal').value = {place!r}; document.getElementById('goto-yes').click()")
            page.until(f"document.getElementById('answer').textContent.includes({why!r})")
            assert not page.run("document.getElementById('ask').open")
        assert page.run(STATE) == "idle"


def test_the_console_gives_orders_under_the_same_lease(chromium: Browser, server: Served) -> None:
    give = """((text) => { document.getElementById('line').value = text;
      document.getElementById('console').requestSubmit(); })"""
    newest = "(document.querySelector('#console-told li')?.textContent ?? '')"
    with opened(chromium, server) as page:
        for text, told in (
            ("fly", "no such order"),
            ("jog 1 0 0", "hold a button"),
            ("release", "obeyed"),
            ("start", "not confirmed"),
        ):
            answered = f"{newest}.startsWith({text!r}) && {newest}.includes({told!r})"
            if text == "release":
                done(page, lambda: page.run(f"{give}('release')"), answered)
            else:
                page.run(f"{give}({text!r})")
            if text == "start":
                page.until("document.getElementById('ask').open")
                page.run("document.getElementById('ask-no').click()")
            page.until(answered)
        page.until(f"{STATE} === 'off'")
        page.run("operate.link.send({ t: 'release' })")
        page.until("!operate.orders.mine")
        page.run(f"{give}('enable')")
        page.until(f"{newest}.includes('press Operate first')")
        assert page.run(STATE) == "off"


def test_the_console_keeps_every_number_of_an_order(chromium: Browser, server: Served) -> None:
    give = """((text) => { document.getElementById('line').value = text;
      document.getElementById('console').requestSubmit(); })"""
    newest = "(document.querySelector('#console-told li')?.textContent ?? '')"
    with opened(chromium, server) as page:
        for text in ("enable 5", "override", "home 1"):
            page.run(f"{give}({text!r})")
            page.until(f"{newest}.startsWith({text!r}) && {newest}.includes('numbers')")
        page.run(f"{give}('home 0.3 -0.5 1')")  # the measured place is in the question
        page.until("document.getElementById('ask').open")
        assert page.run("document.getElementById('place').value") == "0.3, -0.5, 1"
        page.run(f"{give}('park')")  # which moves
        page.until("document.getElementById('ask-title').textContent === 'Park?'")
        page.run("document.getElementById('ask-no').click()")
        page.until(f"{newest}.startsWith('park') && {newest}.includes('not confirmed')")


def test_a_way_is_ordered_only_from_where_it_was_checked(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        page.until(f"{STATE} === 'idle' && operate.jog.may", 60.0)
        page.run("window.asked = operate.link.ask; operate.link.ask = async () => ({ holds: true, length: 0.1 })")
        page.run("window.sent = []; operate.orders.give = (...order) => { sent.push(order); return ''; }")
        page.run("operate.orders.sure = async () => true")
        for moved, why in ((0.0, ""), (0.1, "has moved since")):
            page.run(f"""operate.orders.sure = async () => {{
              const {{ platform }} = operate.orders.control;
              platform.position = platform.position.map((v) => v + {moved});
              return true;
            }}; operate.jog.go([0, 0, 1]).then((why) => {{ window.why = why; }})""")
            page.until("window.why !== undefined")
            assert why in page.run("window.why")
            page.run("window.why = undefined")
        page.run(
            "operate.orders.control.speeds = [0.1]; operate.jog.go([0, 0, 1]).then((why) => { window.why = why; })"
        )
        page.until("window.why?.includes('moves')")
        assert page.run("sent.length") == 1


def test_a_fault_after_a_confirmation_is_not_reset_by_it(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        page.run("""(async () => {
          const { printing, orders } = operate;
          window.sent = []; operate.link.order = async (kind) => { sent.push(kind); return 'no'; };
          const control = { ...orders.control, state: 'fault', fresh: false };
          Object.defineProperty(orders, 'control', { get: () => control, set: () => {} });
          orders.may = () => true;
          printing.pressed = orders.stops; printing.stopped = printing.stops;
          await printing.order('reset', 'fault', 'off', 'resets').catch((reason) => { window.why = reason.message; });
        })()""")
        page.until("window.why")
        assert "fault" in page.run("window.why")
        assert page.run("sent") == []


def test_a_still_picture_that_does_not_come_does_not_show_the_last_one(chromium: Browser, server: Served) -> None:
    with opened(chromium, server, mine=False) as page:
        page.run(
            "window.asked = []; window.setTimeout = (act, wait) => { asked.push([act, wait]); return asked.length; }"
        )
        page.run("operate.camera.begin('/static/icon.svg?snapshot')")  # of this origin
        page.until("asked.length === 2 && !document.getElementById('camera').hidden")
        assert page.run("asked.map(([, wait]) => wait)") == [5000, 1000]
        page.run("asked[0][0]()")  # the timer of a picture that does not come
        assert page.run("document.getElementById('camera').hidden")
        assert "No picture comes" in page.run("document.getElementById('camera-told').textContent")


def test_a_double_click_gives_one_order(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        page.run("window.given = 0; operate.next.act = () => { given += 1; }; operate.next.show = () => {};")
        for detail in (1, 2):
            page.run(f"{ACT}.dispatchEvent(new MouseEvent('click', {{ detail: {detail} }}))")
        assert page.run("given") == 1


def test_no_field_opens_a_list_that_would_take_esc_from_stop(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        assert page.run("document.querySelectorAll('select, [list], [type=date], [type=color]').length") == 0
        assert page.run("document.getElementById('slicers').elements.scope.value") == "upload"


def test_a_job_whose_robot_was_changed_can_be_checked_again(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        number = job(page, server, "old machine", RING, "yes")
        folder = Uploads(server.folder).job(number)
        write_check(folder, JobCheck(subject="0" * 64, answer="yes", why="it can, of another robot"))
        page.run("operate.jobs.list()")
        page.until("operate.jobs.jobs[0]?.check?.why.includes('another')")
        page.run("operate.jobs.load(operate.jobs.jobs[0])")
        page.until("document.getElementById('jobs').textContent.includes('check it again')", 90.0)
        row = "[...document.querySelectorAll('#jobs li')].find((e) => e.textContent.includes('old machine'))"
        page.until(f"[...{row}.querySelectorAll('button')].some((e) => e.textContent === 'Check again')")
        page.until("operate.orders.control?.state && operate.orders.control.state !== 'closed'", 60.0)
        Uploads(server.folder).remove(number)


def test_a_rejected_job_says_why_and_what_is_next(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page:
        number = job(page, server, "too far", RING, "no", "it is too far out")
        page.until("document.getElementById('jobs').textContent.includes('it is too far out')")
        page.until(f"{NEXT}.includes('did not say yes')")
        Uploads(server.folder).remove(number)


def test_one_confirmation_prints_and_pause_resume_stop_have_a_way_on(chromium: Browser, server: Served) -> None:
    origin = 'name = "ring"\norigin = [0.0, 0.0, 5.5]'
    ring = RING.replace("layers = 3", "layers = 12").replace('name = "ring"', origin)  # not done before the test is
    with opened(chromium, server) as page:
        number = job(page, server, "ring", ring, "yes")
        told = printed(page, "ring")
        assert "expected error 8.3 mm" in told
        assert "Keep everyone clear" in told
        assert page.run("operate.orders.control.speeds.length") == 4
        press(page, "Pause")
        page.until(f"{STATE} === 'paused'", 60.0)
        enable(page)
        press(page, "Resume")
        confirm(page)
        wait(page, MOVES)
        page.run("operate.link.open = () => {}; operate.link.socket.close()")  # the connection is lost while it prints
        page.until("document.body.classList.contains('stale')", 5.0)
        with client(server) as second:  # another one takes over, and stops
            second.until(lambda state: state["state"] in ("ready", "printing"))
            end = time.monotonic() + 20.0
            while why := second.take("Bob"):
                assert time.monotonic() < end, why
                second.during(0.2)
            second.send(t="stop")
            second.until(lambda state: state["state"] == "fault")
    with opened(chromium, server, mine=False) as page:  # and from there on it goes on
        page.until("!document.getElementById('take').disabled")
        press(page, "Operate")
        press(page, "Reset")
        page.until("operate.orders.control.state !== 'fault'", 20.0)
        away = "[...document.querySelectorAll('#jobs button')].find((b) => b.textContent === 'Put away')"
        page.until(f"{away} && !{away}.disabled")
        page.run(f"{away}.click()")
        page.until("!operate.state.sitting.job && operate.orders.control.state !== 'closed'", 60.0)
        page.until(
            "operate.runs.list() && document.getElementById('runs').textContent.includes('check said yes')", 30.0
        )
        run = page.run("operate.runs.runs[0].name")
        noted = "document.querySelector('#runs summary').textContent.includes('line two was worn')"
        for _ in range(20):  # a list that is made again meanwhile, or a lease that was lost, is no dead end
            page.run("operate.orders.mine || document.getElementById('take').click()")
            page.run("""{ const [area, keep] = document.querySelectorAll('#runs textarea, #runs details button');
              area.value = 'line two was worn'; keep.click(); }""")
            time.sleep(1.0)
            if page.run(noted):
                break
        assert page.run(noted)
        assert (server.folder / "runs" / run / "notes.txt").read_text() == "line two was worn"
        page.run("document.getElementById('find').value = 'nothing such'; operate.runs.show()")
        assert "No run matches" in page.run("document.getElementById('runs').textContent")
        Uploads(server.folder).remove(number)


def test_stop_withdraws_a_print_that_was_confirmed(chromium: Browser, server: Served) -> None:
    with opened(chromium, server) as page, client(server) as other:
        job(page, server, "ring again", RING, "yes")
        press(page, "Print ring again")
        confirm(page)
        other.send(t="stop")  # by somebody else, while the job is loaded
        page.until("!operate.printing.told", 150.0)
        assert "was not started" in page.run("document.getElementById('answer').textContent")
        other.during(3.0)
        assert not any(state.get("state") in ("ready", "printing") for state in other.states)
        (
            page.complaints(),
            page._browser.events.clear(),
        )  # a load that a stop overtook is in the console, as any over 400
