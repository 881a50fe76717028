"""`serve`: starts the control in this process and the page's server in another one, which is restarted if it ends."""

from __future__ import annotations

import hashlib
import importlib.util
import ipaddress
import json
import logging
import re
import secrets
import socket
import ssl
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

from cablewright.apps.serve.access import Access, new_token
from cablewright.apps.serve.check_worker import write_station
from cablewright.apps.serve.notices.settings import load_news
from cablewright.apps.serve.slicers.keys import Keys
from cablewright.exchange.ros.dds import require_domain
from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.live.prints.run import alone_in, make_folder
from cablewright.live.serve.control_process import Control
from cablewright.live.serve.link import ControlLink
from cablewright.live.serve.operated_machines import Station
from cablewright.machine.settings import MachineSettings
from cablewright.running.locks import locked

_LOOK: Final = 0.5  # s between looks at the server
_AGAIN: Final = 1.0  # s at least between two starts of it
_LIBRARIES: Final = ("starlette", "uvicorn", "websockets")
_HOST: Final = re.compile(r"[A-Za-z0-9.-]{1,253}(:\d{1,5})?")
_PATH: Final = re.compile(r"[A-Za-z0-9/._~%&=?+@:,-]*")
_LOOPBACK: Final = ("localhost", "127.0.0.1", "[::1]")


@dataclass(frozen=True)
class Address:
    """Network address of the page.

    ``names``: host names by which other computers call this one.

    ``certificate`` and ``certificate_key``: files for TLS. ``camera``: address of a picture of the machine, MJPEG or
    still. ``news``: file with the receivers of news on layers, pauses, faults and ends. ``ros2``: number of the domain
    of ROS 2 that gets the machine's state.
    """

    host: str = "127.0.0.1"
    port: int = 8642
    names: tuple[str, ...] = ()
    certificate: Path | None = None
    certificate_key: Path | None = None
    camera: str = ""
    news: Path | None = None
    ros2: int | None = None

    def __post_init__(self) -> None:
        """Raise `InputError` for an address at which the page must not be."""
        try:
            address = ipaddress.ip_address("127.0.0.1" if self.host == "localhost" else self.host)
        except ValueError:
            raise InputError(
                f"--host = {self.host!r}: an address of this computer is expected, such as 127.0.0.1"
            ) from None
        if not 0 <= self.port <= 65535:
            raise InputError(f"--port = {self.port}: must be from 0 (any that is free) to 65535")
        if (self.certificate is None) != (self.certificate_key is None):
            raise InputError("--certificate and --key: both are needed for TLS, or none")
        if not address.is_loopback and self.certificate is None:
            why = "other computers can read along without TLS: give --certificate and --key, or use an SSH tunnel"
            raise InputError(f"--host = {self.host}: {why}")
        if address.is_unspecified and not self.names:
            raise InputError(f"--host = {self.host}: give --name, by which other computers call this one")
        for name in self.names:
            if not name or any(each in name for each in " /:@\\?#") or len(name) > 253:
                raise InputError(f"--name = {name!r}: a host's name without port is expected")
        self._require_certificate()
        if self.camera:
            self._require_camera()
        if self.news is not None and load_news(self.news).mqtt is not None and not importlib.util.find_spec("paho"):
            raise EnvironmentFault("serve: paho-mqtt is not installed: pip install 'cablewright[mqtt]'")
        if self.ros2 is not None:
            require_domain(self.ros2)

    def _require_camera(self) -> None:
        """Reject an address that says more than where a picture is: it is sent to all who watch."""
        start = f"--camera = {self.camera[:80]!r}:"
        try:
            parts = urlsplit(self.camera)
            parts.port  # noqa: B018  # raises where it is none
        except ValueError as reason:
            raise InputError(f"{start} {reason}") from None
        if parts.netloc.startswith("["):
            raise InputError(f"{start} browsers load no picture from an IPv6 address in brackets: give a host's name")
        if parts.scheme not in ("http", "https") or not _HOST.fullmatch(parts.netloc) or len(self.camera) > 300:
            raise InputError(f"{start} http://HOST[:PORT]/PATH is expected, or https, without a name and a password")
        if not _PATH.fullmatch(parts.path + parts.query) or parts.fragment:
            raise InputError(f"{start} letters of an address are expected, without spaces, quotes and #")
        if self.certificate is not None and parts.scheme == "http":
            raise InputError(f"{start} browsers show no picture by http on a page by https: give its https address")

    def _require_certificate(self) -> None:
        if self.certificate is None:
            return
        try:
            ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(str(self.certificate), str(self.certificate_key))
        except (OSError, ssl.SSLError) as reason:
            raise InputError(f"--certificate = {self.certificate}: {reason.strerror or reason}") from None

    @property
    def scheme(self) -> str:
        """URL scheme of the page's addresses: http or https."""
        return "http" if self.certificate is None else "https"

    def hosts(self, port: int) -> frozenset[str]:
        """Host names by which requests may address the server."""
        address = ipaddress.ip_address("127.0.0.1" if self.host == "localhost" else self.host)
        own = () if address.is_unspecified else (f"[{address}]" if address.version == 6 else str(address),)
        known = {*self.names, *own, *(_LOOPBACK if address.is_loopback or address.is_unspecified else ())}
        return frozenset(f"{each.lower()}:{port}" for each in known) | (
            frozenset(each.lower() for each in known) if port in (80, 443) else frozenset()
        )


def require_libraries() -> None:
    """Raise `EnvironmentFault` where the extra ``web`` is missing, or the system cannot share open files."""
    if sys.platform == "win32":
        raise EnvironmentFault(
            "serve: needs Linux or macOS, because the control and the server share sockets; use one of these systems"
        )
    if missing := [name for name in _LIBRARIES if importlib.util.find_spec(name) is None]:
        raise EnvironmentFault(f"serve: {missing[0]} is not installed: pip install 'cablewright[web]'")


def listening(address: Address) -> socket.socket:
    """Return a listening socket at the address. Raises `EnvironmentFault` where it is in use or not available."""
    host = "127.0.0.1" if address.host == "localhost" else address.host
    made = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_STREAM)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((host, address.port))
        made.listen(128)
    except OSError as reason:
        made.close()
        why = f"cannot be had: {reason.strerror or reason}"
        raise EnvironmentFault(f"serve: port {address.port} of {address.host} {why}; --port takes another") from None
    return made


@dataclass(eq=False)
class Server:
    """The process of the page's server, restarted when it ends."""

    link: ControlLink
    folder: Path
    address: Address
    listen: socket.socket
    key: bytes = field(default_factory=lambda: secrets.token_bytes(32))
    token: str = field(default_factory=new_token)
    starts: int = 0
    process: subprocess.Popen[bytes] | None = None
    _over: threading.Event = field(default_factory=threading.Event)

    @property
    def port(self) -> int:
        """Port at which the server listens."""
        return int(self.listen.getsockname()[1])

    @property
    def access(self) -> Access:
        """Access rules of the server."""
        token = hashlib.sha256(self.token.encode()).digest()
        return Access(self.key, token, self.address.hosts(self.port), self.port, self.address.certificate is not None)

    def start(self) -> None:
        """Start the process of the operator's page, on new channels to the control."""
        orders, stops = self.link.connect()
        numbers = {
            "state": self.link.state.file_number,
            "sitting": self.link.sitting.file_number,
            "lease": self.link.told_lease.file_number,
            "orders": orders.fileno(),
            "stops": stops.fileno(),
            "listen": self.listen.fileno(),
        }
        access = self.access
        given: dict[str, Any] = numbers | {
            "key": self.key.hex(),
            "token": access.token.hex(),
            "hosts": sorted(access.hosts),
            "port": self.port,
            "folder": str(self.folder.absolute()),
            "camera": self.address.camera,
            "news": None if self.address.news is None else str(self.address.news.absolute()),
            "ros2": self.address.ros2,
            "certificate": None if self.address.certificate is None else str(self.address.certificate),
            "certificate_key": None if self.address.certificate_key is None else str(self.address.certificate_key),
        }
        self.starts += 1
        self.process = subprocess.Popen(
            [sys.executable, "-m", "cablewright.apps.serve.server"],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            pass_fds=tuple(numbers.values()),
        )
        orders.close()
        stops.close()
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(given).encode() + b"\n")
        self.process.stdin.flush()

    def watch(self) -> None:
        """Restart the server's process whenever it ends, until `end`."""
        begun = time.monotonic()
        while not self._over.wait(_LOOK):
            assert self.process is not None
            code = self.process.poll()
            if code is not None and time.monotonic() - begun > _AGAIN:
                begun = time.monotonic()
                logging.getLogger("cablewright").warning("the page's server has ended (%s); it is started again", code)
                try:
                    self.start()
                except OSError as reason:  # as where there are too many processes: later
                    logging.getLogger("cablewright").warning("the page's server cannot be started: %s", reason)

    def end(self) -> None:
        """End the process of the operator's page."""
        self._over.set()
        if self.process is not None and self.process.stdin is not None:
            self.process.stdin.close()
            try:
                self.process.wait(timeout=5.0)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()


def serve(
    station: Station,
    owner: MachineSettings,
    folder: Path,
    address: Address,
    say: Callable[[str], None],
    lock: Path | None = None,
) -> None:
    """Serve the operator's page until interrupted.

    *owner*: settings of the machine. *lock*: lock file of a real machine. Raises `EnvironmentFault` where the port is
    in use, or another program serves this folder or machine.
    """
    require_libraries()
    make_folder(folder)
    with alone_in(folder), _alone_with(lock):
        _serve(station, owner, folder, address, say)


def _alone_with(lock: Path | None) -> AbstractContextManager[None]:
    """Hold the lock of a machine. Raises `EnvironmentFault` where another program does."""
    return nullcontext() if lock is None else locked(lock, f"{lock}: another program serves this machine")


def _serve(
    station: Station, owner: MachineSettings, folder: Path, address: Address, say: Callable[[str], None]
) -> None:
    listen = listening(address)
    write_station(folder, station.robot, owner)
    Keys(folder)  # a damaged file is rejected here
    interrupted = threading.Event()

    def show() -> None:
        """Print the addresses of the page, once the machine can be operated."""
        host = (address.names or ("127.0.0.1" if address.host == "localhost" else address.host,))[0]
        shown = f"[{host}]" if ":" in host else host
        say(f"{address.scheme}://{shown}:{server.port}/enter#{server.token}")
        socket_scheme = "ws" if address.scheme == "http" else "wss"
        say(f"Foxglove, read only: {socket_scheme}://{shown}:{server.port}/foxglove/{server.access.view_token}")
        say("whoever has the first address may stop the machine and operate it; Ctrl-C stops the machine and ends")

    control = Control(station, ControlLink.new(), folder, interrupted.is_set, show)
    server = Server(control.link, folder, address, listen)
    server.start()
    watching = threading.Thread(target=server.watch, daemon=True)
    watching.start()
    try:
        control.run()
    finally:
        server.end()
        watching.join(timeout=2.0)
        listen.close()
        control.close()
        control.link.close()
