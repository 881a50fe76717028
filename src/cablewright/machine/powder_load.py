"""Powder in the container, computed from the commands: openings of the valve, and refills."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from cablewright.foundation.signals import Command, Order, OrderKind
from cablewright.machine.carried_load import Body, Drum


@dataclass
class PowderLoad:
    """The powder that a container holds.

    ``flow``: kg/s with the valve open. ``full``: kg after a refill; inf: it never ends. ``poured``: kg since then.
    """

    SAVED = ("poured",)

    flow: float
    full: float
    poured: float = 0.0

    @classmethod
    def of(cls, carrier: Drum | Body) -> PowderLoad:
        """Return the full load of a container or a body; one that carries no powder pours none."""
        return cls(carrier.flow, carrier.powder) if carrier.capacity else cls(0.0, math.inf)

    @property
    def left(self) -> float:
        """Powder that is left, kg; below 0 where more left than a full container holds."""
        return self.full - self.poured

    @property
    def gone(self) -> float:
        """Mass that has left a full container, kg."""
        return min(self.poured, self.full)

    def pour(self, valve: float, dt: float) -> None:
        """Subtract the powder that leaves in *dt*, s, through a *valve* opened by a share from 0 to 1."""
        self.poured += self.flow * valve * dt

    def refill(self) -> None:
        """Fill the container with powder."""
        self.poured = 0.0

    def follow(self, orders: Iterable[Order], command: Command | None, dt: float) -> None:
        """Process one step of a log: a refill that was carried out counts before the flow through the valve."""
        if any(order.kind is OrderKind.REFILLED and not order.refusal for order in orders):
            self.refill()
        if command is not None:
            self.pour(command.valve, max(dt, 0.0))
