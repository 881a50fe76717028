"""Actions on the operator's page that prepare a test."""

from __future__ import annotations

import time
from contextlib import suppress

from browser import PATIENCE, Page

STATE = "document.getElementById('state').textContent"


def order(page: Page, kind: str, *states: str, confirm: bool = False) -> None:
    """Click an order until the machine is in one of *states*: a server that hung rejects orders."""
    end, there = time.monotonic() + PATIENCE, f"{list(states)}.includes({STATE})"
    while not page.run(there):
        assert time.monotonic() < end, page.run("document.getElementById('answer').textContent")
        page.run(f"operate.orders.buttons[{kind!r}].click()")
        if confirm:
            page.run("document.getElementById('ask-yes').click()")
        with suppress(TimeoutError):
            page.until(there, 10.0)


def take(page: Page) -> None:
    """Take control where this page has not, or has lost it by silence."""
    if not page.run("operate.orders.mine"):
        page.until("!document.getElementById('take').disabled")
        page.run("document.getElementById('take').click()")
    page.until("operate.orders.mine")


def enable(page: Page) -> None:
    """Take control and make the machine ready to move."""
    take(page)
    for kind, then in (("reset", "off"), ("enable", "idle")):
        if page.run(f"!operate.orders.buttons[{kind!r}].disabled"):
            order(page, kind, then)
    page.until("operate.orders.control.known")


def load(page: Page, name: str) -> None:
    """Load the only job, of that *name*, until it is drawn."""
    end, there = time.monotonic() + 2.0 * PATIENCE, f"operate.state.sitting.job?.name === {name!r}"
    while not page.run(there):
        assert time.monotonic() < end, page.run("document.getElementById('answer').textContent")
        take(page)
        page.run("[...document.querySelectorAll('#jobs button')].find((b) => b.textContent === 'Load').click()")
        with suppress(TimeoutError):
            page.until(there, 30.0)
    page.until("operate.view.view?.path")
