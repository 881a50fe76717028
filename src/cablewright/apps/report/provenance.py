"""Inputs of a report, and assumptions of the model, as the robot file states them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.metadata import PackageNotFoundError, version

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.apps.quantities import NOT_KNOWN, count, quantity
from cablewright.apps.report.check_summary import Digest
from cablewright.apps.report.page import Html, element, table
from cablewright.printing.schedule import ScheduleStep
from cablewright.robot import Line, Robot

_MAX_HEIGHTS = 6


def inputs_table(digest: Digest) -> Html:
    """Return robot, job, sampling and program, one per row."""
    check = digest.check
    robot, job, bead = check.robot, check.job, check.beads.typical
    rows = [
        *robot_rows(robot),
        ("external force", _wrench(robot)),
        ("schedule", _schedule(job.schedule)),
        ("job", job.name),
        ("path", job.source),
        ("scale", f"{job.scale:g}; the path's zero is at {_point(job.origin)} m"),
        ("bead", f"{quantity(bead.width, 'm')} wide, {quantity(bead.height, 'm')} high: {check.beads.source}"),
        ("speeds", _speeds(digest)),
        ("samples", f"{count(len(check.samples))}, at most every {quantity(check.step, 'm')}"),
        ("G-code words without effect", _words(check.toolpath.unknown)),
    ]
    return table(("what", "value"), [row for row in rows if row[1]])


def _words(unknown: dict[str, int]) -> str:
    return ", ".join(f"{word} ({times}×)" for word, times in unknown.items())


def robot_rows(robot: Robot) -> list[tuple[str, str]]:
    """Return the rows about the robot and the program."""
    platform, lines = robot.platform, f"{robot.m} line{'' if robot.m == 1 else 's'}"
    return [
        ("program", program()),
        ("robot", robot.name),
        ("description", robot.description),
        ("source of the robot", robot.source),
        ("platform", f"{platform.words} of {platform.mass:g} kg on {lines}"),
    ]


def assumptions(robot: Robot) -> list[str]:
    """Return the model's assumptions, line by line where the lines differ."""
    return [
        (
            "Lengths and tensions are those of hanging, elastic cables (catenaries) in equilibrium with the platform. "
            "The platform swings about them as a linear system of its mass, the stiffness at each sample and the same "
            f"damping of every mode, {robot.damping}, while lengths go linearly in time between samples."
        ),
        (
            f"Lengths paid out {COMPENSATIONS['none'].words} are those of straight cables that do not stretch, "
            f"{COMPENSATIONS['elastic'].words} those of straight cables that stretch. Where the platform then hangs is "
            "found with the full model."
        ),
        f"How cables leave their mountings: {_shared(robot, _sheave)}.",
        f"What holds them there: {_shared(robot, _mount)}.",
        f"The arc of cable on the sheave: {_shared(robot, _arc)}.",
        f"The span from the winch: {_shared(robot, _dead_span)}.",
        f"At the other end: {_shared(robot, lambda line: line.holder)}.",
        f"From there to the platform: {_shared(robot, _free_spans)}.",
        robot.platform.assumption,
        "Winch torque is the tension at the drum times its radius, of one layer of cable, without losses.",
        *_on_one_drum(robot),
        (
            "Everything is calculated from the robot file. It says nothing of a machine that was built differently, of "
            "wear or of wind, and it takes the place of no guard or test."
        ),
    ]


def _wrench(robot: Robot) -> str:
    """Say what acts on the platform besides its weight; nothing where nothing does."""
    force, moment = robot.platform.force, robot.platform.moment
    told = f"{_point(force)} N" if any(force) else ""
    return told + (f" and {_point(moment)} N m" if any(moment) else "")


def _schedule(schedule: tuple[ScheduleStep, ...]) -> str:
    """Say in words what the job sets by height."""
    told = []
    for height in schedule:
        parts = [f"at {height.z:g} m"]
        if height.rotation is not None:
            parts.append(f"rotation {_point(height.rotation)} rad")
        if height.retraction is not None:
            parts.append(f"retraction {height.retraction:g} m")
        told.append(" ".join(parts))
    shown = told if len(told) <= _MAX_HEIGHTS else [*told[: _MAX_HEIGHTS - 1], f"{len(told) - _MAX_HEIGHTS + 1} more"]
    return "; ".join(shown)


def list_of(texts: list[str]) -> Html:
    """Return sentences as an HTML list."""
    return element("ul", *(element("li", text) for text in texts))


def _shared(robot: Robot, tell: Callable[[Line], str]) -> str:
    """Say what ``tell`` says of the lines: once, or with the names of those it holds for."""
    groups: dict[str, list[str]] = {}
    for line in robot.lines:
        groups.setdefault(tell(line), []).append(line.name)
    if len(groups) == 1:
        return next(iter(groups))
    return "; ".join(f"{text} ({', '.join(names)})" for text, names in groups.items())


def _sheave(line: Line) -> str:
    sheave = line.sheave
    if sheave.kind == "eyelet":
        return "through an eyelet, a fixed point"
    if sheave.kind == "pulley":
        return f"over a pulley of {quantity(sheave.radius, 'm')} radius in a fixed plane"
    over = f"{sheave.wrap} a sheave of {quantity(sheave.radius, 'm')} radius"
    if sheave.kind == "swivel":
        return f"{over} that swivels about {sheave.axis_words} without friction"
    return (
        f"{over} on a lever of {quantity(sheave.lever, 'm')} that turns freely and hangs as forces and weight take it"
    )


def _mount(line: Line) -> str:
    compliance = line.exit_compliance
    if compliance is None:
        return "stands still"
    if isinstance(compliance, float):
        return f"gives by {1e6 * compliance:g} mm per kN in any direction"
    return f"gives, by up to {1e6 * max(row[i] for i, row in enumerate(compliance)):.3g} mm per kN along an axis"


def _arc(line: Line) -> str:
    if line.has_arc:
        return "stretches" if line.arc_elastic else "does not stretch"
    return "none"


def _dead_span(line: Line) -> str:
    if line.winch_exit is not None:
        return f"modelled{line.way}, {'stretches' if line.dead_elastic else 'does not stretch'}"
    return f"a constant {quantity(line.dead_length, 'm')} that does not stretch" if line.dead_length else "not modelled"


def _on_one_drum(robot: Robot) -> Iterator[str]:
    for line in robot.lines:
        if line.shared_winch is not None:
            own = line.shared_winch
            yield f"Line {line.name} is on the drum of line {own.line}, and winds {own.winds} it; torques are of both."


def _free_spans(line: Line) -> str:
    spans = "one span" if line.advantage == 1 else f"{line.advantage} spans over pulleys without friction"
    if line.platform_sheave is not None:
        spans = f"one span to a sheave of {quantity(line.platform_sheave.radius, 'm')} radius on the platform"
    return spans if line.cables == 1 else f"{spans} of each of {line.cables} cables side by side"


def _speeds(digest: Digest) -> str:
    motion = digest.check.job.motion
    speeds = f"at most {motion.print_speed:g} m/s printing and {motion.travel_speed:g} m/s travelling"
    if motion.speed == "fastest":
        speeds = "as fast as winches, flow and the speeds that the job gives allow"
    return (
        f"{speeds}, acceleration "
        f"{motion.acceleration:g} m/s², corners rounded for the speed by {quantity(motion.corner, 'm')}"
    )


def _point(point: tuple[float, float, float]) -> str:
    return "(" + ", ".join(f"{v:g}" for v in point) + ")"


def program() -> str:
    """Return name and version of the program that wrote the page."""
    try:
        return f"cablewright {version('cablewright')}"
    except PackageNotFoundError:  # run from its sources
        return f"cablewright {NOT_KNOWN}: not installed"
