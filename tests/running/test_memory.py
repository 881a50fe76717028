"""Work that needs more memory than is free is rejected with numbers, before it begins."""

from __future__ import annotations

from pathlib import Path

import pytest

import cablewright as cw
from cablewright.foundation.errors import EnvironmentFault
from cablewright.running import memory
from cablewright.running.memory import free_memory, require_memory

MEMINFO = "MemTotal: 16000000 kB\nMemFree: 1 kB\nMemAvailable: 2000000 kB\n"


@pytest.fixture
def system(monkeypatch: pytest.MonkeyPatch):
    """Make the system report these sizes: of itself, and of the control group's limit, use and memory for files."""

    def say(meminfo: str | None, most: str | None = None, used: str = "0", kept: int = 0) -> None:
        group = memory._GROUP / "user" / "job"
        files = {Path("/proc/self/cgroup"): "1:name=x:/other\n0::/user/job\n", Path("/proc/meminfo"): meminfo}
        files |= {group / "memory.max": most, group / "memory.current": used}
        files |= {group / "memory.stat": f"anon 5\ninactive_file {kept}\n"}

        def read_text(path: Path, _encoding: str) -> str:
            text = files[path]
            if text is None:
                raise FileNotFoundError(path)
            return text

        monkeypatch.setattr(Path, "read_text", read_text)

    return say


def test_the_lesser_of_system_and_group_is_free(system) -> None:
    system(MEMINFO)
    assert free_memory() == pytest.approx(2.048e9)
    system(MEMINFO, "max\n", "5000000\n")
    assert free_memory() == pytest.approx(2.048e9)
    system(MEMINFO, "1500000000\n", "500000000\n")
    assert free_memory() == pytest.approx(1e9)
    system(MEMINFO, "1500000000\n", "1500000000\n", kept=400_000_000)
    assert free_memory() == pytest.approx(4e8)
    system(None)
    assert free_memory() is None


def test_what_does_not_fit_is_rejected_with_numbers(system) -> None:
    system(MEMINFO)
    require_memory(2e9, "this", "do less")
    with pytest.raises(EnvironmentFault, match=r"this takes about 29.2 GB, and 2.0 GB are free; do less"):
        require_memory(29.2e9, "this", "do less")
    system(None)
    require_memory(1e18, "this", "do less")  # unknown


@pytest.mark.parametrize(
    ("study", "what"), [(cw.check, "a check"), (cw.accuracy, "the accuracy"), (cw.interference, "the distances")]
)
def test_a_study_of_a_job_reckons_before_it_begins(study, what: str, write_job, monkeypatch) -> None:
    monkeypatch.setattr(memory, "free_memory", lambda: 1e4)
    with pytest.raises(EnvironmentFault, match=rf"{what} of \d+ samples takes .* a longer step in \[sampling\]"):
        study(cw.load("house-printer"), cw.load_job(write_job()))
