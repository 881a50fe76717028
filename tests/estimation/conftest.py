"""A machine without faults, and the filter after nine seconds of it."""

from __future__ import annotations

from typing import Any

import pytest

from cablewright.estimation import started_filter
from cablewright.estimation.kalman.state import FilterState
from cablewright.live.estimator_settings import started_settings
from cablewright.robot import load
from observer_runs import drive
from twins import SETTINGS


@pytest.fixture(scope="session")
def whole() -> Any:
    return drive(16.0, seed=2)


@pytest.fixture(scope="session")
def later(whole: Any) -> FilterState:
    settings = started_settings(load("merlet2023"), SETTINGS)
    state = started_filter.start(settings)
    for frame, _ in whole[:900]:
        started_filter.step(settings, state, frame)
    assert state.chain is None
    return state.filter
