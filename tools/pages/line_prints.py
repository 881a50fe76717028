"""Print two layers with lines of other kinds on machines as built by many seeds: the table of docs/print.md.

    python tools/pages/line_prints.py                    # all robots
    python tools/pages/line_prints.py --robots cogiro --seeds 0:2

Robots: the Hangprinter, whose lines have an advantage of 2, the cogiro as it is and with sheaves on its platform, the
Maslow, whose sled slides on a board, a body that hangs on four lines, a hoist with a counterweight, and a body on three
pairs of lines, each on one winch; jobs: rings of two layers, on the board two rounds of a rectangle. The machine is
built for the robot, or the library's, with the severity typical and the dynamic plant in steps of 10 ms. True values in
each step that prints: distance of the nozzle from its path, and tensions.

Beside them two expectations: that of `check`, with the uncertainties of the robot file or assumed ones, and that of
machines so built by lengths alone, at rest: exits, moduli, lengths at home and drums of other seeds.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from cablewright.foundation.signals import PrintState
from cablewright.live.estimators import estimator
from cablewright.live.prints.body_limits import poses_at
from cablewright.live.prints.loop import Printer, PrintPlan
from cablewright.live.prints.plan import MachineTwin, PrintOptions, plan_print, twin_of
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.machine.simulated.as_built import as_built
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.free_coordinates import with_free
from cablewright.models.statics import Model
from cablewright.printing.arc_length_path import Track
from cablewright.printing.job import Job, load_job
from cablewright.robot import PlatformSheave, Robot, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.checks.check import check

CABLE: Final = {"axial_stiffness": 60e3, "linear_density": 4e-3, "breaking_load": 2e3, "diameter": 2.5e-3}
WINCH: Final = {"drum_radius": 0.04}


def with_sheaves() -> Robot:
    """The cogiro with a sheave of 50 mm at each corner of its platform, whose axis is the platform's vertical."""
    robot = load("cogiro")
    sheave = PlatformSheave(radius=0.05, axis=(0.0, 0.0, -1.0))
    lines = tuple(line.model_copy(update={"platform_sheave": sheave}) for line in robot.lines)
    return Robot.model_validate(robot.model_copy(update={"lines": lines}).model_dump())


def hoist(dead: bool = True, **weight: Any) -> Robot:
    """A point of 20 kg on three winches, and on a counterweight of 12 kg over a pulley above; *dead*: beside it."""
    corners = {"a": (2.0, 0.0), "b": (-1.0, 1.8), "c": (-1.0, -1.8)}
    lines = [
        {"name": name, "exit_point": (x, y, 3.0), "sheave": {"kind": "eyelet"}, "winch": WINCH}
        for name, (x, y) in corners.items()
    ]
    up: dict[str, Any] = {"name": "up", "exit_point": (0.0, 0.0, 3.5), "sheave": {"kind": "eyelet"}}
    up |= {"counterweight": 12.0, **weight} | ({"winch_exit": (2.0, 0.0, 3.5)} if dead else {})
    every = {"cable": CABLE, "tension_limits": (2.0, 400.0)}
    return Robot.model_validate({
        "name": "hoist",
        "scene": {"frame_min": (-0.6, -0.6, 0.2), "frame_max": (0.6, 0.6, 1.6)},
        "platform": {"kind": "point", "mass": 20.0},
        "lines": [every | line for line in [*lines, up]],
    })  # fmt: skip


def pairs() -> Robot:
    """A body of 12 kg on three pairs of parallel lines, each on one drum; its position is given, they keep its turn."""
    exits = {
        "a1": ((1.95, -0.2, 2.8), (0.25, -0.2, 0.1)),
        "a2": ((1.95, 0.2, 2.8), (0.25, 0.2, 0.1)),
        "b1": ((-0.8, 1.8, 2.8), (0.05, 0.32, -0.1)),
        "b2": ((-1.15, 1.6, 2.8), (-0.3, 0.12, -0.1)),
        "c1": ((-1.15, -1.6, 2.8), (-0.3, -0.12, -0.1)),
        "c2": ((-0.8, -1.8, 2.8), (0.05, -0.32, -0.1)),
    }
    lines = [
        {
            "name": name,
            "exit_point": exit_point,
            "platform_point": point,
            "sheave": {"kind": "eyelet"},
            "winch": WINCH,
            "cable": CABLE,
            "tension_limits": (0.5, 400.0),
            "shared_winch": {"line": f"{name[0]}1"} if name[1] == "2" else None,
        }
        for name, (exit_point, point) in exits.items()
    ]
    return Robot.model_validate({
        "name": "pairs",
        "scene": {"frame_min": (-0.6, -0.6, 0.2), "frame_max": (0.6, 0.6, 1.6)},
        "platform": {"kind": "rigid", "mass": 12.0, "inertia": (0.3, 0.3, 0.4), "nozzle": (0.0, 0.0, -0.2)},
        "lines": lines,
    })  # fmt: skip


def ring(radius: float, height: float, speed: float, x: float = 0.0) -> Job:
    """Two layers of a ring of that *radius*, m, about *x*, m, from a *height*, m, on, at that *speed*, m/s."""
    return Job.model_validate({
        "name": "ring",
        "helix": {"radius": radius, "layers": 2, "layer_height": 2e-3, "first_height": height},
        "origin": (x, 0.0, 0.0),
        "bead": {"width": 0.01, "height": 2e-3},
        "motion": {"print_speed": speed, "travel_speed": speed, "acceleration": 0.5 * speed},
    })  # fmt: skip


def on_the_board(folder: Path) -> Job:
    """Two rounds of a rectangle of 0.4 x 0.3 m on the board of the Maslow, 1 m up; its files in a *folder*."""
    plane = load("maslow4").platform.plane
    assert plane is not None
    up = plane.directions[1]
    corners = [(-0.2, -0.15), (0.2, -0.15), (0.2, 0.15), (-0.2, 0.15)]
    lines = ["G21", "G90", "M83", "G0 X0 Y0 Z0 F6000"]
    for layer in range(2):
        lines.append(f";LAYER:{layer}")
        for k, (a, b) in enumerate([*corners, corners[0]]):
            lines.append(f"G{int(k > 0)} X{1e3 * a:g} Y{1e3 * b:g} F6000" + " E5" * (k > 0))
    (folder / "board.gcode").write_text("\n".join(lines) + "\n")
    (folder / "board.toml").write_text(
        f'schema = 1\nname = "board"\ngcode = "board.gcode"\norigin = {list(up)}\n'
        "[bead]\nwidth = 0.006\nheight = 0.002\n"
        "[motion]\nprint_speed = 0.1\ntravel_speed = 0.1\nacceleration = 0.1\ncorner_deviation = 0.002\n"
    )
    return load_job(folder / "board.toml")


_WINDOW: Final = 0.1  # m along the path
_MACHINES: Final = 100  # as built, by lengths alone
_PLACES: Final = 40  # of the path, at which they are solved
_OTHERS: Final = 1000  # the first of their seeds

CASES: Final[dict[str, tuple[Callable[[], Robot], Callable[[Path], Job]]]] = {
    "hangprinter-v4": (lambda: load("hangprinter-v4"), lambda _: ring(0.2, 0.3, 0.1)),
    "cogiro": (lambda: load("cogiro"), lambda _: ring(0.5, 0.5, 0.2)),
    "cogiro-sheaves": (with_sheaves, lambda _: ring(0.5, 0.5, 0.2)),
    "maslow4": (lambda: load("maslow4"), on_the_board),
    "grab-four-lines": (lambda: load("grab-four-lines"), lambda _: ring(0.2, -0.3, 0.1, 1.1)),
    "hoist": (hoist, lambda _: ring(0.25, 0.4, 0.1)),
    "pairs": (pairs, lambda _: ring(0.25, 0.4, 0.1)),
}


@dataclass(frozen=True)
class Outcome:
    """Of a print: errors (k,), m; tensions (k, m), N; how it ended."""

    errors: np.ndarray
    tensions: np.ndarray
    end: str


def distance_from(track: Track, place: np.ndarray, along: float) -> float:
    """Distance in space, m, of a *place* (3,) from the *track* near the distance *along* it, m."""
    first, stop = np.searchsorted(track.distance, (along - _WINDOW, along + _WINDOW))
    begin = track.positions[max(first - 1, 0) : stop + 1]
    way = np.diff(begin, axis=0)
    share = ((place - begin[:-1]) * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-18)
    off = place - begin[:-1] - np.clip(share, 0.0, 1.0)[:, None] * way
    return float(np.linalg.norm(off, axis=1).min())


def printed(robot: Robot, job: Job, options: PrintOptions) -> Outcome:
    """Print until the end, or until the machine stops."""
    twin = twin_of(robot, job, None, options)
    plan, path = plan_print(twin), twin.path
    rig = SimulatedMachine(twin.robot, twin.settings, path.start_pose, seed=options.seed)
    printer = Printer(
        plan, rig, lambda place, radii: estimator(twin.estimator, twin.robot, rig.settings, place, (), radii)
    )
    attendant = Attendant(lambda: None)
    errors, tensions, begun = [], [], False
    while not (begun and attendant.is_over(printer)):
        begun = True
        step = printer.step(attendant.orders(printer, rig.time))
        if step.progress.state is PrintState.PRINTING:
            truth = rig.truth
            nozzle = truth.position if robot.n == 3 else path.printing_point(truth.position, truth.rotation)
            errors.append(distance_from(path.track, nozzle, step.progress.distance))
            tensions.append(truth.tensions)
    end = "finished" if printer.finished else printer.supervisor.reason
    return Outcome(np.array(errors), np.array(tensions), end)


def by_lengths_alone(twin: MachineTwin, plan: PrintPlan, machines: int = _MACHINES) -> float:
    """Return within what distance of the path 95 of 100 of so many *machines* as built stay, m, by lengths alone.

    They pay out from home the cable that holds the nozzle on the path of the machine as described. What creeps, slides
    and swings is left out.
    """
    path, model, most = plan.path, plan.velocity.model, []
    rows = np.linspace(0, len(path.track.positions) - 1, _PLACES).astype(int)
    poses, retraction = poses_at(model, path, path.track.positions[rows])
    nominal = solve_inverse(model, poses, path=True, retraction=retraction).checked()
    home = solve_inverse(model, with_free(twin.robot, path.start_pose)).checked().lengths
    for seed in range(_OTHERS, _OTHERS + machines):
        rig = SimulatedMachine(twin.robot, twin.settings, path.start_pose, seed=seed)
        built = as_built(twin.robot, twin.settings.simulation.tolerances, seed)
        radii, told = ([each.winch.drum_radius or 1.0 for each in robot.lines] for robot in (built, twin.robot))
        lengths = rig.truth.lengths + (nominal.lengths - home) * np.divide(radii, told)
        found = solve_forward(Model(built), lengths, guess=nominal.pose)
        nozzles = found.pose if twin.robot.n == 3 else found.nozzle
        off = [distance_from(path.track, *at) for at in zip(nozzles, path.track.distance[rows], strict=True)]
        most.append(max(off) if found.ok.all() else np.inf)
    return float(np.quantile(most, 0.95))


def main() -> None:
    """Print a table for each robot."""
    parser = argparse.ArgumentParser(description="Prints with lines of other kinds by seeds.")
    parser.add_argument("--robots", default=",".join(CASES), help="by commas")
    parser.add_argument("--seeds", default="0:5", help="first and the one after the last")
    parser.add_argument("--severity", default="typical", choices=("ideal", "typical", "rough", "own"))
    parser.add_argument("--estimator", default="", help="by default the one that the machine's sensors allow")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        _tell(given, Path(folder))


def _tell(given: argparse.Namespace, folder: Path) -> None:
    """Print the tables; files of jobs are in the *folder*."""
    for name in given.robots.split(","):
        make, path = CASES[name]
        robot, job = make(), path(folder)
        limits = np.array([line.tension_limits for line in robot.lines])
        found = check(robot, job).expected
        expected = np.nan if found is None else found.value
        severity = None if given.severity == "own" else given.severity
        twin = twin_of(robot, job, None, PrintOptions(given.estimator or None, layers=2, severity=severity))
        alone = by_lengths_alone(twin, plan_print(twin))
        print(f"\n{name}: 95 of 100 machines within {1e3 * expected:.1f} mm by check; so built, by lengths alone, "
              f"{1e3 * alone:.1f} mm; {limits.min():g} to {limits.max():g} N are allowed\n")  # fmt: skip
        print(
            "| seed | rms | most | tensions | steps outside | end |\n| --- | --- | --- | --- | --- | --- |", flush=True
        )
        for seed in range(*map(int, given.seeds.split(":"))):
            options = PrintOptions(given.estimator or None, layers=2, seed=seed, severity=severity)
            one = printed(robot, job, options)
            if not len(one.errors):
                print(f"| {seed} | - | - | - | - | {one.end} |", flush=True)
                continue
            rms, most = 1e3 * np.sqrt((one.errors**2).mean()), 1e3 * one.errors.max()
            outside = ((one.tensions < limits[:, 0]) | (one.tensions > limits[:, 1])).any(axis=1).mean()
            span = f"{one.tensions.min():.1f} to {one.tensions.max():.1f} N"
            print(f"| {seed} | {rms:.2f} mm | {most:.2f} mm | {span} | {outside:.1%} | {one.end} |", flush=True)


if __name__ == "__main__":
    main()
