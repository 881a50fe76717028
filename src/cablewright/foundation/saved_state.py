"""Saving of objects' state to a snapshot or a file, and exact loading, by one walk over declared attributes.

A class names the attributes that are its state in ``SAVED``, with dots for those of its parts. All else, settings,
derived arrays and scratch, is made again by its constructor: state is loaded into a new object of the same settings,
whose present values say which types and shapes are expected. A class whose derived values depend on its state computes
them in a method ``after_load()``. The walk goes into named parts, tuples, lists and dictionaries. A file holds several
snapshots, so that related states are written together: eight bytes of magic, length of the head and checksum of all
that follows, the head as JSON, then the arrays' bytes.
"""

from __future__ import annotations

import json
import math
import struct
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, NonNegativeInt, ValidationError

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import whole_file
from cablewright.foundation.toml_input import read_bytes

LAYOUT: Final = 6
"""Version of the saved layout: raise it whenever a ``SAVED`` changes. `load` rejects state of another version."""

_MAGIC: Final = b"CWSNAP\x00\x01"
_START: Final = struct.Struct("<8sII")  # magic, length of the head, checksum of the rest
_MAX_FILE: Final = 256 << 20
_MAX_HEAD: Final = 16 << 20
_TYPES: Final = {"b1": np.dtype("?"), "f8": np.dtype("<f8"), "i8": np.dtype("<i8")}
_BOUND: Final = 1e9  # no number of a machine is larger
_RANDOM_BITS: Final = (128, 128, 1, 32)  # of the numbers in a random generator's state


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Saved state: *values* that JSON holds, and *arrays* of floats (f8), integers (i8) and truths (b1), read-only."""

    values: dict[str, Any]
    arrays: dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Coded:
    """An attribute *name* that is no plain data: ``encode`` returns it as JSON holds it, ``decode`` the value of that.

    ``decode`` raises `InputError` for what it cannot read.
    """

    name: str
    encode: Callable[[Any], Any]
    decode: Callable[[Any], Any]

    def walk(self, walk: _Walk, key: str, live: Any) -> Any:
        """Save the attribute's *live* value, or return the saved one."""
        if walk.loading:
            try:
                return self.decode(walk.value(key, None, lambda _: True, ""))
            except InputError as reason:
                raise walk.refused(key, str(reason)) from None
        walk.value(key, self.encode(live), lambda _: True, "")
        return live


@dataclass(frozen=True)
class SavedRows:
    """An attribute *name*, an array with a changing number of rows, up to ``most``; loading replaces it."""

    name: str
    most: int

    def walk(self, walk: _Walk, key: str, live: NDArray[Any]) -> NDArray[Any]:
        """Save or load the rows; see `Coded.walk`."""
        found = walk.array(key, live, None)
        if found.ndim != live.ndim or found.shape[1:] != live.shape[1:] or len(found) > self.most:
            raise walk.refused(key, f"up to {self.most} rows {live.shape[1:]} are expected; got {found.shape}")
        return found.copy()


@dataclass(frozen=True)
class Sparse:
    """An attribute *name*, an array (n, m) that is mostly zero: saved is its smallest block with all other values."""

    name: str

    def walk(self, walk: _Walk, key: str, live: Array) -> Array:
        """Save or load the blocks; see `Coded.walk`."""
        used = [np.flatnonzero(live.any(axis=axis)) for axis in (1, 0)]
        spans = [slice(int(each[0]), int(each[-1]) + 1) if len(each) else slice(0, 0) for each in used]
        block = walk.array(key, live[tuple(spans)], None)
        begin = walk.value(key, [span.start for span in spans], _is_place, "where a block begins")
        ends = [first + part for first, part in zip(begin, block.shape, strict=False)]
        if block.ndim != 2 or (np.array(ends) > live.shape).any():
            raise walk.refused(key, f"a block {block.shape} from {begin} on does not fit into {live.shape}")
        if walk.loading:
            live[...] = 0.0
            live[tuple(slice(first, first + part) for first, part in zip(begin, block.shape, strict=True))] = block
        return live


Saved = tuple[str | Coded | SavedRows | Sparse, ...]
"""Type of a ``SAVED``."""


def save(state: Any) -> Snapshot:
    """Return a copy of the saved attributes of *state* and of its parts, see ``SAVED``."""
    snapshot = Snapshot({"layout": LAYOUT}, {})
    _Walk(snapshot, loading=False).parts("", state)
    return snapshot


def load(state: Any, snapshot: Snapshot) -> None:
    """Set the state of *state*, a new object of the same settings, to the data that `save` returned.

    Arrays are loaded in place. Raises `InputError` for state of another layout, or that is missing or does not fit.
    """
    layout = snapshot.values.get("layout", 1)
    if layout != LAYOUT:
        raise InputError(f"snapshot: its layout is {str(layout)[:60]}, saved by another version; this one: {LAYOUT}")
    _Walk(snapshot, loading=True).parts("", state)


@dataclass(frozen=True, eq=False)
class _Walk:
    """Saves into `snapshot`, or loads from it. Methods return the value to use from now on."""

    snapshot: Snapshot
    loading: bool

    def parts(self, prefix: str, state: Any) -> None:
        """Walk through the attributes that the class of *state* names."""
        for form in state.SAVED:
            *way, last = (form if isinstance(form, str) else form.name).split(".")
            owner, key = reduce(getattr, way, state), prefix + ".".join(name.lstrip("_") for name in (*way, last))
            live = getattr(owner, last)
            found = self._any(key, live) if isinstance(form, str) else form.walk(self, key, live)
            if found is not live:
                setattr(owner, last, found)
        if self.loading and hasattr(state, "after_load"):
            state.after_load()

    def _any(self, key: str, live: Any) -> Any:
        match live:
            case None:  # a part that the settings leave out
                return None
            case bool():
                return self.value(key, live, lambda value: type(value) is bool, "true or false")
            case int():
                return self.value(key, live, _is_count, "a whole number from 0 on")
            case float():
                unknown = math.isnan(live)
                return float(self.value(key, live, lambda value: _is_number(value, unknown), "a number"))
            case np.random.Generator():
                return self._random(key, live)
            case np.ndarray():
                live[...] = self.array(key, live, live.shape)
                return live
            case dict():
                return {name: self._any(f"{key}.{name}", each) for name, each in live.items()}
            case list() | tuple():
                names = getattr(live, "_fields", range(len(live)))
                items = [self._any(f"{key}.{name}", each) for name, each in zip(names, live, strict=True)]
                return type(live)(*items) if hasattr(live, "_fields") else type(live)(items)
        self.parts(f"{key}.", live)
        return live

    def _random(self, key: str, live: np.random.Generator) -> np.random.Generator:
        """A random generator; loaded in place."""
        now = live.bit_generator.state
        numbers = [now["state"]["state"], now["state"]["inc"], now["has_uint32"], now["uinteger"]]
        state, inc, has, left = self.value(key, numbers, _is_random_state, "the state of a random generator")
        live.bit_generator.state = {**now, "state": {"state": state, "inc": inc}, "has_uint32": has, "uinteger": left}
        return live

    def value(self, key: str, now: Any, fits: Callable[[Any], bool], expected: str) -> Any:
        """Save and return *now*; or load the value, which must be as *expected*."""
        if not self.loading:
            self.snapshot.values[key] = now
            return now
        if key not in self.snapshot.values:
            raise self.refused(key, "it is missing")
        if not fits(self.snapshot.values[key]):
            raise self.refused(key, f"{expected} is expected")
        return self.snapshot.values[key]

    def array(self, key: str, now: NDArray[Any], shape: tuple[int, ...] | None) -> NDArray[Any]:
        """Save a copy of *now* and return *now*; or load an array of its type, with that *shape* if given.

        Its numbers are finite, but where that of *now* is not.
        """
        if not self.loading:
            self.snapshot.arrays[key] = now.copy()
            self.snapshot.arrays[key].flags.writeable = False
            return now
        found = self.snapshot.arrays.get(key)
        if found is None:
            raise self.refused(key, "it is missing")
        if found.dtype != now.dtype or (shape is not None and found.shape != shape):
            raise self.refused(key, f"{now.dtype.name} {shape} is expected; got {found.dtype.name} {found.shape}")
        fits = np.abs(found) <= _BOUND
        if found.shape == now.shape:
            fits |= (found == now) | (np.isnan(found) & np.isnan(now))
        if not fits.all():
            raise self.refused(key, f"a number is not finite or over {_BOUND:g}")
        return found

    @staticmethod
    def refused(key: str, why: str) -> InputError:
        """Return the error for a *key* of the saved state."""
        return InputError(f"snapshot: {key}: {why}")


def _is_number(value: Any, unknown: bool) -> bool:
    return type(value) in (int, float) and (unknown or not math.isnan(value))


def _is_count(value: Any) -> bool:
    return type(value) is int and 0 <= value < 2**53


def _is_place(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(map(_is_count, value))


def _is_random_state(value: Any) -> bool:
    if not isinstance(value, list) or len(value) != len(_RANDOM_BITS):
        return False
    whole = all(type(v) is int and 0 <= v < 2**b for v, b in zip(value, _RANDOM_BITS, strict=True))
    return whole and value[1] % 2 == 1  # PCG64 has an odd increment


class _Part(BaseModel):
    """One snapshot in the head of a file: its values; type and shape of its arrays, in the order of their bytes."""

    model_config = ConfigDict(strict=True)
    values: dict[str, Any]
    arrays: dict[str, tuple[Literal["b1", "f8", "i8"], Annotated[tuple[NonNegativeInt, ...], Field(max_length=8)]]]


class _Head(BaseModel):
    """The head of a file."""

    model_config = ConfigDict(strict=True)
    schema_version: Annotated[Literal[1], Field(alias="schema")]
    parts: dict[str, _Part]


SIGNATURE: Final = 32
"""Bytes of a signature."""
Sign = Callable[[memoryview], bytes]
IsSigned = Callable[[memoryview, bytes], bool]


def write_snapshots(
    path: Path, snapshots: Mapping[str, Snapshot], *, parents: bool = False, sign: Sign | None = None
) -> None:
    """Write the named *snapshots* to one file *path*, completely or not at all. Raises `EnvironmentFault`.

    On return the file is on the disk. All state in one file is from the same time. With *parents* missing folders are
    made. The SIGNATURE bytes that *sign* returns for the content follow the content.
    """
    names = {dtype: name for name, dtype in _TYPES.items()}
    parts, data = {}, list[NDArray[np.uint8]]()
    for name, snapshot in snapshots.items():
        arrays = {key: (names[array.dtype], array.shape) for key, array in snapshot.arrays.items()}
        parts[name] = {"values": dict(snapshot.values), "arrays": arrays}
        data += [np.ascontiguousarray(array).reshape(-1).view(np.uint8) for array in snapshot.arrays.values()]
    head = json.dumps({"schema": 1, "parts": parts}, separators=(",", ":")).encode()
    body = np.concatenate([np.frombuffer(head, dtype=np.uint8), *data])
    with whole_file(path, parents=parents) as file:
        file.write(_START.pack(_MAGIC, len(head), zlib.crc32(body.data)))
        file.write(body.data)
        if sign is not None:
            file.write(sign(body.data))


def read_snapshots(path: Path, *, is_signed: IsSigned | None = None) -> dict[str, Snapshot]:
    """Read the file of `write_snapshots`. Raises `InputError`, one line, for any other file, or a damaged one.

    With *is_signed*, which decides whether a signature matches a content, also for a content without a signature.
    """
    data = read_bytes(path, _MAX_FILE, "snapshot")
    if len(data) < _START.size or data[: len(_MAGIC)] != _MAGIC:
        raise InputError(f"{path}: this file is no saved state of cablewright")
    _, length, check = _START.unpack_from(data)
    body = memoryview(data)[_START.size :]
    if is_signed is not None and zlib.crc32(body) != check:  # a signature follows the content
        body, given = body[:-SIGNATURE], bytes(body[-SIGNATURE:])
        signed = is_signed(body, given)
    else:
        signed = is_signed is None
    if length > min(_MAX_HEAD, len(body)) or zlib.crc32(body) != check:
        raise InputError(f"{path}: the snapshot is cut or damaged")
    if not signed:
        raise InputError(f"{path}: not signed by this user, so its author is unknown")
    try:
        head = _Head.model_validate_json(bytes(body[:length]))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        why = first["msg"].replace("Input should be", "must be", 1)
        raise InputError(f"{path}: the snapshot's head: {'.'.join(map(str, first['loc']))}: {why}") from None
    found, rest = dict[str, Snapshot](), body[length:]
    for name, part in head.parts.items():
        arrays = {}
        for key, (kind, shape) in part.arrays.items():
            size = _TYPES[kind].itemsize * math.prod(shape)
            if size > len(rest) or math.prod(each for each in shape if each) > _MAX_FILE:
                raise InputError(f"{path}: part {name[:60]!r}: {key[:60]!r} is longer than the file")
            arrays[key] = np.frombuffer(rest[:size], dtype=_TYPES[kind]).reshape(shape)
            rest = rest[size:]
        found[name] = Snapshot(part.values, arrays)
    if len(rest):
        raise InputError(f"{path}: the snapshot has {len(rest)} bytes too many")
    return found
