"""The reports of `cablewright accuracy`: how far off a robot prints, over a shape or at one place."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.analyses.accuracy.nozzle_error import Accuracy
from cablewright.analyses.accuracy.region import Interior, Region
from cablewright.apps import style
from cablewright.apps.pictures.accuracy import along, contributions, displaced_by, plane
from cablewright.apps.pictures.boundary_limits import workspace
from cablewright.apps.pictures.region import region as region_picture
from cablewright.apps.quantities import count, quantity
from cablewright.apps.report import accuracy_tables as tell
from cablewright.apps.report.page import Html, cards, element, page, picture, section
from cablewright.apps.report.provenance import assumptions, list_of
from cablewright.file_output import write_whole
from cablewright.studies.accuracy import AccuracyStudy

Pictures = dict[str, bytes]

_SHAPES: Final = {
    "helix": "along a helix",
    "path": "along a path",
    "plane": "over a plane",
    "workspace": "over the workspace",
}


def write(study: AccuracyStudy, folder: Path, options: Mapping[str, Any] | None = None) -> Path:
    """Write ``report.html`` of a study and its pictures into ``folder``, which exists; return the report's path.

    *options* are those of the command; the page names what changed its figures. It holds its pictures and asks nothing
    of any other place. The same study gives the same bytes. Raises `EnvironmentFault` where it cannot be written.
    """
    drawn = _pictures(study) if _answered(study.accuracy) else {}
    title = f"Accuracy of {study.accuracy.robot.name} {_SHAPES[study.places.shape]}"
    return _written(folder, title, drawn, lambda pictures: _study_body(study, title, pictures, options or {}))


def write_place(
    accuracy: Accuracy,
    region: Region | None,
    tables: Mapping[str, Any],
    folder: Path,
    options: Mapping[str, Any] | None = None,
) -> Path:
    """Write ``report.html`` of one place, as `write` does. *tables* are the figures of the command's JSON, SI."""
    drawn = {}
    if _answered(accuracy):
        with style.drawing():
            drawn["contributions"] = style.png(contributions(accuracy))
            if region is not None and len(region.points):
                drawn["region"] = style.png(region_picture(region))
    title = f"Accuracy of {accuracy.robot.name} at one place"
    return _written(
        folder, title, drawn, lambda pictures: _place_body(accuracy, region, tables, title, pictures, options or {})
    )


def _written(folder: Path, title: str, drawn: Pictures, body: Callable[[Pictures], Iterator[Html]]) -> Path:
    for name, png in drawn.items():
        write_whole(folder / f"{name}.png", png)
    report = folder / "report.html"
    write_whole(report, page(title, body(drawn), "").encode("utf-8"))
    return report


def _pictures(study: AccuracyStudy) -> Pictures:
    """Draw what there is to draw of a shape."""
    with style.drawing():
        drawn: dict[str, Figure | None] = {"contributions": contributions(study.accuracy)}
        match study.places.shape:
            case "workspace":
                drawn["workspace"] = workspace(study)
            case "plane":
                drawn["plane"] = plane(study)
            case _:
                drawn["along"] = along(study)
        return {name: style.png(figure) for name, figure in drawn.items() if figure is not None}


def _answered(accuracy: Accuracy) -> bool:
    return bool(np.isfinite(accuracy.spread.max_error).any())


def _study_body(study: AccuracyStudy, title: str, pictures: Pictures, options: Mapping[str, Any]) -> Iterator[Html]:
    """Yield the page of a shape."""
    found = study.accuracy
    yield element("h1", title)
    yield _study_verdict(study)
    if pictures:
        yield cards(_study_figures(study))
    yield from tell.notices(found, study)
    if pictures:
        yield section("How far off", *_study_pictures(study, pictures))
        yield section("Extreme places", tell.extremes_table(study))
    if study.workspace is not None:
        yield section("What ends the workspace", tell.ends_table(study))
    if pictures:
        yield section("What each uncertain number does", *_contributions(found, pictures))
    yield from _ending(found, f"{count(len(found.codes))} {_SHAPES[study.places.shape]}", options)


def _study_verdict(study: AccuracyStudy) -> Html:
    found, spread = study.accuracy, study.accuracy.spread
    if not _answered(found):
        return _verdict("Nothing can be said", f"At none of {count(len(found.codes))} places is there an answer.", "no")
    nominal, deviation = float(np.nanmax(found.nominal_error)), float(np.nanmax(spread.max_deviation))
    largest, smallest = float(np.nanmax(spread.max_error)), float(np.nanmin(spread.max_error))
    where = COMPENSATIONS[found.compensation].words
    told = (
        f"{_SHAPES[study.places.shape].capitalize()}, {where}, {found.robot.name} prints "
        f"{_up_to(nominal)} off with the numbers of its file, and {quantity(smallest, 'm')} to "
        f"{quantity(largest, 'm')} off at the worst while {_numbers(found)}. "
    )
    if found.compensation == "full":
        told += f"No better model is left: the deviation that they cause, up to {quantity(deviation, 'm')}, remains."
    else:
        rest = quantity(deviation, "m")
        told += f"Full compensation would remove the first; about {rest} would remain until they are known better."
    return _verdict(f"Up to {quantity(largest, 'm')} off", told)


def _size(size: float) -> str:
    return quantity(size, "m").replace("<", "less than")


def _up_to(size: float) -> str:
    told = _size(size)
    return told if told.startswith("less") else f"up to {told}"


def _numbers(accuracy: Accuracy) -> str:
    k = len(accuracy.ranges)
    return "one number is uncertain" if k == 1 else f"{count(k)} numbers are uncertain"


def _verdict(word: str, told: str, kind: str = "") -> Html:
    shown = f"verdict {kind}".strip()
    return element("div", element("strong", word), element("p", told), class_=shown, role="status")


def _study_figures(study: AccuracyStudy) -> Iterator[tuple[str, str, str]]:
    """Yield what, how much and a note."""
    found, spread = study.accuracy, study.accuracy.spread
    where = "largest of all places"
    yield "max error", quantity(float(np.nanmax(spread.max_error)), "m"), "Δp_max, largest"
    yield "max error", quantity(float(np.nanmin(spread.max_error)), "m"), "Δp_max, smallest"
    yield "nominal error", quantity(float(np.nanmax(found.nominal_error)), "m"), f"Δp_n, {where}"
    yield "difference", quantity(float(np.nanmax(found.difference)), "m"), f"δp, {where}"
    yield "max deviation", quantity(float(np.nanmax(spread.max_deviation)), "m"), f"from nominal, {where}"
    across = np.linalg.norm(found.worst_offset[:, :2], axis=1)
    yield "horizontal", quantity(float(np.nanmax(across)), "m"), f"part of the max error, {where}"
    yield "vertical", quantity(float(np.nanmax(np.abs(found.worst_offset[:, 2]))), "m"), f"part of it, {where}"
    if found.robot.n == 6:
        yield "turn", quantity(float(np.nanmax(spread.max_turn)), "rad"), f"from the wanted rotation, {where}"
    yield "places", count(int(found.ok.sum())), f"with an answer, of {count(len(found.codes))}"
    if study.workspace is not None:
        yield "workspace", f"{study.workspace.nodes.trapezoid_volume:.4g} m³", "accessible, by its nodes"


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
            "Left: between the two surfaces the nozzle may be, above or below where it is wanted. Blank: no answer.",
        )
    if "along" in pictures:
        times = displaced_by(study)
        yield picture(
            pictures["along"],
            "The path in the colours of its largest error, and the parts of the error",
            "Left: the thin line is the path as it would be with the worst numbers, with the error drawn "
            f"{times:g} times its size. Right: lines are medians of a stretch, bands reach from its lowest to its "
            "highest value.",
        )


def _contributions(accuracy: Accuracy, pictures: Pictures) -> Iterator[Html]:
    told = (
        "The largest effects, at the place where each is most." if len(accuracy.codes) > 1 else "The largest effects."
    )
    yield picture(pictures["contributions"], "Displacement of the nozzle by each uncertain number alone", told)
    yield tell.contributions_table(accuracy)


def _ending(accuracy: Accuracy, places: str, options: Mapping[str, Any]) -> Iterator[Html]:
    yield section("What went in", tell.inputs_table(accuracy, places, options))
    yield section("What the figures mean", list_of(tell.meanings(accuracy.robot.n)))
    yield section("What is assumed", list_of(assumptions(accuracy.robot)))


def _place_body(
    accuracy: Accuracy,
    region: Region | None,
    tables: Mapping[str, Any],
    title: str,
    pictures: Pictures,
    options: Mapping[str, Any],
) -> Iterator[Html]:
    """Yield the page of one place."""
    yield element("h1", title)
    yield _place_verdict(accuracy, tables)
    if pictures:
        yield cards(_place_figures(accuracy, tables))
    yield from tell.notices(accuracy)
    if region is not None and "region" in pictures:
        yield section("Where the nozzle may be", *_region(region, pictures))
    if tables.get("remains"):
        yield section("What each compensation leaves", tell.remains_table(tables["remains"]))
    if tables.get("best_tension"):
        yield section("Tensions that let the numbers do least", *_best(accuracy, tables["best_tension"]))
    if pictures:
        yield section("What each uncertain number does", *_contributions(accuracy, pictures))
    where = f"pose {tell.plain(accuracy.wanted[0])}, m" + (" and rad" * (accuracy.robot.n == 6))
    yield from _ending(accuracy, where, options)


def _place_verdict(accuracy: Accuracy, tables: Mapping[str, Any]) -> Html:
    where = tell.plain(accuracy.wanted_nozzle[0])
    if not _answered(accuracy):
        return _verdict("Nothing can be said", f"At {where} m there is no answer.", "no")
    largest = tell.number(tables, "max_error")
    told = (
        f"At {where} m, {COMPENSATIONS[accuracy.compensation].words}, {accuracy.robot.name} is "
        f"{_size(tell.number(tables, 'nominal_error'))} off with the numbers of its file, and up to "
        f"{quantity(largest, 'm')} off while {_numbers(accuracy)}."
    )
    left = next((row for row in tables.get("remains", ()) if row["compensation"] == "full"), None)
    if left is not None and accuracy.compensation != "full":
        rest = tell.number(left, "max_error")
        if rest < largest:
            told += (
                f" Full compensation removes {tell.share(1.0 - rest / largest)} of that; {quantity(rest, 'm')} remain."
            )
        else:
            told += f" Full compensation gains nothing here: {quantity(rest, 'm')} would remain."
    return _verdict(f"Up to {quantity(largest, 'm')} off", told)


def _place_figures(accuracy: Accuracy, tables: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    spread = accuracy.spread
    for key, note in (
        ("nominal_error", "Δp_n"),
        ("max_error", "Δp_max"),
        ("difference", "δp: max less nominal"),
        ("max_deviation", "from nominal"),
    ):
        yield key.replace("_", " "), quantity(tell.number(tables, key), "m"), note
    if np.isfinite(spread.likely_error[0]):
        yield "likely error", quantity(float(spread.likely_error[0]), "m"), "95 % of samples stay within it"
    yield "standard deviation", quantity(float(np.linalg.norm(spread.deviation[0])), "m"), "of all axes together"
    if accuracy.robot.n == 6:
        yield "turn", quantity(float(spread.max_turn[0]), "rad"), "from the wanted rotation, largest"
    yield "region", tell.volume(tell.number(tables, "hull_volume")), "volume of Ω"


def _region(region: Region, pictures: Pictures) -> Iterator[Html]:
    yield picture(
        pictures["region"],
        "The hull of the places to which the corners of the ranges take the nozzle, and its outlines along the axes",
        f"From where the nominal numbers take the nozzle. {count(len(region.points))} corners of the ranges.",
    )
    if region.interior is not None:
        yield element("p", _inner(region.interior))


def _inner(found: Interior) -> str:
    tried = (
        f"{count(found.samples)} points within the ranges were tried, and the error was climbed from {found.climbs}."
    )
    if found.corner_is_worst:
        return f"{tried} None is worse than the corners."
    return (
        f"{tried} Some are worse than all corners: up to {quantity(found.max_error, 'm')} off, "
        f"{quantity(found.max_deviation, 'm')} from the nominal place. The figures of the corners are too small."
    )


def _best(accuracy: Accuracy, best: Mapping[str, Any]) -> Iterator[Html]:
    gain, held = tell.number(best, "gain"), quantity(tell.number(best, "max_deviation"), "m")
    usual = quantity(tell.number(best, "least_norm_max_deviation"), "m")
    yield element(
        "p",
        f"With more lines than freedoms tensions can be chosen. Those below leave a max deviation of {held} instead of "
        f"{usual} with the tensions of least norm: a gain of {tell.share(gain)}.",
    )
    yield tell.tensions_table(accuracy, best["tensions"])
