"""Access rules of the operator's page: hosts, origins, the token and its cookie, and rates."""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
import time
from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final
from urllib.parse import urlsplit

TOKEN_LETTERS: Final = 43
"""Length of a token in letters: 256 bits."""

_MAX_AGE: Final = 7 * 24 * 3600  # s of a cookie
_SESSIONS: Final = 1000  # whose rate is counted
_SAFE: Final = ("GET", "HEAD")
_COOKIE: Final = re.compile(r"([0-9a-f]{16})\.([0-9a-f]{64})")

FOXGLOVE_ORIGINS: Final = ("https://app.foxglove.dev", "https://studio.foxglove.dev", "file://")
"""Origins of Foxglove's own programs, which may read the live log by its address."""

POLICY: Final = (
    b"default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    b"base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
"""Content security policy of the page: it may load only data of this server."""

HEADERS: Final = (
    (b"content-security-policy", POLICY),
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
    (b"referrer-policy", b"same-origin"),  # with no-referrer a plain form would name no origin
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"cache-control", b"no-store"),
)
"""Headers of every answer. A report has another policy: its scripts run without the rights of this origin."""

REPORT_POLICY: Final = (
    b"sandbox allow-scripts; default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; "
    b"frame-ancestors 'none'"
)


def policy_with(camera: str) -> bytes:
    """Return the content security policy of the page; *camera*: address of the camera picture, or empty."""
    if not camera:
        return POLICY
    parts = urlsplit(camera)
    return POLICY.replace(b"img-src 'self'", f"img-src 'self' {parts.scheme}://{parts.netloc}".encode())


def new_token() -> str:
    """Return a random token of 256 bits."""
    return secrets.token_urlsafe(32)


@dataclass(eq=False)
class Bucket:
    """A token bucket that limits rates: a burst, and a number a second."""

    most: float
    rate: float
    _left: float = field(init=False)
    _since: float = field(init=False)

    def __post_init__(self) -> None:
        """Begin with a full bucket."""
        self._left, self._since = self.most, time.monotonic()

    def take(self) -> bool:
        """Take one event from the bucket; return whether the event is allowed now."""
        now = time.monotonic()
        self._left = min(self.most, self._left + (now - self._since) * self.rate)
        self._since = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


@dataclass(eq=False)
class Access:
    """Access rules of a server with these *hosts*.

    ``key``: key that signs cookies, known to this start alone.

    ``token``: SHA-256 of the token. ``secure``: whether the page is served by TLS. ``port``: port in the cookie's name,
    as browsers do not distinguish ports.
    """

    key: bytes
    token: bytes
    hosts: frozenset[str]
    port: int
    secure: bool
    _rates: OrderedDict[str, Bucket] = field(default_factory=OrderedDict, repr=False)
    _guesses: Bucket = field(default_factory=lambda: Bucket(10, 1.0), repr=False)

    @property
    def cookie_name(self) -> str:
        """Name of this server's cookie."""
        return f"cablewright-{self.port}"

    @property
    def view_token(self) -> str:
        """Return a token that permits reading the live log, and nothing else."""
        return hmac.new(self.key, b"view", hashlib.sha256).hexdigest()[:32]

    def knows_host(self, headers: Iterable[tuple[bytes, bytes]]) -> bool:
        """Return whether the request has exactly one Host header, with a name of this server.

        A foreign name that resolves to this computer is rejected (DNS rebinding).
        """
        given = [value for name, value in headers if name == b"host"]
        return len(given) == 1 and given[0].decode("latin-1").lower() in self.hosts

    def origin_of(self, headers: Iterable[tuple[bytes, bytes]]) -> str | None:
        """Return ``own``, ``foxglove``, ``foreign``, or None where the request names no origin."""
        given = [value.decode("latin-1").lower() for name, value in headers if name == b"origin"]
        if not given:
            return None
        scheme = "https" if self.secure else "http"
        if len(given) == 1 and given[0] in {f"{scheme}://{host}" for host in self.hosts}:
            return "own"
        return "foxglove" if len(given) == 1 and given[0] in FOXGLOVE_ORIGINS else "foreign"

    def is_token(self, given: str) -> bool:
        """Return whether the text *given* is the access token, compared in constant time."""
        return hmac.compare_digest(hashlib.sha256(given.encode("utf-8", "replace")).digest(), self.token)

    def may_guess(self) -> bool:
        """Return whether the rate of wrong tokens is low enough to answer one more immediately."""
        return self._guesses.take()

    def is_view_token(self, given: str) -> bool:
        """Return whether the text *given* is the token that permits reading the live log."""
        return hmac.compare_digest(given.encode("utf-8", "replace"), self.view_token.encode())

    def new_cookie(self) -> tuple[str, str]:
        """Return the name of a new session, and the value of the header that sets its cookie."""
        session = secrets.token_hex(8)
        parts = [f"{self.cookie_name}={session}.{self._mark(session)}", "Path=/", "HttpOnly", "SameSite=Strict"]
        return session, "; ".join([*parts, f"Max-Age={_MAX_AGE}", *(["Secure"] if self.secure else [])])

    def session_of(self, headers: Iterable[tuple[bytes, bytes]]) -> str | None:
        """Return the session of the request's cookie, or ``bearer`` if it has the token; None: neither is valid."""
        for name, value in headers:
            text = value.decode("latin-1")
            if name == b"authorization" and text.lower().startswith("bearer ") and self.is_token(text[7:].strip()):
                return "bearer"
            if name == b"cookie" and (found := self._in_cookies(text)):
                return found
        return None

    def allows(self, session: str) -> bool:
        """Return whether the session's rate of requests is within its limit."""
        bucket = self._rates.pop(session, None) or Bucket(200, 40.0)
        self._rates[session] = bucket
        while len(self._rates) > _SESSIONS:
            self._rates.popitem(last=False)
        return bucket.take()

    def _in_cookies(self, text: str) -> str | None:
        for part in text[:4096].split(";"):
            name, _, value = part.strip().partition("=")
            match = _COOKIE.fullmatch(value)
            if name == self.cookie_name and match and hmac.compare_digest(match[2], self._mark(match[1])):
                return match[1]
        return None

    def _mark(self, session: str) -> str:
        return hmac.new(self.key, b"session " + session.encode(), hashlib.sha256).hexdigest()


def is_safe(method: str) -> bool:
    """Return whether requests of the HTTP *method* change nothing."""
    return method in _SAFE
