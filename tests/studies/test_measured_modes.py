"""Measured modes beside the model's: a real swing, a changed twin, a simulated machine, and what is rejected."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cablewright.analyses.modes import modes
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Command, Estimate, SensorFrame
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import write_log
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import RigidPlatform, Robot, load
from cablewright.studies.measured_modes import measured_modes

Array = NDArray[np.float64]
REAL = Path(__file__).parents[2] / "examples" / "free-swing.csv"
POSE = [0.982, np.nan, -0.2038, np.nan, np.nan, np.nan]
GRAB = load("grab-prototype").with_lines(["1", "3"])


def with_inertia(robot: Robot, factor: float) -> Robot:
    platform = robot.platform
    assert isinstance(platform, RigidPlatform)
    scaled = {key: tuple(factor * each for each in getattr(platform, key)) for key in ("inertia", "inertia_products")}
    return robot.model_copy(update={"platform": platform.model_copy(update=scaled)})


def written(path: Path, times: Array, positions: Array) -> Path:
    """A CSV file of positions (N, 3 k), m."""
    names = [f"{axis}{k + 1 if k else ''}" for k in range(positions.shape[1] // 3) for axis in "xyz"]
    rows = [",".join(f"{value:.6f}" for value in (time, *row)) for time, row in zip(times, positions, strict=True)]
    path.write_text("\n".join([",".join(["t", *names]), *rows]) + "\n", "utf-8")
    return path


def twin(path: Path, robot: Robot, pose: Any, damping: float, rate: float = 50.0, duration: float = 12.0) -> Path:
    """A CSV file of one marker of a platform that swings in the pendulum modes of *robot*."""
    found, random = modes(robot, pose), np.random.default_rng(3)
    times = np.arange(0.0, duration, 1.0 / rate)
    place = np.zeros((len(times), 3))
    for k, frequency in enumerate(found.frequencies[: 6 - robot.m]):
        w = 2.0 * np.pi * frequency
        wave = np.exp(-damping * w * times) * np.cos(w * times + random.uniform(0.0, 6.0))
        moved = found.shapes[:3, k] + np.cross(found.shapes[3:, k], [0.1, 0.05, 0.2])
        place += 0.03 * np.outer(wave, moved / np.linalg.norm(moved))
    return written(path, times, place + 1e-5 * random.normal(size=place.shape))


def test_a_real_swing() -> None:
    """Frequencies within 1 % and damping within a factor of 1.5 of those identified from all five markers."""
    found = measured_modes(GRAB, REAL, POSE)
    expected = np.array([[0.6509, 1.0111, 2.5734, 3.5872], [0.0025, 0.0048, 0.0038, 0.0043]])
    compared = [k >= 0 for k in found.matched]
    np.testing.assert_allclose(found.swing.frequencies[compared], expected[0], rtol=0.01)
    ratios = found.swing.damping[compared] / expected[1]
    assert ((ratios > 1 / 1.5) & (ratios < 1.5)).all()
    assert [row["motion"] for row in found.rows if "motion" in row] == ["pendulum"] * 4
    assert any("is twice 1.011 Hz: it may be an overtone" in note for note in found.notes)


def test_a_wrong_inertia_is_what_explains_the_difference(tmp_path: Path) -> None:
    path = twin(tmp_path / "swing.csv", with_inertia(GRAB, 0.8), POSE, 0.004)
    found = measured_modes(GRAB, path, POSE)
    best = {each.number: each for each in found.explanations}["inertia"]
    assert found.explanations[0].number in ("inertia", "mass")  # a pendulum's frequency has their ratio
    assert best.fitted == pytest.approx(0.8, abs=0.01)
    assert best.explains > 0.99
    assert 0.003 < found.measured_damping < 0.005


def test_a_swing_as_modelled_needs_no_explanation(tmp_path: Path) -> None:
    found = measured_modes(GRAB, twin(tmp_path / "swing.csv", GRAB, POSE, 0.004), POSE)
    assert any(note.startswith("the measured frequencies agree with the model's") for note in found.notes)


@pytest.fixture(scope="module")
def shoved(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Robot, Array]:
    """The log of a simulated machine whose winches jerk and then rest, its text, and its pose."""
    twin, robot = load_twin("cogiro"), load("cogiro")
    machine = SimulatedMachine(robot, twin, [0.0, 0.0, 2.0], seed=1)
    path = tmp_path_factory.mktemp("log") / "shoved.mcap"
    head = LogHead(robot, twin.owner, machine.period, simulation=twin.simulation, plant="dynamic", seed=1)
    speeds = np.random.default_rng(0).uniform(-0.6, 0.6, robot.m)
    with write_log(path, head, flush_every=None) as log:
        for k in range(900):
            moved = speeds if 50 <= k < 70 else -speeds if 70 <= k < 90 else np.zeros(robot.m)
            command = Command(machine.time, moved)
            log.write(machine.step(command), command, machine.truth)
    return path, machine.robot, np.concatenate([machine.truth.position, machine.truth.rotation])


@pytest.mark.parametrize("signal", [None, "load-cells"])
def test_a_simulated_machine_swings_as_it_is_built(shoved: tuple[Path, Robot, Array], signal: Any) -> None:
    path, built, pose = shoved
    found = measured_modes(load("cogiro"), path, pose, signal=signal)
    true = modes(built, pose).frequencies
    assert found.record.signal == (signal or "inertial")
    assert found.start >= 0.9  # after the winches came to rest
    strong = found.swing.shares > 0.1
    nearest = abs(np.log(found.swing.frequencies[:, None] / true)).argmin(axis=1)
    np.testing.assert_allclose(found.swing.frequencies[strong], true[nearest[strong]], rtol=0.01)


def test_estimates_of_a_log_give_swing_and_pose(tmp_path: Path) -> None:
    """Of a point: no --at, no --signal, and the winches pay out before they rest."""
    robot, twin = load("house-printer"), load_twin("house-printer")
    place = np.array([1.0, 2.0, 6.0])
    frequency = float(modes(robot, place).frequencies[0])
    path = tmp_path / "swing.mcap"
    nothing, random = np.zeros(robot.m), np.random.default_rng(0)
    head = LogHead(robot, twin.owner, 0.01, simulation=twin.simulation, plant="dynamic", seed=1)
    with write_log(path, head, flush_every=None) as log:
        for k in range(1500):
            time = 0.01 * (k + 1)
            w = 2.0 * np.pi * frequency
            moved = 5e-3 * np.exp(-0.008 * w * time) * np.sin(w * time) * np.array([1.0, -0.5, 0.1])
            at = place + (moved if time > 3.0 else [0.05 * (3.0 - time), 0.0, 0.0]) + 1e-4 * random.normal(size=3)
            estimate = Estimate(time, at, np.zeros(3), np.zeros(3), nothing, nothing, nothing > 1.0, nothing + 0.1)
            command = Command(time, nothing + (1.0 if time < 3.0 else 0.0))
            log.write(SensorFrame(time), command, None, estimate)
    found = measured_modes(robot, path)
    assert found.record.signal == "positions"
    assert found.start == pytest.approx(3.0, abs=0.02)
    np.testing.assert_allclose(found.model.equilibrium.pose, place, atol=1e-3)
    np.testing.assert_allclose(found.swing.frequencies, [frequency], rtol=2e-3)
    np.testing.assert_allclose(found.swing.damping, [0.008], rtol=0.1)
    with pytest.raises(InputError, match="no readings of inertial; a swing is identified from these"):
        measured_modes(robot, path, signal="inertial")


def test_modes_out_of_reach_are_named(tmp_path: Path) -> None:
    """Stretch over half the sampling rate; a pendulum too slow for the record."""
    slow = measured_modes(GRAB, twin(tmp_path / "swing.csv", GRAB, POSE, 0.004, rate=12.0, duration=20.0), POSE)
    assert any("24.8 Hz, was not found: it is over half the sampling rate, 6 Hz" in note for note in slow.notes)
    short = measured_modes(GRAB, twin(tmp_path / "swing.csv", GRAB, POSE, 0.004, rate=50.0, duration=3.5), POSE)
    assert any("hold fewer than 3 periods; at least 4.72 s are needed" in note for note in short.notes)


def edited(edit: Callable[[list[str]], list[str]], path: Path) -> Path:
    rows = [row for row in REAL.read_text("utf-8").splitlines() if not row.startswith("#")]
    path.write_text("\n".join(edit(rows)) + "\n", "utf-8")
    return path


@pytest.mark.parametrize(
    ("edit", "says"),
    [
        (lambda rows: rows[:29], "swing.csv: no swing: 28 samples; at least 100 are needed"),
        (lambda rows: [rows[0], *(f"{k * 0.02:.2f},1,2,3" for k in range(300))], "no swing: nothing moves"),
        (lambda rows: [rows[0].replace("z", "w"), *rows[1:]], "no column 'z'"),
        (lambda rows: [rows[0].replace("t", "when"), *rows[1:]], "no column 't', also called time"),
        (lambda rows: [*rows, rows[-1]], "t does not rise in row 252"),
        (lambda rows: rows[:2], "fewer than 2 rows"),
        (lambda rows: [], "is empty; a header and rows of positions are needed"),
        (lambda rows: [*rows, "11.0,1,nan,2"], "y = 'nan': must be a finite number"),
    ],
)
def test_bad_files_are_rejected_in_one_line(edit: Callable[[list[str]], list[str]], says: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        measured_modes(GRAB, edited(edit, tmp_path / "swing.csv"), POSE)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_a_csv_file_cannot_have_is_rejected() -> None:
    with pytest.raises(InputError, match="does not say where the platform was: give --at"):
        measured_modes(GRAB, REAL)
    with pytest.raises(InputError, match=r"--signal inertial: .* has positions alone"):
        measured_modes(GRAB, REAL, POSE, signal="inertial")
    with pytest.raises(InputError, match="nothing was recorded within the span; it is from 0 to 10 s"):
        measured_modes(GRAB, REAL, POSE, span=(20.0, 30.0))
