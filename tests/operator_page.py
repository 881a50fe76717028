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


def enable(page: Page) -> None:
    """Take control where this page has not, or has lost it by silence, and make the machine ready to move."""
    if not page.run("operate.orders.mine"):
        page.until("!document.getElementById('take').disabled")
        page.run("document.getElementById('take').click()")
    page.until("operate.orders.mine")
    for kind, then in (("reset", "off"), ("enable", "idle")):
        if page.run(f"!operate.orders.buttons[{kind!r}].disabled"):
            order(page, kind, then)
    page.until("operate.orders.control.known")
