"""The live log: by a small client of its own, and by Foxglove's reference client where that is installed."""

from __future__ import annotations

import json
import shutil
import struct
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("starlette")

from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from cases import some
from served import Served, client

TOOL = Path(__file__).parents[3] / "tools" / "foxglove"
EXPECTED = {"/encoders", "/command", "/estimate", "/progress", "/frame", "/tf", "/scene", "/barrier"}


def read(server: Served, protocol: str, patience: float = 30.0) -> dict[str, list[tuple[int, Any]]]:
    """Messages of all topics, with their times, by topic, until there are some of each."""
    topics: dict[int, str] = {}
    found: dict[str, list[tuple[int, Any]]] = {}
    with connect(server.view, subprotocols=[protocol], max_size=1 << 24) as socket:
        assert socket.subprotocol == protocol
        assert json.loads(socket.recv())["op"] == "serverInfo"
        end = time.monotonic() + patience
        while time.monotonic() < end and not all(len(found.get(topic, ())) > 5 for topic in EXPECTED):
            try:
                message = socket.recv(timeout=0.3)
            except TimeoutError:
                continue
            if isinstance(message, str):
                given = json.loads(message)
                assert given["op"] == "advertise"
                for channel in given["channels"]:
                    assert channel["encoding"] == "json"
                    assert json.loads(channel["schema"])["title"] == channel["schemaName"]
                    topics[channel["id"] + 100] = channel["topic"]
                    wanted = {"id": channel["id"] + 100, "channelId": channel["id"]}
                    socket.send(json.dumps({"op": "subscribe", "subscriptions": [wanted]}))
            else:
                kind, number, stamp = struct.unpack_from("<BIQ", message)
                assert kind == 1
                found.setdefault(topics[number], []).append((stamp, json.loads(message[13:])))
    return found


@pytest.mark.parametrize("protocol", ["foxglove.websocket.v1", "foxglove.sdk.v1"])
def test_both_names_of_the_protocol_are_served(server: Served, protocol: str) -> None:
    found = read(server, protocol)
    assert found.keys() >= EXPECTED
    times = [stamp for stamp, _ in found["/estimate"]]
    assert times == sorted(set(times))
    assert abs(times[-1] / 1e9 - time.time()) < 60.0
    scene = [entity["id"] for _, message in found["/scene"] for entity in message["entities"]]
    assert {"frame", "platform", "lines"} <= set(scene)
    frames = {each["child_frame_id"] for _, message in found["/tf"] for each in message["transforms"]}
    assert "drum" in frames


def test_nothing_is_taken_from_it(server: Served) -> None:
    with connect(server.view, subprotocols=["foxglove.sdk.v1"]) as socket, client(server) as watching:
        for foul in ("{", "[]", '{"op": "subscribe", "subscriptions": 7}', '{"op": "setParameters"}'):
            socket.send(foul)
        socket.send('{"op": "advertise", "channels": [{"id": 1, "topic": "/order"}]}')
        watching.during(0.3)
        assert watching.operator is None
    for address in (server.view[:-1], server.view[:-1] + "x"):
        with pytest.raises(InvalidStatus):
            connect(address, subprotocols=["foxglove.sdk.v1"])
    with pytest.raises(InvalidStatus):
        connect(server.view, subprotocols=["foxglove.sdk.v1"], origin="https://evil.example")
    view = server.view.rpartition("/")[2]
    assert server.ask("GET", "/jobs", authorization=f"Bearer {view}")[0] == 401


@pytest.mark.skipif(
    shutil.which("node") is None or not (TOOL / "node_modules").is_dir(), reason="needs npm ci in tools/foxglove"
)
@pytest.mark.parametrize("protocol", some(["foxglove.websocket.v1", "foxglove.sdk.v1"]))
def test_the_reference_client_reads_it(server: Served, protocol: str) -> None:
    command = ["node", "read.mjs", server.view, "3", protocol]
    done = subprocess.run(command, cwd=TOOL, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found.keys() >= EXPECTED
    assert found["/tf"]["schema"] == "foxglove.FrameTransforms"
    assert found["/scene"]["schema"] == "foxglove.SceneUpdate"
    assert all(found[topic]["messages"] > 5 for topic in ("/estimate", "/tf", "/scene", "/frame"))
