"""Corrections of the rigid platform's estimator, a module for each kind of sensor.

Modules are found, not listed.
"""

from __future__ import annotations

from typing import Final

from cablewright.estimation.body.updates.cells import Cells
from cablewright.estimation.body.updates.update import Update
from cablewright.foundation.discovery import modules_of

modules_of(__name__, __path__)

UPDATES: Final[tuple[type[Update], ...]] = tuple(
    sorted(Update.__subclasses__(), key=lambda kind: (kind is not Cells, kind.READING.SOURCES[0].stream))
)
"""All kinds by the streams of their sensors; cells come first: `diagnosis` finds their innovations by it."""
