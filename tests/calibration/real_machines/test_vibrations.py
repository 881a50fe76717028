"""Frequencies of free cables as tensions of a calibration."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurement_rows.vibrations import with_vibrations
from cablewright.calibration.measurements import read_measured, write_measured
from cablewright.calibration.plan import CalibrationPlan, Sigmas
from cablewright.calibration.poses.simulation import SensorNoise, simulate_calibration
from cablewright.foundation.errors import InputError
from cablewright.robot import load

ROBOT = load("merlet2023")


def test_frequencies_serve_as_tensions_do() -> None:
    sensors = SensorNoise(frequency=0.02)
    made = simulate_calibration(ROBOT, 30, 1e-4, seed=3, cable="elastic", sensors=sensors).measured
    plan = CalibrationPlan(
        unknowns=("exit_point", "length_offset", "modulus"),
        shared=("modulus",),
        sigma=Sigmas(encoder=1e-4, frequency=0.02),
    )
    found = calibrate(ROBOT, made, plan, cable="elastic", rough=0.02, outliers=False)
    assert found.status == "ok"
    modulus = next(at for at, each in enumerate(found.unknowns) if each.name == "modulus")
    assert found.values[modulus] == pytest.approx(1.0, abs=4.0 * found.sigma[modulus])
    assert found.sigma[modulus] < 0.2
    chi = found.problem.derivatives(found.fit.theta, found.fit.poses).residual[:, ROBOT.m : 2 * ROBOT.m]
    assert 0.4 < float(np.sqrt(np.mean(chi**2))) < 1.3


def test_straight_lines_find_their_frame_by_frequencies() -> None:
    sensors = SensorNoise(frequency=0.02)
    made = simulate_calibration(ROBOT, 30, 1e-4, seed=4, sensors=sensors).measured
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4, frequency=0.02))
    found = calibrate(ROBOT, made, plan, rough=0.02, outliers=False)
    without = calibrate(ROBOT, replace(made, frequencies=None), plan, rough=0.02, outliers=False)
    assert found.problem.measured.tensions is not None
    assert found.exit_sigma is not None
    assert without.exit_sigma is not None
    assert found.exit_sigma < 0.5 * without.exit_sigma


def test_columns_of_frequencies_are_read_and_written(tmp_path: Path) -> None:
    made = simulate_calibration(ROBOT, 4, 1e-4, seed=4, sensors=SensorNoise(frequency=0.0)).measured
    file = tmp_path / "d.csv"
    text = write_measured(made, ROBOT)
    assert "hz_1" in text
    file.write_text(text)
    read = read_measured(file, ROBOT)
    assert read.frequencies == pytest.approx(made.frequencies)
    file.write_text(text.replace("hz_4", "hz_5"))
    with pytest.raises(InputError, match="has 4 lines"):
        read_measured(file, ROBOT)


def test_frequencies_without_a_span_or_a_mass_are_rejected() -> None:
    plan = CalibrationPlan()
    made = simulate_calibration(ROBOT, 4, 1e-4, seed=4, sensors=SensorNoise(frequency=0.0, tension=0.0)).measured
    with pytest.raises(InputError, match=r"pose 1: hz_1 and f_1: give one of them"):
        with_vibrations(ROBOT, made, plan, made.guess)
    alone = replace(made, tensions=None)
    with pytest.raises(InputError, match="require columns x,y,z"):
        with_vibrations(ROBOT, alone, plan, None)
    assert made.frequencies is not None
    with pytest.raises(InputError, match="pose 1: hz_1: must be over 0 Hz"):
        with_vibrations(ROBOT, replace(alone, frequencies=-made.frequencies), plan, made.guess)
    cable = ROBOT.lines[0].cable.model_copy(update={"linear_density": 0.0})
    lines = tuple(line.model_copy(update={"cable": cable}) for line in ROBOT.lines)
    light = ROBOT.model_copy(update={"lines": lines})
    with pytest.raises(InputError, match=r"has no cable.linear_density; leave them out"):
        with_vibrations(light, alone, plan, made.guess)
    with pytest.raises(InputError, match=r"frequency noise: line .* has no cable.linear_density"):
        simulate_calibration(light, 4, 1e-4, seed=4, cable="elastic", sensors=SensorNoise(frequency=0.0))


def test_the_zero_of_a_load_cell_is_not_that_of_a_frequency() -> None:
    """Both would be shifted by it: cells that read 20 N too much, and frequencies without an error, did not fit."""
    made = simulate_calibration(ROBOT, 4, 1e-4, seed=4, sensors=SensorNoise(frequency=0.02, tension=0.5)).measured
    assert made.tensions is not None
    assert made.frequencies is not None
    by_cell = np.arange(4)[:, None] < 2
    tensions, frequencies = np.where(by_cell, made.tensions + 20.0, np.nan), np.where(by_cell, np.nan, made.frequencies)
    mixed = replace(made, tensions=tensions, frequencies=frequencies)
    for name in ("tension_offset", "tension_scale"):
        plan = CalibrationPlan(unknowns=("exit_point", "length_offset", name))
        with pytest.raises(InputError, match=f"unknowns: {name}: is of load cells"):
            calibrate(ROBOT, mixed, plan, cable="elastic")
    scaled = CalibrationPlan(unknowns=("exit_point", "length_offset", "tension_scale"))  # of densities, then
    assert with_vibrations(ROBOT, replace(made, tensions=None), scaled, made.guess).tensions is not None
