"""The viewer in a page: a scene as data, a picture of it for paper and old browsers, and the program that draws it."""

from __future__ import annotations

from importlib import resources
from typing import Final

from cablewright.apps.report.page import Html, element
from cablewright.apps.web.scene import SceneDescription
from cablewright.apps.web.still import svg

HELP: Final = (
    "Drag to turn, with shift or the right button to move; click it and roll the wheel to zoom; hover over a line or "
    "the path for figures. With fingers: one sideways turns, two move and zoom. Keys: arrows turn, with shift they "
    "move; + and \N{MINUS SIGN} zoom; 0 all; 1, 2, 3 front, side, top; space plays; comma and full stop step; [ and ] "
    "change the layer."
)


def view(scene: SceneDescription, name: str = "scene") -> Html:
    """Return the view of a scene; *name*: of its element, once in a page."""
    data = Html(f'<script type="application/json" id="{name}">{scene.as_json()}</script>')
    inner = [element("div", Html(svg(scene)), class_="stage")]
    inner += [element("p", note, class_="soft") for note in scene.notes]
    inner.append(element("details", element("summary", "How to use the view"), element("p", HELP), class_="help"))
    return element("div", data, *inner, class_="viewer", data_scene=name)


def script() -> str:
    """Return the program that draws all views of a page."""
    return _bundled("viewer.js")


def stylesheet() -> str:
    """Return the look of views."""
    return _bundled("viewer.css")


def _bundled(name: str) -> str:
    return resources.files("cablewright.apps.web").joinpath("viewer", name).read_text(encoding="utf-8")
