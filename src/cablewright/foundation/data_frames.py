"""Results as data frames of pandas and as grids of xarray: the extra `frames`."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from itertools import chain
from typing import TYPE_CHECKING, Any

from cablewright.foundation.errors import EnvironmentFault, InputError, UnknownName

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

COORDINATES = ("x", "y", "z", "rx", "ry", "rz")
"""Names of the coordinates of a pose, m and rad."""

_SPACE = COORDINATES[:3]


def frame_of(result: Any, along: str = "") -> DataFrame:
    """Return the table of a result as a data frame; its other figures, by key, are in ``attrs``.

    *along*: the dimension of the rows, for a result whose figures have several dimensions. Raises `UnknownName` for
    another, `EnvironmentFault` without pandas.
    """
    pandas = _module("pandas")
    values = result.to_dict()
    columns = columns_of(result, along)
    found: DataFrame = pandas.DataFrame(columns)
    used = {name.partition(".")[0] for name in columns}
    found.attrs = {key: value for key, value in values.items() if key not in used and not isinstance(value, list)}
    return found


def columns_of(result: Any, along: str = "") -> dict[str, Any]:
    """Return the columns of a result's table by name. Raises `UnknownName` as `frame_of` does."""
    declared = getattr(result, "columns", None)
    return dict(_of_rows(result, result.to_dict(), along) if declared is None else declared)


def grid_of(result: Any) -> Dataset:
    """Return the table of a result over places that fill a grid along x, y and z as a data set.

    An axis with one coordinate only is no dimension. Raises `InputError` where the places fill no grid,
    `EnvironmentFault` without pandas or xarray.
    """
    table = frame_of(result)
    _module("xarray")
    if not {*_SPACE} <= {*table.columns}:
        raise InputError(f"{type(result).__name__}: it has no positions; only a batch of poses or a grid has")
    axes = [name for name in _SPACE if table[name].nunique() > 1]
    count = 1
    for name in axes:
        count *= table[name].nunique()
    if not axes or count != len(table) or table.duplicated(axes).any():
        raise InputError(f"{type(result).__name__}: its {len(table)} places fill no grid along x, y and z")
    found: Dataset = table.set_index(axes).to_xarray()
    return found.assign_attrs(table.attrs)


def _of_rows(result: Any, values: Mapping[str, Any], along: str) -> Mapping[str, Any]:
    """Return columns by name: of a batch one row each, else of the first figures along something, else one row."""
    named = {each.along: values[each.key] for each in reversed(result.figures) if each.along and not each.unit}
    if getattr(result, "single", True) is False:
        poses: Any = values.get("pose") or getattr(result, "poses", ())
        count = len(result)
        rows = {"pose": [list(map(float, pose)) for pose in poses]} | {k: v for k, v in values.items() if k != "poses"}
        listed = {key: value for key, value in rows.items() if isinstance(value, list) and len(value) == count}
        return dict(chain.from_iterable(_spread(key, value, named) for key, value in listed.items()))
    groups = [each.along for each in result.figures if each.along and isinstance(values[each.key], list)]
    if groups or along:
        if along and along not in groups:
            raise UnknownName("kind of row", along, groups)
        own = (each.key for each in result.figures if each.along == (along or groups[0]))
        return dict(chain.from_iterable(_spread(key, values[key], named) for key in own if values[key] is not None))
    tables = [values[each.key] for each in result.figures if each.parts and isinstance(values[each.key], list)]
    if tables:
        return {key: [row[key] for row in tables[0]] for key in tables[0][0]} if tables[0] else {}
    return {key: [value] for key, value in values.items() if not isinstance(value, list | dict)}


def _spread(key: str, rows: list[Any], named: Mapping[str, list[str]]) -> list[tuple[str, list[Any]]]:
    """Return the columns of a figure: itself; of lists one a coordinate or a line; none of matrices."""
    widths = {len(row) if isinstance(row, list) else 0 for row in rows}
    if widths == {0}:
        return [(key, rows)]
    if len(widths) > 1 or any(isinstance(each, list) for row in rows for each in row):
        return []
    (width,) = widths
    if key in ("pose", "nozzle", "place"):
        prefix = "" if key == "pose" else f"{key}."
        return [(prefix + name, [row[k] for row in rows]) for k, name in enumerate(COORDINATES[:width])]
    names = next((each for each in named.values() if len(each) == width and isinstance(each[0], str)), range(width))
    return [(f"{key}.{name}", [row[k] for row in rows]) for k, name in enumerate(names)]


def _module(name: str) -> Any:
    """Return a module of the extra. Raises `EnvironmentFault` where it is not installed."""
    try:
        return import_module(name)
    except ImportError:
        raise EnvironmentFault(f"{name} is not installed: pip install 'cablewright[frames]'") from None
