"""Figs. 7, 8 and 11 of Merlet and Papegay 2023, each as a PDF: python examples/papers/merlet2023_figures.py.

Fig. 7 is of the simulated machine of the library on a random closed curve of 28 m, Fig. 8 of an exact catenary, Fig. 11
of powder poured along the curve of `examples/blind-machines.toml`. The paper prints neither its exit points nor its
curve, so only sizes and shapes can be compared.
"""

import math
import tempfile
from pathlib import Path

import numpy as np
from figure_sheet import draw, words
from matplotlib.figure import Figure

import cablewright as cw
from cablewright.apps import style
from cablewright.apps.pictures.simulation import line_angle
from cablewright.solvers.slack import angle_from_excess

EXAMPLES = Path(__file__).parents[1]
MASS, PORTIONS = 1700.0, 14  # kg of powder, theirs, and times round the curve in which it is poured here
SPAN, DISTANCE = 2.5, 0.2  # m: their cable and their sensor
BEFORE = 7  # columns of a replay's trace before those of its lines


def angles(quick: bool) -> Figure:
    """Fig. 7: measured and taut angles of the lines that are slack least and most often."""
    robot, duration = cw.load("merlet2023"), 6.0 if quick else 300.0
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder, "loop.mcap")
        cw.simulate(robot, loop=28.0, duration=duration, seed=7, plant="quasi-static", log=log)
        found = cw.replay(log)
    trace = np.array(found.trace).reshape(-1, BEFORE + 2 * robot.m).T
    taut, measured = trace[BEFORE : BEFORE + robot.m], trace[BEFORE + robot.m :]
    order = np.argsort(found.slack_steps)
    shares = 1.0 - np.array(found.slack_steps) / max(found.valid, 1)
    drawn, axes = style.subplots(9.0, 6.0, 2, 1, sharex=True)
    for axis, i in zip(axes, (order[0], order[-1]), strict=True):
        line_angle(axis, trace[0], robot.lines[i].name, shares[i], measured[i], taut[i])
    axes[1].set_xlabel("time in s")
    ours = ", ".join(f"{100.0 * share:.0f}" for share in shares)
    return words(
        drawn,
        "Merlet 2023, Fig. 7: measured angle of two lines, and that of the taut line",
        f"Paper: line 2 always taut, lines 1, 3, 4 for 75, 52, 30 % of the time. Here, of lines 1 to 4: {ours} %.",
        "Reproduced: a slack line's angle leaves that of the taut line, and vibrates. Not comparable: the shares "
        "(machine, curve).",
        "Assumed: exit points, curve, tolerances (seed 7) of the simulated machine; it is quasi-static.",
    )


def slackness(quick: bool) -> Figure:
    """Fig. 8: the angle of a sensor 20 cm from the end of a slack line of 2.5 m, over its excess."""
    robot = cw.load("merlet2023")
    line = robot.lines[0].model_copy(update={"sheave": cw.Eyelet(), "winch_exit": None})
    model = cw.Model(robot.model_copy(update={"lines": (line,)}))
    excess = np.append(0.0, np.geomspace(1e-5, 0.1, 20 if quick else 200))
    drawn, axes = style.axes(7.16, 4.6)
    x, y, z = line.exit_point
    at_one = []
    for i, falls in enumerate((0, 45, 80)):
        slope = math.radians(falls)
        end = [x + SPAN * math.cos(slope), y, z - SPAN * math.sin(slope)]
        turned = np.degrees(angle_from_excess(model, end, line.name, DISTANCE, excess) + slope)
        axes.plot(100.0 * excess, turned, label=f"line falls by {falls}°", **style.curve(i))
        at_one.append(f"{np.interp(0.01, excess, turned):.1f}°")
    axes.plot(1.0, 12.45, "x", color=style.INK, markersize=9, label="the paper's text: 12.45° at 1 cm")
    axes.set(
        xlabel="excess dL_0 in cm", ylabel="angle from the taut line in degrees", xlim=(0.0, 10.0), ylim=(0.0, None)
    )
    axes.legend(loc="lower right")
    return words(
        drawn,
        "Merlet 2023, Fig. 8: angle that shows the slackness, cable of 2.5 m, sensor at 20 cm from B",
        f"Not reproduced: 12.45° at 1 cm. Here {', '.join(at_one)}, by the line's slope, which the paper does not "
        "print.",
        "Reproduced: the steep beginning.",
    )


def structure(quick: bool) -> Figure:
    """Fig. 11: the structure of 1.7 t of powder, and its height."""
    job = cw.load_job(EXAMPLES / "blind-machines.toml")
    samples = job.samples(job.toolpath())
    once = samples.positions[samples.layer == 1]
    length = np.linalg.norm(np.diff(once, axis=0), axis=1)
    powder, field = cw.Powder(), cw.HeightField.flat((-2.2, -4.4), (2.2, 4.4), 0.08 if quick else 0.02)
    portions = 2 if quick else PORTIONS
    for _ in range(portions):
        cw.pour(field, once[:-1], once[1:], MASS / portions * length / length.sum(), powder)
    heights = 100.0 * field.heights
    drawn, (above, section) = style.subplots(9.6, 7.0, 1, 2, width_ratios=(1.0, 1.15))
    extent = (-2.2, 2.2, -4.4, 4.4)
    shown = above.imshow(heights.T, origin="lower", extent=extent, cmap=style.stress_colours(), interpolation="nearest")
    style.colour_bar(drawn, above, shown, "height in cm")
    above.plot(once[:, 0], once[:, 1], color="white", linewidth=0.5)
    i, j = np.unravel_index(heights.argmax(), heights.shape)
    top = field.centres(0)[i], field.centres(1)[j]
    above.plot(*top, **style.RING)
    above.set(xlabel="x in m", ylabel="y in m", title="from above; ring: highest place")
    above.grid(visible=False)
    section.plot(
        field.centres(0) - top[0], heights[:, j], color=style.BLUE, label="here, through the highest place, along x"
    )
    section.axhline(
        18.0, color=style.INK, linestyle=style.DASHED, linewidth=1.0, label="the paper's largest height, 18 cm"
    )
    ridge = np.array([[-0.11, 0.0], [0.0, 9.0], [0.11, 0.0]])
    section.plot(*ridge.T, color=style.ORANGE, label="the paper's ridge: 9 cm by 22 cm")
    section.set(xlabel="distance in m", ylabel="height in cm", xlim=(-1.5, 1.5), ylim=(0.0, 26.0))
    section.legend(loc="upper left")
    section.set_title(f"highest place: {heights.max():.1f} cm")
    return words(
        drawn,
        f"Merlet 2023, Fig. 11: the structure of {MASS:.0f} kg of powder",
        f"Paper: 18 cm high where the curve nearly crosses itself three times. Here {heights.max():.1f} cm: the right "
        "size, no more.",
        "Assumed: the curve (28 m, not the exhibition's). From the paper: 1.5 kg/l, 22° of repose.",
        "Not reproduced: a ridge of 9 cm by 22 cm, which is 39° steep and along 28 m would hold 0.42 t.",
    )


if __name__ == "__main__":
    draw("merlet2023", {7: angles, 8: slackness, 11: structure})
