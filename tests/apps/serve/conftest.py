"""One server for all tests of a file: a simulated house-printer."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator

import pytest

from served import Served, served


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """Serves until the last test of a file: it takes a third of a core from all others."""
    if importlib.util.find_spec("starlette") is None:
        pytest.skip("the extra web is not installed")
    with served(tmp_path_factory.mktemp("served") / "out", "house-printer", "--seed", "1") as made:
        yield made
