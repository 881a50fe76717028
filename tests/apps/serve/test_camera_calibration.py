"""The calibration by camera on the page: its folder from pixels to an accepted robot, its requests, and its section."""

from __future__ import annotations

import asyncio
import base64
import io
import json
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("starlette")
pytest.importorskip("cv2")

import tomlkit
from benchmarks.campaigns import tag_pictures
from benchmarks.campaigns.camera_rooms import Room, Setup, _shown, exit_errors, room
from PIL import Image
from starlette.requests import Request

import cablewright as cw
from browser import Page, browser, executable
from cablewright.apps.serve import camera_folder, camera_routes
from cablewright.apps.serve.camera_routes import CameraRoutes
from cablewright.apps.serve.check_worker import station_of, write_station
from cablewright.apps.serve.checks import WAITING, Checks
from cablewright.apps.serve.uploads import Uploads
from cablewright.calibration.poses.simulation import measure
from cablewright.calibration.sightings.camera import camera_text
from cablewright.foundation.errors import CablewrightError, InputError
from cablewright.live.serve.control_process import Control
from cablewright.live.serve.link import ControlLink
from cablewright.live.serve.operated_machines import SimulatedStation, resting_pose
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.models.job_stages import with_exit_points
from operator_page import enable
from served import RING, Served, client, picture

MACHINE = cw.load("ipanema")
SMALL = Setup(poses=14, width=960, height=720, focal=700.0, size=0.2, encoder=1e-4)
PLAN = 'schema = 1\nsigma.encoder = "0.1 mm"\n'


@pytest.fixture(scope="module")
def made() -> Room:
    return room(MACHINE, SMALL, 3, pixels=False)


def state(lengths: list[float], pose: list[float], **more: Any) -> dict[str, Any]:
    """A state of the machine, at rest at a *pose* with *lengths*."""
    platform = {"valid": True, "position": pose[:3], "rotation": pose[3:]}
    speeds = [0.0] * len(lengths)
    return {"lines": {"lengths": lengths}, "platform": platform, "speeds": speeds, "zero": "1", "state": "idle"} | more


def kept(folder: Path, content: bytes, now: dict[str, Any], after: dict[str, Any] | None = None) -> str:
    """A picture sent at a state of the machine, and the one after it, by default the same."""
    return camera_folder.add(folder, content, now, now if after is None else after, MACHINE)


def sent(folder: Path, made: Room, which: range) -> None:
    """Send files and rendered pictures at some poses of a room to the folder, as the page does."""
    seen = made.data.sightings
    assert seen is not None
    layout = tomlkit.dumps(seen.layout.model_dump(mode="json", exclude_none=True))
    for part, text in (("tags", layout), ("camera", camera_text(seen.camera)), ("plan", PLAN)):
        camera_folder.put_part(folder, part, text.encode())
    rng = np.random.default_rng(4)
    lengths = 5.0 + measure(made.robot, made.poses, 1e-4, rng).measured.counted
    for at in which:
        shown = _shown(seen.layout, SMALL, made.tags, made.poses[at], made.camera)
        grey = tag_pictures.picture(made.lens, SMALL.width, SMALL.height, shown, rng, SMALL.flaws)
        buffer = io.BytesIO()
        Image.fromarray(grey).save(buffer, "png")
        name = kept(folder, buffer.getvalue(), state(lengths[at].tolist(), made.poses[at].tolist()))
        assert name == f"pose-{at + 1:02d}.png"


def worked(what: str, served_folder: Path) -> str:
    """Let the process with limits compute; return what it complained of."""
    command = [sys.executable, "-m", "cablewright.apps.serve.check_worker", what, served_folder, camera_folder.FOLDER]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    said = process.stderr.read()
    process.communicate()
    return said


@pytest.mark.slow  # apps/test_guide_by_camera.py leads from pictures to a robot
def test_pictures_lead_to_an_accepted_robot(made: Room, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A picture without a tag, the last, counts neither for the guide nor for what is accepted."""
    folder = tmp_path / camera_folder.FOLDER
    write_station(tmp_path, MACHINE, cw.load_machine("house-printer"))
    sent(folder, made, range(14))
    buffer = io.BytesIO()
    Image.new("L", (SMALL.width, SMALL.height), 128).save(buffer, "png")
    kept(folder, buffer.getvalue(), state([5.0] * 8, [0.0] * 6))
    with pytest.raises(InputError, match="there is no calibration to accept yet"):
        camera_folder.may_accept(folder, "")
    assert worked("guide", tmp_path) == ""
    found = camera_folder.told(folder)
    answer = found["answer"]
    assert (found["pictures"], found["parts"], found["room"]) == (15, ["tags", "camera", "plan"], True)
    assert answer["verdict"] in ("good", "doubtful")
    assert answer["camera"].startswith("the camera stands at")
    assert answer["pictures"][0]["tags"]
    assert (answer["poses"], answer["pictures"][14]["tags"]) == (14, [])
    assert answer["sigma"] < 5e-3
    camera_folder.may_accept(folder, answer["subject"])
    assert worked("accept", tmp_path) == ""
    robot = cw.load(camera_folder.told(folder)["accepted"])
    assert np.abs(exit_errors(made.robot, robot, own_frame=True)).max() < 8e-3
    assert (folder / "calibrated.calibration.toml").is_file()
    with monkeypatch.context() as worse:
        found = SimpleNamespace(verdict="bad", reasons=("it is",))
        worse.setattr(cw, "calibrate", lambda _robot, data, _plan: found if len(data.counted) == 14 else None)
        with pytest.raises(InputError, match=f"is bad, not {answer['verdict']} as was accepted: it is"):
            camera_folder.accept(folder, MACHINE)
    camera_folder.remove_last(folder)
    with pytest.raises(InputError, match="have changed since the answer that was accepted"):
        camera_folder.accept(folder, MACHINE)


def test_one_is_accepted_by_a_person_who_has_seen_it(tmp_path: Path) -> None:
    answer = {"verdict": "doubtful", "subject": "7" * 64, "reasons": ["it is"]}
    camera_folder.write_answer(tmp_path, answer)
    for verdict in ("doubtful", "good"):
        camera_folder.write_answer(tmp_path, answer | {"verdict": verdict})
        with pytest.raises(InputError, match=f"is {verdict}, and no operator confirmed this one"):
            camera_folder.may_accept(tmp_path, "8" * 64)
        camera_folder.may_accept(tmp_path, "7" * 64)
    camera_folder.write_answer(tmp_path, answer | {"verdict": "bad"})
    with pytest.raises(InputError, match="no calibration to accept"):
        camera_folder.may_accept(tmp_path, "7" * 64)


def test_lengths_are_kept_with_their_picture(tmp_path: Path) -> None:
    pose = [0.0] * 6
    still = state([1.0] * 8, pose)
    for moving, words in (
        (state([1.0] * 8, pose, speeds=[0.1] * 8), "the winches turn"),
        (state([1.0] * 8, pose, platform={"valid": False}), "lengths and position are not known"),
        (state([1.0] * 8, pose, state="homing"), "lengths and position are not known"),
        (state([1.0] * 7 + [None], pose), "lengths and position are not known"),
        (state([1.0] * 7 + [float("nan")], pose), "lengths and position are not known"),
        (state([1.0] * 7, pose), "lengths and position are not known"),
        ({}, "the state of the machine is old"),
    ):
        for before, after in ((moving, still), (still, moving)):
            with pytest.raises(InputError, match=words):
                kept(tmp_path, picture(), before, after)
    for elsewhere in (state([1.0] * 7 + [1.002], pose), still | {"zero": "2"}):
        with pytest.raises(InputError, match="was moved, or homed, meanwhile"):
            kept(tmp_path, picture(), still, elsewhere)
    with pytest.raises(InputError, match="is no JPEG and no PNG"):
        kept(tmp_path, b"GIF89a", still)
    kept(tmp_path, picture(), state([1] * 8, pose))  # as JSON has them
    kept(tmp_path, picture(), state([1.25] * 8, [0.1] * 6))
    rows = (tmp_path / "data.csv").read_text().splitlines()
    assert [float(each) for each in rows[2].split(",")] == [0.25] * 8 + [0.1] * 6
    for left in (1, 0):
        camera_folder.remove_last(tmp_path)
        assert camera_folder.told(tmp_path)["pictures"] == left
        assert len(list((tmp_path / "pictures").iterdir())) == left
    with pytest.raises(InputError, match="there is no picture"):
        camera_folder.remove_last(tmp_path)


def test_lengths_of_another_zero_are_rejected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    still = state([1.0] * 8, [0.0] * 6)
    kept(tmp_path, picture(), still)
    (tmp_path / "tags.toml").write_text("sent")
    (tmp_path / "calibrated.toml").write_text("accepted")
    other = with_exit_points(MACHINE, [(x, y, z + 1e-3) for x, y, z in exits_of(MACHINE)])
    assert camera_folder.subject_of(tmp_path, MACHINE) != camera_folder.subject_of(tmp_path, other)
    for now, robot in ((still | {"zero": "2"}, MACHINE), (still, other)):
        with pytest.raises(InputError, match="opened or homed, or is another robot: begin again"):
            camera_folder.add(tmp_path, picture(), now, now, robot)
    assert camera_folder.told(tmp_path)["pictures"] == 1
    camera_folder.begin_anew(tmp_path)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["calibrated.toml", "tags.toml"]
    assert kept(tmp_path, picture(), still | {"zero": "2"}) == "pose-01.png"
    camera_folder.begin_anew(tmp_path, keeps_robot=False)
    assert [each.name for each in tmp_path.iterdir()] == ["tags.toml"]
    monkeypatch.setattr(camera_folder, "MAX_PICTURES", 2)
    kept(tmp_path, picture(), still)
    kept(tmp_path, picture(), still)
    with pytest.raises(InputError, match="there are 2 pictures already"):
        kept(tmp_path, picture(), still)


def test_a_homing_and_an_opening_give_lengths_another_zero() -> None:
    feed = SimpleNamespace(state={}, head=SimpleNamespace(epoch="today"))
    routes = CameraRoutes(SimpleNamespace(feed=feed, uploads=SimpleNamespace(folder=Path())))  # type: ignore[arg-type]

    def zero(sitting: int, *events: tuple[str, str], age: float = 0.0) -> Any:
        told = [(at, 0.0, *each) for at, each in enumerate(events, 1)]
        feed.state = {"clock": time.monotonic() - age, "sitting": sitting, "events": told}
        return routes._present().get("zero")

    first = zero(1, ("state", "manual"))
    assert first == zero(1, ("state", "manual"), ("fault", "homing failed"))
    homed = zero(1, ("state", "manual"), ("fault", "-"), ("state", "homing"), ("state", "manual"))
    assert homed not in (first, None)
    assert homed == zero(1)  # although other events have replaced those
    assert zero(2) not in (first, homed)
    assert zero(2, age=0.6) is None


def test_bodies_have_a_time_limit_and_their_page_operates_until_they_are_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is kept of one that comes late, of a page that operates no more, or while no answer can be computed."""
    monkeypatch.setattr(camera_routes, "SENDING", 0.1)
    operating = {"ours"}

    async def asked(*, late: bool = False, leaves: bool = False, full: bool = False) -> tuple[int, bytes]:
        async def receive() -> dict[str, Any]:
            await asyncio.sleep(5.0 if late else 0.0)
            operating.difference_update({"ours"} if leaves else ())
            return {"type": "http.request", "body": PLAN.encode(), "more_body": False}

        async def no_news(_version: int) -> int:
            await asyncio.sleep(5.0)
            return 0

        uploads = Uploads(tmp_path)
        checks, operators = Checks(uploads), SimpleNamespace(of_secret=lambda secret: secret in operating or None)
        for at in range(WAITING if full else 0):
            assert checks.ask("report", str(at)) == ""
        feed = SimpleNamespace(state={}, head=None, next=no_news)
        page = SimpleNamespace(
            feed=feed, uploads=uploads, checks=checks, operators=operators, sending=asyncio.Semaphore(1)
        )
        routes = CameraRoutes(page)  # type: ignore[arg-type]
        scope = {"type": "http", "headers": [(b"x-page", b"ours")], "path_params": {"part": "plan"}}
        answer = await routes._by_operator(routes.put, 1000)(Request(scope, receive))
        assert not routes._taking.locked()
        return answer.status_code, bytes(answer.body)

    assert asyncio.run(asked(late=True)) == (408, b"it was not sent within 300 s\n")
    assert asyncio.run(asked(full=True)) == (409, b"10 wait already; try again later\n")
    assert asyncio.run(asked(leaves=True)) == (409, b"this page does not operate the machine any more\n")
    assert asyncio.run(asked())[0] == 403
    assert not (tmp_path / camera_folder.FOLDER).exists()
    operating.add("ours")
    assert asyncio.run(asked())[0] == 200


def test_a_file_that_is_none_is_an_error_and_changes_nothing(made: Room, tmp_path: Path) -> None:
    sent(tmp_path, made, range(0))
    before = (tmp_path / "tags.toml").read_bytes()
    with pytest.raises(InputError, match=r"^tags\.toml: ") as error:
        camera_folder.put_part(tmp_path, "tags", b"schema = 1\ntags = 3\n")
    assert "\n" not in str(error.value)
    assert (tmp_path / "tags.toml").read_bytes() == before
    assert [each.name for each in tmp_path.iterdir() if each.name.startswith("sent-")] == []


@pytest.mark.clock
def test_requests_are_of_the_operator_and_name_what_is_wrong(server: Served, made: Room) -> None:
    assert made.data.sightings is not None
    with client(server) as first:
        bearer = {"authorization": f"Bearer {server.token}", "x-page": first.page}
        assert server.ask("PUT", "/calibration/plan", PLAN, **bearer)[0] == 403
        assert first.take() == ""
        assert server.ask("GET", "/calibration/room", **bearer)[0] == 404
        for method, path, body, status, words in (
            ("PUT", "/calibration/plan", "x", 409, "data.toml: "),
            ("PUT", "/calibration/attic", PLAN, 409, "'attic': expected tags, camera, plan"),
            ("POST", "/calibration/pictures", "", 409, "no picture was sent, and serve has no --camera"),
            ("POST", "/calibration/pictures", "GIF89a", 409, "is no JPEG and no PNG"),
            ("DELETE", "/calibration/pictures", None, 409, "there is no picture"),
            ("POST", "/calibration/accept", "{}", 409, "there is no calibration to accept yet"),
            ("POST", "/calibration/accept", "x" * 5000, 413, "at most 4096 bytes"),
        ):
            found, text, _ = server.ask(method, path, body, **bearer)
            assert (found, words in text, text.count("\n")) == (status, True, 1), text
        assert server.ask("PUT", "/calibration/plan", "x" * 2_000_000, **bearer)[0] == 413
        for method, path, body in (("PUT", "plan", PLAN), ("POST", "guide", ""), ("POST", "anew", "")):
            status, text, _ = server.ask(method, f"/calibration/{path}", body, **bearer)
            assert (status, json.loads(text)) == (200, {"missing": ["tags", "camera"]})
        told = json.loads(server.ask("GET", "/calibration", **bearer)[1])
        assert (told["parts"], told["pictures"], told["live"], told["answer"]) == (["plan"], 0, False, None)


STAGED = RING.replace("[helix]", 'max_seam = "1 m"\n[[stages]]\nz = "50 mm"\nraised = "0.5 m"\n[helix]')


@pytest.mark.clock
def test_the_stages_of_a_job_become_jobs_between_which_exit_points_move(server: Served) -> None:
    low = cw.load("house-printer").lines[0].exit_point[2]
    with client(server) as first:
        assert first.take() == ""
        bearer = {"authorization": f"Bearer {server.token}", "x-page": first.page}
        number = json.loads(server.ask("POST", "/jobs", json.dumps({"name": "tower"}), **bearer)[1])["id"]
        assert server.ask("PUT", f"/jobs/{number}/settings", STAGED, **bearer)[0] == 200
        assert server.ask("POST", f"/jobs/{number}/check", "", **bearer)[0] == 200
        end = time.monotonic() + 180.0
        while len(jobs := json.loads(server.ask("GET", "/jobs")[1])) < 3 or any(each["busy"] for each in jobs):
            assert time.monotonic() < end, jobs
            first.during(0.3)
        by_stage = {each["stage"]: each for each in jobs}
        assert "it has 2 stages, which are jobs of their own now" in by_stage[0]["check"]["why"]
        assert [by_stage[k]["name"] for k in (1, 2)] == ["stage 1 of 2: ring", "stage 2 of 2: ring"]
        status, text, _ = server.ask("POST", f"/calibration/stage/{by_stage[1]['id']}", "", **bearer)
        assert (status, text) == (409, "the job is no later stage\n")
        assert server.ask("POST", "/calibration/adopt", "", **bearer)[1] == "there is no accepted calibration\n"
        status, text, _ = server.ask("POST", f"/calibration/stage/{by_stage[2]['id']}", "", **bearer)
        assert status == 200, text
        assert robot_of(server).lines[0].exit_point[2] == pytest.approx(low + 0.5)
        first.until(lambda state: state.get("sitting", 0) > 1 and state.get("state") not in (None, "closed"))
        calibrated = with_exit_points(robot_of(server), [(x, y, z + 4e-3) for x, y, z in exits_of(robot_of(server))])
        (server.folder / "calibration").mkdir(exist_ok=True)
        (server.folder / "calibration" / "calibrated.toml").write_text(camera_folder.robot_text(calibrated))
        status, text, _ = server.ask("POST", "/calibration/adopt", "", **bearer)
        assert status == 200, text
        assert robot_of(server).lines[0].exit_point[2] == pytest.approx(low + 0.504)
        first.until(lambda state: state.get("state") not in (None, "closed"))


def test_an_adoption_that_fails_changes_nothing(tmp_path: Path) -> None:
    """Jobs are checked for the robot that the machine is, whether it could become the other one or not."""
    robot = cw.load("house-printer")
    station = SimulatedStation(robot, built_machine(robot)[0], 0, resting_pose(robot))
    control = Control(station, ControlLink.new(), tmp_path, lambda: True)
    write_station(tmp_path, robot, station.settings.owner)
    file = tmp_path / "robot.toml"
    try:
        for other, words in (
            (with_exit_points(robot, [(x + 40.0, y, z) for x, y, z in exits_of(robot)]), "leaves the workspace"),
            (
                robot.model_copy(update={"name": "another"}),
                "robot 'another' with .* but the machine is 'house-printer'",
            ),
        ):
            file.write_text(camera_folder.robot_text(other))
            with pytest.raises(CablewrightError, match=words):
                control._adopted(file.name)
            assert (station.robot, station_of(tmp_path)[0]) == (robot, robot)
            station.sitting(None)
        moved = with_exit_points(robot, [(x, y, z + 4e-3) for x, y, z in exits_of(robot)])
        file.write_text(camera_folder.robot_text(moved))
        control._adopted(file.name)
        assert station_of(tmp_path)[0].lines == station.robot.lines == moved.lines
    finally:
        control.close()
        control.link.close()


def robot_of(server: Served) -> cw.Robot:
    """The robot that jobs are checked for."""
    return station_of(server.folder)[0]  # type: ignore[no-any-return]


def exits_of(robot: cw.Robot) -> list[tuple[float, float, float]]:
    return [line.exit_point for line in robot.lines]


def sending(page: Page, field: str, act: str, then: str) -> None:
    """Send a file by a field, again where a busy computer has lost it, or the page the lease, until it is there."""
    end = time.monotonic() + 240.0
    while not page.run(f"Boolean({then})"):
        assert time.monotonic() < end, page.run("document.getElementById('calibrate-told').textContent")
        if page.run("!operate.orders.mine && !document.getElementById('take').disabled"):
            page.run("document.getElementById('take').click()")
        page.run(f"document.querySelector('{field}').disabled || {act}")
        time.sleep(3.0)


@pytest.mark.slow
@pytest.mark.clock
@pytest.mark.skipif(executable() is None, reason="no chromium is installed: see README.md, Tests")
def test_the_section_leads_from_files_to_the_next_picture(server: Served, tmp_path: Path) -> None:
    large = replace(SMALL, poses=1, width=3840, height=2160, focal=2400.0, size=0.6, rough=0.0)
    seen = room(cw.load("house-printer"), large, 3, pixels=False).data.sightings
    assert seen is not None
    layout = tomlkit.dumps(seen.layout.model_dump(mode="json", exclude_none=True))
    files = {"tags": layout, "camera": camera_text(seen.camera)}
    put = """((at, text) => { const t = new DataTransfer(); t.items.add(new File([text], 'file'));
      const field = document.querySelector(at); field.files = t.files; field.dispatchEvent(new Event('change')); })"""
    with browser() as found, found.page(server.address, 1280) as page:
        page.until("window.operate && operate.link.page && !document.body.classList.contains('stale')")
        page.run("document.getElementById('calibrate-run').open = true")
        for at, (part, text) in enumerate(files.items()):
            field = f"#calibrate-files label:nth-child({at + 1}) input"
            there = f"document.getElementById('calibrate-{part}').classList.contains('yes')"
            sending(page, field, f"{put}({json.dumps(field)}, {json.dumps(text)})", there)
        page.until("document.querySelectorAll('#calibrate-next li').length > 3", 240.0)
        assert "put the camera at" in page.run("document.getElementById('calibrate-words').textContent")
        page.until("document.getElementById('calibrate-room').naturalWidth > 100")
        page.run("document.querySelector('#calibrate-next button').click()")
        goal = page.run("document.getElementById('goal').value")
        assert len([float(each) for each in goal.split(",")]) == 3
        enable(page)
        one = base64.b64encode(picture()).decode()
        of_bytes = put.replace("[text]", "[Uint8Array.from(atob(text), (c) => c.charCodeAt(0))]")
        there = "/: [1-9]/.test(document.getElementById('calibrate-count').textContent)"
        sending(page, "#calibrate-send", f"{of_bytes}('#calibrate-send', {one!r})", there)
        page.until("!operate.calibrate.found.busy", 240.0)
        page.run("document.getElementById('calibrate-run').scrollIntoView()")
        (tmp_path / "section.png").write_bytes(page.picture(whole=True))
        assert page.complaints() == []
