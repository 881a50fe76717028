"""A rigid platform prints in closed loop: true values, rejections before anything moves, and a print that goes on."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.signals import PrintState
from cablewright.live.prints.plan import MachineTwin, PrintOptions, plan_print, twin_of
from cablewright.live.prints.print_job import PrintedJob, print_job
from cablewright.machine.log.log import read_log
from cablewright.machine.simulated.settings import FaultPlan, TwinSettings, whole_machine
from cablewright.models.rotation import motion_between
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot, load
from cases import some

ROBOT = load("cogiro")
CHI2_OF_POSE = 12.6
"""Exceeded by one of 20 sums of 6 squares."""


def ring(**changes: object) -> Job:
    return Job.model_validate({
        "name": "ring",
        "origin": [0.4, -0.3, 0.0],
        "helix": {"radius": 0.4, "layers": 1, "layer_height": "12 mm", "first_height": "0.6 m"},
        "motion": {"print_speed": "5 cm/s", "travel_speed": "5 cm/s", "acceleration": "50 mm/s^2"},
        **changes,
    })  # fmt: skip


def printed(
    folder: Path, seed: int, estimator: str | None = None, machine: TwinSettings | None = None, **changes: object
) -> PrintedJob:
    options = PrintOptions(estimator, plant="quasi-static", period=0.5, seed=seed)
    return print_job(ROBOT, ring(**changes), folder, machine=machine, options=options)


def planned(job: Job, robot: Robot = ROBOT, machine: str | None = None) -> MachineTwin:
    twin = twin_of(robot, job, machine, PrintOptions(plant="quasi-static"))
    plan_print(twin)
    return twin


def squared_errors(folder: Path) -> np.ndarray:
    """Errors of the pose squared over its covariance (k,), of the steps that print: 6 are expected."""
    found, pose = [], [0, 1, 2, 6, 7, 8]
    with read_log(folder) as log:
        for entry in log.entries():
            assert entry.estimate is not None
            if entry.progress is None or entry.progress.state is not PrintState.PRINTING:
                continue
            true, told = (np.r_[each.position, each.rotation] for each in (entry.truth, entry.estimate))
            off, covariance = motion_between(true, told), np.array(entry.estimate.covariance)[np.ix_(pose, pose)]
            found.append(float(off @ np.linalg.solve(covariance, off)))
    return np.array(found)


@pytest.mark.slow  # of a point in test_tensions_by_cells.py
def test_a_body_prints_within_its_tensions_and_better_than_by_lengths_alone(tmp_path: Path) -> None:
    blind = whole_machine("cogiro").with_owner(load_cells=None)
    closed, by_cells = (printed(tmp_path / str(name), 21, name).record.whole for name in (None, "encoders"))
    open_ = printed(tmp_path / "blind", 21, "encoders", blind).record.whole
    assert closed.position_rms < 2e-3
    assert closed.position_max < 8e-3
    assert closed.orientation_max < np.radians(0.3)
    assert closed.min_tension_margin > 20.0
    assert open_.min_tension_margin < closed.min_tension_margin - 50.0
    assert closed.tension_error_rms < 15.0  # N of 100 N to 5 kN: the cells have errors of 5 N and 0.5 %
    assert closed.tension_error_max < 40.0
    assert open_.tension_error_rms > 5.0 * closed.tension_error_rms
    assert by_cells.min_tension_margin > 20.0  # encoders alone determine the pose, cells the tensions that move nothing
    assert by_cells.tension_error_rms < 15.0


@pytest.mark.slow
def test_a_machine_as_built_of_the_severity_typical_prints_and_nothing_is_doubted(tmp_path: Path) -> None:
    options = PrintOptions(plant="quasi-static", period=0.5, seed=31, severity="typical")
    done = print_job(ROBOT, ring(), tmp_path / "run", options=options)
    assert done.finished
    assert done.record.whole.position_rms < 4e-3
    assert done.record.whole.min_tension_margin > 50.0
    with read_log(tmp_path / "run") as log:
        faults = {fault.sentence for entry in log.entries() for fault in entry.estimate.faults}
    assert not faults
    assert squared_errors(tmp_path / "run").mean() < CHI2_OF_POSE


@pytest.mark.slow
@pytest.mark.parametrize("seed", some([41, 42, 43, 44]))
def test_a_pose_on_a_typical_machine_is_as_certain_as_its_covariance_says(seed: int, tmp_path: Path) -> None:
    options = PrintOptions(plant="quasi-static", period=0.5, seed=seed, severity="typical")
    assert print_job(ROBOT, ring(), tmp_path / "run", options=options).finished
    squared = squared_errors(tmp_path / "run")
    assert squared.mean() < CHI2_OF_POSE
    assert np.mean(squared < CHI2_OF_POSE) > 0.9


def test_the_platform_turns_by_the_schedule(tmp_path: Path) -> None:
    turned = [{"z": 0.5, "rotation": ["0 deg", "0 deg", "0 deg"]}, {"z": 0.7, "rotation": ["0 deg", "3 deg", "6 deg"]}]
    owner = whole_machine("cogiro").owner
    assert owner.body is not None
    near = ((1.4, -0.8, 1.5), (-0.6, -0.8, 1.5), (-0.6, 0.2, 1.5))  # a quarter of the library's way
    machine = whole_machine("cogiro").with_owner(body=owner.body.model_copy(update={"tour": near}))
    done = printed(tmp_path / "run", 22, machine=machine, schedule=turned)
    assert done.finished
    assert done.record.whole.orientation_max < np.radians(0.4)
    assert np.abs(done.record.rows["true_rotation"]).max() > np.radians(2.5)
    told = json.loads((tmp_path / "run" / "metrics.json").read_text())
    assert {"position_rms", "position_max", "orientation_max", "min_tension_margin"} <= told.keys()


def test_a_broken_line_stops_the_print_and_is_named(tmp_path: Path) -> None:
    fault = FaultPlan(source="line", line="4", kind="broken", begin=20.0)
    machine = whole_machine("cogiro").with_simulation(faults=(fault,))
    options = PrintOptions(plant="quasi-static", period=0.5, seed=23)
    done = print_job(ROBOT, ring(), tmp_path / "run", machine=machine, options=options)
    assert not done.finished
    assert "line 4" in done.run.reason


@pytest.mark.parametrize("line", [pytest.param("1", marks=pytest.mark.slow), "7"])
def test_a_line_off_its_sheave_is_named_once_the_platform_swings_less(tmp_path: Path, line: str) -> None:
    fault = FaultPlan(source="line", line=line, kind="off_sheave", begin=10.0)
    machine = whole_machine("cogiro").with_simulation(faults=(fault,))
    assert machine.owner.body is not None
    machine = machine.with_owner(body=machine.owner.body.model_copy(update={"tour": ()}))
    done = print_job(ROBOT, ring(), tmp_path / "run", machine=machine, options=PrintOptions(seed=24))
    *_, last = (span for span in done.record.spans if span.state is PrintState.FAULT)
    assert 0.5 < last.end - last.begin < 1.5  # it stands from the first doubt on, and is named later
    assert {name for name in "12345678" if f"line {name} " in done.run.reason} == {line}


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"schedule": [{"z": 0.5, "rotation": ["75 deg", "0 deg", "0 deg"]}]}, AnswerError, "turned by 75.0 deg"),
        ({"schedule": [{"z": 0.5, "retraction": "1 m"}]}, InputError, "has no retraction"),
        ({"origin": [6.5, 0.0, 0.0]}, AnswerError, "'cogiro' cannot hold the platform on the path"),
        ({"motion": {"print_speed": "5 m/s", "travel_speed": "5 m/s"}}, InputError, "too fast for the winches"),
        ({"motion": {"acceleration": "150 m/s^2"}}, AnswerError, "would fall slack under 15 m/s"),
    ],
)
def test_what_cannot_be_held_is_rejected_before_it_moves(
    changes: dict[str, object], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        planned(ring(**changes))


def test_a_tour_that_cannot_be_held_is_rejected_and_lengths_alone_make_none() -> None:
    machine = whole_machine("cogiro")
    assert machine.owner.body is not None
    for place, message in (((0.0, 0.0, -0.5), "it is out of the frame"), ((7.0, 0.0, 4.0), "no tensions")):
        body = machine.owner.body.model_copy(update={"tour": (place,)})
        twin = twin_of(ROBOT, ring(), machine.with_owner(body=body), PrintOptions(plant="quasi-static"))
        with pytest.raises(AnswerError, match=rf"\[body\] tour cannot be held by 'cogiro' at .*{message}"):
            plan_print(twin)
    twin = twin_of(ROBOT, ring(), None, PrintOptions("encoders", plant="quasi-static"))
    assert not len(twin.path.tour)
    assert len(planned(ring()).path.tour) == 4


def test_lines_that_would_touch_what_was_laid_are_rejected(tmp_path: Path) -> None:
    """A wall of two layers across the platform; its lower one is then higher than lines that come from below."""
    moves = [f"G0 X{x} Y-900 Z600\nG1 X{x} Y900 E9" for x in (700, 760)]
    moves += ["G0 X-500 Y0 Z300", "G1 X-400 Y0 E9"]
    (tmp_path / "wall.gcode").write_text("\n".join([";LAYER:0", "G21", "G90", "M83", *moves]) + "\n")
    (tmp_path / "job.toml").write_text(
        'schema = 1\nname = "wall"\ngcode = "wall.gcode"\n[bead]\nwidth = "60 mm"\nheight = "20 mm"\n'
        '[motion]\nprint_speed = "0.1 m/s"\ntravel_speed = "0.1 m/s"\nacceleration = "50 mm/s^2"\n'
    )
    with pytest.raises(AnswerError, match=r"line \d would touch what was laid, by \d+ mm, from the nozzle at"):
        planned(load_job(tmp_path / "job.toml"))


def test_a_retraction_beyond_its_stroke_or_too_fast_is_rejected() -> None:
    def job(schedule: list[dict[str, object]], speed: str) -> Job:
        helix = {"radius": 0.2, "layers": 3, "layer_height": "0.1 m", "first_height": "0.3 m"}
        motion = {"print_speed": speed, "travel_speed": speed}
        return ring(origin=[0.0, 0.0, 0.0], helix=helix, motion=motion, schedule=schedule)

    robot = load("jung2020")
    with pytest.raises(InputError, match=r"retracts from 1\.2 to 2 m"):
        planned(job([{"z": 0.3, "retraction": "2.1 m"}], "5 cm/s"), robot)
    with pytest.raises(InputError, match=r"the schedule retracts by .* at most 0\.02 is possible"):
        planned(job([{"z": 0.3, "retraction": "2 m"}, {"z": 0.31, "retraction": "1.5 m"}], "20 cm/s"), robot)


def test_fewer_lines_than_hold_the_position_are_rejected() -> None:
    robot = load("grab-four-lines")
    robot = robot.model_copy(update={"lines": robot.lines[:2]})
    machine = whole_machine("cogiro").with_owner(robot=None)
    with pytest.raises(InputError, match="print: robot 'grab-four-lines' has fewer winches than hold its"):
        plan_print(twin_of(robot, ring(), machine, PrintOptions(plant="quasi-static")))
