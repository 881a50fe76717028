"""Where the cable of an upper layer crosses the turns below it: the radius has a bump, and more is wound."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Command
from cablewright.kernels.plant import winding
from cablewright.machine.files import machine_text
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.machine.simulated.winches import Winches
from cablewright.models.coil import TURN
from cablewright.robot import load

SPAN = math.radians(70.0)
LAYER = 20
CROSSING = 0.134  # of a round cable, from the valley between two turns to the top of one
STARTS = {"merlet2023": [0.3, -1.0, 1.2], "house-printer": [0.0, 0.0, 0.5], "cogiro": [0.0, 0.0, 1.0]}
Plants = pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])
Names = pytest.mark.parametrize("name", sorted(STARTS))


def twin_with(name: str, crossing: float, **keys: float) -> TwinSettings:
    """A machine whose drums take 20 turns in a layer; those of house-printer and cogiro are wider, for a single one."""
    twin, diameter = load_twin(name).with_owner(lidars={}), load(name).lines[0].cable.diameter
    assert diameter is not None
    narrow = twin.owner.winch.model_copy(update={"width": LAYER * diameter})
    twin = twin.with_owner(winch=narrow)
    given = {"crossing": crossing, "crossing_angle": SPAN, **keys}
    return twin.with_simulation(winch=twin.simulation.winch.model_copy(update=given))


def made(name: str, crossing: float, plant: str = "quasi-static", **keys: float) -> SimulatedMachine:
    settings = twin_with(name, crossing, **keys)
    return SimulatedMachine(load(name), settings, STARTS[name], seed=1, plant=plant)  # type: ignore[arg-type]


def drums(name: str, crossing: float, seed: int = 1, **keys: float) -> tuple[Winches, float]:
    """Winches whose dead spans have no detour, and the height of a bump, m."""
    robot, twin = load(name), twin_with(name, crossing, **keys)
    lengths = np.full(robot.m, 10.0)
    wound = Winches(robot, twin.owner.winch, twin.simulation.winch, lengths, seed)
    wound.state[:, winding.HEIGHT] = 0.0
    diameter = robot.lines[0].cable.diameter
    assert diameter is not None
    return wound, crossing * diameter


def at(wound: Winches, i: int, angle: float) -> tuple[float, float]:
    """Radius of drum *i* with an *angle* wound, and the length that is then on it, m."""
    own = wound.state[i].copy()
    own[winding.ANGLE] = angle
    out = winding.length_out(own, wound.radii[i], wound.wound[i], wound.sideways[i])
    return winding.radius_at(own, wound.radii[i]), float(own[winding.HELD] - out)


@Names
def test_what_is_wound_is_the_integral_of_the_radius(name: str) -> None:
    wound, _ = drums(name, CROSSING)
    random = np.random.default_rng(2)
    for i in range(2):
        for begin in TURN * (LAYER - 1.5 + 4.0 * random.random(6)):
            end = begin + TURN * random.uniform(0.1, 2.5)
            kinks = [TURN * k for k in range(int(begin / TURN), int(end / TURN) + 2)]
            own = wound.state[i]
            at_bump = TURN * own[winding.CROSSING_AT]
            kinks += [k + at_bump + more for k in kinks for more in (0.0, SPAN)]
            breaks = [k for k in kinks if begin < k < end]
            whole = quad(lambda a, i=i: at(wound, i, a)[0], begin, end, points=breaks, limit=200, epsabs=1e-12)[0]
            assert at(wound, i, end)[1] - at(wound, i, begin)[1] == pytest.approx(whole, abs=1e-9)


@Names
def test_a_turn_of_an_upper_layer_takes_half_the_height_times_the_angle_more(name: str) -> None:
    (wound, height), (plain, _) = drums(name, CROSSING), drums(name, 0.0)
    for k in range(6):
        whole = TURN * (LAYER - 3 + k)
        more = at(wound, 0, whole)[1] - at(plain, 0, whole)[1]
        assert more == pytest.approx(max(0, k - 2) * 0.5 * height * SPAN, abs=1e-12)


def test_a_bump_has_its_height_and_angle_and_the_first_layer_has_none_but_where_it_ends() -> None:
    (wound, height), (plain, _) = drums("merlet2023", CROSSING), drums("merlet2023", 0.0)

    def over(turn: float) -> np.ndarray:
        angles = TURN * (turn + np.linspace(0.0, 1.0, 5001))
        return np.array([at(wound, 0, a)[0] - at(plain, 0, a)[0] for a in angles])

    for turn in (0, LAYER // 2, LAYER - 2):
        assert (over(turn) == 0.0).all()
    for turn in (LAYER - 1, LAYER + 3, 2 * LAYER - 1):
        bump = over(turn)
        assert bump.max() == pytest.approx(height, rel=1e-5)
        assert np.mean(bump > 1e-9) == pytest.approx(SPAN / TURN, abs=2e-3)
        assert (bump >= 0.0).all()


def test_drums_cross_at_places_of_their_own() -> None:
    found = np.array([drums("merlet2023", CROSSING, seed)[0].state[:, winding.CROSSING_AT] for seed in range(200)])
    most = 1.0 - SPAN / TURN
    assert 0.0 <= found.min() < 0.02
    assert most - 0.02 < found.max() <= most
    assert np.abs(np.corrcoef(found.T) - np.eye(4)).max() < 0.25


@Names
def test_drums_begin_with_the_lengths_that_are_out(name: str) -> None:
    machine = made(name, 1.0)
    assert machine.rig.winches.lengths_out() == pytest.approx(machine.truth.lengths, abs=1e-9)


def test_length_error_of_the_owner_is_the_length_of_crossings() -> None:
    """A coil without them pays out less for the same counts: half the height times the angle for each turn."""
    machine = made("merlet2023", CROSSING)
    wound, diameter = machine.rig.winches, machine.robot.lines[0].cable.diameter
    assert diameter is not None

    def beside() -> np.ndarray:
        """What is out, m, less what would be without crossings, by the same angles."""
        true, height = wound.lengths_out(), wound.state[:, winding.CROSSING].copy()
        wound.state[:, winding.CROSSING] = 0.0
        plain = wound.lengths_out()
        wound.state[:, winding.CROSSING] = height
        return true - plain

    begin, angles, counts = beside(), wound.angles, wound.counts
    for _ in range(100):
        machine.step(Command(machine.time, np.full(4, -0.5)))
    turns, whole = (wound.angles - angles) / TURN, 0.5 * CROSSING * diameter * SPAN
    assert (turns > 1.2).all()
    assert begin - beside() == pytest.approx(turns * whole, abs=1.001 * whole)  # a bump more or less
    ratio = machine.settings.winch.ratio * machine.settings.winch.counts
    assert counts - wound.counts == pytest.approx(turns * ratio, abs=1.0)


@Plants
@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_a_machine_with_crossings_is_taken_up_again_to_the_bit(name: str, plant: str) -> None:
    first = made(name, CROSSING, plant)
    robot, twin = load(name), twin_with(name, CROSSING)
    for k in range(20):
        first.step(Command(first.time, np.full(robot.m, 0.2 * math.cos(k))))
    again = SimulatedMachine.resumed(robot, twin, first.snapshot(), seed=1, plant=plant)  # type: ignore[arg-type]
    for k in range(20):
        for each in (first, again):
            each.step(Command(each.time, np.full(robot.m, 0.2 * math.sin(k))))
    assert (first.rig.motion == again.rig.motion).all()
    assert (first.rig.lengths == again.rig.lengths).all()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("crossing = 1.2", r"winch\.crossing = 1\.2: must be .*1"),
        ("crossing = 0.1\ncrossing_angle = 0.0", r"winch\.crossing_angle = 0\.0: must be"),
        ('crossing = 0.1\ncrossing_angle = "400 deg"', r"winch\.crossing_angle = '400 deg': must be"),
    ],
)
def test_impossible_crossings_are_rejected_in_one_line(text: str, says: str, tmp_path: Path) -> None:
    whole = machine_text("merlet2023").replace("[simulation.winch]", f"[simulation.winch]\n{text}")
    (tmp_path / "own.toml").write_text(whole)
    with pytest.raises(InputError, match=says) as refused:
        load_twin(tmp_path / "own.toml")
    assert "\n" not in str(refused.value)
