"""Process of the page's server: `python -m cablewright.apps.serve.server`, started by `launch`.

Its configuration is a line of JSON on the standard input, and it ends with that input: when the control ends.
"""

from __future__ import annotations

import asyncio
import json
import os
import resource
import signal
import socket
import sys
import threading
from pathlib import Path
from typing import Any

import uvicorn

from cablewright.apps.serve.access import Access
from cablewright.apps.serve.application import Page
from cablewright.apps.serve.checks import Checks
from cablewright.apps.serve.connections import protocol_with
from cablewright.apps.serve.feed import Feed
from cablewright.apps.serve.operators import Operators
from cablewright.apps.serve.slicers.keys import Keys
from cablewright.apps.serve.uploads import Uploads
from cablewright.live.serve.link import ServerLink

_NICE = 5
_MAX_MESSAGE = 4096  # bytes of a socket's message
_MAX_FILES = 8192  # with connections whose TLS is not negotiated yet, which are not counted
_AGREEING = 5.0  # s for TLS


class _Loop(asyncio.SelectorEventLoop):
    """A loop whose servers wait little for who opens a connection and says nothing."""

    async def create_server(self, *given: Any, **options: Any) -> asyncio.Server:
        """Create a server as asyncio does, with a limit of time for TLS."""
        limit = {"ssl_handshake_timeout": _AGREEING} if options.get("ssl") else {}
        return await super().create_server(*given, **options | limit)


def page_of(given: dict[str, Any]) -> Page:
    """Return the web application of the operator's page for a configuration."""
    folder = Path(given["folder"])
    link = ServerLink.of(*(given[name] for name in ("state", "sitting", "lease", "orders", "stops")))
    access = Access(
        bytes.fromhex(given["key"]),
        bytes.fromhex(given["token"]),
        frozenset(given["hosts"]),
        given["port"],
        given["certificate"] is not None,
    )
    operators, uploads = Operators(), Uploads(folder)
    return Page(
        access=access,
        link=link,
        feed=Feed(link, operators, folder),
        operators=operators,
        uploads=uploads,
        checks=Checks(uploads),
        keys=Keys(folder),
        camera=given["camera"],
        news=None if given["news"] is None else Path(given["news"]),
        ros2=given["ros2"],
    )


def main() -> None:
    """Run the server of the operator's page until the control ends."""
    given = json.loads(sys.stdin.buffer.readline())
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the control decides
    os.nice(_NICE)

    def end_with_control() -> None:
        while os.read(0, 1024):  # not by sys.stdin, whose lock the interpreter wants as it ends
            pass
        os._exit(0)

    threading.Thread(target=end_with_control, daemon=True).start()
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft < _MAX_FILES:
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, _MAX_FILES), hard))
    page = page_of(given)
    config = uvicorn.Config(
        page.application(),
        http=protocol_with(page.connections),
        log_level="error",
        access_log=False,
        server_header=False,
        date_header=False,
        proxy_headers=False,
        ws="websockets-sansio",
        ws_max_size=_MAX_MESSAGE,
        ws_max_queue=16,
        ws_ping_interval=5.0,
        ws_ping_timeout=10.0,
        ws_per_message_deflate=False,
        backlog=128,
        timeout_keep_alive=10,
        ssl_certfile=given["certificate"],
        ssl_keyfile=given["certificate_key"],
    )
    with asyncio.Runner(loop_factory=_Loop) as runner:
        runner.run(uvicorn.Server(config).serve(sockets=[socket.socket(fileno=given["listen"])]))


if __name__ == "__main__":
    main()
