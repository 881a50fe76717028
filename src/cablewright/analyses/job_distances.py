"""Distances of lines along a job whose part grows, computed block by block."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.interference import (
    DEFAULT,
    KINDS,
    Contact,
    Interference,
    InterferenceSettings,
    NearestContacts,
    distances,
)
from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import MEMORY, Room, let_go, of_rows
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.models.obstacles import Obstacle, of_beads, of_mesh
from cablewright.models.statics import Equilibrium
from cablewright.printing.beads import Beads
from cablewright.printing.growing_part import deposit
from cablewright.printing.path import Samples
from cablewright.robot import Robot

PART = KINDS.index("part")


@dataclass(frozen=True, eq=False)
class Clearances:
    """Smallest distances of lines from obstacles at k samples of a job, as a check stores them."""

    smallest: Array  # (k,) m; inf where there is nothing, NaN where no line is known
    nearest: Contact | None  # of all; its row is the sample


@dataclass
class JobDistances:
    """Distances of lines at k samples of a job, taken block by block: margins, status codes, and the nearest contacts.

    ``now`` (k,): how much of the part exists at each sample, as `distances` takes it.
    """

    part: Obstacle
    now: Array
    settings: InterferenceSettings
    margins: Array  # (k, 4) as `Interference.margins`
    codes: NDArray[np.int64]  # (k,)
    bound: float = 0.0
    contacts: NearestContacts = field(default_factory=NearestContacts)
    closest: Interference | None = None

    @classmethod
    def of(
        cls,
        robot: Robot,
        beads: Beads,
        samples: Samples,
        mesh: TriangleMesh | None = None,
        settings: InterferenceSettings = DEFAULT,
        room: Room = MEMORY,
    ) -> Self:
        """Return the empty distances before the first block of samples.

        The part is the *mesh*, or else the *beads* that *robot* lays. *room*: folder for all arrays.
        """
        if mesh is None:
            laid = deposit(samples, beads, room, robot.platform.lays_along)
            part, now = of_beads(laid, room), np.arange(len(samples), dtype=np.float64)
        else:
            part, now = of_mesh(mesh), _grown(samples)
        margins = room.empty((len(samples), 4))
        margins[:] = np.nan
        let_go((margins, samples))
        return cls(part, now, settings, margins, np.zeros(len(samples), dtype=np.int64))

    def take(self, held: Equilibrium, first: int) -> None:
        """Add a block of solved rows, whose first is sample *first*."""
        block = slice(first, first + len(held))
        found = distances(held, part=self.part, now=self.now[block], settings=self.settings)
        self.margins[block], self.codes[block] = found.margins, held.judged_code
        let_go((self.margins, self.part))
        self.bound = max(self.bound, float(np.max(found.bounds, initial=0.0, where=np.isfinite(found.bounds))))
        known = self.nearest
        self.contacts = NearestContacts(*map(partial(_nearer, first=first), self.contacts, found.contacts))
        worst = found.nearest()
        if worst is not None and (known is None or worst.margin < known.margin):
            self.closest = found[worst.row]

    @property
    def nearest(self) -> Contact | None:
        """Return the contact with the smallest distance along the job; None if there is none."""
        return min((each for each in self.contacts if each is not None), key=lambda each: each.margin, default=None)

    @property
    def clearances(self) -> Clearances:
        """Return the smallest distances without the description of the part, which takes more memory."""
        return Clearances(of_rows(np.minimum, self.margins), self.nearest)


def _nearer(known: Contact | None, here: Contact | None, first: int) -> Contact | None:
    """Return the nearer of a *known* contact and one of a block whose first row is sample *first*."""
    if here is None or (known is not None and known.margin <= here.margin):
        return known
    return replace(here, row=here.row + first)


def _grown(samples: Samples) -> Array:
    """Height (k,) up to which material lies at each sample, m."""
    laid = np.where(samples.extruding, samples.positions[:, 2], -np.inf)
    return np.asarray(np.maximum.accumulate(laid))
