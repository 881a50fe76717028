"""Robots whose file has compliant mounts, springs and creep: counted by equilibria or measured tensions, or
rejected."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from scipy import special

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.drift.drift import check_drift
from cablewright.calibration.drift.record import load_record, record_of, record_text
from cablewright.calibration.guidance.guided_calibration import guide
from cablewright.calibration.guidance.pose_selection import calibration_poses
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measurements import Measured, write_measured
from cablewright.calibration.plan import CalibrationPlan, Sigmas
from cablewright.calibration.poses.elastic import ElasticProblem
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import SensorNoise, random_poses, simulate_calibration
from cablewright.foundation.errors import InputError
from cablewright.kernels.plant import dynamics
from cablewright.kernels.statics.equilibrium import evaluate
from cablewright.machine.simulated.unmodelled.exit_mounts import ExitMountState
from cablewright.models.fidelity import Fidelity
from cablewright.models.packed_views import LineStates
from cablewright.models.statics import Model
from cablewright.robot import Robot, file_text, load, loads, update
from cablewright.robot.mount import compliance_matrix
from cablewright.solvers.inverse import solve_inverse
from cases import some

PLAN = CalibrationPlan(sigma=Sigmas(encoder=1e-4, tension=2.0))
WITH_MOUNTS = PLAN.model_copy(update={"unknowns": (*PLAN.unknowns, "exit_compliance")})
CELLS = SensorNoise(tension=2.0)


def on_mounts(robot: Robot, rng: np.random.Generator, kinds: str = "number") -> Robot:
    """The robot on mounts of 1 to 5 um/N: by a number, by a matrix of different directions, or every other one so."""
    lines = []
    for at, line in enumerate(robot.lines):
        compliance: object = float(rng.uniform(1e-6, 5e-6))
        if kinds == "matrix" or (kinds == "mixed" and at % 2):
            turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
            matrix = turn @ np.diag(rng.uniform(0.5e-6, 6e-6, 3)) @ turn.T
            compliance = tuple(map(tuple, (0.5 * (matrix + matrix.T)).tolist()))
        lines.append(line.model_copy(update={"exit_compliance": compliance}))
    return Robot.model_validate(robot.model_copy(update={"lines": tuple(lines)}).model_dump())


def with_springs(robot: Robot, rate: float) -> Robot:
    lines = tuple(line.model_copy(update={"spring": rate}) for line in robot.lines)
    return robot.model_copy(update={"lines": lines})


def on_stiff_ends(robot: Robot) -> Robot:
    lines = tuple(line.model_copy(update={"exit_compliance": None, "spring": None}) for line in robot.lines)
    return robot.model_copy(update={"lines": lines})


def plant(robot: Robot, cable: str, count: int, rng: np.random.Generator) -> Measured:
    """What a machine on such mounts measures by the simulated machine's own law, which moves exit points until they
    rest."""
    model = Model(on_stiff_ends(robot), Fidelity.of(cable))
    held = solve_inverse(model, random_poses(model, count, rng)).checked()
    work, _ = dynamics.moving_workspace(model.packed)
    soft = np.array([compliance_matrix(line.exit_compliance or 0.0) for line in robot.lines])
    places, tensions = held.pose.copy(), held.tensions.copy()
    for k in range(count):
        packed = model.packed._replace(lines=model.packed.lines.copy(), platform=model.packed.platform.copy())
        states, lengths = held.states[k].copy(), held.lengths[k].copy()
        evaluate(packed, lengths, places[k], states, work)  # for the lines' planes
        mounts = ExitMountState(soft)
        assert mounts.close(packed, np.arange(robot.m), lengths, places[k], states, np.ones(robot.m), work) == 0
        tensions[k] = LineStates(states).tension
    return Measured(held.lengths - held.lengths[0], places, tensions=tensions)


def displaced(robot: Robot, count: int, rng: np.random.Generator) -> tuple[Measured, np.ndarray]:
    """What rigid lines measure whose exit points are where their tensions displace them, and the lengths at home.

    Springs pay out by their tension over their rate.
    """
    model = Model(on_stiff_ends(robot), Fidelity.of("rigid"))
    poses = random_poses(model, count, rng)
    held = solve_inverse(model, poses).checked()
    soft = np.array([compliance_matrix(line.exit_compliance or 0.0) for line in robot.lines])
    file = np.array([line.exit_point for line in robot.lines])
    points, exits = held.platform_points, np.broadcast_to(file, held.platform_points.shape)
    for _ in range(20):  # along the straight line from the exit as it is then
        away = points - exits
        force = held.tensions[..., None] * away / np.linalg.norm(away, axis=2)[..., None]
        exits = file + np.einsum("mij,nmj->nmi", soft, force)
    lengths = solve_inverse(model, poses, exit_points=np.ascontiguousarray(exits)).lengths
    lengths = lengths - held.tensions * [0.0 if line.spring is None else 1.0 / line.spring for line in robot.lines]
    return Measured(lengths - lengths[0], poses, tensions=held.tensions), lengths[0]


def noisy(clean: Measured, rng: np.random.Generator) -> Measured:
    assert clean.guess is not None
    assert clean.tensions is not None
    return Measured(
        clean.counted + rng.normal(0.0, 1e-4, clean.counted.shape),
        clean.guess + rng.uniform(-0.02, 0.02, clean.guess.shape),
        tensions=clean.tensions + rng.normal(0.0, 2.0, clean.tensions.shape),
    )


def exits_moved(found: Calibration) -> float:
    """How far the exit points are from the file's, m: at most, in any coordinate."""
    return float(np.abs(found.changes[[each.name == "exit_point" for each in found.unknowns]]).max())


@pytest.mark.parametrize("kinds", some(["mixed", "number", "matrix"]))
@pytest.mark.parametrize(("name", "cable"), [("merlet2023", "catenary"), ("cogiro", "elastic")])
def test_mounts_of_the_file_leave_no_error_in_exit_points(name: str, cable: str, kinds: str) -> None:
    """By the plant's law as the oracle; the same without the key has errors of some mm."""
    robot = on_mounts(load(name), np.random.default_rng(11), kinds)
    clean = plant(robot, cable, 20, np.random.default_rng(12))
    found = calibrate(robot, clean, PLAN, cable=cable, rough=0.05, outliers=False)
    assert found.status == "ok"
    assert exits_moved(found) < 2e-5
    assert found.rms < 1e-6
    without = calibrate(on_stiff_ends(robot), clean, PLAN, cable=cable, rough=0.05, outliers=False)
    assert exits_moved(without) > 1e-3


def test_springs_of_the_file_leave_no_error_in_exit_points() -> None:
    """A line pays out less by its tension over the rate, up to the strain of that, as its page says."""
    robot = load("merlet2023")
    rate = 1e5
    model = Model(robot, Fidelity.of("catenary"))
    held = solve_inverse(model, random_poses(model, 20, np.random.default_rng(3))).checked()
    lengths = held.lengths - held.tensions / rate
    clean = Measured(lengths - lengths[0], held.pose, tensions=held.tensions)
    found = calibrate(with_springs(robot, rate), clean, PLAN, cable="catenary", rough=0.05, outliers=False)
    without = calibrate(robot, clean, PLAN, cable="catenary", rough=0.05, outliers=False)
    assert exits_moved(found) < 2e-3 * exits_moved(without)
    assert exits_moved(without) > 1e-3


SOFT: dict[str, Callable[[Robot], Robot]] = {
    "mounts": lambda robot: on_mounts(robot, np.random.default_rng(11), "mixed"),
    "springs": lambda robot: with_springs(robot, 1e5),
    "both": lambda robot: with_springs(on_mounts(robot, np.random.default_rng(11), "matrix"), 1e5),
}


@pytest.mark.parametrize(
    ("name", "soft"),
    [pytest.param("wang2021", each, id=each, marks=[pytest.mark.slow] * (each != "both")) for each in SOFT]
    + [pytest.param("jung2020", "both", marks=pytest.mark.slow)],
)
def test_straight_lines_count_them_by_measured_tensions(name: str, soft: str) -> None:
    """Up to second order in their deflection, which for sheaves, whose cable leaves beside its exit, is a tenth."""
    robot = SOFT[soft](load(name))
    clean, _ = displaced(robot, 40, np.random.default_rng(12))
    found = calibrate(robot, clean, PLAN, rough=0.05, outliers=False)
    without = calibrate(on_stiff_ends(robot), clean, PLAN, rough=0.05, outliers=False)
    assert found.rms < 0.1 * without.rms
    assert exits_moved(found) < 0.2 * exits_moved(without)


@pytest.mark.parametrize("kinds", ["number", "mixed"])
def test_derivatives_are_those_of_differences(kinds: str) -> None:
    """Of straight lines over sheaves and of catenaries, mounts that are unknown among them, springs too."""
    for name, cable in (("wang2021", "rigid"), ("merlet2023", "catenary"), ("cogiro", "elastic")):
        rng = np.random.default_rng(5)
        robot = with_springs(on_mounts(load(name), rng, kinds), 2e5)
        model = Model(robot, Fidelity.of(cable))
        held = solve_inverse(model, random_poses(model, 3, rng)).checked()
        measured = Measured(np.zeros((3, robot.m)), held.pose, tensions=held.tensions)
        plan = WITH_MOUNTS.model_copy(update={"unknowns": (*WITH_MOUNTS.unknowns, "sheave_radius")})
        plan = plan if name == "wang2021" else WITH_MOUNTS
        problem = (
            StraightProblem.of(robot, measured, plan) if cable == "rigid" else ElasticProblem.of(model, measured, plan)
        )
        elastic = isinstance(problem, ElasticProblem)
        theta, states = problem.free.copy(), problem.states_of(held) if elastic else held.pose  # type: ignore[attr-defined]
        here = problem.derivatives(theta, states)
        for at, each in enumerate(problem.free_unknowns):
            step = 1e-5 if each.name == "exit_compliance" else 1e-6
            ends = []
            for sign in (1.0, -1.0):
                moved = theta.copy()
                moved[at] += sign * step
                ends.append(problem.derivatives(moved, states).residual)
            slope = (ends[0] - ends[1]) / (2.0 * step)
            scale = np.abs(here.by_unknown[..., at]).max()
            assert here.by_unknown[..., at] == pytest.approx(slope, abs=2e-5 * scale), each.label


def chi_squared(found: Calibration, truth: dict[str, np.ndarray]) -> tuple[float, int]:
    """The square of the error over its covariance by noise, and its degrees of freedom: those that the data do not
    leave open."""
    left = {name: list(values) for name, values in truth.items()}
    off = np.array([value - left[each.name].pop(0) for each, value in zip(found.unknowns, found.values, strict=True)])
    sizes = np.array([each.size for each in found.unknowns])
    values, vectors = np.linalg.eigh(found.posterior.covariance)
    kept = values > 1e-9 * values.max()
    return float(np.sum((vectors[:, kept].T @ (off / sizes)) ** 2 / values[kept])), int(kept.sum())


def truth_of(robot: Robot, home: np.ndarray) -> dict[str, np.ndarray]:
    exits = np.array([line.exit_point for line in robot.lines])
    soft = [line.exit_compliance for line in robot.lines if isinstance(line.exit_compliance, float)]
    return {"exit_point": exits.ravel(), "length_offset": home, "exit_compliance": np.array(soft)}


@pytest.mark.parametrize("draws", [5, pytest.param(40, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("name", "cable", "kinds", "plan"),
    [
        pytest.param("wang2021", "rigid", "mixed", PLAN, id="straight"),
        pytest.param("wang2021", "rigid", "number", WITH_MOUNTS, id="straight, unknown", marks=pytest.mark.slow),
        pytest.param("merlet2023", "catenary", "mixed", PLAN, id="catenary", marks=pytest.mark.slow),
        pytest.param("merlet2023", "catenary", "number", WITH_MOUNTS, id="catenary, unknown"),
    ],
)
def test_errors_are_those_of_the_sigmas(name: str, cable: str, kinds: str, plan: CalibrationPlan, draws: int) -> None:
    """On as many machines, each with mounts of its own: by noise alone, in all directions that data do not leave open.

    Load cells of straight lines are good ones: with noise of 2 N at 10 N, stiff mounts have errors over sigma too.
    """
    noise = 0.5 if cable == "rigid" else 2.0
    told = plan.model_copy(update={"sigma": Sigmas(encoder=1e-4, tension=noise)})
    total, freedoms, inside = 0.0, 0, 0
    for seed in range(7000, 7000 + draws):
        robot = on_mounts(load(name), np.random.default_rng(seed), kinds)
        sensors = SensorNoise(tension=noise)
        made = simulate_calibration(robot, 30, 1e-4, seed=seed, cable=cable, sensors=sensors, guess=0.02)
        found = calibrate(robot, made.measured, told, cable=cable, rough=0.02, outliers=False)
        size, number = chi_squared(found, truth_of(robot, made.home_lengths))
        number -= kinds == "mixed"  # the yaw, which is kept as in the file
        total, freedoms = total + size, freedoms + number
        inside += size < special.chdtri(number, 0.05)
    assert special.chdtrc(freedoms, total) > 1e-3
    assert special.chdtr(freedoms, total) > 1e-3
    assert special.bdtr(inside, draws, 0.95) > 1e-3


def test_straight_lines_without_tensions_are_rejected(tmp_path: Path) -> None:
    robot = on_mounts(load("wang2021"), np.random.default_rng(1))
    bare = simulate_calibration(robot, 40, 1e-4, seed=1).measured
    message = "no column f_1: line 'south-west' has {}, and straight lines need measured tensions for"
    with pytest.raises(InputError, match=message.format("exit_compliance")):
        calibrate(robot, bare, PLAN)
    with pytest.raises(InputError, match=message.format("exit_compliance")):
        guide(robot, replace(bare, counted=bare.counted[:3], guess=None), PLAN)
    with pytest.raises(InputError, match=message.format("spring")):
        calibrate(with_springs(load("wang2021"), 1e5), bare, PLAN)
    made = simulate_calibration(robot, 40, 1e-4, seed=1, sensors=CELLS).measured
    file = tmp_path / "d.csv"
    file.write_text(write_measured(made, robot), encoding="utf-8")
    found = calibrate(robot, file, PLAN, rough=0.05, need=0.1)
    record = tmp_path / "r.toml"
    record.write_text(record_text(record_of(found, file, datetime(2026, 3, 1, tzinfo=UTC))), encoding="utf-8")
    assert check_drift(found.robot, made, load_record(record)).verdict == "unchanged"
    with pytest.raises(InputError, match=message.format("exit_compliance")):
        check_drift(found.robot, replace(made, tensions=None), record)


@pytest.mark.parametrize("cable", ["rigid", "catenary"])
def test_a_swivel_that_goes_aside_is_no_azimuth(cable: str) -> None:
    robot = on_mounts(load("wang2021"), np.random.default_rng(1), "matrix")
    with pytest.raises(
        InputError, match="swivel_1: line 'south-west' has a compliant mount with a matrix, which turns"
    ):
        simulate_calibration(robot, 20, 1e-4, cable=cable, sensors=SensorNoise(tension=2.0, swivel=1e-3))


def test_counts_to_move_to_are_those_of_the_mounts() -> None:
    """Of chosen poses, and of those of `--guide`, there within the scatter of the robots that it may be."""
    robot = on_mounts(load("wang2021"), np.random.default_rng(1))
    chosen = calibration_poses(robot, 16, candidates=100)
    model = Model(on_stiff_ends(robot), Fidelity.of("rigid"))
    held = solve_inverse(model, chosen.poses).checked()
    stiff = held.lengths - held.lengths[0]
    soft = np.array([line.exit_compliance for line in robot.lines])
    given = held.tensions * soft
    assert chosen.counted - stiff == pytest.approx(given[0] - given, abs=1e-9)
    told = guide(robot, None, PLAN, rough=0.01).to_measure
    assert told.guess is not None
    held = solve_inverse(model, told.guess).checked()
    given = held.tensions * soft
    assert told.counted - (held.lengths - held.lengths[0]) == pytest.approx(given[0] - given, abs=0.1 * np.ptp(given))


def test_a_compliance_of_the_file_that_is_wrong_is_in_the_sigmas() -> None:
    """Its prior is a fifth, and the larger sigmas contain errors of a file of that size."""
    robot = on_mounts(load("merlet2023"), np.random.default_rng(4))
    lines = tuple(line.model_copy(update={"exit_compliance": 1.2 * line.exit_compliance}) for line in robot.lines)  # type: ignore[operator]
    made = simulate_calibration(robot, 40, 1e-4, seed=4, cable="catenary", sensors=CELLS)
    told = calibrate(robot.model_copy(update={"lines": lines}), made.measured, PLAN, cable="catenary", rough=0.05)
    off = told.changes[[each.name == "exit_point" for each in told.unknowns]]
    sigma = told.sigma[[each.name == "exit_point" for each in told.unknowns]]
    assert np.abs(off / sigma).max() < 4.0
    considered = {each.line: each for each in told.doubt.considered if each.name == "exit_compliance"}
    assert set(considered) == {line.name for line in robot.lines}
    for line in robot.lines:
        assert considered[line.name].unit == "m/N"
        assert considered[line.name].sigma <= 0.2 * 1.2 * float(line.exit_compliance or 0.0)  # type: ignore[arg-type]
    assert np.all(told.sigma >= 0.999 * told.noise_sigma)


def test_found_values_are_written_to_the_file() -> None:
    """Beside values of the file that stay, and mounts that a file does not have are added to it."""
    robot = load("merlet2023")
    soft = on_mounts(robot, np.random.default_rng(4))
    made = simulate_calibration(soft, 40, 1e-4, seed=4, cable="catenary", sensors=CELLS)
    found = calibrate(robot, made.measured, WITH_MOUNTS, cable="catenary", rough=0.05, need=1.0)
    assert found.verdict != "bad"
    values = found.values[[each.name == "exit_compliance" for each in found.unknowns]]
    written = loads(update(file_text("merlet2023"), found.robot), "written")
    assert [line.exit_compliance for line in written.lines] == pytest.approx(values.tolist(), abs=1e-12)
    again = calibrate(written, made.measured, PLAN, cable="catenary", rough=0.05, need=1.0)
    assert again.rms == pytest.approx(found.rms, rel=0.1)


def test_mounts_that_are_stiff_after_all_are_an_answer() -> None:
    """At 0, whatever the file has."""
    robot = load("merlet2023")
    made = simulate_calibration(robot, 40, 1e-4, seed=4, cable="catenary", sensors=CELLS)
    soft = on_mounts(robot, np.random.default_rng(4))
    found = calibrate(soft, made.measured, WITH_MOUNTS, cable="catenary", rough=0.05, need=1.0)
    which = [each.name == "exit_compliance" for each in found.unknowns]
    assert found.status == "ok"
    assert (found.values[which] < 4.0 * found.noise_sigma[which]).all()
    assert (found.values[which] == 0.0).any()


@pytest.mark.parametrize("cable", ["rigid", "catenary"])
def test_creep_of_the_file_is_named_and_in_the_sigmas(cable: str) -> None:
    """It would make the most loaded line longer by tension, length and compliance."""
    plain = load("merlet2023" if cable == "catenary" else "wang2021")
    creep = {"retardations": (60.0,), "compliances": (2e-7,), "logarithmic": 1e-7}
    lines = [line.model_dump() | {"cable": line.cable.model_dump() | {"creep": creep}} for line in plain.lines]
    robot = Robot.model_validate(plain.model_dump() | {"lines": lines})
    made = simulate_calibration(plain, 40, 1e-4, seed=4, cable=cable, sensors=CELLS)
    found, without = (
        calibrate(each, made.measured, PLAN, cable=cable, rough=0.05, need=1.0) for each in (robot, plain)
    )
    tensions = found.problem.known_tensions(found.fit.theta, found.fit.poses)
    assert tensions is not None
    longer = 3e-7 * tensions * found.problem.lengths(found.fit.theta, found.fit.poses)
    note = next(note for note in found.notes if "creep" in note)
    assert f"longer by up to {1e3 * longer.max():.3g} mm" in note
    assert plain.lines[int(np.argmax(longer.max(axis=0)))].name in note
    assert not any("creep" in note for note in without.notes)
    assert np.all(found.model_sigma >= without.model_sigma * 0.999)
    name = "modulus" if cable == "catenary" else "stretch"  # which the data determine, but as badly as before
    wider, known = (next(its for its in each.doubt.considered if its.name == name) for each in (found, without))
    assert wider.sigma > known.sigma
