"""The fastest motion takes a lower acceleration where it would break tension limits or the error of the job."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.analyses.motion.lower_acceleration import slower_note
from cablewright.analyses.travel_moves import driven_job
from cablewright.live.prints.plan import PrintOptions, twin_of
from cablewright.printing import job as job_module
from cablewright.printing.beads import Bead
from cablewright.printing.job import Job
from cablewright.robot import load
from cablewright.studies.checks.check import check

ROBOT = load("house-printer")
SKIP = ("interference", "expected-error")


def meander(folder: Path, max_error: str | None = None, **motion: Any) -> Job:
    text = "G21\nG90\nM83\nG0 X-500 Y-500 Z500 F18000\n"
    for row in range(8):
        x = -500 + (100 if row % 2 == 0 else 0)
        text += f"G1 X{x} Y{60 * row - 500} E9 F18000\nG1 X{x} Y{60 * row - 440} E1\n"
    (folder / "part.gcode").write_text(text + "G1 X700 Y100 E9\n")
    motion = {"speed": "fastest", "print_speed": 0.5, "travel_speed": 0.5, **motion}
    more = {} if max_error is None else {"max_error": max_error}
    return Job.model_validate({"name": "m", "gcode": str(folder / "part.gcode"), "motion": motion, **more})


FAST = {"acceleration": 8.0, "print_speed": 2.0, "travel_speed": 2.0}


def test_a_fast_motion_that_swings_too_far_is_slower_until_it_does_not(tmp_path: Path) -> None:
    fast = check(ROBOT, meander(tmp_path, "10 mm", **FAST), skip=SKIP).to_dict()
    assert fast["acceleration"] == 8.0
    found = check(ROBOT, meander(tmp_path, "1 mm", **FAST), skip=SKIP)
    now = found.to_dict()["acceleration"]
    assert 0.4 < now < 8.0
    assert found.to_dict()["motion_error"] <= 0.5e-3 < fast["motion_error"]
    assert f"acceleration {now:.3g} m/s^2 in place of 8" in " ".join(found.notes)


def test_tensions_that_motion_would_break_make_it_slower(tmp_path: Path) -> None:
    job = meander(tmp_path, "1 m", **FAST)
    most = check(ROBOT, job, skip=SKIP).to_dict()["max_tension"] - 100.0
    found = check(ROBOT.limited((100.0, most)), job, skip=SKIP)
    assert 0.4 < found.to_dict()["acceleration"] < 8.0
    assert found.to_dict()["max_tension"] <= most
    assert found.feasible


def test_a_print_has_the_acceleration_of_the_check(tmp_path: Path) -> None:
    job = meander(tmp_path, "1 mm", **FAST)
    slow, _ = driven_job(ROBOT, job)
    twin = twin_of(ROBOT, job, None, PrintOptions(severity="ideal"))
    assert twin.path.acceleration == slow.motion.acceleration < 8.0
    assert slower_note(job, slow)[0] in twin.notes
    assert check(ROBOT, job, skip=SKIP).to_dict()["acceleration"] == slow.motion.acceleration


@pytest.mark.parametrize("motion", [{"speed": "gcode"}, {"shaping": "none"}, {"acceleration": 0.3}])
def test_feeds_of_a_file_and_a_motion_within_limits_stay_as_they_are(tmp_path: Path, motion: dict[str, Any]) -> None:
    job = meander(tmp_path, "2 mm", **FAST | motion)
    slow, _ = driven_job(ROBOT, job)
    assert slow.motion.acceleration == job.motion.acceleration
    assert slower_note(job, slow) == ()


def test_beads_as_given_are_those_of_the_flow_limit_and_found_once(tmp_path: Path, monkeypatch: Any) -> None:
    calls, real = [], job_module.beads_of
    monkeypatch.setattr(job_module, "beads_of", lambda *args: calls.append(1) or real(*args))
    job = meander(tmp_path, speed="gcode", flow_limit="0.1 l/s")
    thin, thick = (
        check(ROBOT, job, skip=SKIP, bead=Bead(width=width, height=0.02)).law.duration for width in (0.03, 0.06)
    )
    assert len(calls) == 2
    assert thick > 1.3 * thin
    speeds = check(ROBOT, job, skip=SKIP, bead=Bead(width=0.06, height=0.02)).samples
    section = Bead(width=0.06, height=0.02).section
    assert np.max(speeds.speed_limit[speeds.extruding]) == pytest.approx(1e-4 / section)
