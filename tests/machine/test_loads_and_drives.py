"""What no model has besides creep, friction and mounts: firm cables, uneven drives, hoses and people who push."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq, root

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Command
from cablewright.machine.files import machine_text
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.machine.simulated.unmodelled.drum_drive import DrumDrive
from cablewright.machine.simulated.unmodelled.hose import Hose
from cablewright.machine.simulated.unmodelled.load_strain import LoadStrain
from cablewright.machine.simulated.unmodelled.pushes import Pushes
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward

REFERENCE, ELASTIC = 400.0, np.array([1e-6, 2e-6, 5e-7])  # N, 1/N
BEGIN = np.array([300.0, 400.0, 700.0])  # N
ALL = {
    "cable": {"settling": 1e-3, "stiffening": 0.3},
    "gears": {"torsion": 1e-4, "ripple": 2e-3, "ripple_periods": 7.0},
    "winch": {"slide": 1e-4},
    "pushes": {"force": 40.0, "pause": 2.0, "length": 1.0},
    "hose": {"start": [4.0, 3.0, 6.0], "length": "11 m", "linear_density": "500 g/m"},
}
Plants = pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])


def twin_with(name: str, tables: dict[str, dict[str, object]]) -> TwinSettings:
    """The machine of the library without lidars, with other values in tables of its simulation."""
    twin = load_twin(name).with_owner(lidars={})
    whole = twin.simulation.model_dump()
    for key, values in tables.items():
        whole[key] = {**(whole[key] or {}), **values}
    return twin.model_copy(update={"simulation": type(twin.simulation).model_validate(whole)})


def made(name: str, tables: dict[str, dict[str, object]], plant: str = "quasi-static") -> SimulatedMachine:
    start = {"merlet2023": [0.3, -1.0, 1.2], "house-printer": [0.0, 0.0, 0.5], "cogiro": [0.0, 0.0, 1.0]}[name]
    return SimulatedMachine(load(name), twin_with(name, tables), start, seed=1, plant=plant)  # type: ignore[arg-type]


def test_a_stiffening_cable_stretches_by_the_integral_of_its_softness() -> None:
    cable = LoadStrain(0.0, 0.4, REFERENCE, BEGIN, ELASTIC)
    for load_ in (0.0, 150.0, 400.0, 2000.0):
        loads = np.full(3, load_)
        whole = [
            quad(lambda t, c=c: c / (1.0 + 0.4 * (t / REFERENCE - 1.0)), begin, load_)[0]
            for c, begin in zip(ELASTIC, BEGIN, strict=True)
        ]
        assert cable.curve(loads) + ELASTIC * (loads - BEGIN) == pytest.approx(whole, rel=1e-9, abs=1e-12)


def test_what_has_settled_stays_and_gives_nothing_back() -> None:
    cable, energy = LoadStrain(1e-3, 0.0, REFERENCE, BEGIN, ELASTIC), np.zeros(3)
    before = cable.strain
    for load_ in [*np.linspace(300.0, 900.0, 200), *np.linspace(900.0, 50.0, 200), *np.linspace(50.0, 900.0, 200)]:
        loads = np.full(3, load_)
        cable.follow(loads)
        energy += loads * (cable.strain - before)
        before = cable.strain.copy()
        assert (energy >= 0.0).all()
    assert cable.strain == pytest.approx(1e-3 * (cable.most - BEGIN) / REFERENCE)
    assert (cable.most <= 900.0).all()
    assert (cable.most > 850.0).all()


@pytest.mark.parametrize("stiffening", [0.0, 0.5])
def test_a_line_between_fixed_ends_finds_its_load(stiffening: float) -> None:
    """Pulled by a strain in steps, or let out: load and strain are those of the curve."""
    for pulled in (8e-4, -1e-4):
        cable, loads = LoadStrain(5e-4, stiffening, REFERENCE, BEGIN, ELASTIC), BEGIN.copy()
        for share in np.minimum(np.linspace(0.0, 2.0, 400), 1.0):
            loads = BEGIN + (share * pulled - cable.strain) / ELASTIC
            cable.follow(loads)

        for i in range(3):
            other = LoadStrain(0.0, stiffening, REFERENCE, BEGIN[i : i + 1], ELASTIC[i : i + 1])

            def off(load_: float, i: int = i, other: LoadStrain = other, pulled: float = pulled) -> float:
                settled = 5e-4 * max(load_ - BEGIN[i], 0.0) / REFERENCE
                return float(ELASTIC[i] * (load_ - BEGIN[i]) + other.curve(np.array([load_]))[0] + settled - pulled)

            assert loads[i] == pytest.approx(brentq(off, 1.0, 1e5, xtol=1e-9), rel=2e-3)


def test_a_gear_twists_in_series_with_its_line() -> None:
    """A motor that winds by an angle: the pull of drum and line between fixed ends is that of two springs in series."""
    radii, softness, torsion = np.array([0.05, 0.1]), np.array([1e-5, 4e-6]), 3e-4
    drive = DrumDrive(torsion, (0.0, 1.0), 0.0, REFERENCE, np.zeros(2), np.zeros(2))
    begin = np.array([300.0, 500.0])
    drive.turn(np.zeros(2), begin, radii, softness)
    assert (drive.lag == 0.0).all()
    wound, pulls = np.array([0.02, 0.01]), begin
    for _ in range(60):
        pulls = begin + (wound + drive.lag) * radii / softness
        drive.turn(wound, pulls, radii, softness)
    assert pulls - begin == pytest.approx(wound * radii / (softness + torsion * radii**2), rel=1e-9)


def test_toothing_returns_and_cable_slides_out_by_the_way() -> None:
    phases = np.array([0.3, 2.0])
    drive = DrumDrive(0.0, (1e-3, 4.0), 2e-4, REFERENCE, np.zeros(2), phases)
    pulls, radii, way = np.array([200.0, 800.0]), np.full(2, 0.05), 0.0
    angles = np.zeros(2)
    for step in [*np.full(50, 0.1), *np.full(70, -0.07)]:
        angles, way = angles + step, way + abs(step)
        drive.turn(angles, pulls, radii, np.full(2, 1e-5))
        teeth = 1e-3 * (np.sin(phases) - np.sin(4.0 * angles + phases))
        assert drive.lag == pytest.approx(teeth - 2e-4 * way * pulls / REFERENCE, abs=1e-15)


@pytest.mark.parametrize("place", [[3.0, 1.0, 1.5], [-2.0, 0.5, -3.0], [0.2, 0.0, -4.0]])
def test_a_hose_pulls_as_the_catenary_that_is_integrated(place: list[float]) -> None:
    """From the force at its start along its length: it ends at the platform, and its weight is carried by both ends."""
    hose, weight, length = Hose((0.0, 0.0, 0.0), 6.0, 12.0), 12.0, 6.0
    pull = hose.pull(np.array(place))
    across = math.hypot(*place[:2])
    level, start = math.hypot(*pull[:2]), -weight * length - pull[2]  # at its start, N: level, and up along its way
    size = [
        quad(lambda s, k=k: (level, start + weight * s)[k] / math.hypot(level, start + weight * s), 0.0, length)[0]
        for k in range(2)
    ]
    assert size == pytest.approx([across, place[2]], abs=1e-8)
    assert pull[:2] * across == pytest.approx(-level * np.array(place[:2]), abs=1e-9)


def test_a_hose_has_a_potential() -> None:
    hose, step = Hose((0.5, 0.0, 3.0), 5.0, 8.0), 1e-5
    moves = np.eye(3) * step
    slopes = np.array([
        (hose.pull(np.array([1.5, 1.0, 1.0]) + move) - hose.pull(np.array([1.5, 1.0, 1.0]) - move)) / (2 * step)
        for move in moves
    ])  # fmt: skip
    assert slopes == pytest.approx(slopes.T, abs=1e-6)
    assert np.linalg.eigvalsh(slopes).max() < 1e-6  # it pulls back


def test_a_machine_with_a_hose_hangs_where_statics_with_its_pull_say() -> None:
    hung = made("house-printer", {"hose": ALL["hose"]})
    for _ in range(5):
        hung.step(Command(hung.time, np.zeros(4)))
    model, lengths = Model(hung.rig.robot), hung.rig.lengths
    hose = hung.rig.unmodelled.hose
    assert hose is not None

    def off(place: np.ndarray) -> np.ndarray:
        under = Model(model.robot.under_wrench(tuple(hose.pull(place))))
        return np.asarray(solve_forward(under, lengths, guess=place).pose - place)

    there = root(off, hung.truth.position, tol=1e-12).x
    plain = solve_forward(model, lengths, guess=hung.truth.position).pose
    assert np.linalg.norm(there - plain) > 1e-4
    assert hung.truth.position == pytest.approx(there, abs=2e-5)  # air of another temperature by then


def test_people_push_for_their_share_of_the_time() -> None:
    pushes, times = Pushes(50.0, 8.0, 2.0, seed=3), np.arange(0.0, 20000.0, 0.5)
    forces = np.linalg.norm([pushes.at(time) for time in times], axis=1)
    assert set(np.round(forces, 9)) == {0.0, 50.0}
    assert np.mean(forces > 0.0) == pytest.approx(0.2, abs=0.02)
    assert (Pushes(50.0, 8.0, 2.0, seed=3).at(777.0) == pushes.at(777.0)).all()


@Plants
@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_a_machine_with_all_of_it_is_taken_up_again_to_the_bit(name: str, plant: str) -> None:
    first, ends = made(name, ALL, plant), []
    for k in range(40):
        first.step(Command(first.time, 0.1 * np.cos(np.arange(first.robot.m) + 0.3 * k)))
    robot, twin = load(name), twin_with(name, ALL)
    again = SimulatedMachine.resumed(robot, twin, first.snapshot(), seed=1, plant=plant)  # type: ignore[arg-type]
    for each in (first, again):
        for k in range(40):
            each.step(Command(each.time, 0.1 * np.sin(np.arange(each.robot.m) + 0.3 * k)))
        ends.append((each.truth.position, each.truth.tensions))
    assert (ends[0][0] == ends[1][0]).all()
    assert (ends[0][1] == ends[1][1]).all()
    plain = made(name, {}, plant)
    assert np.linalg.norm(plain.truth.position - ends[0][0]) > 1e-3


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "[simulation.cable]\nsettling = 0.2",
            r"cable\.settling = 0\.2: must be .*0\.1",
        ),
        ("[simulation.gears]\ntorsion = -1e-4", r"gears\.torsion = -0\.0001: must be .*at least 0"),
        (
            '[simulation.hose]\nstart = [0, 0, 5]\nlength = "0 m"\nlinear_density = 1.0',
            r"hose\.length = '0 m': must be",
        ),
        ("[simulation.hose]\nstart = [0, 0, 5]", r"hose\.length"),
        ("[simulation.pushes]\npause = 0.0", r"pushes\.pause = 0\.0"),
    ],
)
def test_impossible_numbers_are_rejected_in_one_line(text: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(machine_text("merlet2023") + "\n" + text + "\n")
    with pytest.raises(InputError, match=says) as refused:
        load_twin(tmp_path / "own.toml")
    assert "\n" not in str(refused.value)
