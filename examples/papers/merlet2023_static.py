"""Merlet and Papegay 2023 in static poses: the list of positions by lidars, and what a theodolite would find.

At each pose the simulated machine of the library, as built with other errors by each seed, rests for a while. Printed
are the spread of the candidate positions after three turns (theirs: about 3 cm in x and 2 mm in y), and the largest
difference of the estimated position from that by a theodolite (theirs: 1.5 mm): with the window of the east wall, 5 cm
behind the wall, and with it flush; by the filter, by their estimator, and by that with their rank of candidates.
"""

import argparse
from dataclasses import replace

import numpy as np

import cablewright as cw
from cablewright.estimation.merlet2023.state import ObserverSettings
from cablewright.live.estimator_settings import OBSERVERS
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.machine.simulated.severities import with_severity

POSES = [[x, y, 1.2] for y in (-2.0, 0.0, 2.0) for x in (-0.8, 0.8)]
THEIRS = "paper, its rank"
SETTLED = 14.0  # s, as long as each stands
NEAR = 0.3  # m from the first candidate: others are at a wrong wall
STATION = np.array([0.0, -4.5, 1.5])  # m, of the theodolite: where the public is
DISTANCE, ANGLE = 1.5e-3, np.radians(5.0 / 3600.0)  # m and rad, standard deviations of one of its readings


def flush(twin: TwinSettings) -> TwinSettings:
    """The machine in a room whose window is in the plane of its wall."""
    room = twin.owner.room
    walls = tuple(
        wall.model_copy(update={"start": (2.5, wall.start[1]), "end": (2.5, wall.end[1])})
        if wall.name == "window"
        else wall
        for wall in room.walls
        if not wall.name.startswith("window, ")
    )
    return twin.with_owner(room=room.model_copy(update={"walls": walls}))


def by_their_rank(settings: ObserverSettings) -> ObserverSettings:
    """The estimator with the paper's rank of candidates: by the variances of their lines alone."""
    return replace(settings, walls=replace(settings.walls, rank="variance"))


def stands(name: str, robot: cw.Robot, twin: TwinSettings, pose: list[float], seed: int) -> tuple[np.ndarray, ...]:
    """Estimated and true position at the end, m, and after three turns half the spread of candidates in x and y."""
    machine, observer = cw.SimulatedMachine(robot, twin, pose, seed=seed), OBSERVERS[name.split(",")[0]]
    settings = observer.settings(robot, twin.owner, ())
    if name == THEIRS:
        settings = by_their_rank(settings)
    state, spread, estimate = observer.start(settings), np.full(2, np.nan), None
    still = np.zeros(robot.m)
    while machine.time < SETTLED:
        estimate = observer.step(settings, state, machine.step(cw.Command(machine.time, still)))
        found = getattr(getattr(state, "located", None), "wall_pose", None)
        if found is not None and found.candidates and np.isnan(spread).any() and machine.time > 3.5:
            places = np.array([each.position for each in found.candidates])
            near = places[np.linalg.norm(places - places[0], axis=1) < NEAR]
            spread = 0.5 * (near.max(axis=0) - near.min(axis=0))
    return estimate.position, machine.truth.position, spread


def by_theodolite(place: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """A *place* (3,), m, as one reading of distance and angles finds it."""
    ray = place - STATION
    far = float(np.linalg.norm(ray))
    across = far * ANGLE * random.standard_normal(3)
    along = ray / far
    return place + along * (DISTANCE * random.standard_normal() - across @ along) + across


def main() -> None:
    """All of it."""
    options = argparse.ArgumentParser()
    options.add_argument("--seeds", type=int, default=3)
    given = options.parse_args()
    robot, twin = cw.load("merlet2023"), cw.load_twin("merlet2023")
    print(f"{len(POSES)} poses, each of {given.seeds} machines as built")
    rooms = {
        "window 5 cm behind": twin,
        "window flush": flush(twin),
        "the first, typical": with_severity(twin, "typical"),
    }
    for room, machine in rooms.items():
        for name in ("filter", "paper", THEIRS):
            errors, seen, spreads = [], [], []
            for seed in range(201, 201 + given.seeds):
                random = np.random.default_rng(seed)
                for pose in POSES:
                    estimated, true, spread = stands(name, robot, machine, pose, seed)
                    errors.append(np.linalg.norm(estimated - true))
                    seen.append(np.linalg.norm(estimated - by_theodolite(true, random)))
                    spreads.append(spread)
            line = f"{room:20}{name:17}true: rms {1e3 * np.sqrt(np.nanmean(np.square(errors))):6.2f}, most"
            line += f" {1e3 * np.nanmax(errors):6.2f} mm; by the theodolite at most {1e3 * np.nanmax(seen):6.2f} mm"
            if name != "filter":
                x, y = np.nanmedian(spreads, axis=0)
                line += f"; candidates +-{1e3 * x:.1f} mm in x, +-{1e3 * y:.2f} mm in y"
            print(line, flush=True)


if __name__ == "__main__":
    main()
