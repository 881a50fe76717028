"""Figs. 10 to 13 of Paty et al. 2021, each a PDF: python examples/papers/paty2021_figures.py.

Set A of `paty2021.py`, the text as it stands, with nothing tuned. The paper prints few of the numbers that its figures
show; each figure here says which of them are reproduced.
"""

import numpy as np
from figure_sheet import add_map, draw, words
from matplotlib.figure import Figure
from paty2021 import P1, P2, PLANE, PRINTER, SETS, on_helix

import cablewright as cw
from cablewright.apps import style
from cablewright.apps.space_axes import add_faces, add_lines, bounds, heights, space

A, A2 = SETS[:2]


def regions(quick: bool) -> Figure:
    """Fig. 10: the region of uncertainty at P1 and P2, and its projection from above."""
    drawn = style.figure(9.6, 8.0)
    grid = drawn.add_gridspec(2, 2)
    sizes = []
    for column, (name, pose) in enumerate((("P1", P1), ("P2", P2))):
        found = cw.accuracy(A.robot(), pose, cw.modulus_ranges(A.robot(), *A.moduli)).region
        tuned = cw.accuracy(A2.robot(), pose, cw.modulus_ranges(A2.robot(), *A2.moduli)).region
        points = 1e3 * (found.points - found.wanted)
        nominal = 1e3 * (found.nominal - found.wanted)
        low, high = bounds(points)
        axes, _ = space(drawn, grid[0, column], low, high, "mm", zoom=1.25)
        scale = style.scale_of(np.linalg.norm(points - nominal, axis=1))
        colours = style.error_bar(drawn, axes, scale, "δp in mm", pad=0.3)
        add_map(
            axes,
            points[found.hull.triangles],
            lambda at, to=colours, middle=nominal: to.to_rgba(np.linalg.norm(at - middle, axis=1)),
            times=1 if quick else 3,
        )
        axes.set_title(f"({'ab'[column]}) region at {name}: {1e6 * found.hull.volume:.3g} cm³")
        above = drawn.add_subplot(grid[1, column], aspect="equal", xlabel="x in mm", ylabel="y in mm")
        for each, colour, text in ((found, style.BLUE, "set A"), (tuned, style.GREY, "set A2, tuned to P1")):
            outline = 1e3 * (each.hull.projections["xy"] - each.wanted[:2])
            above.plot(*np.vstack([outline, outline[:1]]).T, color=colour, label=text)
        above.plot(*nominal[:2], "o", color=style.INK, label="nominal")
        if column:
            above.legend(loc="upper left", bbox_to_anchor=(1.05, 1.0))
        above.set_title(f"({'cd'[column]}) {name} from above")
        sizes.append(f"{1e6 * found.hull.volume:.3g} cm³, tuned {1e6 * tuned.hull.volume:.3g} cm³")
    return words(
        drawn,
        "Paty 2021, Fig. 10: where the platform may be for moduli of ±30 %",
        f"Paper: 3.126 cm³ at P1 and 151.3 cm³ at P2. Here: {sizes[0]}; {sizes[1]}. Coordinates are from the "
        "commanded place.",
        "Reproduced: small at P1, large at P2. Not reproduced: both volumes with ±30 %; squares from above, here "
        "octagons.",
        "Tuned (grey): moduli of 2/3 to 4/3 and a section of 12.27 mm², chosen to fit P1.",
    )


def helix(quick: bool) -> tuple[cw.Places, cw.Accuracy, float]:
    """The helix whose largest error begins with the paper's 50 mm, and errors along it."""
    robot = A.robot()
    ranges = cw.modulus_ranges(robot, *A.moduli)
    radius = 5.91 if quick else on_helix(robot, ranges)[0]
    places = cw.Places.helix(robot, radius, 2.0 if quick else 0.5, 0.0, 13.0)
    return places, cw.accuracy(robot, places, ranges, tension_limits=PRINTER).accuracy, radius


ASSUMED = (
    "Assumed: the radius, by which the error begins with the paper's 50 mm, and the pitch of 0.5 m.",
    "The helix is outside the paper's own limits of 0.51 to 5.15 kN; here the lowest tension is 20 N.",
)


def path(quick: bool) -> Figure:
    """Fig. 11: the helix, and the largest error along it."""
    places, found, radius = helix(quick)
    errors, at = 1e3 * found.spread.max_error, places.positions
    times = 5.0
    moved = at + times * found.worst_offset
    drawn = style.figure(9.0, 6.6)
    low, high = bounds(at, moved)
    axes, _ = space(drawn, drawn.add_gridspec(1, 1)[0], low, high, "m", zoom=0.95)
    colours = style.error_bar(drawn, axes, style.scale_of(errors[np.isfinite(errors)]), "Δp_max in mm")
    add_lines(axes, np.stack([at[:-1], at[1:]], axis=1), 2, 0.7, style.GREY)
    add_lines(axes, np.stack([moved[:-1], moved[1:]], axis=1), 3, 1.6, colours.to_rgba(errors[:-1]))
    low, high = np.nanmin(errors), np.nanmax(errors)
    return words(
        drawn,
        f"Paty 2021, Fig. 11: largest error on a helix of {radius:.2f} m; displacements {times:.0f} times enlarged",
        f"Paper: 50 to 270 mm. Here up to a height of 13 m: {low:.0f} to {high:.0f} mm; grey is the commanded path.",
        "Not reproduced: 50 mm as the smallest error on the helix. Above 13 m the error grows steeply.",
        *ASSUMED,
    )


def components(quick: bool) -> Figure:
    """Fig. 12: components of the largest error by height."""
    places, found, radius = helix(quick)
    z, offset = places.positions[:, 2], 1e3 * found.worst_offset
    drawn, axes = style.axes(7.16, 4.4)
    parts = (
        ("Δp_x", np.abs(offset[:, 0]), style.SKY, 0.6),
        ("Δp_y", np.abs(offset[:, 1]), style.PINK, 0.6),
        ("Δp_xy", np.linalg.norm(offset[:, :2], axis=1), style.BLUE, 1.6),
        ("Δp_z", np.abs(offset[:, 2]), style.ORANGE, 1.6),
        ("Δp_max", 1e3 * found.spread.max_error, style.INK, 1.6),
    )
    for name, values, colour, width in parts:
        axes.plot(z, values, color=colour, linewidth=width, label=name)
    axes.axvline(7.5, color=style.GREY, linestyle=style.DASHED, linewidth=1.0)
    axes.set(xlabel="height in m", ylabel="size of the component in mm", xlim=(0.0, 13.0), ylim=(0.0, None))
    axes.legend(loc="upper left")
    return words(
        drawn,
        f"Paty 2021, Fig. 12: components of the largest error on a helix of {radius:.2f} m",
        "Reproduced: both parts are of one size at the bottom; below 7.5 m (dashed) the error changes little, above "
        "it Δp_z grows.",
        "Not reproduced: a horizontal part that falls to the top: here it rises again above some 10 m.",
        *ASSUMED,
    )


def planes(quick: bool) -> Figure:
    """Fig. 13: lowest and highest vertical error over two planes."""
    robot = A.robot()
    drawn = style.figure(9.6, 5.4)
    grid = drawn.add_gridspec(1, 2)
    reached = []
    for column, height in enumerate((0.0, 7.5)):
        plane = cw.Places.plane(robot, height, PLANE, PLANE / (4 if quick else 10))
        spread = cw.accuracy(robot, plane, tension_limits=PRINTER).accuracy.spread
        x, y = plane.axes
        both = [1e3 * part[:, 2].reshape(len(x), len(y)) for part in (spread.low, spread.high)]
        low, high = np.nanmin(both[0]), np.nanmax(both[1])
        axes = heights(drawn, grid[column], (x[0], y[0], low - 1.0), (x[-1], y[-1], high + 1.0))
        nodes = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        for order, (one, colour) in enumerate(zip(both, (style.BLUE, style.ORANGE), strict=True)):
            points = np.concatenate([nodes, one[..., None]], axis=-1)
            corners = (points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:])
            add_faces(
                axes, np.stack(corners, axis=2).reshape(-1, 4, 3), colour, 3 + order, alpha=0.7, edge=(1, 1, 1, 0.6)
            )
        axes.set_title(f"({'ab'[column]}) at {height:g} m: lowest (blue) and highest (orange)")
        reached.append(f"{-low:.0f} mm at {height:g} m")
    return words(
        drawn,
        "Paty 2021, Fig. 13: vertical error over two planes",
        f"Paper: largest vertical error 61 mm at 0 m, 40 mm at 7.5 m. Here: {', '.join(reached)}: not reproduced, "
        "same size.",
        f"Assumed: planes out to {PLANE} m. They are outside the paper's own limits of tension; here the lowest is 20 "
        "N.",
        "Not comparable: the other surface, of which the text has no number.",
    )


if __name__ == "__main__":
    draw("paty2021", {10: regions, 11: path, 12: components, 13: planes})
