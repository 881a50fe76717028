"""Paty et al. 2021, section 4, beside cablewright: Table 1, the regions, the planes, the helix, the workspace.

Set A is the text as it stands. The other sets change what the paper leaves open or what its own numbers contradict;
they were chosen after seeing its numbers, so where they agree at P1 they were made to.
"""

from dataclasses import dataclass

import numpy as np

import cablewright as cw

P1, P2 = [0.0, 0.0, 0.0], [0.0, 0.0, 13.25]
PRINTER = (20.0, 5150.0)  # N: the limits of house-printer; the paper's lowest, 510 N, excludes its planes and helix
PLANE = 6.75  # m: how far out the paper's own poses go


@dataclass
class Set:
    """One reading of the paper."""

    name: str
    section: float  # mm^2
    moduli: tuple[float, float]
    dead_elastic: bool = True
    corner: float = 7.5  # m: distance of the exit points from the middle, along x and y

    def robot(self) -> cw.Robot:
        """paty2021 as this set reads it."""
        robot = cw.load("paty2021")
        cable = robot.lines[0].cable.model_copy(update={"section": 1e-6 * self.section})
        changes = {"cable": cable, "dead_elastic": self.dead_elastic}
        scale = np.array([self.corner / 7.5, self.corner / 7.5, 1.0])
        lines = []
        for line in robot.lines:
            points = {key: tuple(scale * getattr(line, key)) for key in ("exit_point", "winch_exit")}
            lines.append(line.model_copy(update=changes | points))
        return robot.model_copy(update={"lines": tuple(lines)})


SETS = (
    Set("A", 4.0 * np.pi, (0.7, 1.3)),
    Set("A2", 12.27, (2 / 3, 4 / 3)),
    Set("B", 6.75, (0.7, 1.3), dead_elastic=False),
    Set("B2", 6.75, (2 / 3, 4 / 3), dead_elastic=False),
    Set("C", 6.32, (2 / 3, 4 / 3), dead_elastic=False, corner=7.0),
)


def at_poses(robot: cw.Robot, ranges: tuple[cw.Range, ...]) -> list[float]:
    """Table 1 and the regions."""
    figures = []
    for pose in (P1, P2):
        found = cw.accuracy(robot, pose, ranges)
        row, spread = found.accuracy, found.accuracy.spread
        figures += [1e3 * x[0] for x in (row.nominal_error, spread.max_error, row.difference, spread.max_deviation)]
        figures.append(1e6 * found.region.hull.volume)
    return figures


def on_planes(robot: cw.Robot, ranges: tuple[cw.Range, ...]) -> list[float]:
    """Vertical errors at 0 and 7.5 m; what the lower half has left, at worst also under tensions chosen to hold it."""
    vertical, difference, left = [], [], []
    for height in np.linspace(0.0, 7.5, 6):
        plane = cw.Places.plane(robot, height, PLANE, PLANE / 10)
        found = cw.accuracy(robot, plane, ranges, tension_limits=PRINTER).accuracy
        vertical.append(-1e3 * np.nanmin(found.spread.low[:, 2]))
        difference.append(1e3 * np.nanmax(found.difference))
        full = cw.accuracy(robot, plane, ranges, tension_limits=PRINTER, compensation="full").accuracy
        worst = np.nanargmax(full.spread.max_deviation)
        left.append((1e3 * full.spread.max_deviation[worst], full.wanted[worst]))
    most, place = max(left, key=lambda pair: pair[0])
    best = cw.accuracy(robot, place, ranges, tension_limits=PRINTER).best
    return [vertical[0], vertical[-1], max(difference), most, 1e3 * best.max_deviation]


def on_helix(robot: cw.Robot, ranges: tuple[cw.Range, ...]) -> list[float]:
    """The radius whose helix begins with 50 mm, as the paper's does, and the height where it reaches 270 mm."""
    radii = np.linspace(3.0, 7.0, 401)
    places = np.column_stack([radii, np.zeros((401, 2))])
    start = cw.accuracy(robot, cw.Places("path", places), ranges, tension_limits=PRINTER).accuracy.spread.max_error
    radius = float(np.interp(50e-3, start, radii))
    helix = cw.Places.helix(robot, radius, 0.5, 0.0, 14.0)
    errors = cw.accuracy(robot, helix, ranges, tension_limits=PRINTER).accuracy.spread.max_error
    return [radius, float(helix.positions[np.argmax(errors > 270e-3), 2])]


ROWS = (
    ("P1 nominal error, mm", "19.5", 1),
    ("P1 largest error, mm", "29.3", 1),
    ("P1 difference, mm", "9.8", 1),
    ("P1 largest deviation from nominal, mm", "-", 1),
    ("P1 region, cm^3", "3.126", 2),
    ("P2 nominal error, mm", "214.6", 1),
    ("P2 largest error, mm", "302.6", 1),
    ("P2 difference, mm", "88.3", 1),
    ("P2 largest deviation from nominal, mm", "-", 1),
    ("P2 region, cm^3", "151.3", 1),
    ("largest vertical error at 0 m, mm", "61", 1),
    ("largest vertical error at 7.5 m, mm", "40", 1),
    ("lower half, largest difference, mm", "28", 1),
    ("lower half, left with full compensation, mm", "28", 1),
    ("  there, tensions chosen to hold it best, mm", "-", 1),
    ("helix that begins with 50 mm: radius, m", "-", 2),
    ("that helix reaches 270 mm at height, m", "top", 2),
)


def components() -> None:
    """Components of the worst error along the helix (the paper's Fig. 12), set A."""
    robot = SETS[0].robot()
    radius = on_helix(robot, cw.modulus_ranges(robot))[0]
    print(f"\nset A, helix of {radius:.2f} m: mean worst error within 0.25 m of a height, horizontal and vertical, mm")
    helix = cw.Places.helix(robot, radius, 0.5, 0.0, 13.0)
    worst = cw.accuracy(robot, helix, tension_limits=PRINTER).accuracy.worst_offset
    for height in (0.0, 2.5, 5.0, 7.5, 10.0, 12.0, 13.0):
        near = np.abs(helix.positions[:, 2] - height) < 0.25
        xy, z = np.linalg.norm(worst[near, :2], axis=1).mean(), np.abs(worst[near, 2]).mean()
        print(f"{height:6.1f}  {1e3 * xy:6.1f}  {1e3 * z:6.1f}")


def surfaces() -> None:
    """Both surfaces of vertical error over the planes (the paper's Fig. 13), set A."""
    robot = SETS[0].robot()
    print("\nset A, vertical error over the planes, mm: height, lower surface, upper surface")
    for height in (0.0, 7.5):
        plane = cw.Places.plane(robot, height, PLANE, PLANE / 10)
        spread = cw.accuracy(robot, plane, tension_limits=PRINTER).accuracy.spread
        ends = [1e3 * end(z) for z in (spread.low[:, 2], spread.high[:, 2]) for end in (np.nanmin, np.nanmax)]
        print("{:6.1f} {:9.1f} to {:.1f} {:9.1f} to {:.1f}".format(height, *ends))


def workspace() -> None:
    """Where the smallest and the largest error are in the accessible workspace, set A under the paper's limits."""
    found = cw.accuracy(cw.load("paty2021"), cw.Places.workspace(0.5))
    row, ends = found.accuracy, found.workspace
    assert ends is not None
    print(f"\nset A, accessible under 0.51 to 5.15 kN: {ends.nodes.trapezoid_volume:.0f} m^3, ended by")
    for edge in ends.by_limit:
        print(f"  {edge.limit}: {edge.ends} times, from {edge.lowest[2]:.2f} to {edge.highest[2]:.2f} m high")
    nodes = found.places.positions[found.places.positions[:, 1] == 0.0]
    for height in (0.0, 7.5):
        print(f"  reach along x at {height} m: {nodes[nodes[:, 2] == height, 0].max():.1f} m")
    for what, at in (("smallest", row.spread.max_error.argmin()), ("largest", row.spread.max_error.argmax())):
        place = ", ".join(f"{x:.2f}" for x in row.wanted[at])
        print(f"  {what} largest error: {1e3 * row.spread.max_error[at]:.1f} mm at ({place})")
    held = cw.inverse(cw.load("paty2021"), [6.0, 6.0, 0.0])
    print(f"  at (6, 6, 0): {held.sentence()}")


def main() -> None:
    """Print all tables."""
    columns = []
    for reading in SETS:
        robot = reading.robot()
        ranges = cw.modulus_ranges(robot, *reading.moduli)
        columns.append(at_poses(robot, ranges) + on_planes(robot, ranges) + on_helix(robot, ranges))
    print(f"{'':<46}{'paper':>8}" + "".join(f"{reading.name:>8}" for reading in SETS))
    for (what, paper, digits), *values in zip(ROWS, *columns, strict=True):
        print(f"{what:<46}{paper:>8}" + "".join(f"{value:8.{digits}f}" for value in values))
    components()
    surfaces()
    workspace()
    shadow = cw.accuracy(cw.load("paty2021"), P1).region.hull.projections["xy"]
    print(f"\nset A, region at P1 seen from above: {len(shadow)} corners")


if __name__ == "__main__":
    main()
