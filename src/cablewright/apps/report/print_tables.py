"""Tables of a print's report."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.apps.quantities import NOT_KNOWN, count, duration, quantity
from cablewright.apps.report.page import Html, element, short_name, table
from cablewright.apps.report.provenance import program
from cablewright.arrays import Array
from cablewright.studies.prints.result import LineUse, PathFollowing, PrintRecord
from cablewright.studies.prints.structure import PrintedStructure

_GAP: Final = "\N{NO-BREAK SPACE}"
_MAX_FAULTS: Final = 40
_OF_THE_PAPER: Final = "merlet2023"


def following_table(found: PrintRecord) -> Html:
    """Error, height and speed: truly, and as the estimation believed."""
    columns = [(name, of) for name, of in (("true", found.true), ("estimated", found.estimated)) if of.error.count]
    if not columns:
        return element("p", "Not known: the log tells of no step that printed with a position.")
    rows = [
        ("mean error beside the path", *(quantity(of.error.mean, "m") for _, of in columns)),
        ("variance", *(_square_cm(of.error.variance) for _, of in columns)),
        ("standard deviation", *(quantity(of.error.deviation, "m") for _, of in columns)),
        ("largest", *(quantity(of.error.size, "m") for _, of in columns)),
        ("where", *(_where(of) for _, of in columns)),
        ("mean height over what was wanted", *(quantity(of.height.mean, "m") for _, of in columns)),
        ("standard deviation of the height", *(quantity(of.height.deviation, "m") for _, of in columns)),
        ("mean speed", *(_cm(of.speed.mean, "cm/s") for _, of in columns)),
        ("variance of the speed", *(f"{_number(1e4 * of.speed.variance)}{_GAP}(cm/s)²" for _, of in columns)),
    ]
    return table(("while printing", *(name for name, _ in columns)), rows, numbers=range(1, len(columns) + 1))


def _where(of: PathFollowing) -> str:
    worst = of.worst
    if worst is None:
        return ""
    x, y = (f"{v:.2f}".replace("-", "\N{MINUS SIGN}") for v in worst.place)
    return f"layer {worst.layer + 1}, x {x} m, y {y} m, at {duration(worst.time)}"


def paper_table(found: PrintRecord) -> Html | None:
    """The figures that Merlet and Papegay 2023 print beside the same of this print; None for another robot."""
    if found.head.robot.name != _OF_THE_PAPER:
        return None
    true, seen, structure = found.true, found.estimated, found.structure
    mass = NOT_KNOWN if structure is None else _kg(structure.mass)
    places = {} if structure is None else {cut.title: cut for cut in structure.sections}
    heights = {title: quantity(_top(cut.true), "m") for title, cut in places.items()}
    rows = [
        ("mean error beside the path", f"\N{MINUS SIGN}0.026{_GAP}cm", _cm(true.error.mean), _cm(seen.error.mean)),
        ("variance", f"0.0774{_GAP}cm (²)", _square_cm(true.error.variance), _square_cm(seen.error.variance)),
        ("largest", f"4.82{_GAP}cm", _cm(true.error.size), _cm(seen.error.size)),
        ("mean speed", f"3.0168{_GAP}cm/s", _cm(true.speed.mean, "cm/s"), _cm(seen.speed.mean, "cm/s")),
        ("its variance, (cm/s)²", "0.02667", _number(1e4 * true.speed.variance), _number(1e4 * seen.speed.variance)),
        ("layers", "142 (or 146)", count(found.layers), ""),
        ("distance travelled", "about 9 km", quantity(found.travelled, "m"), ""),
        ("hours", "126", f"{found.duration / 3600.0:.2f}", ""),
        ("powder", "2.56 t", mass, "" if structure is None else _kg(structure.estimated_mass)),
        ("stops by the light barrier", "24", count(found.barrier_stops), ""),
        ("height where the path passes once", f"9{_GAP}cm", heights.get("where the path passes once", ""), ""),
        ("greatest height", f"18{_GAP}cm", heights.get("where it is highest", ""), ""),
        ("taut, by line, %", "75, 100, 52, 30", _shares(found, "true_taut"), _shares(found, "taut")),
    ]
    told = (
        "Theirs are of the whole exhibition and as their lidars saw it; the heights are of 1.7 t. They print the "
        "variance in cm. Their lines are numbered, ours named: the order is that of the robot file."
    )
    head = ("", "Merlet, Papegay 2023", "here, true", "here, estimated")
    return element("div", table(head, rows, numbers=(1, 2, 3)), element("p", told, class_="soft"))


def _top(values: Array) -> float:
    return float(values[np.isfinite(values)].max()) if np.isfinite(values).any() else math.nan


def _shares(found: PrintRecord, name: str) -> str:
    shares = [getattr(line, name) for line in found.lines]
    return ", ".join(NOT_KNOWN if math.isnan(share) else f"{1e2 * share:.0f}" for share in shares)


def states_table(found: PrintRecord) -> Html:
    """How long in which state, and how often."""
    whole = max(sum(found.states.values()), 1e-9)
    rows = []
    for state, time in found.states.items():
        reasons = list(dict.fromkeys(span.reason for span in found.spans if span.state is state and span.reason))
        times = sum(span.state is state for span in found.spans)
        shown = "; ".join(reasons[:4]) + ("; …" if len(reasons) > 4 else "")
        rows.append((str(state), duration(time), f"{1e2 * time / whole:.1f} %", count(times), shown))
    return table(("state", "time", "share", "times", "why"), rows, numbers=(1, 2, 3))


def structure_table(structure: PrintedStructure) -> Html:
    """Mass and height, and how like the rebuilt one is."""
    like = structure.difference
    rows = [
        ("mass, true", _kg(structure.mass)),
        ("mass by the scans, where over 5 mm high", _kg(structure.estimated_mass)),
        ("density", f"{structure.density:g}{_GAP}kg/m³"),
        ("greatest height", quantity(structure.highest, "m")),
    ]
    if like is not None:
        rows += [
            ("rebuilt less true, mean", quantity(like.mean, "m")),
            ("rms", quantity(like.rms, "m")),
            ("rms on the structure", quantity(like.on_structure, "m")),
            ("largest", quantity(like.max, "m")),
            ("of the structure's cells seen", f"{1e2 * like.share_seen:.0f} %"),
        ]
    return table(("what", "value"), [row for row in rows if row[1] != NOT_KNOWN], numbers=(1,))


def lines_table(found: PrintRecord) -> Html:
    """Maintenance: what each line bore and did."""
    head = (
        "line", "taut", "most slack", "mean tension", "most tension", "taut for", "cable wound", "coil irregular by",
        "frequency", "by the temperature",
    )  # fmt: skip
    rows = [
        (
            short_name(line.name),
            _both(line.taut, line.true_taut, "%", 1e2),
            quantity(max(line.max_excess, 0.0), "m"),
            _both(line.believed_mean_tension, line.mean_tension, "N", 1.0),
            _both(line.believed_max_tension, line.max_tension, "N", 1.0),
            duration(3600.0 * line.hours),
            quantity(line.wound, "m"),
            _both(line.irregularity, line.true_irregularity, "mm", 1e3, "{:.2f}"),
            quantity(line.frequency, "Hz"),
            _slope(line),
        )
        for line in found.lines
    ]
    made = table(head, rows, numbers=range(1, len(head)))
    note = "Of two values the first is believed, the one in brackets true." if found.has_truth else ""
    return element("div", made, element("p", note, class_="soft")) if note else made


def _slope(line: LineUse) -> str:
    if math.isnan(line.frequency_slope):
        return NOT_KNOWN
    return f"{1e2 * line.frequency_slope:+.2f} ± {1e2 * line.frequency_slope_sigma:.2f} %/K".replace(
        "-", "\N{MINUS SIGN}"
    )


def _both(seen: float, true: float, unit: str, scale: float, form: str = "{:.0f}") -> str:
    """A believed value, and in brackets the true one where it is known."""
    told = NOT_KNOWN if math.isnan(seen) else form.format(scale * seen)
    more = "" if math.isnan(true) else f" ({form.format(scale * true)})"
    return NOT_KNOWN if told == NOT_KNOWN and not more else f"{told}{more}{_GAP}{unit}"


def faults_table(found: PrintRecord) -> Html:
    """What the estimation noticed and what the machine said."""
    rows = [
        (source, sentence, f"{since:.1f} to {until:.1f} s", count(steps))
        for (source, sentence), (since, until, steps) in list(found.faults.items())[:_MAX_FAULTS]
    ]
    rows += [("machine", text, "", count(steps)) for text, steps in found.notices.most_common(_MAX_FAULTS)]
    if not rows:
        return element("p", "Nothing that the estimation or the machine would have noticed.")
    return table(("source", "what", "when", "steps"), rows, numbers=(3,))


def went_in(found: PrintRecord, name: str) -> Html:
    """Robot, machine, job, program."""
    head = found.head
    rows = [
        ("robot", head.robot.name),
        ("machine", f"{head.settings.name}, {head.plant} plant, seed {head.seed}"),
        ("job", name),
        ("path", f"{quantity(found.track.length, 'm')} in {count(len(found.track.visits.begin))} visits of layers"),
        ("step", f"{1e3 * head.period:g}{_GAP}ms, {count(found.steps)} of them"),
        ("temperature", _range(found.temperature.min, found.temperature.max, "°C")),
        ("humidity", _range(1e2 * found.humidity.min, 1e2 * found.humidity.max, "%")),
        ("program", program()),
    ]
    return table(("what", "value"), [row for row in rows if row[1]])


def _range(low: float, high: float, unit: str) -> str:
    return "" if math.isnan(low) else f"{low:.1f} to {high:.1f}{_GAP}{unit}"


def _cm(value: float, unit: str = "cm") -> str:
    return NOT_KNOWN if math.isnan(value) else f"{_number(1e2 * value)}{_GAP}{unit}"


def _square_cm(value: float) -> str:
    return NOT_KNOWN if math.isnan(value) else f"{_number(1e4 * value)}{_GAP}cm²"


def _kg(value: float) -> str:
    return NOT_KNOWN if math.isnan(value) else f"{value:.4g}{_GAP}kg"


def _number(value: float) -> str:
    return NOT_KNOWN if math.isnan(value) else f"{value:.4g}".replace("-", "\N{MINUS SIGN}")
