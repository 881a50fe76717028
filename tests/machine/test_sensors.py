"""Sensors: exact without errors by independent oracles; with errors, by the laws of their settings."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from cablewright.foundation.signals import (
    Barrier,
    Climate,
    Condition,
    Distance,
    Encoders,
    Inertial,
    LineAngles,
    Reading,
    Scan,
)
from cablewright.kernels.plant import dynamics, machine_step
from cablewright.kernels.plant.lidar_rays import FAR, ray_to_floor, ray_to_wall
from cablewright.machine.simulated.floor import Ground
from cablewright.machine.simulated.link import Channel, Gaps
from cablewright.machine.simulated.settings import FaultPlan, Link
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.slack import tangent_angle
from twins import SETTINGS, SIMULATION, TWIN, changed, machine, perfect, run

Array = NDArray[np.float64]
QUIET = {"yaw_wander": 0.0, "swing_damping": 150.0, "drag": 400.0}


def of(kind: type, readings: list[Reading]) -> list:
    return [reading for reading in readings if isinstance(reading, kind)]


def scans(readings: list[Reading], source: str) -> list[Scan]:
    return [scan for scan in of(Scan, readings) if scan.source == source]


def oracle_range(origin: Array, way: Array, walls: list[tuple[Array, Array]]) -> float:
    """Distance to the nearest of some segments by solving each 2 x 2 system."""
    found = math.inf
    for start, end in walls:
        A = np.column_stack([way[:2], start - end])
        if abs(np.linalg.det(A)) < 1e-14:
            continue
        t, s = np.linalg.solve(A, start - origin[:2])
        if t > 0 and 0 <= s <= 1:
            found = min(found, float(t))
    return found


def test_lidar_ranges_are_those_of_rays_and_segments() -> None:
    drum = {**QUIET, "yaw_stiffness": 1.0}
    twin = machine(perfect(changed(drum=drum)), start=(0.6, 0.4, 1.2))
    twin.rig.body[dynamics.YAW_REST] = 0.3  # the twist rests turned: the drum turns during the scan
    way: list[tuple[float, Array, Array]] = [(0.0, twin.truth.position, twin.truth.rotation)]
    readings = run(
        twin,
        100,
        (0.5, -0.5, -0.5, 0.5),
        each=lambda _: way.append((twin.truth.time, twin.truth.position, twin.truth.rotation)),
    )
    walls = [(np.array(wall.start), np.array(wall.end)) for wall in SETTINGS.room.walls]
    times = np.array([each[0] for each in way])
    for source in ("north", "south"):
        (scan,) = scans(readings, source)
        place = np.array(SETTINGS.lidars[source].place)
        seen = 0
        for k in range(0, 720, 7):
            if np.isnan(scan.ranges[k]):
                continue
            position = np.array([np.interp(scan.times[k], times, [e[1][j] for e in way]) for j in range(3)])
            turned = np.array([np.interp(scan.times[k], times, [e[2][j] for e in way]) for j in range(3)])
            R = rotation_matrix(turned)
            angle = scan.angles[k]
            expected = oracle_range(position + R @ place, R @ [math.cos(angle), math.sin(angle), 0.0], walls)
            assert scan.ranges[k] == pytest.approx(expected, abs=2e-6)
            seen += 1
        assert seen > 40
        assert abs(twin.truth.rotation[2]) > 0.05


def rotation_matrix(vector: Array) -> Array:
    angle = float(np.linalg.norm(vector)) + 1e-15
    x, y, z = vector / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * K @ K


def test_the_drum_masks_its_own_side_and_the_window_is_5_cm_deep() -> None:
    twin = machine(perfect(changed(drum=QUIET)), plant="quasi-static", start=(0.0, 0.5, 1.2))
    readings = run(twin, 5)
    north, south = scans(readings, "north")[0], scans(readings, "south")[0]
    degrees = np.degrees(north.angles)
    assert np.isnan(north.ranges[(degrees > -149) & (degrees < -31)]).all()
    assert np.isnan(south.ranges[(degrees > 31) & (degrees < 149)]).all()
    points = north.points[~np.isnan(north.ranges)] + [0.0, 0.75]  # the drum is not turned
    east = points[np.abs(points[:, 0] - 2.5) < 0.08]
    window = east[(east[:, 1] > -0.4) & (east[:, 1] < 1.4)]
    assert np.median(window[:, 0]) == pytest.approx(2.55, abs=0.02)
    assert np.isfinite(north.ranges).sum() > 350


def test_range_errors_have_the_laws_of_the_settings() -> None:
    still = changed(drum=QUIET)
    biases, spreads, lost = [], [], []
    for seed in range(6):
        measured, true = machine(still, seed, "quasi-static"), machine(perfect(still), seed, "quasi-static")
        pairs = [{scan.begin: scan.ranges for scan in scans(run(each, 50), "north")} for each in (measured, true)]
        common = [begin for begin in pairs[0] if begin in pairs[1]]
        off = np.array([pairs[0][begin] - pairs[1][begin] for begin in common])
        seen = ~np.isnan([pairs[1][begin] for begin in common])
        near = seen & (np.abs(off) < 0.02)
        lost.append(np.isnan(off)[seen].mean())
        biases.append(off[near].mean())
        spreads.append(off[near].std())
        assert measured._sensors["north"].bias == pytest.approx(biases[-1], abs=2e-4)
        assert (np.abs(off[seen]) > 0.02).mean() == pytest.approx(SIMULATION.lidars["north"].outliers, abs=2e-3)
    assert np.mean(spreads) == pytest.approx(SETTINGS.lidars["north"].deviation, rel=0.03)
    assert np.std(biases) > 5e-4
    assert np.mean(lost) == pytest.approx(SIMULATION.lidars["north"].dropout, rel=0.2)


def test_heights_of_heaps_are_seen_from_above() -> None:
    ground = Ground(load("merlet2023"), TWIN)
    ground.deposit((0.21, -0.2), (0.41, -0.2), 3.0)
    assert ground.mass == pytest.approx(3.0, rel=1e-9)
    ground.deposit((5.0, 0.0), (5.0, 0.0), 1.5)
    ground.deposit((2.49, 4.99), (2.49, 4.99), 1.5)
    assert ground.mass == pytest.approx(6.0, rel=1e-9)
    grid, heights, shown = ground.grid, ground.heights, ground.field
    assert grid[3] == heights.max()
    for x, y in ((0.31, -0.2), (0.28, -0.21), (0.5, 0.5)):
        down = ray_to_floor(x, y, 1.5, 0.0, 0.0, -1.0, 10.0, grid, heights)
        assert 1.5 - down == pytest.approx(shown.at(np.array([[x, y]]))[0], abs=1e-9)
    for slope in (0.3, -0.5):
        way = np.array([slope, 0.1, -1.0]) / math.hypot(slope, 0.1, 1.0)
        origin = np.array([0.31 - slope, -0.3, 1.0])
        met = ray_to_floor(*origin, *way, 10.0, grid, heights)
        on_way = origin + np.linspace(0.0, met, 3000)[:, None] * way
        above = on_way[:, 2] - shown.at(on_way)
        assert above[-1] == pytest.approx(0.0, abs=1e-6)
        assert above[:-1].min() > -1e-6
    assert ray_to_floor(0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.5, grid, heights) == FAR
    assert ray_to_wall(0.0, 0.0, 1.0, 0.0, np.array([2.0, 1.0, 2.0, 3.0])) == FAR


def test_vertical_lidar_and_distance_sensor_measure_the_height() -> None:
    twin = machine(perfect(changed(drum=QUIET)), plant="quasi-static")
    readings = run(twin, 5)
    (scan,) = scans(readings, "vertical")
    lidar = SETTINGS.lidars["vertical"]
    down = np.argmin(np.abs(scan.angles))
    assert scan.ranges[down] == pytest.approx(twin.truth.position[2] + lidar.place[2], abs=1e-6)
    assert of(Distance, readings)[-1].distance == pytest.approx(twin.truth.position[2] - SETTINGS.drum.valve, abs=1e-6)
    before = of(Distance, readings)[-1].distance
    later = of(Distance, run(twin, 50, valve=1.0))[-1].distance
    assert later < before - 5e-3  # it pours where it stands


def test_line_angles_are_the_tangents_of_statics() -> None:
    twin = machine(perfect(changed(drum=QUIET, climate={"swing": 0.0})))
    run(twin, 50, (0.3, 0.0, 0.0, 0.0))
    readings = run(twin, 1500)
    measured = of(LineAngles, readings)[-1].angles
    hung = solve_forward(Model(twin.robot), twin.truth.lengths).checked()
    expected = [tangent_angle(hung, line.name, SETTINGS.line_angles.from_platform) for line in twin.robot.lines]
    np.testing.assert_allclose(measured, expected, atol=2e-6)


def test_angle_noise_has_its_deviation() -> None:
    """Of the mean of the readings that a quasi-static period represents."""
    averaged = SETTINGS.line_angles.rate * SIMULATION.quasi_static_period
    bare = changed(drum=QUIET, line={"vibration": 0.0}, line_angles={"outliers": 0.0})
    measured = of(LineAngles, run(machine(bare, plant="quasi-static"), 2000))
    true = of(LineAngles, run(machine(perfect(bare), plant="quasi-static"), 2000))
    by_time = {reading.time: reading.angles for reading in true}
    off = np.array([reading.angles - by_time[reading.time] for reading in measured if reading.time in by_time])
    assert np.nanstd(off) == pytest.approx(math.radians(0.1) / math.sqrt(averaged), rel=0.03)
    assert np.isnan(off).mean() == pytest.approx(SIMULATION.line_angles.dropout, abs=1e-3)


def test_a_line_vibrates_at_its_own_frequency() -> None:
    """The first mode rings at half of wave speed over length, with the amplitude that the settings give it."""
    packed = Model(machine(plant="quasi-static").robot).packed
    twin = machine(plant="quasi-static")
    row, y, plane = packed.lines[0], twin.rig.states[0], twin.rig.work.planes[0]
    speed = math.sqrt(twin.truth.tensions[0] * 9.81 / row[13])
    vibration, shape, moved, dt = np.array([0.01, 1e-4, 9.81]), np.zeros(2), [], 2e-3
    noise = np.random.default_rng(0).standard_normal(60_000)
    for each in noise:
        machine_step.vibrate(row, y, plane, np.zeros(6), each, vibration, dt, shape)
        moved.append(shape[0])
    power = np.abs(np.fft.rfft(moved)) ** 2
    frequency = np.fft.rfftfreq(len(moved), dt)[np.argmax(power)]
    assert frequency == pytest.approx(speed / (2 * y[2]), rel=0.03)
    assert np.std(moved) == pytest.approx(1e-4, rel=0.25)


def test_inertial_readings_are_gravity_and_turning() -> None:
    twin = machine(perfect(changed(drum=QUIET)))
    still = of(Inertial, run(twin, 20))[-1]
    np.testing.assert_allclose(still.acceleration, [0, 0, 9.81], atol=1e-5)
    np.testing.assert_allclose(still.rate, 0.0, atol=1e-6)


def test_inertial_readings_integrate_to_the_motion() -> None:
    """Readings of gyro and accelerometer, integrated, are the motion of the drum: turn and place of the unit."""
    twin = machine(perfect(changed(drum={"yaw_wander": 0.0, "swing_damping": 0.0})))
    twin.rig.motion[9:12] = 0.3, -0.2, 0.4
    place = np.array(SETTINGS.inertial.place)
    moment = [(twin.truth.position, twin.truth.rotation)]
    readings = of(Inertial, run(twin, 100, each=lambda _: moment.append((twin.truth.position, twin.truth.rotation))))
    R = np.eye(3)
    for reading in readings:
        R = R @ rotation_matrix(reading.rate * 0.01)
    turned = moment[len(readings)][1]
    assert np.abs(R - rotation_matrix(turned)).max() < 2e-2
    forces = np.array([rotation_matrix(moment[k + 1][1]) @ r.acceleration for k, r in enumerate(readings)])
    at = np.array([p + (rotation_matrix(v) @ place if np.any(v) else place) for p, v in moment])
    velocity = 0.01 * np.cumsum(forces - [0, 0, 9.81], axis=0)
    fit = np.gradient(at[:, 0], 0.01)[2:-2]
    assert np.abs(velocity[1 : len(fit) + 1, 0] - velocity[1, 0] + fit[0] - fit).max() < 0.02


def test_the_room_is_reported() -> None:
    measured = of(Climate, run(machine(plant="quasi-static"), 500))
    assert len(measured) == 10
    assert abs(np.mean([reading.temperature for reading in measured]) - 22.0) < 0.2
    assert all(0.0 <= reading.humidity <= 1.0 for reading in measured)


def test_every_sensor_may_lose_readings_and_report_outliers() -> None:
    spoiled = {"dropout": 0.3, "outliers": 0.1}
    names = ("inertial", "line_angles", "distance", "encoders", "climate_sensor")
    settings = perfect(changed(**dict.fromkeys(names, spoiled)))
    tables = {name: {**spoiled, "rate": 5.0} for name in names}
    readings = run(machine(changed(settings, **tables), plant="quasi-static"), 2000)
    for kind in (Inertial, Encoders, Climate):
        assert len(of(kind, readings)) == pytest.approx(0.7 * 2000, rel=0.05)
    lost = np.mean([np.isnan(reading.angles) for reading in of(LineAngles, readings)])
    assert lost == pytest.approx(0.3, rel=0.1)
    assert np.mean([np.isnan(reading.distance) for reading in of(Distance, readings)]) == pytest.approx(0.3, rel=0.1)
    wrong = {
        Inertial: [np.abs(reading.acceleration - [0, 0, 9.81]).max() > 0.01 for reading in of(Inertial, readings)],
        Encoders: [np.abs(reading.counts).max() > 0 for reading in of(Encoders, readings)],
        Climate: [abs(reading.temperature - 22.0) > 1.0 for reading in of(Climate, readings)],
    }
    for kind, found in wrong.items():
        assert np.mean(found) == pytest.approx(0.1 / 0.7, rel=0.35), kind


def test_messages_come_late_in_order_and_some_never() -> None:
    link = Link(latency=0.02, jitter=0.05, loss=0.2)
    channel = Channel(link, np.random.default_rng(0), Gaps(link, 1, 0))
    came = []
    for k in range(3000):
        now = 0.01 * k
        channel.send(now, Distance(now, 1.0))
        came += [(now, reading.time) for reading in channel.arrived(now)]
    late = np.array([now - time for now, time in came])
    assert (late >= 0.02 - 1e-9).all()
    assert (np.diff([time for _, time in came]) > 0).all()
    assert len(came) == pytest.approx(0.8 * 3000, rel=0.05)


def test_a_gap_of_the_link_is_reported_and_delays_readings() -> None:
    twin = machine(changed(wifi={"gaps": ((0.5, 2.5),)}))
    frames = []
    run(twin, 300, each=frames.append)
    within = [frame for frame in frames if 0.51 < frame.time < 2.49]
    assert all(isinstance(reading, Barrier | Encoders | Climate) for frame in within for reading in frame.readings)
    assert any(notice.condition is Condition.SILENT for frame in within for notice in frame.notices)
    after = next(frame for frame in frames if frame.time > 2.49 and len(frame.readings) > 20)
    assert min(reading.time for reading in after.readings) < 0.6


def test_planned_faults_happen() -> None:
    plans = (
        FaultPlan(source="north", begin=2.0, end=4.0),
        FaultPlan(source="line_angles", line="south-east", begin=1.0, end=2.0),
        FaultPlan(source="line_angles", line="north-west", kind="stuck", begin=1.0, end=2.0),
        FaultPlan(source="inertial", kind="stuck", begin=1.0),
    )
    twin = machine(TWIN.with_simulation(faults=plans))
    readings = run(twin, 600)
    turns = [round(scan.time + scan.period) for scan in scans(readings, "north")]
    assert turns == [1, 2, 5, 6][: len(turns)]
    assert len(turns) >= 3
    angles = [reading for reading in of(LineAngles, readings) if 1.0 <= reading.time < 2.0]
    assert all(np.isnan(reading.angles[1]) for reading in angles)
    assert len({reading.angles[3] for reading in angles}) == 1
    assert len({reading.angles[2] for reading in angles}) > 50
    stuck = [reading for reading in of(Inertial, readings) if reading.time > 1.0]
    assert len({reading.acceleration[0] for reading in stuck}) == 1
    assert len({reading.time for reading in stuck}) == len(stuck)


def test_one_sensor_left_out_changes_no_other() -> None:
    one = run(machine(plant="quasi-static"), 20)
    other = run(machine(TWIN.with_owner(distance=None), plant="quasi-static"), 20)
    for a, b in zip(scans(one, "south"), scans(other, "south"), strict=True):
        np.testing.assert_array_equal(a.ranges, b.ranges)


def test_readings_cannot_be_written_to() -> None:
    for reading in run(machine(plant="quasi-static"), 10, (0.1, 0, 0, 0)):
        for each in dataclasses.fields(reading):
            value = getattr(reading, each.name)
            if isinstance(value, np.ndarray):
                assert not value.flags.writeable


def test_a_quasi_static_period_of_a_second_sees_what_shorter_ones_see() -> None:
    """Rays are measured from where the drum is at their own time, between the ends of a period."""
    settings = perfect(changed(drum={"yaw_wander": 0.0, "powder": 0.0}, climate={"swing": 0.0}))
    seen = {}
    for period in (0.1, 1.0):
        twin = machine(settings.with_simulation(quasi_static_period=period), plant="quasi-static")
        seen[period] = run(twin, round(5.0 / period), (0.5, 0.5, -0.5, -0.5))
    for source in ("north", "south", "vertical"):
        fine, coarse = (
            [scan for scan in of(Scan, readings) if scan.source == source] for readings in (seen[0.1], seen[1.0])
        )
        assert [scan.begin for scan in coarse] == pytest.approx([0.0, 1.0, 2.0, 3.0, 4.0], abs=1e-9)
        for a, b in zip(fine, coarse, strict=True):
            np.testing.assert_allclose(a.ranges, b.ranges, atol=2e-3)
    ends = [
        [each for each in of(kind, seen[period]) if each.time > 4.95][-1]
        for kind in (Encoders, LineAngles)
        for period in seen
    ]
    assert np.abs(ends[0].counts - ends[1].counts).max() <= 1
    np.testing.assert_allclose(ends[2].angles, ends[3].angles, atol=1e-6)
