"""Every public function, from the stub that declares them: one pose and a batch, arguments of wrong types, its repr."""

from __future__ import annotations

import inspect
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cablewright as cw
from cablewright.foundation import argument_checks
from test_public_names import WITHOUT_EXTRAS

FUNCTIONS: dict[str, Callable[..., Any]] = {
    name: getattr(cw, name) for name in cw.__all__ if inspect.isfunction(getattr(cw, name))
}
PLACES = ("poses", "where")
AT_POSES = [name for name, function in FUNCTIONS.items() if {*PLACES} & {*inspect.signature(function).parameters}]
ROBOT = cw.load("jung2020")
POSES = np.array([[0.2, 0.1, 0.9], [0.0, 0.0, 0.8]])
GIVEN: dict[str, dict[str, Any]] = {
    "accuracy": {"method": cw.FirstOrder()},
    "solve_with_slack": {"excess": {"1": 0.01}},
}
NO_ROWS = ("bracket", "interference", "simulate_calibration", "solve_with_slack")
"""Functions of a pose, or of a number of poses, that take no rows."""


class Junk:
    """Nothing that any function takes."""

    def __repr__(self) -> str:
        return "junk"


def first(value: Any) -> Any:
    """The first row of an answer of a batch."""
    return value if isinstance(value, np.ndarray) else value.to_dict()


def numbers(value: Any) -> list[float]:
    """All numbers of an answer, in order."""
    if isinstance(value, dict):
        return [number for key in sorted(value) for number in numbers(value[key])]
    if isinstance(value, list | tuple | np.ndarray):
        return [number for each in value for number in numbers(each)]
    return [float(value)] if isinstance(value, float | int | np.floating) else []


def test_functions_that_take_poses_are_known() -> None:
    assert set(AT_POSES) >= {
        "inverse",
        "jacobian",
        "stiffness",
        "natural_frequencies",
        "available_wrenches",
        *NO_ROWS[:2],
    }


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name == "accuracy"))  # as in analyses/accuracy
        for name in AT_POSES
        if name not in NO_ROWS
    ],
)
def test_a_row_of_a_batch_is_the_answer_at_its_pose(name: str) -> None:
    function, options = FUNCTIONS[name], GIVEN.get(name, {})
    one, batch = function(ROBOT, POSES[1], **options), function(ROBOT, POSES, **options)
    if name == "accuracy":  # of one pose the study of that pose
        assert batch.nominal_error[1] == pytest.approx(float(one.accuracy.nominal_error[0]), abs=1e-9)
        return
    if name == "compare_tensions":
        assert batch.tensions[:, 1] == pytest.approx(one.tensions, rel=1e-9)
        return
    if name == "modes":
        one, batch = one.frequencies, batch.frequencies
    row = batch[1]
    if name == "stiffness":
        one, row = one.total, row.total
    assert numbers(first(row)) == pytest.approx(numbers(first(one)), rel=1e-6, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("wrong", [Junk(), 3.5, None, [1, "x"]], ids=["object", "number", "None", "list"])
def test_arguments_of_wrong_types_are_rejected_in_one_line(name: str, wrong: object) -> None:
    function = FUNCTIONS[name]
    needed = [
        each
        for each in inspect.signature(function).parameters.values()
        if each.default is each.empty and each.kind not in argument_checks._VARIED
    ]
    if not needed or (name == "random_loop" and wrong == 3.5):
        return
    if name in ("calibration_poses", "curves"):
        wrong = Junk()
    with pytest.raises(cw.CablewrightError) as caught:
        function(**{each.name: wrong for each in needed})
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_types_of_all_parameters_are_known_and_a_name_is_found_again(name: str) -> None:
    function = FUNCTIONS[name]
    shape, *_ = argument_checks._rules(inspect.unwrap(function))
    assert shape == inspect.signature(function)
    assert getattr(sys.modules[function.__module__], function.__qualname__) is function
    assert function.__doc__


def test_missing_arguments_are_python_errors() -> None:
    with pytest.raises(TypeError, match="poses"):
        cw.inverse(ROBOT)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: cw.inverse("cogiro", POSES), r"inverse: robot = 'cogiro': a Robot or a Model is expected"),
        (lambda: cw.accuracy(ROBOT, POSES[0], Junk()), "ranges = junk: a list or an Uncertainty or None is expected"),
        (lambda: cw.capacity(ROBOT, POSES, length="1 m"), "length = '1 m': a number in SI units is expected"),
        (lambda: cw.count_nodes(ROBOT, "closed-form", grid=5.5), "grid = 5.5: a whole number or None is expected"),
        (
            lambda: cw.Trajectory.through([[0, 0, 1], [1, 0, 1]], speed="0.1 m/s", acceleration=0.1),
            "speed = '0.1 m/s': a number in SI units is expected",
        ),
        (lambda: cw.load(3), "name_or_path = 3: a text or a path is expected"),
        (lambda: cw.tension_distribution(ROBOT, POSES, "exakt"), "did you mean 'exact'"),
        (lambda: cw.inverse(ROBOT, POSES, cable="catenery"), "did you mean 'catenary'"),
    ],
)
def test_the_line_names_what_is_expected(call: Callable[[], object], text: str) -> None:
    with pytest.raises(cw.InputError, match=text):
        call()


def test_an_uncertainty_is_as_good_as_its_ranges() -> None:
    robot, uncertain = cw.load("house-printer"), cw.load_uncertainty("examples/uncertain.toml")
    found = [
        cw.accuracy(robot, [[0.0, 0.0, 5.0]], each, method="first-order") for each in (uncertain, uncertain.of(robot))
    ]
    assert found[0].spread.max_error == pytest.approx(found[1].spread.max_error)


def test_an_unknown_public_name_has_its_nearest() -> None:
    with pytest.raises(AttributeError, match="no attribute 'workspce'; did you mean 'workspace'"):
        cw.workspce  # noqa: B018


@pytest.mark.parametrize("name", ["jacobian", "structure_matrix", "stiffness", "dexterity", "compare_tensions"])
def test_an_unknown_keyword_is_named(name: str) -> None:
    with pytest.raises(cw.InputError, match=f"{name}: unknown argument 'sheeve'; did you mean 'sheave'"):
        FUNCTIONS[name](ROBOT, POSES[0], sheeve="eyelet")


def test_every_member_is_found_without_extras() -> None:
    code = f"""{WITHOUT_EXTRAS}
import inspect, cablewright
members = dict(inspect.getmembers(cablewright))
assert set(cablewright.__all__) <= members.keys(), set(cablewright.__all__) - members.keys()
for name in cablewright.__all__:
    inspect.getdoc(members[name])
    if callable(members[name]):
        inspect.signature(members[name])
"""
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.slow
def test_sixty_snippets_of_users_are_typed(tmp_path: Path) -> None:
    """Each function of the file is a snippet; mypy --strict finds nothing wrong in it, and what is wrong elsewhere."""
    pytest.importorskip("mypy")
    snippets = Path(__file__).parent / "snippets.py"
    assert snippets.read_text("utf-8").count("\ndef ") >= 60
    wrong = tmp_path / "wrong.py"
    wrong.write_text(
        "import cablewright as cw\ncw.jacobian('cogiro', [0.0])\ncw.load('a').exit_point\nx: int = cw.inverse\n"
    )
    command = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent"]
    for file, code in ((snippets, 0), (wrong, 1)):
        ended = subprocess.run([*command, str(file)], capture_output=True, text=True, check=False, cwd=tmp_path)
        assert ended.returncode == code, ended.stdout
    assert ended.stdout.count("error:") == 3, ended.stdout
