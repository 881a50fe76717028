"""What no model has, on whole machines: both plants, points and bodies, against independent solutions."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.signals import Command, Tensions
from cablewright.machine.files import machine_text
from cablewright.machine.log.messages import encode
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.severity_tables import SEVERITIES
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.machine.simulated.unmodelled.cable_creep import step_response
from cablewright.models.packed_views import LineNumbers, LineStates
from cablewright.models.statics import Model
from cablewright.robot import Line, load
from cablewright.solvers.forward import solve_forward
from twins import TWIN, changed, machine, run

PARTS = ("creep", "hysteresis", "sheaves", "exits", "gears", "wind")
BARE = TWIN.with_owner(lidars={})
STARTS = {"merlet2023": [0.3, -1.0, 1.2], "house-printer": [0.0, 0.0, 0.5], "cogiro": [0.0, 0.0, 1.0]}
Plants = pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])


def made(name: str, twin: TwinSettings, plant: str, seed: int = 1) -> SimulatedMachine:
    return SimulatedMachine(load(name), twin, STARTS[name], seed=seed, plant=plant)  # type: ignore[arg-type]


def drive(moved: SimulatedMachine, steps: int) -> list[bytes]:
    """Output of each step, as bytes, of a machine that moves to and fro."""
    said = []
    names = [line.name for line in moved.robot.lines]
    for _ in range(steps):
        speeds = 0.2 * np.cos(np.arange(moved.robot.m) + 2.0 * moved.time)
        frame = moved.step(Command(moved.time, speeds))
        said += [encode(each, names, 1024)[1] for each in (*frame.readings, moved.truth)]
    return said


@Plants
@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_a_machine_with_all_of_it_is_taken_up_again_to_the_bit(name: str, plant: str) -> None:
    twin = with_severity(load_twin(name), "rough", PARTS)
    first = made(name, twin, plant)
    drive(first, 40)
    again = SimulatedMachine.resumed(load(name), twin, first.snapshot(), seed=1, plant=plant)  # type: ignore[arg-type]
    assert drive(again, 40) == drive(first, 40)


@Plants
def test_a_trace_of_it_changes_nothing_but_a_trace(plant: str) -> None:
    trace = BARE.with_simulation(
        cable=BARE.simulation.cable.model_copy(update={"creep": 1e-13, "hysteresis": 1e-13}),
        sheaves=BARE.simulation.sheaves.model_copy(update={"friction": 1e-12}),
        exits=BARE.simulation.exits.model_copy(update={"compliance": 1e-14}),
        wind=BARE.simulation.wind.model_copy(update={"force": 1e-9}),
    )
    plain, traced = made("merlet2023", BARE, plant), made("merlet2023", trace, plant)
    drive(plain, 50), drive(traced, 50)
    assert traced.truth.position == pytest.approx(plain.truth.position, abs=1e-8)
    assert traced.truth.tensions == pytest.approx(plain.truth.tensions, rel=1e-5)


def test_parts_are_drawn_apart_so_that_each_leaves_the_machine_as_it_is() -> None:
    plain, ideal = (
        made("merlet2023", BARE, "dynamic"),
        made("merlet2023", with_severity(BARE, "rough", PARTS), "dynamic"),
    )
    assert ideal.robot == plain.robot
    assert ideal.settings.room == plain.settings.room
    one, two = (made("merlet2023", with_severity(BARE, "rough", parts), "dynamic") for parts in (("wind",), PARTS))
    assert one.rig.unmodelled.wind is not None
    assert two.rig.unmodelled.wind is not None
    assert (one.rig.unmodelled.wind.force == two.rig.unmodelled.wind.force).all()


@pytest.mark.parametrize("name", ["merlet2023", "cogiro"])
def test_lines_creep_by_the_answers_to_all_their_loads(name: str) -> None:
    twin = with_severity(load_twin(name), "rough", ("creep",))
    if name == "merlet2023":
        twin = changed(twin, climate={"swing": 0.0})
    hung = made(name, twin.with_owner(lidars={}), "quasi-static")
    unmodelled = hung.rig.unmodelled
    times, loads, still = [0.0], [hung.truth.tensions], np.zeros(hung.robot.m)
    assert unmodelled.strain == pytest.approx(0.0)
    for _ in range(400):
        hung.step(Command(hung.time, still))
        times.append(hung.time)
        loads.append(hung.truth.tensions)
    # Boltzmann: each change of load has an answer of its own; half way through the step in which it came
    steps, ages = np.diff(loads, axis=0), times[-1] - 0.5 * (np.array(times[1:]) + np.array(times[:-1]))
    answer = loads[0] * step_response(np.array(times[-1:])) + step_response(ages) @ steps
    # shares of lines are +-30 % about 0.1 % at the mean tension
    strain = np.asarray(unmodelled.strain)
    shares = strain / (1e-3 * answer / loads[0].mean())
    assert ((shares > 0.7) & (shares < 1.3)).all()
    assert np.ptp(shares) > 0.05
    again = made(name, twin.with_owner(lidars={}), "quasi-static")
    for _ in range(100):
        again.step(Command(again.time, still))
    early = (
        loads[0] * step_response(np.array(times[100:101]))
        + step_response(times[100] - 0.5 * (np.array(times[1:101]) + np.array(times[:100]))) @ steps[:100]
    )
    assert np.asarray(again.rig.unmodelled.strain) / (1e-3 * early / loads[0].mean()) == pytest.approx(shares, rel=2e-3)


@pytest.mark.parametrize("part", ["creep", "hysteresis", "sheaves", "exits"])
def test_the_step_of_the_plant_does_not_matter(part: str) -> None:
    ends = []
    for period in (0.1, 0.4):
        twin = with_severity(BARE, "rough", (part,)).with_simulation(quasi_static_period=period)
        moved = machine(changed(twin, climate={"swing": 0.0}), plant="quasi-static")
        begin = moved.truth.position
        for speed, seconds in ((0.5, 4.0), (-0.5, 4.0), (0.0, 40.0)):
            run(moved, round(seconds / period), speed * np.array([1.0, -1.0, -1.0, 1.0]))
        ends.append(moved.truth.position - begin)
    assert ends[0] == pytest.approx(ends[1], abs=2e-4 * max(1.0, 1e3 * np.abs(ends[0]).max()))


def displace(line: Line, off: Any) -> Line:
    """*line* with its exit displaced by *off* (3,), m; its winch, far below, stays at its height, and in its plane."""
    exit_point = tuple((np.array(line.exit_point) + off).tolist())
    if line.winch_exit is None:
        return line.model_copy(update={"exit_point": exit_point})
    winch = tuple((np.array(line.winch_exit) + np.array([off[0], off[1], 0.0])).tolist())
    return line.model_copy(update={"exit_point": exit_point, "winch_exit": winch})


@Plants
@pytest.mark.parametrize("name", ["merlet2023", "house-printer", "cogiro"])
def test_exit_points_give_in_equilibrium_with_the_statics_of_the_displaced_robot(name: str, plant: str) -> None:
    twin = with_severity(load_twin(name), "rough", ("exits",)).with_owner(lidars={})
    stiff = made(name, load_twin(name).with_owner(lidars={}), plant)
    hung = made(name, twin, plant)
    if plant == "quasi-static":
        drive(hung, 15)
    rig = hung.rig
    assert rig.unmodelled.exits is not None
    displaced = rig.unmodelled.exits.displaced
    lines = tuple(displace(line, off) for line, off in zip(rig.robot.lines, displaced, strict=True))
    if plant == "dynamic":
        assert hung.truth.position[2] < stiff.truth.position[2] - 5e-3
    # an independent solution of the robot with exit points there
    model = Model(rig.robot.model_copy(update={"lines": lines}))
    found = solve_forward(model, rig.lengths, guess=rig.pose).checked()
    assert found.pose == pytest.approx(rig.pose, abs=6e-6)  # the winch has moved aside by some mm
    state, own = LineStates(found.states), LineNumbers(model.packed.lines)
    ends = found.pose[:3] + (np.array([line.platform_point for line in lines]) if rig.robot.n == 6 else 0.0)
    away = ends[:, :2] - own.exit_point[:, :2] if rig.robot.n == 6 else found.pose[:2] - own.exit_point[:, :2]
    flat = away / np.linalg.norm(away, axis=1)[:, None]
    force = found.tensions[:, None] * np.column_stack(
        [np.cos(state.free_angle)[:, None] * flat, np.sin(state.free_angle)]
    )
    dead = np.column_stack([np.cos(state.dead_angle)[:, None] * flat, np.sin(state.dead_angle)])
    force += own.has_dead_span[:, None] * found.tensions[:, None] * dead
    assert displaced == pytest.approx(1e-5 * force, abs=5e-6)


def test_a_mount_of_one_line_may_differ_and_must_be_of_a_line() -> None:
    stiff = changed(BARE, exits={"compliance": 0.0, "by_line": {"north-west": 1e-5}})
    displaced = machine(stiff).rig.unmodelled.exits.displaced  # type: ignore[union-attr]
    assert (np.linalg.norm(displaced, axis=1) > 1e-4).tolist() == [False, False, False, True]
    with pytest.raises(UnknownName, match="north-west"):
        machine(changed(BARE, exits={"by_line": {"north-wset": 1e-5}}))


def test_motors_measure_the_winch_side_of_a_sheave_and_load_cells_the_mean_of_both() -> None:
    cells = TensionSensor(rate=100.0, deviation=0.0, bias=0.0, most=2000.0)
    twin = BARE.with_owner(load_cells=cells, motor_torques=cells)
    twin = changed(twin, wire={"latency": 0.0, "jitter": 0.0, "loss": 0.0}, sheaves={"friction": 0.03})
    moved = machine(twin)
    for sign in (1.0, -1.0):
        readings = run(moved, 60, sign * np.array([0.3, 0.3, 0.3, 0.3]))
        told = {each.source: each for each in readings if isinstance(each, Tensions)}
        motors, loads, true = told["motor_torques"].tensions, told["load_cells"].tensions, moved.truth.tensions
        assert moved.rig.unmodelled.ratio * true == pytest.approx(motors, rel=1e-12)
        assert loads == pytest.approx(0.5 * (motors + true), rel=1e-12)
        turned = np.array([math.log(each) for each in motors / true]) / math.log(0.97) * 90.0
        assert (sign * turned > 60.0).all()  # degrees by which the cables turn, the way in which they move
        assert (sign * turned < 150.0).all()


def test_a_winch_stalls_by_the_tension_on_its_own_side() -> None:
    """Reeling in needs more torque than the platform's side of the sheave asks for."""
    still = np.zeros(4)
    plain = machine(BARE)
    plain.step(Command(0.0, still))
    asked = plain.truth.tensions * plain.truth.radii
    for friction, stalls in ((0.0, False), (0.1, True)):
        limit = 1.05 * float(asked.max())
        moved = machine(changed(BARE, winch={"max_torque": limit}, sheaves={"friction": friction}))
        told = set()
        for _ in range(40):
            told |= {each.condition.name for each in moved.step(Command(moved.time, np.full(4, -0.02))).notices}
        assert ("STALLED" in told) == stalls


def test_backlash_moves_the_platform_only_where_a_line_does_not_pull() -> None:
    taut, loose = (changed(BARE, gears={"backlash": 0.02, "bearing_friction": pull}) for pull in (0.0, 1e6))
    plain, turned, lost = machine(BARE), machine(taut), machine(loose)
    for each in (plain, turned, lost):
        run(each, 100, (0.1, 0.1, 0.1, 0.1))
    assert (turned.truth.position == plain.truth.position).all()
    assert lost.truth.lengths == pytest.approx(plain.truth.lengths - 0.02 * plain.truth.radii, abs=1e-4)
    assert (lost.rig.winches.counts == plain.rig.winches.counts).all()  # an encoder on the motor sees nothing of it


@Plants
def test_wind_pushes_the_platform_and_is_gone_when_it_is(plant: str) -> None:
    blown, calm = made("merlet2023", changed(BARE, wind={"force": 30.0}), plant), made("merlet2023", BARE, plant)
    offs = []
    for _ in range(50):
        for each in (blown, calm):
            each.step(Command(each.time, np.zeros(4)))
        offs.append(blown.truth.position - calm.truth.position)
    force = blown.rig.unmodelled.wind
    assert force is not None
    assert 1e-4 < np.abs(offs).max() < 0.3


def with_keys(text: str) -> str:
    return machine_text("merlet2023") + "\n" + text + "\n"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[simulation.sheaves]\nfriction = 1.2", r"sheaves\.friction = 1\.2: must be less than 1|below 1|under 1"),
        ("[simulation.cable]\ncreep = -0.001", r"cable\.creep = -0\.001: must be at least 0"),
        ("[simulation.exits]\ncompliance = -1e-6", r"exits\.compliance.*-1e-06 m/N: must be 0 to 0\.01"),
        (
            "[simulation.exits]\ncompliance = [[1e-6, 2e-6, 0.0], [2e-6, 1e-6, 0.0], [0.0, 0.0, 1e-6]]",
            r"exits\.compliance.*makes the stiffness indefinite: its smallest eigenvalue is -1e-06 m/N",
        ),
        (
            "[simulation.exits]\ncompliance = [[1e-6, 2e-7, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 1e-6]]",
            r"exits\.compliance.*must be a symmetric matrix",
        ),
        ('[simulation.gears]\nbacklash = "-1 deg"', r"gears\.backlash = '-1 deg': must be at least 0"),
        ("[simulation.wind]\ncorrelation = 0.0", r"wind\.correlation"),
    ],
)
def test_impossible_numbers_are_rejected_in_one_line(text: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(with_keys(text))
    with pytest.raises(InputError, match=says) as refused:
        load_twin(tmp_path / "own.toml")
    assert "\n" not in str(refused.value)


def test_a_file_may_give_a_matrix_for_a_line(tmp_path: Path) -> None:
    matrix = [[2e-6, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 1e-7]]
    text = f"[simulation.exits]\ncompliance = 1e-6\n[simulation.exits.by_line]\nnorth-west = {matrix}\n"
    (tmp_path / "own.toml").write_text(with_keys(text))
    exits: Any = load_twin(tmp_path / "own.toml").simulation.exits
    found = exits.matrices(("south-west", "north-west"))
    assert found == pytest.approx(np.array([1e-6 * np.eye(3), matrix]))


def test_severities_have_the_numbers_that_were_fixed() -> None:
    numbers = {
        name: [tables[table][key] for table, key in (
            ("cable", "creep"), ("cable", "hysteresis"), ("exits", "compliance"), ("sheaves", "friction"),
            ("gears", "backlash"), ("wind", "force"),
        )]
        for name, tables in SEVERITIES.items()
    }  # fmt: skip
    assert numbers["ideal"] == [0.0] * 6
    assert numbers["typical"] == pytest.approx([2e-4, 2e-4, 1e-6, 0.01, math.radians(0.1), 1.0])
    assert numbers["rough"] == pytest.approx([1e-3, 5e-4, 1e-5, 0.03, math.radians(0.3), 3.0])
