"""Examples and the blocks of the documentation run, and print what is pinned here or printed there."""

from __future__ import annotations

import re
import runpy
import shlex
import subprocess
from pathlib import Path

import pytest

from cablewright.apps.cli.main import run

pytestmark = pytest.mark.usefixtures("undrawn")  # what is compared is text
ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = ROOT / "examples"
PINNED = {  # the number, and how far the printed one may be from it: its last digit
    "01_hold_a_pose": (833.4, 0.1),  # N
    "02_where_does_it_hang": (19.0, 0.1),  # mm; Paty 2021, Table 1 prints 19.5
    "03_slack_line": (0.40, 0.01),  # N
    "04_stiffness": (98.88, 0.01),  # kN/m
    "05_check_a_part": (19.76, 0.01),  # mm
    "06_own_robot": (2.7283, 0.0001),  # m
    "07_rigid_platform": (17.53, 0.01),  # N m/rad
    "08_hanging_platform": (50.75, 0.01),  # N
    "09_retract_as_it_grows": (1.975, 0.001),  # mm
    "10_how_far_off": (32.0, 0.1),  # mm
    "11_let_a_line_out": (8.31, 0.01),  # mm
    "12_simulated_machine": (68.4, 0.1),  # mm
    "13_heap_of_powder": (24.1, 0.1),  # cm
    "14_stress_in_a_bracket": (55.6, 0.1),  # MPa
    "15_calibrate": (6.19, 0.01),  # mm
    "16_print": (33.2, 0.2),  # mm
    "17_print_with_a_body": (84.0, 2.0),  # N
    "18_print_with_a_retracting_beam": (-0.8, 0.3),  # N
    "19_design": (5.47, 0.01),  # mm
    "20_zeros_of_sensors": (1.16, 0.01),  # mm
    "21_creep_and_mounts": (12.41, 0.01),  # mm
    "22_counterweight": (51.3, 0.1),  # N
    "23_a_robot_for_a_paper": (114.4, 0.1),  # W
    "24_own_control_loop": (26.0, 0.1),  # mm
    "papers/paty2021_mounts": (0.58, 0.01),  # mm
    "papers/paty2021_fidelity": (54.31, 0.01),  # mm
    "25_print_a_tall_wall": (5.5, 0.1),  # mm
    "26_tags_and_camera": (9.07, 0.01),  # m
}
PYTHON = re.compile(r"```python\n(.*?)```(?:\n+```text\n(.*?)```)?", re.DOTALL)  # a script, and what it prints
CONSOLE = re.compile(r"```console\n(.*?)```", re.DOTALL)  # commands after "$ ", and some lines of their output


def slow_with(long: tuple[str, ...], text: str) -> list[pytest.MarkDecorator]:
    return [pytest.mark.slow] * any(each in text for each in long)


def blocks(pattern: re.Pattern[str], long: tuple[str, ...]) -> list[object]:
    """Each match in a page as a parameter named after the page; slow where it has one of the texts *long*."""
    return [
        pytest.param(*found.groups(), id=f"{page.stem}-{number}", marks=slow_with(long, found[0]))
        for page in sorted((ROOT / "docs").rglob("*.md"))
        for number, found in enumerate(pattern.finditer(page.read_text(encoding="utf-8")), 1)
    ]


def test_every_example_is_pinned() -> None:
    assert sorted(path.stem for path in EXAMPLES.glob("*.py")) == sorted(name for name in PINNED if "/" not in name)


SLOW = (  # seconds to minutes
    "09_retract_as_it_grows",
    "10_how_far_off",  # as apps/cli/test_accuracy.py
    "13_heap_of_powder",  # as papers/test_merlet2023.py
    "14_stress_in_a_bracket",  # as apps/cli/test_bracket.py
    "16_print",  # as apps/cli/test_print.py
    "17_print_with_a_body",
    "18_print_with_a_retracting_beam",
    "19_design",  # as studies/design/test_design.py
    "20_zeros_of_sensors",  # as calibration/test_offsets.py
    "21_creep_and_mounts",  # as calibration/test_creep.py and test_mounts.py
    "25_print_a_tall_wall",
)


@pytest.mark.parametrize(
    "name", [pytest.param(each, marks=[pytest.mark.slow] if each in SLOW else []) for each in sorted(PINNED)]
)
def test_an_example_prints_its_number(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    last = capsys.readouterr().out.splitlines()[-1]
    found = re.search(r": (-?[0-9.]+) [a-zA-Z/]+$", last)
    assert found is not None, f"the last line has no number with its unit: {last!r}"
    number, last_digit = PINNED[name]
    assert float(found[1]) == pytest.approx(number, abs=1.001 * last_digit)


LONG = ("cw.campaign(", "cw.design(robot", 'cw.workspace(model, "exact"')
"""Scripts that take seconds: of calls that have examples in their docstrings, and tests in their ranks."""
FEWER = ("(20000, 3)", "(500, 3)")  # poses of a script that takes times, which are not compared here


@pytest.mark.parametrize(("script", "printed"), blocks(PYTHON, LONG))
def test_a_script_of_the_documentation_prints_the_output_on_the_page(
    script: str,
    printed: str | None,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = tmp_path / "script.py"
    path.write_text(script.replace(*FEWER) if printed is None else script, encoding="utf-8")
    monkeypatch.chdir(ROOT)
    runpy.run_path(str(path), run_name="__main__")
    out = capsys.readouterr().out
    assert printed is None or out == printed


def sessions() -> list[object]:
    """Sessions of the pages, of a tutorial as one.

    Slow are those whose commands other tests run: the quick start and `new`, as `apps/test_new.py` prints a part;
    searches that leave nothing out, as `solvers/test_exhaustive.py`; `retraction`, `simulate` and `trade`, as their
    examples in `apps/test_figures.py`; `fit`, as `studies/test_fit.py`; a wrench box, as `apps/cli/test_workspace.py`;
    hangprinters and wall plotters, as `studies/test_makers.py` and the tests of `exchange`.
    """
    long = (
        "$ cablewright print workshop", " --exhaustive", "$ cablewright new attic", "$ cablewright retraction jung2020",
        "$ cablewright simulate merlet2023 --loop", "$ cablewright trade jung2020 --vary exit-distance=0.0283",
        "$ cablewright fit house-printer", " --wrench-box=", "$ cablewright import config.g --nozzle-below",
        "$ cablewright import maslow.yaml --out",
    )  # fmt: skip
    found = []
    for page in sorted((ROOT / "docs").rglob("*.md")):
        texts = CONSOLE.findall(page.read_text(encoding="utf-8"))
        for number, text in enumerate(["".join(texts)] if page.parent.name == "tutorials" else texts, 1):
            found.append(pytest.param(text, id=f"{page.stem}-{number}", marks=slow_with(long, text)))
    return found


@pytest.mark.parametrize("session", sessions())
def test_a_session_of_the_documentation_prints_the_output_on_the_page(
    session: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    out: list[str] = []
    for line in session.splitlines():
        if line.startswith("$ cablewright "):
            run(shlex.split(line)[2:])
            out += "".join(capsys.readouterr()).splitlines()
        elif line.startswith("$ "):
            subprocess.run(line[2:], shell=True, check=True)
        else:
            assert line in out
