"""The notebooks run from an empty state and show what their cells end with; they are stored without outputs."""

from __future__ import annotations

import ast
import json
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cablewright as cw

FOLDER = Path(__file__).resolve().parents[2] / "examples" / "notebooks"
NAMES = sorted(file.stem for file in FOLDER.glob("*.ipynb"))
SLOW = ("a_day_of_the_blind_machines", "jung2020_workspace_and_stiffness")


def cells(name: str, kind: str) -> list[str]:
    """Return the sources of a notebook's cells of a kind."""
    book = json.loads((FOLDER / f"{name}.ipynb").read_text("utf-8"))
    assert book["nbformat"] == 4
    return ["".join(cell["source"]) for cell in book["cells"] if cell["cell_type"] == kind]


def shown(source: str, names: dict[str, Any]) -> Any:
    """Run a cell as a notebook does; return the value of its last expression."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "<cell>", "exec"), names)  # noqa: S102
    return None if last is None else eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)  # noqa: S307


def test_there_are_five_without_outputs() -> None:
    assert len(NAMES) == 5
    for name in NAMES:
        book = json.loads((FOLDER / f"{name}.ipynb").read_text("utf-8"))
        code = [cell for cell in book["cells"] if cell["cell_type"] == "code"]
        assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)
        assert len({cell["id"] for cell in book["cells"]}) == len(book["cells"])
        assert cells(name, "markdown")[0].startswith("# ")


@pytest.mark.parametrize("name", [pytest.param(each, marks=[pytest.mark.slow] * (each in SLOW)) for each in NAMES])
def test_all_cells_run_and_their_values_can_be_shown(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(FOLDER)  # where Jupyter opens it
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    names: dict[str, Any] = {"__name__": "__main__"}
    rich = 0
    for source in cells(name, "code"):
        value = shown(source, names)
        for look, begin in (("_repr_html_", "<"), ("_repr_png_", b"\x89PNG")):
            drawn = getattr(value, look)() if hasattr(value, look) else None  # a figure has no HTML without a window
            if drawn is not None:
                rich += 1
                assert drawn.startswith(begin)
    assert rich >= 2


@pytest.mark.slow
@pytest.mark.skipif(find_spec("nbclient") is None or find_spec("ipykernel") is None, reason="needs the extra notebooks")
@pytest.mark.parametrize("name", NAMES)
def test_a_kernel_of_jupyter_runs_it(name: str) -> None:
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    book = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    nbformat.validate(book)
    nbclient.NotebookClient(book, timeout=300, resources={"metadata": {"path": str(FOLDER)}}).execute()


def test_a_result_is_a_table_and_a_batch_its_first_rows() -> None:
    robot = cw.load("jung2020").with_(name="<b>mine</b>")
    one = cw.inverse(robot, [0.2, 0.1, 0.9])._repr_html_()
    assert "<b>mine" not in one
    assert "&lt;b&gt;mine" in one
    assert one.count("<table>") == 2  # its figures, and its lines
    rows = cw.inverse(robot, [[0.0, 0.0, z] for z in np.linspace(0.6, 1.2, 20)])._repr_html_()
    assert rows.count("<tr>") == 1 + 12
    assert "20 rows, of which 12 are shown" in rows


def test_a_view_is_a_frame_without_requests_and_a_page(tmp_path: Path) -> None:
    held = cw.inverse(cw.load("merlet2023"), [0.0, 0.0, 1.0])
    found = cw.view(held, height=300)
    frame = found._repr_html_()
    assert frame.startswith('<iframe srcdoc="')
    assert "height: 300px" in frame
    assert frame.count("<") == 2  # the frame and its end: the page is escaped
    found.save(tmp_path / "view.html")
    assert (tmp_path / "view.html").read_text("utf-8") == found.page()
    assert repr(found) == "View('merlet2023', states=1)"
    assert repr(cw.view(cw.modes(held))).startswith("View('Modes'")


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: cw.view(cw.inverse(cw.load("merlet2023"), [[0.0, 0.0, 1.0]] * 2)), "view: a batch has no view"),
        (lambda: cw.view(cw.problems("margin")[0]), "view: Problem has no robot to show"),
        (lambda: cw.view(cw.load("merlet2023"), height=5), "height = 5: must be from 100 to 4000 pixels"),
        (lambda: cw.view(cw.inverse(cw.load("merlet2023"), [0.0, 0.0, 1.0])).save("x.htm"), "ends in .html"),
    ],
)
def test_what_cannot_be_shown_is_said_in_one_line(call: Callable[[], object], text: str) -> None:
    with pytest.raises(cw.InputError, match=text) as caught:
        call()
    assert "\n" not in str(caught.value)
