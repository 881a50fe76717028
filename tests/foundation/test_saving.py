"""Plain data is saved and loaded by one walk; what other versions saved is rejected, or begins again."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.foundation.saved_state import (
    LAYOUT,
    Coded,
    Saved,
    SavedRows,
    Snapshot,
    Sparse,
    load,
    read_snapshots,
    save,
    write_snapshots,
)
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import load as load_robot
from twins import TWIN, machine

EARLIER = Path(__file__).parents[1] / "earlier_files"


class Pair(NamedTuple):
    """Two arrays, one of them a scratch that may be left out."""

    rows: np.ndarray
    scratch: np.ndarray | None


@dataclasses.dataclass(eq=False)
class Part:
    """A part that derives a value from its state."""

    SAVED = ("mask", "_counts")

    mask: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(3, dtype=bool))
    _counts: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(2, dtype=np.int64))
    total: int = 0

    def after_load(self) -> None:
        self.total = int(self._counts.sum())


class Whole:
    """One of every kind of state, and settings that are not saved."""

    SAVED: ClassVar[Saved] = (
        "steps", "time", "done", "pair", "place", "random", "part", "parts", "missing", "inner.total",
        Sparse("floor"), SavedRows("path", 4), Coded("names", sorted, set),
    )  # fmt: skip

    def __init__(self) -> None:
        self.setting, self.steps, self.time, self.done = 7, 0, -math.inf, False
        self.pair, self.place = Pair(np.zeros((2, 2)), None), (0.0, 0.0)
        self.random, self.part = np.random.default_rng(5), Part()
        self.parts, self.missing, self.inner = {"a": Part(), "b": [Part()]}, None, Part()
        self.floor, self.path, self.names = np.zeros((5, 6)), np.zeros((0, 2)), set[str]()


def used() -> Whole:
    """A state that has changed everywhere."""
    state = Whole()
    state.setting, state.steps, state.time, state.done, state.place = 8, 41, 0.1 + 0.2, True, (math.inf, -1.5)
    state.pair.rows[:] = np.pi * np.arange(4.0).reshape(2, 2)
    state.random.standard_normal(7)
    for number, part in enumerate((state.part, state.parts["a"], state.parts["b"][0])):  # type: ignore[index]
        part.mask[number], part._counts[:] = True, (2**29, number)  # type: ignore[union-attr]
    state.inner.total, state.names = 3, {"ü", "b"}
    state.floor[2, 3:5], state.path = (0.25, 1e-300), np.arange(6.0).reshape(3, 2)
    return state


def test_every_kind_of_plain_state_comes_back_to_the_bit(tmp_path: Path) -> None:
    state, found = used(), Whole()
    rows, mask = found.pair.rows, found.part.mask
    write_snapshots(tmp_path / "state", {"whole": save(state)})
    load(found, read_snapshots(tmp_path / "state")["whole"])
    mine, others = save(state), save(found)
    assert mine.values == others.values
    assert mine.arrays.keys() == others.arrays.keys()
    assert all(each.tobytes() == others.arrays[key].tobytes() for key, each in mine.arrays.items())
    assert (found.setting, found.place, found.names, found.part.total) == (7, state.place, state.names, 2**29)
    assert found.pair.rows is rows  # arrays are loaded in place
    assert found.part.mask is mask
    assert found.random.random() == state.random.random()
    assert mine.arrays["floor"].shape == (1, 2)


def test_what_was_saved_shares_no_memory_with_the_state() -> None:
    state = used()
    snapshot = save(state)
    before = {key: each.copy() for key, each in snapshot.arrays.items()}
    for live in (state.pair.rows, state.floor, state.path, state.part.mask):
        live[...] = 1
    assert all(each.tobytes() == before[key].tobytes() for key, each in snapshot.arrays.items())


def _arrays(state: Any) -> Iterator[np.ndarray]:
    for form in getattr(state, "SAVED", ()):
        found = state
        for name in (form if isinstance(form, str) else form.name).split("."):
            found = getattr(found, name)
        for each in found.values() if isinstance(found, dict) else [found]:
            yield from [each] if isinstance(each, np.ndarray) else _arrays(each)


@pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])
def test_no_array_of_a_machine_is_saved_twice(plant: str) -> None:
    found = list(_arrays(machine(plant=plant)))
    assert len(found) > 20
    for number, one in enumerate(found):
        assert not any(np.shares_memory(one, other) for other in found[:number])


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("steps", True, "a whole number"),
        ("time", math.nan, "a number is expected"),
        ("done", 1, "true or false"),
        ("place.0", "x", "a number"),
        ("part.mask", np.zeros(3), "bool (3,) is expected; got float64 (3,)"),
        ("pair.rows", np.full((2, 2), math.nan), "not finite"),
        ("pair.rows", np.full((2, 2), 1e10), "over 1e+09"),
        ("path", np.zeros((5, 2)), "up to 4 rows (2,)"),
        ("path", np.zeros((2, 3)), "up to 4 rows (2,)"),
    ],
)
def test_what_does_not_fit_is_named(key: str, value: Any, says: str) -> None:
    snapshot = save(used())
    kind = snapshot.arrays if isinstance(value, np.ndarray) else snapshot.values
    kind[key] = value
    with pytest.raises(InputError) as refused:
        load(Whole(), snapshot)
    assert str(refused.value).startswith(f"snapshot: {key}: ")
    assert says in str(refused.value)


def test_a_number_may_be_unknown_where_it_begins_unknown() -> None:
    state, found = Whole(), Whole()
    state.time = found.time = math.nan
    for one in (state, found):
        one.pair.rows[0] = math.nan, -math.inf
    load(found, save(state))
    assert math.isnan(found.time)
    state.time, state.pair.rows[0] = 2.0, 3.0
    load(found, save(state))
    assert (found.time, *found.pair.rows[0]) == (2.0, 3.0, 3.0)


def test_state_without_saved_attributes_is_a_mistake() -> None:
    state = Whole()
    state.missing = object()  # type: ignore[assignment]
    with pytest.raises(AttributeError, match="SAVED"):
        save(state)


@pytest.mark.parametrize("layout", [1, 99])
def test_state_of_another_layout_is_rejected_by_its_number(layout: int) -> None:
    snapshot = save(used())
    snapshot.values["layout"] = layout
    with pytest.raises(InputError, match=f"layout is {layout}, .* this one: {LAYOUT}"):
        load(Whole(), snapshot)


def test_a_machine_of_the_first_layout_is_rejected() -> None:
    old = read_snapshots(EARLIER / "print_checkpoint.bin")["machine"]
    new = machine().snapshot()
    given = Snapshot(old.values | {"machine": new.values["machine"]}, old.arrays)
    with pytest.raises(InputError, match="layout is 1"):
        SimulatedMachine.resumed(load_robot("merlet2023"), TWIN, given, seed=1)
