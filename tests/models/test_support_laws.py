"""Cells that run machines obey a law: rest, motion, encoders, power and files of motion, by the solvers of statics."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import cablewright as cw
from cablewright.control import velocity
from cablewright.control.path_follower import Target
from cablewright.control.velocity import VelocitySettings
from cablewright.exchange.firmware import firmware
from cablewright.exchange.motion_export.klipper import LETTERS as KLIPPER
from cablewright.exchange.motion_export.linuxcnc import LETTERS as LINUXCNC
from cablewright.foundation.signals import Command, Encoders, Estimate, SensorFrame, frozen
from cablewright.live.body_estimator import body_settings
from cablewright.live.estimators import estimator, reckoning_of
from cablewright.machine.drives.drum_units import scales_of
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.machine.simulated.settings import Tolerances
from cablewright.models.free_coordinates import free_coordinates
from cablewright.models.support_table import Capability, Coverage
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import taut_at
from exchange.test_motion import replay
from models import support_examples as examples
from models.test_support_table import cells_of

DT = 0.01
EXACT = Tolerances(anchor=0.0, sheave_radius=0.0, modulus=0.0)


def moves(robot: Robot) -> np.ndarray:
    """A short way (3,), m, that the platform may go: in its plane, and with two lines on one drum equally long."""
    plane, way = robot.platform.plane, np.array([0.003, -0.002, 0.0025])
    if robot.n == 3 and robot.sharing:
        way[0] = 0.0
    return way if plane is None else way - (way @ np.array(plane.across)) * np.array(plane.across)


def moved(robot: Robot) -> cw.Equilibrium:
    """The example a little farther on."""
    there = examples.pose_at(robot).copy()
    there[:3] += moves(robot)
    return cw.inverse(robot, there).checked()


def rests(robot: Robot) -> str:
    """A plant that stands has the tensions of the inverse problem, and stays where it is."""
    held = examples.held(robot)
    exact = built_machine(robot)[0].with_simulation(tolerances=EXACT)
    machine = cw.SimulatedMachine(robot, exact, examples.pose_at(robot), seed=1)
    off = np.abs(machine.truth.tensions / held.tensions - 1.0).max()
    for _ in range(10):
        machine.step(Command(machine.time, np.zeros(robot.winches)))
    slid = np.linalg.norm(machine.truth.position - held.pose[:3])
    return "" if off < 2e-3 and slid < 2e-4 else f"tensions differ by {off:.2g}, it slides by {1e3 * slid:.3g} mm"


def follows_encoders(robot: Robot) -> str:
    """The estimate is where drums that pay out the lengths of another pose have led the platform."""
    owner, held, there = examples.twin(robot).owner, examples.held(robot), moved(robot)
    known = reckoning_of(robot, owner) if robot.n == 3 else body_settings(robot, owner, sensors=False)
    found, winches = estimator("encoders", robot, owner, held.pose), WinchLines.of(robot)
    turned = known.drums.angles(held.lengths) - known.drums.angles(there.lengths)
    counts = np.rint(turned[winches.hosts] * known.counts_per_radian).astype(np.int64)
    for now, given in ((0.0, 0 * counts), (1.0, counts)):
        seen = found.step(SensorFrame(now, (Encoders(now, given),)))
    off = np.linalg.norm(seen.position - there.pose[:3])
    return "" if off < 2e-4 else f"it is {1e3 * off:.3g} mm off"


def goes_as_wanted(robot: Robot) -> str:
    """Winches at the speeds of the control move the platform by its wanted velocity, by the forward problem."""
    held, way, wanted = examples.held(robot), moves(robot), free_coordinates(robot)
    settings = VelocitySettings(cw.Model.of(robot), 1e3, law="model", manage_slack=False)
    turn = np.pad(held.pose[3:], (0, 6 - robot.n))
    excess = held.lengths - taut_at(settings.model, held.pose).lengths
    still, radii = frozen(np.zeros(3)), frozen(np.full(robot.m, 0.05))
    here = frozen(held.pose[:3]), still, frozen(turn), frozen(held.lengths), frozen(excess)
    believed = Estimate(0.0, *here, np.zeros(robot.m, np.bool_), radii)
    target = Target(held.pose[:3], way / DT, 0.0, 0, 0.1, False, False, False, turn)
    speeds = velocity.step(settings, velocity.start(settings), believed, target, DT, held.tensions)
    lengths = held.lengths + 0.05 * DT * WinchLines.of(robot).of_lines(speeds)
    there = cw.forward(robot, lengths, guess=held.pose).pose
    off = np.delete(there - held.pose, wanted)[: 3 - sum(k < 3 for k in wanted)]
    size = np.linalg.norm(off - np.delete(way, [k for k in wanted if k < 3]))
    return "" if size < 0.05 * np.linalg.norm(way) else f"it misses by {1e3 * size:.3g} mm"


def keeps_power(robot: Robot) -> str:
    """A drive's power is that of the cables on its drum, whose speeds are those of the encoders' counts."""
    owner = examples.on_drives(robot)
    senses, cables = WinchLines.of(robot).senses, np.array([line.cables for line in robot.lines])
    for k, scale in enumerate(scales_of(robot, owner)):
        per_turn = scale.counts / (owner.winch.counts * owner.winch.ratio / (2.0 * np.pi))
        pulled = 10.0 * scale.radii[0] * float(cables @ (senses[k] == 1.0))
        if per_turn != (1, -1)[k % 2] or not np.isclose(-scale.torque_of(10.0), pulled):
            return f"drum {k}: {per_turn:g} turns, {pulled:g} N m"
    return ""


def holds_its_files_path(kind: str, file: str, letters: str) -> Callable[[Robot], str]:
    """Drums that turn as a file of motion says pay out the lengths that hold the nozzle where it says."""

    def law(robot: Robot) -> str:
        made = firmware(kind, robot, examples.job_of(robot))
        found, winches, pays = replay(made.files[file], letters[: robot.winches]), WinchLines.of(robot), []
        nozzles, free = 1e-3 * np.array(found.points), free_coordinates(robot)
        for nozzle in (nozzles[0], nozzles[len(nozzles) // 2]):
            pose = np.zeros(robot.n)
            pose[:3] = nozzle - (robot.platform.nozzle if robot.n == 6 else 0.0)
            pose[list(free)] = np.nan
            pays.append(solve_inverse(cw.Model.full(robot), pose).checked().lengths)
        turned = np.radians(np.subtract(found.winches[len(nozzles) // 2], found.winches[0]))
        radii = np.array([line.winch.drum_radius for line in robot.winch_lines])
        off = np.abs((pays[1] - pays[0])[winches.hosts] - radii * turned).max()
        return "" if off < 1e-4 else f"a line is {1e3 * off:.3g} mm off"

    return law


LAWS: dict[str, tuple[Capability, Callable[[Robot], str]]] = {
    "a plant rests": (Capability.SIMULATION, rests),
    "an estimate follows encoders": (Capability.ESTIMATION, follows_encoders),
    "a platform goes as wanted": (Capability.CONTROL, goes_as_wanted),
    "a drive keeps power": (Capability.DRIVES, keeps_power),
    "klipper": (Capability.KLIPPER, holds_its_files_path("klipper", "job.gcode", KLIPPER)),
    "linuxcnc": (Capability.LINUXCNC, holds_its_files_path("linuxcnc", "job.ngc", LINUXCNC)),
}


_FILES = ("klipper", "linuxcnc")


@pytest.mark.parametrize("name", [pytest.param(each, marks=[pytest.mark.slow] * (each in _FILES)) for each in LAWS])
def test_each_cell_obeys_its_law(name: str) -> None:
    capability, law = LAWS[name]
    running = [(cell, robot) for cell, robot, verdict in cells_of(capability) if verdict is not Coverage.REJECTED]
    assert len(running) > 20
    assert not [(cell, fault) for cell, robot in running if (fault := law(robot))]
