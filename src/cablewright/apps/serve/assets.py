"""Static files of the page, read once: no other file can be requested."""

from __future__ import annotations

from functools import cache
from importlib import resources
from types import MappingProxyType
from typing import Final

from starlette.responses import Response

_PAGE, _VIEWER = "cablewright.apps.serve", "cablewright.apps.web"
_HTML, _SCRIPT, _STYLE = "text/html; charset=utf-8", "text/javascript; charset=utf-8", "text/css; charset=utf-8"

_SCRIPTS: Final = (
    "main", "texts", "words", "link", "state", "next", "lines", "orders", "questions", "printing", "jog", "plan",
    "chart", "view", "camera", "console", "first", "winches", "jobs", "runs", "slicers", "enter",
    "calibrate",
)  # fmt: skip
ASSETS: Final = MappingProxyType(
    {f"{name}.js": (_PAGE, "page", _SCRIPT) for name in _SCRIPTS}
    | {
        "operate.css": (_PAGE, "page", _STYLE),
        "icon.svg": (_PAGE, "page", "image/svg+xml"),
        "viewer.js": (_VIEWER, "viewer", _SCRIPT),
        "viewer.css": (_VIEWER, "viewer", _STYLE),
    }
)
"""Package, folder and kind of each file, by its name."""

_PAGES: Final = ("index.html", "enter.html", "stop.html")


@cache
def _content(name: str) -> tuple[bytes, str]:
    package, folder, kind = (_PAGE, "page", _HTML) if name in _PAGES else ASSETS[name]
    return resources.files(package).joinpath(folder, name).read_bytes(), kind


def asset(name: str, status: int = 200) -> Response:
    """Return the HTTP response with a static file of the page."""
    content, kind = _content(name)
    return Response(content, status, media_type=kind)
