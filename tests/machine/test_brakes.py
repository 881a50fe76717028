"""Brakes that give: what a closed one holds, what it takes, and that encoders and whoever commands learn of it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import shared_winch_robots
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.signals import Command, Condition, Encoders, WinchMode
from cablewright.kernels.plant import winding
from cablewright.live.serve.operated_machines import resting_pose
from cablewright.machine.coils import coil_of
from cablewright.machine.files import machine_text
from cablewright.machine.interface import RESET
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.machine.simulated.unmodelled.brakes import Brakes
from cablewright.machine.simulated.unmodelled.effect_sizes import WinchBrakes
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

STARTS = {"merlet2023": [0.3, -1.0, 1.2], "house-printer": [0.0, 0.0, 0.5], "cogiro": [0.0, 0.0, 1.0]}
Plants = pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])
Names = pytest.mark.parametrize("name", sorted(STARTS))


def twin_with(name: str, law: dict[str, Any], **winch: float) -> TwinSettings:
    """A machine with such brakes in a room of one temperature, without lidars."""
    twin = load_twin(name).with_owner(lidars={})
    given = twin.simulation
    return twin.with_simulation(
        brakes=WinchBrakes.model_validate(law),
        climate=given.climate.model_copy(update={"swing": 0.0}),
        winch=given.winch.model_copy(update=winch),
    )


def made(name: str, plant: str, law: dict[str, Any], **winch: float) -> SimulatedMachine:
    settings = twin_with(name, law, **winch)
    return SimulatedMachine(load(name), settings, STARTS[name], seed=1, plant=plant)  # type: ignore[arg-type]


def torques(machine: SimulatedMachine) -> np.ndarray:
    """What the lines pull at their drums, (m,) N m."""
    return np.asarray(machine.truth.tensions * machine.rig.unmodelled.ratio * machine.truth.radii)


def brake(machine: SimulatedMachine, steps: int = 1, **more: Any) -> list[Any]:
    """The frames of so many steps with all brakes closed."""
    still, off = np.zeros(machine.robot.m), (WinchMode.OFF,) * machine.robot.m
    return [machine.step(Command(machine.time, still, modes=off, **more)) for _ in range(steps)]


def drum(torque: float, softness: float, radius: float = 0.05) -> tuple[np.ndarray, np.ndarray]:
    """A winch with a closed brake, and radii of a drum that all are the same."""
    own = np.zeros(winding.WINCH)
    own[[winding.ANGLE, winding.HELD, winding.RATIO]] = 100.0, 20.0, 1.0
    own[[winding.BRAKE, winding.SOFT]] = torque, softness
    return own[None], np.full((1, 40), radius)


def turned(winches: np.ndarray, radii: np.ndarray, tension: float) -> float:
    """Length that one step pays out, m, with the motor at rest."""
    before = winches[0, winding.ANGLE]
    wound = np.cumsum(np.full_like(radii, winding.TURN * radii[0, 0]), axis=1) - winding.TURN * radii[0, 0]
    motor = np.array([10.0, 0.01, 1e6])
    drums = (winches, motor, radii, wound, np.zeros_like(radii))
    winding.turn_winches(*drums, np.zeros(1), np.array([tension]), 0.01, np.zeros(1), np.zeros(1, dtype=np.int64))
    return float(radii[0, 0] * (before - winches[0, winding.ANGLE]))


def test_a_line_between_fixed_ends_slips_to_the_brake_force_and_loses_its_energy() -> None:
    for pulled in (150.0, 399.9, 400.1, 3000.0):
        winches, radii = drum(20.0, 1e-5)
        paid = turned(winches, radii, pulled)
        held = pulled - paid / 1e-5
        assert held == pytest.approx(min(pulled, 400.0), rel=1e-12)
        assert turned(winches, radii, held) == pytest.approx(0.0, abs=1e-12)
        lost = 0.5 * 1e-5 * (pulled**2 - held**2)  # of the line, J
        assert lost >= 20.0 * winches[0, winding.SLIPPED] - 1e-12  # what friction of that torque takes
        assert winches[0, winding.SLIPPED] == pytest.approx(max(pulled - 400.0, 0.0) * 1e-5 / 0.05)


def test_whatever_pulls_a_brake_pays_out_only_and_only_beyond_its_torque() -> None:
    random, (winches, radii) = np.random.default_rng(4), drum(20.0, 1e-5)
    for pull in random.uniform(0.0, 900.0, 500):
        assert turned(winches, radii, pull) >= 0.0
        winches[0, winding.PULL] = 0.0
        assert (turned(winches, radii, pull) > 0.0) == (pull > 400.0)


@Names
def test_one_weak_brake_slips_to_where_statics_with_a_longer_line_say(name: str) -> None:
    i = int(np.argmax(torques(made(name, "quasi-static", {}))))
    line = load(name).lines[i].name
    holds = 0.85 * torques(made(name, "quasi-static", {}))[i]
    machine = made(name, "quasi-static", {"by_line": {line: holds}})
    model, begin, place = Model(machine.rig.robot), machine.truth.lengths, machine.rig.pose
    brake(machine, 200)
    now = torques(machine)
    assert now[i] == pytest.approx(holds, rel=2e-3)

    def over(paid: float) -> float:
        found = solve_forward(model, begin + paid * np.eye(len(begin))[i], guess=place)
        return float(found.tensions[i] * machine.truth.radii[i] - holds)

    there = begin + brentq(over, 0.0, 0.3, xtol=1e-9) * np.eye(len(begin))[i]
    assert machine.truth.lengths == pytest.approx(there, abs=2e-5)
    assert machine.rig.pose == pytest.approx(solve_forward(model, there, guess=place).pose, abs=3e-5)


@pytest.mark.parametrize(("name", "share"), [("merlet2023", 0.9), ("cogiro", 0.8)])
def test_all_brakes_that_are_too_weak_let_the_platform_down_until_they_hold(name: str, share: float) -> None:
    holds = share * torques(made(name, "quasi-static", {})).max()
    machine = made(name, "quasi-static", {"torque": holds}, radius_walk=0.0)
    angles = machine.rig.winches.angles
    for _ in range(600):
        brake(machine)
        assert (machine.rig.winches.angles <= angles).all()  # no brake winds a line in
        angles = machine.rig.winches.angles
    assert (torques(machine) <= holds * (1.0 + 1e-3)).all()
    assert machine.rig.winches.slipped.max() > 1e-3


@Plants
def test_weak_brakes_of_drums_with_two_lines_let_the_platform_down_until_they_hold_both(plant: str) -> None:
    robot = shared_winch_robots.pairs()
    pose, twin = resting_pose(robot, np.array([0.1, 0.05, 0.9])), built_machine(robot)[0]

    def drums(machine: SimulatedMachine) -> np.ndarray:
        return machine.rig.winches.lines.torques(machine.truth.tensions, machine.truth.radii)

    holds = 0.97 * drums(SimulatedMachine(robot, twin, pose, seed=1, plant=plant)).max()  # type: ignore[arg-type]
    weak = twin.with_simulation(brakes=WinchBrakes.model_validate({"torque": float(holds)}))
    machine = SimulatedMachine(robot, weak, pose, seed=1, plant=plant)  # type: ignore[arg-type]
    off = (WinchMode.OFF,) * 3
    for _ in range(300):
        machine.step(Command(machine.time, np.zeros(3), modes=off))
    assert (drums(machine) <= holds * (1.005 if plant == "quasi-static" else 1.05)).all()  # it sways where it falls
    fell = pose[2] - machine.truth.position[2]
    assert 0.005 < fell < 0.08
    statics = solve_inverse(Model(robot), np.array([*machine.truth.position, np.nan, np.nan, np.nan]))
    rest = machine.rig.winches.lines.torques(statics.tensions, machine.truth.radii)
    assert rest.max() == pytest.approx(
        holds, rel=0.03
    )  # where both lines of the worst drum pull as much as its brake holds


def test_a_platform_on_slipping_brakes_falls_with_the_excess_of_its_weight() -> None:
    """Four lines of one pull, which is 0.8 of the head's weight: it falls with a fifth of gravity."""
    pulled = torques(made("house-printer", "dynamic", {}))
    assert np.ptp(pulled) < 0.003 * pulled.max()
    machine = made("house-printer", "dynamic", {"torque": 0.8 * pulled.mean()}, radius_walk=0.0)
    heights, times = [machine.truth.position[2]], [0.0]
    for _ in range(20):
        brake(machine)
        assert torques(machine) == pytest.approx(np.full(4, 0.8 * pulled.mean()), rel=5e-3)
        heights.append(machine.truth.position[2])
        times.append(machine.time)
    fall = -2.0 * np.polyfit(times, heights, 2)[0]
    assert fall == pytest.approx(0.2 * machine.robot.scene.gravity, rel=0.03)


@Plants
def test_strong_brakes_change_no_bit_and_open_ones_hold_nothing(plant: str) -> None:
    plain, strong, weak = (made("merlet2023", plant, {"torque": torque}) for torque in (0.0, 1e5, 1e-3))
    for k in range(30):
        speeds = 0.1 * np.cos(np.arange(4) + 0.2 * k)
        for machine in (plain, strong, weak):
            machine.step(Command(machine.time, speeds))
    assert (plain.rig.motion == weak.rig.motion).all()
    brake(plain, 30), brake(strong, 30), brake(weak, 3)
    assert (plain.rig.motion == strong.rig.motion).all()
    assert (plain.rig.lengths == strong.rig.lengths).all()
    assert (weak.rig.winches.slipped > 0.0).all()


def test_encoders_count_what_a_brake_lets_slip() -> None:
    """By the counts and a coil that lies as it should, lengths are the true ones to a count."""
    machine = made("merlet2023", "quasi-static", {"torque": 10.0}, radius_walk=0.0, sideways_walk=0.0)
    begin, winch = machine.truth.lengths, machine.settings.winch
    counted = [each for frame in brake(machine, 150) for each in frame.readings if isinstance(each, Encoders)]
    assert machine.truth.lengths.max() - begin.max() > 0.02
    turns = counted[-1].counts / winch.counts / winch.ratio
    for i, line in enumerate(machine.robot.lines):
        coil = coil_of(line, winch)
        angle = coil.angle(winch.held - begin[i])
        reads = begin[i] + coil.length(angle) - coil.length(angle - winding.TURN * turns[i])
        assert reads == pytest.approx(machine.truth.lengths[i], abs=5e-3)  # and the detour of the dead span
        assert reads > begin[i] + 0.01


@Plants
@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_a_machine_whose_brakes_slip_is_taken_up_again_to_the_bit(name: str, plant: str) -> None:
    law = {"torque": 0.6 * torques(made(name, plant, {})).max(), "spread": 0.2}
    first = made(name, plant, law)
    brake(first, 5)
    robot, twin = load(name), twin_with(name, law)
    again = SimulatedMachine.resumed(robot, twin, first.snapshot(), seed=1, plant=plant)  # type: ignore[arg-type]
    before = first.rig.winches.slipped.copy()
    one, two = brake(first, 20), brake(again, 20)
    assert (first.rig.motion == again.rig.motion).all()
    assert [frame.notices for frame in one] == [frame.notices for frame in two]
    assert (first.rig.winches.slipped > before).any()


def test_slip_is_reported_until_a_person_resets() -> None:
    machine = made("merlet2023", "quasi-static", {"torque": 12.0})
    told = [[n for n in frame.notices if n.condition is Condition.BRAKE] for frame in brake(machine, 100)]
    first = next(k for k, notices in enumerate(told) if notices)
    assert first > 0
    assert all(len(notices) == 1 for notices in told[first:])
    text = r"(north|south)-(east|west): its winch is 2\d mm from where it was commanded, "
    assert re.fullmatch(text + "which its brake should hold: secure the load", told[first][0].subject)
    frame = machine.step(Command(machine.time, np.zeros(4)))  # held by its motors: still not where it should be
    assert any(n.condition is Condition.BRAKE for n in frame.notices)
    frame = brake(machine, 1, outputs={RESET: 1.0})[0]
    assert not any(n.condition is Condition.BRAKE for n in frame.notices)


def test_only_a_machine_whose_brakes_give_takes_an_order_to_reset() -> None:
    plain = made("merlet2023", "quasi-static", {})
    assert not plain.abilities.outputs
    with pytest.raises(InputError, match="no such output"):
        brake(plain, outputs={RESET: 1.0})
    assert made("merlet2023", "quasi-static", {"torque": 10.0}).abilities.brakes


def test_torques_have_errors_within_their_spread_or_that_of_their_line() -> None:
    names, found = ("a", "b", "c"), []
    for seed in range(400):
        brakes = Brakes(WinchBrakes(torque=20.0, by_line={"b": 5.0}, spread=0.3), names, seed, 0.02)
        found.append(brakes.torques)
    shares = np.array(found) / [20.0, 5.0, 20.0] - 1.0
    assert np.abs(shares).max() <= 0.3
    assert shares.std(axis=0) == pytest.approx(np.full(3, 0.3 / np.sqrt(3.0)), rel=0.1)
    assert np.abs(np.corrcoef(shares.T) - np.eye(3)).max() < 0.2
    with pytest.raises(UnknownName, match="line 'd'"):
        Brakes(WinchBrakes(by_line={"d": 5.0}), names, 1, 0.02)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("torque = -1.0", r"brakes\.torque = -1\.0: must be .*at least 0"),
        ("torque = 10.0\nspread = 1.0", r"brakes\.spread = 1\.0: must be .*1"),
        ("by_line = { north-west = -2.0 }", r"brakes\.by_line.*north-west.* = -2\.0"),
    ],
)
def test_impossible_brakes_are_rejected_in_one_line(text: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(f"{machine_text('merlet2023')}\n[simulation.brakes]\n{text}\n")
    with pytest.raises(InputError, match=says) as refused:
        load_twin(tmp_path / "own.toml")
    assert "\n" not in str(refused.value)
