"""A platform in a tilted plane on the operator's page: enabled, homed, moved by hand, and a layer printed."""

from __future__ import annotations

import json
import os
import re
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("starlette")

import cablewright as cw
from browser import Page, browser, executable
from cablewright.machine.simulated.machine_file import machine_file
from operator_page import STATE, load, order, take
from served import Served, served

pytestmark = pytest.mark.clock

BEGIN = "0.1, 0.2143593, 0.8"
GCODE = ";LAYER:0\nG21\nG90\nM83\nG1 X60 E5 F3600\nG1 Y16.077 Z60 E5\nG1 X0 Y0 Z0 E5\n"
JOB = """
schema = 1
name = "triangle"
origin = [0.1, 0.2143593, 0.8]
[bead]
width = "6 mm"
height = "2 mm"
[motion]
print_speed = "60 mm/s"
travel_speed = "60 mm/s"
acceleration = "0.1 m/s^2"
"""
DRIVES = """
[motor_torques]
rate = 100.0
deviation = 0.5
most = 2000.0
[drives]
interface = "loopback"
channel = "43113"
rated_torque = "2 N m"
tension = "15 N"
[drives.nodes]
"""
SEND = """((files) => { const t = new DataTransfer();
  for (const [name, text] of files) t.items.add(new File([text], name));
  document.getElementById('files').files = t.files; document.getElementById('upload').requestSubmit(); })"""


def on_drives(name: str) -> str:
    """The machine file of the robot *name* with its winches on virtual drives."""
    robot = cw.load(name)
    text = machine_file(robot).replace('period = "10 ms"', 'kind = "canopen"\nperiod = "10 ms"')
    text = re.sub(r"max_speed = \S+", "max_speed = 12.0", text, count=1)
    for table in ("climate_sensor", "barrier"):
        text = re.sub(rf"\[{table}\][^\[]*", "", text)
    nodes = (
        f'"{line.name}" = {{ id = {k + 1}, direction = {(1, -1)[k % 2]} }}\n' for k, line in enumerate(robot.lines)
    )
    return text + DRIVES + "".join(nodes)


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder = tmp_path_factory.mktemp("served")
    machine = folder / "machine.toml"
    machine.write_text(on_drives("maslow4"))
    with served(folder / "out", "maslow4", "--machine", str(machine), "--try", "--at", BEGIN) as made:
        yield made


def keep(page: Page, name: str) -> None:
    """Keep a picture of the page for whoever asks for one by PICTURES."""
    if folder := os.environ.get("PICTURES"):
        (Path(folder) / f"{name}.png").write_bytes(page.picture(whole=True))


def click(page: Page, selector: str) -> None:
    page.until(f"!document.querySelector('{selector}').disabled")
    page.run(f"document.querySelector('{selector}').click()")


def home(page: Page, measured: str) -> None:
    """Reset, enable and home the machine, by a *measured* place unless that is empty."""
    for kind, then in (("reset", "off"), ("enable", "idle")):
        page.until(f"!operate.orders.buttons[{kind!r}].disabled")
        order(page, kind, then)
    page.run("operate.orders.buttons.home.click()")
    page.until("document.getElementById('ask').open")
    page.run(f"document.getElementById('place').value = {measured!r}")
    page.run("document.getElementById('ask-yes').click()")
    page.until("operate.orders.control.known", 180.0)
    page.until(f"{STATE} === 'idle'")


def place(page: Page) -> np.ndarray:
    return np.array(page.run("operate.orders.control.platform.position"))


@pytest.mark.slow
@pytest.mark.skipif(executable() is None, reason="no chromium is installed: see README.md")
def test_a_machine_in_a_plane_goes_from_enable_to_a_printed_layer(server: Served) -> None:
    plane = cw.load("maslow4").platform.plane
    assert plane is not None
    with browser() as chromium, chromium.page(server.address, 1280) as page:
        page.until("location.pathname === '/' && window.operate && operate.view.view")
        page.until("document.querySelectorAll('#jog button').length === 4")
        labels = page.run("[...document.querySelectorAll('#jog button')].map((b) => b.textContent)")
        assert labels == ["\u2212x", "+x", "down in the plane", "up in the plane"]
        take(page)
        home(page, BEGIN)
        homed = place(page)
        assert np.linalg.norm(homed - np.array(json.loads(f"[{BEGIN}]"))) < 1e-3
        keep(page, "homed")
        up = "document.querySelectorAll('#jog button')[3]"
        end = time.monotonic() + 120.0
        while place(page)[2] < homed[2] + 0.03:  # a busy computer's page may end a jog by itself, as its state is old
            assert time.monotonic() < end, place(page)
            take(page)  # which that page may have lost too
            page.until(f"!{up}.disabled")
            page.run(f"{up}.dispatchEvent(new KeyboardEvent('keydown', {{ key: 'Enter' }}))")
            time.sleep(1.0)
            page.run(f"{up}.dispatchEvent(new KeyboardEvent('keyup', {{ key: 'Enter' }}))")
        page.until(f"{STATE} === 'idle'")
        jogged = place(page)
        assert abs(jogged[0] - homed[0]) < 1e-3
        assert abs(plane.height(jogged)) < 1e-6
        page.run("document.getElementById('goal').value = '0.2, 0.9'")
        click(page, "#goto-yes")
        page.until("document.getElementById('ask').open")  # once the way was checked
        page.run("document.getElementById('ask-yes').click()")
        page.until(f"{STATE} === 'moving by hand'")
        page.until(f"{STATE} === 'idle'", 60.0)
        assert abs(place(page)[[0, 2]] - (0.2, 0.9)).max() < 1e-4
        keep(page, "gone")
        page.run(f"{SEND}({json.dumps([['part.gcode', GCODE], ['job.toml', JOB]])})")
        page.until("document.querySelector('#jobs').textContent.includes('check: ')", 300.0)
        keep(page, "checked")
        assert "check: yes" in page.run("document.querySelector('#jobs').textContent")
        load(page, "triangle")
        home(page, "")  # by the lengths that it has kept
        order(page, "start", "moving to the path", "printing", confirm=True)
        page.until(f"{STATE} === 'printing'", 120.0)
        drawn = page.run("operate.view.drawn")
        page.until(f"operate.view.drawn > {drawn} + 20")
        keep(page, "printing")
        page.until("document.getElementById('runs').textContent.includes('finished')", 120.0)
        keep(page, "printed")
        assert page.complaints() == []
