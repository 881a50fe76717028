"""Cells of homing, prints and firmware with own kinematics obey a law: statics, or a round trip."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tools.pages.line_prints import distance_from

import cablewright as cw
from cablewright.control.homing import Homing, HomingSettings
from cablewright.control.take_up import TakeUpSettings
from cablewright.exchange.firmware import firmware
from cablewright.exchange.formats import read_robot
from cablewright.exchange.klipper_config import klipper_anchors
from cablewright.foundation.signals import (
    Encoders,
    Estimate,
    PrintState,
    SensorFrame,
    Tensions,
    frozen,
)
from cablewright.live.estimators import estimator
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.support_table import Capability, Coverage, support
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Robot
from models import support_examples as examples
from models.test_support_laws import EXACT
from models.test_support_table import cells_of

UNKNOWN = frozen(np.full(3, np.nan))
MICRO = 16


def exact(robot: Robot) -> TwinSettings:
    """The machine that is built for a robot, exactly as described."""
    made = built_machine(robot)[0]
    even = made.simulation.winch.model_copy(update={"radius_walk": 0.0, "sideways_walk": 0.0})
    return made.with_simulation(tolerances=EXACT, winch=even)


def homed(robot: Robot, place: np.ndarray | None, saved: np.ndarray | None) -> tuple[str, list[np.ndarray]]:
    """Why homing fails, and the lengths and the pose that it accepts, on drums with the torques of the statics."""
    held, winches, accepted = examples.held(robot), WinchLines.of(robot), list[np.ndarray]()
    arms = 0.05 * np.array([line.cables for line in robot.lines])
    torques = winches.torques(held.tensions, arms)
    take_up = TakeUpSettings(
        robot.winch_names, 0.1, 650.0, 0.05, arms=np.full(robot.winches, 0.05), opposed=winches.opposed
    )
    box = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    settings = HomingSettings(
        cw.Model.full(robot), take_up, lambda _: saved, lambda lengths, _, pose: accepted.extend((lengths, pose)),
        held.pose, box, place, lambda read, _, expected: winches.tensions(read, arms, expected),
    )  # fmt: skip
    homing, counts = Homing(settings), np.zeros(robot.winches, np.int64)
    nothing = Estimate(0.0, *(UNKNOWN,) * 5, np.zeros(robot.m, np.bool_), UNKNOWN, valid=False)
    for now in 0.1 * np.arange(1, 40):
        read = Tensions("motor_torques", now, frozen(np.full(robot.winches, np.nan)), frozen(torques))
        done = homing.step(SensorFrame(now, (Encoders(now, counts), read)), nothing, 0.1)
        if done.finished or done.failure:
            return done.failure, accepted
        if done.winch_speeds.any():
            return "it moves to find the wrong line", accepted
    return "it does not end", accepted


def homes(robot: Robot) -> str:
    """At a measured place lengths are those of the inverse problem; saved ones lead there, and a wrong one is found."""
    held = examples.held(robot)
    why, found = homed(robot, held.pose, None)
    if why or max(np.abs(found[0] - held.lengths).max(), np.abs(found[1] - held.pose).max()) > 4e-4:
        return why or f"lengths differ by {1e3 * np.abs(found[0] - held.lengths).max():.3g} mm"
    why, found = homed(robot, None, held.lengths)
    if robot.m - len(robot.hung) <= robot.freedoms:
        return "" if "no more lines than degrees of freedom" in why else f"without a place: {why}"
    if why or np.abs(found[1] - held.pose).max() > 4e-4:
        return why or f"the pose differs by {1e3 * np.abs(found[1] - held.pose).max():.3g} mm"
    why, found = homed(robot, None, held.lengths + 0.1 * (np.arange(robot.m) == robot.hosts[0]))
    return "" if why and not found else "a wrong length is not found"


def prints(robot: Robot) -> str:
    """On a machine as described, from rest to rest, the nozzle stays on the job's path."""
    own_winches = robot.winches >= robot.freedoms and not robot.sharing and robot.retraction is None
    if not own_winches or support(robot, Capability.MACHINE_FILE).verdict is Coverage.REJECTED:
        return ""  # others have prints of their own in tests/live/prints
    options = PrintOptions("encoders", plant="quasi-static", period=0.1)
    twin = twin_of(robot, examples.job_of(robot), exact(robot), options)
    path, off = twin.path, list[float]()
    rig = SimulatedMachine(robot, twin.settings, path.start_pose, seed=1, plant="quasi-static")
    printer = Printer(
        plan_print(twin), rig, lambda at, radii: estimator("encoders", robot, rig.settings, at, (), radii)
    )
    attendant = Attendant(lambda: None)
    for _ in range(1500):
        step = printer.step(attendant.orders(printer, rig.time))
        if step.progress.state is PrintState.PRINTING:
            truth = rig.truth
            nozzle = truth.position if robot.n == 3 else path.printing_point(truth.position, truth.rotation)
            off.append(distance_from(path.track, nozzle, step.progress.distance))
        if printer.finished:
            break
    ended = printer.finished and len(off) > 20
    return "" if ended and max(off) < 5e-4 else printer.supervisor.reason or f"it is {1e3 * max(off):.3g} mm off"


def is_read_back(robot: Robot) -> str:
    """Anchors and radii that Klipper's file has are those of the robot, with lines at one point."""
    path = Path(examples._FOLDER.name) / "printer.cfg"
    path.write_text(klipper_anchors(robot).text)
    for ours, back in zip(robot.lines, read_robot([path]).robot.lines, strict=True):
        at = np.subtract(ours.exit_point, ours.platform_point)
        if not np.allclose(back.exit_point, at, atol=1e-9):
            return f"anchor {back.name}: {back.exit_point}"
        if not np.isclose(back.winch.drum_radius, ours.winch.drum_radius, rtol=1e-9):
            return f"anchor {back.name}: {back.winch.drum_radius} m"
    return ""


def turns_as_its_file(robot: Robot) -> str:
    """Motors at the steps of RepRapFirmware's law pay out what the robot that its file describes has to."""
    made = firmware("reprapfirmware", robot.limited((5.0, 900.0)), examples.job_of(robot))  # of the cable of an import
    path = Path(examples._FOLDER.name) / "config.g"
    path.write_text(made.files["config.g"])
    back, words = read_robot([path]).robot, dict[str, np.ndarray]()
    for code, rest in re.findall(r"(?m)^(M669|M666) ([^;\n]*)", made.files["config.g"]):
        words |= {code + key: np.array(each.split(":"), float) for key, each in re.findall(r"([A-Z])([-0-9.:]+)", rest)}
    points = re.findall(r"(?m)^G[01] .*?X(\S+) Y(\S+) Z(\S+)", made.files["job.g"])
    at = np.array([points[0], points[len(points) // 2]], float)
    paid = [cw.inverse(back, 1e-3 * each, cable="rigid").lengths for each in at]
    anchors = 1e3 * np.array([line.exit_point for line in back.lines])
    own = 1e3 * np.array([np.subtract(line.exit_point, line.platform_point) for line in robot.lines])
    if not np.allclose(anchors, own, atol=1e-3):
        return f"anchors {anchors.tolist()}"
    apart = np.linalg.norm(at[:, None] - anchors, axis=2)
    rise = apart - np.linalg.norm(anchors, axis=1)
    u, o, r, q = (words[f"M666{key}"] for key in "UORQ")
    turned = u * rise / r if not q[0] else (np.sqrt(r**2 - u * o * q * rise) - r) * -2.0 / (o * q)
    drums = np.array([line.winch.drum_radius for line in robot.lines])
    off = np.abs(drums * (turned[1] - turned[0]) - (paid[1] - paid[0])).max()  # of cable
    return "" if off < 1e-4 else f"a line is {1e3 * off:.3g} mm off"


LAWS: dict[str, tuple[Capability, Callable[[Robot], str]]] = {
    "homing finds the lengths of statics": (Capability.HOMING, homes),
    "a print keeps its path": (Capability.PRINT, prints),
    "klipper's winches are read back": (Capability.KLIPPER_WINCH, is_read_back),
    "reprapfirmware": (Capability.REPRAPFIRMWARE, turns_as_its_file),
}
SLOW = (Capability.PRINT, Capability.REPRAPFIRMWARE)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (LAWS[name][0] in SLOW)) for name in LAWS]
)
def test_each_cell_obeys_its_law(name: str) -> None:
    capability, law = LAWS[name]
    running = [(cell, robot) for cell, robot, verdict in cells_of(capability) if verdict is not Coverage.REJECTED]
    assert len(running) > 10
    assert not [(cell, fault) for cell, robot in running if (fault := law(robot))]
