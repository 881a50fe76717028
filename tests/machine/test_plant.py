"""The plant: equilibrium, powder, winches and their encoders, two speeds, the same bytes from the same seed."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Command, Condition, Encoders
from cablewright.machine.log.log import LogWriter
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from twins import SETTINGS, START, TWIN, changed, head, machine, perfect, run

STILL = {"yaw_wander": 0.0, "swing_damping": 150.0, "drag": 400.0}
PLANTS = ["dynamic", "quasi-static"]


@pytest.mark.parametrize("plant", PLANTS)
def test_it_hangs_still_until_it_is_commanded_to_move(plant: str) -> None:
    twin = machine(changed(drum=STILL, climate={"swing": 0.0}), plant=plant)
    np.testing.assert_allclose(twin.truth.position, START, atol=1e-9)
    run(twin, 50)
    np.testing.assert_allclose(twin.truth.position, START, atol=1e-8)
    assert twin.truth.time == pytest.approx(50 * twin.period)


def test_the_twist_of_the_lines_changes_as_the_drum_goes_and_not_as_it_stands() -> None:
    yaws = np.array([machine(seed=seed, plant="quasi-static").truth.rotation[2] for seed in range(60)])
    assert yaws.std() == pytest.approx(np.radians(4.0), rel=0.25)
    twin = machine(changed(climate={"swing": 0.0}))
    begin = twin.truth.rotation[2]
    run(twin, 100)
    assert twin.truth.rotation[2] == pytest.approx(begin, abs=1e-6)
    run(twin, 500, (0.5, 0.5, -0.5, -0.5))
    assert abs(twin.truth.rotation[2] - begin) > 5e-3


def test_both_plants_come_to_the_equilibrium_of_the_solver() -> None:
    speeds = (0.3, -0.2, 0.1, 0.0)
    ends = {}
    for plant, seconds in (("dynamic", 30.0), ("quasi-static", 2.0)):
        twin = machine(changed(drum=STILL, climate={"swing": 0.0}), plant=plant)
        run(twin, round(1.0 / twin.period), speeds)
        run(twin, round(seconds / twin.period))
        hung = solve_forward(Model(twin.robot), twin.truth.lengths).checked()
        np.testing.assert_allclose(twin.truth.position, hung.pose, atol=2e-8)
        np.testing.assert_allclose(twin.truth.tensions, hung.tensions, rtol=1e-4)
        ends[plant] = twin.truth.position
    np.testing.assert_allclose(ends["dynamic"], ends["quasi-static"], atol=2e-3)  # the wait after 1 s is a lag longer


def test_powder_is_neither_made_nor_lost() -> None:
    twin = machine(plant="quasi-static")
    drum, begin = SETTINGS.drum, twin.truth.powder
    for _ in range(5):
        run(twin, 40, (0.1, -0.1, -0.1, 0.1), valve=0.7)
        left = begin - twin.truth.powder
        lies = twin.rig.ground.mass + twin.rig.falling_mass
        assert lies == pytest.approx(left, rel=1e-9)
        assert left == pytest.approx(0.7 * drum.flow * twin.time, rel=1e-9)
    weight = (drum.empty_mass + twin.truth.powder) * twin.robot.scene.gravity
    hung = solve_forward(Model(twin.robot.under_wrench((0, 0, 0))), twin.truth.lengths)
    assert hung.ok
    assert twin.rig.packed.platform[3] == pytest.approx(weight)


def test_an_empty_drum_says_so() -> None:
    twin = machine(changed(drum={"powder": 0.01}), plant="quasi-static")
    said = []
    run(twin, 10, valve=1.0, each=lambda frame: said.extend(notice.condition for notice in frame.notices))
    assert Condition.POWDER_OUT in said
    assert twin.truth.powder == 0.0


@pytest.mark.parametrize("plant", PLANTS)
def test_encoders_count_what_the_coil_pays_out(plant: str) -> None:
    twin = machine(perfect(changed(climate={"swing": 0.0})), plant=plant)
    begin, winches = twin.truth.lengths, twin.rig.winches
    readings = run(twin, round(6.0 / twin.period), (1.0, -0.5, 0.2, 0.0))
    counts = [reading for reading in readings if isinstance(reading, Encoders)][-1].counts
    turned = counts * (2 * np.pi / (SETTINGS.winch.counts * SETTINGS.winch.ratio))
    for i, coil in enumerate(winches.coils):
        off_drum = coil.length(winches.start_angles[i]) - coil.length(winches.start_angles[i] - turned[i])
        grain = 2 * np.pi * 0.06 / (SETTINGS.winch.counts * SETTINGS.winch.ratio)
        detour = SETTINGS.winch.width**2 / 8 / 4.03  # m: by how much the exit's wandering changes the dead span at most
        assert twin.truth.lengths[i] - begin[i] == pytest.approx(off_drum, abs=grain + detour)
    assert counts[0] > 0 > counts[1]
    assert abs(counts[3]) <= 1


def test_motors_lag_and_have_a_most_speed() -> None:
    twin = machine()
    lag, asked = SETTINGS.winch.lag, 1.0
    run(twin, 10, (asked, 0.0, 0.0, 0.0))  # 0.1 s
    turned = twin.rig.winches.start_angles[0] - twin.rig.winches.angles[0]
    assert turned == pytest.approx(asked * (0.1 - lag * (1 - np.exp(-0.1 / lag))), rel=1e-9)
    said = []
    run(twin, 1, (50.0, 0.0, 0.0, 0.0), each=lambda frame: said.extend(frame.notices))
    assert [(notice.condition, notice.subject) for notice in said] == [(Condition.LIMITED, "south-west")]


def test_a_motor_stalls_on_a_load_over_its_torque() -> None:
    twin = machine(changed(winch={"max_torque": 5.0}))
    said = []
    run(twin, 20, (-0.5, 0.0, 0.0, 0.0), each=lambda frame: said.extend(frame.notices))
    assert (Condition.STALLED, "south-west") in {(notice.condition, notice.subject) for notice in said}
    assert twin.rig.winches.angles[0] == pytest.approx(twin.rig.winches.start_angles[0], abs=1e-9)


def test_a_drum_ends() -> None:
    twin = machine(changed(winch={"held": 12.0}), plant="quasi-static")
    said = []
    run(twin, 100, (3.0, 3.0, 0.0, 0.0), each=lambda frame: said.extend(frame.notices))
    assert Condition.DRUM_END in {notice.condition for notice in said}


def test_warm_cable_shrinks() -> None:
    """A quarter of a day on, the room is at its warmest, and every length off the drums shorter by 12 ppm a degree."""
    warm = changed(climate={"swing": 20.0}, drum={"powder": 0.0})
    slow = warm.with_simulation(quasi_static_period=6 * 3600.0).with_owner(lidars={}, climate_sensor=None)
    twin = machine(slow, plant="quasi-static")
    begin = twin.truth.lengths
    run(twin, 2)
    np.testing.assert_allclose(twin.truth.lengths - begin, -12e-6 * 20.0 * begin, atol=2e-9, rtol=1e-3)


@pytest.mark.parametrize("plant", PLANTS)
def test_the_same_seed_gives_the_same_bytes(plant: str, tmp_path) -> None:
    contents = []
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        twin = machine(seed=seed, plant=plant)
        with (tmp_path / name).open("wb") as file, LogWriter(file, head(plant=plant, seed=seed)) as log:
            for _ in range(120):
                command = Command(twin.time, np.array([0.3, -0.3, 0.1, 0.0]), 1.0)
                log.write(twin.step(command), command, twin.truth)
        contents.append((tmp_path / name).read_bytes())
    assert contents[0] == contents[1]
    assert contents[0] != contents[2]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"substep": 3e-3}, "substep = 0.003 s"),
        ({"substep": 1e-9}, "substep = 1e-09 s"),
        ({"inertial": {"rate": 33.0}}, "inertial.rate = 33 Hz"),
        ({"line_angles": {"rate": 400.0}}, "line_angles.rate = 400 Hz"),
        ({"encoders": {"rate": 70.0}}, "encoders.rate = 70 Hz"),
        ({"distance": {"rate": 30.0}}, "distance.rate = 30 Hz"),
        ({"climate_sensor": {"rate": 0.3}}, "climate_sensor.rate"),
        ({"winch": {"held": 5.0}}, "winch.held = 5 m"),
    ],
)
def test_what_does_not_fit_is_named(change: dict, says: str) -> None:
    tables = {name: value for name, value in change.items() if isinstance(value, dict)}
    plain = {name: value for name, value in change.items() if not isinstance(value, dict)}
    with pytest.raises(InputError, match=says):
        machine(changed(**tables).with_simulation(**plain))


def test_a_turn_that_is_no_number_of_steps_is_named() -> None:
    lidars = {"north": SETTINGS.lidars["north"].model_copy(update={"turn": 0.505})}
    with pytest.raises(InputError, match=r"lidars\.north\.turn"):
        machine(TWIN.with_owner(lidars=lidars))


@pytest.mark.parametrize(
    ("command", "says"),
    [
        (Command(0.0, np.zeros(3)), "4 finite numbers"),
        (Command(0.0, np.array([0, 0, np.nan, 0])), "4 finite numbers"),
        (Command(0.0, np.zeros(4), 1.5), "valve = 1.5"),
        (Command(-0.5, np.zeros(4)), "the clock jumped back"),
    ],
)
def test_a_command_that_is_none_is_rejected(command: Command, says: str) -> None:
    twin = machine(plant="quasi-static")
    twin.step(Command(0.0, np.zeros(4)))
    with pytest.raises(InputError, match=says):
        twin.step(command)


def test_robots_that_no_plant_can_move_are_rejected() -> None:
    robot = load("merlet2023")
    bare = [
        line.model_copy(update={"winch": line.winch.model_copy(update={"drum_radius": None})}) for line in robot.lines
    ]
    light = [
        line.model_copy(update={"cable": line.cable.model_copy(update={"linear_density": 0.0})}) for line in robot.lines
    ]
    for given, says in (
        (load("jung2020"), r"needs \[body\]"),
        (robot.model_copy(update={"lines": tuple(bare)}), "winch.drum_radius"),
        (robot.model_copy(update={"lines": tuple(light)}), "a cable without weight"),
    ):
        with pytest.raises(InputError, match=says):
            SimulatedMachine(given, TWIN, START, seed=0)
    with pytest.raises(InputError, match="unknown plant 'static'"):
        machine(plant="static")
