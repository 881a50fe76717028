"""A number along the rows of a table that is constant between its changes: a layer, a line type, a switch."""

from __future__ import annotations

from array import array

import numpy as np

from cablewright.foundation.arrays import Array


class Changes:
    """A number along the rows of a table, stored by the rows at which it changes; never more entries than rows."""

    def __init__(self) -> None:
        """Start without a change."""
        self.rows = array("q")
        self.values = array("d")

    def __len__(self) -> int:
        """The number of changes."""
        return len(self.rows)

    @property
    def last(self) -> float | None:
        """The number since its last change; None before the first one."""
        return self.values[-1] if self.values else None

    def set(self, row: int, value: float) -> None:
        """Let *value* hold from *row* on, which is no earlier than the last change."""
        if self.rows and self.rows[-1] == row:
            self.values[-1] = value
        elif value != self.last:
            self.rows.append(row)
            self.values.append(value)

    def spread(self, count: int, before: float) -> Array:
        """Return the number of each of *count* rows, (count,); *before* holds until the first change."""
        ends = np.concatenate([[0], np.array(self.rows, dtype=np.int64), [count]])
        return np.repeat(np.concatenate([[before], np.array(self.values)]), np.diff(ends))
