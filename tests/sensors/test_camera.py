"""A camera in the room, in the loop: its simulation, and what the estimators make of readings that are late."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cablewright as cw
from cablewright.estimation import started_filter
from cablewright.estimation.camera import KnownCamera
from cablewright.exchange.ros.messages import RosMessages
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import CameraPose, Command, SensorFrame, frozen
from cablewright.live.drive_along_path import DriveSettings, Pilot, random_loop
from cablewright.live.estimator_settings import started_settings
from cablewright.live.estimators import best_estimator, estimator
from cablewright.live.rest_pose import rest_pose
from cablewright.machine.description_sigmas import MachineAccuracy
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import read_log, write_log
from cablewright.machine.sensors.camera import CameraSensor, PlatformTag
from cablewright.machine.simulated.sensors import camera as cameras
from cablewright.machine.simulated.sensors.camera import SIMULATED, CameraFlaws, RoomCamera
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.rotation import motion_between

TAGS = tuple(
    PlatformTag(size=0.25, at=at, normal=normal)
    for at, normal in (
        ((-0.15, -0.2, -0.3), (-0.5, -1.0, 0.2)),
        ((0.15, -0.2, -0.3), (0.5, -1.0, 0.2)),
        ((-0.1, -0.2, -0.6), (0.0, -1.0, 0.3)),
        ((0.1, -0.2, -0.75), (0.2, -1.0, 0.0)),
    )
)
SHEET: dict[str, Any] = {
    "rate": 2.0, "at": (0.0, -6.0, 2.0), "looks": (0.0, 1.0, -0.1), "width": 3840, "height": 2160,
    "focal_length": 2400.0, "corner_deviation": 0.15, "tags": TAGS,
}  # fmt: skip
SENT = {"place_deviation": 1e-3, "turn_deviation": 2e-4, "focal_deviation": 2e-4, "time_deviation": 5e-3}
FLAWS = {"occlusion": 0.1, "dropout": 0.05, "outliers": 0.01, "exposure": 0.005, "readout": 0.01}
HOME = 0.02  # m, by which a body's lengths at home are wrong at most
START = np.array([0.5, 1.0, 1.2])


def twin(severity: str = "ideal", flaws: dict[str, Any] | None = None, **sheet: Any) -> TwinSettings:
    """The exhibition's machine with a camera in place of its lidars."""
    camera = CameraSensor(**(SHEET | sheet))
    made = with_severity(load_twin("merlet2023"), severity)
    return made.with_owner(camera=camera, lidars={}).with_simulation(camera=CameraFlaws(**(flaws or {})))


def swayed(
    settings: TwinSettings, seconds: float, seed: int = 4
) -> Iterator[tuple[SensorFrame, Array, SimulatedMachine]]:
    """Yield frames of a machine that moves to and fro, each with the true pose (6,), and the machine."""
    machine = SimulatedMachine(cw.load("merlet2023"), settings, START, seed=seed)
    for _ in range(round(seconds / machine.period)):
        speeds = np.array([1.5, -1.5, -1.5, 1.5]) * np.sin(2.0 * machine.time)
        frame = machine.step(Command(machine.time, winch_speeds=speeds))
        yield frame, np.concatenate([machine.truth.position, machine.truth.rotation]), machine


def sighted(settings: TwinSettings, seconds: float, seed: int = 4) -> tuple[list[CameraPose], Array, Array, RoomCamera]:
    """Readings (k), the motions (k, 6) from the true pose then to the one shown, delays (k,), s, and the camera."""
    true, read, late, cameras = dict[int, Array](), list[CameraPose](), list[float](), set[RoomCamera]()
    for frame, pose, machine in swayed(settings, seconds, seed):
        cameras |= {each for each in machine._sensors.values() if isinstance(each, RoomCamera)}
        true[round(1e3 * frame.time)] = pose
        read += frame.of(CameraPose)
        late += [frame.time - each.time for each in frame.of(CameraPose)]
    off = [motion_between(true[round(1e3 * each.time)], each.pose) for each in read]
    return read, np.array(off), np.array(late), cameras.pop()


def test_covariance_is_that_of_the_errors_and_depth_is_worst() -> None:
    read, off, late, _ = sighted(twin(rate=10.0), 12.0)
    assert len(read) == 119
    squares = [float(one @ np.linalg.solve(each.spread, one)) for one, each in zip(off, read, strict=True)]
    assert np.mean(squares) == pytest.approx(6.0, abs=4.0 * np.sqrt(12.0 / len(read)))
    sigmas = np.sqrt([np.diag(each.spread)[:3] for each in read])
    assert (sigmas[:, 1] > 2.5 * sigmas[:, 0]).all()  # along its axis, beside across
    assert late == pytest.approx(np.full(len(read), 0.001), abs=0.0101)  # the wire's


def test_errors_of_one_unit_are_those_that_the_estimators_know() -> None:
    """The slopes of `KnownCamera` are the oracle of a camera with large errors and sharp pixels."""
    large = {"place_deviation": 5e-3, "turn_deviation": 2e-3, "focal_deviation": 1e-3}
    _, off, _, camera = sighted(twin(corner_deviation=1e-4, **large), 6.0, seed=8)
    axes = camera._true_axes @ camera._axes.T
    true_turn = 0.5 * np.array([axes[2, 1] - axes[1, 2], axes[0, 2] - axes[2, 0], axes[1, 0] - axes[0, 1]])
    short = 1.0 - camera._true_focal / camera.settings.focal_length
    errors = np.concatenate([camera._true_at - camera._at, true_turn, [short, 0.0]])
    told = KnownCamera.told(camera.settings)
    expected = told.slopes(START, np.zeros(6)) @ errors
    assert np.linalg.norm(expected[:3]) > 5e-3
    assert off.mean(axis=0) == pytest.approx(expected, abs=0.02 * float(np.linalg.norm(expected)) + 2e-4)


def test_late_hidden_lost_and_random_readings() -> None:
    _, off, late, _ = sighted(twin(flaws={"latency": (0.03, 0.2), "occlusion": 0.3, "outliers": 0.05}, rate=10.0), 30.0)
    assert 0.03 <= late.min() < 0.06
    assert 0.15 < late.max() <= 0.222  # each arrives after the one before
    assert 0.5 < len(off) / 300.0 < 0.9
    assert 0.01 < np.mean(np.linalg.norm(off[:, :3], axis=1) > 0.1) < 0.1


def test_a_rolling_shutter_and_blur_are_errors_in_motion() -> None:
    still = sighted(twin(rate=10.0), 8.0)[1]
    rolled = sighted(twin(rate=10.0, flaws={"readout": 0.2}), 8.0)[1]
    blurred, _, _, _ = sighted(twin(rate=10.0, flaws={"exposure": 0.08}), 8.0)
    rms = [float(np.sqrt(np.mean(each[:, [0, 2]] ** 2))) for each in (still, rolled)]
    assert rms[1] > 2.0 * rms[0]
    sigmas = np.sqrt([each.spread[0, 0] for each in blurred])
    assert sigmas.max() > 2.0 * sigmas.min()


def test_the_wrong_one_of_two_poses_is_not_given(monkeypatch: pytest.MonkeyPatch) -> None:
    """One flat tag: noise of its corners decides between two poses; where it may have decided none is given."""

    def of_one_tag(noise: float) -> tuple[float, float]:
        """Share of the pictures that are answered, and of these the share with a wrong rotation."""
        _, off, _, _ = sighted(twin(rate=20.0, tags=(TAGS[3],), corner_deviation=noise), 6.0)
        return len(off) / 119.0, float(np.mean(np.linalg.norm(off[:, 3:], axis=1) > 0.35))

    assert of_one_tag(0.03) == (1.0, 0.0)
    share, wrong = of_one_tag(0.3)
    monkeypatch.setattr(cameras, "_AMBIGUOUS", 0.0)  # the better of both is given, however near the other
    every, flipped = of_one_tag(0.3)
    assert every == 1.0
    assert flipped > 0.05
    assert 0.3 < share < 0.8
    assert wrong < 0.3 * flipped


def test_no_tag_is_read_from_too_far_or_from_behind() -> None:
    for sheet in ({"focal_length": 500.0}, {"at": (0.0, 6.0, 2.0), "looks": (0.0, -1.0, -0.1)}):
        assert not sighted(twin(**sheet), 3.0)[0]


def test_a_snapshot_keeps_readings_that_have_not_arrived() -> None:
    settings = twin(flaws={"latency": (0.2, 0.4)}, rate=10.0)
    *_, (_, _, machine) = swayed(settings, 1.0)
    other = SimulatedMachine.resumed(cw.load("merlet2023"), settings, machine.snapshot(), seed=4)
    late = list[Array]()
    for _ in range(60):
        frames = [each.step(Command(each.time, np.zeros(4))) for each in (machine, other)]
        one, two = ([r.pose.tolist() for r in frame.of(CameraPose)] for frame in frames)
        assert one == two
        late += one
    assert len(late) > 3


def test_log_and_ros_have_the_pose(tmp_path: Path) -> None:
    settings = twin()
    head = LogHead(cw.load("merlet2023"), settings.owner, 0.01, simulation=settings.simulation, plant="dynamic", seed=4)
    sent = []
    with write_log(tmp_path / "a.mcap", head) as log:
        for frame, _, _ in swayed(settings, 1.2):
            sent += frame.of(CameraPose)
            log.write(frame)
    with read_log(tmp_path / "a.mcap") as read:
        entries = list(read.entries())
    logged = [each for entry in entries for each in entry.frame.of(CameraPose)]
    assert [(each.time, each.pose.tolist(), each.covariance.tolist()) for each in logged] == [
        (each.time, each.pose.tolist(), each.covariance.tolist()) for each in sent
    ]
    ros = [each for entry in entries for each in RosMessages(head).of(entry) if each.topic == "/camera_pose"]
    assert [each.type for each in ros] == ["geometry_msgs/msg/PoseWithCovarianceStamped"] * len(sent)
    assert ros[0].fields["pose"]["pose"]["position"]["y"] == pytest.approx(sent[0].pose[1])
    assert ros[0].fields["pose"]["covariance"][7] == sent[0].covariance[7]


def looped(settings: TwinSettings, seed: int, seconds: float) -> tuple[Array, Array, Array, list[str]]:
    """Errors (k, 3), m, of the filter and of encoders alone along a random path, nees (k,), and faults at the end."""
    robot, way = cw.load("merlet2023"), random_loop(cw.load("merlet2023"), 28.0, seed)
    machine = SimulatedMachine(robot, settings, [*way[0], 1.2], seed=seed)
    pilot = Pilot(machine, way, DriveSettings(), seed)
    known = started_settings(robot, settings.owner)
    state, alone = started_filter.start(known), estimator("encoders", robot, settings.owner, np.array([*way[0], 1.2]))
    found, others, nees = list[Array](), list[Array](), list[float]()
    for step in range(round(seconds / machine.period)):
        frame, truth = machine.step(pilot.command()), machine.truth
        told, beside = started_filter.step(known, state, frame), alone.step(frame)
        if told.valid and frame.time > 5.0 and step % 20 == 0:
            off = told.position - truth.position
            assert told.covariance is not None
            found.append(off)
            others.append(beside.position - truth.position)
            nees.append(float(off @ np.linalg.solve(told.covariance[:3, :3], off)))
    return np.array(found), np.array(others), np.array(nees), [each.sentence for each in told.faults]


@pytest.mark.parametrize("seed", [71, 72])
def test_a_point_platform_is_found_by_encoders_and_camera(seed: int) -> None:
    """On a rough machine, whose encoders alone are wrong by centimetres."""
    off, alone, nees, faults = looped(twin("rough", FLAWS | {"latency": (0.03, 0.2)}, **SENT), seed, 15.0)
    rms, without = (float(np.sqrt((each**2).sum(axis=1).mean())) for each in (off, alone))
    assert len(off) > 40
    assert rms < 8e-3 < 15e-3 < without
    assert nees.mean() < 7.8
    assert not faults


def test_a_late_picture_counts_at_its_own_time() -> None:
    """With 0.4 s of delay, in which B moves by over 1 cm, the errors stay those of prompt pictures."""
    prompt, late = (looped(twin(flaws={"latency": (wait, wait)}), 73, 12.0)[0] for wait in (0.0, 0.4))
    sizes = [float(np.sqrt((each**2).sum(axis=1).mean())) for each in (prompt, late)]
    assert sizes[1] < sizes[0] + 1e-3


def test_a_camera_that_is_moved_is_reported() -> None:
    settings = twin()
    known = started_settings(cw.load("merlet2023"), settings.owner)
    state, told = started_filter.start(known), None
    for frame, _, _ in swayed(settings, 9.0):
        told = started_filter.step(known, state, shifted(frame, 0.3, 0.3) if frame.time > 5.0 else frame)
        assert frame.time > 5.0 or not told.faults
    assert told is not None
    assert not told.valid
    assert any("was the camera" in each.sentence for each in told.faults)


def test_a_camera_that_was_moved_a_little_leaves_the_estimate_invalid() -> None:
    """Its pictures are accepted again after some time, but nothing shows whether the camera moved or the platform."""
    settings = twin()
    known = started_settings(cw.load("merlet2023"), settings.owner)
    state, valid, accepted = started_filter.start(known), list[bool](), False
    for frame, _, _ in swayed(settings, 16.0):
        valid.append(started_filter.step(known, state, shifted(frame, 0.03) if frame.time > 5.0 else frame).valid)
        accepted = frame.time > 10.0 and (accepted or state.filter.judged.rejections["camera"] == 0)
    assert valid[len(valid) // 4]
    assert accepted
    assert not valid[-1]


def shifted(frame: SensorFrame, by: float, turned: float = 0.0) -> SensorFrame:
    """The frame with the poses by the camera *by* m away along each axis, and *turned*, rad, about each."""
    off = np.repeat([by, turned], 3)
    moved = (CameraPose(each.time, frozen(each.pose + off), each.covariance) for each in frame.of(CameraPose))
    kept = tuple(each for each in frame.readings if not isinstance(each, CameraPose))
    return SensorFrame(frame.time, (*kept, *moved), frame.notices)


def before(robot: cw.Robot) -> CameraSensor:
    """A camera 3 m before the frame of a *robot* with a rigid platform, on which tags are large."""
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    middle = 0.5 * (low + high)
    tags = tuple(each.model_copy(update={"size": 0.3}) for each in TAGS)
    at = (float(middle[0]), float(low[1]) - 3.0, float(middle[2]))
    return CameraSensor(**(SHEET | SENT | {"at": at, "tags": tags, "rate": 2.5}))


def test_a_body_with_load_cells_names_a_camera_that_was_moved() -> None:
    """Measurements between two pictures agree with the statics, and say nothing of the camera."""
    robot = cw.load("cogiro")
    settings = load_twin("cogiro").with_owner(camera=before(robot)).with_simulation(camera=CameraFlaws(**FLAWS))
    pose = rest_pose(robot).equilibrium.pose
    machine = SimulatedMachine(robot, settings, pose, seed=83, plant="dynamic")
    found, told = estimator("filter", robot, machine.settings, pose), None
    speeds = np.array([0.1, 0.1, -0.1, -0.1, 0.1, 0.1, -0.1, -0.1])
    while machine.time < 8.0:
        frame = machine.step(Command(machine.time, speeds * np.sin(0.3 * machine.time)))
        told = found.step(shifted(frame, 0.1) if frame.time > 3.0 else frame)
        assert frame.time > 3.0 or not any(each.source == "camera" for each in told.faults)
    assert told is not None
    assert told.valid
    assert any("they are ignored" in each.sentence for each in told.faults)
    assert np.linalg.norm(told.position - machine.truth.position) < 0.02


@pytest.mark.parametrize("seed", [81, 82])
def test_a_body_is_found_by_encoders_and_camera(seed: int) -> None:
    """A machine without cells and inertial unit, whose lengths at home are wrong by up to 2 cm."""
    robot = cw.load("cogiro")
    accuracy = MachineAccuracy(home_length=HOME / math.sqrt(3.0))  # of a uniform distribution
    plain = load_twin("cogiro").with_owner(load_cells=None, motor_torques=None, inertial=None, accuracy=accuracy)
    off_home = plain.simulation.tolerances.model_copy(update={"home_length": HOME})
    plain = plain.with_simulation(tolerances=off_home)
    settings = plain.with_owner(camera=before(robot)).with_simulation(camera=CameraFlaws(**FLAWS))
    assert (best_estimator(plain.owner), best_estimator(settings.owner)) == ("encoders", "filter")
    pose = rest_pose(robot).equilibrium.pose
    machine = SimulatedMachine(robot, settings, pose, seed=seed, plant="quasi-static")
    two = [estimator(name, robot, machine.settings, pose) for name in ("encoders", "filter")]
    sizes, nees = list[list[float]](), list[float]()
    for step in range(60):
        speeds = np.array([0.5, 0.5, -0.5, -0.5, 0.5, 0.5, -0.5, -0.5]) * np.sin(0.3 * machine.time)
        frame = machine.step(Command(machine.time, speeds))
        found = [each.step(frame) for each in two]
        if step > 10:
            off = [each.position - machine.truth.position for each in found]
            sizes.append([float(np.linalg.norm(each)) for each in off])
            assert found[1].covariance is not None
            nees.append(float(off[1] @ np.linalg.solve(found[1].covariance[:3, :3], off[1])))
    alone, seen = np.sqrt(np.mean(np.square(sizes), axis=0))
    assert seen < 0.5 * alone
    assert np.mean(nees) < 7.8


@pytest.mark.parametrize(
    ("key", "value", "why"),
    [
        ("up", (0.0, 1.0, -0.1), "up: is parallel to the direction that it faces"),
        ("tags", (), "tags: Tuple should have at least 1 item"),
        ("corner_deviation", 0.0, "corner_deviation: Input should be greater than 0"),
        ("focal_deviation", 0.6, "focal_deviation: Input should be less than or equal to 0.5"),
    ],
)
def test_bad_sheets(key: str, value: object, why: str) -> None:
    with pytest.raises(ValueError, match=why.partition(": ")[2]):
        CameraSensor(**(SHEET | {key: value}))


def test_bad_flaws_and_a_machine_without_the_camera() -> None:
    with pytest.raises(ValueError, match="must be the shortest and the longest, in this order"):
        CameraFlaws(latency=(0.2, 0.1))
    plain = load_twin("merlet2023").with_owner(lidars={})
    with pytest.raises(InputError, match="horizontal lidar"):
        started_settings(cw.load("merlet2023"), plain.owner)


def test_the_table_of_the_page_is_read(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "camera.md").read_text()
    table = page.partition("## In the loop")[2].partition("```toml\n")[2].partition("```")[0]
    machine = (Path(cw.__file__).parent / "machine" / "library" / "merlet2023.toml").read_text()
    (tmp_path / "machine.toml").write_text(machine + table)
    found = load_twin(tmp_path / "machine.toml")
    assert found.owner.sheets["camera"].rate == 2.0
    assert found.simulation.flaws(SIMULATED).latency == (0.03, 0.2)
