"""Mutated files for every reader and for whole commands, for ten seconds; and every case that ever failed."""

from __future__ import annotations

import logging
import runpy
import signal
import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
TOOL = runpy.run_path(str(ROOT / "tools" / "fuzz.py"), run_name="tool")
FORMATS = {each.name: each for each in TOOL["FORMATS"]}
CASES = sorted((ROOT / "tests" / "fuzz_cases").glob("*"))
BRIEF, LONG = 4.0, 60.0  # s, of all formats


@pytest.fixture(autouse=True)
def _prepared() -> Iterator[None]:
    """Alarms are raised, and warnings left out, for the test alone."""
    before = signal.getsignal(signal.SIGALRM)
    with warnings.catch_warnings():
        TOOL["prepare"]()
        yield
    signal.signal(signal.SIGALRM, before)
    logging.disable(logging.NOTSET)


@pytest.mark.parametrize("seconds", [BRIEF, pytest.param(LONG, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", FORMATS)
def test_no_mutation_is_a_fault(name: str, seconds: float) -> None:
    found = list(TOOL["run"]([FORMATS[name]], seed=1, seconds=seconds / len(FORMATS), inputs=10**9, cases=None))
    assert not found


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_what_once_failed_does_so_no_more(case: Path, tmp_path: Path) -> None:
    form = FORMATS[case.name.rpartition("-")[0]]
    assert TOOL["tried"](form, case.read_bytes(), tmp_path) is None


def test_a_fault_is_found_and_reduced(tmp_path: Path) -> None:
    """The fuzzer itself: a reader that stumbles over a letter is caught, and what is kept is that letter."""

    def read(path: Path) -> None:
        if b"[" in path.read_bytes():
            raise KeyError("a fault")

    form = TOOL["Format"]("faulty", ".txt", lambda: [b"ten letters " * 20], read)
    failures = list(TOOL["run"]([form], seed=1, seconds=20.0, inputs=2000, cases=tmp_path))
    assert [each.kind for each in failures] == ["faulty: KeyError elsewhere"]
    (kept,) = tmp_path.iterdir()
    assert kept.read_bytes() == b"["
    assert TOOL["tried"](form, kept.read_bytes(), tmp_path) is not None


@pytest.mark.parametrize(
    ("read", "kind"),
    [
        (lambda _path: signal.pause(), "slow"),
        (lambda _path: TOOL["_judge_message"]("x" * 3000), "AssertionError fuzz._judge_message"),
    ],
)
def test_what_hangs_or_talks_too_much_is_a_fault(read, kind: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setitem(TOOL["tried"].__globals__, "LONGEST", 0.2)
    found = TOOL["tried"](TOOL["Format"]("faulty", ".txt", lambda: [b""], read), b"", tmp_path)
    assert found is not None
    assert found.kind.split()[0] == kind.split()[0]
