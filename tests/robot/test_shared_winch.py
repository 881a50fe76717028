"""The table `shared_winch` of a line: what may stand there, and what does not cover such robots."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import cablewright as cw
from cablewright.analyses.workspace.workspace import count_nodes
from cablewright.exchange.losses import keys_given, lost_keys
from cablewright.live.rest_pose import rest_pose
from cablewright.robot import Winch, load, update
from cablewright.robot.design_variables import Change
from cablewright.solvers.hardware_limits import rise_on_drums
from cablewright.studies.design.measures import Prices, _cost
from physics.test_shared_winches import BELT, parallelograms, shared

TABLE = 'shared_winch = { line = "left", offset = "2397 mm", winds = "against" }'


def belt(table: str, more: str = "") -> str:
    return BELT.replace(TABLE, f"{table}\n{more}")


BAD = {
    'shared_winch = { line = "lef" }': "no line is named 'lef'",
    'shared_winch = { line = "right" }': "line 'right' is on its own drum",
    'shared_winch = { line = "left", winds = "against" }': "must be over 0 m for cables that wind against each other",
    'shared_winch = { line = "left", winds = "round" }': "winds",
    'shared_winch = { line = "left", offset = "3 N" }': "offset",
    'shared_winch = { line = "left", offset = inf }': "offset",
    'shared_winch = { offset = "3 m" }': "line",
    'shared_winch = { line = "left", longer = "3 m" }': "unknown key; did you mean",
    'shared_winch = "left"': "shared_winch",
    'shared_winch = { line = "left" }\nwinch = { drum_radius = "30 mm" }': "winch.drum_radius differs",
    'shared_winch = { line = "up" }': "",
}


@pytest.mark.parametrize("table", BAD)
def test_bad_tables_are_rejected_in_one_line(table: str) -> None:
    if not BAD[table]:
        assert cw.loads(belt(table)).winches == 2
        return
    with pytest.raises(cw.InputError) as refused:
        cw.loads(belt(table))
    assert "\n" not in str(refused.value)
    assert BAD[table] in str(refused.value)


def test_no_chains_and_no_build_up() -> None:
    text = BELT + 'shared_winch = { line = "right" }\n'
    with pytest.raises(cw.InputError, match=r"line 'right' is itself on the drum of 'left': name that one"):
        cw.loads(text)
    three = cw.loads(BELT + 'shared_winch = { line = "left" }\n')
    assert (three.winches, [line.name for line in three.sharing]) == (1, ["right", "up"])
    coil = 'winch = { build_up = 0.01, drum_length = "1 m" }'
    grown = BELT.replace("[winch]", '[winch]\nbuild_up = 0.01\ndrum_length = "1 m"')
    with pytest.raises(cw.InputError, match="at one radius only if they are as long: offset = 0, along"):
        cw.loads(grown)
    assert cw.loads(grown.replace(TABLE, 'shared_winch = { line = "left" }')).winches == 2
    with pytest.raises(cw.InputError, match=r"winch\.build_up differs"):
        cw.loads(BELT.replace(TABLE, f'shared_winch = {{ line = "left" }}\n{coil}'))


def test_a_file_is_read_written_and_updated() -> None:
    robot = cw.loads(BELT)
    own = robot.lines[1].shared_winch
    assert own is not None
    assert (own.line, own.offset, own.winds, own.sense) == ("left", 2.397, "against", -1.0)
    lines = list(robot.lines)
    lines[1] = lines[1].model_copy(update={"shared_winch": own.model_copy(update={"offset": 2.5})})
    changed = robot.model_copy(update={"lines": tuple(lines)})
    assert 'offset = "2500 mm"' in update(BELT, changed)
    assert cw.loads(update(BELT, changed)) == changed
    lost = lost_keys(keys_given(robot), "lines.name")
    assert "lines.shared_winch: the format has nothing like it" in lost


def test_a_moved_exit_keeps_its_drum() -> None:
    robot = cw.loads(BELT)
    moved = Change("exit_point.z@right").on(robot, 1.05)
    assert moved.lines[1].exit_point[2] == 1.05
    assert moved.lines[1].shared_winch == robot.lines[1].shared_winch


BODY = parallelograms(4)


def test_a_body_on_shared_winches_rests_and_has_a_workspace() -> None:
    found = rest_pose(BODY)
    assert found.held
    assert np.isfinite(found.equilibrium.pose).all()
    assert count_nodes(BODY, "static", grid=3, box=[-0.5, 0.5, -0.5, 0.5, 0.8, 1.4]).volume > 0.0
    with pytest.raises(cw.InputError, match="gravity decides the rotation"):
        cw.workspace(BODY, "static", grid=5, orientations=[[0.0, 0.0, 0.1]])


GCODE = "G21\nG90\nM82\nG1 Z1 F3000\nG1 X0 Y0 F3000\nG1 X5 Y0 E1 F1200\nG1 X5 Y5 E2\nG1 X0 Y5 E3\nG1 X0 Y0 E4\n"
JOB = 'schema = 1\nname = "part"\ngcode = "part.gcode"\norigin = [0.0, 0.0, 1.0]\n'
JOB += '[bead]\nwidth = "60 mm"\nheight = "20 mm"\n[sampling]\nstep = "5 mm"\n'


def test_check_and_cost_count_a_drum_once(tmp_path: Path) -> None:
    """Torques with acceleration are of both lines, and lengths without compensation are stated to be each line's
    own."""
    (tmp_path / "part.gcode").write_text(GCODE)
    (tmp_path / "part.toml").write_text(JOB)
    own = load("cogiro")
    lines = [each.model_copy(update={"winch": Winch(drum_radius=0.06, max_torque=200.0)}) for each in own.lines]
    own = own.model_copy(update={"lines": tuple(lines)})
    at = cw.inverse(own, [0.0, 0.0, 1.0]).checked().lengths
    robot = shared(own, (1, 0, float(at[1] - at[0]), "along"))
    before, after = (cw.check(each, tmp_path / "part.toml") for each in (own, robot))
    assert after.feasible
    torques = after.statics.lines.winch_torque
    np.testing.assert_array_equal(torques[:, 0], torques[:, 1])
    np.testing.assert_allclose(torques[:, 0], before.statics.lines.winch_torque[:, :2].sum(axis=1), rtol=0.05)
    (finding,) = (each for each in after.findings if each.limit == "winch torque")
    assert finding.line in {"1", "2"}
    said = "line '2' has shared_winch: lengths without compensation take each line to have a winch of its own"
    assert said in after.not_checked
    assert said not in before.not_checked


def test_rising_torques_of_one_drum_are_the_worst() -> None:
    drop, rise = np.array([[-1.0, -2.0, -3.0]]), np.array([[10.0, 20.0, 30.0]])
    np.testing.assert_array_equal(rise_on_drums(cw.loads(BELT), drop, rise), [[12.0, 21.0, 30.0]])
    along = cw.loads(belt('shared_winch = { line = "left" }'))
    np.testing.assert_array_equal(rise_on_drums(along, drop, rise), [[30.0, 30.0, 30.0]])


def test_a_drum_costs_once() -> None:
    held, lines = SimpleNamespace(lengths=np.ones((1, 3))), SimpleNamespace(winch_torque=[[3.0, -3.0, 1.0]])
    of = SimpleNamespace(robot=cw.loads(BELT), prices=Prices(winch=7.0, torque=10.0), held=held, lines=lines)
    assert _cost(of) == 2 * 7.0 + 10.0 * (3.0 + 1.0)  # type: ignore[arg-type]
