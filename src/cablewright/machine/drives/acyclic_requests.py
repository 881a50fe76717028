"""Acyclic requests to drives: single objects read or written outside the bus cycles, on any bus."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, Protocol

from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.axis import Axis
from cablewright.machine.drives.cia402 import DISABLE_OPERATION, ENERGISED, PowerState, state_of
from cablewright.machine.drives.object_transfers import Transfer
from cablewright.machine.drives.parameters import RAMP_AND_OFF, ObjectParameter, speed_limit

_POLL: Final = 0.01  # s


class Carrier(Protocol):
    """Interface of a bus that carries out acyclic transfers of drives."""

    def now(self) -> float:
        """The time by the bus's clock, s."""

    def wait(self, seconds: float) -> None:
        """Wait until the given time of the bus's clock, s."""

    def finish(self, axis: Axis) -> None:
        """Finish all waiting transfers of drive parameters, however long they take."""


def bring_off(carrier: Carrier, axes: Sequence[Axis], limit: float) -> None:
    """Stop drives that an earlier program left under torque, by ramp and brake, before their settings are changed.

    Raises `EnvironmentFault` for one that is still under torque after *limit*, s.
    """
    left = [axis for axis in axes if _power(carrier, axis) in ENERGISED]
    for axis in left:
        ramp = axis.transfers.add(Transfer(o.DISABLE_OPTION, RAMP_AND_OFF))
        carrier.finish(axis)
        if not ramp.failure:
            axis.transfers.add(Transfer(o.CONTROLWORD, DISABLE_OPERATION))
            carrier.finish(axis)
    end = carrier.now() + limit
    while left and carrier.now() < end:
        carrier.wait(_POLL)
        left = [axis for axis in left if _power(carrier, axis) in ENERGISED]
    if left:
        why = "it was left under torque, and it does not switch off on request: use the emergency stop"
        raise EnvironmentFault(f"the drive of line {left[0].name} (node {left[0].node}): {why}")


def _power(carrier: Carrier, axis: Axis) -> PowerState:
    """The state of a drive by request; one that does not answer counts as enabled."""
    word = axis.transfers.add(Transfer(o.STATUSWORD))
    carrier.finish(axis)
    return PowerState.ENABLED if word.failure else state_of(word.result)


def read_back(
    carrier: Carrier, axes: Sequence[Axis], wanted: Callable[[Axis], list[ObjectParameter]]
) -> dict[str, list[tuple[ObjectParameter, int | None]]]:
    """Return the parameters to write with the present value of each drive, by line; None: a drive lacks the object."""
    found = {}
    for axis in axes:
        lasting = [each for each in wanted(axis) if each.lasts]
        read = [axis.transfers.add(Transfer(each.object)) for each in lasting]
        carrier.finish(axis)
        values = [None if each.failure else each.result for each in read]
        found[axis.name] = list(zip(lasting, values, strict=True))
    return found


def begin_speed_limits(axes: Sequence[Axis], tension: Sequence[bool], tension_speed: float) -> None:
    """Begin to limit the speed of each drive, for torque mode where *tension*: *tension_speed*, m/s of its cable."""
    for axis, slow in zip(axes, tension, strict=True):
        scale = axis.scale
        most = min(tension_speed / scale.radii[1], scale.max_speed) if slow else scale.max_speed
        axis.failure = ""
        axis.check([speed_limit(scale, most)], write=True)


def require_agreed(axis: Axis) -> None:
    """Raise `InputError` for a drive with a wrong parameter."""
    if axis.failure:
        raise InputError(f"the drive of line {axis.name} (node {axis.node}): {axis.failure}")
