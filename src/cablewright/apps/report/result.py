"""Declared figures as cards and tables, and the page of any result, which commands write with ``--report``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from cablewright.apps import style
from cablewright.apps.dark_pictures import themed
from cablewright.apps.figures import Sheet, along_sheet, part_sheet, sheets, summary, text
from cablewright.apps.pictures import gallery
from cablewright.apps.report.document import document, verdict, view
from cablewright.apps.report.page import Html, Themed, cards, element, notice, picture, section, table
from cablewright.apps.report.provenance import list_of, program
from cablewright.apps.web.robot_scene import scene_of
from cablewright.foundation.results import Pictured, Result


def key_figures(
    found: Result, keys: Iterable[str], notes: Mapping[str, str] | None = None
) -> Iterator[tuple[str, str, str]]:
    """Return label, value and note of the figures with these *keys*, for `page.cards`."""
    by_key = {each.key: each for each in found.figures}
    for key in keys:
        figure = by_key[key]
        yield figure.label, text(figure, figure.of(found)), (notes or {}).get(key, "")


def part_table(found: Result, key: str) -> Html:
    """Return the HTML table of a figure that has parts."""
    figure = next(each for each in found.figures if each.key == key)
    return sheet_table(part_sheet(figure, figure.of(found)))


def along_table(found: Result, along: str) -> Html:
    """Return the HTML table of figures that have values along the same dimension."""
    return sheet_table(along_sheet(found, along))


def sheet_table(sheet: Sheet) -> Html:
    """Return the HTML of a table of figures; numbers flush right."""
    return table(sheet.head, sheet.rows, numbers=[k for k, number in enumerate(sheet.numeric) if number])


_LONG = 60  # letters of a value that makes no card
_INPUTS = (
    "robot",
    "job",
    "method",
    "objectives",
    "constraints",
    "criterion",
    "point",
    "box",
    "plant",
    "estimator",
    "log",
)


def result_page(found: Pictured, title: str, *, drawn: bool = True) -> str:
    """Return the page of a result as HTML; *drawn*: whether there is something to draw.

    The same result gives the same text.
    """
    pictured = None
    if drawn:
        with style.drawing():
            pictured = themed(gallery.draw(found))
    return document(title, _body(found, title, pictured))


def _body(found: Pictured, title: str, drawn: Themed | None) -> Iterator[Html]:
    yield element("h1", title)
    yield _verdict(found)
    rows = summary(found, "status", "answer", *_INPUTS)
    yield cards((*row, "") for row in rows if len(row[1]) <= _LONG and "\n" not in row[1])
    yield from map(notice, getattr(found, "notes", ()))
    for label, value in rows:
        if len(value) > _LONG or "\n" in value:
            yield section(label, list_of(value.split("\n")))
    if drawn is not None:
        yield picture(drawn, f"{title}: meaning of the figures", "")
    scene = scene_of(found, title)
    if scene is not None:
        yield section("In three dimensions", view(scene))
    for sheet in sheets(found):
        title = sheet.title or f"by {sheet.head[0].partition(',')[0]}"
        yield section(title[:1].upper() + title[1:], sheet_table(sheet))
    inputs = [each[:2] for each in key_figures(found, [each.key for each in found.figures if each.key in _INPUTS])]
    if inputs:
        yield section("Inputs", table(["setting", "value"], inputs))
    yield element("p", program(), class_="soft")


def _verdict(found: Result) -> Html:
    status = str(getattr(found, "status", "ok"))
    word, kind = ("Done", "yes") if not found.refusal else (status, "no")
    words = found.refusal or getattr(found, "answer", "") or ", ".join(" ".join(each) for each in _headlines(found))
    return verdict(word, f"{words[:1].upper()}{words[1:]}.", kind=kind)


def _headlines(found: Result) -> Iterator[tuple[str, str]]:
    """Label and value of the figures that answer the question of a result."""
    keys = [each.key for each in found.figures if each.key in found.HEADLINES and each.key not in ("status", "robot")]
    return (each[:2] for each in key_figures(found, keys))
