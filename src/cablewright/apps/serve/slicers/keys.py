"""API keys of slicers: made on the page, stored as hashes, each with a scope."""

from __future__ import annotations

import hashlib
import json
import secrets
import time
from collections import OrderedDict
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Final

from cablewright.apps.serve.operators import person
from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import write_whole
from cablewright.foundation.toml_input import read_bytes

SCOPES: Final = ("upload", "operate")
"""What a key may do: send jobs and read the state; beyond that, pause and end a print. Neither starts motion."""

MAX_KEYS: Final = 20
"""Keys that are kept at a time."""

FILE: Final = "keys.json"
_MAX_FILE: Final = 1 << 16  # bytes


@dataclass(frozen=True)
class Key:
    """An API key of a slicer. ``digest``: SHA-256 of its text. ``utc``: s, time of its creation."""

    number: str
    name: str
    scope: str
    digest: str
    utc: float

    @property
    def title(self) -> str:
        """Name of the key's user in logs."""
        return f"{self.name} (key {self.number})"

    @property
    def operates(self) -> bool:
        """Whether the key may pause and end a print."""
        return self.scope == "operate"

    def told(self) -> dict[str, Any]:
        """Data of the API key that the page shows."""
        return {"id": self.number, "name": self.name, "scope": self.scope, "utc": self.utc}


@dataclass(eq=False)
class Keys:
    """The API keys by which slicers send files to a served folder."""

    folder: Path
    _kept: OrderedDict[str, Key] = field(default_factory=OrderedDict)  # by digest

    def __post_init__(self) -> None:
        """Read the keys. Raises `InputError` where their file is damaged."""
        path = self.folder / FILE
        if not path.exists():
            return
        try:
            found = [Key(**each) for each in json.loads(read_bytes(path, _MAX_FILE, "file of keys"))]
        except (ValueError, TypeError) as reason:
            raise InputError(f"{path}: is damaged ({reason}); remove it, and make the keys again on the page") from None
        self._kept.update((each.digest, each) for each in found)

    def told(self) -> list[dict[str, Any]]:
        """All API keys, as the page shows them."""
        return [each.told() for each in self._kept.values()]

    def of(self, text: str) -> Key | None:
        """Return the API key with this text. It is found by its hash, so that the time reveals nothing of it."""
        return self._kept.get(_digest(text))

    def holds(self, key: Key) -> bool:
        """Return whether an API key is still valid."""
        return key.digest in self._kept

    def make(self, name: object, scope: object) -> tuple[str, Key]:
        """Create an API key; return its text, which is not stored. Raises `InputError`."""
        called = person(name)
        if not called:
            raise InputError("name: a name for the key is expected, such as that of the slicer or computer")
        if scope not in SCOPES:
            raise InputError(f"scope = {str(scope)[:40]!r}: must be {' or '.join(SCOPES)}")
        if len(self._kept) >= MAX_KEYS:
            raise InputError(f"there are {MAX_KEYS} keys already: remove one")
        text = secrets.token_urlsafe(32)
        made = Key(secrets.token_hex(4), called, str(scope), _digest(text), time.time())
        self._keep([*self._kept.values(), made])
        return text, made

    def remove(self, number: str) -> None:
        """Remove an API key, which is then invalid. Raises `InputError`."""
        rest = [each for each in self._kept.values() if each.number != number]
        if len(rest) == len(self._kept):
            raise InputError("there is no such key")
        self._keep(rest)

    def _keep(self, keys: list[Key]) -> None:
        write_whole(self.folder / FILE, json.dumps([asdict(each) for each in keys]).encode())
        self._kept = OrderedDict((each.digest, each) for each in keys)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()
