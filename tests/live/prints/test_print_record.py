"""The record of a print: the exact moments of all steps, each against the right piece of path, from a log alone."""

from __future__ import annotations

import dataclasses
import json
import tracemalloc
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.signals import Estimate, LineAngles, PrintState, Progress, SensorFrame, Truth, frozen
from cablewright.live.prints.record import UNUSED, record
from cablewright.live.prints.spooling_regularity import SpoolStatistics
from cablewright.live.prints.steps_table import row_type
from cablewright.live.prints.structure import _floor_correction
from cablewright.live.prints.vibration import WINDOW, VibrationWindows, peak_frequency
from cablewright.machine.log.log import Entry, LogWriter, read_log
from cablewright.models.path_offset import nearest
from cablewright.printing.arc_length_path import Track
from cablewright.printing.job import Bead
from print_logs import SPEED, printed, rounds, standard, without
from twins import SETTINGS, head, perfect


@pytest.fixture(scope="module")
def made():
    return standard()


@pytest.fixture(scope="module")
def found(made):
    entries, track, twin = made
    return record(entries, head(), track, print_speed=SPEED, true_structure=twin.rig.ground.field)


def printing(entries: list[Entry]) -> list[Entry]:
    return [each for each in entries if each.progress is not None and each.progress.state is PrintState.PRINTING]


def test_moments_are_those_of_every_printing_step(made, found) -> None:
    entries, track, _ = made
    steps = printing(entries)
    for own, of in (("truth", found.true), ("estimate", found.estimated)):
        signals = [getattr(each, own) for each in steps]
        near = [nearest(track, s.position, e.progress.distance, 0.3) for s, e in zip(signals, steps, strict=True)]
        errors = np.array([each.offset for each in near])
        ways = np.array([track.at(each.distance).tangent for each in near])
        speeds = (np.array([each.velocity for each in signals]) * ways).sum(axis=1)
        heights = np.array([s.position[2] - e.progress.target[2] for s, e in zip(signals, steps, strict=True)])
        space = np.hypot(errors, heights)
        for result, values in ((of.error, errors), (of.speed, speeds), (of.height, heights), (of.space, space)):
            known = values[np.isfinite(values)]
            assert result.count == len(known)
            assert result.mean == pytest.approx(known.mean(), rel=1e-9)
            assert result.variance == pytest.approx(known.var(), rel=1e-9)
            assert result.size == pytest.approx(np.abs(known).max(), rel=1e-12)
        assert of.errors.counts.sum() == of.error.count
        worst = int(np.nanargmax(np.abs(errors)))
        assert of.worst is not None
        assert of.worst.value == pytest.approx(errors[worst])
        assert of.worst.time == steps[worst].frame.time


def test_states_and_stops_are_counted(made, found) -> None:
    entries, _, _ = made
    for state, seconds in found.states.items():
        assert seconds == pytest.approx(0.01 * sum(e.progress.state is state for e in entries), abs=1e-9)
    assert sum(found.states.values()) == pytest.approx(found.duration)
    assert found.barrier_stops == 1
    assert found.refills == 0
    assert [span.state.value for span in found.spans] == ["ready", "printing", "paused", "printing"]
    assert found.spans[2].reason == "the light barrier is broken"
    assert found.layers == 0
    assert found.layers_begun == 1


def test_lines_are_reported_as_they_were(made, found) -> None:
    entries, _, _ = made
    steps = printing(entries)
    valid = [each.estimate for each in steps if each.estimate.valid]
    for i, line in enumerate(found.lines):
        assert line.taut == pytest.approx(np.mean([not each.slack[i] for each in valid]))
        assert line.max_tension == max(each.truth.tensions[i] for each in steps)
        assert line.mean_tension == pytest.approx(np.mean([each.truth.tensions[i] for each in steps]))
        gone = sum(abs(b.truth.lengths[i] - a.truth.lengths[i]) for a, b in pairwise(entries))
        assert line.wound == pytest.approx(gone, rel=0.1)
        assert line.believed_mean_tension == pytest.approx(line.mean_tension, rel=0.15, abs=15.0)


def test_what_is_drawn_is_of_the_steps(made, found) -> None:
    entries, _, _ = made
    assert len(found.rows) == len(entries)
    assert found.rows["true_position"] == pytest.approx(np.array([e.truth.position for e in entries]))
    assert found.rows["taut"].shape == (len(entries), 4)
    slack = found.rows["slack"] == 1.0
    off = np.abs(found.rows["measured"] - found.rows["taut"])
    assert np.nanmedian(off[slack]) > 3.0 * np.nanmedian(off[~slack])


@pytest.mark.parametrize("missing", ["truth", "estimate", "progress"])
def test_quantities_without_data_in_the_log_are_not_reported(made, missing: str) -> None:
    entries, track, _ = made
    found = record(without(entries, missing), head(), track, print_speed=SPEED)
    assert found.steps == len(entries)
    result = found.to_dict()
    assert (result["mean_path_error"] is None) == (missing != "estimate")
    assert (result["estimated_mean_path_error"] is None) == (missing != "truth")
    assert result["structure"] is None or missing != "estimate"
    assert found.has_truth == (missing == "estimate")


def test_metrics_are_json_with_all_keys(found) -> None:
    result = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    for key in (
        "layers", "distance", "mean_speed", "speed_variance", "mean_path_error", "path_error_variance",
        "max_path_error", "estimated_max_path_error", "barrier_stops", "refills", "states", "lines", "structure",
    ):  # fmt: skip
        assert key in result
    assert result["max_path_error"] == pytest.approx(abs(found.true.worst.value))
    assert {line["name"] for line in result["lines"]} == {"south-west", "south-east", "north-east", "north-west"}


def test_a_log_has_the_record_of_its_steps(made, found, tmp_path: Path) -> None:
    entries, track, _ = made
    path = tmp_path / "print.mcap"
    with path.open("wb") as file, LogWriter(file, head()) as log:
        for each in entries:
            log.write(each.frame, each.command, each.truth, each.estimate, each.progress)
    with read_log(path) as log:
        again = record(log.entries(without=UNUSED), log.head, track, print_speed=SPEED)
    own = found.to_dict()
    for key, value in again.to_dict().items():
        if key not in ("structure", "lines", "notes"):  # the log has no true structure
            assert str(value) == str(own[key])


def follows(track: Track, steps: int, off: float) -> Iterator[Entry]:
    """A print that is *off* (m) to the left of its path, a second a step."""
    m = 4
    none, still = frozen(np.zeros(m)), frozen(np.zeros(3))
    for k in range(steps):
        time, distance = 1.0 + k, SPEED * k
        place = track.at(distance)
        x, y, _ = place.tangent
        at = frozen(place.position + off * np.array([-y, x, 0.0]))
        moves = frozen(SPEED * place.tangent)
        truth = Truth(time, at, moves, still, still, none, none, none, none, 0.0)
        estimate = Estimate(time, at, moves, still, none, none, np.zeros(m, dtype=np.bool_), none)
        progress = Progress(time, PrintState.PRINTING, int(track.layer[track.piece(distance)]), distance, at, off)
        yield Entry(SensorFrame(time), None, truth, estimate, progress)


def test_layers_and_crossings_are_not_mixed_up() -> None:
    track = rounds(1, 3)
    steps = int(track.length / SPEED) + 1
    found = record(follows(track, steps, 0.04), head(plant="quasi-static"), track, print_speed=SPEED)
    assert found.true.error.mean == pytest.approx(0.04, rel=5e-3)
    assert found.true.error.deviation < 1e-3
    assert found.true.speed.mean == pytest.approx(SPEED, rel=1e-3)
    assert found.layers == found.layers_begun == 3
    layers = found.true.by_layer
    assert layers.number.tolist() == [1, 2, 3]
    assert layers.mean == pytest.approx([0.04] * 3, rel=5e-3)


@pytest.mark.slow
def test_memory_does_not_grow_with_the_log() -> None:
    track, peaks = rounds(1, 3), []
    for steps in (8_000, 24_000):
        tracemalloc.start()
        stretched = (replace(e, frame=SensorFrame(e.frame.time)) for e in follows(track, steps, 0.01))
        record(stretched, head(plant="quasi-static"), track, print_speed=SPEED)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.1 * peaks[0]


def test_the_rebuilt_structure_is_like_the_true_one(found) -> None:
    structure = found.structure
    assert structure is not None
    assert structure.difference is not None
    assert abs(structure.difference.mean) < 4e-3
    assert structure.difference.rms < 6e-3
    assert structure.mass == pytest.approx(found.rows["powder"][0] - found.rows["powder"][-1], abs=0.05)


def all_seen(structure):
    """The structure without what is thin, as scans would see it."""
    field = structure.true
    high = dataclasses.replace(field, heights=np.where(field.heights > 5e-3, field.heights, 0.0))
    return dataclasses.replace(structure, true=high, estimated=high)


def test_mass_that_the_scans_missed_is_said(found) -> None:
    structure = found.structure
    assert structure.mass_seen == pytest.approx(structure.estimated_mass / structure.mass)
    assert structure.mass_seen < 0.9
    [note] = structure.notes
    assert f"the scans saw {structure.estimated_mass:.3g} of {structure.mass:.3g} kg that were laid" in note
    assert note in found.notes
    assert not all_seen(structure).notes


def test_beads_finer_than_the_cells_are_said(found) -> None:
    whole = all_seen(found.structure)
    assert not dataclasses.replace(whole, bead=Bead(width=0.06, height=0.02)).notes
    [note] = dataclasses.replace(whole, bead=Bead(width=0.002, height=0.001)).notes
    assert note.startswith("beads are 2 mm wide, cells of the height field 20 mm")


def test_a_scan_without_errors_rebuilds_the_heap() -> None:
    """The error on the heap is the cells' size: 2 cm of a flank of 22 degrees are 8 mm high."""
    entries, track, twin = printed(20.0, perfect(), seed=5, heap=6.0)
    known = [
        replace(e, estimate=replace(e.estimate, position=e.truth.position, rotation=e.truth.rotation, valid=True))
        for e in entries
    ]
    made = record(known, head(perfect()), track, print_speed=SPEED, true_structure=twin.rig.ground.field)
    assert made.structure is not None
    assert made.structure.difference is not None
    assert made.structure.difference.on_structure < 4e-3
    assert abs(made.structure.difference.mean) < 5e-4
    assert made.structure.highest > 0.03
    assert made.structure.mass == pytest.approx(6.0, rel=1e-9)
    assert np.nanmedian(np.abs(made.structure.estimated.heights[made.structure.estimated.heights < 1e-3])) < 1e-4


def test_a_scan_that_is_too_low_is_raised() -> None:
    rng = np.random.default_rng(5)
    heights = np.concatenate([rng.normal(0.0, 2e-3, 300), rng.normal(0.02, 2e-3, 100)])
    assert _floor_correction(heights, 2e-3) == 0.0
    assert _floor_correction(heights - 0.02, 2e-3) == pytest.approx(0.02, abs=1e-3)
    assert _floor_correction(heights[:0], 2e-3) == 0.0


def test_a_tone_is_found_and_noise_is_not() -> None:
    rng = np.random.default_rng(1)
    times = 0.01 * np.arange(2000) + rng.normal(0.0, 1e-5, 2000)
    noise = rng.normal(0.0, 2e-3, 2000)
    for tone in (9.3, 17.21, 30.0):
        angles = -0.5 + 0.01 * times + noise + 2e-3 * np.sin(2.0 * np.pi * tone * times)
        angles[rng.random(2000) < 0.01] = np.nan
        assert peak_frequency(times, angles, 1.1 * tone) == pytest.approx(tone, abs=0.01)
    assert np.isnan(peak_frequency(times, noise, 15.0))
    assert np.isnan(peak_frequency(times, noise, 45.0)), "beyond the range of the rate"
    assert np.isnan(peak_frequency(times[::20], noise[::20], 9.3)), "a rate of 5 Hz"


def test_a_slope_against_temperature_is_found_back() -> None:
    rng, vibration = np.random.default_rng(2), VibrationWindows(1)
    for k in range(12):
        warm, near = 20.0 + 0.5 * k, 15.0 + rng.uniform(-2.0, 2.0)
        tone = near * np.exp(-2e-3 * (warm - 22.0))
        times = 100.0 * k + np.arange(0.0, WINDOW + 0.02, 0.01)
        for time in times:
            angle = 1e-2 * np.sin(2.0 * np.pi * tone * time) + rng.normal(0.0, 1e-3)
            if vibration.add(LineAngles(time, frozen([angle]))):
                vibration.close(warm, np.array([near]))
    result = vibration.result()
    assert len(result.times) == 12
    assert result.slopes[0] == pytest.approx(-2e-3, abs=4.0 * result.slope_sigmas[0] + 1e-6)
    assert result.slope_sigmas[0] < 2e-4


def test_a_regular_coil_is_regular_and_a_walk_is_not() -> None:
    robot = head().robot
    coils = SpoolStatistics(robot, SETTINGS.winch)
    lengths = np.linspace(3.0, 12.0, 4000)[:, None] * np.ones(4)
    regular = SpoolStatistics(robot, SETTINGS.winch)
    regular.add(lengths, np.full_like(lengths, 0.05))
    base = regular.result()[0].regular
    radii = np.stack([np.interp(lengths[:, 0], regular.result()[0].lengths, base)] * 4, axis=1)
    radii[:, 1] += 1e-3 * np.sin(7.0 * lengths[:, 1])
    radii[:, 2] += 5e-4
    coils.add(lengths, radii)
    result = coils.result()
    assert result[0].irregularity < 1e-4
    assert result[1].irregularity == pytest.approx(1e-3 / np.sqrt(2.0), rel=0.1)
    assert result[2].irregularity < 1e-4
    assert np.isnan(result[0].true_irregularity)


def test_columns_have_their_own_places() -> None:
    rows = np.arange(row_type(4).itemsize / 8).view(row_type(4))
    values = np.concatenate([np.ravel(rows[name]) for name in ("time", "step", "target", "position", "excess")])
    assert len(np.unique(values)) == len(values)
    assert rows["excess"].shape == (1, 4)
