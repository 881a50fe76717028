"""A machine that lays strands: what leaves the nozzle lies, as wide and high as the bead; it swings as it should."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Command
from cablewright.machine.files import load_machine, machine_text
from cablewright.machine.settings import extruding
from cablewright.machine.simulated.deposition import extrude
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.statics import Model
from cablewright.printing.heightfield import HeightField
from cablewright.printing.job import Bead
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from twins import SETTINGS, changed, run

ROBOT, TWIN = load("house-printer"), load_twin("house-printer")
HOUSE = TWIN.owner
START = (-1.0, 0.5, 0.5)


def printer(settings: Any = TWIN, plant: Any = "dynamic", start: Any = START) -> SimulatedMachine:
    return SimulatedMachine(ROBOT, settings, start, seed=2, plant=plant)


def go(twin: SimulatedMachine, way: np.ndarray, speed: float, valve: float = 1.0) -> float:
    """Go straight by *way* (3,) at *speed*, its lengths as they should be; return how much was fed, kg."""
    begin = twin.truth.position
    steps = round(float(np.linalg.norm(way)) / speed / twin.period)
    places = begin + np.linspace(0.0, 1.0, steps + 1)[:, None] * way
    lengths = solve_inverse(Model(twin.robot), places).lengths
    for here, there in pairwise(lengths):
        rate = (there - here) / twin.period + 2.0 * (here - twin.truth.lengths)
        twin.step(Command(twin.time, rate / twin.truth.radii, valve))
    return twin.settings.drum.flow * valve * steps * twin.period


@pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])
def test_what_is_fed_lies(plant: str) -> None:
    twin, fed = printer(plant=plant), 0.0
    for way, speed, valve in (((1.5, 0.5, 0.0), 0.3, 1.0), ((0.0, -1.0, 0.0), 0.5, 0.0), ((-1.0, 0.0, 0.1), 0.2, 0.6)):
        fed += go(twin, np.array(way), speed, valve)
        assert twin.rig.ground.mass + twin.rig.falling_mass == pytest.approx(fed, rel=1e-9)
    run(twin, 3)
    assert twin.rig.falling_mass == 0.0
    volume = fed / HOUSE.extrusion.density
    assert twin.rig.ground.field.volume == pytest.approx(volume, rel=1e-9)
    assert twin.rig.ground.outside_mass == 0.0
    assert twin.truth.powder == 0.0
    with pytest.raises(InputError, match="the drum takes 0 to 0 kg"):
        twin.refill(1.0)


def test_a_strand_has_the_section_of_its_bead() -> None:
    bead = Bead(width=0.1, height=0.03)
    twin = printer(TWIN.model_copy(update={"owner": extruding(HOUSE, bead, 0.3)}), plant="quasi-static")
    go(twin, np.array([2.0, 0.0, 0.0]), 0.3)
    run(twin, 2)
    ground = twin.rig.ground
    across = ground.heights[ground.field.cells_of(np.array([[0.0, 0.5]]))[0, 0] - 20 :][:40]
    assert across.sum(axis=1).mean() * ground.field.cell == pytest.approx(bead.section, rel=0.02)
    assert np.count_nonzero(across.mean(axis=0)) in (5, 6, 7)
    assert across.max() == pytest.approx(bead.section / bead.width, rel=0.25)


def test_a_job_sets_the_extruder_and_no_drum_of_powder() -> None:
    bead = Bead(width=0.05, height=0.01)
    made = extruding(HOUSE, bead, 0.2)
    assert made.extrusion is not None
    assert made.extrusion.bead == bead
    assert made.drum.flow == pytest.approx(2200 * 0.2 * (0.05 * 0.01 - (1 - np.pi / 4) * 1e-4))
    assert HOUSE.drum.flow == pytest.approx(extruding(HOUSE, HOUSE.extrusion.bead, 0.3).drum.flow, rel=1e-4)
    assert extruding(SETTINGS, bead, 0.2) is SETTINGS


def test_a_drum_that_holds_powder_says_how(tmp_path: Path) -> None:
    for key in ("powder_density", "radius", "powder_bottom"):
        lines = [line for line in machine_text("merlet2023").splitlines() if not line.startswith(f"{key} =")]
        (tmp_path / "own.toml").write_text("\n".join(lines))
        with pytest.raises(InputError, match=f"{key}: must be given where capacity is"):
            load_machine(tmp_path / "own.toml")


def test_a_strand_keeps_its_volume_where_the_nozzle_stands_and_at_the_edge() -> None:
    field, random = HeightField.flat((0.0, 0.0), (1.0, 1.0), 0.02), np.random.default_rng(3)
    start = np.vstack([random.random((30, 2)), [[0.5, 0.5], [0.001, 0.3]]])
    end = np.vstack([random.random((30, 2)), [[0.5, 0.5], [0.001, 0.4]]])
    volumes = random.random(32) * 1e-3
    extrude(field, start, end, volumes, 0.06)
    assert field.volume == pytest.approx(volumes.sum(), rel=1e-12)


def test_both_plants_come_to_rest_at_the_equilibrium_of_the_solver() -> None:
    still = changed(TWIN, climate={"swing": 0.0}, drum={"swing_damping": 500.0, "drag": 4000.0, "yaw_wander": 0.0})
    for plant in ("dynamic", "quasi-static"):
        twin = printer(still, plant)
        np.testing.assert_allclose(twin.truth.position, START, atol=1e-9)
        run(twin, round(2.0 / twin.period), (2.0, -2.0, -1.0, 3.0))
        run(twin, round(20.0 / twin.period))
        hung = solve_forward(Model(twin.robot), twin.truth.lengths, guess=twin.truth.position).checked()
        np.testing.assert_allclose(twin.truth.position, hung.pose, atol=1e-7)
        np.testing.assert_allclose(twin.truth.tensions, hung.tensions, rtol=1e-4)


def test_a_substep_of_two_milliseconds_is_short_enough() -> None:
    """Driven by hard jerks, B goes the same way at a quarter of the substep; lines are stiff, the head is heavy."""
    ways = []
    for substep in (2e-3, 5e-4):
        twin = printer(TWIN.with_simulation(substep=substep))
        way = []
        for k in range(300):
            speeds = 5.0 * np.array([1.0, -1.0, -1.0, 1.0]) * (1 if (k // 50) % 2 else -1)
            twin.step(Command(twin.time, speeds))
            way.append(twin.truth.position)
        ways.append(np.array(way))
    assert np.ptp(ways[0], axis=0).max() > 0.2
    assert np.abs(ways[0] - ways[1]).max() < 2e-3


def test_a_machine_without_wireless_sensors_is_not_silent() -> None:
    said: list[Any] = []
    run(printer(), 120, each=lambda frame: said.extend(frame.notices))
    assert said == []


def test_it_is_taken_up_again() -> None:
    twin = printer()
    go(twin, np.array([0.3, 0.1, 0.0]), 0.3)
    other = SimulatedMachine.resumed(ROBOT, TWIN, twin.snapshot(), seed=2)
    for each in (twin, other):
        run(each, 30, (1.0, -1.0, 0.0, 0.0), valve=0.7)
    np.testing.assert_array_equal(twin.truth.position, other.truth.position)
    np.testing.assert_array_equal(twin.rig.ground.heights, other.rig.ground.heights)
    assert twin.rig.ground.heights.any()
