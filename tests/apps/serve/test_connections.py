"""Connections of strangers: however many there are, a stop and a page with the token get through."""

from __future__ import annotations

import asyncio
import http.client
import json
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress

import pytest

pytest.importorskip("uvicorn")

from cablewright.apps.serve import connections
from cablewright.apps.serve.connections import MAX_OPEN, Connections, Holder
from cases import some
from served import Served, client

MANY = MAX_OPEN + 60
SOON = 2.0  # s


class Wire(asyncio.Transport):
    """A transport of which only whether it is open matters."""

    gone = False

    def is_closing(self) -> bool:
        return self.gone

    def abort(self) -> None:
        self.gone = True


def peer(number: int) -> tuple[str, int]:
    return "127.0.0.1", number


def test_the_oldest_stranger_is_closed_and_no_holder_is() -> None:
    async def enter() -> None:
        made, wires = Connections(), [Wire() for _ in range(MAX_OPEN + 1)]
        for number, wire in enumerate(wires[:MAX_OPEN]):
            made.enter(peer(number), wire)
        assert made.admits(peer(0), Holder.TOKEN)
        made.enter(peer(MAX_OPEN), wires[-1])
        assert [number for number, wire in enumerate(wires) if wire.gone] == [1]

    asyncio.run(enter())


@pytest.mark.parametrize("holder", Holder)
def test_holders_leave_room_for_others(holder: Holder) -> None:
    async def enter() -> None:
        made, wires = Connections(), [Wire() for _ in range(MAX_OPEN)]
        for number, wire in enumerate(wires):
            made.enter(peer(number), wire)
        admitted = [number for number in range(MAX_OPEN) if made.admits(peer(number), holder)]
        assert admitted == list(range(holder.value))
        assert made.admits(peer(0), holder)  # it is one already
        wires[0].abort()
        assert made.admits(peer(holder.value), holder)

    asyncio.run(enter())
    assert sum(each.value for each in Holder) < MAX_OPEN


def test_a_stranger_has_little_time_and_a_holder_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connections, "STRANGERS_TIME", 0.02)

    async def enter() -> None:
        made, stranger, holder = Connections(), Wire(), Wire()
        made.enter(peer(1), stranger)
        made.enter(peer(2), holder)
        assert made.admits(peer(2), Holder.KEY)
        await asyncio.sleep(0.1)
        assert (stranger.gone, holder.gone) == (True, False)

    asyncio.run(enter())


@contextmanager
def opened(server: Served, number: int, begin: bytes = b"") -> Iterator[list[socket.socket]]:
    """So many connections on which nothing comes after *begin*."""
    with ExitStack() as stack:
        sockets = [stack.enter_context(socket.create_connection(("127.0.0.1", server.port))) for _ in range(number)]
        for each in sockets:
            each.sendall(begin)
        yield sockets


@pytest.mark.clock
@pytest.mark.parametrize(
    "begin", some([b"", b"POST /stop HTTP/1.1\r\nHost: x\r\n", b"GET /api/version HTTP/1.1\r\n"], 2)
)
def test_a_stop_and_a_page_get_through_many_silent_connections(server: Served, begin: bytes) -> None:
    with client(server) as page:
        page.ready()
        with opened(server, MANY, begin):
            assert server.ask("GET", "/jobs")[0] == 200  # by the token, as a page that is opened now
            began = time.monotonic()
            assert server.ask("POST", "/stop")[0] == 202
            assert time.monotonic() - began < SOON
            page.until(lambda state: state["state"] == "fault", 10.0)
            with client(server) as other:
                other.send(t="stop")
                other.until(lambda state: state["state"] == "fault", 10.0)


@pytest.mark.clock
def test_a_stop_gets_through_the_requests_of_the_token_itself(server: Served) -> None:
    body = f"POST /jobs HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nAuthorization: Bearer {server.token}\r\n"
    with opened(server, MAX_OPEN, f"{body}Content-Length: 9\r\n\r\n".encode()) as sockets:
        assert server.ask("POST", "/stop")[0] == 202
        time.sleep(0.5)
        refused = 0
        for each in sockets:
            each.settimeout(0.0)
            with suppress(BlockingIOError):
                try:
                    answer = each.recv(64)  # nothing: closed as a stranger's, before its request was read
                    refused += not answer or answer.startswith(b"HTTP/1.1 503")
                except ConnectionError:
                    refused += 1
        assert refused >= MAX_OPEN - Holder.TOKEN.value


@pytest.mark.clock
def test_a_stranger_is_rejected_without_reading_the_rest(server: Served) -> None:
    with socket.create_connection(("127.0.0.1", server.port)) as slow:
        head = f"POST /api/files/local HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nX-Api-Key: wrong\r\n"
        slow.sendall(f"{head}Content-Type: multipart/form-data\r\nContent-Length: {1 << 30}\r\n\r\n".encode())
        slow.settimeout(10.0)
        began, answer = time.monotonic(), b""
        closed = False
        while not closed and time.monotonic() - began < 10.0:
            with suppress(BlockingIOError):
                try:
                    slow.setblocking(True)
                    slow.sendall(b"x" * 1000)
                    slow.setblocking(False)
                    answer += slow.recv(4096)
                except ConnectionError:
                    closed = True
            time.sleep(0.05)
        assert closed
        assert answer.startswith(b"HTTP/1.1 401")
        assert b"make one on the page" in answer
        assert time.monotonic() - began < 5.0


@pytest.mark.clock
def test_a_slicer_that_has_a_key_stops_beyond_every_limit(server: Served) -> None:
    from served import make_key

    key = make_key(server)
    slicer = http.client.HTTPConnection("127.0.0.1", server.port, timeout=20)
    with client(server) as page, closing(slicer) as connection:
        page.ready()
        for _ in range(1000):  # until its rate allows no more
            connection.request("GET", "/api/version", headers={"x-api-key": key})
            last = connection.getresponse()
            last.read()
            if last.status == 429:
                break
        status, text, _ = server.ask("POST", "/printer/emergency_stop", x_api_key=key)
        assert (status, json.loads(text)) == (200, {"result": "ok"})
        page.until(lambda state: state["state"] == "fault", 10.0)
