"""Arrays as text of a page: little-endian bytes, deflated, in base64."""

from __future__ import annotations

import base64
import zlib
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Packed = dict[str, Any]
"""``type`` (u8, u16, u32 or f32), ``shape``, ``delta``: whether rows are differences from the row before, ``data``."""

_TYPES: Final = {"u8": "<u1", "u16": "<u2", "u32": "<u4", "f32": "<f4"}
_LEVEL: Final = 6  # of zlib


def packed(values: NDArray[Any], kind: str, *, delta: bool = False) -> Packed:
    """Return *values* as a type of `Packed`; *delta*: as differences, which wrap, for whole numbers that change little.

    Raises `OverflowError` for a whole number that the type does not hold.
    """
    given = np.asarray(values)
    made = given.astype(_TYPES[kind])
    if kind != "f32" and not np.array_equal(made, given):
        raise OverflowError(f"numbers that {kind} does not hold")
    if delta and len(made):
        made = np.concatenate([made[:1], np.diff(made, axis=0)])  # modulo its size
    data = base64.b64encode(zlib.compress(made.tobytes(), _LEVEL)).decode("ascii")
    return {"type": kind, "shape": list(made.shape), "delta": delta, "data": data}


def unpacked(given: Packed) -> NDArray[Any]:
    """Return the array of `packed`."""
    data = zlib.decompress(base64.b64decode(given["data"]))
    values = np.frombuffer(data, dtype=_TYPES[given["type"]]).reshape(given["shape"])
    return np.cumsum(values, axis=0, dtype=values.dtype) if given["delta"] else values
