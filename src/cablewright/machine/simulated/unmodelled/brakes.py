"""Brakes that slip: a closed one holds its drum up to a torque, and slips beyond it until the line's pull falls.

Coulomb friction, at rest as in motion, of a drum without inertia: the kernel pays out the length that a line between
fixed ends would need to be held, and the distance that the platform moves away besides. In the quasi-static plant,
where it moves as far as lines let it, a line is as soft as its last slip has shown. A brake only takes energy. The drum
turns its motor, so that encoders count the way.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.signals import Condition, Notice
from cablewright.kernels.plant import winding
from cablewright.machine.drives.unexpected_motion import astray, slipping
from cablewright.machine.simulated.as_built_parts import BRAKES, drawn
from cablewright.machine.simulated.unmodelled.effect_sizes import WinchBrakes, of_lines
from cablewright.machine.simulated.winches import Winches

_GROWS: Final = 4.0  # in a step, of how much softer a line is taken for
_MOST: Final = 0.02  # m that a line may be let out in a step, if its brake held nothing


class Brakes:
    """The simulated brakes of m winches, open at first."""

    SAVED = ("_softer",)

    def __init__(self, law: WinchBrakes, names: tuple[str, ...], seed: int, limit: float) -> None:
        """*names* (m,) of the lines; *limit*: m of cable by which one may slip without a notice.

        Raises `UnknownName` for a line.
        """
        uneven = 1.0 + law.spread * drawn(seed, BRAKES).uniform(-1.0, 1.0, len(names))
        self.torques = np.array(of_lines(names, law.by_line, law.torque)) * uneven
        """What each holds, (m,) N m; 0: it holds whatever pulls."""
        self._names, self._limit = names, limit
        self._softer = np.ones(len(names))  # than between fixed ends

    def close(self, closed: Mask, winches: Winches, softness: Array) -> None:
        """Close the brakes that are *closed* (m,), open the others.

        *softness* (m,): m/N, of lines per pull on drums. A drum with several lines is as stiff as all of them together.
        """
        if not winches.lines.plain:
            stiffness = np.abs(winches.lines.senses) @ (1.0 / softness)
            softness = softness.copy()
            softness[winches.lines.hosts] = 1.0 / stiffness
        winches.set_brakes(np.where(closed, self.torques, 0.0), softness)

    def yield_by_secants(self, winches: Winches, pulls: Array) -> None:
        """Update the lines' softness from their last slip, by the *pulls* (m,), N, at the winches since.

        Of a drum with several lines by the pull of all.
        """
        was, radii, hosts = winches.state, winches.leaving_radii, winches.lines.hosts
        if not winches.lines.plain:
            pulls[hosts] = winches.lines.torques(pulls, radii) / radii[hosts]
        slipped, fell = was[:, winding.SLIP], was[:, winding.PULL] - pulls
        soft = np.maximum(was[:, winding.SOFT], 1e-12)
        seen = np.where(fell > 0.0, slipped / np.maximum(fell, 1e-9), np.inf) / soft
        most = np.minimum(_GROWS * self._softer, _MOST / np.maximum(pulls, 1.0) / soft)
        self._softer = np.where(slipped > 0.0, np.maximum(np.minimum(seen, most), 1.0), 1.0)
        was[:, winding.SOFT] *= self._softer
        was[:, winding.PULL] = 0.0  # nothing has a speed

    def forget(self, winches: Winches) -> None:
        """Restart the count of slip at the present angles of the drums, when a person orders a reset."""
        winches.slipped[:] = 0.0

    def notices(self, winches: Winches) -> list[Notice]:
        """Return a notice for each winch that slipped too far since the last reset, as a machine with drives does."""
        lengths = winches.slipped * winches.leaving_radii
        worst = int(np.argmax(lengths))
        if lengths[worst] <= self._limit:
            return []
        return [Notice(Condition.BRAKE, slipping(astray(self._names[worst], lengths[worst])))]
