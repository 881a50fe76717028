"""The estimator of Merlet 2023 on a simulated machine: its errors, and its reports when sensors fail."""

from __future__ import annotations

import dataclasses
import importlib
import math
import pkgutil
from typing import Any

import numpy as np
import pytest

import cablewright.estimation
from cablewright.estimation.lidar.room import Laser
from cablewright.estimation.merlet2023 import observer
from cablewright.estimation.time_buffer import TimeBuffer
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Command, Encoders, Estimate, Inertial, LineAngles, Scan, SensorFrame
from cablewright.live.estimator_settings import observer_settings, surveyed_walls
from cablewright.machine.sensors.lidars import LidarSettings
from cablewright.robot import load
from cases import some
from observer_runs import broken, drive, errors, observe
from twins import SETTINGS, TWIN, changed, machine

ROBOT = load("merlet2023")
NAMES = [line.name for line in ROBOT.lines]


@pytest.fixture(scope="module")
def whole() -> Any:
    return drive(14.0, seed=2)


def named(found: list[Estimate]) -> set[tuple[str, str]]:
    return {(fault.source, fault.sentence) for estimate in found for fault in estimate.faults}


def test_a_moving_machine_is_found_within_two_centimetres(whole: Any) -> None:
    found = observe(whole)
    assert not named(found)
    assert errors(found, whole, 4.0).max() < 0.02
    late = [(e, truth) for e, (frame, truth) in zip(found, whole, strict=True) if frame.time > 4.0]
    assert max(abs(e.yaw - truth.rotation[2]) for e, truth in late) < math.radians(0.6)
    assert all(e.valid for e, _ in late)
    slack = [(e.slack, truth.excess) for e, truth in late if truth.excess.max() > 5e-3]
    assert np.mean([not (s[x > 5e-3] == 0).any() and not s[x <= 0].any() for s, x in slack] or [1.0]) >= 0.98


@pytest.mark.parametrize("seed", some([3, 11]))
def test_a_machine_that_hangs_still_is_found_within_its_lidars_bias(seed: int) -> None:
    lidars = {name: lidar.model_copy(update={"bias": 0.0}) for name, lidar in SETTINGS.lidars.items()}
    unbiased = TWIN.with_owner(lidars=lidars)
    recording = drive(6.0, unbiased, seed=seed, held=True)
    found = observe(recording)
    level = [
        float(np.hypot(*(e.position - truth.position)[:2]))
        for e, (frame, truth) in zip(found, recording, strict=True)
        if frame.time > 3.2
    ]
    assert np.mean(np.array(level) < 2e-3) >= 0.95


@pytest.mark.parametrize(
    ("plan", "source", "bound"),
    [
        ({"source": "north", "begin": 5.0}, "north", 0.05),
        ({"source": "north", "begin": 5.0, "kind": "stuck"}, "north", 0.05),
        ({"source": "south", "begin": 5.0}, "south", 0.05),
        ({"source": "vertical", "begin": 0.0}, "vertical", 0.05),
        ({"source": "inertial", "begin": 5.0}, "inertial", 0.05),
        ({"source": "inertial", "begin": 5.0, "kind": "stuck"}, "inertial", 0.05),
        ({"source": "encoders", "begin": 5.0}, "encoders", 0.12),
        ({"source": "encoders", "begin": 5.0, "kind": "stuck"}, "encoders", 0.12),
        ({"source": "line_angles", "begin": 5.0}, "line_angles", 0.05),
        ({"source": "line_angles", "begin": 5.0, "line": "south-east"}, "line_angles", 0.05),
        ({"source": "line_angles", "begin": 5.0, "line": "south-east", "kind": "stuck"}, "line_angles", 0.05),
        ({"source": "distance", "begin": 0.0}, "distance", 0.02),
    ],
)
def test_a_sensor_that_fails_is_named_and_the_error_stays_small(
    plan: dict[str, Any], source: str, bound: float
) -> None:
    recording = drive(11.0, broken(plan), seed=2)
    found = observe(recording)
    assert source in {fault.source for fault in found[-1].faults}
    if "line" in plan:
        assert any(plan["line"] in fault.sentence for fault in found[-1].faults)
    assert found[-1].valid
    assert errors(found, recording, 4.0).max() < bound


def test_a_gap_of_the_wireless_link_is_survived() -> None:
    wifi = {"gaps": ((5.0, 7.0),)}
    recording = drive(12.0, changed(wifi=wifi), seed=2)
    found = observe(recording)
    assert {"north", "south", "inertial", "line_angles"} <= {source for source, _ in named(found)}
    assert not found[-1].faults
    assert errors(found, recording, 4.0).max() < 0.05


def test_no_lidar_no_position() -> None:
    recording = drive(4.0, broken({"source": "north"}, {"source": "south"}), seed=2)
    found = observe(recording)
    assert not any(estimate.valid for estimate in found)
    assert {"north", "south"} <= {fault.source for fault in found[-1].faults}
    assert np.isnan(found[-1].lengths).all()


def test_no_wall_in_sight_is_said(whole: Any) -> None:
    def blind(reading: Any) -> Any:
        if isinstance(reading, Scan) and reading.source != "vertical" and reading.begin > 5.0:
            return dataclasses.replace(
                reading, ranges=np.where(reading.ranges > 0.0, 0.4 + 0.0 * reading.ranges, np.nan)
            )
        return reading

    recording = [
        (SensorFrame(frame.time, tuple(map(blind, frame.readings)), frame.notices), truth)
        for frame, truth in whole[:1000]
    ]
    found = observe(recording)
    assert {source for source, _ in named(found)} == {"north", "south"}
    assert errors(found, recording, 4.0).max() < 0.1


def test_a_clock_that_jumps_back_is_named_and_survived(whole: Any) -> None:
    again = [(*whole[k],) for k in (*range(700), *range(300, 900))]
    found = observe(again)
    at = found[700]
    assert any(fault.source == "clock" for fault in at.faults)
    assert np.isfinite(at.position).all()
    assert errors(found[1000:], again[1000:], 0.0).max() < 0.15
    assert found[-1].valid


def test_frames_without_readings_and_readings_from_the_future_change_no_place(whole: Any) -> None:
    empty = [(SensorFrame(0.01 * (k + 1)), None) for k in range(50)]
    assert not any(estimate.valid for estimate in observe(empty))  # type: ignore[arg-type]
    late = Inertial(1e6, np.zeros(3), np.zeros(3))
    (only,) = observe([(SensorFrame(0.01, (late,)), whole[0][1])])
    assert [fault.source for fault in only.faults] == ["inertial"]


def test_rubbish_is_survived(whole: Any) -> None:
    """Numbers that are none, and frames in which everything is out of order."""
    random, recording = np.random.default_rng(7), []
    for frame, truth in whole[:900]:
        readings = [_spoiled(reading, random) for reading in frame.readings]
        random.shuffle(readings)  # type: ignore[arg-type]
        recording.append((SensorFrame(frame.time, tuple(readings)), truth))
    for estimate in observe(recording):
        assert np.isfinite(estimate.position).all() or not estimate.valid


def _spoiled(reading: Any, random: np.random.Generator) -> Any:
    if random.random() > 0.05:
        return reading
    if isinstance(reading, Scan):
        return dataclasses.replace(reading, ranges=random.uniform(0.0, 20.0, len(reading.ranges)))
    if isinstance(reading, Inertial):
        return dataclasses.replace(reading, rate=np.array([math.nan, math.inf, 1e9]))
    if isinstance(reading, LineAngles):
        return dataclasses.replace(reading, angles=random.uniform(-9.0, 9.0, 4))
    if isinstance(reading, Encoders):
        return dataclasses.replace(reading, counts=reading.counts + random.integers(-(10**7), 10**7, 4))
    return reading


def test_a_quasi_static_machine_is_found_too() -> None:
    recording = drive(40.0, seed=2, plant="quasi-static")
    found = observe(recording)
    assert errors(found, recording, 8.0).max() < 0.03


def test_an_operators_laser_picks_and_a_wrong_one_is_named(whole: Any) -> None:
    x, y, _ = whole[99][1].position
    right = Laser("east", 2.5 - x), Laser("north", 5.0 - y)
    assert observe(whole[:300], lasers=right)[-1].valid
    found = observe(whole[:300], lasers=(Laser("east", 3.1 - x),))
    assert not found[-1].valid
    assert any("no position agrees with the laser" in sentence for _, sentence in named(found))


def test_turns_do_not_queue_up(whole: Any) -> None:
    """After a long gap of the link, and at steps of a second."""
    known = observer_settings(ROBOT, SETTINGS)
    state = observer.start(known)
    scans = [r for frame, _ in whole for r in frame.of(Scan)]
    for k in range(20):
        readings = tuple(dataclasses.replace(scan, begin=scan.begin + 14.0 * k) for scan in scans)  # type: ignore[type-var]
        observer.step(known, state, SensorFrame(14.0 * (k + 1), readings))
        assert not state.turns.pending or k == 0
    observer.step(
        known, state, SensorFrame(280.01, tuple(dataclasses.replace(s, begin=s.begin + 266.0) for s in scans))
    )  # type: ignore[type-var]
    assert len(state.turns.pending) <= 3 * known.walls.kept_turns
    empty = Scan("north", 300.0, 1e-3, 0.0, 0.01, np.empty(0))
    observer.step(known, state, SensorFrame(301.0, (empty,)))


def test_estimation_never_sees_the_truth() -> None:
    import pathlib

    folder = pathlib.Path(cablewright.estimation.__file__).parent
    for file in folder.rglob("*.py"):
        text = file.read_text("utf-8")
        assert "Truth" not in text
        assert "cablewright.machine" not in text


def test_walls_of_a_room_are_its_faces_put_together() -> None:
    room = surveyed_walls(SETTINGS.room)
    found = {wall.name: (wall.normal, wall.distance) for wall in room.walls}
    assert found == {"west": ((-1.0, 0.0), 2.5), "north": ((0.0, 1.0), 5.0), "east": ((1.0, 0.0), 2.5)}


def test_machines_that_cannot_be_observed_are_rejected() -> None:
    blind = SETTINGS.model_copy(update={"lidars": {}})
    with pytest.raises(InputError, match="horizontal lidar"):
        observer_settings(ROBOT, blind)
    tilted: LidarSettings = SETTINGS.lidars["vertical"]
    with pytest.raises(InputError, match="level plane"):
        observer_settings(ROBOT, SETTINGS.model_copy(update={"lidars": {"north": tilted}}))
    with pytest.raises(InputError, match="line_angles"):
        observer_settings(ROBOT, SETTINGS.model_copy(update={"line_angles": None}))
    bare = SETTINGS.room.model_copy(update={"walls": ()})
    with pytest.raises(InputError, match="needs walls"):
        observer_settings(ROBOT, SETTINGS.model_copy(update={"room": bare}))
    known = observer_settings(ROBOT, SETTINGS)
    with pytest.raises(InputError, match="lidars"):
        dataclasses.replace(known, lidars=("north",))
    with pytest.raises(InputError, match="counts_per_radian"):
        dataclasses.replace(known, counts_per_radian=0.0)


def test_nothing_is_kept_without_end() -> None:
    trail = TimeBuffer(1, 10)
    assert trail.at([0.0]).tolist() == [[0.0]]
    for k in range(1000):
        trail.add(float(k), [2.0 * k if k < 999 else 0.0])
    trail.add(5.0, [0.0])  # from before: left out
    trail.add(999.0, [1998.0])  # again
    assert len(trail) <= 20
    assert trail.at([998.5, 2000.0]).tolist() == [[1997.0], [1998.0]]


def test_start_knows_nothing() -> None:
    state = observer.start(observer_settings(ROBOT, SETTINGS))
    assert state.tracker is None
    assert math.isnan(state.located.yaw_offset)


@pytest.mark.parametrize(("floor_cone", "low", "high"), [(math.radians(70.0), -0.01, 0.01), (None, -0.3, -0.02)])
def test_a_ridge_under_the_vertical_lidar_is_no_floor(floor_cone: float | None, low: float, high: float) -> None:
    """Powder lies all along the scan from the beginning: in the paper's cone there is no floor."""
    twin = machine(plant="quasi-static", seed=3)
    known = observer_settings(load("merlet2023"), twin.settings)
    assert known.height is not None
    known = dataclasses.replace(known, height=dataclasses.replace(known.height, floor_cone=floor_cone))
    state, still = observer.start(known), Command(0.0, np.zeros(4))
    x, y, _ = twin.truth.position.tolist()
    twin.rig.ground.deposit((x - 0.5, y), (x + 0.7, y), 15.0)
    for _ in range(60):
        found = observer.step(known, state, twin.step(dataclasses.replace(still, time=twin.time)))
    assert low < found.position[2] - twin.truth.position[2] < high


@pytest.mark.parametrize("seed", some([2, 5]))
def test_a_scan_that_comes_late_is_no_first_position(seed: int) -> None:
    """The link is gone at the start: what it sends afterwards is of where a platform at 3 cm/s has been."""
    recording, late, held = drive(8.0, seed=seed), [], []
    for frame, truth in recording:
        wireless = [each for each in frame.readings if not isinstance(each, Encoders)]
        held += wireless
        kept = tuple(each for each in frame.readings if isinstance(each, Encoders))
        if frame.time >= 2.9:
            kept, held = (*kept, *held), []
        late.append((SensorFrame(frame.time, kept), truth))
    found = observe(late)
    first = next(k for k, each in enumerate(found) if each.valid)
    assert late[first][0].time > 2.9
    moved = np.linalg.norm(late[first][1].position - recording[200][1].position)
    assert moved > 0.02
    assert np.linalg.norm(found[first].position - late[first][1].position) < 0.6 * moved


def test_states_are_nested_in_parts_of_at_most_15_fields() -> None:
    counted = {}
    for each in pkgutil.walk_packages(cablewright.estimation.__path__, "cablewright.estimation."):
        for name, kind in vars(importlib.import_module(each.name)).items():
            if dataclasses.is_dataclass(kind) and not kind.__dataclass_params__.frozen:
                counted[name] = len(dataclasses.fields(kind))
    assert {"FilterState", "ObserverState", "BodyState", "ReckoningState"} <= counted.keys()
    assert max(counted.values()) <= 15, counted


@pytest.mark.parametrize("depth", [0.05, 0.0])
def test_a_window_behind_its_wall_spreads_the_list_of_positions_by_half_its_depth(depth: float) -> None:
    """The paper's list, of an operator to choose from: +-3 cm in x and +-2 mm in y, in a room with such a window."""
    room = SETTINGS.room
    walls = tuple(
        wall.model_copy(update={"start": (2.5 + depth, -0.5), "end": (2.5 + depth, 1.5)})
        if wall.name == "window"
        else wall
        for wall in room.walls
        if depth or not wall.name.startswith("window, ")
    )
    twin = machine(TWIN.with_owner(room=room.model_copy(update={"walls": walls})), seed=4)
    settings = observer_settings(ROBOT, twin.settings)
    state = observer.start(settings)
    while twin.time < 4.2:
        estimate = observer.step(settings, state, twin.step(Command(twin.time, np.zeros(4))))
    places = np.array([each.position for each in state.located.wall_pose.candidates])
    near = places[np.linalg.norm(places - places[0], axis=1) < 0.3]
    spread = 0.5 * (near.max(axis=0) - near.min(axis=0))
    assert spread[0] == pytest.approx(0.5 * depth, abs=5e-3)
    assert spread[1] < 2e-3
    assert np.linalg.norm((estimate.position - twin.truth.position)[:2]) < 5e-3  # which is not its error
