"""Guided calibrations: proposed poses are safe on the true robot, help, and end; reported sigmas hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.campaigns.camera_rooms import Setup, room

import cablewright as cw
from cablewright.calibration.guidance.pictures_to_take import usable
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, MeasuredRange, Point, TouchedPlane
from cablewright.calibration.poses.simulation import measure, random_poses
from cablewright.calibration.unknowns import unknowns_of, with_values
from cablewright.foundation.errors import InputError
from cablewright.solvers.inverse import solve_inverse
from cases import often, some

WANG = cw.load("wang2021")
EXITS = np.array([line.exit_point for line in WANG.lines])
ROUGH = 0.05
SURVEYED = CalibrationPlan(points=tuple(Point(line=line.name, at=line.exit_point) for line in WANG.lines[:3]))


def file_of(seed: int) -> cw.Robot:
    """The robot's file, whose exit points are wrong by up to `ROUGH`."""
    wrong = EXITS + np.random.default_rng(seed).uniform(-ROUGH, ROUGH, EXITS.shape)
    return with_values(WANG, unknowns_of(WANG, ("exit_point",)), wrong.ravel(), raised=True)


def measured_at(poses: np.ndarray, seed: int) -> Measured:
    """What the true robot measures there, with guesses like those that were proposed."""
    return measure(WANG, poses, 1e-4, np.random.default_rng(seed), guess=ROUGH).measured


@pytest.mark.parametrize("seed", some([1, 4]))
def test_it_leads_from_nothing_to_a_good_calibration(seed: int) -> None:
    file, data, poses, before = file_of(seed), None, np.zeros((0, 3)), np.inf
    for _ in range(12):
        found = cw.guide(file, data, SURVEYED, rough=2.0 * ROUGH, need=5e-3, seed=seed)
        if found.advice == "stop":
            break
        assert found.advice == "measure"
        assert found.sigma_next <= before
        before = found.sigma if found.sigma is not None else np.inf
        poses = np.concatenate([poses, [each.pose for each in found.next_poses]])
        data = measured_at(poses, seed)
    assert found.advice == "stop"
    assert found.found.verdict == "good"
    assert len(poses) < 40
    assert np.abs(found.found.values[:12] - EXITS.ravel()).max() < 4.0 * 5e-3
    assert found.next_poses == ()


def test_what_it_calls_safe_the_true_robot_holds() -> None:
    held = []
    for seed in range(6):
        found = cw.guide(file_of(seed), rough=ROUGH, tension_limits=(20.0, 400.0), seed=seed)
        poses = np.array([each.pose for each in found.next_poses if each.safe])
        held += solve_inverse(cw.Model(WANG, tension_limits=(20.0, 400.0)), poses).ok.tolist()
        for each in found.next_poses:
            assert 20.0 - 1e-6 <= each.min_tension <= each.max_tension <= 400.0 + 1e-6
    assert np.mean(held) > 0.95


def test_it_knows_better_than_random_poses() -> None:
    """After the proposed poses exit points are known better than after as many random ones."""
    poses = random_poses(WANG, 24, np.random.default_rng(3))
    guided = cw.guide(WANG, measured_at(poses, 3), SURVEYED, rough=ROUGH, count=6)
    proposed = np.array([each.pose for each in guided.next_poses])
    noise = []
    for more in (proposed, *(random_poses(WANG, 6, np.random.default_rng(seed)) for seed in range(10, often(12, 15)))):
        made = cw.calibrate(WANG, measured_at(np.concatenate([poses, more]), 4), SURVEYED, rough=ROUGH)
        noise.append(float((made.noise_sigma[:12] / made.encoder_sigma).max()))
    assert noise[0] < min(noise[1:])


def test_counts_lead_to_the_poses() -> None:
    """With the true file the reported counts are those that the robot has there; the first pose is home."""
    found = cw.guide(WANG, rough=0.01)
    poses = np.array([each.pose for each in found.next_poses])
    counts = np.array([each.counts for each in found.next_poses])
    assert counts[0] == pytest.approx(np.zeros(4))
    assert counts == pytest.approx(measure(WANG, poses, 0.0, np.random.default_rng(0)).measured.counted, abs=1e-9)
    assert np.array_equal(found.to_measure.guess, poses)


def test_few_poses_give_no_figure_and_say_how_many_are_missing() -> None:
    made = measured_at(random_poses(WANG, 6, np.random.default_rng(1)), 1)
    found = cw.guide(WANG, made, rough=ROUGH)
    assert (found.sigma, found.exits, found.poses) == (None, (), 6)
    assert len(found.next_poses) == 11  # 12 that there must be, 5 that test them


def test_data_of_another_machine_end_it() -> None:
    made = measured_at(random_poses(WANG, 30, np.random.default_rng(1)), 1)
    found = cw.guide(WANG, replace(made, counted=made.counted[:, [1, 0, 2, 3]]), rough=ROUGH)
    assert found.advice == "mend"
    assert "no further pose helps" in found.refusal
    assert found.next_poses == ()


def test_what_it_cannot_do_is_rejected() -> None:
    with pytest.raises(InputError, match="next = 0"):
        cw.guide(WANG, count=0)
    with pytest.raises(InputError, match="rigid lines only"):
        cw.guide(cw.Model(WANG, cw.Fidelity.of("elastic")))
    with pytest.raises(InputError, match="add exit_point to the plan's unknowns"):
        cw.guide(WANG, plan=CalibrationPlan(unknowns=("length_offset",)))


def test_poses_of_a_plan_keep_their_row_where_others_have_no_picture() -> None:
    """Rows 2 and 5 have no picture: entries of the plan follow their poses, those of dropped ones go."""
    pytest.importorskip("cv2")
    data = room(cw.load("ipanema"), Setup(poses=6), 3).data
    assert data.sightings is not None
    pictures = tuple(None if at in (1, 4) else each for at, each in enumerate(data.sightings.pictures))
    given = replace(data, sightings=replace(data.sightings, pictures=pictures))
    up = {"point": (0.0, 0.0, 0.0), "normal": (0.0, 0.0, 1.0)}
    plan = CalibrationPlan(
        planes=(TouchedPlane(poses=(2, 3, 6), **up), TouchedPlane(poses=(5,), **up), TouchedPlane(poses=(1, 9), **up)),
        ranges=(
            MeasuredRange(point=(0.0, 0.0, 0.0), poses=(6, 5, 1), values=(6.0, 5.0, 1.0)),
            MeasuredRange(point=(0.0, 0.0, 0.0), poses=(2,), values=(2.0,)),
        ),
    )
    measured, kept, words = usable(given, plan)
    assert measured is not None
    assert np.array_equal(measured.counted, data.counted[[0, 2, 3, 5]])
    assert [each.poses for each in kept.planes] == [(2, 4), (1, 9)]
    assert [(each.poses, each.values) for each in kept.ranges] == [((4, 1), (6.0, 1.0))]
    assert sum("has no picture" in each for each in words) == 2
