"""Effects that cross-validation asks for: the right one is chosen, none where the model is right, errors fall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.campaigns.twins import errors, spools

from cablewright.calibration.calibrate import _calm, calibrate
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Known, Sigmas
from cablewright.calibration.poses.simulation import SensorNoise, measure, random_poses
from cablewright.foundation.errors import InputError
from cablewright.models.drum import WinchDrum
from cablewright.robot import Robot, load
from cases import often, some

WANG = load("wang2021")
EXITS = np.array([line.exit_point for line in WANG.lines]).ravel()
SOFT = {"axial_stiffness": 1e5, "young_modulus": None, "section": None}


def made_with(effect: str, seed: int) -> tuple[Robot, Measured]:
    """The file, and 44 poses measured to 2 mm of a machine with an *effect* that straight lines do not have."""
    lines = [line.model_copy(update={"cable": line.cable.model_copy(update=SOFT)}) for line in WANG.lines]
    robot = WANG.model_copy(update={"lines": tuple(lines)}) if effect == "stretch" else WANG
    rng = np.random.default_rng(seed)
    law = "elastic" if effect == "stretch" else "rigid"
    made = measure(robot, random_poses(robot, 44, rng), 2e-4, rng, cable=law, sensors=SensorNoise(pose=2e-3)).measured
    counted = made.counted
    if effect == "build_up":
        counted = WinchDrum(1.0, build_up=4e-3).angles(counted)
    if effect == "hysteresis":
        counted = counted - 1e-3 * np.sign(np.diff(counted, axis=0, prepend=counted[:1]))
    return robot, replace(made, counted=counted)


def error_of(found: Calibration) -> float:
    return float(np.sqrt(np.mean((found.values[:12] - EXITS) ** 2)))


@pytest.mark.parametrize(
    ("effect", "number", "tolerance"),
    some([("build_up", 4e-3, 3e-4), ("hysteresis", 1e-3, 1e-4), ("stretch", 1.0, 0.1)], fast=2),
)
def test_the_effect_that_the_machine_has_is_found(effect: str, number: float, tolerance: float) -> None:
    robot, measured = made_with(effect, 1)
    search = effect == "stretch"  # poses near the height of exit points stretch lines by centimetres
    plain = calibrate(robot, measured, rough=0.05, outliers=search)
    found = calibrate(robot, measured, rough=0.05, outliers=search, models="auto")
    first, *others = found.effects
    assert plain.effects == ()
    assert (first.name, first.chosen) == (effect, True)
    assert first.value == pytest.approx(number, abs=tolerance)
    assert first.after < 0.85 * first.before
    assert first.fall == pytest.approx(1.0 - first.after / first.before)
    assert not any(each.chosen for each in others)
    assert error_of(found) < 0.5 * error_of(plain)
    assert ("build_up" in found.problem.plan.unknowns) == (effect == "build_up")
    assert any("counts are corrected" in each for each in found.notes) == (effect != "build_up")
    assert found.to_dict()["effects"][0]["name"] == effect


def test_too_few_calm_poses_are_no_reason_to_reject_the_data() -> None:
    soft = made_with("stretch", 2)[0]
    rng = np.random.default_rng(2)
    made = measure(soft, random_poses(soft, 13, rng), 1e-4, rng, cable="elastic").measured
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4))
    plain = calibrate(soft, made, plan, rough=0.05, outliers=False)
    calm = _calm(plain)
    assert calm is not None
    with pytest.raises(InputError, match="10 poses; at least 12 are required"):
        calibrate(soft, made.only(calm), plan, rough=0.05, outliers=False)
    assert calibrate(soft, made, plan, rough=0.05, outliers=False, models="auto").status == "ok"


def test_a_right_model_is_left_as_it_is() -> None:
    for seed in range(often(2, 4)):
        robot, measured = made_with("none", seed)
        found = calibrate(robot, measured, rough=0.05, outliers=False, models="auto")
        assert len(found.effects) == 7
        assert not any(each.chosen for each in found.effects)
        assert found.values == pytest.approx(calibrate(robot, measured, rough=0.05, outliers=False).values)


def test_what_is_unknown_or_has_no_part_is_no_candidate() -> None:
    robot, measured = made_with("none", 5)
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "build_up"), shared=("build_up",))
    found = calibrate(load("wang2021"), measured, plan, rough=0.05, outliers=False, models="auto")
    assert {each.name for each in found.effects} == {
        *("stretch", "sag", "deflection", "hysteresis", "sheave_radius", "length_scale")
    }
    spools = load("hangprinter-v4")
    rng = np.random.default_rng(6)
    data = measure(spools, random_poses(spools, 44, rng), 2e-4, rng).measured
    names = {each.name for each in calibrate(spools, data, rough=0.05, outliers=False, models="auto").effects}
    assert "sheave_radius" not in names
    assert robot == WANG


def test_a_spool_printer_with_a_makers_defects_finds_held_out_positions() -> None:
    """Friction, softer lines, a build-up known to 10 %, positions wrong by 3 mm, anchors that deflect."""
    twin = spools(1006)
    plain = calibrate(twin.file, twin.measured, twin.plan, rough=0.05, need=5e-3)
    found = calibrate(twin.file, twin.measured, twin.plan, rough=0.05, need=5e-3, models="auto")
    own, before = (float(np.sqrt(np.mean(errors(twin, each, twin.counts) ** 2))) for each in (found, plain))
    assert {each.name for each in found.effects if each.chosen} & {"stretch", "deflection"}
    assert own < 2.5e-3
    assert own < before


def test_lengths_that_count_a_build_up_get_no_other() -> None:
    lines = [
        line.model_copy(update={"winch": line.winch.model_copy(update={"build_up": 0.012, "drum_length": 5.0})})
        for line in load("hangprinter-v4").lines
    ]
    robot = load("hangprinter-v4").model_copy(update={"lines": tuple(lines)})
    rng = np.random.default_rng(4)
    made = measure(robot, random_poses(robot, 44, rng), 2e-4, rng).measured
    wrong = replace(made, counted=WinchDrum(1.0, build_up=6e-3).angles(made.counted))
    found = calibrate(robot, wrong, rough=0.05, outliers=False, models="auto")
    assert "build_up" not in {each.name for each in found.effects}


def test_an_effect_without_a_solution_is_not_in_the_model(monkeypatch: pytest.MonkeyPatch) -> None:
    robot, measured = made_with("hysteresis", 1)
    plain = calibrate(robot, measured, rough=0.05, outliers=False)
    fits = iter((plain, replace(plain, status="degenerate")))
    monkeypatch.setattr("cablewright.calibration.calibrate._fitted", lambda *_: next(fits))
    found = calibrate(robot, measured, rough=0.05, outliers=False, models="auto")
    assert found.fit is plain.fit
    assert not any(each.chosen for each in found.effects)
    assert "hysteresis" in {each.name for each in found.effects}
    assert any("hysteresis: left out" in each for each in found.notes)


def test_a_number_that_the_plan_knows_is_no_effect() -> None:
    _, measured = made_with("none", 5)
    known = (Known(name="build_up", deviation=0.0), Known(name="stretch", deviation=0.1))
    found = calibrate(WANG, measured, CalibrationPlan(known=known), rough=0.05, outliers=False, models="auto")
    assert not {each.name for each in found.effects} & {"build_up", "stretch"}


def test_the_number_of_a_chosen_effect_is_in_the_covariance() -> None:
    robot, measured = made_with("hysteresis", 1)
    found = calibrate(robot, measured, rough=0.05, outliers=False, models="auto")
    without = replace(found, effects=())
    assert (found.sigma[:12] >= 0.999 * without.sigma[:12]).all()
    considered = {each.name: each for each in found.doubt.considered}
    assert considered["hysteresis"].probability == 1.0
    assert 0.0 < considered["deflection"].probability < 1.0
    assert abs(considered["hysteresis"].value) < 3.0 * considered["hysteresis"].sigma
