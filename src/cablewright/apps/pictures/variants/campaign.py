"""A print campaign: the machines' largest errors, and what each tolerance does to them."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.studies.campaigns.result import Campaign


def campaign_picture(found: Campaign) -> Figure:
    """Draw the share of machines within an error, and the change of the largest error by tolerance."""
    drawn = style.figure(11.0, 4.4)
    if found.sensitivities:
        left, right = drawn.subplots(1, 2)
        _bars(right, found)
    else:
        left = drawn.subplots()
    _distribution(left, found)
    low, high = found.success_interval
    style.headline(
        drawn,
        f"{style.label(found.what.job.name)} on {len(found.prints)} machines of {style.label(found.what.robot.name)}: "
        f"{100 * found.success_rate:.0f} % succeed (95 % interval {100 * low:.0f} to {100 * high:.0f} %)",
    )
    return drawn


def _distribution(axes: Axes, found: Campaign) -> None:
    """Draw the share of the machines, finished or not, whose largest error is at most so large."""
    errors = np.sort(1e3 * found.errors[np.isfinite(found.errors)])
    shares = 100.0 * np.arange(1, len(errors) + 1) / len(found.prints)
    axes.step(np.r_[0.0, errors], np.r_[0.0, shares], where="post", color=style.BLUE)
    axes.axvline(1e3 * found.allowed_error, color=style.RED, linestyle="--", label="allowed")
    axes.set(xlabel="largest error beside the path in mm", ylabel="machines in %", title="machines within an error")
    axes.set_xlim(left=0.0)
    axes.set_ylim(0.0, 104.0)
    axes.legend(loc="lower right")


def _bars(axes: Axes, found: Campaign) -> None:
    """Draw the mean change of the largest error if a tolerance is met exactly, with its standard error."""
    rows = found.sensitivities[::-1]
    names = [each.tolerance.replace("_", " ") for each in rows]
    changes = [1e3 * each.change for each in rows]
    errors = [1e3 * each.change_error for each in rows]
    axes.barh(names, changes, xerr=np.nan_to_num(errors), color=style.SKY, ecolor=style.INK, capsize=3)
    axes.axvline(0.0, color=style.GREY, linewidth=0.8)
    axes.set(xlabel="change of the largest error in mm, mean and its standard error", title="one tolerance met exactly")
    axes.grid(visible=False, axis="y")
