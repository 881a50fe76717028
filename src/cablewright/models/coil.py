"""Cable on a winch drum, turn by turn in layers: radius, length and position of each turn."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.kernels.plant import winding

TURN = 2.0 * np.pi

MAX_TURNS: Final = 200_000


@dataclass(frozen=True, eq=False)
class Coil:
    """The cable wound on a winch drum, turn by turn from the bare core; radius and position are interpolated.

    Angles are the drum's, rad, 0 for the empty drum. Read-only arrays.
    """

    radii: Array  # (k,) m: to the cable's axis after each turn
    wound: Array  # (k,) m: cable on the drum after each turn, wound[0] = 0
    sideways: Array  # (k,) m: position of the cable along the drum, from its middle, after each turn

    def radius(self, angle: float) -> float:
        """Return the radius (m) at which the cable leaves the drum with *angle* wound."""
        return float(np.interp(angle / TURN, np.arange(len(self.radii)), self.radii))

    def length(self, angle: float) -> float:
        """Return the length of cable (m) on the drum with *angle* wound. Raises `InputError` beyond the last turn."""
        turns = angle / TURN
        if not 0.0 <= turns <= len(self.radii) - 1:
            raise InputError(
                f"{angle:g} rad of cable wound on the winch drum; it holds 0 to {TURN * (len(self.radii) - 1):g} rad"
            )
        whole = min(int(turns), len(self.radii) - 2)
        share = turns - whole
        rise = self.radii[whole + 1] - self.radii[whole]
        return float(self.wound[whole] + TURN * share * (self.radii[whole] + 0.5 * share * rise))

    def angle(self, length: float) -> float:
        """Return the angle that winds *length* (m) of cable. Raises `InputError` for more than the drum holds."""
        if not 0.0 <= length <= self.wound[-1]:
            raise InputError(f"{length:g} m of cable wound on the winch drum; it holds 0 to {self.wound[-1]:g} m")
        whole = min(int(np.searchsorted(self.wound, length, side="right")) - 1, len(self.radii) - 2)
        begin, rise = self.radii[whole], self.radii[whole + 1] - self.radii[whole]
        rest = (length - self.wound[whole]) / TURN
        # rest = share (begin + share rise / 2), written without the cancellation of a small rise
        share = 2.0 * rest / (begin + np.sqrt(begin * begin + 2.0 * rise * rest))
        return float(TURN * (whole + share))


@dataclass(frozen=True, eq=False)
class LineCoils:
    """The cables of m lines on their drums, each coil with the part of *held* m of cable that its line does not use.

    ``coils``: (m,); None: of a line without a winch, whose angle is 0 and whose radius is NaN.
    """

    coils: tuple[Coil | None, ...]
    held: float

    def angles(self, lengths: Array) -> Array:
        """Return the wound angles (m,), rad, of the winch drums with *lengths* (m,), m, paid out.

        Raises `InputError`.
        """
        outs = zip(self.coils, lengths.tolist(), strict=True)
        return np.array([0.0 if coil is None else coil.angle(self.held - out) for coil, out in outs])

    @cached_property
    def tables(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """Radii and wound lengths (m, k), m, after each of so many turns (m,); 0 turns: of a line without a winch."""
        turns = np.array([0 if coil is None else len(coil.radii) - 1 for coil in self.coils])
        radii, wound = np.zeros((2, len(turns), int(turns.max(initial=0)) + 1))
        for i, coil in enumerate(self.coils):
            if coil is not None:
                radii[i, : turns[i] + 1], wound[i, : turns[i] + 1] = coil.radii, coil.wound
        return radii, wound, turns

    def paid(self, before: Array, now: Array) -> Array | None:
        """Return the lengths (m,), m, paid out between two wound angles (m,), rad; None: beyond a drum's turns."""
        found = np.empty(len(self.coils))
        return found if winding.paid_out(*self.tables, before, now, found) else None

    def radii(self, angles: Array) -> Array:
        """Return the radius (m,), m, at which each line leaves its drum with *angles* (m,), rad, wound up."""
        (radii, _, turns), found = self.tables, np.empty(len(self.coils))
        winding.radii_by(radii, turns, angles, found)
        return found


def wind(
    capacity: float,
    core: float,
    width: float,
    diameter: float,
    pitch: float,
    *,
    growth: float = 0.0,
    random: np.random.Generator | None = None,
    radius_walk: float = 0.0,
    sideways_walk: float = 0.0,
    memory: float = 1.0,
) -> Coil:
    """Wind at least *capacity* (m) of cable of that *diameter* (m) on a drum of that *width* (m), to and fro.

    *core*: radius of the first layer's cable axis; *pitch*: increase of the radius per layer; *growth*: besides, per
    turn, m. With *random*, radius and position of each turn deviate by first-order Gauss-Markov processes of standard
    deviations *radius_walk* and *sideways_walk* with a correlation length of *memory* turns. Raises `InputError` for a
    drum too narrow for one turn, a *radius_walk* over a sixth of the radius, or too many turns.
    """
    per_layer = turns_per_layer(width, diameter)
    if per_layer < 1:
        raise InputError(f"width = {width:g} m: too narrow for one turn of a cable of {diameter:g} m")
    if not core > 6.0 * radius_walk:
        raise InputError(f"radius_walk = {radius_walk:g} m: must be under a sixth of the drum's radius, {core:g} m")
    turns = int(min(np.ceil(capacity / (TURN * (core - 3.0 * radius_walk))), MAX_TURNS)) + 2
    if turns > MAX_TURNS:
        raise InputError(
            f"{capacity:g} m of cable on a winch drum of radius {core:g} m take more than {MAX_TURNS} "
            f"turns, the maximum; give a larger drum_radius or a smaller capacity"
        )
    index = np.arange(turns + 1)
    layer, place = np.divmod(index, per_layer)
    across = (place + 0.5) / per_layer - 0.5
    sideways = width * np.where(layer % 2 == 0, across, -across)
    radii = core + pitch * layer + growth * index
    if random is not None:
        radii = radii + radius_walk * _walk(len(index), memory, random)
        sideways = np.clip(sideways + sideways_walk * _walk(len(index), memory, random), -0.5 * width, 0.5 * width)
    wound = np.concatenate([[0.0], np.cumsum(0.5 * TURN * (radii[:-1] + radii[1:]))])
    for column in (radii, wound, sideways):
        column.flags.writeable = False
    return Coil(np.asarray(radii), wound, np.asarray(sideways))


def turns_per_layer(width: float, diameter: float) -> int:
    """Return how many turns of a cable of that *diameter* fit side by side on a drum of that *width*, m."""
    return int(width / diameter + 1e-9)


def _walk(count: int, memory: float, random: np.random.Generator) -> Array:
    """Return a first-order Gauss-Markov process (count,) of standard deviation 1, correlated over *memory* steps."""
    keep = float(np.exp(-1.0 / memory))
    walk = random.standard_normal(count)
    walk[1:] *= np.sqrt(1.0 - keep * keep)
    for k in range(1, count):
        walk[k] += keep * walk[k - 1]
    return walk
