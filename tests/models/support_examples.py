"""A robot for each feature of the table of support, as a point and as a body, and a short use of each capability."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import cablewright as cw
import out_of_plane
import planar_robots
from cablewright.analyses.accuracy.least_sensitive_tensions import best_tensions
from cablewright.analyses.accuracy.nozzle_error import AccuracyQuestion
from cablewright.analyses.bracket.loads import loads_at
from cablewright.calibration.survey.result import Exit, Survey, surveyed
from cablewright.control.homing import Homing, HomingSettings
from cablewright.control.path_follower import TimedPath
from cablewright.control.take_up import TakeUpSettings
from cablewright.control.velocity import VelocitySettings
from cablewright.exchange.firmware import firmware
from cablewright.exchange.klipper_config import klipper_anchors
from cablewright.exchange.mjcf import mjcf
from cablewright.exchange.urdf import urdf
from cablewright.exchange.wirex_output import wirex
from cablewright.live.estimator_settings import observer_settings
from cablewright.live.estimators import estimator
from cablewright.live.prints.limits import planned
from cablewright.machine.drives.drum_units import scales_of
from cablewright.machine.drives.settings import WinchDriveSettings
from cablewright.machine.settings import MachineSettings
from cablewright.machine.simulated.machine_file import machine_file
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.models.job_poses import along, sampled
from cablewright.models.support_table import Capability
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot, load
from cablewright.solvers.line_cover import refuse_unfit
from cablewright.solvers.slack import angle_from_excess
from physics.test_shared_winches import parallelograms

_FOLDER = tempfile.TemporaryDirectory()
ENDS = ((-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0))
CABLE = {
    "axial_stiffness": 2e5, "linear_density": 0.02, "breaking_load": 2e4, "diameter": 0.003, "young_modulus": None
}  # fmt: skip
DRUM = {"drum_radius": 0.05}
JOINT = {"kind": "universal-joint", "radius": 0.05, "lever": 0.104, "lever_weight": 6.85, "lever_mass_centre": 0.07}


def _line(name: str, exit_point: Any, **own: Any) -> dict[str, Any]:
    cable = {key: value for key, value in CABLE.items() if value is not None}
    limits = (5.0, 3000.0)
    plain = {"name": name, "exit_point": exit_point, "sheave": {"kind": "eyelet"}, "cable": cable, "winch": DRUM}
    return plain | {"tension_limits": limits} | own


FRAME = {"frame_min": (-2.0, -2.0, 0.0), "frame_max": (2.0, 2.0, 3.0)}


def _robot(name: str, platform: dict[str, Any], lines: list[dict[str, Any]], scene: dict[str, Any] = FRAME) -> Robot:
    return Robot.model_validate({"name": name, "scene": scene, "platform": platform, "lines": lines})


@cache
def plain(body: bool) -> Robot:
    """A point on 4 lines from above, or a body on 8, crossed, from above and below."""
    if not body:
        lines = [_line(f"line {k}", (*end, 3.0)) for k, end in enumerate(ENDS)]
        return _robot("point", {"mass": 20.0}, lines)
    own = load("cogiro")
    lines = [_line(line.name, line.exit_point, platform_point=line.platform_point) for line in own.lines]
    platform = {"kind": "rigid", "mass": 100.0, "inertia": (12.0, 13.0, 14.0)}
    return _robot("body", platform, lines, own.scene.model_dump())


def _guided(kind: str) -> Callable[[Any, Robot], dict[str, Any]]:
    def changes(line: Any, _robot: Robot) -> dict[str, Any]:
        index = 1 if kind == "aside" else 3 if kind == "wheels" else 0
        found = out_of_plane.guided(line, kind, index, np.random.default_rng(3))
        return {key: getattr(found, key) for key in ("sheave", "winch_exit", "guides", "platform_sheave")}

    return changes


def _matrix(_line: Any, _robot: Robot) -> dict[str, Any]:
    return {"exit_compliance": ((1e-6, 2e-7, 0.0), (2e-7, 2e-6, 0.0), (0.0, 0.0, 1e-6))}


_CHANGES: dict[str, Callable[[Any, Robot], dict[str, Any]]] = {
    "lines": lambda _line, _robot: {},
    "eyelet": lambda _line, _robot: {},
    "swivel": lambda _line, _robot: {"sheave": {"kind": "swivel", "radius": 0.04}},
    "universal-joint": lambda line, _robot: {
        "sheave": JOINT, "winch_exit": (*line.exit_point[:2], line.exit_point[2] - 2.5)
    },
    "pulley": _guided("pulleys"),
    "tilted-swivel": lambda _line, _robot: {"sheave": {"kind": "swivel", "radius": 0.06, "axis": (0.2, 0.1, 1.0)}},
    "winch-aside": _guided("aside"),
    "guides": _guided("guides"),
    "guide-wheels": _guided("wheels"),
    "platform-sheave": lambda _line, _robot: {"platform_sheave": {"radius": 0.03, "axis": (0.1, 0.0, -1.0)}},
    "sheave-to-sheave": lambda _line, _robot: {
        "sheave": {"kind": "swivel", "radius": 0.04}, "platform_sheave": {"radius": 0.03, "axis": (0.1, 0.0, -1.0)}
    },
    "platform-pulley": _guided("platform pulleys"),
    "advantage": lambda _line, _robot: {"advantage": 2},
    "cables": lambda _line, _robot: {"cables": 2},
    "mount": lambda _line, _robot: {"exit_compliance": 2e-6},
    "spatial-mount": _matrix,
    "spring": lambda _line, _robot: {"spring": 2e5},
    "counterweight": lambda _line, _robot: {"counterweight": 8.0, "winch": {}},
    "weightless": lambda line, _robot: {"cable": line.cable.model_copy(update={"linear_density": 0.0})},
    "unlike-cables": lambda line, _robot: {"cable": line.cable.model_copy(update={"breaking_load": 3e4})},
    "unlike-min-tensions": lambda _line, _robot: {"tension_limits": (6.0, 3000.0)},
    "no-diameter": lambda line, _robot: {"cable": line.cable.model_copy(update={"diameter": None})},
    "no-drum-radius": lambda _line, _robot: {"winch": {}},
    "shared-winch": lambda line, robot: {
        "shared_winch": {"line": robot.lines[1].name, "offset": 0.0, "winds": "along"}
    },
}  # fmt: skip


def _whole(robot: Robot, first: dict[str, Any]) -> Robot:
    table = robot.model_dump(by_alias=True)
    changed = {key: value.model_dump() if hasattr(value, "model_dump") else value for key, value in first.items()}
    lines = [table["lines"][0] | changed, *table["lines"][1:]]
    return Robot.model_validate(table | {"lines": lines})


def _kept(robot: Robot, lines: Iterable[int]) -> Robot:
    return robot.model_copy(update={"lines": tuple(robot.lines[k] for k in lines)})


@cache
def example(feature: str, body: bool) -> Robot | None:
    """A robot with a feature; None where no robot of this kind of platform has it."""
    found = _example(feature, body)
    if found is None or feature in ("no-diameter", "no-drum-radius"):
        return found
    wound = []
    for line in found.lines:
        own = line.winch.drum_radius is not None or line.counterweight
        winch = line.winch if own else line.winch.model_copy(update=DRUM)
        cable = line.cable.model_copy(update={"diameter": 0.003})
        wound.append(line.model_copy(update={"winch": winch, "cable": cable}))
    return found.model_copy(update={"lines": tuple(wound)})


def _example(feature: str, body: bool) -> Robot | None:
    robot = plain(body)
    if feature in ("shared-winch", "few-shared-winches") and body:
        robot = parallelograms(4)
        return robot.model_copy(update={"platform": robot.platform.model_copy(update={"inertia": (0.2, 0.2, 0.2)})})
    if feature in _CHANGES:
        return _whole(robot, _CHANGES[feature](robot.lines[0], robot))
    if feature == "plane":
        return planar_robots.board(body=body)
    if feature == "tilted-plane":
        return planar_robots.board("tilted", body=body)
    if feature == "few-lines-in-plane":
        return _kept(planar_robots.board(body=body), range(2, 4) if body else range(2, 3))
    if feature == "body":
        return robot if body else None
    if feature.startswith("over-"):
        most = int(feature.split("-")[1])
        angles = [2.0 * math.pi * k / (most + 1) for k in range(most + 1)]
        exits = [(2.0 * math.cos(angle), 2.0 * math.sin(angle), 3.0) for angle in angles]
        lines = [_line(f"line {k}", at) for k, at in enumerate(exits)]
        return None if body else _robot("many", {"mass": 20.0}, lines)
    if feature == "no-gravity":
        own = load("ipanema")
        return own.model_copy(update={"scene": own.scene.model_copy(update={"gravity": 0.0})}) if body else None
    if feature == "offset-point":
        at = [{"platform_point": (0.0, 0.0, 0.1)}] * robot.m
        table = robot.model_dump(by_alias=True)
        lines = [line | own for line, own in zip(table["lines"], at, strict=True)]
        return None if body else Robot.model_validate(table | {"lines": lines})
    if feature in ("few-winches", "free-position"):
        own = load("grab-four-lines") if feature == "few-winches" else None
        return own if body else _kept(robot, (0, 2))
    assert feature in ("retraction", "few-shared-winches")
    if not body:
        return None
    table = robot.model_dump(by_alias=True)
    table["platform"]["retraction"] = {"length": 0.2, "least": 0.1, "most": 0.4, "lines": [robot.lines[0].name]}
    return Robot.model_validate(table)


def pose_at(robot: Robot) -> np.ndarray:
    """A pose that the example can hold; NaN for what gravity decides."""
    plane = robot.platform.plane
    if plane is not None:
        at = planar_robots.places(robot, 1)[0]
        return at if robot.m >= robot.freedoms else _with_free(robot, at)
    if robot.n == 3:
        at = [0.0, -0.3, 1.2] if robot.sharing else [0.2, -0.3, 1.2]
        return np.array(at if robot.winches >= 3 else [0.2, np.nan, 1.2])
    if robot.sharing:
        return np.array([0.0, 0.0, 1.0, np.nan, np.nan, np.nan])
    if robot.name == "ipanema":
        return np.array([0.2, 0.1, 1.0, 0.0, 0.0, 0.0])
    if robot.m == 4:
        return np.array([1.1, 0.1, -0.2, np.nan, np.nan, 0.0])
    return np.array([0.5, 0.3, 1.5, 0.0, 0.0, 0.0])


def _with_free(robot: Robot, at: np.ndarray) -> np.ndarray:
    free = at.copy()
    if robot.n == 3:
        free[0] = np.nan
        return free
    across = int(np.argmax(np.abs(robot.platform.plane.across)))
    free[3 + across] = np.nan
    return free


@cache
def held(robot: Robot) -> cw.Equilibrium:
    """The example at its pose, solved."""
    return cw.inverse(robot, pose_at(robot))


@cache
def straight(robot: Robot) -> cw.Equilibrium:
    """As `held`, with rigid cables."""
    return cw.inverse(robot, pose_at(robot), cable="rigid")


@cache
def job_of(robot: Robot) -> Job:
    """A small square about the pose, in its plane if it has one."""
    plane = robot.platform.plane
    axes = np.eye(3) if plane is None else np.linalg.svd(np.array([plane.across]))[2][1:]
    at = held(robot).pose[:3] if robot.n == 3 else held(robot).nozzle
    corners = [20.0 * (a * axes[0] + b * axes[1]) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))]
    text = "G21\nG90\nM83\n;LAYER:0\n"
    for k, (x, y, z) in enumerate(corners):
        text += f"G{int(k > 0)} X{x:.6f} Y{y:.6f} Z{z:.6f}{' E5' if k else ''} F1200\n"
    file = Path(_FOLDER.name) / f"{hash(text)}.gcode"
    file.write_text(text)
    return load_job(file).model_copy(update={"origin": tuple(at.tolist())})


@cache
def twin(robot: Robot) -> TwinSettings:
    """A machine that fits the example: that of the plain one, or of few lines and planes its own."""
    own = robot if robot.name in ("grab-four-lines", "board") else plain(robot.n == 6)
    file = Path(_FOLDER.name) / "machine.toml"
    file.write_text(machine_file(own))
    return load_twin(file)


def on_drives(robot: Robot) -> MachineSettings:
    """Its machine on virtual drives, every second of which turns the other way."""
    nodes = {name: {"id": k + 1, "direction": (1, -1)[k % 2]} for k, name in enumerate(robot.winch_names)}
    table = {"interface": "loopback", "channel": "43113", "nodes": nodes, "rated_torque": 5.0, "tension": 30.0}
    return twin(robot).with_owner(kind="canopen", drives=WinchDriveSettings.model_validate(table)).owner


def _drives(robot: Robot) -> bool:
    return len(scales_of(robot, on_drives(robot))) == robot.winches


def _homed(robot: Robot) -> bool:
    take_up = TakeUpSettings(robot.winch_names, 30.0, 650.0, 0.05)
    settings = HomingSettings(
        cw.Model.of(robot), take_up, lambda _: None, lambda *_: None, np.zeros(3), (np.zeros(3), np.ones(3))
    )
    return Homing(settings).pose is None


def _surveyed(robot: Robot) -> bool:
    moved = np.add(robot.lines[0].exit_point, [0.01, 0.0, 0.0])
    exits = (Exit(robot.lines[0].name, moved, None, None, None),)
    found = Survey(exits, (), (), (), math.nan, math.nan, None, np.zeros((0, 0)), ())
    return np.allclose(surveyed(robot, found)[0].lines[0].exit_point, moved, atol=1e-4)


def _chosen(robot: Robot) -> bool:
    given = held(robot)[None]
    method = AccuracyQuestion.of(robot, method="first-order").method
    height = robot.lines[0].exit_point[2]
    ranges = (cw.Range(cw.Parameter("exit_point.z", robot.lines[0].name), height, height - 1e-3, height + 1e-3),)
    return best_tensions(given, ranges, method).max_deviation > 0.0


def _boxed(robot: Robot) -> list[float]:
    x, y, z = held(robot).pose[:3]
    return [x - 0.05, x + 0.05, y - 0.05, y + 0.05, z - 0.05, z + 0.05]


def _workspace(robot: Robot, criterion: str) -> bool:
    if robot.platform.plane is not None:
        return cw.workspace_area(robot, criterion, step=0.5).area > 0.0
    return cw.workspace(robot, criterion, grid=3, box=_boxed(robot)).volume > 0.0


def _boundary(robot: Robot) -> bool:
    given = {} if robot.platform.plane is not None else {"box": _boxed(robot)}
    return cw.boundary_modes(robot, "static", grid=5, **given).status == "ok"


def _along(robot: Robot) -> bool:
    job = job_of(robot)
    samples, _ = sampled(robot, job, job.toolpath())
    return len(along(robot, job, samples)[0]) > 0


def _simulated(robot: Robot) -> bool:
    machine = cw.SimulatedMachine(robot, twin(robot), pose_at(robot), seed=1)
    return bool(np.isfinite(machine.truth.position).all())


def _planned(robot: Robot) -> bool:
    owner, path = (
        twin(robot).owner,
        TimedPath.of(job_of(robot), nozzle=None if robot.n == 3 else robot.platform.nozzle),
    )
    return bool(planned(robot, owner, path, owner.period, "encoders", "model", None).velocity.gain)


def _tracked(robot: Robot) -> bool:
    found = held(robot)
    tracker = cw.Tracker(found.model, found.lengths, begin=found)
    return tracker.step(found.lengths + 1e-5) is cw.Status.OK


def _guessed(robot: Robot) -> bool:
    return cw.forward(robot, held(robot).lengths, guess=held(robot).pose).ok


def _exported(name: str) -> Callable[[Robot], tuple[str, ...]]:
    return lambda robot: firmware(name, robot, job_of(robot)).lost


PROBES: dict[Capability, Callable[[Robot], Any]] = {
    Capability.INVERSE: lambda robot: held(robot).ok,
    Capability.FORWARD: _guessed,
    Capability.LINEARISE: lambda robot: np.isfinite(cw.linearise(held(robot)).per_length).all(),
    Capability.MODES: lambda robot: np.isfinite(cw.modes(held(robot)).frequencies).all(),
    Capability.CERTIFY: lambda robot: bool(cw.certify(held(robot)).certified),
    Capability.TRACKER: _tracked,
    Capability.POSE_BOX: lambda robot: cw.enclose_poses(held(robot), 1e-6, tolerance=0.3).complete,
    Capability.EQUILIBRIA: lambda robot: len(cw.equilibria(robot, held(robot).lengths, starts=4)) > 0,
    Capability.EXHAUSTIVE: lambda robot: refuse_unfit(cw.Model.of(robot), held(robot).lengths) is None,
    Capability.TENSIONS: lambda robot: bool(cw.tension_distribution(robot, straight(robot).pose).feasible),
    Capability.WRENCH_CLOSURE: lambda robot: cw.wrench_closure(robot, held(robot).pose).margin <= 1.0,
    Capability.CAPACITY: lambda robot: math.isfinite(cw.capacity(robot, straight(robot).pose).margin),
    Capability.TENSION_CHOICE: _chosen,
    Capability.WORKSPACE: lambda robot: _workspace(robot, "static"),
    Capability.STRAIGHT_WORKSPACE: lambda robot: _workspace(robot, "exact"),
    Capability.BOUNDARY_MODES: _boundary,
    Capability.EXCESS: lambda robot: np.isfinite(cw.excess_lengths(held(robot))).all(),
    Capability.SLACK: lambda robot: any(
        cw.solve_with_slack(robot, held(robot).pose, {line: 0.02}).ok for line in (3, 1, 0)
    ),
    Capability.SHAPE: lambda robot: np.isfinite(
        angle_from_excess(cw.Model(robot), held(robot).pose, int(0 in robot.hung), 0.0, 0.05)
    ).all(),
    Capability.SLACK_SETS: lambda robot: isinstance(cw.slack_sets(robot, held(robot).pose), tuple),
    Capability.LET_OUT: lambda robot: bool(cw.let_out(robot, held(robot).lengths, robot.m - 1, [1e-4]).ok.all()),
    Capability.CHECK: lambda robot: cw.check(robot, job_of(robot), skip=("interference", "expected-error")).not_checked,
    Capability.PATH: _along,
    Capability.BRACKET: lambda robot: len(loads_at(cw.Model.of(robot), held(robot).pose[None])) == 2,
    Capability.SURVEY: _surveyed,
    Capability.CALIBRATION: lambda robot: len(cw.simulate_calibration(robot, 12, 1e-4).poses) == 12,
    Capability.ELASTIC_CALIBRATION: lambda robot: (
        len(cw.simulate_calibration(robot, 12, 1e-4, cable="elastic").poses) == 12
    ),
    Capability.SIMULATION: _simulated,
    Capability.MACHINE_FILE: machine_file,
    Capability.PRINT: _planned,
    Capability.ESTIMATION: lambda robot: estimator("encoders", robot, twin(robot).owner, held(robot).pose) is not None,
    Capability.ROOM_ESTIMATION: lambda robot: observer_settings(robot, cw.load_machine("merlet2023")).walls is not None,
    Capability.CONTROL: lambda robot: VelocitySettings(cw.Model.of(robot), 1.0, law="model").gain > 0.0,
    Capability.HOMING: _homed,
    Capability.DRIVES: _drives,
    Capability.KLIPPER: _exported("klipper"),
    Capability.KLIPPER_WINCH: lambda robot: klipper_anchors(robot).lost,
    Capability.REPRAPFIRMWARE: _exported("reprapfirmware"),
    Capability.LINUXCNC: _exported("linuxcnc"),
    Capability.WIREX: lambda robot: wirex(robot).lost,
    Capability.MJCF: lambda robot: mjcf(straight(robot)).lost,
    Capability.URDF: lambda robot: urdf(robot, held(robot).pose).lost,
}
