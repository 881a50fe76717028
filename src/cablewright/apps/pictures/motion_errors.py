"""Picture of the nozzle error by motion of the platform over the time of a print, and of the swing's frequency."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.apps.report.check_summary import Digest, grouped
from cablewright.studies.checks.path_statics import median
from cablewright.studies.checks.result import LARGEST


def motion(digest: Digest) -> Figure | None:
    """Draw error and frequency of the dominant mode over time, where material is laid, if any is.

    Nothing is drawn where no motion is known.
    """
    check, starts = digest.check, digest.stretches
    found = check.motion
    if found is None or not found.largest > 0.0:  # NaN where no sample is held
        return None
    seconds, unit = style.time_unit(check.law.duration)
    time = np.append(check.law.time[starts], check.law.duration) / seconds
    drawn, (errors, rates) = style.subplots(9.0, 4.2, 2, 1, sharex=True, height_ratios=(1.6, 1))
    laid = check.samples.extruding
    displacement = np.where(laid | ~laid.any(), check.statics.displacement, np.nan)
    kinds = ((LARGEST, "largest", style.ORANGE), (median, "median", style.BLUE))
    for choose, words, colour in kinds:
        values = 1e3 * grouped(choose, displacement, starts)
        errors.step(time, np.append(values, values[-1:]), where="post", color=colour, linewidth=1.3, label=words)
    if math.isfinite(check.allowed_error):
        errors.axhline(
            1e3 * check.allowed_error, color=style.RED, linestyle=style.DASHED, label="allowed, with the expected error"
        )
    at = check.law.time[found.sample] / seconds
    errors.plot(at, 1e3 * found.largest, zorder=5, markeredgewidth=1.6, **style.RING)
    errors.set(ylabel="error by motion in mm", ylim=(0.0, None))
    swinging = np.where(displacement > 0.0, check.statics.frequency, np.nan)
    frequency = grouped(median, swinging, starts)
    rates.plot(time[:-1], frequency, ".", color=style.BLUE, markersize=4)
    rates.plot(at, found.frequency, markeredgewidth=1.6, **style.RING)
    rates.set(
        xlabel=f"time in {unit}",
        ylabel="frequency in Hz",
        ylim=(0.0, 1.25 * float(np.nanmax([found.frequency, *frequency]))),
    )
    rates.margins(x=0)
    style.legend_below(drawn, errors, columns=3)
    return drawn
