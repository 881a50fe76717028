"""The reports of `cablewright accuracy`: errors of a robot over a shape or at one pose."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.analyses.accuracy.nozzle_error import Accuracy
from cablewright.apps import style
from cablewright.apps.dark_pictures import themed
from cablewright.apps.figures import summary
from cablewright.apps.pictures.accuracy import along, contributions, displaced_by, plane
from cablewright.apps.pictures.error_region import region as region_picture
from cablewright.apps.pictures.workspace import workspace_errors
from cablewright.apps.quantities import count, quantity
from cablewright.apps.report.document import verdict, view, write_report
from cablewright.apps.report.page import Html, Themed, cards, element, notice, picture, section, table
from cablewright.apps.report.provenance import assumptions, list_of, robot_rows
from cablewright.apps.report.result import part_table
from cablewright.apps.web.robot_scene import place_scene, study_scene
from cablewright.foundation.errors import Status
from cablewright.studies.accuracy import AccuracyStudy
from cablewright.studies.accuracy_at_pose import AccuracyAtPose

Pictures = dict[str, Themed]

_SHAPES: Final = {
    "helix": "along a helix",
    "path": "along a path",
    "plane": "over a plane",
    "workspace": "over the workspace",
}
_IN_VERDICT: Final = ("status", "robot", "shape", "compensation")


def write(study: AccuracyStudy, folder: Path, options: Mapping[str, Any] | None = None) -> Path:
    """Write ``report.html`` of a study and its pictures into ``folder``, which exists; return the report's path.

    *options* are those of the command; the page names those that changed its figures. It holds its pictures and makes
    no request. The same study gives the same bytes. Raises `EnvironmentFault` where it cannot be written.
    """
    drawn = _pictures(study) if _answered(study.accuracy) else {}
    title = f"Accuracy of {study.accuracy.robot.name} {_SHAPES[study.places.shape]}"
    return write_report(folder, title, _study_body(study, title, drawn, options or {}), drawn)


def write_place(found: AccuracyAtPose, folder: Path, options: Mapping[str, Any] | None = None) -> Path:
    """Write ``report.html`` of the accuracy at one pose, as `write` does."""
    drawn = {}
    if _answered(found.accuracy):
        with style.drawing():
            drawn["contributions"] = themed(contributions(found.accuracy))
            if len(found.region.points):
                drawn["region"] = themed(region_picture(found.region))
    title = f"Accuracy of {found.accuracy.robot.name} at one pose"
    return write_report(folder, title, _place_body(found, title, drawn, options or {}), drawn)


def _pictures(study: AccuracyStudy) -> Pictures:
    """Draw what there is to draw of a shape."""
    with style.drawing():
        drawn: dict[str, Figure | None] = {"contributions": contributions(study.accuracy)}
        match study.places.shape:
            case "workspace":
                drawn["workspace"] = workspace_errors(study)
            case "plane":
                drawn["plane"] = plane(study)
            case _:
                drawn["along"] = along(study)
        return {name: themed(figure) for name, figure in drawn.items() if figure is not None}


def _answered(accuracy: Accuracy) -> bool:
    return bool(np.isfinite(accuracy.spread.max_error).any())


def _study_body(study: AccuracyStudy, title: str, pictures: Pictures, options: Mapping[str, Any]) -> Iterator[Html]:
    """Yield the page of a shape."""
    found = study.accuracy
    yield element("h1", title)
    yield _study_verdict(study)
    if pictures:
        yield cards(_cards(study, found))
    yield from _notices(found, study.notes)
    if pictures:
        yield section("The robot and the places", view(study_scene(study, title)))
        yield section("Errors over the places", *_study_pictures(study, pictures))
        yield section("Extreme places", part_table(study, "extremes"))
    if study.workspace is not None:
        yield section("Limits that end the workspace", part_table(study, "ends"))
    if pictures:
        yield section("Effect of each uncertain parameter", *_contributions(study, pictures))
    yield from _ending(found, f"{count(len(found.codes))} {_SHAPES[study.places.shape]}", options)


def _cards(result: AccuracyStudy | AccuracyAtPose, found: Accuracy) -> Iterator[tuple[str, str, str]]:
    """Labels and values of the key figures; no rotations of a point platform, which has none."""
    turns = ("nominal_turn", "max_turn") if found.robot.n == 3 else ()
    return ((*each, "") for each in summary(result, *_IN_VERDICT, *turns))


def _notices(found: Accuracy, notes: tuple[str, ...]) -> Iterator[Html]:
    """Yield what has to be known before a figure is used."""
    for code in np.unique(found.codes):
        if code:
            times, total = count(int((found.codes == code).sum())), count(len(found.codes))
            yield notice(f"at {times} of {total} places: {Status.of(int(code)).value}; they have no answer")
    yield from map(notice, notes)


def _study_verdict(study: AccuracyStudy) -> Html:
    found, spread = study.accuracy, study.accuracy.spread
    if not _answered(found):
        return verdict(
            "Nothing can be said", f"At none of {count(len(found.codes))} places is there an answer.", kind="no"
        )
    nominal, deviation = float(np.nanmax(found.nominal_error)), float(np.nanmax(spread.max_deviation))
    largest, smallest = float(np.nanmax(spread.max_error)), float(np.nanmin(spread.max_error))
    where = COMPENSATIONS[found.compensation].words
    words = (
        f"{_SHAPES[study.places.shape].capitalize()}, {where}, {found.robot.name} prints "
        f"{_up_to(nominal)} off with the numbers of its file, and {quantity(smallest, 'm')} to "
        f"{quantity(largest, 'm')} off at the worst while {_numbers(found)}. "
    )
    if found.compensation == "full":
        words += f"No better model is left: the deviation that they cause, up to {quantity(deviation, 'm')}, remains."
    else:
        rest = quantity(deviation, "m")
        words += f"Full compensation would remove the first; about {rest} would remain until they are known better."
    return verdict(f"Up to {quantity(largest, 'm')} off", words)


def _size(size: float) -> str:
    return quantity(size, "m").replace("<", "less than")


def _up_to(size: float) -> str:
    words = _size(size)
    return words if words.startswith("less") else f"up to {words}"


def _numbers(accuracy: Accuracy) -> str:
    k = len(accuracy.ranges)
    return "one parameter is uncertain" if k == 1 else f"{count(k)} parameters are uncertain"


def _study_pictures(study: AccuracyStudy, pictures: Pictures) -> Iterator[Html]:
    if "workspace" in pictures:
        yield picture(
            pictures["workspace"],
            "The boundary of the workspace in the frame, coloured by the largest error, and an upright section of it",
            "Colour: the largest error at the nearest node of the grid. P1 and P2 are drawn over the boundary, also "
            "where they lie within. In the section: where grid lines leave the workspace, and the limit that ends it.",
        )
    if "plane" in pictures:
        yield picture(
            pictures["plane"],
            "Lowest and highest vertical error over the plane, and a map of the largest error",
            "Left: the nozzle is between the two surfaces, above or below its expected height. Blank: no answer.",
        )
    if "along" in pictures:
        times = displaced_by(study)
        yield picture(
            pictures["along"],
            "The path in the colours of its largest error, and the parts of the error",
            "Left: the thin line is the path under the worst values, with the error drawn "
            f"{times:g} times its size. Right: lines are medians of a stretch, bands reach from its lowest to its "
            "highest value.",
        )


def _contributions(result: AccuracyStudy | AccuracyAtPose, pictures: Pictures) -> Iterator[Html]:
    yield picture(
        pictures["contributions"],
        "Displacement of the nozzle by each uncertain parameter alone",
        "The largest effects, each at the place where it is largest.",
    )
    yield part_table(result, "contributions")


def _place_body(found: AccuracyAtPose, title: str, pictures: Pictures, options: Mapping[str, Any]) -> Iterator[Html]:
    """Yield the page of one pose."""
    accuracy = found.accuracy
    yield element("h1", title)
    yield _place_verdict(found)
    if pictures:
        yield cards(_cards(found, accuracy))
    yield from _notices(accuracy, found.notes)
    if pictures:
        yield section("The robot at the pose", view(place_scene(found, title)))
    if "region" in pictures:
        caption = f"From the nominal position of the nozzle. {count(len(found.region.points))} corners of the ranges."
        alt = "The hull of the positions of the nozzle at the corners of the ranges, and its outlines along the axes"
        inner = () if found.region.interior is None else (part_table(found, "interior"),)
        yield section("Positions that the nozzle can have", picture(pictures["region"], alt, caption), *inner)
    if found.remains:
        yield section("Errors that each compensation leaves", part_table(found, "remains"))
    if found.best is not None:
        yield section("Tensions of smallest deviation", part_table(found, "best_tension"))
    if pictures:
        yield section("Effect of each uncertain parameter", *_contributions(found, pictures))
    yield from _ending(
        accuracy, f"pose {_plain(accuracy.wanted[0])}, m" + (" and rad" * (accuracy.robot.n == 6)), options
    )


def _place_verdict(found: AccuracyAtPose) -> Html:
    accuracy = found.accuracy
    where = _plain(accuracy.wanted_nozzle[0])
    if not _answered(accuracy):
        return verdict("Nothing can be said", f"At {where} m there is no answer.", kind="no")
    largest, nominal = float(accuracy.spread.max_error[0]), float(accuracy.nominal_error[0])
    words = (
        f"At {where} m, {COMPENSATIONS[accuracy.compensation].words}, {accuracy.robot.name} is {_size(nominal)} off "
        f"with the numbers of its file, and up to {quantity(largest, 'm')} off while {_numbers(accuracy)}."
    )
    if "full" in found.remains and accuracy.compensation != "full":
        rest = float(found.remains["full"].spread.max_error[0])
        if rest < largest:
            removed = f"{(1.0 - rest / largest) * 100.0:.3g} %"
            words += f" Full compensation removes {removed} of that; {quantity(rest, 'm')} remain."
        else:
            words += f" Full compensation gains nothing here: {quantity(rest, 'm')} would remain."
    return verdict(f"Up to {quantity(largest, 'm')} off", words)


def _ending(accuracy: Accuracy, places: str, options: Mapping[str, Any]) -> Iterator[Html]:
    rows = [
        *robot_rows(accuracy.robot),
        ("lengths commanded", COMPENSATIONS[accuracy.compensation].words),
        ("places", places),
        ("uncertain parameters", count(len(accuracy.ranges))),
        ("method", accuracy.method),
        *((words, str(options[key])) for key, words in _OPTIONS.items() if options.get(key) is not None),
    ]
    yield section("Inputs", table(("what", "value"), [row for row in rows if row[1]]))
    yield section(
        "What the figures mean", list_of([*_MEANINGS.splitlines(), *(_TURN if accuracy.robot.n == 6 else ())])
    )
    yield section("What is assumed", list_of(assumptions(accuracy.robot)))


def _plain(numbers: np.ndarray) -> str:
    """Coordinates, to a millimetre."""
    return f"({', '.join(f'{round(float(each), 3) + 0.0:g}' for each in numbers)})"


_OPTIONS: Final = {
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
_MEANINGS: Final = """\
Error: distance of the nozzle from its expected position (Δp).
Nominal error (Δp_n): the error if every parameter is as the robot file has it. A better model removes it.
Max error (Δp_max): the largest error found for uncertain parameters within their ranges.
Difference (δp of Paty's Table 1): the max error less the nominal error.
Max deviation: the largest distance of the nozzle from its nominal position (δp of equation 24). No model removes it.
Region (Ω): the hull of the positions of the nozzle at the corners of the ranges.
Effect of a parameter: displacement of the nozzle by half its range alone, in first order, where that is largest.\
"""
"""What the figures mean, with the symbols of Paty et al. 2021."""
_TURN: Final = ("Turn: the angle between the expected rotation of the platform and the one it has.",)
