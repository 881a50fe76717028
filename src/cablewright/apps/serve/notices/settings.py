"""Settings of receivers of news: webhooks and an MQTT broker. The file and its addresses contain no secret."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Final, Self
from urllib.parse import urlsplit

from pydantic import Field, model_validator

from cablewright.foundation.errors import InputError
from cablewright.foundation.toml_input import load_model, read_bytes
from cablewright.foundation.validation import Description, FileDescription, refusal

_MAX_SECRET: Final = 4096  # bytes


class NewsKind(StrEnum):
    """Kinds of news about a print: layer, pause, fault, end."""

    LAYER = "layer"
    PAUSE = "pause"
    FAULT = "fault"
    END = "end"


_What = tuple[NewsKind, ...]
_ALL: Final = tuple(NewsKind)
_Text = Annotated[str, Field(min_length=1, max_length=200)]


class WebhookSettings(Description):
    """A program that takes news by HTTP POST. ``secret``: file of the secret that signs them."""

    address: _Text
    secret: Path | None = None
    what: _What = _ALL

    @model_validator(mode="after")
    def _has_no_secret(self) -> Self:
        """Reject an address that is none, or that has more than a host and a path: addresses stay in logs."""
        try:
            parts = urlsplit(self.address)
            known = parts.scheme in ("http", "https") and bool(parts.hostname) and (parts.port or 1) > 0
        except ValueError:
            known = False
        if not known or not self.address.isascii() or not self.address.isprintable() or " " in self.address:
            raise refusal("address", "http://HOST[:PORT]/PATH or https://HOST[:PORT]/PATH is expected")
        if parts.username is not None or parts.query or parts.fragment:
            raise refusal(
                "address", "no name, password, ? or #: addresses stay in logs; give secret, a file that signs"
            )
        return self


class MqttSettings(Description):
    """A broker of MQTT. ``topic``: the levels before the kind of news. ``password``: file with that of the ``user``."""

    host: _Text
    port: Annotated[int, Field(ge=1, le=65535)] = 1883
    topic: Annotated[str, Field(pattern=r"^[^#+\x00]{1,200}$")] = "cablewright"
    user: _Text | None = None
    password: Path | None = None
    tls: bool = False
    what: _What = _ALL

    @model_validator(mode="after")
    def _hides_the_password(self) -> Self:
        if self.password is not None and not self.tls and self.host not in ("localhost", "127.0.0.1", "::1"):
            raise refusal("tls", "must be true where a password goes to another computer")
        return self


class NewsSettings(FileDescription):
    """Settings of all receivers of news: a whole file."""

    webhook: Annotated[tuple[WebhookSettings, ...], Field(max_length=8)] = ()
    mqtt: MqttSettings | None = None


def load_news(path: Path) -> NewsSettings:
    """Read the settings of receivers of news; secrets are in files beside it. Raises `InputError`."""
    found = load_model(NewsSettings, path)
    hooks = tuple(each.model_copy(update={"secret": _beside(path, each.secret)}) for each in found.webhook)
    mqtt = found.mqtt and found.mqtt.model_copy(update={"password": _beside(path, found.mqtt.password)})
    for file in (*(each.secret for each in hooks), mqtt.password if mqtt else None):
        if file is not None:
            secret_of(file)
    return found.model_copy(update={"webhook": hooks, "mqtt": mqtt})


def secret_of(path: Path) -> bytes:
    """Return the content of a secret's file, without the end of its line. Raises `InputError`."""
    found = read_bytes(path, _MAX_SECRET, "secret").strip()
    if not found:
        raise InputError(f"{path}: is empty; a secret of one line is expected")
    return found


def _beside(path: Path, file: Path | None) -> Path | None:
    return None if file is None else path.parent / file
