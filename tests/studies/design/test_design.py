"""Designs: figures against their analyses, optimisers against known optima, constraints, rejections and resumption."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cablewright.analyses.modes import modes
from cablewright.foundation.errors import AnswerError, EnvironmentFault, InputError, UnknownName
from cablewright.printing.job import Job
from cablewright.robot import load
from cablewright.robot.files import loads
from cablewright.running.executors.processes import Processes
from cablewright.solvers.hardware_limits import winch_torques
from cablewright.studies.checks.check import check
from cablewright.studies.design.measures import MEASURES, Prices, measured
from cablewright.studies.design.optimisers import BAD, OPTIMISERS, Budget, scores
from cablewright.studies.design.problem import DesignConstraint, DesignProblem, Variable, places_of
from cablewright.studies.design.search import design
from cablewright.studies.trade import TradeSettings, trade

HOUSE, BEAM = load("house-printer"), load("jung2020")
JOB = Job.model_validate({
    "name": "ring", "helix": {"radius": 3.0, "layers": 1, "layer_height": 0.02, "first_height": 1.0},
})  # fmt: skip
HEIGHT = (Variable.read("exit_point.z=8:15"),)
NODES = TradeSettings("closed-form", count="nodes", grid=5, boundary_grid=5)


def test_figures_of_the_part_are_those_of_check_and_modes() -> None:
    found = check(HOUSE, JOB)
    samples = found.samples
    what = DesignProblem(
        HOUSE, HEIGHT, ("expected_error",), job=JOB, places=tuple(map(tuple, samples.positions.tolist()))
    )
    keys = ("expected_error", "min_tension", "max_tension", "tension_margin", "lowest_frequency", "cable_length")
    figures = measured(what.candidate(()), keys)
    lines = found.statics.lines
    assert found.expected is not None
    assert figures["expected_error"] == pytest.approx(found.expected.value, rel=0.1)  # of 500 drawn machines, not 4000
    at_rest = found.statics.tensions  # at the sheaves, which differ by the weight of a cable; check has motion too
    assert figures["min_tension"] == pytest.approx(np.nanmin(at_rest), rel=0.1)
    assert figures["max_tension"] == pytest.approx(np.nanmax(at_rest), rel=0.1)
    assert np.nanmin(lines.lowest_tension) < figures["min_tension"]
    assert np.nanmax(lines.highest_tension) > figures["max_tension"]
    assert figures["tension_margin"] == pytest.approx(figures["min_tension"] - 20.0)
    assert figures["lowest_frequency"] == pytest.approx(np.nanmin(modes(HOUSE, samples.positions).lowest))
    assert figures["cable_length"] == pytest.approx(found.lengths.max(axis=0).sum(), rel=1e-9)


def test_the_cost_is_that_of_cable_winches_and_torques() -> None:
    places = ((0.0, 0.0, 0.5), (3.0, 2.0, 1.0))
    prices = Prices(2.0, 100.0, 5.0)
    what = DesignProblem(HOUSE, HEIGHT, ("cost",), job=JOB, places=places, prices=prices)
    held = what.candidate(()).held
    torques = winch_torques(held).max(axis=0)
    cost = 2.0 * held.lengths.max(axis=0).sum() + 100.0 * HOUSE.m + 5.0 * torques.sum()
    assert measured(what.candidate(()), ("cost",))["cost"] == pytest.approx(cost)
    dear = design(HOUSE, JOB, HEIGHT, ["cost"], prices={"cable": 1.0}, evaluations=10, population=5)
    length = design(HOUSE, JOB, HEIGHT, ["cable_length"], evaluations=10, population=5)
    assert dear.chosen[0].values == length.chosen[0].values


def test_prices_that_are_missing_or_make_no_sense_are_rejected() -> None:
    with pytest.raises(InputError, match="cost: needs at least one price"):
        design(HOUSE, JOB, HEIGHT, ["cost"])
    with pytest.raises(UnknownName, match=r"price 'cables'.*did you mean 'cable'"):
        design(HOUSE, JOB, HEIGHT, ["cost"], prices={"cables": 1.0})
    with pytest.raises(InputError, match="price of winch = -1: must be"):
        design(HOUSE, JOB, HEIGHT, ["cost"], prices={"winch": -1.0})


def test_places_represent_the_whole_path() -> None:
    samples = check(HOUSE, JOB).samples
    places = np.array(places_of(samples))
    assert len(places) < 0.4 * len(samples)
    np.testing.assert_array_equal(places.min(axis=0)[:2].round(1), [-3.0, -3.0])
    assert (np.ptp(samples.positions[samples.extruding], axis=0) == np.ptp(places, axis=0)).all()


def test_figures_of_the_workspace_are_those_of_trade() -> None:
    what = DesignProblem(
        BEAM, (Variable.read("exit-distance=0.05:0.3"),), ("volume", "boundary_frequency"), workspace=NODES
    )
    found = measured(what.candidate((0.2,)), (*what.keys, "exit_distance"))
    (own,) = trade(BEAM, {"exit-distance": [0.2]}, NODES).combinations
    assert found == {"volume": own.volume, "boundary_frequency": own.least, "exit_distance": own.exit_distance}


@pytest.mark.parametrize("name", sorted(OPTIMISERS))
def test_optimisers_find_a_known_optimum_within_a_constraint_and_repeat_themselves(name: str) -> None:
    """The nearest point to (0.8, 0.8) with x + y <= 1 is (0.5, 0.5)."""
    if name != "de":
        pytest.importorskip({"cma-es": "cma", "nsga2": "pymoo"}[name], reason="needs the extra design")
    asked = [list[np.ndarray](), list[np.ndarray]()]
    for rows in asked:

        def batch(values: np.ndarray, rows: list[np.ndarray] = rows) -> tuple[np.ndarray, np.ndarray]:
            rows.append(values.copy())
            return ((values - 0.8) ** 2).sum(axis=1)[:, None], np.maximum(0.0, values.sum(axis=1) - 1.0)

        OPTIMISERS[name](batch, 2, 1, Budget(800, 20, 3))
    whole = np.concatenate(asked[0])
    assert len(whole) == 800
    assert ((whole >= 0.0) & (whole <= 1.0)).all()
    allowed = whole[whole.sum(axis=1) <= 1.0]
    best = allowed[((allowed - 0.8) ** 2).sum(axis=1).argmin()]
    np.testing.assert_allclose(best, 0.5, atol=0.02)
    np.testing.assert_array_equal(whole, np.concatenate(asked[1]))


def test_any_candidate_that_holds_is_better_than_one_that_does_not() -> None:
    found = scores(np.array([[1e9], [-5.0], [math.nan], [0.0]]), np.array([0.0, 0.1, 0.0, math.inf]))
    assert found[0] == 1e9
    assert BAD <= found[2] < found[1] < found[3] < math.inf


def test_a_search_beats_the_robot_resumes_and_is_the_same_in_processes(tmp_path: Path) -> None:
    asked = {"evaluations": 20, "population": 10, "seed": 1}
    file = tmp_path / "results.jsonl"
    found = design(HOUSE, JOB, HEIGHT, ["expected_error"], file=file, **asked)  # type: ignore[arg-type]
    assert found.status == "ok"
    best = found.chosen[0]
    assert best.figures["expected_error"] < found.original.figures["expected_error"]
    assert best.figures["expected_error"] == min(each.figures["expected_error"] for each in found.tried)
    half = b"".join(file.read_bytes().splitlines(keepends=True)[:8])
    file.write_bytes(half)
    executor = Processes(2)
    try:
        again = design(HOUSE, JOB, HEIGHT, ["expected_error"], file=file, executor=executor, **asked)  # type: ignore[arg-type]
    finally:
        executor.close()
    assert again.tried == found.tried
    robot = found.robot_of(best)
    assert robot.name == "house-printer-designed"
    assert {line.exit_point[2] for line in robot.lines} == {best.values[0]}


def test_a_front_has_no_candidate_that_another_beats() -> None:
    pytest.importorskip("pymoo", reason="needs the extra design")
    vary, finer = [Variable.read("exit-distance=0.05:0.4")], replace(NODES, grid=9, boundary_grid=9)
    found = design(BEAM, None, vary, ["volume", "boundary_frequency"], workspace=finer, evaluations=20, population=10)
    worth = np.array([found.what.worth(each.figures) for each in found.front])
    assert len(worth) > 1
    for row in worth:
        assert not ((worth <= row).all(axis=1) & (worth < row).any(axis=1)).any()
    for each in found.holding:
        assert (worth <= found.what.worth(each.figures)).all(axis=1).any()


def test_constraints_that_cannot_be_met_are_named_with_how_close_it_came() -> None:
    bounds = [DesignConstraint.read("expected_error<=0.001"), DesignConstraint.read("min_tension>=1")]
    found = design(HOUSE, JOB, HEIGHT, ["cable_length"], bounds, evaluations=10, population=5)
    assert found.status == "infeasible"
    assert "nearest misses expected_error <= 0.001 (it has 0.00" in found.refusal
    assert found.refusal.endswith("no candidate at all meets expected_error <= 0.001")
    assert found.chosen == ()


def test_constraints_that_exclude_each_other_are_reported_as_such() -> None:
    bounds = [DesignConstraint.read("frame_height<=9"), DesignConstraint.read("cable_length>=115")]
    found = design(HOUSE, JOB, HEIGHT, ["expected_error"], bounds, evaluations=10, population=10)
    assert found.refusal.endswith("each can be met, but not all together")


def test_an_objective_without_any_value_ends_the_search() -> None:
    with pytest.raises(AnswerError, match="objective expected_error: has no value for any of the first 5 candidates: "):
        design(HOUSE, JOB, [Variable.read("mass=90000:91000")], ["expected_error"], evaluations=10, population=5)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("exit_pont.z=1:2", "unknown parameter 'exit_pont.z'; did you mean 'exit_point.z'"),
        ("exits-x", "expected NAME=LOW:HIGH"),
        ("exits-x=2:1", "two finite numbers that rise"),
        ("exits-x=nan:1", "two finite numbers that rise"),
    ],
)
def test_variables_that_make_no_sense_are_rejected(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        Variable.read(text)


@pytest.mark.parametrize("text", ["volume", "volume>=x", "volume=1", "volume>=nan", "1<=volume"])
def test_constraints_that_make_no_sense_are_rejected(text: str) -> None:
    with pytest.raises(InputError, match=r"expected FIGURE>=VALUE or FIGURE<=VALUE"):
        DesignConstraint.read(text)


def test_contradictions_are_rejected_before_the_work() -> None:
    with pytest.raises(UnknownName, match="did you mean 'expected_error'"):
        design(HOUSE, JOB, HEIGHT, ["expected_eror"])
    with pytest.raises(InputError, match=r"min_tension >= 30 and min_tension <= 20 contradict"):
        design(
            HOUSE,
            JOB,
            HEIGHT,
            ["volume"],
            [DesignConstraint.read("min_tension>=30"), DesignConstraint.read("min_tension<=20")],
        )
    with pytest.raises(InputError, match="expected_error: can only be computed for a printed part; give a JOB"):
        design(HOUSE, None, HEIGHT, ["expected_error"])
    with pytest.raises(InputError, match="method de: is for one objective; nsga2 takes 2"):
        design(HOUSE, JOB, HEIGHT, ["expected_error", "min_tension"], method="de")
    with pytest.raises(InputError, match="is varied more than once"):
        design(HOUSE, JOB, HEIGHT * 2, ["expected_error"])


def test_a_package_that_is_missing_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("cma", "pymoo", "pymoo.algorithms.moo.nsga2"):
        monkeypatch.setitem(__import__("sys").modules, name, None)
    for name in ("cma-es", "nsga2"):
        with pytest.raises(EnvironmentFault, match=r"pip install 'cablewright\[design\]'"):
            OPTIMISERS[name](lambda _: (np.zeros((1, 1)), np.zeros(1)), 2, 1, Budget(10, 5, 0))


def test_every_figure_declares_its_meaning() -> None:
    for key, each in MEASURES.items():
        assert each.figure.key == key
        assert each.scale > 0.0
        assert each.figure.meaning.endswith(".")


def test_the_written_file_loads_as_the_robot(tmp_path: Path) -> None:
    from cablewright.apps.cli.main import run

    folder = tmp_path / "out"
    command = "design house-printer examples/helix.toml --vary exit_point.z=8:15 --objective expected_error --json "
    root = Path(__file__).resolve().parents[3]
    command = command.replace("examples/", f"{root}/examples/")
    assert run([*command.split(), "--evaluations", "6", "--population", "5", "--out", str(folder)]) == 0
    robot = loads((folder / "robot.toml").read_text("utf-8"))
    assert robot.lines[0].exit_point[2] < 15.0
    assert (folder / "report.html").stat().st_size > 10_000
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "file").touch()
    assert run([*command.split(), "--out", str(tmp_path / "other")]) == 2
