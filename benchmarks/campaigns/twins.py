"""Calibration of simulated machines with the defects of makers' machines, against an oracle that knows these.

``python -m benchmarks.campaigns.twins 200 0 [KINDS]``, KINDS with commas. Three kinds of machines. Those of the first
two are calibrated from 44 poses, of which 9 are measured, by `calibrate(models="auto")` and by an oracle with the true
build-up, counts without stretch and deflection, and good positions:

* spools: a printer with 4 lines of two spans. Friction of its eyelets changes tensions by 3 % either way, EA is 20 %
  less than in the file, the build-up of its spools is known to 10 %, 3 of the 9 positions are wrong by 3 mm, anchors
  give 2 um/N.
* belts: 4 toothed belts to a point, which stretch by 0.2 % at their mean tension, 20 % less by the file, on a frame
  that bends by 2 mm at the mean force.
* suspended: a body on 4 lines over swivels with horizontal axes and angle sensors, calibrated from 27 poses without any
  measured position. Its free freedoms are solved by gravity, which is 0.5 deg off the surveyed frame. Zeros of the
  angle sensors are 1 deg off, those of tilts 0.5 deg and of load cells 2 N, the centre of mass 5 mm; the noise of
  lengths is 3 mm, of cells 0.5 N, of angles 1 mrad. The oracle knows gravity, zeros and the centre of mass.
  `suspended8` has 8 poses.

In ``outside_belts`` and ``outside_suspended`` the sheave of one line has a radius 2 mm from that in the file, in
``outside_spools`` the drum, as eyelets have no radius. Columns: held-out positions from lengths alone, rms; the error
of the first pose, of which the lengths at home tell; errors of exit points over the printed sigma, rms; whether the
truth is in the joint 95 % ellipsoid of all exit points, `Calibration.joint_limit`; whether the verdict asks for a
number of a single line, and the power of the best test of the first sheave's radius alone (Neyman, Pearson 1933).
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.judgement.unmodelled_effects import corrections
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Known, Prior, Sigmas
from cablewright.calibration.poses.elastic import ElasticProblem, problem_of
from cablewright.calibration.poses.fit import fitted_poses
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import SensorNoise, measure, random_poses
from cablewright.calibration.poses.start_values import equilibria_at
from cablewright.models.drum import WinchDrum
from cablewright.models.fidelity import Fidelity
from cablewright.models.rotation import matrices
from cablewright.models.statics import Model
from cablewright.robot import Robot, Swivel, load
from cablewright.solvers.inverse import solve_inverse

Array = NDArray[np.float64]
POSES, KNOWN, HELD_OUT = 44, 9, 40
ROUGH = 0.01  # m: of the file's exit points
NOISE, POSITION = 2e-4, 1e-3  # m
BUILD_UP = 5e-3  # 1/m
FRICTION, SOFTER, OFF, WRONG, GIVES = 0.03, 0.8, 0.1, 3e-3, 2e-6
STRETCH, BENDING = 2e-3, 2e-3
RADIUS = 2e-3  # m
LENGTH_NOISE, ANGLE_NOISE, SURVEY, CENTRE = 3e-3, 1e-3, 1e-3, 5e-3  # m, rad, m, m
CELL_NOISE, CELL_ZERO = 0.5, 2.0  # N
ZEROS = ("tension_offset", "swivel_offset", "tilt_offset")
ZERO, TILT = math.radians(1.0), math.radians(0.5)


@dataclass(frozen=True)
class Twin:
    """A machine's file and data, what an oracle would have instead, and what is true."""

    file: Robot
    measured: Measured
    plan: CalibrationPlan
    oracle: Measured
    oracle_plan: CalibrationPlan
    exits: Array  # (3 m,)
    poses: Array  # (HELD_OUT, 3)
    counts: Array  # (HELD_OUT, m)
    oracle_counts: Array
    start: Array  # (3,) the first pose of the calibration
    oracle_file: Robot | None = None  # where it is another one
    law: str = "rigid"


def spools(seed: int, larger: float = 0.0) -> Twin:
    """A spool printer; the drum of the first line is *larger* than in the file, m."""
    robot, rng = load("hangprinter-v4"), np.random.default_rng(seed)
    poses = random_poses(robot, POSES + HELD_OUT, rng)
    tensions = solve_inverse(Model(robot, Fidelity.of("rigid")), poses).tensions
    tensions = tensions * (1.0 + FRICTION * rng.choice([-1.0, 1.0], tensions.shape))
    lines = []
    for line in robot.lines:
        length = line.advantage * math.dist(line.exit_point, line.platform_point)
        winch = line.winch.model_copy(update={"build_up": BUILD_UP, "drum_length": length})
        lines.append(line.model_copy(update={"winch": winch}))
    robot = robot.model_copy(update={"lines": tuple(lines)})
    made = measure(robot, poses, 0.0, rng)
    lengths = made.measured.counted + made.home_lengths
    ea = SOFTER * np.array([line.cable.stiffness for line in robot.lines])
    spans = np.array([float(line.advantage) for line in robot.lines])
    less = tensions * (lengths / ea + spans**2 * GIVES)
    true = BUILD_UP * (1.0 + OFF * rng.normal())
    by_drum = [True] * robot.m
    plan = CalibrationPlan(
        unknowns=("exit_point", "length_offset", "build_up"),
        priors=(
            Prior(name="build_up", deviation=OFF * BUILD_UP),
            Prior(name="build_up", deviation=1e-5, alike=True),
        ),
    )
    right = tuple(
        line.model_copy(update={"winch": line.winch.model_copy(update={"build_up": true})}) for line in robot.lines
    )
    counted = _wound(robot.model_copy(update={"lines": right}), lengths - less)
    first = robot.lines[0].winch.drum_radius
    assert first is not None
    counted[:, 0] *= first / (first + larger)  # in m by the radius in the file
    without = _wound(robot, lengths)
    return _twin(robot, rng, poses, counted, without, plan, by_drum, wrong=3)


def belts(seed: int, larger: float = 0.0) -> Twin:
    """A belt frame; the first sheave is *larger* than in the file, m."""
    robot, rng = load("wang2021"), np.random.default_rng(seed)
    poses = random_poses(robot, POSES + HELD_OUT, rng)
    tensions = solve_inverse(Model(robot, Fidelity.of("rigid")), poses).tensions
    stiffness = {"axial_stiffness": tensions.mean() / STRETCH / SOFTER, "young_modulus": None, "section": None}
    lines = [line.model_copy(update={"cable": line.cable.model_copy(update=stiffness)}) for line in robot.lines]
    robot = robot.model_copy(update={"lines": tuple(lines)})
    made = measure(_with_radius(robot, larger), poses, 0.0, rng)
    lengths = made.measured.counted + made.home_lengths
    share = tensions / tensions.mean()
    less = STRETCH * share * lengths + BENDING * share
    plan = CalibrationPlan(known=(Known(name="build_up", deviation=0.0),))
    return _twin(robot, rng, poses, lengths - less, lengths, plan, (), wrong=0)


def suspended(seed: int, count: int = 27, larger: float = 0.0) -> Twin:
    """A suspended body, *count* poses; the sheave of the first line is *larger* than in the file, m."""
    own, rng = load("grab-four-lines"), np.random.default_rng(seed)
    lines = [
        line.model_copy(
            update={"sheave": Swivel(radius=0.0225, axis=(1.0 if line.exit_point[0] < 1.1 else -1.0, 0, 0))}
        )
        for line in own.lines
    ]
    file = Robot.model_validate(own.model_copy(update={"lines": tuple(lines)}).model_dump())
    centre = np.array(file.platform.centre_of_mass) + CENTRE * rng.normal(size=3) / math.sqrt(3.0)
    platform = file.platform.model_copy(update={"centre_of_mass": tuple(centre.tolist())})
    points = np.array([line.exit_point for line in file.lines])
    middle, way = points.mean(axis=0), rng.uniform(0.0, math.tau)
    turn = matrices([TILT * math.cos(way), TILT * math.sin(way), 0.0])
    level = (points - middle) @ turn.T + middle
    exits = level + rng.normal(0.0, SURVEY, points.shape)
    true = _with_exits(file.model_copy(update={"platform": platform}), exits)
    true = _with_radius(true, larger)
    model = Model(true, Fidelity.of("elastic"))
    poses = random_poses(model, count + HELD_OUT, rng)
    noise = SensorNoise(tension=CELL_NOISE, swivel=ANGLE_NOISE, tilt=ANGLE_NOISE)
    made = measure(model, poses, LENGTH_NOISE, rng, sensors=noise).measured
    zeros = [spread * rng.normal(size=size) for spread, size in ((CELL_ZERO, file.m), (ZERO, file.m), (TILT, 2))]
    true_zeros = [np.zeros_like(each) for each in zeros]
    read, good = (
        Measured(
            made.counted[:count],
            made.guess[:count],
            tensions=made.tensions[:count] - off[0],
            swivel=made.swivel[:count] - off[1],
            tilt=made.tilt[:count] - off[2],
        )
        for off in (zeros, true_zeros)
    )
    plan = CalibrationPlan(
        unknowns=("exit_point", "length_offset", *ZEROS, "centre_of_mass"),
        sigma=Sigmas(encoder=LENGTH_NOISE, tension=CELL_NOISE, swivel=ANGLE_NOISE, tilt=ANGLE_NOISE),
        level=TILT,
        priors=(
            Prior(name="exit_point", deviation=SURVEY, tilted=True),
            *(Prior(name=name, deviation=spread) for name, spread in zip(ZEROS, (CELL_ZERO, ZERO, TILT), strict=True)),
            Prior(name="centre_of_mass", deviation=CENTRE / math.sqrt(3.0)),
        ),
    )
    surveyed = (Prior(name="exit_point", deviation=SURVEY),)
    oracle = plan.model_copy(update={"unknowns": plan.unknowns[:2], "priors": surveyed, "level": None})
    return Twin(
        file,
        read,
        plan,
        good,
        oracle,
        exits.ravel(),
        poses[count:, :3],
        made.counted[count:],
        made.counted[count:],
        poses[0, :3],
        _with_radius(_with_exits(true, level), -larger),
        "elastic",
    )


def suspended8(seed: int) -> Twin:
    """The same of 8 poses."""
    return suspended(seed, 8)


def outside_belts(seed: int) -> Twin:
    """A belt frame, of which the sheave of one line has another radius."""
    return belts(seed, RADIUS)


def outside_suspended(seed: int) -> Twin:
    """A suspended body, of which the sheave of one line has another radius."""
    return suspended(seed, larger=RADIUS)


def outside_spools(seed: int) -> Twin:
    """A spool printer, of which the drum of one line has another radius: its eyelets have none."""
    return spools(seed, RADIUS)


def _with_exits(robot: Robot, exits: Array) -> Robot:
    """Return the robot with other exit points (m, 3), m."""
    pairs = zip(robot.lines, exits.tolist(), strict=True)
    return robot.model_copy(
        update={"lines": tuple(line.model_copy(update={"exit_point": tuple(to)}) for line, to in pairs)}
    )


def _with_radius(robot: Robot, larger: float) -> Robot:
    """Return the robot with a sheave of the first line that is *larger*, m."""
    first = robot.lines[0].sheave
    assert first.kind == "swivel"
    sheave = {"sheave": first.model_copy(update={"radius": first.radius + larger})}
    return robot.model_copy(update={"lines": (robot.lines[0].model_copy(update=sheave), *robot.lines[1:])})


def _wound(robot: Robot, lengths: Array) -> Array:
    """Return what the drums of a robot count, m by the radius in its file, as lines have *lengths* (N, m)."""
    found = np.zeros_like(lengths)
    for at, line in enumerate(robot.lines):
        radius, build_up = line.winch.drum_radius or 1.0, line.winch.build_up or 0.0
        drum = WinchDrum(radius, build_up=build_up, at=line.winch.drum_length or 0.0)
        found[:, at] = radius * drum.angles(lengths[:, at])
    return found


def _twin(
    robot: Robot,
    rng: np.random.Generator,
    poses: Array,
    counted: Array,
    without: Array,
    plan: CalibrationPlan,
    by_drum: list[bool] | tuple[()],
    wrong: int,
) -> Twin:
    noise = rng.normal(0.0, NOISE, counted.shape)
    counted, without = (each - each[0] + noise for each in (counted, without))
    exits = np.array([line.exit_point for line in robot.lines])
    file = _with_exits(robot, exits + rng.uniform(-ROUGH, ROUGH, exits.shape))
    own = poses[:POSES]
    known = np.arange(POSES)[:, None] < KNOWN
    guess = np.where(known, own + rng.normal(0.0, POSITION, own.shape), own + rng.uniform(-0.05, 0.05, own.shape))
    ways = rng.normal(size=own.shape)
    bad = (np.arange(POSES)[:, None] < wrong) * WRONG * ways / np.linalg.norm(ways, axis=1, keepdims=True)
    sigma = np.where(known, POSITION, np.nan)
    sigma_of_good = np.where(np.arange(POSES)[:, None] < wrong, np.nan, sigma)
    oracle_plan = CalibrationPlan(known=(Known(name="build_up", deviation=0.0), Known(name="stretch", deviation=0.0)))
    return Twin(
        file,
        Measured(counted[:POSES], guess + bad, sigma, by_drum=by_drum),
        plan.model_copy(update={"sigma": Sigmas()}),
        Measured(without[:POSES], guess, sigma_of_good, by_drum=by_drum),
        oracle_plan,
        exits.ravel(),
        poses[POSES:],
        counted[POSES:],
        without[POSES:],
        own[0],
    )


def errors(twin: Twin, found: Calibration, counts: Array) -> Array:
    """Return the errors (HELD_OUT,) of positions, m, that the calibrated robot finds from *counts* (HELD_OUT, m)."""
    by_drum = found.problem.measured.by_drum
    poses = np.hstack([twin.poses + 0.01, np.zeros((len(twin.poses), found.problem.robot.n - 3))])
    if found.problem.elastic:
        problem = problem_of(found.problem.model, Measured(counts, poses), found.problem.plan)
        assert isinstance(problem, ElasticProblem)
        states = problem.states_of(equilibria_at(problem, Model(found.robot), poses))
        return _off(problem.poses_of(fitted_poses(problem, found.fit.theta, states)), twin.poses)
    chosen = {each.name: each.value for each in found.effects if each.chosen}
    for _ in range(3):
        data = Measured(counts, poses, by_drum=by_drum)
        problem = StraightProblem.of(found.problem.robot, data, found.problem.plan.model_copy(update={"datum": ()}))
        fit = replace(found.fit, poses=poses, weights=problem.weights)
        more = corrections(problem, fit, counts)
        longer = sum((value * more[name] for name, value in chosen.items() if name in more), np.zeros_like(counts))
        problem = StraightProblem.of(problem.robot, replace(data, counted=counts + longer), problem.plan)
        poses = fitted_poses(problem, found.fit.theta, poses)
    return _off(poses, twin.poses)


def _off(poses: Array, true: Array) -> Array:
    return np.asarray(np.linalg.norm(poses[:, :3] - true, axis=1))


def joint(twin: Twin, found: Calibration) -> tuple[bool, float]:
    """Return whether the true exit points are in the joint 95 % ellipsoid, and the errors over sigma, rms.

    Directions that the data leave open and the datum holds have no error.
    """
    k = len(twin.exits)
    sizes, ways = np.linalg.eigh(found.covariance[:k, :k])
    kept = sizes > 1e-9 * sizes.max()
    off = ways[:, kept].T @ (found.values[:k] - twin.exits)
    square = float(np.sum(off**2 / sizes[kept]))
    ratio = (ways[:, kept] @ off) / found.sigma[:k]
    return square < found.joint_limit(int(kept.sum())), float(np.sqrt(np.mean(ratio**2)))


KINDS = {
    each.__name__: each
    for each in (spools, belts, suspended, suspended8, outside_spools, outside_belts, outside_suspended)
}


def main(count: int, seed: int, kinds: str) -> None:
    """Print a line for each machine, and what all say."""
    for name in kinds.split(","):
        rows = []
        for each in range(seed, seed + count):
            twin = KINDS[name](each)
            given = {"rough": 0.05, "need": 5e-3, "cable": twin.law}
            found = calibrate(twin.file, twin.measured, twin.plan, models="auto", **given)
            oracle = calibrate(twin.oracle_file or twin.file, twin.oracle, twin.oracle_plan, **given)
            if found.status != "ok" or oracle.status != "ok":
                print(f"{name} {each}: {found.status} {found.reason}; oracle {oracle.status}", flush=True)
                continue
            own, best = (
                float(np.sqrt(np.mean(errors(twin, one, counts) ** 2)))
                for one, counts in ((found, twin.counts), (oracle, twin.oracle_counts))
            )
            inside, ratio = joint(twin, found)
            start = float(np.linalg.norm(found.poses[0, :3] - twin.start))
            chosen = ", ".join(one.name for one in found.effects if one.chosen)
            seen = [each.sigma for each in found.scores if each.words == f"sheave radius of {twin.file.lines[0].name}"]
            best_test = special.ndtr(RADIUS / seen[0] + special.ndtri(0.02)) if seen else np.nan
            asked = any("the data ask for" in each or "pays out" in each for each in found.reasons)
            rows.append(
                (own, best, inside, ratio, start, joint(twin, oracle)[0], found.verdict == "good", asked, best_test)
            )
            print(
                f"{name} {each}: held out {1e3 * own:.2f} mm, oracle {1e3 * best:.2f} mm, first pose "
                f"{1e3 * start:.2f} mm, seen over printed {ratio:.2f}, {'in' if inside else 'OUT'}, {found.verdict}, "
                f"{chosen or '-'}{', asks for a number of a line' if asked else ''}",
                flush=True,
            )
        own, best, inside, ratio, start, of_oracle, good, asked, power = np.array(rows, dtype=float).T
        shown = power[np.isfinite(power)]
        most = "; the best test of the first sheave, with 2 % false alarms, shows"
        said = f"{most} {100 * shown.mean():.0f} %" if len(shown) else ""
        print(
            f"{name}, {len(rows)} of {count} machines: held out over oracle, rms "
            f"{np.sqrt(np.mean(own**2) / np.mean(best**2)):.2f}, median {np.median(own / best):.2f}; first pose, "
            f"median {1e3 * np.median(start):.2f} mm; joint coverage of 95 % {100 * inside.mean():.1f} % (oracle "
            f"{100 * of_oracle.mean():.1f} %); seen over printed, rms {np.sqrt(np.mean(ratio**2)):.2f}, median "
            f"{np.median(ratio):.2f}; good {100 * good.mean():.0f} %, asks for a number of a line "
            f"{100 * asked.mean():.0f} %{said}",
            flush=True,
        )


if __name__ == "__main__":
    given = [*sys.argv[1:], *["20", "0", ",".join(KINDS)][len(sys.argv) - 1 :]]
    main(int(given[0]), int(given[1]), given[2])
