"""The promises of the loop under random orders and faults: `tools/random_orders.py` runs more of them."""

from __future__ import annotations

import numpy as np
import pytest
from tools.random_orders import run_sequence

from cablewright.control import guard, manual, supervisor
from cablewright.control.transitions import TRANSITIONS
from cablewright.signals import OrderKind, PrintState, WinchMode
from cablewright.studies.prints import loop

SEEDS = range(300)


def test_no_promise_is_broken_and_every_state_is_seen() -> None:
    seen = set().union(*map(run_sequence, SEEDS))
    assert seen == set(PrintState)


BREAKS = {
    "the fault stays": (supervisor, "_no_reset", lambda *_: ""),
    "over its limit": (guard, "_measured_tensions", lambda *_: ([], True)),
    "brakes open": (loop, "advance", lambda _settings, stop, _dt: (stop.speeds, WinchMode.VELOCITY)),
    "brakes close in fault on winches": (loop, "advance", lambda *_: (np.zeros(4), WinchMode.OFF)),
    "beside a person": (supervisor, "_person", lambda *_: ""),
    "nobody repeats": (manual, "LEASE", 1e9),
    "reset with a cause": (guard, "_inputs", lambda *_: []),
    "left the fault": (supervisor, "TRANSITIONS", TRANSITIONS | {(PrintState.FAULT, OrderKind.START): PrintState.IDLE}),
}


@pytest.mark.parametrize("says", BREAKS)
def test_whoever_breaks_one_is_found(says: str, monkeypatch) -> None:
    module, name, broken = BREAKS[says]
    monkeypatch.setattr(module, name, broken)
    with pytest.raises(AssertionError, match=says):
        list(map(run_sequence, SEEDS))
