"""A print that was killed after its end says so when it is resumed."""

from __future__ import annotations

import numpy as np
import pytest
from tools.random_world import Followed, Shaken, plan

from cablewright.control.supervisor import NOT_RESET
from cablewright.foundation.saved_state import Snapshot
from cablewright.foundation.signals import PrintState
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.recorder import checkpoint_of


@pytest.mark.parametrize("finished", [True, False])
def test_a_print_that_had_its_end_is_resumed_as_finished(finished: bool) -> None:
    def printer(saved: dict[str, Snapshot] | None = None) -> Printer:
        machine = Shaken(np.random.default_rng(0), calm=True)
        return Printer(plan(), machine, lambda _place, _radii: Followed(machine), saved=saved)

    first = printer()
    first.supervisor.finished = finished
    again = printer(checkpoint_of(first))
    assert again.finished is finished
    assert (again.supervisor.state, again.supervisor.reason) == (
        PrintState.FAULT,
        "finished" if finished else NOT_RESET,
    )
