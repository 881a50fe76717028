"""Declared figures as parts of a page: cards and tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from cablewright.apps.figures import Sheet, along_sheet, part_sheet, text
from cablewright.apps.report.page import Html, table
from cablewright.results import Result


def key_figures(
    found: Result, keys: Iterable[str], notes: Mapping[str, str] | None = None
) -> Iterator[tuple[str, str, str]]:
    """Label, value and note of the figures with these *keys*, for `page.cards`."""
    by_key = {each.key: each for each in found.figures}
    for key in keys:
        figure = by_key[key]
        yield figure.label, text(figure, figure.of(found)), (notes or {}).get(key, "")


def part_table(found: Result, key: str) -> Html:
    """The table of a figure that has parts."""
    figure = next(each for each in found.figures if each.key == key)
    return sheet_table(part_sheet(figure, figure.of(found)))


def along_table(found: Result, along: str) -> Html:
    """The table of the figures that run along the same things."""
    return sheet_table(along_sheet(found, along))


def sheet_table(sheet: Sheet) -> Html:
    """A table of figures; numbers flush right."""
    return table(sheet.head, sheet.rows, numbers=[k for k, number in enumerate(sheet.numeric) if number])
