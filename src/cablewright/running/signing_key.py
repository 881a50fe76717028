"""A secret key of the user, which signs state files from which proofs or prints are resumed.

A checksum shows that a file is whole, not who wrote it: a stranger can compute one as well. A resumed file is accepted
only if it was signed with the key, which no other user of a well-kept system can read.
"""

from __future__ import annotations

import hashlib
import hmac
import os
import secrets
import stat
from contextlib import suppress
from pathlib import Path
from typing import Final

from cablewright.foundation.errors import EnvironmentFault
from cablewright.foundation.file_output import cannot_write

DIRECTORY: Final = "CABLEWRIGHT_STATE_DIR"
"""Environment variable with the folder of the key (default: the user's folder for program state)."""

_NAME: Final = "signing.key"
_BYTES: Final = 32


def signature(content: bytes | memoryview) -> bytes:
    """Return the signature (32 bytes) of *content* with the user's key, which is made where there is none.

    HMAC with SHA-256. Raises `EnvironmentFault` where the key cannot be read or made, or others can read it.
    """
    return hmac.digest(_key(), content, hashlib.sha256)


def is_signed(content: bytes | memoryview, given: bytes) -> bool:
    """Return whether *given* is this user's signature of *content*."""
    return hmac.compare_digest(signature(content), given)


def _key() -> bytes:
    file = _folder() / _NAME
    try:
        if not file.exists():
            _make(file)
        with open(os.open(file, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0)), "rb") as kept:
            found, key = os.fstat(kept.fileno()), kept.read(_BYTES + 1)
    except OSError as reason:
        raise cannot_write(file, reason) from None
    own = os.name != "posix" or (found.st_uid == os.geteuid() and not found.st_mode & (stat.S_IRWXG | stat.S_IRWXO))
    if not own or len(key) != _BYTES:
        why = "is no key of this user alone" if len(key) == _BYTES else f"has not the {_BYTES} bytes of a key"
        raise EnvironmentFault(f"{file}: {why}; remove it, and searches and prints start again")
    return key


def _make(file: Path) -> None:
    """Make the key, whole; one that another program made in the meantime stays."""
    file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    part = file.with_name(f".{secrets.token_hex(8)}.part")
    try:
        with open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as out:
            out.write(secrets.token_bytes(_BYTES))
        with suppress(FileExistsError):
            os.link(part, file)
    finally:
        part.unlink(missing_ok=True)


def _folder() -> Path:
    """The folder of the key. A relative folder of the environment does not count, as the XDG specification has it."""
    own = os.environ.get(DIRECTORY)
    if own:
        return Path(own).expanduser().absolute()
    shared = Path(os.environ.get("XDG_STATE_HOME") or os.environ.get("LOCALAPPDATA") or "")
    try:
        home = shared if shared.is_absolute() else Path.home() / ".local" / "state"
    except RuntimeError:  # a user without a home
        raise EnvironmentFault(
            f"there is no folder for the key that signs saved states; set the environment variable {DIRECTORY}"
        ) from None
    return home / "cablewright"
