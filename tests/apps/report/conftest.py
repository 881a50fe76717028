"""A small check that tests may write reports of."""

import pytest

from apps.report.synthetic import make_check, ring_robot, small_job


@pytest.fixture
def small(tmp_path):
    """(check, layers) of a few moves on four lines."""
    return make_check(ring_robot(4), small_job(tmp_path))


@pytest.fixture
def folder(tmp_path):
    """An empty folder for a report."""
    made = tmp_path / "run"
    made.mkdir()
    return made
