"""Shaped motion in a check and on a simulated machine: no swing, lengths under the forces of acceleration, its cost."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from cablewright.analyses.modes import modes
from cablewright.control import path_follower
from cablewright.control.path_follower import GuideMode, GuideState, TimedPath
from cablewright.live.prints.limits import planned
from cablewright.live.prints.plan import PrintOptions, twin_of
from cablewright.live.prints.print_job import print_job
from cablewright.models.inertia import inertia_wrenches
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.swing_free_motion import JobMotion, lowest_frequencies
from cablewright.studies.checks.check import check

ROBOT = load("house-printer")
ALONE = ("interference", "expected-error")


def meander(folder: Path, width: float = 100.0, **motion: object) -> Job:
    """Ten lines 60 mm apart, at 0.3 m/s, whose corners swing the platform in step, and a straight line."""
    text = "G21\nG90\nM83\nG0 X-500 Y-500 Z500 F18000\n"
    for row in range(10):
        x = -500 + (width if row % 2 == 0 else 0)
        text += f"G1 X{x} Y{60 * row - 500} E9 F18000\nG1 X{x} Y{60 * row - 440} E1\n"
    (folder / "part.gcode").write_text(text + "G1 X700 Y100 E9\n")
    bead = {"width": 0.06, "height": 0.02}
    return Job.model_validate({"name": "m", "gcode": str(folder / "part.gcode"), "bead": bead, "motion": motion})


def test_a_meander_that_swings_too_far_is_rejected_and_shaped_it_is_not(tmp_path: Path) -> None:
    wild, calm = (check(ROBOT, meander(tmp_path, shaping=each), skip=ALONE) for each in ("none", "auto"))
    assert not wild.feasible
    assert wild.to_dict()["motion_error"] > 0.03
    assert calm.feasible
    assert calm.to_dict()["motion_error"] < 1e-3
    assert calm.to_dict()["duration_unshaped"] == pytest.approx(wild.law.duration)
    assert calm.law.duration > wild.law.duration
    assert "motion is shaped for modes from 1.8" in " ".join(calm.notes)


def test_commanded_lengths_hold_the_platform_while_it_accelerates(tmp_path: Path) -> None:
    found = check(ROBOT, meander(tmp_path), skip=ALONE)
    vector = found.law.vector
    assert vector is not None
    fast = int(np.linalg.norm(vector, axis=1).argmax())
    wrench = inertia_wrenches(ROBOT, found.poses[[fast]], vector[[fast]])
    held = solve_inverse(Model(ROBOT), found.poses[[fast]], wrenches=wrench)
    np.testing.assert_allclose(found.statics.commanded[fast], held.lengths[0], atol=1e-9)
    assert np.abs(found.statics.commanded[fast] - found.lengths[fast]).max() > 1e-4
    still = np.flatnonzero(~vector.any(axis=1))
    np.testing.assert_array_equal(found.statics.commanded[still], found.lengths[still])


def test_the_slowest_mode_is_the_first_of_the_modes(tmp_path: Path) -> None:
    job = meander(tmp_path)
    motion = JobMotion.of(ROBOT, job, job.samples(job.toolpath()))
    places = motion.path.positions[::40]
    lowest = modes(ROBOT, places).lowest
    np.testing.assert_allclose(lowest_frequencies(Model(ROBOT), places), lowest, rtol=1e-9)
    assert motion.shaper is not None
    np.testing.assert_allclose(1.0 / motion.shaper.period(places), lowest, rtol=0.01)


def test_a_job_that_wants_none_is_not_shaped_and_says_so(tmp_path: Path) -> None:
    job = meander(tmp_path, shaping="none")
    motion = JobMotion.of(ROBOT, job, job.samples(job.toolpath()))
    assert (motion.shaper, motion.why, motion.notes) == (None, 'motion.shaping = "none"', ())


def test_a_layer_shorter_than_the_shaper_is_reported(tmp_path: Path) -> None:
    (tmp_path / "dot.gcode").write_text("M83\nG1 X0 Y0 Z900 F9000\n;LAYER:0\nG1 X2 E1\n;LAYER:1\nG1 X2 Y400 Z910 E9\n")
    job = Job.model_validate(
        {"name": "dot", "gcode": str(tmp_path / "dot.gcode"), "bead": {"width": 0.06, "height": 0.02}}
    )
    notes = JobMotion.of(ROBOT, job, job.samples(job.toolpath())).notes
    assert any("is longer than layer 1, " in note and 'motion.shaping = "none"' in note for note in notes)


def test_layers_shorter_than_the_shaper_keep_their_place_and_do_not_swing(tmp_path: Path) -> None:
    """Dots of 4 cm, each 10 mm over the last: slow, on their path, layer by layer, and calm."""
    text = "G21\nG90\nM83\nG0 X0 Y0 Z800 F18000\n"
    for layer in range(6):
        text += f";LAYER:{layer}\nG0 Z{800 + 10 * layer}\nG1 X{40 * (1 - layer % 2)} E1 F18000\n"
    (tmp_path / "dots.gcode").write_text(text)
    bead = {"width": 0.06, "height": 0.01}
    job = Job.model_validate({"name": "dots", "gcode": str(tmp_path / "dots.gcode"), "bead": bead})
    found = check(ROBOT, job, skip=ALONE)
    path = found.shaping.path
    begin, way = path.positions[:-1], np.diff(path.positions, axis=0)
    away = []
    for point in found.samples.positions:
        share = np.clip(((point - begin) * way).sum(axis=1) / (way**2).sum(axis=1), 0.0, 1.0)
        away.append(np.linalg.norm(point - begin - share[:, None] * way, axis=1).min())
    assert max(away) <= found.job.motion.corner * 1.001
    assert set(found.samples.layer) == set(path.layer)
    assert found.feasible
    assert found.to_dict()["motion_error"] < 1e-3
    assert any("that shapes the motion is longer than layer" in note for note in found.notes)


def test_a_stop_keeps_its_ramp_and_a_jog_its_acceleration(tmp_path: Path) -> None:
    plans = []
    for shaping in ("none", "auto"):
        twin = twin_of(ROBOT, meander(tmp_path, shaping=shaping), None, PrintOptions())
        owner = twin.settings.owner
        plans.append(planned(ROBOT, owner, twin.path, owner.period, twin.estimator, "model", None))
    wild, calm = plans
    assert calm.path.shaping is not None
    assert calm.guard.stop == wild.guard.stop
    assert dataclasses.replace(calm.manual, period=None) == wild.manual
    assert calm.path.period is not None
    assert wild.path.period is None
    for plan in plans:  # a hold on the path slows down by the job's acceleration, as before
        state = GuideState(path_time=plan.path.duration - 3.0)
        speeds = [path_follower.step(plan.path, state, 0.01, GuideMode.FOLLOW).path_speed for _ in range(100)]
        held = [path_follower.step(plan.path, state, 0.01, GuideMode.HOLD).path_speed for _ in range(100)]
        assert held[-1] == 0.0
        assert sum(each > 0.0 for each in held) * 0.01 <= max(speeds) / plan.path.acceleration + 0.2


def test_material_leads_the_motion_by_the_pressure_advance(tmp_path: Path) -> None:
    flows = []
    for advance in (0.0, 0.2):
        path = TimedPath.of(meander(tmp_path, pressure_advance=advance), robot=ROBOT)
        state, found = GuideState(), []
        while state.path_time < path.duration:
            found.append(path_follower.step(path, state, 0.01, GuideMode.FOLLOW).flow)
        flows.append(np.array(found[100:-100]))
    np.testing.assert_allclose(flows[1][:-20], flows[0][20:], atol=2e-3)


def test_a_shaped_print_on_the_nonlinear_plant_swings_a_fifth_as_far(tmp_path: Path) -> None:
    found = [
        print_job(
            ROBOT, meander(tmp_path, shaping=each), tmp_path / each, options=PrintOptions(severity="ideal", seed=1)
        )
        for each in ("none", "auto")
    ]
    wild, calm = (each.record.to_dict()["max_path_error"] for each in found)
    assert calm < 0.25 * wild
