"""Results of one solve or of a batch, whose arrays then have a leading axis."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels.layout import Packed

_Batch = TypeVar("_Batch", bound="Rows")


class Rows:
    """Base of results: a frozen dataclass of arrays, of a single result, or with a leading axis of a batch.

    A batch has a length and iterates over its rows. It is indexed like an array: an integer gives a single result; a
    slice, mask or list a smaller batch; ``single[None]`` is a batch of one.
    """

    SINGLE: ClassVar[tuple[str, int]] = ("code", 0)
    """A field, and its number of axes in a single result."""
    __match_args__: ClassVar[tuple[str, ...]]

    @property
    def single(self) -> bool:
        """Whether the result is a single one, not a batch."""
        name, axes = self.SINGLE
        return bool(getattr(self, name).ndim == axes)

    def __len__(self) -> int:
        """The number of rows of a batch. Raises `TypeError` for a single result."""
        if self.single:
            raise TypeError(f"a single {type(self).__name__} has no length and no truth value")
        return len(getattr(self, self.SINGLE[0]))

    def __iter__(self) -> Iterator[Self]:
        """Iterate over the rows of a batch."""
        return (self[row] for row in range(len(self)))

    def __getitem__(self, index: Any) -> Self:
        """A row of a batch, or a smaller batch."""
        return type(self)(*(_taken(getattr(self, name), index) for name in self.__match_args__))

    def __repr__(self) -> str:
        """The names and shapes of the arrays, because their numbers would fill screens."""
        arrays = ((name, getattr(self, name)) for name in self.__match_args__)
        shapes = (f"{name} {array.shape}" for name, array in arrays if array is not None)
        return f"{type(self).__name__}({', '.join(shapes)})"


def scalar(values: NDArray[Any]) -> Any:
    """Return *values*, as a Python number if they are of a single result."""
    return values.item() if values.ndim == 0 else values


def by_row(meaning: Callable[[int], Any], codes: NDArray[np.int64]) -> Any:
    """Return the *meaning* of a status code, or of a batch the tuple (N) of meanings."""
    return meaning(int(codes)) if codes.ndim == 0 else tuple(map(meaning, codes.tolist()))


def rows_of(packed: Packed, index: Any) -> Packed:
    """Return some rows of a batch with a leading axis; a batch with one row for all is returned as it is."""
    if len(packed.lines) == 1:
        return packed
    lines, platform = packed.lines[index], packed.platform[index]
    if platform.ndim == 1:
        lines, platform = lines[None], platform[None]
    return packed._replace(lines=np.ascontiguousarray(lines), platform=np.ascontiguousarray(platform))


def joined(first: _Batch, second: _Batch) -> _Batch:
    """Return the rows of two batches with the same fields in one; a field that is no array is that of the first."""
    pairs = ((getattr(first, name), getattr(second, name)) for name in first.__match_args__)
    return type(first)(*(_put_together(one, other) for one, other in pairs))


def _put_together(one: Any, other: Any) -> Any:
    """Return the rows of a field of two batches."""
    if isinstance(one, Rows):
        return joined(one, other)
    if isinstance(one, Packed):
        if len(one.lines) == 1 and np.array_equal(one.lines, other.lines):
            return one
        return one._replace(
            lines=np.concatenate([one.lines, other.lines]), platform=np.concatenate([one.platform, other.platform])
        )
    return np.concatenate([one, other]) if isinstance(one, np.ndarray) else one


def _taken(value: Any, index: Any) -> Any:
    """Return rows of a field; a field that is no array belongs to all rows."""
    if isinstance(value, Packed):
        return rows_of(value, index)
    if isinstance(value, Rows):
        return value[index]
    return np.asarray(value)[index] if isinstance(value, np.ndarray | np.generic) else value
