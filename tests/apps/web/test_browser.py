"""Pages in a browser: no error, no request, nothing clipped, what one moves is seen to move, and fingers get past."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from apps.report.synthetic import make_check, ring_robot, small_job
from browser import Browser, browser, executable
from cablewright.apps import style
from cablewright.apps.report import check as check_report
from cablewright.apps.report.show import show_page
from cablewright.apps.web.robot_scene import robot_scene
from cablewright.robot import load
from print_logs import RING
from served import picture

ROOT = Path(__file__).parents[3]
EVIL = "</script><img src=x onerror=alert(1)>"

pytestmark = pytest.mark.skipif(executable() is None, reason="no chromium is installed: see README.md")

KINDS = (
    "robot", "markup", "job", "check", "log", "accuracy", "modes", "calibration", "replay", "print", "workspace",
    "interference", "bracket", "trade", "curves", "survey",
)  # fmt: skip
WITH_PATH = ("job", "check")
ALIKE = ("accuracy", "replay", "interference", "bracket", "trade", "curves", "survey")
"""Reports whose style and tables are those of the others: slow."""
DRAWN = ("robot", "modes", "calibration")  # with their pictures, beside "check"; the others have one of a pixel
LOOKS = [
    pytest.param(kind, width, dark, marks=[pytest.mark.slow] * (kind in ALIKE or (k > 1 and kind not in WITH_PATH)))
    for kind in KINDS
    for k, (width, dark) in enumerate(((1280, False), (390, True), (1280, True), (390, False)))
]
TRADE = (
    "trade", "jung2020", "--vary", "exit-distance=0.2,0.3", "--count", "nodes", "--grid", "5", "--boundary-grid", "5"
)  # fmt: skip
MIDDLE_OF_A_LINE = """(() => {
  const v = document.querySelector('.viewer').view, p = v.lines.points(v.frame, 2), k = p.length >> 1;
  const [a, b] = [v.project(p[k - 1]), v.project(p[k])], r = v.canvas.getBoundingClientRect();
  return [r.left + (a[0] + b[0]) / 2, r.top + (a[1] + b[1]) / 2];
})()"""


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as found:
        yield found


EXAMPLES = ROOT / "examples"
COMMANDS = {
    "robot": ("show", "cogiro", "--out"),
    "job": ("show", "house-printer", EXAMPLES / "helix.toml", "--out"),
    "log": ("show", "merlet2023", EXAMPLES / "merlet2023-loop.mcap", "--out"),
    "modes": ("modes", "jung2020", "--at", "0,0,0.8", "--report"),
    "calibration": ("calibrate", "wang2021", EXAMPLES / "calibration.csv", "--accept", "--report"),
    "replay": ("replay", EXAMPLES / "merlet2023-loop.mcap", "--report"),
    "workspace": ("workspace", "jung2020", "--tolerance", "0.05", "--report"),
    "interference": ("interference", "cogiro", "--at", "0,-1,1.5", "--report"),
    "bracket": ("bracket", "house-printer", "--at=-2.25,-6.75,13", "--times", "1", "--report"),
    "trade": (*TRADE, "--report"),
    "curves": ("curves", "--count", "8", "--seed", "2022", "--report"),
    "survey": ("survey", EXAMPLES / "survey.gsi", "--plan", EXAMPLES / "survey.toml", "--report"),
}


def marked_up() -> str:
    """The page of a robot whose names are markup."""
    robot = load("wang2021")
    line = robot.lines[0].model_copy(update={"name": EVIL[:60]})
    return show_page(robot_scene(robot.model_copy(update={"name": f"<b>{EVIL}", "lines": (line, *robot.lines[1:])})))


class Pages(dict[str, Path]):
    """Pages by their kind, each made where it is first looked at."""

    def __init__(self, folder: Path, cli) -> None:
        self.folder, self.cli = folder, cli

    def __missing__(self, kind: str) -> Path:
        page = self.folder / f"{kind}.html"
        with pytest.MonkeyPatch.context() as patch:
            if kind not in (*DRAWN, "check"):
                patch.setattr(style, "png", lambda _drawn: picture())  # style and width of a page are the same for all
            if kind == "markup":
                page.write_text(marked_up())
            elif kind in COMMANDS:
                self.cli(*COMMANDS[kind], page)
            else:
                shutil.copy(self.report(kind), page)
        assert page.is_file()
        self[kind] = page
        return page

    def report(self, kind: str) -> Path:
        """The report in a folder of a run."""
        run = self.folder / kind
        if kind == "check":
            check, layers = make_check(ring_robot(4), small_job(self.folder))
            run.mkdir()
            return check_report.write(check, run, layers)
        if kind == "accuracy":
            self.cli("accuracy", "wang2021", "--helix", "0.5,0.2,1,1.4", "--out", run)
        else:
            ring = self.folder / "ring.toml"
            ring.write_text(RING.format(radius=0.2))
            self.cli("print", "merlet2023", ring, "--plant", "quasi-static", "--out", run)
        return run / "report.html"


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory, cli) -> Pages:
    return Pages(tmp_path_factory.mktemp("pages"), cli)


@pytest.mark.parametrize(("kind", "width", "dark"), LOOKS)
def test_a_page_is_quiet_and_whole(chromium, pages, kind: str, width: int, dark: bool) -> None:
    with chromium.page(pages[kind], width, dark=dark, touch=width < 500) as page:
        page.settled()
        assert page.complaints() == []
        assert page.requests() == []
        assert page.run("[...document.querySelectorAll('.viewer')].map((v) => v.dataset.reason ?? '')") in ([], [""])
        assert page.run("document.documentElement.scrollWidth") <= width
        outside = "[...document.querySelectorAll('table')].filter((t) => !t.closest('.wide')).length"
        assert page.run(outside) == 0
        assert page.run("getComputedStyle(document.querySelector('.wide') ?? document.body).overflowX") != "hidden"
        assert "<b>" not in page.run("document.body.innerText").replace(f"<b>{EVIL}", "")
        assert page.run("document.querySelectorAll('img[src=x]').length") == 0


def test_dark_pages_are_dark_all_over(chromium, pages) -> None:
    with chromium.page(pages["modes"], 1280, dark=True) as page:
        page.settled()
        assert page.pixels("figure img").mean() < 0.35
        assert page.pixels(".stage").mean() < 0.35
    with chromium.page(pages["modes"], 1280) as page:
        page.settled()
        assert page.pixels("figure img").mean() > 0.65


@pytest.mark.parametrize("kind", WITH_PATH)
def test_sliders_change_what_is_drawn(chromium, pages, kind: str) -> None:
    with chromium.page(pages[kind], 1280) as page:
        page.settled()
        before = page.pixels(".stage")
        assert before.std() > 0.01
        page.run("(() => { const s = document.querySelector('.scrub'); s.value = Math.round(0.4 * s.max);"
                 "s.dispatchEvent(new Event('input')); })()")  # fmt: skip
        scrubbed = page.pixels(".stage")
        assert _changed(before, scrubbed) > 50
        page.run("(() => { const s = document.querySelector('.layer'); s.value = 0;"
                 "s.dispatchEvent(new Event('input')); })()")  # fmt: skip
        assert _changed(scrubbed, page.pixels(".stage")) > 20


def test_time_goes_on_while_it_plays(chromium, pages) -> None:
    with chromium.page(pages["job"], 1280) as page:
        page.settled()
        page.run("document.querySelector('.play').click()")
        page.until("document.querySelector('.viewer').view.frame > 3")
        page.run("document.querySelector('.play').click()")
        assert page.run("document.querySelector('.play').textContent") == "Play"


def test_sliders_of_the_pose_show_a_state_that_was_solved(chromium, pages) -> None:
    with chromium.page(pages["robot"], 1280) as page:
        page.settled()
        before = page.pixels(".stage")
        page.run("(() => { const s = document.querySelectorAll('.pose')[2]; s.value = 0;"
                 "s.dispatchEvent(new Event('input')); })()")  # fmt: skip
        assert _changed(before, page.pixels(".stage")) > 200
        view = "document.querySelector('.viewer').view"
        x, y, z = page.run(f"{view}.given.frames.lattice")
        assert page.run(f"{view}.pose()[2]") == pytest.approx(z[0], rel=1e-6)
        assert page.run(f"{view}.frame") < len(x) * len(y)
        assert f"{z[0]:.3f}" in page.run("document.querySelector('.readout').innerText").replace("\N{MINUS SIGN}", "-")


def test_points_of_lidars_can_be_hidden(chromium, pages) -> None:
    with chromium.page(pages["log"], 1280) as page:
        page.settled()
        page.run("document.querySelector('.viewer').view.show(15)")
        before = page.pixels(".stage")
        tick = "[...document.querySelectorAll('.choices label')].find((l) => l.textContent.includes('lidar points'))"
        page.run(f"{tick}.querySelector('input').click()")
        assert _changed(before, page.pixels(".stage")) > 200


@pytest.mark.parametrize("kind", ["robot", "job"])
def test_turning_by_mouse_and_keys(chromium, pages, kind: str) -> None:
    with chromium.page(pages[kind], 1280) as page:
        page.settled()
        before = page.pixels(".stage")
        box = page.run("document.querySelector('.stage canvas').getBoundingClientRect().toJSON()")
        x, y = box["left"] + 400, box["top"] + 300
        for what, at in (("mousePressed", x), ("mouseMoved", x + 120), ("mouseReleased", x + 120)):
            page.send("Input.dispatchMouseEvent", type=what, x=at, y=y, button="left", buttons=1, clickCount=1)
        turned = page.pixels(".stage")
        assert _changed(before, turned) > 500
        for kind_of in ("keyDown", "keyUp"):
            page.send("Input.dispatchKeyEvent", type=kind_of, key="0", text="0" if kind_of == "keyDown" else "")
        page.until("!document.querySelector('.viewer').view.moving")
        page.run("document.activeElement.blur()")  # the ring of the focus is a change too
        assert _changed(before, page.pixels(".stage")) < 60


def test_a_line_shows_its_tension(chromium, pages) -> None:
    with chromium.page(pages["robot"], 1280) as page:
        page.settled()
        at = page.run(MIDDLE_OF_A_LINE)
        page.send("Input.dispatchMouseEvent", type="mouseMoved", x=at[0], y=at[1])
        page.until("!document.querySelector('.tip').hidden")
        told = page.run("document.querySelector('.tip').innerText")
        assert "tension 4" in told
        assert "limits 100 N to 5 kN" in told


def test_one_finger_scrolls_past_and_sideways_turns(chromium, pages) -> None:
    with chromium.page(pages["job"], 390, 700, touch=True) as page:
        page.settled()
        azimuth = page.run("document.querySelector('.viewer').view.camera.azimuth")
        page.swipe(195, 400, -250)
        page.until("window.scrollY > 100")
        page.run("window.scrollTo({top: 0, behavior: 'instant'})")
        page.swipe(195, 300, 0, dx=120)
        assert page.run("document.querySelector('.viewer').view.camera.azimuth") != azimuth


def test_without_webgl_a_picture_stays(pages) -> None:
    with browser("--disable-gpu", "--disable-3d-apis") as plain, plain.page(pages["check"], 1280) as page:
        page.settled()
        assert page.run("document.querySelector('.viewer').dataset.reason")
        assert page.run("getComputedStyle(document.querySelector('.still')).display") != "none"
        assert page.pixels(".still").std() > 0.01


def _changed(one: np.ndarray, other: np.ndarray) -> int:
    """Number of pixels that differ."""
    return int((np.abs(one - other).max(axis=2) > 0.08).sum())
