"""Figs. 4 to 6 of Wang and Caro 2021, each a PDF: python examples/papers/wang2021_figures.py.

The robot, poses, starts and bounds are those of `wang2021.py`, which assumes all that the paper does not print. The
solver of Figs. 4 and 5 is SciPy's trust region in bounds, of the kind of MATLAB's lsqnonlin.
"""

import numpy as np
from figure_sheet import draw, words
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from wang2021 import TRUE, Case

from cablewright.apps import style

ASSUMED = ("Assumed, since not printed: exit points, random poses, starts within 10 mm of the truth, bounds of 50 mm.",)
POSES = (16, 20, 24, 28, 32, 36, 40)


def tolerances(quick: bool) -> Figure:
    """Fig. 4: mu by both tolerances."""
    starts, few = (1, np.logspace(-5, -4, 2)) if quick else (3, np.logspace(-12, -4, 5))
    case = Case(20, starts)
    mu = np.array(
        [
            [np.mean([case.mu(case.as_paper(start, f, x, analytic=True)) for start in case.starts]) for f in few]
            for x in few
        ]
    )
    drawn, axes = style.axes(7.16, 5.2)
    edges = np.sqrt(few[:-1] * few[1:])
    edges = np.concatenate([[few[0] ** 2 / edges[0]], edges, [few[-1] ** 2 / edges[-1]]])
    shown = axes.pcolormesh(edges, edges, mu, cmap="cividis", norm=LogNorm(mu.min(), mu.max()))
    style.colour_bar(drawn, axes, shown, "mu in mm²", format=lambda value, _: style.power(value))
    axes.set(xscale="log", yscale="log", xlabel="FunctionTolerance", ylabel="StepTolerance")
    for side in (axes.xaxis, axes.yaxis):
        style.log_ticks(side, few[0], few[-1])
    axes.grid(visible=False)
    return words(
        drawn,
        f"Wang 2021, Fig. 4: mu by both tolerances, 20 poses, with Jacobian, mean of {starts} starts",
        "Reproduced: mu falls with the tolerances to a floor. Not reproduced: FunctionTolerance as the stronger. Here "
        "it changes nothing, because SciPy compares it with a sum of squares that falls to zero.",
        *ASSUMED,
    )


def by_poses(quick: bool) -> Figure:
    """Fig. 5: mu by the number of poses, with and without Jacobian."""
    counts, few, tolerance = (POSES[:2], 1, 1e-4) if quick else (POSES, 3, 1e-12)
    drawn, axes = style.axes(7.16, 4.4)
    for i, (name, analytic) in enumerate((("with Jacobian", True), ("without", False))):
        mu = []
        for count in counts:
            case = Case(count, few)
            mu.append(np.mean([case.mu(case.as_paper(start, tolerance, tolerance, analytic)) for start in case.starts]))
        axes.plot(counts, mu, "os"[i] + "-", color=style.COLOURS[i], label=name)
    axes.set(xlabel="poses", ylabel="mu in mm²", ylim=(0.0, None))
    axes.legend(loc="lower right")
    return words(
        drawn,
        f"Wang 2021, Fig. 5: mu by the number of poses, mean of {few} starts",
        "Not reproduced: a quality that rises with the number of poses. Without noise it has no reason to: this is "
        "rounding.",
        *ASSUMED,
    )


def first_exit(quick: bool) -> Figure:
    """Fig. 6: error of y of the first exit point, by the number of poses."""
    counts, starts = (POSES[::3], 20) if quick else (POSES, 500)
    means, singles = [], []
    for count in counts:
        y = 1e3 * (np.array([x[1] for x in Case(count, starts).ours()]) - TRUE[0, 1])
        means.append(abs(y.mean()))
        singles.append(float(np.sqrt(np.mean(y**2))))
    drawn, axes = style.axes(7.16, 4.4)
    axes.semilogy(counts, singles, "o-", color=style.ORANGE, label="a single run, rms")
    axes.semilogy(counts, means, "s-", color=style.BLUE, label=f"mean of {starts} runs, as in the paper")
    axes.semilogy(counts, np.array(singles) / np.sqrt(starts), "--", color=style.INK, label=f"a single run / √{starts}")
    axes.axhline(0.1, color=style.GREY, linewidth=1.0, label="the paper's 0.1 mm")
    axes.set(xlabel="poses", ylabel="error of y of the first exit point in mm")
    style.log_ticks(axes.yaxis, *axes.get_ylim())
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    return words(
        drawn,
        "Wang 2021, Fig. 6: error of y of the first exit point, with Jacobian",
        "Reproduced: the size, 0.1 mm. It says how many starts were averaged, and nothing of a calibration: a single "
        "run keeps 2 mm.",
        "Not reproduced: a decreasing trend.",
        *ASSUMED,
    )


if __name__ == "__main__":
    draw("wang2021", {4: tolerances, 5: by_poses, 6: first_exit})
