"""The page of any result: its verdict, its figures, its tables, its picture, and the robot to turn where it has one.

Commands whose answer is one result write it with ``--report``.
"""

from __future__ import annotations

from collections.abc import Iterator

from cablewright.apps import style
from cablewright.apps.figures import sheets, summary
from cablewright.apps.pictures import gallery
from cablewright.apps.report.figures import sheet_table
from cablewright.apps.report.page import Html, cards, element, notice, page, picture, section
from cablewright.apps.report.provenance import list_of, program
from cablewright.apps.report.terms import with_terms
from cablewright.apps.report.viewer import script, stylesheet, view
from cablewright.apps.web.result_scene import scene_of
from cablewright.results import Pictured, Result

_LONG = 60  # letters of a value that makes no card


def result_page(found: Pictured, title: str, *, drawn: bool = True) -> str:
    """Return the page as HTML; *drawn*: whether there is something to draw. The same result gives the same text."""
    png = None
    if drawn:
        with style.drawing():
            png = style.png(gallery.draw(found))
    body = with_terms(_body(found, title, png))
    return page(title, body, script(), stylesheet())


def _body(found: Pictured, title: str, png: bytes | None) -> Iterator[Html]:
    yield element("h1", title)
    yield _verdict(found)
    rows = summary(found, "status")
    yield cards((*row, "") for row in rows if len(row[1]) <= _LONG and "\n" not in row[1])
    yield from map(notice, getattr(found, "notes", ()))
    for label, value in rows:
        if len(value) > _LONG or "\n" in value:
            yield section(label, list_of(value.split("\n")))
    if png is not None:
        yield picture(png, f"{title}: what the figures say", "")
    scene = scene_of(found, title)
    if scene is not None:
        yield section("In three dimensions", view(scene))
    for sheet in sheets(found):
        title = sheet.title or f"by {sheet.head[0].partition(',')[0]}"
        yield section(title[:1].upper() + title[1:], sheet_table(sheet))
    yield element("p", program(), class_="soft")


def _verdict(found: Result) -> Html:
    status = str(getattr(found, "status", "ok"))
    word, kind = ("Done", "yes") if not found.refusal else (status, "no")
    words = found.refusal[:1].upper() + found.refusal[1:] + "." if found.refusal else f"Status: {status}."
    return element("div", element("strong", word), element("p", words), class_=f"verdict {kind}", role="status")
