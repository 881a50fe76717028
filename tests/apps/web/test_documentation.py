"""The built documentation in Chromium: search finds, galleries show, and no page asks for anything outside.

`make docs` builds it.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

from browser import Browser, browser, executable

SITE = Path(__file__).resolve().parents[3] / "site"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(executable() is None, reason="needs Chromium"),
    pytest.mark.skipif(not (SITE / "index.html").is_file(), reason="needs `make docs`"),
]


class Quiet(SimpleHTTPRequestHandler):
    """Serves files without a word."""

    def log_message(self, *_arguments: Any) -> None:
        """Say nothing."""


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(SITE))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as found:
        yield found


@pytest.mark.parametrize("name", ["", "library/", "papers/figures/", "problems/", "reference/", "researcher/"])
def test_a_page_asks_for_nothing_outside_and_its_pictures_are_there(name: str, address: str, chromium: Browser) -> None:
    with chromium.page(f"{address}/{name}", 1200) as page:
        broken = "[...document.images].filter((each) => each.complete && !each.naturalWidth).map((each) => each.src)"
        assert page.run(broken) == []
        if name == "papers/figures/":
            assert page.run("document.querySelectorAll('article img').length") == 19
        assert [each for each in page.requests() if not each.startswith(address)] == []
        assert page.complaints() == []


def test_search_finds_a_page(address: str, chromium: Browser) -> None:
    with chromium.page(f"{address}/", 1200) as page:
        page.run("document.querySelector('.md-search__input').focus()")
        page.run(
            "(() => { const field = document.querySelector('.md-search__input'); field.value = 'compare_loops';"
            " field.dispatchEvent(new Event('keyup', {bubbles: true}));"
            " field.dispatchEvent(new Event('input', {bubbles: true})); })()"
        )
        page.until("document.querySelectorAll('.md-search-result__link').length > 0")
        links = page.run("[...document.querySelectorAll('.md-search-result__link')].map((each) => each.href)")
        assert any("reference" in each or "extending" in each for each in links), links
        assert [each for each in page.requests() if not each.startswith(address)] == []
