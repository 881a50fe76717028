"""Calibration of robots with features beside plain lines, against the Cramer-Rao bound.

``python -m benchmarks.campaigns.calibrated_features 100 0 [KINDS]``, KINDS with commas: machines a kind, first seed.
The model and all given sigmas are right, exit points of the file are within 10 mm, poses are measured to 1 mm (1 mrad):

* advantage: the Hangprinter, two spans a line; stretching: the same with lines that stretch and load cells;
* swivels: a point on four swivels with tilted axes, whose angle sensors have unknown zeros;
* guides: the same point with eyelets behind two guides each;
* body: eight lines of `cogiro` with an accelerometer, whose mounting is unknown;
* suspended: the body on four lines of `benchmarks.campaigns.twins`, without measured positions;
* pulleys, aside, ends: the point over pulleys in fixed planes, over swivels whose winches are aside of their axes, and
  to sheaves on the platform; pulleys_body, ends_body: the body so, with fixed wheels on it;
* pairs: a body on three pairs of parallel lines, each on one drum; hung: the point with a counterweight in place of a
  winch, and load cells; hung_blind: without load cells, so that nothing depends on that exit point;
* pulleys_stretching, aside_stretching, ends_stretching, guides_stretching, pairs_stretching, hung_stretching: the same
  with lines that stretch and load cells; board: a body in a plane on two such lines.

Columns: errors of all unknowns of known truth over the bound, rms, in the directions of its covariance; share of exit
points' coordinates within 1.96 of the printed sigma; whether they are in the joint 95 % ellipsoid; good verdicts.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.campaigns import twins
from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Known, Sigmas
from cablewright.calibration.poses.simulation import SensorNoise, measure, random_poses
from cablewright.robot import Cable, Eyelet, PlatformPulley, PlatformSheave, Pulley, Robot, Swivel, Winch, load

Array = NDArray[np.float64]
POSES, NOISE, POSITION, ANGLE, CELL = 40, 1e-4, 1e-3, 1e-3, 0.2  # m, m, rad, N
ROUGH = 0.01  # m
EXACT = ("build_up", "sheave_radius", "stretch", "tension_scale", "modulus")


class Case(NamedTuple):
    """A machine's file and data, the plan, and what is true of each unknown; NaN: not known."""

    file: Robot
    measured: Measured
    plan: CalibrationPlan
    truth: Array  # (k,)
    cable: str = "rigid"


def made(robot: Robot, seed: int, cable: str = "rigid", zeros: dict[str, float] | None = None, **noise: float) -> Case:
    """Return data of a *robot*, with *zeros* of sensors drawn to these standard deviations."""
    rng, zeros = np.random.default_rng(seed), zeros or {}
    sensors = SensorNoise(pose=POSITION, **noise)
    found = measure(robot, random_poses(robot, POSES, rng, cable), NOISE, rng, cable=cable, sensors=sensors)
    measured, offsets = found.measured, []
    for name, spread in zeros.items():
        read = getattr(measured, name)
        offsets.append(rng.normal(0.0, spread, read.shape[1]))
        measured = replace(measured, **{name: read - offsets[-1]})
    exits = np.array([line.exit_point for line in robot.lines])
    file = robot.with_(exit_points=exits + rng.uniform(-ROUGH, ROUGH, exits.shape))
    wound = [at for at in range(robot.m) if at not in robot.hung]
    seen = wound if cable == "rigid" and "tension" not in noise else list(range(robot.m))
    names = [*noise, "encoder"]
    exact = [name for name in EXACT if _may_be_known(name, robot, cable, noise)]
    plan = CalibrationPlan(
        unknowns=("exit_point", "length_offset", *(f"{name}_offset" for name in zeros)),
        sigma=Sigmas(**({"encoder": NOISE} | {name: noise[name] for name in names[:-1]})),
        known=tuple(Known(name=name, deviation=0.0) for name in exact),
    )
    return Case(file, measured, plan, np.concatenate([exits[seen].ravel(), found.home_lengths[wound], *offsets]), cable)


def _may_be_known(name: str, robot: Robot, cable: str, noise: dict[str, float]) -> bool:
    """Whether a plan of this robot can say that a number is exact."""
    if name == "sheave_radius":
        return any(not isinstance(line.sheave, Eyelet) for line in robot.lines)
    if name == "tension_scale":
        return "tension" in noise
    return (name == "modulus") == (cable != "rigid") if name in ("modulus", "stretch") else True


def over(robot: Robot, **parts: Callable[[Array, int], Any]) -> Robot:
    """Return the robot with other *parts* of its lines, by their exit point (3,) and index."""
    lines = [
        line.model_copy(update={name: of(np.array(line.exit_point), i) for name, of in parts.items()})
        for i, line in enumerate(robot.lines)
    ]
    return Robot.model_validate(robot.model_copy(update={"lines": tuple(lines), "uncertainty": None}).model_dump())


def advantage(seed: int) -> Case:
    """A Hangprinter."""
    return made(load("hangprinter-v4"), seed)


def stretching(seed: int) -> Case:
    """A Hangprinter whose lines stretch."""
    return made(load("hangprinter-v4"), seed, "elastic", tension=CELL)


def swivels(seed: int) -> Case:
    """Swivels out of the vertical."""
    axes = np.random.default_rng(seed + 10**6).normal(0.0, 0.3, (4, 2))
    robot = over(load("wang2021"), sheave=lambda _, i: Swivel(radius=0.075, axis=(*axes[i].tolist(), 1.0)))
    return made(robot, seed, zeros={"swivel": 0.1}, swivel=ANGLE)


def guides(seed: int) -> Case:
    """Eyelets behind guides."""
    ways = np.array([(0.5, 0.2, -2.0), (0.3, 0.1, 0.2)])
    robot = over(
        load("wang2021"),
        sheave=lambda _, __: Eyelet(),
        winch_exit=lambda at, _: tuple((at - [0.0, 0.0, 3.0]).tolist()),
        guides=lambda at, _: tuple(tuple((at + way).tolist()) for way in ways),
    )
    return made(robot, seed)


def body(seed: int) -> Case:
    """Eight lines."""
    return made(load("cogiro"), seed, zeros={"tilt": 0.01}, tilt=ANGLE)


def suspended(seed: int) -> Case:
    """A body on four lines."""
    twin = twins.suspended(seed)
    return Case(twin.file, twin.measured, twin.plan, twin.exits, twin.law)


def drawn(kind: str, body: bool = False) -> Robot:
    """Return the point of `wang2021` or the body of `cogiro` with other guides at each line."""
    robot = load("cogiro" if body else "wang2021")
    rng = np.random.default_rng(3)

    def inward(at: Array) -> Array:
        way = -at * [1.0, 1.0, 0.0]
        return way / np.linalg.norm(way)

    def aside(at: Array) -> Array:
        return at - [0.0, 0.0, 2.0] + 0.5 * np.cross([0.0, 0.0, 1.0], inward(at)) - 0.3 * inward(at)

    def wheel(at: Array, i: int) -> PlatformPulley:
        to = at - np.array(robot.lines[i].platform_point)
        to = to / np.linalg.norm(to)
        way = unit(np.cross(to, rng.normal(size=3)) - 0.5 * to)
        axis = unit(np.cross(way, to))
        return PlatformPulley(radius=0.03, axis=axis, leaves=tuple(np.cross(axis, np.cross(way, axis)).tolist()))

    parts: dict[str, dict[str, Callable[[Array, int], Any]]] = {
        "pulleys": {
            "sheave": lambda at, _: Pulley(radius=0.08, axis=unit(np.cross([0.0, 0.0, 1.0], inward(at)))),
            "winch_exit": lambda at, _: tuple((at - 0.08 * inward(at) - [0.0, 0.0, 2.0]).tolist()),
        },
        "aside": {
            "sheave": lambda _, __: Swivel(radius=0.06),
            "winch_exit": lambda at, _: tuple(aside(at).tolist()),
        },
        "ends": {
            "sheave": lambda _, __: Eyelet(),
            "platform_sheave": lambda at, i: wheel(at, i) if body else PlatformSheave(radius=0.03, axis=(0.1, 0, -1)),
        },
        "guides": {
            "sheave": lambda _, __: Eyelet(),
            "winch_exit": lambda at, _: tuple((at - [0.0, 0.0, 3.0]).tolist()),
            "guides": lambda at, _: tuple(tuple((at + way).tolist()) for way in ((0.5, 0.2, -2.0), (0.3, 0.1, 0.2))),
        },
    }
    return over(robot, **({} if kind == "guides" else {"guides": lambda _, __: ()}), **parts[kind])


def unit(way: Array) -> tuple[float, ...]:
    """Return the unit vector of a direction."""
    return tuple((way / np.linalg.norm(way)).tolist())


def pairs_of_lines() -> Robot:
    """Return a body on three pairs of parallel lines, each pair on one drum."""
    lines = []
    for k in range(3):
        angle = 2.0 * np.pi * k / 3.0 + 0.3
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        for side, name in ((0.2, "a"), (-0.2, "b")):
            beside = side * np.array([-out[1], out[0], 0.0])
            own = {"name": f"{k}{name}", "exit_point": (2.0 * out + beside + [0.0, 0.0, 2.8]).tolist()}
            own["platform_point"] = (0.25 * out + beside + [0.0, 0.0, 0.1]).tolist()
            lines.append(own | ({"shared_winch": {"line": f"{k}a"}} if name == "b" else {}))
    cable = {"axial_stiffness": 6e4, "linear_density": 0.002, "breaking_load": 2e3}
    common = {"cable": cable, "sheave": {"kind": "eyelet"}, "tension_limits": (0.5, 400.0)}
    scene = {"frame_min": (-2.0, -2.0, 0.0), "frame_max": (2.0, 2.0, 2.6)}
    parts = {"name": "pairs", "scene": scene, "platform": {"kind": "rigid", "mass": 6.0}}
    return Robot.model_validate(parts | {"lines": [common | each for each in lines]})


def hung_point() -> Robot:
    """Return a point on four winches and a counterweight above them."""
    robot = load("wang2021")
    first = robot.lines[0]
    more = first.model_copy(
        update={
            "name": "weight", "exit_point": (0.3, 0.2, 4.5), "sheave": Eyelet(), "winch_exit": None, "winch": Winch(),
            "counterweight": 0.4 * robot.platform.mass,
        }
    )  # fmt: skip
    return Robot.model_validate(robot.model_copy(update={"lines": (*robot.lines, more)}).model_dump())


def board(seed: int) -> Case:
    """A body in a vertical plane on two lines."""
    exits, points = ((-1.2, 0.25, 1.0), (1.2, 0.25, 1.0)), ((-0.1, 0.0, 0.1), (0.12, 0.0, 0.1))
    robot = Robot.from_points(
        exits, points, mass=5.0, cable=Cable(axial_stiffness=5e4, linear_density=0.02, breaking_load=1e4),
        tension_limits=(2.0, 300.0), frame=((-1.2, -0.5, -1.0), (1.2, 0.5, 1.0)), inertia=(0.1, 0.12, 0.14),
        plane={"normal": (0.0, 1.0, 0.0), "distance": 0.0, "one_sided": False},
    )  # fmt: skip
    return made(robot, seed, "elastic", tension=CELL)


MORE: dict[str, Callable[[int], Case]] = {
    **{kind: lambda seed, kind=kind: made(drawn(kind), seed) for kind in ("pulleys", "aside", "ends")},
    **{f"{kind}_body": lambda seed, kind=kind: made(drawn(kind, True), seed) for kind in ("pulleys", "ends")},
    "pairs": lambda seed: made(pairs_of_lines(), seed),
    "hung": lambda seed: made(hung_point(), seed, tension=CELL),
    "hung_blind": lambda seed: made(hung_point(), seed),
    **{
        f"{kind}_stretching": lambda seed, kind=kind: made(drawn(kind), seed, "elastic", tension=CELL)
        for kind in ("pulleys", "aside", "ends", "guides")
    },
    "pairs_stretching": lambda seed: made(pairs_of_lines(), seed, "elastic", tension=CELL),
    "hung_stretching": lambda seed: made(hung_point(), seed, "elastic", tension=CELL),
    "board": board,
}
KINDS = {each.__name__: each for each in (advantage, stretching, swivels, guides, body, suspended)} | MORE


class Figures(NamedTuple):
    """Results of the machines of one kind."""

    errors: Array  # (.., k): of the unknowns over the bound, in the directions of its covariance
    inside: Array  # (.., e): whether coordinates of exit points are within 1.96 sigma
    joint: Array  # (..,): whether they are in the joint 95 % ellipsoid
    verdicts: tuple[str, ...]
    failures: tuple[str, ...]

    @property
    def rms(self) -> float:
        """Root mean square of errors over the bound."""
        return float(np.sqrt(np.mean(np.square(self.errors))))


def figures(kind: str, seeds: Iterable[int]) -> Figures:
    """Calibrate a machine of a kind for each of the *seeds*."""
    white, inside, joint, verdicts, failures = [], [], [], [], []
    for seed in seeds:
        case = KINDS[kind](seed)
        found = calibrate(case.file, case.measured, case.plan, rough=0.05, need=5e-3, cable=case.cable)
        if found.status != "ok":
            failures.append(f"{kind} {seed}: {found.reason}")
            continue
        k = len(case.truth)
        e = sum(each.name == "exit_point" for each in found.unknowns)
        off, sizes = found.values[:k] - case.truth, np.array([one.size for one in found.unknowns[:k]])
        bound = found.posterior.covariance[:k, :k] * np.outer(sizes, sizes) * found.scale**2
        unit_sizes = np.sqrt(np.diag(bound))
        values, ways = np.linalg.eigh(bound / np.outer(unit_sizes, unit_sizes))
        white.append((ways.T @ (off / unit_sizes)) / np.sqrt(values))
        inside.append(np.abs(off[:e]) < 1.96 * found.sigma[:e])
        own = found.covariance[:e, :e]
        joint.append(float(off[:e] @ np.linalg.solve(own, off[:e])) < found.joint_limit(e))
        verdicts.append(found.verdict)
    return Figures(np.array(white), np.array(inside), np.array(joint), tuple(verdicts), tuple(failures))


def main(count: int, seed: int, kinds: str) -> None:
    """Print a line a kind."""
    for name in kinds.split(","):
        found = figures(name, range(seed, seed + count))
        for failure in found.failures:
            print(failure, flush=True)
        print(
            f"{name}, {len(found.verdicts)} of {count}: over the bound, rms {found.rms:.3f}; within 1.96 sigma "
            f"{100 * found.inside.mean():.1f} %; joint {100 * found.joint.mean():.1f} %; "
            f"good {100 * np.mean([each == 'good' for each in found.verdicts]):.0f} %",
            flush=True,
        )


if __name__ == "__main__":
    given = [*sys.argv[1:], *["20", "0", ",".join(KINDS)][len(sys.argv) - 1 :]]
    main(int(given[0]), int(given[1]), given[2])
