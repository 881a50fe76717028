"""Snapshots of a machine's complete state: saved and loaded exactly, as plain data.

Each part lists its state once, in a method ``archive_state(archive)``: a saving archive copies each value, a loading
archive restores it. A file holds several snapshots, so that what belongs together is written together: eight bytes of
magic, length of the head and checksum of all that follows, the head as JSON, then the arrays' bytes.
"""

from __future__ import annotations

import json
import math
import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.file_output import whole_file
from cablewright.machine.log.messages import decode, encode
from cablewright.signals import Reading, SensorFrame

_MAGIC: Final = b"CWSNAP\x00\x01"
_START: Final = struct.Struct("<8sII")  # magic, length of the head, checksum of what follows
_MAX_FILE: Final = 256 << 20
_MAX_HEAD: Final = 16 << 20
_TYPES: Final = {"f8": np.dtype("<f8"), "i8": np.dtype("<i8")}
_BOUND: Final = 1e9  # no number of a machine is larger


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Saved state: *values* that JSON holds, and *arrays* of floats (f8) and integers (i8), read-only."""

    values: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]]


class Archive(Protocol):
    """Saves or loads a state. Each method takes the present value and returns, or sets, the one to use from now on."""

    def section(self, name: str) -> Archive:
        """The archive of a part, with its own namespace."""

    def number(self, name: str, now: float) -> float:
        """A number, possibly infinite."""

    def count(self, name: str, now: int) -> int:
        """An integer from 0 on."""

    def array(self, name: str, live: NDArray[Any]) -> None:
        """An array of fixed shape; loaded in place."""

    def sparse(self, name: str, live: Array) -> None:
        """An array (n, m) that is mostly zero; loaded in place."""

    def scratch(self, name: str, live: NamedTuple) -> None:
        """Workspace of a kernel, with any values; loaded in place."""

    def rows(self, name: str, now: Sequence[Array], width: int, max_rows: int) -> list[Array]:
        """Up to *max_rows* rows (*width*,)."""

    def readings(self, name: str, now: Sequence[tuple[float, Reading]]) -> list[tuple[float, Reading]]:
        """Readings, each with a number."""

    def random(self, name: str, live: np.random.Generator) -> None:
        """A random generator; loaded in place."""


class SavingArchive:
    """An `Archive` that saves copies of values. `snapshot`: what has been saved."""

    def __init__(self, taken: Snapshot | None = None, prefix: str = "") -> None:
        """Start empty, or share the contents of *taken*."""
        self._values: dict[str, Any] = {}
        self._arrays: dict[str, NDArray[Any]] = {}
        if taken is not None:
            assert isinstance(taken.values, dict)
            assert isinstance(taken.arrays, dict)
            self._values, self._arrays = taken.values, taken.arrays
        self._prefix = prefix

    @property
    def snapshot(self) -> Snapshot:
        """What has been saved."""
        return Snapshot(self._values, self._arrays)

    def section(self, name: str) -> SavingArchive:
        """As `Archive`."""
        return SavingArchive(self.snapshot, f"{self._prefix}{name}.")

    def number(self, name: str, now: float) -> float:
        """As `Archive`."""
        self._values[self._prefix + name] = float(now)
        return now

    def count(self, name: str, now: int) -> int:
        """As `Archive`."""
        self._values[self._prefix + name] = int(now)
        return now

    def array(self, name: str, live: NDArray[Any]) -> None:
        """As `Archive`."""
        copy = live.copy()
        copy.flags.writeable = False
        self._arrays[self._prefix + name] = copy

    def sparse(self, name: str, live: Array) -> None:
        """As `Archive`: the smallest block of *live* with all non-zero values, and where it begins."""
        spans = []
        for axis in (0, 1):
            used = np.flatnonzero(live.any(axis=1 - axis))
            spans.append(slice(int(used[0]), int(used[-1]) + 1) if len(used) else slice(0, 0))
        self.array(name, live[tuple(spans)])
        self._values[self._prefix + name] = [span.start for span in spans]

    def scratch(self, name: str, live: NamedTuple) -> None:
        """As `Archive`."""
        for field, values in zip(live._fields, live, strict=True):
            self.array(f"{name}.{field}", values)

    def rows(self, name: str, now: Sequence[Array], width: int, max_rows: int) -> list[Array]:
        """As `Archive`."""
        assert len(now) <= max_rows
        self.array(name, np.array(now, dtype=np.float64).reshape(-1, width))
        return list(now)

    def readings(self, name: str, now: Sequence[tuple[float, Reading]]) -> list[tuple[float, Reading]]:
        """As `Archive`."""
        encoded = ((number, *encode(reading, (), 1)) for number, reading in now)
        self._values[self._prefix + name] = [[float(number), topic, data.decode()] for number, topic, data in encoded]
        return list(now)

    def random(self, name: str, live: np.random.Generator) -> None:
        """As `Archive`."""
        state = live.bit_generator.state
        inner = state["state"]
        self._values[self._prefix + name] = [inner["state"], inner["inc"], state["has_uint32"], state["uinteger"]]


class LoadingArchive:
    """An `Archive` that loads a snapshot. Every method raises `InputError` for a value that does not fit."""

    def __init__(self, snapshot: Snapshot, prefix: str = "") -> None:
        """Load from *snapshot*."""
        self._snapshot, self._prefix = snapshot, prefix

    def section(self, name: str) -> LoadingArchive:
        """As `Archive`."""
        return LoadingArchive(self._snapshot, f"{self._prefix}{name}.")

    def number(self, name: str, now: float) -> float:  # noqa: ARG002, as `Archive`
        """As `Archive`."""
        return self._number(name, self._value(name))

    def count(self, name: str, now: int) -> int:  # noqa: ARG002
        """As `Archive`."""
        value = self._value(name)
        if type(value) is not int or not 0 <= value < 2**53:
            raise self._refused(name, "a whole number from 0 on is wanted")
        return value

    def array(self, name: str, live: NDArray[Any]) -> None:
        """As `Archive`."""
        kept = self._kept(name, live.dtype, live.shape)
        if not (np.abs(kept) <= _BOUND).all():
            raise self._refused(name, f"a number is not finite or over {_BOUND:g}")
        live[...] = kept

    def sparse(self, name: str, live: Array) -> None:
        """As `Archive`."""
        kept, begin = self._kept(name, live.dtype, None), self._value(name)
        if not isinstance(begin, list) or len(begin) != 2 or kept.ndim != 2:
            raise self._refused(name, "a part of an array and where it begins are wanted")
        if not all(
            type(first) is int and 0 <= first <= whole - part
            for first, part, whole in zip(begin, kept.shape, live.shape, strict=True)
        ):
            raise self._refused(name, f"does not fit into {live.shape}")
        if not (np.abs(kept) <= _BOUND).all():
            raise self._refused(name, f"a number is not finite or over {_BOUND:g}")
        live[...] = 0.0
        live[tuple(slice(first, first + part) for first, part in zip(begin, kept.shape, strict=True))] = kept

    def scratch(self, name: str, live: NamedTuple) -> None:
        """As `Archive`."""
        for field, values in zip(live._fields, live, strict=True):
            values[...] = self._kept(f"{name}.{field}", values.dtype, values.shape)

    def rows(self, name: str, now: Sequence[Array], width: int, max_rows: int) -> list[Array]:  # noqa: ARG002
        """As `Archive`."""
        kept = self._kept(name, np.dtype(np.float64), None)
        if kept.ndim != 2 or kept.shape[1] != width or len(kept) > max_rows or not (np.abs(kept) <= _BOUND).all():
            raise self._refused(name, f"up to {max_rows} rows of {width} finite numbers are wanted")
        return [row.copy() for row in kept]

    def readings(self, name: str, now: Sequence[tuple[float, Reading]]) -> list[tuple[float, Reading]]:  # noqa: ARG002
        """As `Archive`."""
        rows = self._value(name)
        if not isinstance(rows, list):
            raise self._refused(name, "a list is wanted")
        return [self._reading(name, row) for row in rows]

    def random(self, name: str, live: np.random.Generator) -> None:
        """As `Archive`."""
        values = self._value(name)
        bits = (128, 128, 1, 32)
        if not isinstance(values, list) or len(values) != len(bits):
            raise self._refused(name, "the state of a random generator is wanted")
        if not all(type(v) is int and 0 <= v < 2**b for v, b in zip(values, bits, strict=True)) or values[1] % 2 == 0:
            raise self._refused(name, "it is no state of a random generator")
        state, inc, has, left = values
        inner = {"state": state, "inc": inc}
        live.bit_generator.state = {"bit_generator": "PCG64", "state": inner, "has_uint32": has, "uinteger": left}

    def _value(self, name: str) -> Any:
        if self._prefix + name not in self._snapshot.values:
            raise self._refused(name, "it is missing")
        return self._snapshot.values[self._prefix + name]

    def _kept(self, name: str, dtype: np.dtype[Any], shape: tuple[int, ...] | None) -> NDArray[Any]:
        kept = self._snapshot.arrays.get(self._prefix + name)
        if kept is None:
            raise self._refused(name, "it is missing")
        if kept.dtype != dtype or (shape is not None and kept.shape != shape):
            raise self._refused(name, f"{dtype.name} {shape} is wanted; got {kept.dtype.name} {kept.shape}")
        return kept

    def _number(self, name: str, value: Any) -> float:
        if type(value) not in (int, float) or math.isnan(value):
            raise self._refused(name, "a number is wanted")
        return float(value)

    def _reading(self, name: str, row: Any) -> tuple[float, Reading]:
        if not isinstance(row, list) or len(row) != 3 or not isinstance(row[1], str) or not isinstance(row[2], str):
            raise self._refused(name, "number, topic and message are wanted")
        signal = decode(row[1], row[2].encode(), f"snapshot: {self._prefix}{name}")
        if not isinstance(signal, Reading) or isinstance(signal, SensorFrame):
            raise self._refused(name, f"{row[1][:60]!r} is no topic of a reading")
        return self._number(name, row[0]), signal

    def _refused(self, name: str, why: str) -> InputError:
        return InputError(f"snapshot: {self._prefix}{name}: {why}")


def write_snapshots(path: Path, snapshots: Mapping[str, Snapshot]) -> None:
    """Write *snapshots*, by name, to *path*: all or nothing, on the disk on return. Raises `EnvironmentFault`.

    State that belongs together goes into one file, so that it is all of one time.
    """
    parts, data = {}, list[NDArray[np.uint8]]()
    for name, snapshot in snapshots.items():
        listed = {}
        for key, array in snapshot.arrays.items():
            listed[key] = [_type_name(key, array.dtype), array.shape]
            data.append(np.ascontiguousarray(array).reshape(-1).view(np.uint8))
        parts[name] = {"values": dict(snapshot.values), "arrays": listed}
    head = json.dumps({"schema": 1, "parts": parts}, separators=(",", ":")).encode()
    body = np.concatenate([np.frombuffer(head, dtype=np.uint8), *data])
    with whole_file(path) as file:
        file.write(_START.pack(_MAGIC, len(head), zlib.crc32(body.data)))
        file.write(body.data)


def read_snapshots(path: Path) -> dict[str, Snapshot]:
    """Read what `write_snapshots` wrote. Raises `InputError`, one line, for any other file, or a damaged one."""
    try:
        with path.open("rb") as file:
            data = file.read(_MAX_FILE + 1)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(f"{path}: cannot be read: {reason}") from None
    if len(data) > _MAX_FILE:
        raise InputError(f"{path}: over {_MAX_FILE >> 20} MiB, too much for a snapshot")
    if len(data) < _START.size or data[: len(_MAGIC)] != _MAGIC:
        raise InputError(f"{path}: no snapshot of a machine")
    _, length, check = _START.unpack_from(data)
    body = memoryview(data)[_START.size :]
    if length > min(_MAX_HEAD, len(body)) or zlib.crc32(body) != check:
        raise InputError(f"{path}: the snapshot is cut or damaged")
    try:
        head = json.loads(bytes(body[:length]))
    except (ValueError, RecursionError):
        raise InputError(f"{path}: the snapshot's head is no JSON") from None
    if not isinstance(head, dict) or head.get("schema") != 1 or not isinstance(head.get("parts"), dict):
        raise InputError(f"{path}: the snapshot is not of schema 1")
    found, rest = {}, body[length:]
    for name, part in head["parts"].items():
        found[name], rest = _part(part, rest, f"{path}: part {name[:60]!r}")
    if len(rest):
        raise InputError(f"{path}: the snapshot has {len(rest)} bytes too many")
    return found


def _part(part: Any, data: memoryview, origin: str) -> tuple[Snapshot, memoryview]:
    """A part of the head, with its arrays from the beginning of *data*; and the data after them."""
    values, listed = (part.get(key) if isinstance(part, dict) else None for key in ("values", "arrays"))
    if not isinstance(values, dict) or not isinstance(listed, dict):
        raise InputError(f"{origin}: values and arrays are wanted")
    arrays = {}
    for key, entry in listed.items():
        kind, shape = entry if isinstance(entry, list) and len(entry) == 2 else (None, None)
        whole = isinstance(shape, list) and len(shape) <= 8 and all(type(n) is int and n >= 0 for n in shape)
        if not isinstance(kind, str) or kind not in _TYPES or shape is None or not whole:
            raise InputError(f"{origin}: {key[:60]!r}: an array's type and shape are wanted")
        size = 8 * math.prod(shape)
        if size > len(data):
            raise InputError(f"{origin}: {key[:60]!r} is longer than the file")
        arrays[key] = np.frombuffer(data[:size], dtype=_TYPES[kind]).reshape(shape)
        data = data[size:]
    return Snapshot(values, arrays), data


def _type_name(key: str, dtype: np.dtype[Any]) -> str:
    for name, known in _TYPES.items():
        if dtype == known:
            return name
    raise TypeError(f"{key}: arrays of {dtype} are not kept")
