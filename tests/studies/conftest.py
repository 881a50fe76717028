"""One check that the tests of studies look at from several sides."""

from __future__ import annotations

from pathlib import Path

import pytest

from cablewright.printing.job import load_job
from cablewright.robot import load
from cablewright.studies.checks.check import check
from cablewright.studies.checks.result import Check


@pytest.fixture(scope="session")
def job_file(write_job) -> Path:
    """A square of a metre, three layers, in the middle of a machine."""
    return write_job()


@pytest.fixture(scope="session")
def found(job_file: Path) -> Check:
    """The check of the square on the house-printer."""
    return check(load("house-printer"), load_job(job_file))
