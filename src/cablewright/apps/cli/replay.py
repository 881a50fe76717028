"""`replay`: estimation run again on a machine's log, and how far it was off where the log has the truth."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import AsJson, Plot, check_plot
from cablewright.apps.cli.output import numbers, print_json, progress, tell, write_picture
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.estimation.lidar.room import Laser

_NOTHING = "no step of the log has a valid estimate"
_KINDS = ("in space   ", "from above ", "in height  ")
_ORDER = (
    "valid    ",
    *(f"{name:<9} {kind}" for name in ("static", "moving") for kind in _KINDS),
    *("ellipsoid", "yaw      ", "tilt     ", "taut     ", "slack    ", "radius   ", "step     "),
)
"""In which order lines are told."""
_BOTH = ("paper", "filter")


def replay(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A machine's log, MCAP, or the folder of a run.")],
    estimator: Annotated[
        str,
        typer.Option(
            "--estimator", help="paper: the chain of Merlet and Papegay 2023; filter: one of all sensors; both."
        ),
    ] = "paper",
    laser: Annotated[
        str | None, typer.Option("--laser", metavar="WALL=D[,..]", help="Measured from B to a wall at the start, m.")
    ] = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """Run the estimation on a log: position, slack line and winch drums' radii, beside the truth where it is there."""
    from cablewright.studies.replay import replay as run

    check_plot(plot)
    lasers = [] if laser is None else _lasers(laser)
    names = _BOTH if estimator == "both" else (estimator,)
    with progress() as tells:
        all_found = [run(log, name, lasers=lasers, progress=tells) for name in names]
    if plot is not None:
        from cablewright.apps.pictures.replay import replay_picture

        write_picture(plot, replay_picture, all_found)
    each = [found.to_dict() | {"plot": None if plot is None else str(plot)} for found in all_found]
    if as_json:
        print_json(each[0] if len(each) == 1 else _together(each))
    else:
        _print(each)
    for note in all_found[0].notes:
        tell(f"{log}: {note}")
    lost = [found.estimator for found in all_found if not found.valid]
    if lost:
        tell(_NOTHING if len(names) == 1 else f"{_NOTHING}: {', '.join(lost)}")
        return 1
    return 0


def _together(each: list[dict[str, Any]]) -> dict[str, Any]:
    """One object of several estimators' values: what is the log's once, the rest by name."""
    shared = ("log", "robot", "plant", "seed", "steps", "duration", "lines", "notes", "plot")
    status = "ok" if all(values["status"] == "ok" for values in each) else "lost"
    named = {values["estimator"]: {key: value for key, value in values.items() if key not in shared} for values in each}
    return {"status": status} | {key: each[0][key] for key in shared} | {"estimators": named}


def _lasers(text: str) -> list[Laser]:
    """The value of --laser. Raises `InputError`."""
    from cablewright.estimation.lidar.room import Laser

    found = []
    for part in text.split(","):
        wall, _, value = part.partition("=")
        distance = numbers(value.strip() or "nan", "--laser") or [math.nan]
        if not (wall.strip() and distance[0] > 0.0 and math.isfinite(distance[0])):
            raise InputError(f"--laser = {text!r}: WALL=D is wanted, D over 0 in m, like east=1.32")
        found.append(Laser(wall.strip(), distance[0]))
    return found


def _print(each: list[dict[str, Any]]) -> None:
    """The summary for people; of two estimators, line by line one under the other."""
    first = each[0]
    names = " and ".join(values["estimator"] for values in each)
    about = f"{first['robot']}: {first['duration']:.1f} s of the {first['plant']} plant, seed {first['seed']}"
    typer.echo(f"{about}, estimator{'s' if len(each) > 1 else ''} {names}")
    told = [_lines(values) for values in each]
    labels = list(dict.fromkeys(label for lines in told for label in lines))
    order = {label: i for i, label in enumerate(_ORDER)}
    for label in sorted(labels, key=lambda one: order.get(one, len(order))):
        for values, lines in zip(each, told, strict=True):
            whose = f"{values['estimator']:<8}" if len(each) > 1 else ""
            if label in lines:
                typer.echo(f"{label} {whose}{lines[label]}")
    for values in each:
        whose = f"{values['estimator']:<8}" if len(each) > 1 else ""
        for fault in values["faults"]:
            since = f"{fault['from']:.2f} to {fault['to']:.2f} s"
            typer.echo(f"fault     {whose}{fault['source']}: {fault['sentence']}; {since}")
    if first["plot"] is not None:
        typer.echo(f"written   {first['plot']}")


def _lines(values: dict[str, Any]) -> dict[str, str]:
    """What is told of one estimator, by what stands before it."""
    lines = {"valid    ": f"{100 * values['valid_share']:.1f} % of {values['steps']} steps"}
    for name in ("static", "moving"):
        for what, text in (("position", "in space"), ("level", "from above"), ("height", "in height")):
            each = values[name][what]
            if each["count"]:
                lines[f"{name:<9} {text:<11}"] = _millimetres(each)
    if values["coverage"] is not None:
        lines["ellipsoid"] = (
            f"{100 * values['coverage']:.1f} % of errors within the one of 95 %, nees {values['nees']:.2f}"
        )
    for name in ("yaw", "tilt"):
        if values[name]["count"]:
            each = {key: math.degrees(value) for key, value in values[name].items() if key != "count"}
            lines[f"{name:<9}"] = f"rms {each['rms']:.3f}°, 95 % {each['p95']:.3f}°, at most {each['most']:.3f}°"
    shares = (f"{name} {100 * share:.0f} %" for name, share in zip(values["lines"], values["taut_share"], strict=True))
    lines["taut     "] = f"{', '.join(shares)} of the time"
    slack = values["slack"]
    if slack["steps"]:
        named = f"named rightly in {100 * slack['named_share']:.2f} % of {slack['steps']} steps over 5 mm"
        lines["slack    "] = f"{named}; excess {_millimetres(slack['excess'])}"
    within = values["radius"]["within_1_percent"]
    if within is not None:
        shares = (f"{100 * share:.0f} %" for share in within)
        sizes = (f"{100 * each['rms']:.2f} %" for each in values["radius"]["each"])
        lines["radius   "] = f"within 1 % in {', '.join(shares)} of steps after 10 s; rms {', '.join(sizes)}"
    times = values["step_time"]
    if times["mean"] is not None:
        lines["step     "] = (
            f"{1e6 * times['mean']:.0f} us mean, {1e3 * times['p99']:.2f} ms in 99 of 100, processor time"
        )
    return lines


def _millimetres(each: dict[str, Any]) -> str:
    rms, p95, largest = (1e3 * each[key] for key in ("rms", "p95", "most"))
    return f"rms {rms:.1f} mm, 95 % {p95:.1f} mm, at most {largest:.1f} mm"
