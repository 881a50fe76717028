"""A surveyor with a total station, made up: true places, the shots at them, and the files they become."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from oracles.room import EAST, NORTH, WEST

ARCSEC = math.radians(1 / 3600)
EXITS = {1: (-2.5, -5.0, 4.03), 2: (2.4, -5.0, 4.02), 3: (2.4, 5.0, 4.05), 4: (-2.5, 5.0, 4.04)}
"""Exit points of a machine like Merlet's in the room of `oracles.room`, m; winches straight below."""


@dataclass(frozen=True)
class Site:
    """True places of markers by name, in the room's frame, and how the instrument stands in it."""

    markers: Mapping[str, tuple[float, float, float]]
    station: tuple[float, float, float] = (0.1, -0.2, 1.5)
    turned: float = 0.7  # rad, of the instrument's circle

    def to_grid(self, place) -> np.ndarray:
        """From the room's frame to the instrument's: z up, origin at its axis."""
        c, s = math.cos(self.turned), math.sin(self.turned)
        x, y, z = np.subtract(place, self.station)
        return np.array([c * x - s * y, s * x + c * y, z])


def site(**changes) -> Site:
    """The markers that docs/survey.md speaks of: two a wall, two about each exit and winch, floor, one sheave."""
    markers = {
        "WEST1": (WEST, -3.1, 1.2), "WEST2": (WEST, 3.4, 1.4), "EAST1": (EAST, -3.3, 1.1), "EAST2": (EAST, 3.2, 1.3),
        "EAST3": (EAST, -1.8, 3.2), "NORTH1": (-1.8, NORTH, 1.0), "NORTH2": (1.9, NORTH, 1.4),
        "FLOOR1": (0.9, 0.6, 0.0), "FLOOR2": (-1.2, -1.4, 0.0),
    }  # fmt: skip
    for line, (x, y, z) in EXITS.items():
        if line != 4:
            markers |= {f"X{line}-1": (x - 0.06, y, z + 0.05), f"X{line}-2": (x + 0.06, y, z + 0.05)}
        markers |= {f"W{line}-1": (x - 0.08, y, 0.15), f"W{line}-2": (x + 0.08, y, 0.15)}
    x, y, z = EXITS[4]
    for i, turn in enumerate((-0.2, 0.5, 1.2, 1.9, 2.6), 1):  # a mark on the swinging sheave of line 4
        markers[f"A4-{i}"] = (x + 0.09 * math.cos(turn - 1.6), y + 0.09 * math.sin(turn - 1.6), z - 0.04)
    for i, turn in enumerate((0.0, 1.3, 2.5, 3.8, 5.0), 1):  # a mark on its side as it turns
        markers[f"S4-{i}"] = (x + 0.0375 + 0.03 * math.cos(turn), y, z + 0.03 * math.sin(turn))
    return Site(markers, **changes)


def polar(site: Site, rng: np.random.Generator, angle: float = 5 * ARCSEC, distance: float = 2e-3, ppm: float = 2.0):
    """One shot at each marker: (name, circle, zenith angle, slope distance), rad and m, with the instrument's noise."""
    rows = []
    for name, place in site.markers.items():
        x, y, z = site.to_grid(place)
        slope = math.sqrt(x * x + y * y + z * z)
        hz, v = math.atan2(x, y) % math.tau, math.acos(z / slope)
        noise = rng.normal(size=3)
        sigma = distance + 1e-6 * ppm * slope
        rows.append((name, hz + angle * noise[0], v + angle * noise[1], slope + sigma * noise[2]))
    return rows


def csv(rows) -> str:
    """Shots as a CSV in gon."""
    gon = 200 / math.pi
    lines = ["point,hz (gon),v (gon),slope (m)"]
    lines += [f"{name},{hz * gon % 400:.5f},{v * gon:.5f},{slope:.5f}" for name, hz, v, slope in rows]
    return "\n".join(lines) + "\n"


def gsi(rows, wide: bool = False, height: float | None = None) -> str:
    """Shots as Leica writes them in gon and tenths of a millimetre, GSI-8 or GSI-16; a station block first."""
    places, star = (16, "*") if wide else (8, "")

    def word(index: int, information: str, value: int) -> str:
        return f"{index}{information}{'-' if value < 0 else '+'}{abs(value):0{places}d}"

    gon = 200e5 / math.pi
    lines = []
    if height is not None:
        station = [word(index, "..16", 0) for index in (84, 85, 86)]
        lines.append(
            " ".join([f"{star}110001+{'STATION':0>{places}}", *station, word(88, "..16", round(1e4 * height))])
        )
    for i, (name, hz, v, slope) in enumerate(rows, 2):
        words = [
            f"{star}11{i % 10000:04d}+{name:0>{places}}",
            word(21, ".322", round(hz * gon) % 40_000_000),
            word(22, ".322", round(v * gon)),
            word(31, "..06", round(1e4 * slope)),
        ]
        lines.append(" ".join(words))
    return " \n".join(lines) + " \n"
