"""Every transition between the states of a machine and its print: one table, from which the docs are drawn.

A machine begins in `PrintState.FAULT`. Whatever is not in the table has no effect. No state in which a person may be
near the machine ends by itself: it takes an order, or `Happening.MAY_RESUME`, which takes one too unless only the
position was lost.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from types import MappingProxyType
from typing import Final

from cablewright.foundation.signals import OrderKind, PrintState


class Happening(StrEnum):
    """Events besides orders that change the state of a print."""

    DANGER = "the guard or a hard limit stops it"
    SOFT_LIMIT = "a soft limit is reached"
    PERSON = "somebody is in the light barrier, or it is not read"
    POSITION_LOST = "the position is not known"
    POWDER_LOW = "powder is low or out"
    MAY_RESUME = "resumption was ordered and the light barrier is free, or the position is known again"
    ARRIVED = "the platform is where the path continues, and its position has settled"
    PATH_END = "the path ends"
    DONE = "the procedure or the manual motion is done"
    FAILED = "the procedure fails"


Event = OrderKind | Happening
_S, _O, _H = PrintState, OrderKind, Happening


def _rows(states: Iterable[PrintState], event: Event, then: PrintState) -> dict[tuple[PrintState, Event], PrintState]:
    return {(state, event): then for state in states}


_PRINTS: Final = (_S.READY, _S.PRINTING)
_WAITS: Final = (_S.PAUSED, _S.REFILLING, _S.STOPPED)
_HANDLES: Final = (_S.TENSIONING, _S.HOMING, _S.MANUAL)

TRANSITIONS: Final = MappingProxyType(
    _rows(_S, _O.EMERGENCY, _S.FAULT)
    | _rows(_S, _H.DANGER, _S.FAULT)
    | {(_S.FAULT, _O.RESET): _S.OFF}
    | {(_S.OFF, _O.ENABLE): _S.IDLE, (_S.IDLE, _O.RELEASE): _S.OFF}
    | {(_S.IDLE, _O.TAKE_UP): _S.TENSIONING, (_S.IDLE, _O.HOME): _S.HOMING}
    | _rows((_S.IDLE, _S.MANUAL), _O.JOG, _S.MANUAL)
    | _rows((_S.IDLE, _S.MANUAL), _O.GO_TO, _S.MANUAL)
    | _rows((_S.IDLE, _S.MANUAL), _O.PARK, _S.MANUAL)
    | _rows(_HANDLES, _H.DONE, _S.IDLE)
    | _rows(_HANDLES, _H.FAILED, _S.IDLE)
    | _rows(_HANDLES, _H.SOFT_LIMIT, _S.IDLE)
    | _rows(_HANDLES, _H.PERSON, _S.IDLE)
    | _rows(_HANDLES, _O.STOP, _S.IDLE)
    | _rows(_HANDLES, _O.PAUSE, _S.IDLE)
    | {(_S.MANUAL, _H.POSITION_LOST): _S.IDLE}
    | {(_S.IDLE, _O.START): _S.READY, (_S.READY, _H.ARRIVED): _S.PRINTING, (_S.PRINTING, _H.PATH_END): _S.IDLE}
    | _rows((*_PRINTS, _S.PAUSED), _O.PAUSE, _S.PAUSED)
    | {(_S.REFILLING, _O.PAUSE): _S.REFILLING, (_S.STOPPED, _O.PAUSE): _S.STOPPED}
    | _rows((*_PRINTS, _S.PAUSED), _H.PERSON, _S.PAUSED)
    | {(_S.PRINTING, _H.POSITION_LOST): _S.PAUSED}
    | _rows(_PRINTS, _H.POWDER_LOW, _S.REFILLING)
    | _rows(_PRINTS, _H.SOFT_LIMIT, _S.STOPPED)
    | _rows((*_PRINTS, *_WAITS), _O.STOP, _S.STOPPED)
    | _rows(_WAITS, _H.MAY_RESUME, _S.READY)
    | {(_S.STOPPED, _O.RESET): _S.IDLE}
)
"""The state after each event that changes one."""
