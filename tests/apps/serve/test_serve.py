"""`cablewright serve` by its protocol: who gets in, who may do what, and what becomes of who is gone."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import struct
import sys
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("starlette")

from websockets.exceptions import InvalidStatus

from cablewright.live.serve.jobs import JobCheck, subject_of, write_check
from cablewright.robot import load
from served import RING, Served, client

pytestmark = [pytest.mark.clock, pytest.mark.skipif(sys.platform != "linux", reason="looks at processes in /proc")]

ROOT = Path(__file__).parents[3]
ACCELERATION = 0.2  # m/s^2, of motions by hand


def test_foreign_hosts_and_origins_are_rejected(server: Served) -> None:
    bearer = {"authorization": f"Bearer {server.token}"}
    assert server.ask("GET", "/jobs", **bearer)[0] == 200
    for host in ("evil.example", f"evil.example:{server.port}", "127.0.0.1", f"localhost.evil:{server.port}", ""):
        assert server.ask("GET", "/jobs", host=host, **bearer)[0] == 421
    assert server.ask("GET", "/jobs", host=f"LOCALHOST:{server.port}", **bearer)[0] == 200
    for origin in ("https://evil.example", "null", "http://127.0.0.1", f"https://127.0.0.1:{server.port}"):
        assert server.ask("POST", "/stop", origin=origin, **bearer)[0] == 403
    cookie = server.cookie()
    for origin in ("https://evil.example", None):
        with pytest.raises(InvalidStatus), client(server, cookie, origin=origin):
            pass


def test_nothing_is_served_without_the_token(server: Served) -> None:
    for path in ("/jobs", "/runs", "/scene", "/static/main.js"):
        status, text, _ = server.ask("GET", path, accept="*/*")
        assert status == 401
        assert "token" in text
    assert "Enter the token" in server.ask("GET", "/", accept="*/*")[1]
    assert server.ask("POST", "/stop", origin=server.origin)[0] == 401
    assert server.ask("POST", "/enter", "an old token", origin=server.origin)[0] == 401
    old = f"cablewright-{server.port}={'0' * 16}.{'0' * 64}"
    assert server.ask("GET", "/jobs", cookie=old)[0] == 401
    status, _, headers = server.ask("POST", "/enter", server.token, origin=server.origin)
    assert status == 200
    assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= set(headers["set-cookie"].split("; "))
    assert server.token not in headers["set-cookie"]
    assert server.token not in "".join(server.said)


def test_a_request_by_cookie_that_changes_something_names_its_origin(server: Served) -> None:
    cookie = server.cookie()
    assert server.ask("POST", "/close", "{}", cookie=cookie)[0] == 403
    assert server.ask("GET", "/jobs", cookie=cookie)[0] == 200


def test_every_answer_has_a_strict_policy(server: Served) -> None:
    for path in ("/", "/jobs", "/enter", "/nothing"):
        headers = {name.lower(): value for name, value in server.ask("GET", path)[2].items()}
        assert headers["content-security-policy"].startswith("default-src 'none'; script-src 'self';")
        assert "unsafe" not in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff"
    headers = server.ask("GET", "/runs/x/report")[2]
    assert headers["content-security-policy"].startswith("sandbox allow-scripts; default-src 'none'")


def test_one_operates_and_all_may_stop(server: Served) -> None:
    with client(server) as first, client(server) as second:
        first.ready()
        assert "operates the machine" in second.take("Bob")
        assert second.order("release") == "you do not operate the machine"
        second.jog((0.1, 0.0, 0.0), 1)
        second.during(0.3)
        assert second.told[-1] == {"t": "jog", "refusal": "you do not operate the machine"}
        first.hold((0.1, 0.0, 0.0), 0, lambda state: state["state"] == "manual")
        second.send(t="stop")
        second.until(lambda state: state["state"] == "fault")
        assert second.state["reason"] == "emergency stop"
        first.jog((0.1, 0.0, 0.0), 1 << 20)
        first.during(0.3)
        assert first.state["state"] == "fault"
    orders = [json.loads(line) for line in (server.folder / "orders.jsonl").read_text().splitlines()]
    assert any(each["order"] == "emergency stop" and "page" in each["by"] for each in orders)
    assert any(each["order"] == "jog" and each["by"].startswith("Ann") for each in orders)


def test_stop_by_a_plain_request_and_after_a_reconnect(server: Served) -> None:
    with client(server) as first:
        first.ready()
    status, text, _ = server.ask("POST", "/stop", "")
    assert (status, text) == (202, "stop was sent\n")
    with client(server) as again:
        again.until(lambda state: state.get("state") == "fault")
        again.ready()
        assert again.order("emergency stop") == ""
        again.until(lambda state: state["state"] == "fault")


def test_a_jog_that_was_sent_before_is_not_obeyed_again(server: Served) -> None:
    with client(server) as first:
        first.ready()
        number = first.hold((0.0, 0.05, 0.0), 10, lambda state: state["state"] == "manual")
        first.until(lambda state: state["state"] == "idle")
        place = first.state["platform"]["position"]
        for _ in range(10):
            first.jog((0.0, 0.05, 0.0), number)  # as it was
            number += 1
            first.jog((0.0, 0.05, 0.0), number, beat=first.beat - 1000)  # of a state that is old
            first.during(0.05)
        assert first.state["state"] == "idle"
        assert np.allclose(first.state["platform"]["position"], place, atol=2e-4)
        assert "after the state that you saw" in first.told[-1]["refusal"]


def test_a_socket_that_dies_in_a_jog_ends_it_within_its_lease_and_distance(server: Served) -> None:
    speed = 0.1
    with client(server) as watching:
        with client(server) as first:
            first.ready()
            wanted = 0.98 * speed
            number = first.hold((speed, 0.0, 0.0), 0, lambda state: state["platform"]["velocity"][0] > wanted)
            end = first.state["time"] + 0.5
            first.hold((speed, 0.0, 0.0), number, lambda state: state["time"] > end)
            raw = first.socket.socket  # killed: no closing words, as of a browser that is gone
            raw.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            os.close(raw.detach())
        watching.until(lambda state: state.get("state") == "idle")
        watching.during(1.0)
    known = [state for state in watching.states if "platform" in state]
    last = max(state["jogged"] for state in known if state["jogged"] is not None)
    wound = np.array([np.abs(state["speeds"]).max() for state in known])
    times = np.array([state["time"] for state in known])
    steady = np.median(wound[(times > last - 0.3) & (times <= last)])
    slower = np.flatnonzero((times > last) & (wound < 0.95 * steady))[0]
    began = times[slower] - (1.0 - wound[slower] / steady) * speed / ACCELERATION
    assert began - last <= 0.25
    places = np.array([state["platform"]["position"][0] for state in known])
    at_last = np.interp(last, times, places)
    assert places[-1] - at_last <= speed * 0.25 + speed**2 / (2.0 * ACCELERATION) + 5e-3
    assert watching.operator is None


def test_jobs_name_nothing_but_their_own_files(server: Served) -> None:
    with client(server) as first:
        assert first.take() == ""
        bearer = {"authorization": f"Bearer {server.token}", "x-page": first.page}
        status, text, _ = server.ask("POST", "/jobs", json.dumps({"name": "../../etc/passwd\n"}), **bearer)
        assert status == 200
        number = json.loads(text)["id"]
        for path in (f"/jobs/{number}/../x", f"/jobs/{number}/about.json", "/jobs/%2e%2e/settings", "/jobs/0/gcode"):
            assert server.ask("PUT", path, "x", **bearer)[0] in (404, 405, 409), path
        evil = RING.split("[helix]")[0] + 'gcode = "/etc/hostname"\n'
        assert server.ask("PUT", f"/jobs/{number}/settings", evil, **bearer)[0] == 200
        assert server.ask("PUT", f"/jobs/{number}/settings", evil, **bearer)[0] == 409
        assert server.ask("POST", f"/jobs/{number}/check", "", **bearer)[0] == 200
        status, text, _ = server.ask("POST", f"/jobs/{number}/load", "{}", **bearer)
        assert (status, text.strip()) == (409, "load: it was not checked yet")
        end = time.monotonic() + 180
        while (found := json.loads(server.ask("GET", "/jobs")[1])[0])["check"] is None or found["busy"]:
            assert time.monotonic() < end
            first.during(0.3)
        assert found["check"]["answer"] == "failed"
        assert "names a path" in found["check"]["why"]
        status, text, _ = server.ask("POST", f"/jobs/{number}/load", "{}", **bearer)
        assert status == 409
        assert "names a path" in text
        assert server.ask("DELETE", f"/jobs/{number}", **bearer)[0] == 200
    assert server.ask("POST", "/jobs", "{}", **bearer)[0] == 403  # whose page has gone


def test_a_file_that_is_too_large_is_rejected_by_name(server: Served) -> None:
    with client(server) as first:
        assert first.take() == ""
        bearer = {"authorization": f"Bearer {server.token}", "x-page": first.page}
        number = json.loads(server.ask("POST", "/jobs", '{"name": "huge"}', **bearer)[1])["id"]
        status, text, _ = server.ask("PUT", f"/jobs/{number}/settings", b"#" * (65 << 10), **bearer)
        assert (status, text.strip()) == (413, "settings of 'huge': too large; at most 64 KiB")
        assert not (server.folder / "jobs" / number / "job.toml").exists()
        assert server.ask("DELETE", f"/jobs/{number}", **bearer)[0] == 200


def test_a_dead_server_changes_nothing_and_is_started_again(server: Served) -> None:
    cookie = server.cookie()
    with client(server, cookie) as first:
        first.ready()
        steps = first.state["steps"]
        os.kill(server.server(), signal.SIGKILL)
    end = time.monotonic() + 30
    while True:
        try:
            if server.ask("GET", "/jobs", cookie=cookie)[0] == 200:  # whoever was let in still is
                break
        except OSError:
            pass
        assert time.monotonic() < end
        time.sleep(0.1)
    with client(server, cookie) as again:
        again.until(lambda state: state.get("steps", 0) > steps)
        assert again.state["state"] == "idle"
        assert again.operator is None
        assert again.take() == ""


def test_a_job_is_loaded_only_after_its_check_and_a_run_whose_folder_goes_ends(server: Served) -> None:
    with client(server) as first:
        first.until(lambda state: state.get("state") not in (None, "closed"))
        assert first.take() == ""
        own = {"authorization": f"Bearer {server.token}", "x-page": first.page}
        number = json.loads(server.ask("POST", "/jobs", '{"name": "ring"}', **own)[1])["id"]
        assert server.ask("PUT", f"/jobs/{number}/settings", RING, **own)[0] == 200
        folder = server.folder / "jobs" / number
        subject = subject_of(folder, load("house-printer"))
        write_check(folder, JobCheck(subject=subject, answer="no", why="too heavy"))
        status, text, _ = server.ask("POST", f"/jobs/{number}/load", "{}", **own)
        assert (status, text.strip()) == (409, "load: its check said no, and no operator confirmed this: too heavy")
        before = first.state["sitting"]
        confirmed = json.dumps({"confirmed": subject})
        assert server.ask("POST", f"/jobs/{number}/load", confirmed, **own)[0] == 200
        first.until(lambda state: state["sitting"] > before and state["state"] == "fault")
        first.until(lambda _: (first.sitting.get("job") or {}).get("id") == number)
        first.ready()
        assert server.ask("DELETE", f"/jobs/{number}", **own)[0] == 409  # it is in use
        assert first.order("start") == ""
        first.until(lambda state: state["state"] == "ready")
        assert "not at rest" in server.ask("POST", "/close", "{}", **own)[1]
        run = first.sitting["run"]
        shutil.rmtree(server.folder / "runs" / run)
        first.until(lambda state: state["state"] == "closed")
        assert "cannot be written" in first.state["reason"]
        assert server.ask("GET", f"/runs/{run}/report")[0] == 404
        first.during(0.1)
        assert server.ask("POST", "/close", "{}", **own)[0] == 200  # it is opened again
        first.until(lambda state: state["state"] == "fault" and state["reason"] == "not reset since it was started")
        assert server.ask("DELETE", f"/jobs/{number}", **own)[0] == 200


def test_a_port_in_use_is_named(server: Served, tmp_path: Path, cli) -> None:
    done = cli("serve", "house-printer", "--port", server.port, "--out", tmp_path / "x")
    assert done.code == 3
    assert done.err.startswith(f"cablewright: serve: port {server.port} of 127.0.0.1 cannot be had:")


def test_two_of_one_folder(server: Served, cli) -> None:
    done = cli("serve", "house-printer", "--port", 0, "--out", server.folder)
    assert done.code == 3
    assert done.err.endswith("another program works in this folder\n")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--host", "0.0.0.0"), "--host = 0.0.0.0: other computers can read along without TLS: give --certificate"),
        (("--host", "example.org"), "--host = 'example.org': an address of this computer is expected"),
        (("--port", "70000"), "--port = 70000: must be from 0"),
        (("--certificate", "x.pem"), "--certificate and --key: both are needed for TLS, or none"),
        (("--certificate", "x.pem", "--key", "y.pem"), "--certificate = x.pem: No such file"),
        (("--try",), "--try: is only for a machine file with a table [drives]"),
        (("--name", "a b"), "--name = 'a b': a host's name without port is expected"),
        (("--at", "1,2"), "--at = '1,2': expected 3 finite numbers"),
        (("--machine", "nothing"), "no machine 'nothing' in the library"),
    ],
)
def test_bad_input_is_one_line(arguments: tuple[str, ...], said: str, tmp_path: Path, cli) -> None:
    assert cli("serve", "house-printer", *arguments, "--out", tmp_path / "out").refusal.startswith(said)


def test_a_machine_that_is_not_there(tmp_path: Path, cli) -> None:
    text = (ROOT / "examples" / "virtual-drives.toml").read_text().replace('"43113"', '"43197"')
    (tmp_path / "drives.toml").write_text(text)
    done = cli("serve", "merlet2023", "--machine", tmp_path / "drives.toml", "--port", 0, "--out", tmp_path / "out")
    assert done.code == 3
    assert "no drive answers there" in done.err.splitlines()[-1]


def test_no_error_was_missed(server: Served) -> None:
    assert not [line for line in server.said if "Traceback" in line or "Error" in line]
