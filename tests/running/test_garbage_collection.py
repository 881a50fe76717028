"""The garbage collector is as it was before a control loop, and leaves old objects alone during it."""

from __future__ import annotations

import gc

import pytest

from cablewright.running.garbage_collection import without_old_objects


@pytest.fixture(params=[False, True], ids=["nothing frozen", "frozen before"])
def frozen(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    """Objects that seem frozen before: tests themselves are, and must stay so."""
    count = 7 * request.param
    monkeypatch.setattr(gc, "get_freeze_count", lambda: count)
    return count


@pytest.mark.parametrize("paced", [False, True])
def test_objects_of_before_are_left_out_and_come_back(
    frozen: int, paced: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    back: list[bool] = []
    monkeypatch.setattr(gc, "unfreeze", lambda: back.append(True))
    old = [[]]
    assert gc.is_tracked(old)
    gc.collect()
    with without_old_objects(paced=paced):
        assert gc.isenabled() is not paced
        assert not any(each is old for each in gc.get_objects())
        assert back == []
    assert gc.isenabled()
    assert back == ([] if frozen else [True])
