"""Logs of a print for tests: a machine that a pilot drives along a path, an observer beside it, progress reported."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np

from cablewright.estimation.merlet2023 import observer
from cablewright.foundation.signals import PrintState, Progress
from cablewright.live.drive_along_path import DriveSettings, Pilot, random_loop
from cablewright.live.estimator_settings import observer_settings
from cablewright.machine.log.log import Entry
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.arc_length_path import Track
from cablewright.printing.path import Samples
from cablewright.robot import Robot, load
from twins import TWIN, machine

RING = """schema = 1
name = "a ring"
origin = [0.3, -0.5, 0.0]
[helix]
radius = {radius}
layers = 1
layer_height = "1 mm"
first_height = "1 m"
[motion]
print_speed = "3 cm/s"
travel_speed = "3 cm/s"
acceleration = "20 mm/s^2"
"""
SPEED = 0.03
HEIGHT = 1.2


@cache
def rounds(seed: int, layers: int) -> Track:
    """A pilot's rounds as a track, each with an order of a millimetre higher, which the pilot ignores."""
    way = random_loop(load("merlet2023"), 28.0, seed)
    places = np.concatenate([np.column_stack([way, np.full(len(way), HEIGHT + 1e-3 * k)]) for k in range(layers)])
    layer = np.repeat(np.arange(1, layers + 1, dtype=np.int32), len(way))
    laying = np.ones(len(places), dtype=bool)
    laying[:: len(way)] = False
    distance = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    number = np.arange(len(places))
    return Track.of(
        Samples(places, distance, np.full(len(places), SPEED), np.zeros(len(places)), number, laying, layer,
                number.astype(np.int32))
    )  # fmt: skip


def printed(
    seconds: float, settings: TwinSettings = TWIN, *, seed: int = 1, plant: str = "dynamic", heap: float = 0.0
) -> tuple[list[Entry], Track, SimulatedMachine]:
    """Steps of a print by a pilot: it waits for 4 s, is paused once for 2 s by the barrier, in name alone.

    With a *heap* (kg) that lies along its first 60 cm before nothing falls from the drum.
    """
    track = rounds(seed, 3)
    twin = machine(settings, seed=seed, plant=plant, start=[*track.positions[0][:2], HEIGHT])
    if heap:
        twin.rig.ground.deposit(tuple(track.at(0.0).position[:2]), tuple(track.at(0.6).position[:2]), heap)
    drives = DriveSettings(valve=0.0 if heap else 1.0)
    pilot = Pilot(twin, track.positions[: len(track.positions) // 3, :2], drives, seed)
    known = observer_settings(twin_robot(), settings.owner)
    state, entries = observer.start(known), []
    for _ in range(round(seconds / twin.period)):
        command = pilot.command()
        frame = twin.step(command)
        estimate = observer.step(known, state, frame)
        entries.append(Entry(frame, command, twin.truth, estimate, progress_at(track, pilot, frame.time)))
    return entries, track, twin


@cache
def standard() -> tuple[list[Entry], Track, SimulatedMachine]:
    """26 s of a print, made once for all tests of a process."""
    return printed(26.0, seed=5)


def twin_robot() -> Robot:
    """The robot that is believed."""
    return load("merlet2023")


def progress_at(track: Track, pilot: Pilot, now: float) -> Progress:
    """What a supervisor would say."""
    state, reason = PrintState.PRINTING, ""
    if now < 4.0:
        state, reason = PrintState.READY, "waits for three turns of the lidars"
    elif 10.0 <= now < 12.0:
        state, reason = PrintState.PAUSED, "the light barrier is broken"
    distance = pilot.distance(now)
    layer = int(track.layer[track.piece(distance)])
    return Progress(now, state, layer, distance, track.at(distance).position, float("nan"), reason)


def without(entries: list[Entry], *names: str) -> Iterator[Entry]:
    """The same steps as a log has them that lacks some: ``truth``, ``estimate``, ``progress``."""
    for entry in entries:
        yield replace(entry, **dict.fromkeys(names))
