"""Picture of layers by height of the exit points: feasible ones, violations of others, and the stages found."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.studies.stages.search import Stages


def stages_picture(found: Stages) -> Figure:
    """Draw each layer that was checked alone, at each height of the exit points, and the stages as steps."""
    drawn = style.figure(7.2, 5.0)
    axes = drawn.subplots()
    limits = list(dict.fromkeys(each.limit for each in found.layer_checks if each.limit))
    colours = (style.RED, style.ORANGE, style.PINK, style.GREY, style.INK)
    good = [each for each in found.layer_checks if each.feasible]
    places = [each.height for each in good], [each.exit_height for each in good]
    axes.plot(*places, "o", color=style.SKY, markersize=6, label="holds")
    for k, limit in enumerate(limits):
        some = [each for each in found.layer_checks if each.limit == limit]
        colour = colours[k % len(colours)]
        places = [each.height for each in some], [each.exit_height for each in some]
        axes.plot(*places, "x", color=colour, markersize=6, label=f"breaks {limit}")
    if found.checked is not None:
        begins = [each.begin for each in found.checked_stages]
        heights = [each.stage.exit_height for each in found.checked_stages]
        end = float(np.nanmax([each.check.samples.positions[:, 2].max() for each in found.checked_stages]))
        axes.step([*begins, end], [*heights, heights[-1]], where="post", color=style.BLUE, label="stages", zorder=1)
    axes.set(xlabel="height of the nozzle in m", ylabel="highest exit point in m")
    axes.set_title(f"{found.job.name}: {found.status}")
    axes.margins(0.05)
    drawn.legend(loc="outside lower center", ncols=3)
    return drawn
