"""A small check that tests may write reports of."""

import pytest

from apps.report.synthetic import make_check, ring_robot, small_job
from cablewright.apps.report.check import write


@pytest.fixture(scope="session")
def small(tmp_path_factory):
    """(check, layers) of a few moves on four lines."""
    return make_check(ring_robot(4), small_job(tmp_path_factory.mktemp("small")))


@pytest.fixture(scope="session")
def written(small, tmp_path_factory):
    """The folder with its report, to be read only."""
    made = tmp_path_factory.mktemp("written")
    write(small[0], made, small[1])
    return made


@pytest.fixture
def folder(tmp_path):
    """An empty folder for a report."""
    made = tmp_path / "run"
    made.mkdir()
    return made
