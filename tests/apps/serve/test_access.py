"""Who gets in, piece by piece; and the memory and the messages between control and server."""

from __future__ import annotations

import hashlib
import os
import threading
import time
from pathlib import Path

import pytest

from cablewright.apps.serve.access import Access, Bucket, new_token
from cablewright.apps.serve.operators import MAX_CLIENTS, Operators, person
from cablewright.control.orders import STOPS
from cablewright.control.transitions import TRANSITIONS
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import OrderKind
from cablewright.live.serve.jobs import (
    GCODE,
    JOB,
    JobCheck,
    folder_of,
    load_served,
    read_check,
    subject_of,
    write_check,
)
from cablewright.live.serve.latest_shared_message import shared
from cablewright.live.serve.link import LEASE, ControlLink, ServerLink
from cablewright.live.serve.messages import LoadMessage, OrderMessage, parsed
from cablewright.robot import load
from served import RING

TOKEN = new_token()
ACCESS = Access(b"k" * 32, hashlib.sha256(TOKEN.encode()).digest(), frozenset({"127.0.0.1:8642"}), 8642, False)


def test_a_cookie_is_of_one_start_and_one_port() -> None:
    session, header = ACCESS.new_cookie()
    name, _, value = header.split(";")[0].partition("=")
    assert ACCESS.session_of([(b"cookie", f"a=b; {name}={value}; c=d".encode())]) == session
    for other in (value[:-1], value.replace(".", ""), "0" * 16 + value[16:], value.upper(), ""):
        assert ACCESS.session_of([(b"cookie", f"{name}={other}".encode())]) is None
    later = Access(b"j" * 32, ACCESS.token, ACCESS.hosts, 8642, False)
    assert later.session_of([(b"cookie", f"{name}={value}".encode())]) is None
    beside = Access(ACCESS.key, ACCESS.token, ACCESS.hosts, 8643, False)
    assert beside.session_of([(b"cookie", f"{name}={value}".encode())]) is None
    assert "Secure" in Access(ACCESS.key, ACCESS.token, ACCESS.hosts, 8642, True).new_cookie()[1]


def test_the_token_and_the_view_token_are_apart() -> None:
    assert ACCESS.is_token(TOKEN)
    assert not ACCESS.is_token(ACCESS.view_token)
    assert not ACCESS.is_view_token(TOKEN)
    assert not ACCESS.is_token("")
    assert not ACCESS.is_token("\udc80")
    assert len({new_token() for _ in range(100)}) == 100


@pytest.mark.parametrize(
    ("origin", "expected"),
    [
        (b"http://127.0.0.1:8642", "own"),
        (b"https://127.0.0.1:8642", "foreign"),
        (b"http://127.0.0.1:8643", "foreign"),
        (b"http://127.0.0.1:8642.evil.example", "foreign"),
        (b"null", "foreign"),
        (b"https://app.foxglove.dev", "foxglove"),
    ],
)
def test_origins(origin: bytes, expected: str) -> None:
    assert ACCESS.origin_of([(b"origin", origin)]) == expected
    assert ACCESS.origin_of([]) is None
    assert ACCESS.origin_of([(b"origin", origin), (b"origin", b"http://127.0.0.1:8642")]) == "foreign"


def test_two_hosts_are_none() -> None:
    host = (b"host", b"127.0.0.1:8642")
    assert ACCESS.knows_host([host])
    assert not ACCESS.knows_host([host, host])
    assert not ACCESS.knows_host([])


def test_a_bucket_is_filled_again() -> None:
    bucket = Bucket(3, 100.0)
    assert [bucket.take() for _ in range(4)] == [True, True, True, False]
    time.sleep(0.03)
    assert bucket.take()


def test_the_lease_is_of_one_page_and_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    operators = Operators()
    first, second = operators.join("a"), operators.join("b")
    assert first is not None
    assert second is not None
    assert operators.take(first, "Ann") == ""
    assert "Ann" in operators.take(second, "Bob")
    assert operators.of_secret(first.secret) is first
    assert operators.of_secret(second.secret) is None
    assert operators.of_secret("") is None
    operators.release(second)  # of whose it is not
    assert operators.operator is first
    first.last -= 6.0
    assert operators.operator is None
    assert operators.of_secret(first.secret) is None
    assert operators.take(second, "Bob") == ""
    operators.leave(second)
    assert operators.operator is None
    while operators.join("c") is not None:
        assert len(operators.clients) <= MAX_CLIENTS


def test_names_are_one_line_without_tricks() -> None:
    assert person("  Ann\n\x1b[31mB\u202eob ") == "Ann \\x1b[31mB\\u202eob"
    assert person(7) == person(None) == ""
    assert len(person("x" * 1000)) == 40


def test_messages_are_checked_again_by_the_control() -> None:
    order = OrderMessage(by="x", at=1.0, kind=OrderKind.JOG, arguments={"velocity": (0.1, 0.0, 0.0)})
    assert parsed(order.model_dump_json().encode()) == order
    assert isinstance(parsed(b'{"by": "x", "load": null}'), LoadMessage)
    for foul in (
        b"", b"{", b"[]", b'{"by": "x"}', b'{"by": "", "kind": "reset"}', b'{"by": "x", "kind": "fly"}',
        b'{"by": "x", "kind": "jog", "arguments": {"velocity": [NaN, 0, 0]}}',
        b'{"by": "x", "kind": "jog", "arguments": {"velocity": [1e99, 0, 0]}}',
        b'{"by": "x", "kind": "reset", "more": 1}', b'{"by": "x", "load": "../x"}', b'{"by": "x", "load": "a/b"}',
    ):  # fmt: skip
        assert parsed(foul) is None, foul


def test_stops_come_first_and_what_is_full_is_rejected() -> None:
    link = ControlLink.new()
    orders, stops = link.connect()
    memories = link.state, link.sitting, link.told_lease
    files = [os.dup(each.file_number) for each in memories]
    server = ServerLink.of(*files, orders.detach(), stops.detach())
    order = OrderMessage(by="x", kind=OrderKind.START)
    sent = 0
    while server.send(order):
        sent += 1
        assert sent < 100_000
    assert server.send(OrderMessage(by="x", kind=OrderKind.EMERGENCY), "stops")  # though the others are full
    found = list(link.messages())
    assert isinstance(found[0], OrderMessage)
    assert found[0].kind is OrderKind.EMERGENCY
    assert all(isinstance(each, OrderMessage) and each.kind is OrderKind.START for each in found[1:])
    for each in link.connect():  # a new server: what the old one has sent is gone
        each.close()
    assert list(link.messages()) == []
    assert not server.send(order)
    link.close()
    server.close()


@pytest.mark.parametrize("stop", STOPS)
def test_a_message_that_a_stop_overtook_is_untimely(stop: OrderKind) -> None:
    link = ControlLink.new()
    orders, stops = link.connect()
    orders.send(OrderMessage(by="ann", at=100.0, kind=stop).model_dump_json().encode())
    assert len(list(link.messages())) == 1
    link.told_lease.write(LEASE.pack(5, link.clock()))
    start = OrderMessage(by="ben", at=99.9, lease=5, kind=OrderKind.START)
    assert link.untimely(start) == "it was ordered before the last stop"
    assert link.untimely(start.model_copy(update={"at": 100.1})) == ""
    assert "does not operate" in link.untimely(start.model_copy(update={"at": 100.1, "lease": 4}))
    link.told_lease.write(LEASE.pack(5, link.clock() - 1.1))  # the server hangs
    assert "does not operate" in link.untimely(start.model_copy(update={"at": 100.1}))
    for each in (orders, stops, link):
        each.close()


def test_the_latest_is_whole_while_it_is_written() -> None:
    latest = shared(1 << 16)
    reader = type(latest)(os.dup(latest.file_number), 1 << 16)
    assert reader.read() == (0, b"")
    over = threading.Event()

    def write() -> None:
        k = 0
        while not over.is_set():
            k += 1
            latest.write(bytes([k % 251]) * (1000 + k % 50_000))

    writing = threading.Thread(target=write)
    writing.start()
    last, wrong = 0, 0
    end = time.monotonic() + 0.5
    while time.monotonic() < end:
        number, data = reader.read()
        if number:
            wrong += number < last or len(set(data)) != 1 or data[0] != number % 251
            last = max(last, number)
    over.set()
    writing.join()
    assert last > 10
    assert not wrong
    assert not latest.write(bytes(1 << 17))
    for each in (latest, reader):
        each.close()


def test_the_page_knows_the_orders_of_the_table() -> None:
    from cablewright.live.serve.status import allowed_orders

    allowed = allowed_orders()
    for state, event in TRANSITIONS:
        if isinstance(event, OrderKind):
            assert state.value in allowed[event.value]
    assert set(allowed) == {kind.value for kind in OrderKind}


@pytest.fixture
def job(tmp_path: Path) -> Path:
    folder = tmp_path / ("0" * 15 + "a")
    folder.mkdir()
    (folder / JOB).write_text(RING)
    return folder


@pytest.mark.parametrize("name", ["/etc/passwd", "../x.gcode", "a/b.gcode", "..", "", "x\\\\y", ".", "a\\u0000b"])
def test_a_job_that_names_a_path_is_rejected(job: Path, name: str) -> None:
    (job / GCODE).write_text("G1 X1 E1\n")
    (job / JOB).write_text(f'schema = 1\nname = "x"\ngcode = "{name}"\n')
    with pytest.raises(InputError, match="names a path"):
        load_served(job, "x")


def test_the_path_of_a_job_is_its_own_file(job: Path) -> None:
    (job / GCODE).write_text("G1 X1 E1\n")
    (job / JOB).write_text('schema = 1\nname = "x"\ngcode = "house.gcode"\n')
    (job / "house.gcode").write_text("G1 X9 E1\n")
    assert load_served(job, "x").gcode == job / GCODE
    (job / GCODE).unlink()
    with pytest.raises(InputError, match="no G-code was sent"):
        load_served(job, "x")


def test_links_and_foreign_numbers_are_no_jobs(job: Path) -> None:
    assert folder_of(job.parent, job.name) == job
    (job.parent / ("0" * 15 + "b")).symlink_to(job)
    for number in ("0" * 15 + "b", "..", "", "../" + job.name, job.name.upper(), job.name + "\n", "0" * 16):
        with pytest.raises(InputError, match="no such job"):
            folder_of(job.parent, number)


def test_what_was_checked_is_what_is_loaded(job: Path) -> None:
    robot = load("house-printer")
    subject = subject_of(job, robot)
    assert read_check(job) is None
    for answer, confirmed, said in (
        ("yes", "", ""),
        ("no", "", "its check said no, and no operator confirmed this: too heavy"),
        ("no", "0" * 64, "its check said no, and no operator confirmed this: too heavy"),
        ("no", subject, ""),
        ("failed", subject, "its check did not come to an answer: too heavy"),
    ):
        write_check(job, JobCheck(subject=subject, answer=answer, why="too heavy"))
        found = read_check(job)
        assert found is not None
        assert found.refusal(subject_of(job, robot), confirmed) == said
    write_check(job, JobCheck(subject=subject, answer="yes", why=""))
    (job / JOB).write_text(RING + "# changed\n")
    found = read_check(job)
    assert found is not None
    assert "before its files" in found.refusal(subject_of(job, robot), "")
    assert subject_of(job, robot) != subject_of(job, load("merlet2023"))
