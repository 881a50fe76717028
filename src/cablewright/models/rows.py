"""One answer, or a batch of answers: what results whose arrays may have a leading axis share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels.layout import Packed


class Rows:
    """A frozen dataclass of arrays: those of one answer, or with a leading axis those of a batch.

    A batch has a length and yields its rows. Its indices are those of an array: an integer gives one answer; a slice,
    mask or list a smaller batch; and ``one[None]`` is a batch of one.
    """

    SINGLE: ClassVar[tuple[str, int]] = ("code", 0)
    """A field, and how many axes it has in one answer."""
    __match_args__: ClassVar[tuple[str, ...]]

    @property
    def single(self) -> bool:
        """Whether this is one answer, and no batch."""
        name, axes = self.SINGLE
        return bool(getattr(self, name).ndim == axes)

    def __len__(self) -> int:
        """How many rows a batch has. Raises `TypeError` for one answer."""
        if self.single:
            raise TypeError(f"a single {type(self).__name__} has no length, and is neither true nor false")
        return len(getattr(self, self.SINGLE[0]))

    def __iter__(self) -> Iterator[Self]:
        """Each row of a batch."""
        return (self[row] for row in range(len(self)))

    def __getitem__(self, index: Any) -> Self:
        """One row of a batch, or a smaller batch."""
        return type(self)(*(_taken(getattr(self, name), index) for name in self.__match_args__))

    def __repr__(self) -> str:
        """Which arrays there are, and of which shape: their numbers fill screens."""
        arrays = (f"{name} {getattr(self, name).shape}" for name in self.__match_args__)
        return f"{type(self).__name__}({', '.join(arrays)})"


def scalar(values: NDArray[Any]) -> Any:
    """*values*, and where they are of one answer a plain Python number."""
    return values.item() if values.ndim == 0 else values


def by_row(meaning: Callable[[int], Any], codes: NDArray[np.int64]) -> Any:
    """What a code means, or of a batch a tuple (N) of what each does."""
    return meaning(int(codes)) if codes.ndim == 0 else tuple(map(meaning, codes.tolist()))


def rows_of(packed: Packed, index: Any) -> Packed:
    """Some rows of a batch; a single one keeps its leading axis, and one for all stays that."""
    if len(packed.lines) == 1:
        return packed
    lines, platform = packed.lines[index], packed.platform[index]
    if platform.ndim == 1:
        lines, platform = lines[None], platform[None]
    return Packed(packed.freedoms, np.ascontiguousarray(lines), np.ascontiguousarray(platform))


def _taken(value: Any, index: Any) -> Any:
    """Rows of a field; what is no array is of all rows."""
    if isinstance(value, Packed):
        return rows_of(value, index)
    return np.asarray(value)[index] if isinstance(value, np.ndarray | np.generic) else value
