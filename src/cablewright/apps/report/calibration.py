"""The report of `cablewright calibrate`: what was found, how well it is known, what the data leave open."""

from __future__ import annotations

from collections.abc import Iterator

from cablewright.apps import style
from cablewright.apps.pictures.calibration import correlation_picture, exits_picture, residuals_picture
from cablewright.apps.report.page import Html, cards, element, page, picture, section, table
from cablewright.apps.report.provenance import list_of, program
from cablewright.apps.report.quantities import count, quantity
from cablewright.calibration.result import Calibration

Pictures = dict[str, bytes]


def calibration_page(found: Calibration, data: str) -> str:
    """Return the page as HTML; *data* names the file of the measurements. The same calibration gives the same text."""
    title = f"Calibration of {found.problem.robot.name}"
    return page(title, _body(found, title, data, _pictures(found)), "")


def _pictures(found: Calibration) -> Pictures:
    if found.status != "ok":
        return {}
    with style.drawing():
        drawn = {
            "residuals": residuals_picture(found),
            "exits": exits_picture(found),
            "correlation": correlation_picture(found),
        }
        return {name: style.png(figure) for name, figure in drawn.items() if figure is not None}


def _body(found: Calibration, title: str, data: str, pictures: Pictures) -> Iterator[Html]:
    yield element("h1", title)
    yield _verdict(found)
    yield cards(_figures(found))
    for note in found.notes:
        yield element("p", note[0].upper() + note[1:] + ".", class_="notice")
    if found.status == "ok":
        yield section("What the data leave open", *_open(found))
        yield section("Values", _values(found))
        yield section("What is left of the lengths", *_residuals(found, pictures))
        yield section("How well exit points are known", *_exits(pictures))
        yield section("What one more measurement would bring", *_suggestions(found))
    yield section("What went in", _inputs(found, data))
    yield section("What is assumed", list_of(_assumed(found)))


def _verdict(found: Calibration) -> Html:
    good = found.status == "ok"
    word = "Calibrated" if good else "Not calibrated"
    told = (
        f"Lengths of {count(found.problem.poses)} poses fit to {quantity(found.rms, 'm')} rms."
        if good
        else found.reason
    )
    kind = "yes" if good else "no"
    return element("div", element("strong", word), element("p", told), class_=f"verdict {kind}", role="status")


def _figures(found: Calibration) -> Iterator[tuple[str, str, str]]:
    given = found.problem.plan.sigma.encoder is not None
    spoiled = len({each.pose for each in found.rejected})
    yield "poses", count(found.problem.poses), f"{count(spoiled)} with something left out" if spoiled else "all count"
    yield "left over", quantity(found.rms, "m"), "rms of the lengths that count"
    yield "encoders", quantity(found.encoder_sigma, "m"), "sigma, given" if given else "sigma, from what is left over"
    yield "unknowns", count(found.alone.total), "poses counted"
    yield "decided", count(found.alone.rank), "by the data alone"
    yield "steps", count(found.iterations), f"best of {found.fit.starts} starts"


def _open(found: Calibration) -> Iterator[Html]:
    if found.gauge:
        yield element("p", "No measurement here sees these; the datum decides them:")
        yield list_of(list(found.gauge))
    else:
        yield element("p", "Nothing: the data decide all that is looked for.")
    held = ", ".join(found.problem.plan.datum)
    if held and held != "inner":
        yield element("p", f"Datum: {held} as in the robot file.")
    else:
        yield element("p", "Datum: inner. Exit points, as a whole, keep the place and direction of the robot file.")
    rows = [(each.words, quantity(each.sigma, each.unit)) for each in found.weakest]
    yield element("p", "The least known of what is not open:")
    yield table(("combination", "sigma"), rows, numbers=(1,))


def _values(found: Calibration) -> Html:
    rows = []
    start = found.problem.start
    for at, unknown in enumerate(found.unknowns):
        before = None if unknown.name == "length_offset" else start[at] * unknown.size
        value, sigma = found.values[at], found.sigma[at]
        change = "" if before is None else f"{(value - before) * 1e3:+.3f}"
        if unknown.unit == "m":
            rows.append((unknown.label, f"{value:.6f} m", f"{change} mm" if change else "", f"{sigma * 1e3:.3g} mm"))
        else:
            told = "" if before is None else f"{value - before:+.3g}"
            rows.append((unknown.label, f"{value:.9g} {unknown.unit}", told, f"{sigma:.3g} {unknown.unit}"))
    return table(("unknown", "value", "change", "sigma"), rows, numbers=(1, 2, 3))


def _residuals(found: Calibration, pictures: Pictures) -> Iterator[Html]:
    yield picture(
        pictures["residuals"],
        "What is left of each line's length at each pose",
        "One mark for each length that counts. A pose takes up as many of its errors as it has freedoms, so what is "
        "left is smaller than the encoders' sigma.",
    )
    if found.rejected:
        place = found.problem.measured.place
        rows = [
            (
                str(each.pose + 1),
                place(each.pose),
                f"{each.sensor} of {each.line}" if each.line else "not told by the others",
                quantity(each.size, each.unit),
            )
            for each in found.rejected
        ]
        yield table(("pose", "where", "line", "off by"), rows, numbers=(0, 3))


def _exits(pictures: Pictures) -> Iterator[Html]:
    if "exits" in pictures:
        yield picture(
            pictures["exits"],
            "Exit points from above and from the side with their sigma ellipses, enlarged",
            "In the frame of the datum. Ellipses hold 39 % of the probability of two coordinates.",
        )
    if "correlation" in pictures:
        yield picture(
            pictures["correlation"],
            "Matrix of the correlations of all unknowns",
            "Dark: one of the two is known only as well as the other. Columns are in the order of the rows.",
        )
    if not pictures.keys() & {"exits", "correlation"}:
        yield element("p", "Not drawn.")


def _suggestions(found: Calibration) -> Iterator[Html]:
    if not found.suggestions:
        yield element("p", "Not told.")
        return
    rows = [
        (
            each.words,
            quantity(each.before, "m"),
            quantity(each.after, "m"),
            f"{each.open_before} to {each.open_after}",
        )
        for each in found.suggestions[:8]
    ]
    yield element("p", "Sigma of the exit points' coordinates, rms, before and after, in the frame of the inner datum.")
    yield table(("measurement", "before", "after", "open freedoms"), rows, numbers=(1, 2))


def _inputs(found: Calibration, data: str) -> Html:
    plan, robot = found.problem.plan, found.problem.robot
    rows = [
        ("robot", robot.name),
        ("measurements", data),
        ("looked for", ", ".join(plan.unknowns)),
        ("one number for all lines", ", ".join(plan.shared)),
        ("datum", ", ".join(plan.datum) or "inner"),
        ("priors", ", ".join(f"{each.name} ±{each.deviation:g}" for each in plan.priors)),
        ("program", program()),
    ]
    return table(("what", "value"), [row for row in rows if row[1]])


def _assumed(found: Calibration) -> list[str]:
    lines = {
        "rigid": "Lines are straight and do not stretch; sheaves swivel about a vertical axis without friction.",
        "elastic": "Lines are straight and stretch; sheaves are as in the robot file, without friction.",
        "catenary": "Lines stretch and sag; sheaves are as in the robot file, without friction.",
    }
    begin = "the winch exit, unstrained" if found.problem.elastic else "the exit point"
    return [
        lines[found.problem.cable],
        "Errors of each kind of sensor are independent, normal and alike in all lines and poses.",
        "Sigma is of the first order: where a tilt is known to a few degrees only, its errors are not normal.",
        f"Lengths count from {begin}; home lengths are those where counts are zero, whichever pose that is.",
    ]
