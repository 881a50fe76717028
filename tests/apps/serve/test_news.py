"""News for other programs, their signature and their topics; a receiver that is slow or away delays nothing."""

from __future__ import annotations

import hashlib
import hmac
import importlib.util
import json
import os
import queue
import signal
import socket
import struct
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

from cablewright.apps.serve.notices import senders
from cablewright.apps.serve.notices.news import NewsWatch
from cablewright.apps.serve.notices.senders import SIGNATURE, WAITING, Webhook
from cablewright.apps.serve.notices.settings import MqttSettings, WebhookSettings, load_news
from cablewright.foundation.errors import InputError
from served import client, served

SITTING = {"sitting": 2, "machine": "shed", "robot": "house-printer", "run": "r", "path": {"layers": 9}}
NEWS = {"what": "layer", "layer": 3}


def state(name: str, layer: int = 0, **more: Any) -> dict[str, Any]:
    return {"sitting": 2, "state": name, "reason": "", "layer": layer, "utc": 1.0, "fresh": False, "events": []} | more


def reported(*states: dict[str, Any]) -> list[tuple[str, Any]]:
    watching = NewsWatch()
    return [(each["what"], each["state"]) for one in states for each in watching.look(one, SITTING)]


def test_layers_pauses_and_faults_are_reported_once() -> None:
    states = [
        state("fault", fresh=True), state("off"), state("idle"), state("ready"), state("printing", 1),
        state("printing", 1), state("printing", 2), state("paused", 2), state("paused", 2), state("ready", 2),
        state("printing", 2), state("printing", 4), state("fault", 4), state("fault", 4), state("off"),
    ]  # fmt: skip
    layer = ("layer", "printing")
    assert reported(*states) == [layer, layer, ("pause", "paused"), layer, ("fault", "fault")]
    assert reported(state("fault", fresh=True)) == []
    assert reported({"sitting": 0, "state": "closed"}) == []


def test_the_end_of_a_run_is_reported_though_its_last_state_was_not_seen() -> None:
    watching = NewsWatch()
    before = [[7, 1.0, "run", "run a ends: finished"]]
    assert watching.look(state("printing", events=before), SITTING) == []  # what was before is not new
    ended = [*before, [8, 2.0, "run", "run b ends: stopped"], [9, 2.0, "order", "jog by Ann"]]
    (news,) = watching.look(state("fault", fresh=True, events=ended, sitting=3), SITTING | {"sitting": 3})
    assert (news["what"], news["run"], news["status"]) == ("end", "b", "stopped")
    assert (news["machine"], news["layers"]) == ("shed", 9)
    assert watching.look(state("fault", fresh=True, events=ended, sitting=3), SITTING | {"sitting": 3}) == []


def test_a_file_names_who_gets_what(tmp_path: Path) -> None:
    file = tmp_path / "news.toml"
    (tmp_path / "hook.key").write_text("secret\n")
    file.write_text(
        'schema = 1\n[[webhook]]\naddress = "https://example.org/hook"\nsecret = "hook.key"\nwhat = ["fault", "end"]\n'
        '[mqtt]\nhost = "127.0.0.1"\nuser = "shed"\npassword = "hook.key"\n'
    )
    found = load_news(file)
    assert found.webhook[0].secret == tmp_path / "hook.key"
    assert found.webhook[0].what == ("fault", "end")
    assert found.mqtt is not None
    assert found.mqtt.topic == "cablewright"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('[[webhook]]\naddress = "https://u:p@example.org/"\n', "addresses stay in logs"),
        ('[[webhook]]\naddress = "https://example.org/?token=x"\n', "addresses stay in logs"),
        ('[[webhook]]\naddress = "ftp://example.org/"\n', "HOST"),
        ('[[webhook]]\naddress = "http://example.org:99999/"\n', "HOST"),
        ('[[webhook]]\naddress = "http://example.org/h\u00f6ok"\n', "HOST"),
        ('[[webhook]]\naddress = "http://example.org/a b"\n', "HOST"),
        ('[[webhook]]\naddress = "http://x/"\nsecret = "none.key"\n', "none.key"),
        ('[[webhook]]\naddress = "http://x/"\nwhat = ["start"]\n', "what"),
        ('[mqtt]\nhost = "x"\ntopic = "a/#"\n', "topic"),
        ('[mqtt]\nhost = "x"\npassword = "none.key"\n', "tls"),
    ],
)
def test_secrets_in_addresses_and_wrong_keys_are_rejected_by_name(tmp_path: Path, text: str, why: str) -> None:
    (tmp_path / "news.toml").write_text("schema = 1\n" + text)
    with pytest.raises(InputError, match=why):
        load_news(tmp_path / "news.toml")


@contextmanager
def hooked(status: int = 204, wait: float = 0.0) -> Iterator[tuple[str, queue.Queue[tuple[Any, bytes]]]]:
    """Address of a receiver of webhooks that answers so, and its requests."""
    got: queue.Queue[tuple[Any, bytes]] = queue.Queue()

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            got.put((dict(self.headers), self.rfile.read(int(self.headers["Content-Length"]))))
            time.sleep(wait)
            self.send_response(status)
            self.send_header("Location", "/elsewhere")
            self.end_headers()

        do_GET = do_POST  # noqa: N815

        def log_message(self, *_given: Any) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/hook", got
    finally:
        server.shutdown()
        server.server_close()


def test_a_webhook_gets_signed_news(tmp_path: Path) -> None:
    (tmp_path / "key").write_bytes(b"secret\n")
    with hooked() as (address, got):
        hook = Webhook(WebhookSettings(address=address, secret=tmp_path / "key"))
        assert hook.put(NEWS)
        headers, body = got.get(timeout=10)
    assert json.loads(body) == NEWS
    assert headers[SIGNATURE] == "sha256=" + hmac.new(b"secret", body, hashlib.sha256).hexdigest()


@pytest.mark.parametrize("status", [500, 302])
def test_a_webhook_that_fails_or_leads_elsewhere_gets_the_next_news_too(
    status: int, caplog: pytest.LogCaptureFixture
) -> None:
    with hooked(status) as (address, got):
        hook = Webhook(WebhookSettings(address=address))
        for number in (1, 2):
            assert hook.put({"what": "layer", "layer": number})
            assert json.loads(got.get(timeout=10)[1])["layer"] == number
        assert got.empty()  # no redirection is followed
    assert [each.message.partition(": ")[2] for each in caplog.records] == [f"it answers {status}"]  # once


def test_a_webhook_whose_host_is_no_name_is_complained_about(caplog: pytest.LogCaptureFixture) -> None:
    hook = Webhook(WebhookSettings(address="http://example..org/"))
    for _ in range(2):
        assert hook.put(NEWS)
    end = time.monotonic() + 10.0
    while not (caplog.records and hook._queue.empty()):  # its thread goes on
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_webhook_that_hangs_delays_no_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(senders, "TIME", 0.3)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        hook = Webhook(WebhookSettings(address=f"http://127.0.0.1:{silent.getsockname()[1]}/"))
        began = time.monotonic()
        taken = [hook.put(NEWS) for _ in range(WAITING + 20)]
        assert time.monotonic() - began < 0.2
        assert sum(taken) in (WAITING, WAITING + 1)  # one may be under way
        silent.settimeout(5.0)
        for _ in range(2):  # the second one comes once the first had its time
            silent.accept()[0].close()


needs_mqtt = pytest.mark.skipif(importlib.util.find_spec("paho") is None, reason="the extra mqtt is not installed")


def _packet(connection: socket.socket) -> tuple[int, bytes]:
    """One packet of MQTT 3.1.1: its type and flags, and its body."""
    kind, length, shift = connection.recv(1)[0], 0, 0
    while True:
        byte = connection.recv(1)[0]
        length |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            return kind, connection.recv(length, socket.MSG_WAITALL)


@needs_mqtt
def test_a_broker_gets_news_by_their_topic() -> None:
    from cablewright.apps.serve.notices.senders import Mqtt

    with socket.create_server(("127.0.0.1", 0)) as broker:
        made = Mqtt(MqttSettings(host="127.0.0.1", port=broker.getsockname()[1], topic="shed/printer"))
        assert made.put(NEWS)  # before the broker has answered
        broker.settimeout(10.0)
        connection, _ = broker.accept()
        connection.settimeout(10.0)
        kind, body = _packet(connection)
        assert (kind >> 4, body[2:6]) == (1, b"MQTT")
        connection.sendall(b"\x20\x02\x00\x00")
        kind, body = _packet(connection)
        (length,) = struct.unpack_from(">H", body)
        assert kind >> 4 == 3
        assert body[2 : 2 + length] == b"shed/printer/layer"
        assert json.loads(body[4 + length :]) == NEWS  # after the number of the message
        connection.sendall(b"\x40\x02" + body[2 + length : 4 + length])
        made._client.loop_stop()
        connection.close()


@needs_mqtt
def test_a_wrong_password_is_reported(caplog: pytest.LogCaptureFixture) -> None:
    from cablewright.apps.serve.notices.senders import Mqtt

    with socket.create_server(("127.0.0.1", 0)) as broker:
        made = Mqtt(MqttSettings(host="127.0.0.1", port=broker.getsockname()[1]))
        broker.settimeout(10.0)
        connection, _ = broker.accept()
        connection.settimeout(10.0)
        _packet(connection)
        connection.sendall(b"\x20\x02\x00\x05")
        end = time.monotonic() + 10.0
        while not caplog.messages and time.monotonic() < end:
            time.sleep(0.02)
        made._client.loop_stop()
        connection.close()
    assert any("127.0.0.1: the broker rejects the connection: Not authorized" in each for each in caplog.messages)


@needs_mqtt
def test_a_broker_that_is_away_delays_no_one() -> None:
    from cablewright.apps.serve.notices.senders import Mqtt

    with socket.create_server(("127.0.0.1", 0)) as away:
        port = away.getsockname()[1]
    made, began = Mqtt(MqttSettings(host="127.0.0.1", port=port)), time.monotonic()
    taken = [made.put(NEWS) for _ in range(WAITING + 20)]
    assert time.monotonic() - began < 1.0
    assert taken == [True] * WAITING + [False] * 20
    made._client.loop_stop()


@pytest.mark.clock
def test_a_server_that_starts_again_without_its_secret_still_stops_the_machine(tmp_path: Path) -> None:
    pytest.importorskip("starlette")
    (tmp_path / "hook.key").write_text("secret\n")
    file = tmp_path / "news.toml"
    file.write_text('schema = 1\n[[webhook]]\naddress = "http://127.0.0.1:9/"\nsecret = "hook.key"\n')
    with served(tmp_path / "out", "house-printer", "--news", str(file), ready=False) as server:
        with client(server) as page:
            page.until(lambda state: state.get("state") is not None)
        (tmp_path / "hook.key").unlink()
        os.kill(server.server(), signal.SIGKILL)
        end, stopped = time.monotonic() + 30.0, 0
        while stopped != 202:
            assert time.monotonic() < end
            time.sleep(0.2)
            with suppress(OSError):
                stopped, _, _ = server.ask("POST", "/stop")
        time.sleep(2.0)
        assert server.ask("GET", "/jobs")[0] == 200
    assert any("nothing is sent any more, news: " in each and "hook.key" in each for each in server.said)
