"""Equipment as built: errors have the laws of their tolerances, one by one, and no estimator receives them."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cablewright.foundation.signals import Distance, Encoders, Inertial, LineAngles, Scan, Tensions
from cablewright.live.estimator_settings import started_settings
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.settings import RoomSettings, WallFace
from cablewright.machine.simulated.as_built_parts import (
    angle_zeros,
    as_built_machine,
    as_built_room,
    mass_factors,
    mounting,
    places_along,
    tension_gains,
)
from cablewright.machine.simulated.settings import Tolerances, TwinSettings
from cablewright.machine.simulated.wireless_clock import DrumClock
from cablewright.robot import load
from twins import SETTINGS, TWIN, changed, machine, perfect, run

Array = NDArray[np.float64]
SEEDS = range(400)
SIZES = {
    "wall": 2e-3,
    "mount_place": 3e-3,
    "mount_turn": 5e-3,
    "clock_offset": 0.01,
    "clock_drift": 5e-5,
    "line_angle_bias": 0.02,
    "tension_gain": 0.02,
    "mass": 0.01,
}


def off(**sizes: float) -> TwinSettings:
    return changed(tolerances=sizes)


def errors(key: str, seed: int, **sizes: float) -> Array:
    """The errors that one tolerance makes, as numbers; all are as in `SIZES` but those that are given."""
    given = off(**{**SIZES, **sizes})
    made, law = as_built_machine(given, seed), given.simulation.tolerances
    own, along = made.owner, places_along(law, seed, 4)
    clock = DrumClock(given.simulation, seed)
    match key:
        case "wall":
            return np.ravel([
                np.array([face.start, face.end]) - [was.start, was.end]
                for face, was in zip(own.room.walls, SETTINGS.room.walls, strict=True)
            ])  # fmt: skip
        case "mount_place":
            places = [np.subtract(own.lidars[name].place, lidar.place) for name, lidar in SETTINGS.lidars.items()]
            return np.concatenate([*places, along, np.subtract(own.inertial.place, SETTINGS.inertial.place)])
        case "mount_turn":
            sensors = ("inertial", "distance", "north", "south", "vertical")
            return np.concatenate([turn_of(mounting(name, law, seed)) for name in sensors])
        case "clock_offset":
            return np.array([clock.offset])
        case "clock_drift":
            return np.array([clock.drift])
        case "line_angle_bias":
            return angle_zeros(law, seed, 4)
        case "tension_gain":
            return np.concatenate([tension_gains(source, law, seed, 4) for source in ("load_cells", "motor_torques")])
    return np.array(mass_factors(law, seed)) - 1.0


def turn_of(rotation: Array) -> Array:
    """The rotation vector of a small turn."""
    return 0.5 * np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0],
                           rotation[1, 0] - rotation[0, 1]])  # fmt: skip


@pytest.mark.parametrize("key", [key for key in SIZES if key != "wall"])
def test_errors_have_the_deviation_of_their_tolerance_and_no_mean(key: str) -> None:
    found = np.array([errors(key, seed) for seed in SEEDS])
    assert found.std() == pytest.approx(SIZES[key], rel=0.1)
    assert (np.abs(found.mean(axis=0)) < 5.0 * SIZES[key] / math.sqrt(len(SEEDS))).all()
    together = np.corrcoef(found.T) - np.eye(found.shape[1]) if found.shape[1] > 1 else np.zeros(1)
    assert np.abs(together).max() < 0.25  # independent


@pytest.mark.parametrize("key", SIZES)
def test_one_tolerance_changes_no_error_but_its_own(key: str) -> None:
    for other in SIZES:
        was, now = errors(other, 3), errors(other, 3, **{key: 2.0 * SIZES[key]})
        if other == key:
            np.testing.assert_allclose(now, 2.0 * was, rtol=2e-4, atol=1e-12)  # as a turn is not quite its angles
        else:
            np.testing.assert_array_equal(now, was)
    assert not errors(key, 3, **{key: 0.0}).any()


def test_walls_stay_straight_and_their_ends_have_errors_across_them() -> None:
    ends = []
    for seed in SEEDS:
        room = as_built_room(SETTINGS.room, 2e-3, seed)
        faces = {face.name: np.array([face.start, face.end]) for face in room.walls}
        was = {face.name: np.array([face.start, face.end]) for face in SETTINGS.room.walls}
        moved = {name: faces[name] - was[name] for name in faces}
        east = np.vstack([faces["east, south of the window"], faces["east, north of the window"]])
        line = np.polynomial.Polynomial.fit(east[:, 1], east[:, 0], 1)
        np.testing.assert_allclose(line(east[:, 1]), east[:, 0], atol=1e-12)
        assert not moved["west"][:, 1].any()  # only across
        assert not moved["north"][:, 0].any()
        side = moved["window, south side"]
        np.testing.assert_array_equal(side[0], side[1])  # 5 cm long: shifted, not turned
        ends.append([moved["west"][0, 0], moved["west"][1, 0], moved["north"][0, 1], moved["north"][1, 1],
                     moved["east, south of the window"][0, 0], moved["east, north of the window"][1, 0],
                     moved["window"][0, 0], side[0, 1]])  # fmt: skip
    found = np.array(ends)
    np.testing.assert_allclose(found.std(axis=0), 2e-3, rtol=0.15)
    assert np.abs(np.corrcoef(found.T) - np.eye(8)).max() < 0.2


def test_faces_on_one_line_are_one_wall_whichever_way_they_run() -> None:
    c, s = math.cos(0.3), math.sin(0.3)
    turned = [(c * x - s * y, s * x + c * y) for x, y in ((0.0, 0.0), (2.0, 0.0), (6.0, 0.0), (4.0, 0.0))]
    pairs = [(turned[0], turned[1]), (turned[2], turned[3])]
    faces = tuple(WallFace(**{"name": str(k), "from": a, "to": b}) for k, (a, b) in enumerate(pairs))
    room = as_built_room(RoomSettings(ceiling=3.0, walls=faces), 0.01, 5)
    places = np.array([end for face in room.walls for end in (face.start, face.end)])
    assert np.linalg.matrix_rank(places - places[0], tol=1e-9) == 1
    assert np.linalg.norm(places - turned) > 1e-3


def test_without_tolerances_the_machine_is_the_owners() -> None:
    assert as_built_machine(TWIN, 5) == TWIN
    assert as_built_machine(off(**SIZES), 5) == as_built_machine(off(**SIZES), 5) != as_built_machine(off(**SIZES), 6)


def test_no_truth_reaches_an_estimator() -> None:
    """Each tolerance and the machine built with it: the estimator's settings stay as they were."""
    told = pickle.dumps(started_settings(load("merlet2023"), SETTINGS))
    keys = Tolerances.model_fields.keys() - {"modulus", "anchor", "sheave_radius"}
    assert keys == SIZES.keys() | {"tension_drift", "home_length", "drum_radius"}
    for key in keys:
        made = machine(off(**{key: SIZES.get(key, 0.01)}), plant="quasi-static")
        usual = machine(plant="quasi-static")
        assert made.settings == usual.settings
        assert made.simulation != usual.simulation
        assert pickle.dumps(started_settings(load("merlet2023"), off(**{key: SIZES.get(key, 0.01)}).owner)) == told


@pytest.mark.parametrize(
    "tables",
    [
        {"people": {"share": 0.5}},
        {"room": {"glass": ("window",)}},
        {"clock": {"jumps": ((1.0, 0.5),)}},
        {"wifi": {"gap_every": 60.0, "gap_length": 2.0}},
    ],
)
def test_properties_of_room_and_link_reach_no_estimator(tables: dict[str, dict[str, Any]]) -> None:
    made = changed(**tables)
    assert made.simulation != TWIN.simulation
    told = [pickle.dumps(started_settings(load("merlet2023"), machine(each).settings)) for each in (made, TWIN)]
    assert told[0] == told[1]


def readings_of(kind: type, settings: TwinSettings, steps: int = 30, seed: int = 2) -> list[Any]:
    return [each for each in run(machine(settings, seed), steps) if isinstance(each, kind)]


def test_accelerometers_and_cells_show_their_errors() -> None:
    cells = TensionSensor(rate=100.0, deviation=0.0, most=1e4)
    exact = perfect().with_owner(load_cells=cells)
    made = changed(exact, tolerances={"line_angle_bias": 0.02, "tension_gain": 0.05})
    law = made.simulation.tolerances
    for right, wrong in zip(readings_of(LineAngles, exact), readings_of(LineAngles, made), strict=True):
        np.testing.assert_allclose(wrong.angles - right.angles, angle_zeros(law, 2, 4), atol=1e-12)
    gains = tension_gains("load_cells", law, 2, 4)
    for right, wrong in zip(readings_of(Tensions, exact), readings_of(Tensions, made), strict=True):
        np.testing.assert_allclose(wrong.tensions / right.tensions - 1.0, gains, atol=1e-12)


def test_zeros_drift_by_their_share_of_the_range() -> None:
    cells = TensionSensor(rate=5.0, deviation=0.0, most=1000.0)
    made = changed(perfect().with_owner(load_cells=cells), tolerances={"tension_drift": 0.01})
    ends = []
    for seed in range(12):
        twin = machine(made, seed, "quasi-static")
        shown = [each for each in run(twin, 300) if isinstance(each, Tensions)]
        ends.append(shown[-1].tensions - twin.truth.tensions)
    assert np.std(ends) == pytest.approx(10.0 * math.sqrt(60.0 / 3600.0), rel=0.3)


def test_an_accelerometer_farther_out_shows_the_tangent_there() -> None:
    """The line's angle changes along it by its sag: as with the same place in the description."""
    moved = changed(perfect(), tolerances={"mount_place": 0.1})
    along = places_along(moved.simulation.tolerances, 2, 4)
    shown = readings_of(LineAngles, moved)[-1].angles
    for i, way in enumerate(along):
        told = changed(perfect(), line_angles={"from_platform": max(0.0, 0.2 + way)})
        assert shown[i] == pytest.approx(readings_of(LineAngles, told)[-1].angles[i], abs=1e-12)


def test_turned_sensors_measure_in_their_own_axes() -> None:
    still = {"yaw_wander": 0.0, "swing_damping": 150.0, "drag": 400.0}
    right, wrong = changed(perfect(), drum=still), changed(perfect(), drum=still, tolerances={"mount_turn": 0.03})
    law = wrong.simulation.tolerances
    for a, b in zip(readings_of(Inertial, right), readings_of(Inertial, wrong), strict=True):
        np.testing.assert_allclose(b.acceleration, a.acceleration @ mounting("inertial", law, 2), atol=1e-12)
    slant = mounting("distance", law, 2)[2, 2]
    for a, b in zip(readings_of(Distance, right), readings_of(Distance, wrong), strict=True):
        assert b.distance == pytest.approx(a.distance / slant, rel=1e-4)
    turn = turn_of(mounting("north", law, 2))
    assert np.abs(turn).max() > 5e-3
    scans = [
        next(scan for scan in readings_of(Scan, each, 110) if scan.source == "north")
        for each in (right, changed(right, tolerances={"mount_turn": 0.03}))
    ]
    bearings = [wall_bearing(scan) for scan in scans]
    assert bearings[1] - bearings[0] == pytest.approx(-turn[2], abs=2e-3)


def wall_bearing(scan: Scan) -> float:
    """Direction of the north wall's line, rad."""
    near = np.abs(scan.angles - 0.5 * math.pi) < 0.3
    x, y = scan.points[near].T
    return math.atan(np.polyfit(x, y, 1)[0])


def test_the_clock_on_the_drum_stamps_what_comes_over_the_link() -> None:
    law = {"clock_offset": 0.05, "clock_drift": 1e-3}
    wrong = changed(perfect(), tolerances=law, clock={"jumps": ((0.5, 1.0), (0.8, -0.25))})
    clock = DrumClock(wrong.simulation, 2)
    for kind in (Inertial, LineAngles, Scan, Encoders):
        right = readings_of(kind, perfect(), 120)
        shown = readings_of(kind, wrong, 120)
        assert len(right) == len(shown) > 0
        for a, b in zip(right, shown, strict=True):
            begin = a.begin if isinstance(a, Scan) else a.time
            jumped = (begin >= 0.5) * 1.0 - (begin >= 0.8) * 0.25
            expected = begin if kind is Encoders else (1.0 + clock.drift) * begin + clock.offset + jumped
            assert (b.begin if isinstance(b, Scan) else b.time) == pytest.approx(expected, abs=1e-12)
            if isinstance(a, Scan):
                assert b.period == pytest.approx(a.period * (1.0 + clock.drift), rel=1e-12)


def test_a_heavier_drum_hangs_on_tenser_lines() -> None:
    heavy = off(mass=0.1)
    empty, powder = mass_factors(heavy.simulation.tolerances, 2)
    twin = machine(heavy, 2)
    assert twin.robot.platform.mass == pytest.approx(40.0 * empty + 20.0 * powder)
    assert twin.truth.powder == pytest.approx(20.0 * powder)
    twin.refill(30.0)
    assert twin.truth.powder == pytest.approx(30.0 * powder)
    assert twin.settings.drum == SETTINGS.drum
