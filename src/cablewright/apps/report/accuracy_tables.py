"""What a report of accuracy says in words and tables: warnings, extreme places, contributions, what went in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.analyses.accuracy.nozzle_error import Accuracy
from cablewright.apps.pictures.accuracy import effects
from cablewright.apps.quantities import NOT_KNOWN, count, quantity
from cablewright.apps.report.page import Html, element, table
from cablewright.apps.report.provenance import program
from cablewright.arrays import Array
from cablewright.errors import Status
from cablewright.studies.accuracy import AccuracyStudy

_TOO_CURVED: Final = 0.05  # of the spread: beyond it first order is an estimate only


def notices(accuracy: Accuracy, study: AccuracyStudy | None = None) -> Iterator[Html]:
    """Yield what has to be known before a figure is trusted."""
    total, spread = count(len(accuracy.codes)), accuracy.spread
    for code in np.unique(accuracy.codes):
        if code:
            times = count(int((accuracy.codes == code).sum()))
            yield _notice(f"At {times} of {total} places: {Status.of(int(code)).value}. They have no answer.")
    curved = _largest(spread.nonlinearity) if accuracy.method == "first-order" else 0.0
    if curved > _TOO_CURVED:
        yield _notice(
            f"First order is off by up to {share(curved)} of the spread. Contributions and standard deviations are of "
            "first order, and so are all figures of the spread if the method was first order: take them as estimates."
        )
    lost = int(spread.unsolved.sum())
    if lost:
        solves = "solve has" if lost == 1 else "solves have"
        yield _notice(
            f"{count(lost)} {solves} no answer and are left out: the true extremes may lie beyond the figures."
        )
    broken = [] if study is None else [rule for rule in study.rules if not rule.holds]
    if broken:
        told = ", ".join(f"{rule.line} ({rule.value:.3g})" for rule in broken)
        yield _notice(
            f"The radius of these sheaves is not over {broken[0].wanted:g} times that of the cable, which wears "
            f"it: {told}."
        )


def extremes_table(study: AccuracyStudy) -> Html:
    """Return where each figure is largest, and the largest error smallest."""
    found, spread = study.accuracy, study.accuracy.spread
    worst = found.worst_offset
    rows: list[tuple[str, str, Array, bool]] = [
        ("max error, largest", "m", spread.max_error, True),
        ("max error, smallest", "m", spread.max_error, False),
        ("its horizontal part, largest", "m", np.linalg.norm(worst[:, :2], axis=1), True),
        ("its vertical part, largest", "m", np.abs(worst[:, 2]), True),
        ("nominal error, largest", "m", found.nominal_error, True),
        ("difference, largest", "m", found.difference, True),
        ("max deviation, largest", "m", spread.max_deviation, True),
        ("vertical error, lowest", "m", spread.low[:, 2], False),
        ("vertical error, highest", "m", spread.high[:, 2], True),
        ("error of 95 % of samples, largest", "m", spread.likely_error, True),
    ]
    if found.robot.n == 6:
        rows.append(("turn of the platform, largest", "rad", spread.max_turn, True))
    told = []
    for name, unit, values, highest in rows:
        if np.isfinite(values).any():
            at = int(np.nanargmax(values) if highest else np.nanargmin(values))
            told.append((name, quantity(float(values[at]), unit), place_of(study.places.positions[at])))
    return table(("figure", "value", "where, in m"), told, numbers=(1,))


def contributions_table(accuracy: Accuracy) -> Html:
    """Return each uncertain number: what it may be, what it is at the worst place, and what it alone does."""
    sizes, vertical = effects(accuracy)
    errors = accuracy.spread.max_error
    worst = accuracy.spread.worst_values[int(np.nanargmax(errors))] if np.isfinite(errors).any() else None
    rows = []
    for k in np.argsort(-sizes, kind="stable"):
        each = accuracy.ranges[k]
        unit = "" if each.parameter.unit == "1" else f" {each.parameter.unit}"
        spread = "uniform" if each.deviation is None else f"normal, deviation {each.deviation:.6g}{unit}"
        rows.append(
            (
                each.parameter.label,
                f"{each.nominal:.7g}{unit}",
                f"{each.low:.7g} to {each.high:.7g}{unit}",
                spread,
                NOT_KNOWN if worst is None else f"{worst[k]:.7g}{unit}",
                quantity(float(sizes[k]), "m"),
                quantity(float(vertical[k]), "m"),
            )
        )
    head = (
        "uncertain number",
        "nominal",
        "range",
        "distribution",
        "at the largest error",
        "its effect",
        "vertical part",
    )
    return table(head, rows, numbers=(1, 2, 4, 5, 6))


def ends_table(study: AccuracyStudy) -> Html:
    """Return which limits end the workspace, how often and where."""
    ending = () if study.workspace is None else study.workspace.by_limit
    if not ending:
        return element("p", "Nothing is accessible: no limit ends anything.")
    total = sum(each.ends for each in ending)
    rows = [
        (each.limit, f"{count(each.ends)} ({share(each.ends / total)})", place_of(each.lowest), place_of(each.highest))
        for each in ending
    ]
    return table(("limit", "ends of grid lines", "lowest, in m", "highest, in m"), rows, numbers=(1,))


def remains_table(remains: Sequence[Mapping[str, Any]]) -> Html:
    """Return what each model of a controller leaves of the error."""
    rows = [
        (
            COMPENSATIONS[row["compensation"]].words,
            *(quantity(number(row, key), "m") for key in ("nominal_error", "max_error", "max_deviation")),
        )
        for row in remains
    ]
    return table(("lengths commanded", "nominal error", "max error", "max deviation"), rows, numbers=(1, 2, 3))


def inputs_table(accuracy: Accuracy, where: str, options: Mapping[str, Any]) -> Html:
    """Return robot, commanded lengths, places, method, what else was asked for, and program."""
    robot = accuracy.robot
    body = "point mass" if robot.n == 3 else "rigid body"
    rows = [
        ("robot", robot.name),
        ("description", robot.description),
        ("source of the robot", robot.source),
        ("platform", f"{body} of {robot.platform.mass:g} kg on {robot.m} line{'' if robot.m == 1 else 's'}"),
        ("lengths commanded", COMPENSATIONS[accuracy.compensation].words),
        ("places", where),
        ("uncertain numbers", count(len(accuracy.ranges))),
        ("method", accuracy.method),
        *((told, str(options[key])) for key, told in _ASKED.items() if options.get(key) is not None),
        ("program", program()),
    ]
    return table(("what", "value"), [row for row in rows if row[1]])


_ASKED: Final = {
    "uncertainty": "uncertainty file",
    "home": "zeroed at",
    "tension_limits": "tension limits of every line, N",
    "retraction": "retraction, m",
    "load": "load",
    "wrench": "wrench, N and N m",
    "samples": "samples",
    "seed": "seed",
}
"""Options of the command that change the figures, as the page names them."""


def meanings(robot_freedoms: int) -> list[str]:
    """Return what the figures mean, with the symbols of Paty et al. 2021."""
    told = [
        "Error: from where the nozzle is wanted to where it is (Δp).",
        (
            "Nominal error (Δp_n): the error if every number is as the robot file has it. It comes from the model that "
            "gives the commanded lengths, and a better model removes it."
        ),
        "Max error (Δp_max): the largest error that uncertain numbers within their ranges were found to give.",
        "Difference (δp of Paty's Table 1): the max error less the nominal error.",
        (
            "Max deviation: the longest way from where the nominal numbers take the nozzle (δp of equation 24). No "
            "model removes it, only better known numbers or a measurement; it is at least as large as the difference."
        ),
        "Region (Ω): the hull of the places to which the corners of the ranges take the nozzle.",
        (
            "Effect of a number: how far it alone moves the nozzle over half its range, in first order, at the place "
            "where that is most."
        ),
    ]
    if robot_freedoms == 6:
        told.append("Turn: the angle between the wanted rotation of the platform and the one it has.")
    return told


def tensions_table(accuracy: Accuracy, tensions: Sequence[float] | Array) -> Html:
    """Return the tension of each line."""
    rows = [(line.name, quantity(float(pull), "N")) for line, pull in zip(accuracy.robot.lines, tensions, strict=True)]
    return table(("line", "tension"), rows, numbers=(1,))


def place_of(point: Sequence[float] | Array) -> Html:
    """Write a place on one line."""
    return element("span", plain(point), class_="keep")


def plain(numbers: Sequence[float] | Array) -> str:
    """Write some coordinates, to a millimetre."""
    texts = [f"{round(float(v), 3) + 0.0:.3f}".rstrip("0").rstrip(".") for v in numbers]
    return f"({', '.join(texts)})".replace("-", "\N{MINUS SIGN}")


def volume(size: float) -> str:
    """Write the volume (m^3) of a region."""
    return NOT_KNOWN if np.isnan(size) else f"{size * 1e9:.4g} mm³" if size < 1e-5 else f"{size * 1e6:.4g} cm³"


def share(part: float) -> str:
    """Write a share in per cent."""
    return "less than 0.1 %" if 0.0 < part < 1e-3 else f"{part * 100:.3g} %"


def number(values: Mapping[str, Any], key: str) -> float:
    """Return a number of a command's JSON; NaN where there is none."""
    value = values.get(key)
    return float("nan") if value is None else float(value)


def _notice(text: str) -> Html:
    return element("p", text, class_="notice")


def _largest(values: Array) -> float:
    return float(np.nanmax(values)) if np.isfinite(values).any() else float("nan")
