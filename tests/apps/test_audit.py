"""What `make check` says of the dependencies' vulnerabilities, and of not having been able to ask."""

from __future__ import annotations

import json

import pytest
from tools.audit import LOCKS, NotAudited, read, told

KNOWN = {
    "name": "pillow",
    "version": "9.0.0",
    "vulns": [{"id": "PYSEC-2022-168", "fix_versions": ["9.0.1"], "aliases": [], "description": "a path"}],
}
FINE = {"name": "numpy", "version": "2.0.0", "vulns": []}
SKIPPED = {"name": "mine", "skip_reason": "Dependency not found on PyPI"}


def answer(*dependencies: dict[str, object]) -> str:
    return json.dumps({"dependencies": dependencies, "fixes": []})


def test_a_known_vulnerability_fails_once_for_all_locks(capsys: pytest.CaptureFixture[str]) -> None:
    assert told(read(answer(FINE, KNOWN, KNOWN, SKIPPED), "Found 1 known vulnerability")) == 1
    assert capsys.readouterr().out.splitlines() == [
        "pillow 9.0.0: PYSEC-2022-168, mended in 9.0.1",
        "3 dependencies audited, 1 not; 1 known vulnerabilities",
    ]


def test_none_known_is_fine() -> None:
    assert told(read(answer(FINE), "")) == 0


def test_an_index_without_advisories_is_no_clean_bill() -> None:
    with pytest.raises(NotAudited, match="no advisories for any of the 2"):
        read(answer(SKIPPED, SKIPPED), "")


def test_offline_is_said_and_a_failure_of_the_tool_is_one() -> None:
    with pytest.raises(NotAudited, match="cannot be reached"):
        read("", "Traceback ...\nrequests.exceptions.ConnectTimeout: pypi.org")
    with pytest.raises(RuntimeError, match="unrecognized arguments"):
        read("", "pip-audit: error: unrecognized arguments: --disable")


def test_every_lock_is_looked_at() -> None:
    assert [lock.name for lock in LOCKS] == ["bench.txt", "dev.txt", "docs.txt", "run.txt"]
