"""Figs. 6 to 14 of Jung 2020, each as a PDF with its data beside it: python examples/papers/jung2020_figures.py.

Workspaces are those of the paper's closed form. Volumes are counted on 41^3 nodes, as the paper's seem to be; surfaces
are converged. The neighbouring exit points of Table 3 are 0.1 m apart, as its caption says. Frequencies are of the
elastic stiffness alone, as in the paper; the notes have those with the geometric part, which is not small.
"""

import numpy as np
from figure_sheet import draw, words
from jung2020 import LENGTHS, RIGID, TABLE_1, TABLE_3, TIP, beam
from matplotlib.figure import Figure

import cablewright as cw
from cablewright.apps import style
from cablewright.apps.space_axes import add_surface, machine

FORM = "closed-form"
PALE = np.array([0.60, 0.80, 0.93])
SLOPE, INTERCEPT = -0.675, 1.929  # the paper's Eq. 15
FREEDOM_COLOURS = (style.BLUE, style.GREEN, style.INK, style.SKY, style.PINK, style.ORANGE)


def counted(robot: cw.Robot, quick: bool, retraction: float | cw.RetractionLaw | None = None) -> cw.NodeCount:
    """Nodes of the frame in the workspace of the closed form."""
    return cw.count_nodes(cw.Model(robot, RIGID), FORM, grid=13 if quick else 41, retraction=retraction)


def platform_points(robot: cw.Robot, height: float) -> np.ndarray:
    """Points of the platform (8, 3), m, where p is at a *height* in the middle of the frame."""
    return np.array([line.platform_point for line in robot.lines]) + np.array([0.0, 0.0, height])


def surfaces(cases: list[tuple[str, cw.Robot, float]], quick: bool) -> tuple[Figure, list[str]]:
    """Surfaces of workspaces side by side, by title, robot and length, and their volumes in words."""
    drawn = style.figure(9.6, 5.6)
    grid, sizes = drawn.add_gridspec(1, len(cases)), []
    for column, (title, robot, length) in enumerate(cases):
        model = cw.Model(robot, RIGID)
        found = cw.workspace(model, FORM, retraction=length, grid=13 if quick else 41)
        nodes = counted(robot, quick, length)
        axes = machine(drawn, grid[0, column], robot, found.box.low, found.box.high)
        add_surface(axes, found.mesh, PALE, darkest=0.5)
        points = platform_points(robot.retracted(length), 1.0)
        axes.scatter(*points.T, s=10, c=style.PINK, depthshade=False, zorder=9)
        axes.set_title(f"({'ab'[column]}) {title}")
        sizes.append(f"{nodes.volume:.2f} m³ ({100.0 * nodes.fraction:.1f} %), converged {found.volume:.2f} m³")
    return drawn, sizes


def first_workspaces(quick: bool) -> Figure:
    """Fig. 6: the workspace with the exit points of Table 1 and with those of Table 2."""
    drawn, sizes = surfaces([("Table 1", TABLE_1, 2.0), ("exits 0.0283 m apart", beam(0.0283), 2.0)], quick)
    return words(
        drawn,
        "Jung 2020, Fig. 6: workspace of the closed form; squares: exit points; pink: platform points at 1 m",
        f"Paper: (a) 2.96 m³, about 37 %. Here, counted on 41 x 41 x 41 nodes: (a) {sizes[0]}; (b) {sizes[1]}.",
        "Reproduced: (a), if nodes are counted. The paper has no number for (b). Drawn is the converged surface.",
    )


def by_distance(quick: bool) -> Figure:
    """Fig. 7: volume by the distance of neighbouring exit points."""
    apart = np.array([0.002, 0.0283, 0.1, 0.2121]) if quick else np.array([0.002, *np.linspace(0.0141, 0.2121, 15)])
    shares = [100.0 * counted(beam(each), quick).fraction for each in apart]
    drawn, axes = style.axes(7.16, 4.2)
    axes.plot(apart, shares, "o-", color=style.BLUE, label="here, counted")
    axes.plot(
        0.0,
        100.0 * counted(TABLE_1, quick).fraction,
        "s",
        color=style.ORANGE,
        label="Table 1: exit points of a pair coincide",
    )
    axes.plot(0.0, 37.0, "x", color=style.INK, markersize=9, label="the paper's text: about 37 %")
    axes.set(xlabel="distance of neighbouring exit points in m", ylabel="volume in % of the frame")
    axes.legend(loc="lower left")
    return words(
        drawn,
        "Jung 2020, Fig. 7: volume of the workspace by the distance of neighbouring exit points",
        "Reproduced: the volume falls as they part. Table 1, where they coincide, is singular in yaw and counts less.",
    )


def retracted(quick: bool) -> Figure:
    """Fig. 8: the workspace at two lengths."""
    drawn, sizes = surfaces([(f"{length} m", TABLE_3, length) for length in (1.6, 1.2)], quick)
    return words(
        drawn,
        "Jung 2020, Fig. 8: workspace of the retracted beam; pink: platform points at 1 m",
        f"Here, counted: (a) {sizes[0]}; (b) {sizes[1]}. The paper prints no number.",
        "Reproduced: a shorter beam has a lower and wider workspace.",
    )


def by_height(quick: bool) -> Figure:
    """Fig. 9: area of the workspace by height and length."""
    drawn, axes = style.axes(7.16, 4.6)
    lengths = np.linspace(1.2, 2.0, 3 if quick else 5)
    layers = [counted(TABLE_3, quick, length) for length in lengths]
    for i, (length, found) in enumerate(zip(lengths, layers, strict=True)):
        axes.plot(found.slices() / 4.0, found.axes[2], label=f"{length:.1f} m", **style.curve(i))
    best = np.max([found.slices() / 4.0 for found in layers], axis=0)
    axes.fill_betweenx(layers[0].axes[2], layers[-1].slices() / 4.0, best, color=style.RED, alpha=0.12)
    axes.set(
        xlabel="area of the slice, share of the frame's floor",
        ylabel="height of p in m",
        xlim=(0.0, None),
        ylim=(0.0, 2.0),
    )
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), title="length")
    gain = 100.0 * (best.sum() / (layers[-1].slices() / 4.0).sum() - 1.0)
    return words(
        drawn,
        "Jung 2020, Fig. 9: what other lengths than 2 m gain by height (red)",
        "Reproduced: long beams reach low, short ones are wider above. The best of these lengths in each slice gains "
        f"{gain:.0f} %.",
        "The paper prints no number.",
    )


def law(quick: bool) -> Figure:
    """Fig. 10: area by height and length, with the paper's law and ours."""
    lengths = np.linspace(1.2, 2.0, 5 if quick else 17)
    layers = [counted(TABLE_3, quick, length) for length in lengths]
    z, areas = layers[0].axes[2], np.array([each.slices() / 4.0 for each in layers])
    own = cw.retraction(
        cw.Model(TABLE_3, RIGID), FORM, point="origin", steps=5 if quick else 9, heights=10 if quick else 40,
        tolerance=0.05 if quick else 2e-3,
    ).law  # fmt: skip
    drawn, axes = style.axes(7.16, 4.8)
    step, rise = 0.5 * (lengths[1] - lengths[0]), 0.5 * (z[1] - z[0])
    extent = (z[0] - rise, z[-1] + rise, lengths[0] - step, lengths[-1] + step)
    shown = axes.imshow(areas, origin="lower", aspect="auto", extent=extent, cmap="cividis", interpolation="nearest")
    style.colour_bar(drawn, axes, shown, "share of the slice")
    some = areas.max(axis=0) > 0.0
    axes.plot(
        z[some],
        lengths[areas.argmax(axis=0)][some],
        "o",
        color="white",
        markersize=4,
        markeredgecolor=style.INK,
        label="largest share of a height",
    )
    for name, slope, intercept, colour, dashes in (
        ("paper, z of p", SLOPE, INTERCEPT, style.RED, "-"),
        ("paper, z of the lower end", SLOPE, INTERCEPT - SLOPE * TIP, style.RED, style.DASHED),
        (f"ours: {own.slope:.3f} z + {own.intercept:.3f} m", own.slope, own.intercept, style.ORANGE, "-"),
    ):
        axes.plot(z, slope * z + intercept, color=colour, linestyle=dashes, label=style.minus(name))
    axes.set(xlabel="height of p in m", ylabel="retraction length in m", xlim=(0.0, 2.0), ylim=extent[2:])
    axes.grid(visible=False)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    return words(
        drawn,
        "Jung 2020, Fig. 10: share of each slice by height and length, and laws l_e(z)",
        f"Reproduced: the largest share, 0.64 in the paper, here {areas.max():.3f}. Not reproduced: the paper's law, "
        "a red line.",
        "The paper does not say which slices it fits, nor of which point z is the height.",
    )


def scheme(_quick: bool) -> Figure:
    """Fig. 11: the beam retracted, and at its full length."""
    drawn, both = style.subplots(9.0, 5.0, 1, 2, sharey=True)
    z = 1.0
    cases = ((INTERCEPT + SLOPE * z, z, "(a) retracted to l_e(z)"), (INTERCEPT, 0.0, "(b) at z = 0: l_e = d_r"))
    for axes, (length, height, title) in zip(both, cases, strict=True):
        robot = TABLE_3.retracted(min(max(length, 1.2), 2.0))
        style.rectangle(axes, robot.scene.frame_min, robot.scene.frame_max, (0, 2))
        ends = platform_points(robot, height)
        exits = np.array([line.exit_point for line in robot.lines])
        for a, b in zip(exits, ends, strict=True):
            axes.plot([a[0], b[0]], [a[2], b[2]], color=style.GREY, linewidth=0.8)
        top, bottom = ends[:, 2].max(), ends[:, 2].min()
        axes.plot([0.0, 0.0], [bottom, top], color=style.BLUE, linewidth=4.0)
        axes.plot(0.0, height, "o", color=style.INK, zorder=5)
        axes.annotate("p", (0.0, height), xytext=(8, 0), textcoords="offset points", va="center")
        axes.annotate("", (-0.25, bottom), (-0.25, top), arrowprops={"arrowstyle": "<->", "color": style.RED})
        axes.text(
            -0.3,
            0.5 * (bottom + top),
            f"l_e = {top - bottom:.2f} m",
            ha="right",
            va="center",
            color=style.RED,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0},
        )
        axes.set(xlabel="x in m", aspect="equal", xlim=(-1.1, 1.1), ylim=(-0.3, 2.6), title=title)
    both[0].set_ylabel("z in m")
    return words(
        drawn,
        "Jung 2020, Fig. 11: the retractable beam, l_e(z) = c_r z + d_r",
        f"Law of the paper: c_r = {SLOPE}, d_r = {INTERCEPT} m. Drawn to scale from Table 3; p is 0.2 m above the "
        "lower end.",
        "The lower end would be under the floor at z = 0: the paper calls p the tip too, which its Table 1 "
        "contradicts.",
    )


def frequencies(number: int, width: float, paper: str, verdict: str, quick: bool) -> Figure:
    """Lowest frequencies along the boundary at three lengths, and the freedom with most energy."""
    drawn = style.figure(10.4, 7.2)
    grid = drawn.add_gridspec(2, 3)
    plain, whole = [], []
    for length in LENGTHS:
        robot = cw.with_box_inertia(beam(0.1, width).retracted(length))
        found = cw.boundary_modes(cw.Model(robot, cw.Fidelity.of("elastic")), FORM, grid=9 if quick else 21)
        plain.append((robot, found.places, cw.modes(found.modes.equilibrium, geometric=False)))
        whole.append(found.lowest)
    lowest = np.concatenate([each.lowest for _, _, each in plain])
    with_tension = np.concatenate(whole)
    row = drawn.add_subplot(grid[0, :], frame_on=False, xticks=[], yticks=[])
    colours = style.error_bar(drawn, row, style.scale_of(lowest), "lowest frequency in Hz", location="left")
    seen = {}
    for column, (length, (robot, places, found)) in enumerate(zip(LENGTHS, plain, strict=True)):
        above, below = (machine(drawn, grid[row, column], robot) for row in (0, 1))
        above.scatter(*places.T, c=colours.to_rgba(found.lowest), s=7, depthshade=False)
        above.set_title(f"(a) length {length} m")
        named = found.dominant[:, 0]
        for k, (name, colour) in enumerate(zip(cw.FREEDOMS, FREEDOM_COLOURS, strict=True)):
            if (named == k).any():
                seen[name] = below.scatter(*places[named == k].T, color=colour, s=7, depthshade=False)
        most = np.bincount(named, minlength=6).argmax()
        below.set_title(f"(b) {length} m: {100.0 * (named == most).mean():.0f} % {cw.FREEDOMS[most]}")
    drawn.legend(seen.values(), seen.keys(), loc="outside right center", markerscale=2.0)
    return words(
        drawn,
        f"Jung 2020, Fig. {number}: lowest frequencies along the boundary (a), and the freedom with most energy (b)",
        f"Paper: {paper}. Here, elastic part alone as in the paper: {lowest.min():.2f} to {lowest.max():.2f} Hz: "
        f"{verdict}",
        f"With the geometric part, which Eq. 9 leaves out: {with_tension.min():.1f} to {with_tension.max():.1f} Hz. "
        "Not reproduced: a translation along z as the freedom of most modes.",
    )


if __name__ == "__main__":
    near = "reproduced."
    draw(
        "jung2020",
        {
            6: first_workspaces,
            7: by_distance,
            8: retracted,
            9: by_height,
            10: law,
            11: scheme,
            12: lambda quick: frequencies(12, 0.04, "around 1.2 Hz", near, quick),
            13: lambda quick: frequencies(13, 0.08, "7 to 17 Hz, ends widened to 0.08 m", near, quick),
            14: lambda quick: frequencies(14, 0.16, "8 to 21 Hz, ends widened to 0.16 m", near, quick),
        },
    )
