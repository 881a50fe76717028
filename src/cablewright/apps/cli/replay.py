"""`replay`: the estimation run again on a machine's log, and how far it was off where the log has the truth."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import AsJson, Plot, check_plot
from cablewright.apps.cli.output import numbers, print_json, progress, tell, write_picture
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.estimation.room import Laser
    from cablewright.studies.replay import Replay

__all__ = ["replay"]

_NOTHING = "no step of the log has a valid estimate"
_LEARNT = 10.0
"""How long a radius may take to be found, s."""


def replay(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A machine's log, MCAP, or the folder of a run.")],
    estimator: Annotated[
        str, typer.Option("--estimator", help="paper: the chain of Merlet and Papegay 2023.")
    ] = "paper",
    laser: Annotated[
        str | None, typer.Option("--laser", metavar="WALL=D[,..]", help="Measured from B to a wall at the start, m.")
    ] = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """Run the estimation on a log: position, slack line and winch drums' radii, beside the truth where it is there."""
    from cablewright.studies import replay as study

    check_plot(plot)
    lasers = [] if laser is None else _lasers(laser)
    with progress() as tells:
        found = study.replay(log, estimator, lasers, progress=tells)
    if plot is not None:
        from cablewright.apps.report.replay_picture import replay_picture

        write_picture(plot, replay_picture, found)
    values = _values(found, log, plot)
    if as_json:
        print_json(values)
    else:
        _print(values)
    for note in found.notes:
        tell(f"{log}: {note}")
    if not found.valid:
        tell(_NOTHING)
        return 1
    return 0


def _lasers(text: str) -> list[Laser]:
    """The value of --laser. Raises `InputError`."""
    from cablewright.estimation.room import Laser

    found = []
    for part in text.split(","):
        wall, _, value = part.partition("=")
        distance = numbers(value.strip() or "nan", "--laser") or [math.nan]
        if not (wall.strip() and distance[0] > 0.0 and math.isfinite(distance[0])):
            raise InputError(f"--laser = {text!r}: WALL=D is wanted, D over 0 in m, like east=1.32")
        found.append(Laser(wall.strip(), distance[0]))
    return found


def _values(found: Replay, log: Path, plot: Path | None) -> dict[str, Any]:
    import numpy as np

    times = np.array(found.step_times)
    steps, share = found.named_share()
    since = found.column("time") - found.begin > _LEARNT
    radii, due = found.radius_errors, found.column("true_excess") > 5e-3
    return {
        "status": "ok" if found.valid else "lost",
        "log": str(log),
        "robot": found.head.robot.name,
        "plant": found.head.plant,
        "seed": found.head.seed,
        "estimator": found.estimator,
        "steps": found.steps,
        "duration": found.duration,
        "valid_share": found.valid / max(found.steps, 1),
        "compared_from": found.begin,
        "static": _position(found, moving=False),
        "moving": _position(found, moving=True),
        "yaw": _spread(found.column("yaw")),
        "tilt": _spread(found.column("tilt")),
        "lines": [line.name for line in found.head.robot.lines],
        "taut_share": 1.0 - found.slack_steps / max(found.valid, 1),
        "slack": {"steps": steps, "named_share": share, "excess": _spread(found.column("excess_error")[due])},
        "radius": {
            "within_1_percent": np.mean(np.abs(radii[since]) <= 0.01, axis=0) if since.any() else None,
            "each": [_spread(column[since]) for column in radii.T],
        },
        "step_time": {
            "mean": float(times.mean()) if len(times) else math.nan,
            "p99": float(np.percentile(times, 99)) if len(times) else math.nan,
            "max": float(times.max()) if len(times) else math.nan,
        },
        "faults": [
            {"source": source, "sentence": sentence, "from": begin, "to": end, "steps": int(count)}
            for (source, sentence), (begin, end, count) in found.faults.items()
        ],
        "notes": list(found.notes),
        "plot": None if plot is None else str(plot),
    }


def _position(found: Replay, *, moving: bool) -> dict[str, Any]:
    """Errors of steps that move, or stand: in space, from above, in height; and shares within the paper's bounds."""
    import numpy as np

    chosen = found.chosen(moving=moving)
    space, level, height = found.position(moving=moving), found.level(moving=moving), found.column("z")[chosen]
    shares = {
        f"within_{bound}mm": float(np.mean(space <= 1e-3 * bound)) if len(space) else math.nan for bound in (2, 20)
    }
    return {"position": _spread(space), "level": _spread(level), "height": _spread(height)} | shares


def _spread(values: Any) -> dict[str, Any]:
    from cablewright.studies.replay import spread

    return dataclasses.asdict(spread(values))


def _print(values: dict[str, Any]) -> None:
    """The summary for people."""
    typer.echo(
        f"{values['robot']}: {values['duration']:.1f} s of the {values['plant']} plant, seed {values['seed']}, "
        f"estimator {values['estimator']}"
    )
    typer.echo(f"valid     {100 * values['valid_share']:.1f} % of {values['steps']} steps")
    for name in ("static", "moving"):
        for what, text in (("position", "in space"), ("level", "from above"), ("height", "in height")):
            each = values[name][what]
            if each["count"]:
                typer.echo(f"{name:<9} {text:<11} {_millimetres(each)}")
    for name in ("yaw", "tilt"):
        if values[name]["count"]:
            each = {key: math.degrees(value) for key, value in values[name].items() if key != "count"}
            typer.echo(f"{name:<9} rms {each['rms']:.3f}°, 95 % {each['p95']:.3f}°, at most {each['most']:.3f}°")
    shares = (f"{name} {100 * share:.0f} %" for name, share in zip(values["lines"], values["taut_share"], strict=True))
    typer.echo(f"taut      {', '.join(shares)} of the time")
    slack = values["slack"]
    if slack["steps"]:
        named = f"named rightly in {100 * slack['named_share']:.2f} % of {slack['steps']} steps over 5 mm"
        typer.echo(f"slack     {named}; excess {_millimetres(slack['excess'])}")
    within = values["radius"]["within_1_percent"]
    if within is not None:
        shares = (f"{100 * share:.0f} %" for share in within)
        sizes = (f"{100 * each['rms']:.2f} %" for each in values["radius"]["each"])
        typer.echo(f"radius    within 1 % in {', '.join(shares)} of steps after 10 s; rms {', '.join(sizes)}")
    times = values["step_time"]
    typer.echo(f"step      {1e6 * times['mean']:.0f} us mean, {1e3 * times['p99']:.2f} ms in 99 of 100, processor time")
    for fault in values["faults"]:
        typer.echo(f"fault     {fault['source']}: {fault['sentence']}; {fault['from']:.2f} to {fault['to']:.2f} s")
    if values["plot"] is not None:
        typer.echo(f"written   {values['plot']}")


def _millimetres(each: dict[str, Any]) -> str:
    rms, p95, most = (1e3 * each[key] for key in ("rms", "p95", "most"))
    return f"rms {rms:.1f} mm, 95 % {p95:.1f} mm, at most {most:.1f} mm"
