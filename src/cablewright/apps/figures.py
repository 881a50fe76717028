"""Figures of results as text: values with units, and tables; the same for terminal and reports."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from typing import Any, NamedTuple

from cablewright.foundation.results import Figure, Result, plain
from cablewright.foundation.units import unit_size

NONE = "-"
WIDE = 8  # parts beyond which things stand in columns beside each other, not in rows
FAR_BELOW = 1e-3  # of the largest of a column: what is smaller may be shown as 0


class Sheet(NamedTuple):
    """A table of figures: heads, rows of texts, which columns are numbers, whether the first rows are the best."""

    title: str
    head: tuple[str, ...]
    rows: list[tuple[str, ...]]
    numeric: tuple[bool, ...]
    ranked: bool = False


def summary(result: Result, *without: str) -> list[tuple[str, str]]:
    """Return labels and values of a result's main figures, in their order, but not those of the keys *without*."""
    shown = (each for each in result.figures if _is_plain(each) and each.key not in without)
    return [(each.label, text(each, each.of(result))) for each in shown]


def pairs(figures: Iterable[Figure], *of: object) -> list[tuple[str, ...]]:
    """Return the label of each figure, with its value for each of *of*."""
    return [(each.label, *(text(each, each.of(one)) for one in of)) for each in figures]


def sheets(result: Result) -> Iterator[Sheet]:
    """Return the tables of a result: the figures along its lines or another dimension, and those with parts."""
    return (sheet for sheet in _sheets(result.figures, result) if sheet.rows)


def _sheets(figures: Sequence[Figure], of: object) -> Iterator[Sheet]:
    seen = set()
    for each in figures:
        if each.along and not each.detail and each.along not in seen:
            seen.add(each.along)
            yield _along_sheet(figures, of, each.along)
        elif each.parts and not each.along and not each.detail and (value := each.of(of)) is not None:
            yield from _part_sheets(each, value)


def along_sheet(result: Result, along: str) -> Sheet:
    """Return the table of figures that have a value along the same lines or other dimension."""
    return _along_sheet(result.figures, result, along)


def _along_sheet(figures: Iterable[Figure], of: object, along: str) -> Sheet:
    """Columns of values; of figures with parts a row for each, or where there are many parts a column for each."""
    beside = [each for each in figures if each.along == along and not each.detail]
    parts = [part for part in beside[0].parts if not part.detail]
    if len(parts) > WIDE:
        return _side_by_side(parts, {each.label: each.of(of) for each in beside})
    if parts:
        return _by_name(along, parts, {each.label: each.of(of) for each in beside})
    found = columns("", [(each, each.of(of)) for each in beside])
    return found if len(found.head) > 1 else found._replace(rows=[])  # names alone are no table


def columns(title: str, given: Iterable[tuple[Figure, Any]]) -> Sheet:
    """Return a table of figures with a sequence of values each; figures without any value are left out."""
    listed = [(figure, values.values() if isinstance(values, Mapping) else values) for figure, values in given]
    kept = [(figure, list(values)) for figure, values in listed if values is not None]
    kept = [(figure, values) for figure, values in kept if any(not _is_missing(value) for value in values)]
    heads, made = [], []
    for figure, values in kept:
        factor, unit = scale(figure, values)
        heads.append(f"{figure.label}, {unit}" if unit else figure.label)
        together = figure.unit != "SI"  # else values of several dimensions, each with decimals of its own
        made.append([_joined(value, factor, figure, values if together else [value]) for value in values])
    numeric = tuple(bool(_numbers(values)) for _, values in kept)
    return Sheet(title, tuple(heads), list(zip(*made, strict=True)), numeric)


def table(title: str, figures: Iterable[Figure], rows: Iterable[object]) -> Sheet:
    """Return a table with one row for each of *rows*, whose columns are *figures*."""
    every = list(rows)
    return columns(title, [pair for each in figures if not each.detail for pair in _columns_of(each, every)])


def _columns_of(figure: Figure, rows: Sequence[object]) -> list[tuple[Figure, list[Any]]]:
    """The column of a figure in a table, or where each row has one thing with parts, the columns of these."""
    values = [figure.of(row) for row in rows]
    if not figure.parts or any(isinstance(value, tuple | list) for value in values):
        return [(figure, values)]
    shown = (part for part in figure.parts if not part.detail)
    named = (replace(part, name=f"{part.label} {figure.label}") if part.unit else part for part in shown)
    return [(part, [None if value is None else part.of(value) for value in values]) for part in named]


def text(figure: Figure, value: Any) -> str:
    """Return the value of a figure as text with its unit; of parts each with its label."""
    if figure.parts and value is not None and not isinstance(value, tuple | list):
        return ", ".join(" ".join(pair) for pair in pairs(figure.parts, value))
    value = plain(value)
    if figure.sentences:
        return "\n".join(value or ()) or NONE
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {text(figure, each)}" for key, each in value.items()) or NONE
    if figure.unit == "m, rad" and isinstance(value, list) and not isinstance(value[0], list):
        place = f"{_joined(value[:3], 1.0, figure)} m"
        return place if len(value) == 3 else f"{place}, {_joined(value[3:], 1.0, figure)} rad"
    factor, unit = scale(figure, value if isinstance(value, list) else [value])
    return f"{_joined(value, factor, figure)} {unit}".rstrip() if not _is_missing(value) else NONE


def scale(figure: Figure, values: Sequence[Any]) -> tuple[float, str]:
    """Return the factor from SI to the unit in which *values* of a figure are shown, and that unit."""
    unit = figure.shown or _by_size(figure.unit, _numbers(values))
    if unit in ("", "1", "SI"):
        return 1.0, ""
    return (1.0 if unit == figure.unit else 1.0 / unit_size(unit)), unit


def part_sheet(figure: Figure, value: Any) -> Sheet:
    """Return the table of a figure with parts: of rows, of columns by key, of rows by name, or of one object."""
    shown = [part for part in figure.parts if not part.detail]
    if isinstance(value, tuple | list):
        return table(figure.label, shown, value)._replace(ranked=figure.ranked)
    if isinstance(value, Mapping) and not any(part.key in value for part in figure.parts):
        return _by_name(figure.label, shown, value)
    values = [(part, plain(part.of(value))) for part in shown]
    if isinstance(value, Mapping) and all(isinstance(each, list) for _, each in values):
        return columns(figure.label, values)
    return Sheet(figure.label, (), [(part.label, text(part, each)) for part, each in values], (False, False))


def _part_sheets(figure: Figure, value: Any) -> Iterator[Sheet]:
    """The tables of a figure with parts; of one thing, parts that have parts themselves are rows of a further table.

    Several such things by name are compared.
    """
    nested = [part for part in figure.parts if part.parts and not part.detail]
    if isinstance(value, tuple | list) or not nested:
        yield part_sheet(figure, value)
    elif isinstance(value, Mapping) and not any(part.key in value for part in figure.parts):
        yield from _compared(figure.parts, value)
    else:
        values = pairs(filter(_is_plain, figure.parts), value)
        yield Sheet(figure.label, (), values, (False, False))
        rows = {part.label: each for part in nested if not isinstance(each := part.of(value), tuple | list)}
        yield _by_name("" if values else figure.label, nested[0].parts, rows)
        for part in nested:
            if part.label not in rows:
                yield from _part_sheets(part, part.of(value))


def _by_name(title: str, parts: Iterable[Figure], rows: Mapping[str, Any]) -> Sheet:
    """A table with the name of each row in its first column; empty where no row has a value."""
    names = (Figure("name", "", "", name=" "), list(rows))
    shown = [(part, [part.of(row) for row in rows.values()]) for part in parts if not part.detail]
    found = columns(title, [names, *shown])
    return found if len(found.head) > 1 else found._replace(rows=[])


def _compared(figures: Sequence[Figure], named: Mapping[str, object]) -> Iterator[Sheet]:
    """Several things by name: a column of values for each, then their tables, with the name before each row."""
    values = pairs(filter(_is_plain, figures), *named.values())
    yield Sheet("", (" ", *named), values, (False, *(True for _ in named)))
    alike: dict[tuple[str, tuple[str, ...]], list[tuple[str, Sheet]]] = {}
    for name, of in named.items():
        for each in _sheets(figures, of):
            alike.setdefault((each.title, each.head), []).append((name, each))
    for (title, head), made in alike.items():
        longest = max(len(each.rows) for _, each in made)
        rows = [(name, *each.rows[k]) for k in range(longest) for name, each in made if k < len(each.rows)]
        yield Sheet(title, (" ", *head) if head else (), rows, (False, *made[0][1].numeric))


def _side_by_side(parts: Sequence[Figure], things: Mapping[str, Any]) -> Sheet:
    """A table of things with the same parts: one row for each part, one column for each thing."""
    rows = [(part.label, *(text(part, part.of(thing)) for thing in things.values())) for part in parts]
    return Sheet("", ("", *things), rows, (False, *(True for _ in things)))


def _is_plain(figure: Figure) -> bool:
    return not (figure.along or figure.parts or figure.detail)


def _is_missing(value: Any) -> bool:
    return value is None or (isinstance(value, float) and math.isnan(value))


def _numbers(values: Sequence[Any]) -> list[float]:
    """The finite numbers among *values*, and in lists among them."""
    found: list[float] = []
    for value in values:
        flat = plain(value)
        if isinstance(flat, Mapping):
            flat = list(flat.values())
        if isinstance(flat, list):
            found += _numbers(flat)
        elif isinstance(flat, int | float) and not isinstance(flat, bool):
            found.append(flat)
    return found


_STEPS = {
    "m": ((1.0, "mm"), (1e4, "m"), (math.inf, "km")),
    "N": ((1e4, "N"), (math.inf, "kN")),
    "Pa": ((1e3, "Pa"), (1e9, "MPa"), (math.inf, "GPa")),
    "rad": ((math.inf, "deg"),),
    "s": ((0.1, "ms"), (120.0, "s"), (7200.0, "min"), (math.inf, "h")),
}
"""Units that people read, each below a size in SI."""


def _by_size(unit: str, values: list[float]) -> str:
    largest = max(map(abs, values), default=math.inf)
    return next((name for below, name in _STEPS.get(unit, ()) if largest < below or below == math.inf), unit)


def _form(figure: Figure, values: list[float]) -> str:
    """The format that gives the largest of *values* the figure's significant digits, and one to those not far below."""
    if figure.unit == "SI":  # of several dimensions
        return f".{figure.digits}g"
    if all(float(value).is_integer() for value in values) and figure.unit in ("", "1"):
        return ".0f"
    sizes = [abs(value) for value in values if value]
    if not sizes:
        return ".0f"
    leading = math.floor(math.log10(max(sizes)))
    if not -4 <= leading <= 9:
        return ".1e"
    smallest = math.floor(math.log10(min(size for size in sizes if size > FAR_BELOW * max(sizes))))
    return f".{max(figure.digits - 1 - leading, -smallest, 0)}f"


def _joined(value: Any, factor: float, figure: Figure, among: Sequence[Any] | None = None) -> str:
    """Numbers, or lists of them, all with as many decimals as the largest of them, or *among* others, needs."""
    others = [each * factor for each in _numbers([value] if among is None else among)]
    return _cell(value, factor, _form(figure, others), figure.outward)


def _cell(value: Any, factor: float, form: str, outward: int) -> str:
    value = plain(value)
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_cell(each, factor, form, outward)}" for key, each in value.items()) or NONE
    if isinstance(value, list):
        nested = any(isinstance(each, list) for each in value)
        return ("; " if nested else ", ").join(_cell(each, factor, form, outward) for each in value) or NONE
    if _is_missing(value):
        return NONE
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        if form.endswith("g"):
            return format(value * factor, form)
        return format(float(_rounded(Decimal(value * factor), form, outward)) + 0.0, form)  # no minus before a zero
    return str(value)


def _rounded(value: Decimal, form: str, outward: int) -> Decimal:
    """To the digits of a format: to the nearest, or up or down where *outward* is 1 or -1."""
    how = {1: ROUND_CEILING, -1: ROUND_FLOOR, 0: ROUND_HALF_EVEN}[outward]
    digits = int(form[1:-1])
    last = value.adjusted() - digits if form.endswith("e") else -digits
    return value.quantize(Decimal(1).scaleb(last), rounding=how, context=Context(prec=400))
