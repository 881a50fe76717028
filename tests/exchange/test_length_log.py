"""Logs of cable lengths as CSV: of a check, and of a machine, solved forward."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.exchange.length_log import forward_log, read_lengths
from cablewright.foundation.errors import InputError
from cablewright.models.statics import Model
from cablewright.printing.job import load_job
from cablewright.robot import load
from cablewright.studies.checks.check import check
from cablewright.studies.checks.tables import write_check

ROBOT = load("merlet2023")
POSES = np.linspace([-0.5, -1.0, 0.5], [0.8, 1.5, 1.5], 20)


def log_of(lengths: np.ndarray, header: str = "time [s];length 1 (mm);length_2_mm;Length 3 [mm];length 4 (mm)") -> str:
    rows = [f"{0.1 * k!r};" + ";".join(repr(1e3 * float(each)) for each in row) for k, row in enumerate(lengths)]
    return "\n".join([header, *rows])


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "log.csv"
    path.write_text(log_of(cw.inverse(ROBOT, POSES).lengths))
    return path


def test_a_machines_log_gives_the_poses_back(file: Path) -> None:
    names = [line.name for line in ROBOT.lines]
    text = file.read_text()
    for k, name in enumerate(names):
        for old in (f"length {k + 1} ", f"length_{k + 1}_", f"Length {k + 1} "):
            text = text.replace(old, old.replace(str(k + 1), name, 1), 1)
    file.write_text(text)
    found = forward_log(Model(ROBOT), read_lengths(file, ROBOT))
    assert (found.solved, found.refusal) == (20, "")
    np.testing.assert_allclose(found.poses.pose, POSES, atol=1e-7)
    assert found.log.time[3] == pytest.approx(0.3)


def test_the_lengths_of_a_check_give_its_path(tmp_path: Path) -> None:
    (tmp_path / "wall.gcode").write_text(";LAYER:0\nG1 X-500 Y-800 Z300 F9000\nG1 X500 Y700 E9\n")
    job = load_job(tmp_path / "wall.gcode")
    at_rest = job.model_copy(update={"motion": job.motion.model_copy(update={"shaping": "none"})})
    made = check(ROBOT, at_rest, skip=("interference", "expected-error"))
    write_check(made, tmp_path, "merlet2023", tmp_path / "wall.gcode")
    found = forward_log(Model(ROBOT), read_lengths(tmp_path / "lengths.csv", ROBOT))
    np.testing.assert_allclose(found.poses.pose, made.samples.positions, atol=1e-7)


def test_a_row_that_nothing_hangs_from_is_reported(tmp_path: Path) -> None:
    lengths = cw.inverse(ROBOT, POSES).lengths
    lengths[7] *= 0.5
    (tmp_path / "log.csv").write_text(named(log_of(lengths)))
    found = forward_log(Model(ROBOT), read_lengths(tmp_path / "log.csv", ROBOT))
    assert "row 8 first" in found.refusal
    assert found.poses.ok[:7].all()


def named(text: str) -> str:
    """The header with the names of the robot's lines."""
    header = "time (s);" + ";".join(f"length {line.name} (mm)" for line in ROBOT.lines)
    return "\n".join([header, *text.split("\n")[1:]])


GOOD = named(log_of(np.array([[5.0, 5.1, 5.2, 5.3]] * 3)))
FIRST = ROBOT.lines[0].name
BAD = {
    "no unit": (GOOD.replace(f"length {FIRST} (mm)", f"length {FIRST}"), f"column 'length {FIRST}' has no unit"),
    "no unit of time": (GOOD.replace("time (s)", "time"), "'time (s)' or 'time (ms)'"),
    "unknown unit": (GOOD.replace("(mm)", "(furlong)", 1), "unknown unit 'furlong'"),
    "a line is missing": (GOOD.replace(f"length {FIRST} (mm)", "other"), f"no column 'length {FIRST}'"),
    "twice": (GOOD.replace("time (s)", f"length {FIRST} (m)"), "no column 'time'"),
    "not a number": (GOOD.replace("0.1;", "0.1;x", 1), "must be a finite number"),
    "short row": (GOOD + "\n0.5;1;2", "3 cells; the header has 5"),
    "negative": (GOOD.replace("0.1;", "0.1;-", 1), "must be over 0"),
    "time falls": (GOOD.replace("0.2;", "0.05;", 1), "the time in row 3 is before"),
    "empty": ("", "is empty"),
    "header alone": (GOOD.split("\n")[0], "no rows"),
}


@pytest.mark.parametrize("what", BAD)
def test_bad_logs_are_one_line(what: str, tmp_path: Path) -> None:
    text, words = BAD[what]
    (tmp_path / "log.csv").write_text(text)
    with pytest.raises(InputError, match=r"^[^\n]*$") as caught:
        read_lengths(tmp_path / "log.csv", ROBOT)
    assert words in str(caught.value)
