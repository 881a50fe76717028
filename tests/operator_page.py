"""Actions on the operator's page that prepare a test."""

from __future__ import annotations

from browser import Page

STATE = "document.getElementById('state').textContent"


def enable(page: Page) -> None:
    """Take control where this page has not, or has lost it by silence, and make the machine ready to move."""
    if not page.run("operate.orders.mine"):
        page.until("!document.getElementById('take').disabled")
        page.run("document.getElementById('take').click()")
    page.until("operate.orders.mine")
    for kind, then in (("reset", "off"), ("enable", "idle")):
        if page.run(f"!operate.orders.buttons[{kind!r}].disabled"):
            page.run(f"operate.orders.buttons[{kind!r}].click()")
            page.until(f"{STATE} === {then!r}")
    page.until("operate.orders.control.known")
