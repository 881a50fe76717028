"""The room as found: people, glass, dark walls, ghosts; and a link that is gone for seconds."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Command, Distance, Scan
from cablewright.machine.files import machine_text
from cablewright.machine.log.messages import encode
from cablewright.machine.simulated.link import Channel, Gaps
from cablewright.machine.simulated.people import WIDTH, Visits
from cablewright.machine.simulated.random_spells import Spells
from cablewright.machine.simulated.settings import Link, TwinSettings, load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import load
from twins import SETTINGS, TWIN, changed, machine, perfect, run

Array = NDArray[np.float64]
LOW, HIGH = np.array([-2.5, -5.0]), np.array([2.5, 5.0])
RADIUS = 0.18
STILL = {"yaw_wander": 0.0, "swing_damping": 150.0, "drag": 400.0}


def north_scans(settings: TwinSettings, seed: int = 1, steps: int = 60) -> list[Scan]:
    readings = run(machine(settings, seed, "quasi-static", start=(0.0, 0.5, 1.2)), steps)
    return [each for each in readings if isinstance(each, Scan) and each.source == "north"]


@pytest.mark.parametrize("share", [0.05, 0.2, 0.7])
def test_somebody_is_there_for_the_share_of_the_time_from_the_start_on(share: float) -> None:
    there = np.array([
        [Visits(share, LOW, HIGH, RADIUS, seed).visits.at(time) is not None for time in (0.0, 15.0, 60.0, 300.0)]
        for seed in range(1500)
    ])  # fmt: skip
    sigma = math.sqrt(share * (1.0 - share) / len(there))
    assert (np.abs(there.mean(axis=0) - share) < 4.0 * sigma).all()
    visits = Visits(share, LOW, HIGH, RADIUS, 1).visits
    found = [visits.at(time) for time in np.arange(0.0, 2e5, 5.0)]
    assert np.mean([visit is not None for visit in found]) == pytest.approx(share, rel=0.15)
    lengths = np.array([visit.end - visit.begin for visit in set(found) - {None}])
    assert 10.0 <= lengths.min() < 11.0
    assert 39.0 < lengths.max() <= 40.0 + 1e-9


def test_people_walk_in_the_room_at_walking_speed_and_never_into_the_drum() -> None:
    for seed in range(30):
        visits, drum = Visits(1.0, LOW, HIGH, RADIUS, seed), np.array([0.3 * math.sin(seed), 4.0 * math.cos(seed)])
        times = np.arange(0.0, 60.0, 0.1)
        places = np.array([visits.place(time, drum) for time in times])
        assert (places >= LOW + 0.29).all()
        assert (places <= HIGH - 0.29).all()
        clear = np.linalg.norm(places - drum, axis=1) - RADIUS - 0.5 * WIDTH
        assert clear.min() >= 0.6 - 1e-9
        free = np.array([visits.place(time, np.array([50.0, 0.0])) for time in times])
        speeds = np.linalg.norm(np.diff(free, axis=0), axis=1) / 0.1
        assert np.quantile(speeds, 0.9) <= 1.5 + 1e-6
        assert 0.3 < np.median(speeds) < 1.5


def test_a_room_too_small_to_be_clear_of_the_drum_is_empty() -> None:
    visits = Visits(1.0, np.array([-0.9, -0.9]), np.array([0.9, 0.9]), RADIUS, 0)
    assert all(visits.place(time, np.zeros(2)) is None for time in np.arange(0.0, 100.0))


def test_what_people_do_follows_from_the_time_alone() -> None:
    times, drum = np.random.default_rng(0).uniform(0.0, 3000.0, 300), np.array([0.5, 0.5])
    one, other = (Visits(0.3, LOW, HIGH, RADIUS, 4) for _ in range(2))
    found = {time: one.place(time, drum) for time in times}
    for time in np.sort(times):
        np.testing.assert_array_equal(other.place(time, drum), found[time])


def test_a_lidar_sees_a_person_in_front_of_the_walls() -> None:
    exact = changed(perfect(), drum=STILL)
    with_one = changed(exact, people={"share": 1.0})
    alone, shown = north_scans(exact), north_scans(with_one)
    room = machine(with_one, plant="quasi-static")._sensors["north"]._room
    met = 0
    for before, now in zip(alone, shown, strict=True):
        nearer = np.flatnonzero(now.ranges < before.ranges - 1e-9)
        others = np.delete(np.arange(720), nearer)
        np.testing.assert_array_equal(now.ranges[others], before.ranges[others])
        body = room.faces(now.begin + 0.6, np.array([0.0, 0.5]))[len(SETTINGS.room.walls) :]
        if not len(nearer):
            continue
        points = now.points[nearer] + [0.0, 0.75]
        off = np.linalg.norm(points - body[:, :2].mean(axis=0), axis=1)
        assert (off <= 0.5 * WIDTH + 1e-4).all()
        assert (off >= 0.5 * WIDTH * math.cos(math.pi / 8.0) - 1e-4).all()  # a body of 8 sides
        met += 1
    assert met > 3


def test_rays_pass_glass_and_die_on_dark_walls_by_their_shares() -> None:
    exact = changed(perfect(), drum=STILL)
    plain = np.array([scan.ranges for scan in north_scans(exact)])
    scan = north_scans(exact)[0]
    points = scan.points + np.array([0.0, 0.75])
    window, west = np.abs(points[:, 0] - 2.55) < 1e-3, np.abs(points[:, 0] + 2.5) < 1e-3
    found = changed(exact, room={"glass": ("window",), "glass_share": 0.3, "dark": ("west",), "dark_share": 0.6})
    shown = np.array([scan.ranges for scan in north_scans(found)])
    other = ~(window | west)
    np.testing.assert_array_equal(shown[:, other], plain[:, other])
    through = shown[:, window] > plain[:, window] + 0.1
    assert through.mean() == pytest.approx(0.3, abs=0.05)
    straight = np.abs(scan.angles) < 0.05  # at right angles to the window
    assert np.nanmax((shown - plain)[:, straight]) == pytest.approx(3.0, abs=0.02)
    lost = np.isnan(shown[:, west])
    assert lost.mean() == pytest.approx(0.6, abs=0.05)
    np.testing.assert_array_equal(shown[:, west][~lost], plain[:, west][~lost])


def test_ghosts_are_a_share_and_too_far() -> None:
    exact = changed(perfect(), drum=STILL)
    flaws = {
        "north": TWIN.simulation.lidars["north"].model_copy(update={"ghosts": 0.1, "dropout": 0.0, "outliers": 0.0})
    }
    plain = np.array([scan.ranges for scan in north_scans(exact)])
    off = np.array([scan.ranges for scan in north_scans(exact.with_simulation(lidars=flaws))]) - plain
    off = off[~np.isnan(off)]
    assert (off >= -1e-9).all()
    ghosts = off > 1e-6
    assert ghosts.mean() == pytest.approx(0.1, rel=0.1)
    assert off[ghosts].mean() == pytest.approx(0.3, rel=0.15)


@pytest.mark.parametrize("key", ["glass", "dark"])
def test_faces_that_the_room_does_not_have_are_rejected(key: str, tmp_path: Path) -> None:
    table = f'[simulation.room]\n{key} = ["oven"]\n[simulation.climate]'
    text = machine_text("merlet2023").replace("[simulation.climate]", table)
    (tmp_path / "own.toml").write_text(text)
    with pytest.raises(InputError, match=rf"simulation\.room\.{key} = \['oven'\]: the room has no wall 'oven'"):
        load_twin(tmp_path / "own.toml")


def test_gaps_at_random_have_their_length_and_rate_and_keep_the_order() -> None:
    link = Link(latency=0.01, jitter=0.02, gap_every=20.0, gap_length=1.5)
    gaps = Gaps(link, 3, 0)
    channel, came = Channel(link, np.random.default_rng(0), gaps), list[tuple[float, float]]()
    for k in range(400_000):
        now = 0.05 * k
        channel.send(now, Distance(now, 1.0))
        came += [(now, reading.time) for reading in channel.arrived(now)]
    arrived, sent = np.array(came).T
    assert (np.diff(sent) > 0.0).all()  # nothing is lost, and nothing overtakes
    assert len(sent) > 399_900
    pauses = np.diff(arrived)[np.diff(arrived) > 1.0]
    assert len(pauses) == pytest.approx(20_000.0 / 21.5, rel=0.1)
    assert (pauses > 1.49).all()
    assert (pauses < 1.85).all()  # but for two delays and two steps
    assert np.quantile(arrived - sent, 0.99) > 1.0
    found = sorted({gaps._spells.at(time) for time in np.arange(0.0, 2e4, 1.0)} - {None})
    between = np.array([later.begin - earlier.end for earlier, later in pairwise(found)])
    assert between.mean() == pytest.approx(20.0, rel=0.1)
    assert between.std() == pytest.approx(20.0, rel=0.15)


def test_planned_gaps_and_gaps_at_random_join() -> None:
    link = Link(gaps=((10.0, 30.0),), gap_every=5.0, gap_length=3.0)
    gaps = Gaps(link, 3, 0)
    for time in np.linspace(0.0, 60.0, 601):
        end = gaps.end(time)
        assert end >= time
        assert end == gaps.end(end)
        assert not 10.0 <= end < 30.0
        assert gaps._spells.at(end + 1e-9) is None


def outputs(twin: SimulatedMachine, steps: int) -> list[bytes]:
    found = []
    for _ in range(steps):
        frame = twin.step(Command(twin.time, np.array([0.2, -0.2, 0.1, 0.0]) * math.cos(0.3 * twin.time), 1.0))
        found += [encode(reading, "abcd", 1024)[1] for reading in frame.readings]
        found += [encode(twin.truth, "abcd", 1024)[1], str(frame.notices).encode()]
    return found


@pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])
def test_a_machine_resumed_in_a_gap_and_a_visit_goes_on_to_the_bit(plant: str) -> None:
    lidars = {name: flaws.model_copy(update={"ghosts": 0.05}) for name, flaws in TWIN.simulation.lidars.items()}
    law = changed(
        tolerances={"wall": 2e-3, "mount_place": 2e-3, "mount_turn": 5e-3, "clock_offset": 0.01, "clock_drift": 5e-5,
                    "line_angle_bias": 0.02, "mass": 0.01},
        people={"share": 0.95},
        wifi={"gap_every": 1.0, "gap_length": 2.0},
        clock={"jumps": ((4.0, -0.3),)},
        room={"glass": ("window",), "dark": ("west",)},
    ).with_simulation(lidars=lidars)  # fmt: skip
    whole, broken = (machine(law, 5, plant) for _ in range(2))
    inside = {"gap": 0, "visit": 0}
    for steps in (130, 71, 53, 90, 170) if plant == "dynamic" else (17, 31, 40, 60):
        assert outputs(whole, steps) == outputs(broken, steps)
        gaps, visits = broken._wifi._gaps, broken._sensors["north"]._room._visits
        inside["gap"] += gaps.end(broken.time) > broken.time
        inside["visit"] += visits.visits.at(broken.time) is not None
        snapshot = broken.snapshot()
        broken = SimulatedMachine.resumed(load("merlet2023"), law, snapshot, seed=5, plant=plant)
    assert outputs(whole, 60) == outputs(broken, 60)
    assert min(inside.values()) > 0


def test_random_periods_of_any_time_are_drawn_quickly() -> None:
    """Also of a time that a file may name, a thousand million seconds ahead; they do not depend on earlier requests."""
    for every, length in ((1.0, 0.1), (1e9, 1e9), (60.0, 2.0)):
        one, other = (Spells(every, (length, length), 1, 2) for _ in range(2))
        times = np.random.default_rng(0).uniform(0.0, 1e12, 400)
        found = {time: one.at(time) for time in times}
        assert all(other.at(time) == found[time] for time in np.sort(times))
        within = [(time, spell) for time, spell in found.items() if spell is not None]
        assert all(spell.begin <= time < spell.end for time, spell in within)
        assert len(within) / len(times) == pytest.approx(length / (every + length), abs=0.08)
