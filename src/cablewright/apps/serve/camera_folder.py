"""Calibration by camera on the operator's page: a folder of pictures and lengths, and what came of them.

It has the layout of the tags, the camera, a plan if there is one, a row of lengths for each picture, and the answer of
the guide. All is computed in a process with limits, `check_worker`.
"""

from __future__ import annotations

import hashlib
import http.client
import json
import re
import time
import urllib.request
from datetime import UTC, datetime
from math import isfinite
from pathlib import Path
from shutil import rmtree
from typing import TYPE_CHECKING, Any, Final

from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.file_output import write_whole
from cablewright.foundation.toml_input import read_bytes
from cablewright.live.serve.jobs import digest_of

if TYPE_CHECKING:
    from cablewright.robot import Robot

FOLDER: Final = "calibration"
PARTS: Final = {"tags": "tags.toml", "camera": "camera.toml", "plan": "data.toml"}
"""Files that a person sends, by the last part of their address; the plan may be missing."""

MAX_PICTURE: Final = 64 << 20  # bytes
MAX_PART: Final = 1 << 20
MAX_PICTURES: Final = 200
"""Pictures that are kept at a time."""

ROOM: Final = "room.png"
_ANSWER, _DATA, _HOME = "answer.json", "data.csv", "home.json"
_PICTURES, _ROBOT = "pictures", "calibrated.toml"
_KINDS: Final = {b"\xff\xd8\xff": ".jpg", b"\x89PNG": ".png"}
_PATIENCE: Final = 5.0  # s for a picture of the camera
_BEGIN: Final = b"\xff\xd8\xff"  # of a JPEG
_END: Final = b"\xff\xd9"
_LENGTH: Final = re.compile(rb"content-length:\s*(\d{1,12})\s", re.IGNORECASE)
_SAME: Final = 1e-3  # m, between lengths before and after a picture
_SETTING: Final = ("homing", "tensioning")  # states that set lengths
_VERDICTS: Final = ("bad", "doubtful", "good")
_ANEW: Final = "since the first picture the machine was opened or homed, or is another robot: begin again"


def put_part(folder: Path, part: str, content: bytes) -> None:
    """Write a file that a person has sent, if it is one. Raises `InputError`, and keeps the earlier one."""
    from cablewright.calibration.plan import load_plan
    from cablewright.calibration.sightings.camera import load_camera
    from cablewright.calibration.sightings.layout import load_layout

    read = {"tags": load_layout, "camera": load_camera, "plan": load_plan}[part]
    trial = folder / f"sent-{PARTS[part]}"
    write_whole(trial, content, parents=True)
    try:
        read(trial)
        write_whole(folder / PARTS[part], content)
    except InputError as why:
        raise InputError(str(why).replace(str(trial), PARTS[part])) from None
    finally:
        trial.unlink(missing_ok=True)


def picture_from(address: str) -> bytes:
    """Return one JPEG from the live camera at *address*, or the first of its stream. Raises `EnvironmentFault`."""
    found, until = bytearray(), time.monotonic() + _PATIENCE
    try:
        with urllib.request.urlopen(address, timeout=_PATIENCE) as answer:  # http or https: see `Address`
            streams = answer.headers.get_content_maintype() == "multipart"
            mark = b"--" + (answer.headers.get_boundary() or "").strip("-").encode()
            while piece := answer.read1(1 << 16):
                found += piece
                if time.monotonic() > until:
                    raise EnvironmentFault(f"the camera: no whole picture came within {_PATIENCE:g} s")
                if streams and (picture := _first_of(found, mark)):
                    return picture
                if len(found) > MAX_PICTURE:
                    raise EnvironmentFault("the camera: a picture has more than 64 MiB")
            if streams or answer.length:  # bytes that have not come
                raise EnvironmentFault("the camera: its answer ended before a picture was whole; try again")
    except (OSError, ValueError, http.client.HTTPException) as reason:
        raise EnvironmentFault(f"the camera does not answer: {reason}") from None
    return bytes(found)


def _first_of(stream: bytearray, mark: bytes) -> bytes:
    """The first JPEG of a stream, as long as its part states, or else up to the next *mark*; empty while it comes."""
    begin = stream.find(_BEGIN)
    if begin < 0:
        return b""
    if stated := _LENGTH.search(stream, max(stream.rfind(mark, 0, begin), 0), begin):
        end = begin + int(stated[1])
        return bytes(stream[begin:end]) if len(stream) >= end else b""
    after = stream.find(mark, begin) if len(mark) > 2 else -1  # a picture in the picture ends earlier
    end = stream.rfind(_END, begin, max(after, begin))
    return bytes(stream[begin : end + len(_END)]) if end > begin else b""


def _at_rest(state: dict[str, Any], robot: Robot) -> tuple[list[float], list[float]]:
    """Lengths (m,) and pose (n,) in a *state*. Raises `InputError` where it is old, or they are not known or change."""
    if not state:
        raise InputError("the state of the machine is old: take the picture again")
    platform, lengths = state.get("platform") or {}, (state.get("lines") or {}).get("lengths") or []
    pose = [*platform.get("position", ()), *platform.get("rotation", ())][: robot.n]
    known = [each for each in (*lengths, *pose) if isinstance(each, int | float) and isfinite(each)]
    if not platform.get("valid") or state.get("state") in _SETTING or len(known) != robot.m + robot.n:
        raise InputError("lengths and position are not known: enable the machine, or home it")
    if any(state.get("speeds") or ()):
        raise InputError("the winches turn: take the picture once the platform stands")
    return [float(each) for each in lengths], [float(each) for each in pose]


def add(folder: Path, picture: bytes, before: dict[str, Any], after: dict[str, Any], robot: Robot) -> str:
    """Keep a picture with the lengths and the pose of the states *before* and *after* it; return its name.

    ``zero`` of a state names the opening of the machine and its last homing. Raises `InputError` for no picture, too
    many, where lengths are unknown, have another zero than those of the first picture, or the platform moves.
    """
    kind = next((ending for start, ending in _KINDS.items() if picture.startswith(start)), None)
    if kind is None:
        raise InputError("the picture: is no JPEG and no PNG")
    (lengths, pose), (later, _) = _at_rest(before, robot), _at_rest(after, robot)
    zero = {"zero": before["zero"], "robot": digest_of(robot)}
    if before["zero"] != after["zero"] or max(abs(a - b) for a, b in zip(lengths, later, strict=True)) > _SAME:
        raise InputError("the platform was moved, or homed, meanwhile: take the picture again once it stands")
    rows = _rows(folder)
    if len(rows) > MAX_PICTURES:
        raise InputError(
            f"there are {MAX_PICTURES} pictures already, and more are not kept: remove one, or begin again"
        )
    if not rows:
        write_whole(folder / _HOME, json.dumps(zero | {"lengths": lengths}).encode(), parents=True)
        rows = [",".join([*(f"dl_{at + 1}" for at in robot.hosts), *("x", "y", "z", "rx", "ry", "rz")[: robot.n]])]
    home = json.loads(read_bytes(folder / _HOME, MAX_PART, "lengths"))
    if not isinstance(home, dict) or {key: home.get(key) for key in zero} != zero:
        raise InputError(_ANEW)
    rows.append(",".join(map(repr, [*(lengths[at] - home["lengths"][at] for at in robot.hosts), *pose])))
    name = f"pose-{len(rows) - 1:02d}{kind}"
    write_whole(folder / _PICTURES / name, picture, parents=True)
    write_whole(folder / _DATA, "\n".join([*rows, ""]).encode())
    return name


def remove_last(folder: Path) -> None:
    """Remove the last picture and its lengths. Raises `InputError` where there is none."""
    rows = _rows(folder)
    if not rows:
        raise InputError("there is no picture")
    for picture in (folder / _PICTURES).glob(f"pose-{len(rows) - 1:02d}.*"):
        picture.unlink()
    if len(rows) > 2:
        write_whole(folder / _DATA, "\n".join([*rows[:-1], ""]).encode())
    else:
        (folder / _DATA).unlink()


def _rows(folder: Path) -> list[str]:
    """The header and the rows of the lengths; empty before the first picture."""
    path = folder / _DATA
    return read_bytes(path, MAX_PART, "lengths").decode().splitlines() if path.exists() else []


def told(folder: Path) -> dict[str, Any]:
    """Return what the page shows: files that are there, number of pictures, the guide's answer, the robot's file."""
    answer = folder / _ANSWER
    return {
        "parts": [part for part, name in PARTS.items() if (folder / name).is_file()],
        "pictures": max(len(_rows(folder)) - 1, 0),
        "answer": json.loads(read_bytes(answer, MAX_PART, "answer")) if answer.exists() else None,
        "room": (folder / ROOM).is_file(),
        "accepted": str(folder / _ROBOT) if (folder / _ROBOT).is_file() else "",
    }


def may_accept(folder: Path, confirmed: str) -> None:
    """Raise `InputError` where the calibration is bad, missing, or not *confirmed* by its subject."""
    answer = told(folder)["answer"] or {}
    if answer.get("verdict") not in ("good", "doubtful"):
        raise InputError("there is no calibration to accept yet")
    if confirmed != answer["subject"]:
        raise InputError(f"the calibration is {answer['verdict']}, and no operator confirmed this one")


def subject_of(folder: Path, robot: Robot) -> str:
    """Return the SHA-256 of the *robot* and of all files that a calibration depends on."""
    whole = hashlib.sha256(digest_of(robot).encode())
    for path in (*(folder / name for name in (*PARTS.values(), _DATA)), *sorted((folder / _PICTURES).glob("pose-*"))):
        if path.is_file():
            whole.update(hashlib.sha256(read_bytes(path, MAX_PICTURE, "file")).digest())
    return whole.hexdigest()


def _so_far(folder: Path, robot: Robot) -> tuple[Any, Any, Any]:
    """Return measurements, sightings and plan, as far as there are any."""
    from cablewright.calibration.guidance.pictures_to_take import sightings_so_far
    from cablewright.calibration.plan import load_plan
    from cablewright.foundation.progress import silent

    tags, camera, plan = (folder / name for name in PARTS.values())
    measured, seen = sightings_so_far(robot, folder / _DATA, folder / _PICTURES, tags, camera, silent)
    return measured, seen, load_plan(plan) if plan.exists() else None


def guide_next(folder: Path, robot: Robot) -> None:
    """Write the guide's answer to the pictures so far, and its picture of the room. Raises `CablewrightError`."""
    import cablewright as cw

    subject = subject_of(folder, robot)
    measured, seen, plan = _so_far(folder, robot)
    found = cw.guide(robot, measured, plan, sightings=seen)
    found.plot(folder / ROOM)
    shown = [
        {"name": each.path.name, "tags": [one.number for one in each.sightings], "left_out": each.left_out}
        for each in seen.pictures
        if each is not None
    ]
    verdict = None if found.found is None else found.found.verdict
    write_answer(folder, found.to_dict() | {"pictures": shown, "verdict": verdict, "subject": subject})


def write_answer(folder: Path, answer: dict[str, Any]) -> None:
    """Write what the page shows of the calibration. Raises `EnvironmentFault`."""
    write_whole(folder / _ANSWER, json.dumps(answer, allow_nan=False).encode(), parents=True)


def robot_text(robot: Robot) -> str:
    """Return the TOML text of a *robot*'s file."""
    import tomlkit

    return tomlkit.dumps({"schema": 1} | robot.model_dump(mode="json", exclude_none=True))


def begin_anew(folder: Path, *, keeps_robot: bool = True) -> None:
    """Remove pictures, lengths and answers: they are of other lengths or exit points. The files that were sent stay.

    *keeps_robot*: so does that of the calibration that was accepted.
    """
    from cablewright.calibration.drift.record import record_path

    rmtree(folder / _PICTURES, ignore_errors=True)
    robot = folder / _ROBOT
    for path in (
        *(folder / name for name in (_DATA, _HOME, _ANSWER, ROOM)),
        *(() if keeps_robot else (robot, record_path(robot))),
    ):
        path.unlink(missing_ok=True)


def accept(folder: Path, robot: Robot) -> None:
    """Write robot file and record of the calibration that a person has accepted. Raises `CablewrightError`."""
    import cablewright as cw
    from cablewright.calibration.drift.record import record_of, record_path, record_text
    from cablewright.calibration.guidance.pictures_to_take import usable
    from cablewright.calibration.plan import plan_of

    answer = told(folder)["answer"] or {}
    if answer.get("subject") != subject_of(folder, robot):
        raise InputError("the pictures have changed since the answer that was accepted: look at the new one")
    taken, _, plan = _so_far(folder, robot)
    measured, plan, _ = usable(taken, plan_of(plan))  # as the guide does
    assert measured is not None
    found = cw.calibrate(robot, measured, plan)
    if _VERDICTS.index(found.verdict) < _VERDICTS.index(answer["verdict"]):
        raise InputError(
            f"the calibration is {found.verdict}, not {answer['verdict']} as was accepted: {found.reasons[0]}"
        )
    write_whole(folder / _ROBOT, robot_text(found.robot).encode())
    write_whole(record_path(folder / _ROBOT), record_text(record_of(found, folder / _DATA, datetime.now(UTC))).encode())
