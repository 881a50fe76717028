"""The figures of a result, declared once with unit and meaning for JSON, terminal, reports, pictures and docs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, is_dataclass, replace
from enum import Enum
from operator import attrgetter
from pathlib import Path
from types import MethodType
from typing import TYPE_CHECKING, Any, ClassVar

from cablewright.foundation.data_frames import frame_of, grid_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing
    from pandas import DataFrame
    from xarray import Dataset

_MOST_IN_LINE = 8  # numbers of a list that a result shows in its line


@dataclass(frozen=True)
class Figure:
    """One figure (named value) of a result, declared once for JSON, terminal, reports and the docs' tables.

    ``key`` is its name in JSON, ``unit`` its SI unit ("1" for a share, factor or count, "" for what is no quantity) and
    ``meaning`` one sentence. ``value`` says how it is read off the result: attributes joined by dots, methods without
    arguments among them, None as soon as one of them is; or a function; by default the attribute named ``key``.
    Results for which ``only`` is false do not have the figure.

    What people read: ``name`` where it is not the key; ``digits``, the significant ones; ``shown``, the unit, such as
    "mm" or "%", chosen by size where it is empty. A figure with ``detail`` is in JSON and docs only. Figures with the
    same ``along`` ("line") have one value for each and are columns of one table. ``parts`` are the figures of each row
    of a table, or of a part; with ``along`` too, of one beside others. Of a long table people see the first rows where
    it is ``ranked``. ``outward``: 1 or -1 rounds up or down what people read, for bounds that are proved.
    ``sentences``: a list of them, of which people read one a line.
    """

    key: str
    unit: str
    meaning: str
    value: str | Callable[[Any], Any] = ""
    name: str = ""
    digits: int = 4
    only: Callable[[Any], bool] | None = None
    shown: str = ""
    along: str = ""
    parts: tuple[Figure, ...] = ()
    detail: bool = False
    outward: int = 0
    ranked: bool = False
    sentences: bool = False

    def of_part(self, part: str) -> Figure:
        """Return the figure of a result that reads it from its attribute *part*."""
        inner, only = attrgetter(part), self.only
        value = self.value
        if isinstance(value, str):
            read: str | Callable[[Any], Any] = f"{part}.{value or self.key}"
        else:
            read = lambda of: None if (it := inner(of)) is None else value(it)  # noqa: E731
        return replace(self, value=read, only=None if only is None else lambda of: only(inner(of)))

    @property
    def label(self) -> str:
        """Label of the figure (a named number of a result) for people."""
        return self.name or self.key.replace("_", " ")

    def of(self, result: object) -> Any:
        """Return the figure's value of a *result*; of a mapping the value at ``key``."""
        if isinstance(result, Mapping):
            return result.get(self.key)
        if not isinstance(self.value, str):
            return self.value(result)
        found: Any = result
        for part in (self.value or self.key).split("."):
            if found is None:
                return None
            found = getattr(found, part)
            found = found() if isinstance(found, MethodType) else found
        return found

    def plain_of(self, result: object) -> Any:
        """Return the figure's value as in JSON."""
        value = self.of(result)
        if not self.parts or value is None or isinstance(value, Mapping | Result):
            return plain(value)
        if isinstance(value, tuple | list):
            return [figures_dict(self.parts, row) for row in value]
        return figures_dict(self.parts, value)


class Result:
    """Base of results: a frozen value that declares its figures. A dataclass that is one is made with ``repr=False``.

    ``html``: writes the tables of any of them. What stands above all ranks sets it, as pages are of the highest.
    """

    html: ClassVar[Callable[[Any], str]]
    FIGURES: ClassVar[tuple[Figure, ...]] = ()
    HEADLINES: ClassVar[tuple[str, ...]] = ()  # keys of those that stand in its repr
    ROWS: ClassVar[str] = ""  # the dimension of the table's rows, for a result whose figures have several dimensions

    @property
    def figures(self) -> tuple[Figure, ...]:
        """The figures that this result has, in the order of its declaration."""
        return tuple(each for each in self.FIGURES if each.only is None or each.only(self))

    def to_dict(self) -> dict[str, Any]:
        """Return the figures by their keys as in JSON: SI, lists, texts, None for unknown values."""
        return figures_dict(self.figures, self)

    def to_frame(self, along: str = "") -> DataFrame:
        """Return the table as a pandas data frame, in SI: a row for each row of a batch, line, mode or position.

        Columns are keys of figures; ``tensions.NAME`` where each row has one for each line. Other figures are in
        ``attrs``. *along*: ``line`` or ``mode``, of a single result that has both. Raises `EnvironmentFault` without
        pandas, the extra ``frames``.
        """
        return frame_of(self, along or self.ROWS)

    def to_xarray(self) -> Dataset:
        """Return the table over a grid of positions as an xarray data set along x, y and z, in m.

        Raises `InputError` where the places fill no grid, `EnvironmentFault` without the extra ``frames``.
        """
        return grid_of(self)

    @property
    def refusal(self) -> str:
        """Reason for a no, in a sentence; empty for a yes."""
        return ""

    def _repr_html_(self) -> str:
        """Return its tables, which a notebook shows."""
        return Result.html(self)

    def __repr__(self) -> str:
        """The headlines in one line."""
        parts = [f"{each.key}={_brief(each.of(self), each)}" for each in self.figures if each.key in self.HEADLINES]
        return f"{type(self).__name__}({', '.join(parts)})"


def figures_dict(figures: Iterable[Figure], of: object) -> dict[str, Any]:
    """Return the values of *figures* of the object *of*, by key, as in JSON."""
    return {each.key: each.plain_of(of) for each in figures}


class Pictured(Result):
    """A result with a picture.

    ``draw``: the function that draws it. The package for pictures sets it, since results may not import pictures.
    """

    draw: ClassVar[Callable[..., Drawing]]

    def plot(
        self,
        file: str | Path | None = None,
        *,
        width: float | str | None = None,
        style: str | Path | Mapping[str, Any] | None = None,
    ) -> Drawing:
        """Return the picture as a figure of matplotlib, and write it where a *file* is named: .png, .svg or .pdf.

        Its data are written beside it, as FILE.csv. *width*: ``one-column`` or ``two-column`` of a paper, or m; texts
        are then 7 points high. *style*: a style sheet of matplotlib, or settings by name, over those of cablewright.
        Raises `InputError` for another ending, width or setting, `EnvironmentFault` where a file cannot be written.
        """
        return Pictured.draw(self, file, width=width, style=style)


def plain(value: Any) -> Any:
    """Convert *value* to JSON: arrays to lists, numbers that are not finite to None, results to their figures."""
    if isinstance(value, Result):
        return value.to_dict()
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, str | bool | int | None):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, tuple | list):
        return [plain(each) for each in value]
    if isinstance(value, Path):
        return str(value)
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value))
    return plain(value.tolist())  # of NumPy: an array or a scalar


def _brief(value: Any, figure: Figure) -> str:
    """The value as a part of a line, with its unit."""
    value = plain(value)
    return _short(value, figure.digits) + (
        f" {figure.unit}" if value is not None and figure.unit not in ("", "1") else ""
    )


def _short(value: Any, digits: int) -> str:
    if isinstance(value, list):
        more = f", ... {len(value)} in all" if len(value) > _MOST_IN_LINE else ""
        return f"[{', '.join(_short(each, digits) for each in value[:_MOST_IN_LINE])}{more}]"
    return f"{value:.{digits}g}" if isinstance(value, float) else repr(value)
