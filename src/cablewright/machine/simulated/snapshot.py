"""Snapshots of a machine's complete state: saved and loaded exactly, as plain data.

Each part lists its state once, in a method ``archive_state(archive)``, which serves for saving and for loading. A file
holds several snapshots, so that what belongs together is written together: eight bytes of magic, length of the head and
checksum of all that follows, the head as JSON, then the arrays' bytes.
"""

from __future__ import annotations

import json
import math
import struct
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, NonNegativeInt, ValidationError

from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.file_output import whole_file
from cablewright.machine.log.messages import decode, encode
from cablewright.signals import Reading
from cablewright.toml_input import read_bytes

_MAGIC: Final = b"CWSNAP\x00\x01"
_START: Final = struct.Struct("<8sII")  # magic, length of the head, checksum of what follows
_MAX_FILE: Final = 256 << 20
_MAX_HEAD: Final = 16 << 20
_TYPES: Final = {"f8": np.dtype("<f8"), "i8": np.dtype("<i8")}
_BOUND: Final = 1e9  # no number of a machine is larger
_RANDOM_BITS: Final = (128, 128, 1, 32)  # of the numbers in a random generator's state


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Saved state: *values* that JSON holds, and *arrays* of floats (f8) and integers (i8), read-only."""

    values: dict[str, Any]
    arrays: dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Archive:
    """Saves a state into `snapshot`, or loads it from there. ``prefix``: the section, before each name.

    Each method takes the present value and returns, or sets, the one to use from now on. Loading raises `InputError`
    for a value that is missing or does not fit.
    """

    snapshot: Snapshot = field(default_factory=lambda: Snapshot({}, {}))
    loading: bool = False
    prefix: str = ""

    def section(self, name: str) -> Archive:
        """The archive of a part, with its own names."""
        return replace(self, prefix=f"{self.prefix}{name}.")

    def number(self, name: str, now: float) -> float:
        """A number, possibly infinite."""
        return float(self._value(name, float(now), _is_number, "a number"))

    def count(self, name: str, now: int) -> int:
        """An integer from 0 on."""
        return int(self._value(name, int(now), _is_count, "a whole number from 0 on"))

    def random(self, name: str, live: np.random.Generator) -> None:
        """A random generator; loaded in place."""
        now = live.bit_generator.state
        numbers = [now["state"]["state"], now["state"]["inc"], now["has_uint32"], now["uinteger"]]
        state, inc, has, left = self._value(name, numbers, _is_random_state, "the state of a random generator")
        live.bit_generator.state = {**now, "state": {"state": state, "inc": inc}, "has_uint32": has, "uinteger": left}

    def readings(self, name: str, now: Sequence[tuple[float, Reading]]) -> list[tuple[float, Reading]]:
        """Readings, each with a number."""
        if not self.loading:
            encoded = ((float(number), *encode(reading, (), 1)) for number, reading in now)
            self.snapshot.values[self.prefix + name] = [
                [number, topic, data.decode()] for number, topic, data in encoded
            ]
            return list(now)
        found = []
        for number, topic, text in self._value(name, None, _are_messages, "a list of number, topic and message"):
            signal = decode(topic, text.encode(), f"snapshot: {self.prefix}{name}")
            if not isinstance(signal, Reading):
                raise self._refused(name, f"{topic[:60]!r} is no topic of a reading")
            found.append((float(number), signal))
        return found

    def array(self, name: str, live: NDArray[Any]) -> None:
        """An array of fixed shape; loaded in place."""
        live[...] = self._array(name, live, live.shape)

    def scratch(self, name: str, live: NamedTuple) -> None:
        """Workspace of a kernel, with any values and parts that may be None; loaded in place."""
        for part, values in zip(live._fields, live, strict=True):
            if values is not None:
                values[...] = self._array(f"{name}.{part}", values, values.shape, bound=None)

    def rows(self, name: str, now: Sequence[Array], width: int, max_rows: int) -> list[Array]:
        """Up to *max_rows* rows (*width*,)."""
        found = self._array(name, np.array(now, dtype=np.float64).reshape(-1, width), None)
        if found.ndim != 2 or found.shape[1] != width or len(found) > max_rows:
            raise self._refused(name, f"up to {max_rows} rows of {width} finite numbers are expected")
        return [row.copy() for row in found]

    def sparse(self, name: str, live: Array) -> None:
        """An array (n, m) that is mostly zero: its smallest block with all other values; loaded in place."""
        used = [np.flatnonzero(live.any(axis=axis)) for axis in (1, 0)]
        spans = [slice(int(each[0]), int(each[-1]) + 1) if len(each) else slice(0, 0) for each in used]
        block = self._array(name, live[tuple(spans)], None)
        begin = self._value(name, [span.start for span in spans], _is_place, "where a block begins")
        ends = [first + part for first, part in zip(begin, block.shape, strict=False)]
        if block.ndim != 2 or (np.array(ends) > live.shape).any():
            raise self._refused(name, f"a block {block.shape} from {begin} on does not fit into {live.shape}")
        if self.loading:
            live[...] = 0.0
            live[tuple(slice(first, first + part) for first, part in zip(begin, block.shape, strict=True))] = block

    def _value(self, name: str, now: Any, fits: Callable[[Any], bool], expected: str) -> Any:
        """Save and return *now*; or load the value, which must be as *expected*."""
        key = self.prefix + name
        if not self.loading:
            self.snapshot.values[key] = now
            return now
        if key not in self.snapshot.values:
            raise self._refused(name, "it is missing")
        if not fits(self.snapshot.values[key]):
            raise self._refused(name, f"{expected} is expected")
        return self.snapshot.values[key]

    def _array(
        self, name: str, now: NDArray[Any], shape: tuple[int, ...] | None, bound: float | None = _BOUND
    ) -> NDArray[Any]:
        """Save a copy of *now* and return it; or load an array of its type, with that *shape* and *bound* if given."""
        key = self.prefix + name
        if not self.loading:
            self.snapshot.arrays[key] = now.copy()
            self.snapshot.arrays[key].flags.writeable = False
            return now
        found = self.snapshot.arrays.get(key)
        if found is None:
            raise self._refused(name, "it is missing")
        if found.dtype != now.dtype or (shape is not None and found.shape != shape):
            raise self._refused(name, f"{now.dtype.name} {shape} is expected; got {found.dtype.name} {found.shape}")
        if bound is not None and not (np.abs(found) <= bound).all():
            raise self._refused(name, f"a number is not finite or over {bound:g}")
        return found

    def _refused(self, name: str, why: str) -> InputError:
        return InputError(f"snapshot: {self.prefix}{name}: {why}")


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and not math.isnan(value)


def _is_count(value: Any) -> bool:
    return type(value) is int and 0 <= value < 2**53


def _is_place(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(map(_is_count, value))


def _is_random_state(value: Any) -> bool:
    if not isinstance(value, list) or len(value) != len(_RANDOM_BITS):
        return False
    whole = all(type(v) is int and 0 <= v < 2**b for v, b in zip(value, _RANDOM_BITS, strict=True))
    return whole and value[1] % 2 == 1  # PCG64 has an odd increment


def _are_messages(value: Any) -> bool:
    return isinstance(value, list) and all(
        isinstance(row, list)
        and len(row) == 3
        and _is_number(row[0])
        and [type(text) for text in row[1:]] == [str, str]
        for row in value
    )


class _Part(BaseModel):
    """One snapshot in the head of a file: its values; type and shape of its arrays, in the order of their bytes."""

    model_config = ConfigDict(strict=True)
    values: dict[str, Any]
    arrays: dict[str, tuple[Literal["f8", "i8"], Annotated[tuple[NonNegativeInt, ...], Field(max_length=8)]]]


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
    """Write *snapshots*, by name, to *path*: all or nothing, on the disk on return. Raises `EnvironmentFault`.

    State that belongs together goes into one file, so that it is all from the same time. With *parents* missing folders
    are made. What *sign* returns of the content, SIGNATURE bytes, follows it.
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
    """Read what `write_snapshots` wrote. Raises `InputError`, one line, for any other file, or a damaged one.

    With *is_signed*, which tells whether a signature belongs to a content, for one that is not signed too.
    """
    data = read_bytes(path, _MAX_FILE, "snapshot")
    if len(data) < _START.size or data[: len(_MAGIC)] != _MAGIC:
        raise InputError(f"{path}: no saved state of this program")
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
        raise InputError(f"{path}: not signed by this user, so that nobody knows who made it")
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
            size = 8 * math.prod(shape)
            if size > len(rest) or math.prod(each for each in shape if each) > _MAX_FILE:
                raise InputError(f"{path}: part {name[:60]!r}: {key[:60]!r} is longer than the file")
            arrays[key] = np.frombuffer(rest[:size], dtype=_TYPES[kind]).reshape(shape)
            rest = rest[size:]
        found[name] = Snapshot(part.values, arrays)
    if len(rest):
        raise InputError(f"{path}: the snapshot has {len(rest)} bytes too many")
    return found
