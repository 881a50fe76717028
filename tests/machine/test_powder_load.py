"""Powder of a drum, by orders and commands."""

from __future__ import annotations

import math

import numpy as np

from cablewright.foundation.signals import Command, Order, OrderKind
from cablewright.machine.powder_load import PowderLoad
from twins import SETTINGS


def poured(valve: float) -> Command:
    return Command(0.0, np.zeros(4), valve)


def test_what_the_valve_lets_out_is_gone_until_it_is_refilled() -> None:
    load = PowderLoad.of(SETTINGS.drum)
    load.follow((), poured(0.5), 10.0)
    assert math.isclose(load.gone, 5.0 * SETTINGS.drum.flow)
    assert math.isclose(load.left + load.gone, SETTINGS.drum.powder)
    load.follow((), None, 10.0)
    load.follow((Order(OrderKind.REFILLED, refusal="it prints"),), poured(0.0), 10.0)
    assert math.isclose(load.gone, 5.0 * SETTINGS.drum.flow)
    load.follow((Order(OrderKind.REFILLED),), poured(1.0), 1.0)
    assert math.isclose(load.gone, SETTINGS.drum.flow)


def test_no_more_is_gone_than_was_in_it() -> None:
    load = PowderLoad.of(SETTINGS.drum)
    load.pour(1.0, 1e6)
    assert load.gone == SETTINGS.drum.powder
    assert load.left < 0.0


def test_what_comes_through_a_hose_makes_nothing_lighter() -> None:
    load = PowderLoad.of(SETTINGS.drum.model_copy(update={"capacity": 0.0, "powder": 0.0}))
    load.pour(1.0, 1e6)
    assert load.gone == 0.0
    assert load.left == math.inf
