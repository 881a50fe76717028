"""Upload from slicers: the calls of PrusaSlicer, OrcaSlicer and Cura, written from their sources, and what is rejected.

PrusaSlicer and OrcaSlicer: src/slic3r/Utils/OctoPrint.cpp (test, upload), Moonraker.cpp, MoonrakerPrinterAgent.cpp;
Cura: OctoPrintOutputDevice.py of fieldOfView/Cura-OctoPrintPlugin, MoonrakerOutputDevice.py of
emtrax-ltd/Cura2MoonrakerPlugin. Printrun has no upload of its own: it sends files by the same calls of a slicer.
"""

from __future__ import annotations

import json
import resource
import shutil
import socket
import threading
import time
from typing import Any

import pytest

pytest.importorskip("starlette")

from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from cablewright.apps.serve.slicers.keys import FILE, MAX_KEYS, Keys
from cablewright.apps.serve.slicers.machine_view import verdict_of
from cablewright.apps.serve.slicers.multipart_forms import file_name, parsed_form
from cablewright.apps.serve.slicers.slicer_comments import notes_of
from cablewright.apps.serve.uploads import MAX_NOTES
from cablewright.foundation.errors import InputError
from served import BOUNDARY, Served, client, form, make_key, send, sliced

pytestmark = pytest.mark.clock


@pytest.fixture(scope="module")
def key(server: Served) -> str:
    return make_key(server)


def checked(server: Served, key: str, name: str) -> dict[str, Any]:
    """Wait for the verdict, by Moonraker's metadata."""
    end = time.monotonic() + 300.0
    while time.monotonic() < end:
        told = json.loads(server.ask("GET", f"/server/files/metadata?filename={name}", x_api_key=key)[1])["result"]
        if told["cablewright"]["check"] is not None and not told["cablewright"]["busy"]:
            return dict(told)
        time.sleep(0.2)
    raise AssertionError("it was not checked")


def statuses(server: Served, key: str, number: int) -> list[int]:
    """Of so many requests that are sent together, on one connection: a busy computer answers them fast enough too."""
    request = f"GET /api/version HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nX-Api-Key: {key}\r\n\r\n"
    with socket.create_connection(("127.0.0.1", server.port), timeout=60) as sending:
        threading.Thread(target=sending.sendall, args=(request.encode() * number,), daemon=True).start()
        answered = b""
        while answered.count(b"HTTP/1.1 ") < number and b"HTTP/1.1 429" not in answered:
            answered += sending.recv(1 << 16)
    return [int(each[:3]) for each in answered.split(b"HTTP/1.1 ")[1:]]


def test_prusaslicer_and_orcaslicer_upload_by_octoprint(server: Served, key: str) -> None:
    status, text, _ = server.ask("GET", "/api/version", x_api_key=key)
    assert status == 200
    assert "api" in json.loads(text)
    assert json.loads(text)["text"].startswith("OctoPrint")  # or they say: mismatched type of print host
    status, text, headers = send(server, "/api/files/local", key, "square.gcode", sliced(), print="true", path="")
    assert status == 201, text
    assert headers["location"].partition("/api/")[2] == "files/local/square.gcode"  # Cura's plugin splits it there
    told = json.loads(text)
    assert told["done"]
    assert not told["effectivePrint"]  # it was requested, and a person decides
    job = json.loads(server.ask("GET", "/api/job", x_api_key=key)[1])
    assert job["job"]["file"]["name"] == "square.gcode"
    assert job["state"] == "Operational"
    assert "check" in job["message"]  # it waits for it, or is being checked
    flags = json.loads(server.ask("GET", "/api/printer", x_api_key=key)[1])["state"]["flags"]
    assert {"operational", "paused", "printing", "error", "ready", "closedOrError", "pausing", "cancelling"} == set(
        flags
    )
    assert flags["ready"]
    with client(server) as page:
        page.until(lambda state: "state" in state)
        assert page.state["state"] in ("fault", "off", "idle")  # nothing was loaded, nothing moves
        assert page.sitting["job"] is None
        assert not any(page.state.get("speeds", ()))
    kept = json.loads(server.ask("GET", "/jobs")[1])[0]
    assert kept["wants_print"]
    assert "slicer (key" in kept["by"]


def test_verdict_and_expected_error_are_reported_in_words() -> None:
    check: dict[str, Any] = {"answer": "yes", "why": "it can", "expected_error": 8.34e-3}
    job = {"file": "a.gcode", "name": "a", "busy": "", "check": check}
    assert verdict_of(job) == "a.gcode: check says yes; expected error 8.34 mm; a person starts it on the page"
    assert verdict_of(job | {"busy": "waits", "check": None}) == "a.gcode waits for its check"
    no = job | {"check": check | {"answer": "no", "why": "too far", "expected_error": None}}
    assert verdict_of(no) == "a.gcode: check says no: too far"
    assert "could not be checked: bad" in verdict_of(job | {"check": check | {"answer": "failed", "why": "bad"}})
    assert "check it on the page" in verdict_of(job | {"check": None})


@pytest.mark.slow
def test_an_upload_is_checked_and_its_verdict_is_reported(server: Served, key: str) -> None:
    assert send(server, "/api/files/local", key, "checked.gcode", sliced(), print="true")[0] == 201
    found = checked(server, key, "checked.gcode")
    check = found["cablewright"]["check"]
    assert check["answer"] == "yes", check
    assert 0.0 < check["expected_error"] < 0.1
    assert found["estimated_time"] == check["duration"]  # not the slicer's guess
    job = json.loads(server.ask("GET", "/api/job", x_api_key=key)[1])
    assert "check says yes; expected error" in job["message"]
    assert job["job"]["estimatedPrintTime"] == pytest.approx(check["duration"])


def test_cura_and_orcaslicer_upload_by_moonraker(server: Served, key: str) -> None:
    status, text, _ = server.ask("GET", "/printer/info", x_api_key=key, accept="application/json, text/plain")
    assert json.loads(text)["result"]["state"] == "ready"  # Cura waits for it
    info = json.loads(server.ask("GET", "/server/info", x_api_key=key)[1])["result"]
    assert info["klippy_state"] == "ready"
    assert info["machine_name"]
    status, text, _ = send(server, "/server/files/upload", key, "/by cura.gcode", sliced(), root="gcodes", print="true")
    assert status == 201, text
    told = json.loads(text)
    assert told["item"]["path"] == "by cura.gcode"
    assert told["print_started"] is False
    assert told["print_queued"] is True
    found = json.loads(server.ask("GET", "/server/files/metadata?filename=by%20cura.gcode", x_api_key=key)[1])["result"]
    assert (found["slicer"], found["slicer_version"]) == ("PrusaSlicer", "2.9.1")
    assert (found["layer_height"], found["filament_total"]) == (0.6, 12.5)
    assert found["estimated_time"] in (3723.0, (found["cablewright"]["check"] or {}).get("duration"))
    small = found["thumbnails"][0]
    assert (small["width"], small["height"]) == (16, 16)
    status, _, headers = server.ask(
        "GET", f"/server/files/gcodes/{small['relative_path'].replace(' ', '%20')}", x_api_key=key
    )
    assert (status, headers["content-type"]) == (200, "image/png")
    names = [each["path"] for each in json.loads(server.ask("GET", "/server/files/list", x_api_key=key)[1])["result"]]
    assert "by cura.gcode" in names
    asked = server.ask(
        "GET", "/printer/objects/query?print_stats&virtual_sdcard&extruder&heater_bed&fan", x_api_key=key
    )
    status_told = json.loads(asked[1])["result"]["status"]
    assert status_told["print_stats"]["state"] == "standby"
    assert "by cura.gcode" in status_told["print_stats"]["message"]
    assert status_told["virtual_sdcard"]["progress"] == 0.0
    assert "extruder" not in status_told


def test_orcaslicer_reads_the_state_by_websocket(server: Served, key: str) -> None:
    address = f"ws://127.0.0.1:{server.port}/websocket"
    for headers in ({}, {"x-api-key": "wrong"}):
        with pytest.raises(InvalidStatus), connect(address, additional_headers=headers):
            pass
    with connect(address, additional_headers={"x-api-key": key}) as socket:

        def ask(number: int, method: str, **given: Any) -> Any:
            socket.send(json.dumps({"jsonrpc": "2.0", "method": method, "params": given, "id": number}))
            while (answer := json.loads(socket.recv(timeout=20))).get("id") != number:
                assert answer["method"] == "notify_status_update"
            return answer

        about = {"client_name": "OrcaSlicer", "version": "1", "type": "agent", "url": "https://example.org"}
        assert "connection_id" in ask(0, "server.connection.identify", **about)["result"]
        wanted = {"print_stats": None, "virtual_sdcard": None, "extruder": None, "toolhead": ["position"]}
        found = ask(1, "printer.objects.subscribe", objects=wanted)["result"]["status"]
        assert set(found) == {"print_stats", "virtual_sdcard", "toolhead"}
        assert list(found["toolhead"]) == ["position"]
        assert "print_stats" in ask(2, "printer.objects.list")["result"]["objects"]
        for method in ("printer.print.start", "printer.print.resume", "printer.gcode.script"):
            assert "a person confirms" in ask(3, method, filename="square.gcode", script="G28")["error"]["message"]
        assert "not offered" in ask(4, "machine.reboot")["error"]["message"]
        assert "scope operate" in ask(5, "printer.print.pause")["error"]["message"]
        socket.send("no JSON")
        assert json.loads(socket.recv(timeout=20))["error"]["code"] == -32700
        send(server, "/api/files/local", key, "news.gcode", sliced())
        end = time.monotonic() + 20.0
        while time.monotonic() < end:
            news = json.loads(socket.recv(timeout=20))
            if news["params"][0].get("print_stats", {}).get("filename") == "news.gcode":
                return
    raise AssertionError("the new file was not reported")


def test_nothing_that_a_key_may_do_starts_motion(server: Served) -> None:
    operates = make_key(server, "operate", "tablet")
    assert send(server, "/api/files/local", operates, "square.gcode", sliced())[0] == 201
    for method, path, body in (
        ("POST", "/printer/print/start?filename=square.gcode", "{}"),
        ("POST", "/printer/print/resume", "{}"),
        ("POST", "/printer/gcode/script", '{"script": "SDCARD_PRINT_FILE FILENAME=square.gcode"}'),
        ("POST", "/api/job", '{"command": "start"}'),
        ("POST", "/api/job", '{"command": "pause", "action": "resume"}'),
        ("POST", "/api/files/local/square.gcode", '{"command": "select", "print": true}'),
    ):
        status, text, _ = server.ask(method, path, body, x_api_key=operates)
        assert status == 403, (path, text)
        assert "a person confirms" in text
    for path in ("/close", "/jobs", "/keys", "/stop", "/jobs/0123456789abcdef/load"):  # of the page alone
        assert server.ask("POST", path, "{}", x_api_key=operates)[0] == 401
    with client(server) as page:
        page.ready()
        assert server.ask("POST", "/printer/emergency_stop", "{}", x_api_key=operates)[0] == 200
        page.until(lambda state: state["state"] == "fault")
        page.until(lambda state: any("tablet (key" in each[3] for each in state["events"]))
        page.ready()
        assert server.ask("POST", "/api/job", '{"command": "cancel"}', x_api_key=operates)[0] in (204, 400)


def test_what_is_rejected_is_rejected_readably(server: Served, key: str) -> None:
    small = b"G1 X1 Y1\n"
    for name, why in (
        ("../up.gcode", "names a path"),
        ("a/b.gcode", "names a path"),
        ("a\\\\b.gcode", "names a path"),
        (".gcode", "names a path"),
        ("part.ufp", "G-code is expected"),
        ("x" * 130 + ".gcode", "at most 120"),
    ):
        for path in ("/api/files/local", "/server/files/upload"):
            status, text, _ = send(server, path, key, name, small)
            assert status == 400, (name, text)
            assert why in text
    status, text, _ = send(server, "/api/files/local", key, "a.gcode", small, path="folder")
    assert (status, "folders are not supported" in text) == (400, True)
    status, text, headers = send(server, "/api/files/local", "wrong", "a.gcode", small)
    assert (status, "make one on the page" in text, headers["content-type"]) == (401, True, "text/plain")
    status, text, _ = send(server, "/server/files/upload", "wrong", "a.gcode", small)
    assert status == 401
    assert "make one on the page" in json.loads(text)["error"]["message"]
    for secret in ("apikey", "token", "access_token"):
        status, text, _ = server.ask("GET", f"/api/version?{secret}={key}", x_api_key=key)
        assert (status, "stays in logs" in text) == (400, True)
    for origin in (server.origin, "https://evil.example", "null"):
        status, text, headers = server.ask("GET", "/api/version", x_api_key=key, origin=origin)
        assert status == 403
        assert "access-control-allow-origin" not in {each.lower() for each in headers}
    assert server.ask("GET", "/api/version", cookie=server.cookie())[0] == 401  # a browser's cookie opens nothing here
    assert server.ask("GET", "/api/version")[0] == 401  # nor the token
    status, text, _ = send(server, "/api/files/local", key, "empty.gcode", b"")
    assert (status, "is empty" in text) == (400, True)
    status, text, _ = server.ask("POST", "/api/files/local", small, x_api_key=key, content_type="text/plain")
    assert (status, "a form is expected" in text) == (400, True)
    assert not [job for job in json.loads(server.ask("GET", "/jobs")[1]) if not job["parts"]]  # nothing is left of them


def test_two_gigabytes_are_rejected_immediately(server: Served, key: str) -> None:
    head = (
        f"POST /api/files/local HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nX-Api-Key: {key}\r\n"
        f"Content-Type: multipart/form-data; boundary=x\r\nContent-Length: {2 << 30}\r\n\r\n"
    )
    with socket.create_connection(("127.0.0.1", server.port), timeout=20) as sending:
        sending.sendall(head.encode() + b"x" * 100_000)  # and goes on
        sending.sendall(b"x" * 100_000)
        answer = ""
        while "MiB of G-code" not in answer:
            answer += sending.recv(4096).decode()
    assert "413" in answer.splitlines()[0]
    assert "2048 MiB: too large; at most 64 MiB" in answer


def test_a_full_disk_is_reported_and_leaves_nothing(server: Served, key: str) -> None:
    before = json.loads(server.ask("GET", "/jobs")[1])
    process, most = server.server(), resource.RLIM_INFINITY
    resource.prlimit(
        process, resource.RLIMIT_FSIZE, (2000, most)
    )  # no file may grow over it, as on a disk that is full
    try:
        status, text, _ = send(server, "/api/files/local", key, "full.gcode", b"G1 X1\n" * 1000)
    finally:
        resource.prlimit(process, resource.RLIMIT_FSIZE, (most, most))
    assert status == 507
    assert "cannot be written" in text
    assert [each["id"] for each in json.loads(server.ask("GET", "/jobs")[1])] == [each["id"] for each in before]


def test_keys_are_kept_by_their_hashes_and_can_be_removed(server: Served, key: str) -> None:
    kept = (server.folder / FILE).read_text()
    assert key not in kept
    number = next(each["id"] for each in json.loads(server.ask("GET", "/keys")[1]) if each["name"] == "slicer")
    assert server.ask("DELETE", f"/keys/{number}")[0] == 403  # of the operator
    extra = make_key(server, name="gone")
    assert 429 in statuses(server, extra, 600)  # its rate
    gone = next(each["id"] for each in json.loads(server.ask("GET", "/keys")[1]) if each["name"] == "gone")
    with client(server) as page:
        page.ready()
        headers = {"cookie": server.cookie(), "origin": server.origin, "x_page": page.page}
        assert server.ask("DELETE", f"/keys/{gone}", **headers)[0] == 200
    assert server.ask("GET", "/api/version", x_api_key=extra)[0] == 401


def test_a_socket_ends_with_its_key(server: Served) -> None:
    text = make_key(server, scope="operate", name="brief")
    number = next(each["id"] for each in json.loads(server.ask("GET", "/keys")[1]) if each["name"] == "brief")
    about = {"additional_headers": {"x-api-key": text}}
    address = f"ws://127.0.0.1:{server.port}/websocket"
    with connect(address, **about) as silent, connect(address, **about) as asking:  # type: ignore[arg-type]
        with client(server) as page:
            page.ready()
            headers = {"cookie": server.cookie(), "origin": server.origin, "x_page": page.page}
            assert server.ask("DELETE", f"/keys/{number}", **headers)[0] == 200
        asking.send(json.dumps({"jsonrpc": "2.0", "method": "printer.print.pause", "id": 1}))
        for each in (asking, silent):
            with pytest.raises(ConnectionClosed):
                each.recv(timeout=20)


def test_long_notes_keep_the_former_ones_and_places_are_numbers_of_metres(server: Served) -> None:
    run = "20260101-000000-part"
    (server.folder / "runs" / run).mkdir()
    with client(server) as page:
        page.ready()
        headers = {"cookie": server.cookie(), "origin": server.origin, "x_page": page.page}
        whole = "\u7ebf" * MAX_NOTES  # three bytes each
        assert server.ask("PUT", f"/runs/{run}/notes", whole.encode(), **headers)[0] == 200
        assert server.ask("PUT", f"/runs/{run}/notes", b"x" * (4 * MAX_NOTES + 1), **headers)[0] == 413
        assert (server.folder / "runs" / run / "notes.txt").read_text(encoding="utf-8") == whole
        status, why, _ = server.ask("POST", "/reach", f'{{"position": [{"9" * 400}, 0, 0]}}', **headers)
        assert status == 409, why
    shutil.rmtree(server.folder / "runs" / run)


def test_keys_are_limited_and_a_damaged_file_is_named(tmp_path: Any) -> None:
    keys = Keys(tmp_path)
    made = [keys.make(f"k{k}", "upload")[0] for k in range(MAX_KEYS)]
    with pytest.raises(InputError, match="remove one"):
        keys.make("more", "upload")
    for name, scope in (("", "upload"), ("x", "admin"), ("x", None)):
        with pytest.raises(InputError, match=r"name|scope"):
            keys.make(name, scope)
    again = Keys(tmp_path)
    assert [found.name for text in made if (found := again.of(text))] == [f"k{k}" for k in range(MAX_KEYS)]
    (tmp_path / FILE).write_text("{")
    with pytest.raises(InputError, match="is damaged"):
        Keys(tmp_path)


def test_forms_are_read_byte_by_byte() -> None:
    content = bytes(range(256)) + b"\r\n--" + BOUNDARY[:-1].encode() + b"\r\n"
    kind, body = form("a.gcode", content, print="TRUE", root="gcodes")
    found = parsed_form(kind, body)
    assert (found.name, found.content, found.wants_print) == ("a.gcode", content, True)
    for cut in (10, len(body) // 2, len(body) - len(BOUNDARY) - 8):
        with pytest.raises(InputError):
            parsed_form(kind, body[:cut])
    with pytest.raises(InputError, match="root"):
        parsed_form(*form("a.gcode", b"x", root="config"))
    assert file_name("/a b.GCODE") == "a b.GCODE"


@pytest.mark.parametrize("name", ["filename*0=\"a\"; filename*=utf-8''b.gcode", f'filename*{"9" * 4400}="a"'])
def test_malformed_pieces_of_a_name_are_rejected(name: str) -> None:
    kind, body = form("a.gcode", b"G1 X1\n")
    with pytest.raises(InputError, match=r"malformed|cut off|no file"):
        parsed_form(kind, body.replace(b'filename="a.gcode"', name.encode()))
    with pytest.raises(InputError, match="malformed"):
        parsed_form(f"multipart/form-data; boundary*{'9' * 4400}=x", body)


def test_notes_of_slicers(tmp_path: Any) -> None:
    path = tmp_path / "cura.gcode"
    path.write_text(";FLAVOR:Marlin\n;TIME:1234\n;Layer height: 0.25\n;Generated with Cura_SteamEngine 5.9.0\nG1 X1\n")
    found = notes_of(path)
    assert (found.slicer, found.version) == ("Cura", "5.9.0")
    assert found.numbers == {"estimated_time": 1234.0, "layer_height": 0.25}
    path.write_text(
        "; thumbnail begin 8x8 4\n; !!!!\n; thumbnail end\n; thumbnail begin 8x8 4\n; AAAA\n; thumbnail end\n"
    )
    assert notes_of(path).pictures == ()


def test_notes_take_no_longer_for_pictures_that_do_not_end_and_numbers_stay_finite(tmp_path: Any) -> None:
    path = tmp_path / "hostile.gcode"
    path.write_text("; thumbnail begin 1x1 1\n" * 80_000)
    begin = time.process_time()
    assert notes_of(path).pictures == ()
    assert time.process_time() - begin < 5.0  # one pass: it was half an hour, in which no page could stop
    for text in (f"; estimated printing time = {'1' * 5000}s\n", f"; layer_height = {'9' * 400}\n"):
        path.write_text(text)
        assert notes_of(path).numbers == {}
