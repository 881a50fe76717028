"""The expected error of a job: Monte Carlo of the same statistic, solved, is the oracle."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.analyses.accuracy import expected_error as module
from cablewright.analyses.accuracy.expected_error import REMEDIES, ExpectedError, ExpectedErrorSearch
from cablewright.analyses.accuracy.spread import SpreadProblem, drawn, sampled
from cablewright.models.job_poses import along
from cablewright.models.statics import Equilibrium, Model
from cablewright.printing.job import Job
from cablewright.robot import Robot, load
from cablewright.robot.parameters import nominal, parameters_of, with_value
from cablewright.robot.uncertainty import Range, Uncertain, Uncertainty, assumed_uncertainty
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise
from cases import often, some

ROBOTS = {"house-printer": (3.0, 1.0), "merlet2023": (1.0, 1.0), "jung2020": (0.2, 0.9), "wang2021": (0.3, 1.0)}
SLACK = {"hangprinter-v4": (0.25, 0.3), "hangprinter-v4 low": (0.3, 0.05)}
"""Robots of which drawn machines go slack."""


def walked(name: str, ranges: tuple[Range, ...] | None = None, step: float = 0.02) -> tuple[Equilibrium, ExpectedError]:
    """A turn of a helix on a robot of the library: its poses, held, and the expected error."""
    robot = load(name.split()[0])
    radius, height = (ROBOTS | SLACK)[name]
    helix = {"radius": radius, "layers": 1, "layer_height": 0.05, "first_height": height}
    job = Job.model_validate({"name": "turn", "helix": helix, "sampling": {"step": step}})
    samples = job.samples(job.toolpath())
    poses, _ = along(robot, job, samples)
    held = solve_inverse(Model.full(robot), poses, path=True)
    assert held.ok.all()
    search = ExpectedErrorSearch(assumed_uncertainty(robot).of(robot) if ranges is None else ranges, samples, 0)
    for first in range(0, len(poses), 100):
        some = np.arange(first, min(first + 100, len(poses)))
        search.take(some, held[some], linearise(held[some]))
    return held, search.result()


def solved(held: Equilibrium, ranges: tuple[Range, ...], draws: int = 1000, every: int = 16) -> np.ndarray:
    """Errors (N, S, 3), m, of the nozzle at some rows of drawn machines, by solving each of them."""
    some = held[::every]
    points, _, ok = sampled(SpreadProblem(some, some.lengths, some.pose, ranges), drawn(ranges, draws, 77))
    assert ok.all()
    return points - some.nozzle[:, None]


def percentile(errors: np.ndarray) -> float:
    """The 95th percentile over machines of the largest error along the job."""
    return float(np.quantile(np.linalg.norm(errors, axis=2).max(axis=0), 0.95))


@pytest.mark.parametrize("name", some(ROBOTS, fast=2))
def test_monte_carlo_with_the_same_biases_along_the_job_agrees(name: str) -> None:
    held, found = walked(name)
    assert found.value == pytest.approx(percentile(solved(held, found.ranges, often(600, 1000))), rel=0.1)
    assert abs(found.curvature) < 0.1
    assert found.unsolved == 0


@pytest.mark.parametrize("name", SLACK)
def test_monte_carlo_along_all_of_the_path_agrees_where_machines_go_slack(name: str) -> None:
    held, found = walked(name)
    assert found.curvature > 0.1  # first order is no guide here
    assert found.value == pytest.approx(percentile(solved(held, found.ranges, every=6)), rel=0.1)


def test_an_error_that_many_machines_have_none_of_is_not_stated() -> None:
    wide = Uncertainty(parameters=(Uncertain(name="length_offset", plus_minus=2.5),))
    _, found = walked("merlet2023", wide.of(load("merlet2023")))
    assert np.isnan(found.value)
    assert found.sample is not None
    assert found.unsolved > 0.05 * module.DRAWS
    assert f"{found.unsolved} of {module.DRAWS} drawn machines have no sound equilibrium" in found.unknown
    assert found.notes == (f"expected error is not stated: {found.unknown}",)


def test_the_share_of_each_cause_is_that_of_its_variance() -> None:
    held, found = walked("house-printer")
    row = found.sample
    assert row is not None
    at = held[row : row + 1]
    alone = {}
    for name in {each.parameter.entry.base for each in found.ranges}:
        own = tuple(each for each in found.ranges if each.parameter.entry.base == name)
        alone[name] = float((solved(at, own, every=1) ** 2).sum(axis=2).mean())
    total = sum(alone.values())
    shares = {cause.name: cause.share for cause in found.causes}
    assert sum(shares.values()) == pytest.approx(1.0)
    for name, square in alone.items():
        assert shares[name] == pytest.approx(square / total, rel=0.1, abs=2e-3), name
    assert [cause.share for cause in found.causes] == sorted(shares.values(), reverse=True)


def test_without_one_cause_the_error_is_that_of_the_others() -> None:
    _, found = walked("merlet2023")
    for cause in found.causes:
        rest = tuple(each for each in found.ranges if each.parameter.entry.base != cause.name)
        if len(rest) < len(found.ranges):
            assert cause.without == pytest.approx(walked("merlet2023", rest)[1].value, rel=0.05)
        assert cause.without <= found.value * 1.01


def test_cells_do_not_hide_the_largest_error(monkeypatch: pytest.MonkeyPatch) -> None:
    few = walked("house-printer")[1].value
    monkeypatch.setattr(module, "CELLS", 60)
    assert few == pytest.approx(walked("house-printer")[1].value, rel=0.01)


def test_error_of_interpolated_lengths_is_that_of_the_search() -> None:
    """Midway between samples a metre apart, against the equilibrium of the mean of their lengths."""
    none = Uncertainty(parameters=(Uncertain(name="mass", plus_minus=1e-9),))
    robot = load("house-printer")
    ranges = none.of(robot)
    job = Job.model_validate(
        {
            "name": "turn",
            "helix": {"radius": 5.0, "layers": 1, "layer_height": 0.05, "first_height": 1.0},
            "sampling": {"step": 1.0},
        }
    )
    path = job.toolpath()
    every = job.samples(path)
    keep = slice(None, None, 80)  # chords of about 1.6 m
    thin = {name: getattr(every, name)[keep] for name in every.__dataclass_fields__}
    samples = type(every)(**thin)
    held = solve_inverse(Model.full(robot), samples.positions, path=True)
    search = ExpectedErrorSearch(ranges, samples, 0)
    search.take(np.arange(len(samples)), held, linearise(held))
    found = search.result()
    mean = 0.5 * (held.lengths[1:] + held.lengths[:-1])
    middle = 0.5 * (samples.positions[1:] + samples.positions[:-1])
    reached = solve_forward(Model.full(robot), mean, guess=middle)
    off = np.linalg.norm(reached.pose - middle, axis=1)
    assert found.rms[1:] == pytest.approx(off, rel=0.15)
    assert found.causes[0].name == "interpolation"
    assert found.causes[0].share == pytest.approx(1.0)


def test_the_seed_decides_and_changes_little() -> None:
    robot = load("merlet2023")
    job = Job.model_validate(
        {"name": "turn", "helix": {"radius": 1.0, "layers": 1, "layer_height": 0.05, "first_height": 1.0}}
    )
    samples = job.samples(job.toolpath())
    held = solve_inverse(Model.full(robot), samples.positions, path=True)
    linear, values = linearise(held), []
    for seed in (0, 0, 1):
        search = ExpectedErrorSearch(assumed_uncertainty(robot).of(robot), samples, seed)
        search.take(np.arange(len(samples)), held, linear)
        values.append(search.result().value)
    assert values[0] == values[1] != values[2]
    assert values[0] == pytest.approx(values[2], rel=0.05)


def test_nothing_known_is_nothing_said() -> None:
    robot: Robot = load("merlet2023")
    job = Job.model_validate(
        {"name": "turn", "helix": {"radius": 1.0, "layers": 1, "layer_height": 0.05, "first_height": 1.0}}
    )
    found = ExpectedErrorSearch(assumed_uncertainty(robot).of(robot), job.samples(job.toolpath()), 0).result()
    assert np.isnan(found.value)
    assert (found.sample, found.causes, found.notes) == (None, (), ())


def test_every_number_that_may_be_uncertain_has_a_remedy() -> None:
    from cablewright.robot.uncertainty import _KINDS

    assert {kinds[0].base for kinds in _KINDS.values()} == set(REMEDIES) - {module.INTERPOLATION}


@pytest.mark.parametrize("name", ["house-printer", "jung2020"])
def test_tension_errors_of_drawn_machines_are_as_expected(name: str) -> None:
    robot = load(name)
    kinds = ("exit_point.x", "exit_point.y", "exit_point.z")
    ranges = tuple(
        Range(each, at := nominal(robot, each), at - 2e-4, at + 2e-4)
        for kind in kinds
        for each in parameters_of(robot, kind)
    )
    held, found = walked(name, ranges, step=1.0)
    assert found.tensions.shape == (robot.m, 2)
    random, rows = np.random.default_rng(1), []
    for _ in range(80):
        drawn_robot = robot
        for each in ranges:
            drawn_robot = with_value(drawn_robot, each.parameter, random.uniform(each.low, each.high))
        there = solve_forward(Model.full(drawn_robot), held.lengths, guess=held.pose)
        assert there.ok.all()
        rows.append(there.tensions - held.tensions)
    off = 1.96 * np.std(rows, axis=0)
    low, high = (held.tensions - off).min(axis=0), (held.tensions + off).max(axis=0)
    nominal_low, nominal_high = held.tensions.min(axis=0), held.tensions.max(axis=0)
    np.testing.assert_allclose(nominal_low - found.tensions[:, 0], nominal_low - low, rtol=0.35, atol=0.05)
    np.testing.assert_allclose(found.tensions[:, 1] - nominal_high, high - nominal_high, rtol=0.35, atol=0.05)
