"""A rigid platform on the operator's page: enabled, moved by hand, and a layer printed."""

from __future__ import annotations

import importlib.resources
import json
from collections.abc import Iterator

import numpy as np
import pytest

pytest.importorskip("starlette")

from browser import browser, executable
from operator_page import STATE, enable, load, order
from served import Served, client, served

pytestmark = pytest.mark.clock

RING = """
schema = 1
name = "ring"
origin = ["0.2 m", "0.1 m", "0 m"]
[helix]
radius = "60 mm"
layers = 1
layer_height = "20 mm"
first_height = "2 m"
[bead]
width = "60 mm"
height = "20 mm"
[motion]
print_speed = "0.2 m/s"
travel_speed = "0.2 m/s"
acceleration = "0.3 m/s^2"
"""
SEND = """((text) => { const t = new DataTransfer(); t.items.add(new File([text], 'ring.toml'));
  document.getElementById('files').files = t.files; document.getElementById('upload').requestSubmit(); })"""


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder = tmp_path_factory.mktemp("served")
    machine = folder / "machine.toml"
    text = (importlib.resources.files("cablewright.machine") / "library" / "cogiro.toml").read_text("utf-8")
    machine.write_text(
        "\n".join(line for line in text.splitlines() if not line.startswith("tour"))
    )  # a minute and a half
    with served(folder / "out", "cogiro", "--machine", str(machine), "--seed", "1") as made:
        yield made


@pytest.mark.slow  # as in live/test_bodies_on_drives.py, without a page
def test_a_body_is_moved_by_its_nozzle_at_the_rotation_that_it_has(server: Served) -> None:
    with client(server) as page:
        page.ready()
        assert page.sitting["procedures"] == []
        begin = page.state["platform"]
        page.hold((0.1, 0.0, 0.0), 1, lambda state: state["platform"]["position"][0] > begin["position"][0] + 0.05)
        page.until(lambda state: state["state"] == "idle")
        goal = [0.0, 0.2, 2.1]
        assert page.order("go to", position=goal) == ""
        page.until(lambda state: state["state"] == "manual" or page.during(0.05))
        while page.state["state"] == "manual":
            page.during(0.2)
        page.during(1.0)
        assert page.state["state"] == "idle", page.state
        found = page.state["platform"]
        assert np.allclose(found["nozzle"], goal, atol=5e-4)  # the estimate goes on
        assert np.abs(np.subtract(found["rotation"], begin["rotation"])).max() < 3e-3
        over = page.order("go to", position=[0.0, 0.2, 7.0])
        assert "z = 7 m is outside 0 to 5.5 m" in over


@pytest.mark.slow
@pytest.mark.skipif(executable() is None, reason="no chromium is installed: see README.md")
def test_a_layer_is_printed_from_the_page(server: Served) -> None:
    with browser() as chromium, chromium.page(server.address, 1280) as page:
        page.until("location.pathname === '/' && window.operate && operate.view.view")
        enable(page)
        page.until("document.getElementById('rotation').textContent.endsWith('\\u00b0')")
        assert page.run("document.getElementById('nozzle-fact').hidden") is False
        assert page.run("[...document.querySelectorAll('#lines tr')].length") == 8
        page.run(f"{SEND}({json.dumps(RING)})")
        page.until("document.querySelector('#jobs').textContent.includes('check: ')", 300.0)
        assert "check: yes" in page.run("document.querySelector('#jobs').textContent")
        enable(page)
        load(page, "ring")
        enable(page)
        order(page, "start", "moving to the path", "printing", confirm=True)
        page.until(f"{STATE} === 'printing'", 120.0)
        drawn = page.run("operate.view.drawn")
        page.until(f"operate.view.drawn > {drawn} + 3")
        assert page.run("operate.view.view.poses.shape[1]") == 6
        page.until("document.getElementById('runs').textContent.includes('finished')", 120.0)
        page.until("document.querySelector('#runs a')", 300.0)  # its report
        assert page.complaints() == []
