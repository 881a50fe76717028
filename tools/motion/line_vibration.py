"""How far the own vibration of lines moves the slowest mode of a platform: against a fine mesh of lumped masses.

    python -m tools.motion.line_vibration

A point hangs in the middle of four lines whose exit points are the corners of a rectangle, a third of its side above
it; side and mass differ. Each line of the mesh has 40 pieces, straight springs between lumped masses; its equilibrium
and its small vibrations are those of that mesh alone. The model has lines without mass and the stiffness of catenaries.
"""

from __future__ import annotations

import sys
from itertools import pairwise
from typing import Final

import numpy as np

from cablewright.analyses.modes import modes
from cablewright.foundation.arrays import Array
from cablewright.models.fidelity import Fidelity, SheaveLaw
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

CASES: Final = (
    *((8.0, 1600.0), (16.0, 1600.0), (8.0, 400.0), (24.0, 800.0), (16.0, 400.0), (8.0, 240.0), (8.0, 200.0)),
    *((8.0, 150.0), (8.0, 100.0), (16.0, 150.0), (16.0, 100.0), (24.0, 100.0), (32.0, 100.0), (64.0, 100.0)),
)  # side, m, and mass, kg
PIECES: Final = 40
DENSITY: Final = 0.14  # kg/m, of a steel cable of 6 mm
STIFFNESS: Final = 1.8e6  # N, modulus times section
GRAVITY: Final = 9.81  # m/s^2
STEPS: Final = 60
SHARE: Final = 0.3  # of a mode's energy that the platform has at least, to be a mode of the platform


def square(side: float, mass: float) -> Robot:
    """The robot with that *side*, m, and *mass*, kg."""
    height = side / 3.0
    corners = [(x * 0.5 * side, y * 0.4 * side, height) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    cable = {"young_modulus": STIFFNESS / 1e-5, "section": 1e-5, "linear_density": DENSITY, "breaking_load": 1e6}
    line = {"cable": cable, "sheave": {"kind": "eyelet"}, "tension_limits": [20.0, 1e5]}
    lines = [line | {"name": str(k), "exit_point": corner} for k, corner in enumerate(corners)]
    return Robot.model_validate(
        {
            "schema": 1,
            "name": "square",
            "scene": {"gravity": GRAVITY, "frame_min": [-side] * 3, "frame_max": [side] * 3},
            "platform": {"kind": "point", "mass": mass},
            "lines": lines,
        }
    )


class Mesh:
    """Nodes of lines from their exit points to the platform, which is the last node (3,)."""

    def __init__(self, exits: Array, platform: Array, lengths: Array, mass: float) -> None:
        """*exits* (m, 3), m; *lengths* (m,), m, not stretched; *mass*: of the platform, kg."""
        inner = np.linspace(0.0, 1.0, PIECES + 1)[1:-1, None]
        chains = [begin + inner * (platform - begin) for begin in exits]
        self.exits, self.rest = exits, lengths / PIECES
        self.places = np.concatenate([*chains, platform[None]])
        self.masses = np.append(np.repeat(DENSITY * self.rest, PIECES - 1), mass + 0.5 * DENSITY * self.rest.sum())

    def pieces(self) -> list[tuple[int, int, float]]:
        """Nodes at both ends of each piece, negative for exit points, and its length without stretch, m."""
        found, last = [], len(self.places) - 1
        for line, rest in enumerate(self.rest):
            chain = [-1 - line, *range(line * (PIECES - 1), (line + 1) * (PIECES - 1)), last]
            found += [(one, other, float(rest)) for one, other in pairwise(chain)]
        return found

    def forces(self) -> tuple[Array, Array]:
        """Forces (n, 3), N, on the nodes, and their stiffness (3n, 3n), N/m."""
        force = np.zeros_like(self.places)
        force[:, 2] = -GRAVITY * self.masses
        size = 3 * len(self.places)
        stiffness = np.zeros((size, size))
        for one, other, rest in self.pieces():
            here = self.places[one] if one >= 0 else self.exits[-1 - one]
            way = self.places[other] - here
            length = float(np.linalg.norm(way))
            along = way / length
            pull = STIFFNESS * (length / rest - 1.0)
            outer = np.outer(along, along)
            block = STIFFNESS / rest * outer + max(pull, 0.0) / length * (np.eye(3) - outer)
            for node, sign in ((one, 1.0), (other, -1.0)):
                if node < 0:
                    continue
                force[node] += sign * pull * along
                rows = slice(3 * node, 3 * node + 3)
                stiffness[rows, rows] += block
                across = other if node == one else one
                if across >= 0:
                    stiffness[rows, 3 * across : 3 * across + 3] -= block
        return force, stiffness

    def settle(self) -> None:
        """Come to rest, by damped Newton steps."""
        for step in range(STEPS):
            force, stiffness = self.forces()
            stiffness[np.diag_indices_from(stiffness)] += 1e3 * 0.5**step
            move = np.linalg.solve(stiffness, force.ravel()).reshape(-1, 3)
            self.places += move * min(1.0, 0.1 / float(np.abs(move).max()))
            if np.abs(move).max() < 1e-10:
                return
        raise RuntimeError("the mesh does not settle")

    def modes(self) -> tuple[Array, Array]:
        """Frequencies, Hz, and the share of each mode's energy of motion that the platform has."""
        roots = np.repeat(np.sqrt(self.masses), 3)
        squares, shapes = np.linalg.eigh(self.forces()[1] / roots[:, None] / roots)
        return np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi), (shapes[-3:] ** 2).sum(axis=0)


def compared(side: float, mass: float) -> tuple[float, float, float, float]:
    """First own frequency of a line, the model's slowest mode and that of the mesh, Hz; and the platform's share."""
    robot = square(side, mass)
    held = solve_inverse(Model(robot, Fidelity(sheave=SheaveLaw.EYELET)), np.zeros((1, 3)))
    mesh = Mesh(np.array([line.exit_point for line in robot.lines]), np.zeros(3), held.lengths[0], mass)
    mesh.settle()
    found, (rates, shares) = modes(held), mesh.modes()
    first = int(np.flatnonzero(shares > SHARE)[0])
    return float(found.line_frequencies.min()), float(found.lowest[0]), float(rates[first]), float(shares[first])


def main() -> None:
    """Print the table."""
    write = sys.stdout.write
    write("| span, m | mass, kg | own frequency, Hz | slowest mode, Hz | ratio | by the mesh, Hz | error | share |\n")
    write("| --- | --- | --- | --- | --- | --- | --- | --- |\n")
    for side, mass in CASES:
        own, slowest, found, share = compared(side, mass)
        span = side * float(np.linalg.norm((0.5, 0.4, 1.0 / 3.0)))
        write(f"| {span:.1f} | {mass:g} | {own:.2f} | {slowest:.3f} | {own / slowest:.2f} | {found:.3f} | ")
        write(f"{slowest / found - 1.0:+.1%} | {share:.0%} |\n")


if __name__ == "__main__":
    main()
