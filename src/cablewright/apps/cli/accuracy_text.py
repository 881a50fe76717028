"""What `accuracy` prints for people."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from cablewright.apps.cli.output import tell

if TYPE_CHECKING:
    from cablewright.analyses.accuracy.nozzle_error import Accuracy
    from cablewright.studies.accuracy import AccuracyStudy
    from cablewright.studies.accuracy_at_pose import AccuracyAtPose

DOUBT = 0.05
"""Share of the spread by which first order may be off before it is said."""

FINEST = 1e-9  # m: below it the solver speaks
MAX_SHOWN = 8
"""Uncertain numbers that are listed."""


def print_place(found: AccuracyAtPose, report: str | None) -> None:
    """The figures of one pose."""
    import numpy as np

    from cablewright.analyses.accuracy.compensation import COMPENSATIONS

    at, spread, corners = found.accuracy, found.accuracy.spread, found.region
    place = ", ".join(f"{x:g}" for x in at.wanted[0])
    typer.echo(f"{at.robot.name} at {place}: nominal error {_mm(at.nominal_error[0])} mm")
    typer.echo(f"largest error {_mm(spread.max_error[0])} mm, {_mm(at.difference[0])} mm more than nominal, where")
    for each, value in list(zip(at.ranges, spread.worst_values[0], strict=True))[:MAX_SHOWN]:
        typer.echo(f"  {each.parameter.label:<40} {value:.6g} {_unit(each.parameter.unit)}".rstrip())
    if len(at.ranges) > MAX_SHOWN:
        typer.echo(f"  and {len(at.ranges) - MAX_SHOWN} more; all with --json")
    if at.robot.n == 6:
        typer.echo(f"turned {at.nominal_turn[0] * 1e3:.3g} mrad nominally, {spread.max_turn[0] * 1e3:.3g} mrad at most")
    typer.echo(f"largest deviation from the nominal point {_mm(spread.max_deviation[0])} mm")
    if np.isfinite(spread.likely_error[0]):
        typer.echo(f"95 % of the samples are within {_mm(spread.likely_error[0])} mm of the wanted point")
    typer.echo(f"region of the corners: {corners.hull.volume * 1e9:.4g} mm^3")
    if corners.interior is not None:
        inner = corners.interior
        verdict = "none is worse than" if inner.corner_is_worst else "SOME ARE WORSE than"
        typer.echo(f"of {inner.samples} inner points, {inner.climbs} of them climbed from, {verdict} the corners")
    typer.echo("what is left of the error:         nominal  largest")
    for name, left in found.remains.items():
        typer.echo(
            f"  {COMPENSATIONS[name].words:<31} {_mm(left.nominal_error[0]):>8}  {_mm(left.spread.max_error[0]):>8} mm"
        )
    if found.best is not None:
        best = found.best
        typer.echo(
            f"tensions chosen to hold it best: deviation {_mm(best.max_deviation)} mm instead of "
            f"{_mm(best.least_norm_max_deviation)} mm, a gain of {100 * best.gain:.1f} %"
        )
    _print_contributions(at)
    if report:
        typer.echo(f"report {report}")


def print_study(found: AccuracyStudy, report: str) -> None:
    """The figures of a shape."""
    import numpy as np

    summary, at = found.to_dict(), found.accuracy
    spread = at.spread
    typer.echo(f"{at.robot.name} over a {found.places.shape}: {summary['answered']} of {summary['places']} places")
    for status, count in summary["refused"].items():
        typer.echo(f"  refused as {status}: {count}")
    low, high = int(np.nanargmin(spread.max_error)), int(np.nanargmax(spread.max_error))
    for what, row in (("largest", high), ("smallest", low)):
        where = ", ".join(f"{x:.3f}" for x in at.wanted_nozzle[row])
        error, nominal = _mm(spread.max_error[row]), _mm(at.nominal_error[row])
        typer.echo(f"{what:<8} largest error {error} mm, nominal {nominal} mm, at {where}")
    low_z, high_z = np.nanmin(spread.low[:, 2]), np.nanmax(spread.high[:, 2])
    typer.echo(f"vertical error from {_mm(low_z)} to {_mm(high_z)} mm")
    typer.echo(f"largest deviation from the nominal point {_mm(np.nanmax(spread.max_deviation))} mm")
    if found.workspace is not None:
        typer.echo(f"accessible {found.workspace.nodes.trapezoid_volume:.1f} m^3, ended by")
        for each in found.workspace.by_limit:
            typer.echo(
                f"  {each.limit:<30} {each.ends:>7} times, from {each.lowest[2]:.2f} to {each.highest[2]:.2f} m high"
            )
    _print_contributions(at)
    typer.echo(f"report {report}")


def _print_contributions(found: Accuracy) -> None:
    """Which numbers matter most, where they differ in kind."""
    import numpy as np

    if len({each.parameter.kind for each in found.ranges}) == 1:
        return
    sizes = np.nanmax(np.linalg.norm(found.spread.effects, axis=1), axis=0)
    typer.echo("each number's own effect, half its range:")
    for k in np.argsort(-sizes, kind="stable")[:MAX_SHOWN]:
        typer.echo(f"  {found.ranges[k].parameter.label:<40} {_mm(sizes[k]):>8} mm")


def warn(found: Accuracy) -> None:
    """Say on stderr what a reader has to know before trusting the figures."""
    import numpy as np

    from cablewright.analyses.accuracy.corners import ALL_VERTICES

    spread = found.spread
    worst = float(np.nanmax(spread.nonlinearity))
    if worst > DOUBT and found.method == "first-order":
        tell(f"cablewright: first order is up to {100 * worst:.0f} % of the spread off here; --method vertices is less")
    if worst > DOUBT and found.method == "vertices" and len(found.ranges) > ALL_VERTICES:
        tell(f"cablewright: first order, which chose the corners, is up to {100 * worst:.0f} % of the spread off here")
    for each in found.ranges:
        if not each.low <= each.nominal <= each.high:
            tell(f"cablewright: {each.parameter.label}: the robot file's {each.nominal:g} is outside its range")
    if spread.unsolved.any():
        lost = int(spread.unsolved.sum())
        tell(
            f"cablewright: {lost} sets of values leave no sound equilibrium and are left out: it may be worse than this"
        )


def _mm(metres: float) -> str:
    return f"{metres * 1e3:.4g}" if abs(metres) >= FINEST else "0"


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit
