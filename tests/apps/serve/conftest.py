"""One server for all tests of a process: a simulated house-printer."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator

import pytest

from served import Served, served


@pytest.fixture(scope="package")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """Serves until the last test of this folder: it takes a third of a core."""
    if importlib.util.find_spec("starlette") is None:
        pytest.skip("the extra web is not installed")
    with served(tmp_path_factory.mktemp("served") / "out", "house-printer", "--seed", "1") as made:
        yield made
