"""Positions measured during a print: where it stops for them, and the corrections learnt from them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cablewright.control.path_follower import Target
from cablewright.estimation.length_corrections import MOUNT
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.saved_state import load as restore
from cablewright.foundation.saved_state import save
from cablewright.foundation.signals import Encoders, SensorFrame
from cablewright.live.estimators import DeadReckoning, estimator
from cablewright.live.prints.loop import run as run_loop
from cablewright.live.prints.measurement_stops import PlaceVisits
from cablewright.live.prints.plan import MachineTwin, PrintOptions, plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.live.prints.simulated_operator import attendant_of
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.severities import with_severity
from cablewright.printing.arc_length_path import Track
from cablewright.printing.job import load_job
from cablewright.robot import load
from cablewright.solvers.inverse import inverse
from cablewright.studies.campaigns.true_errors import TrueErrors

EXAMPLES = Path(__file__).parents[3] / "examples"
ROBOT, HOUSE = load("house-printer"), load_job(EXAMPLES / "house.toml")
PLACE = np.array([1.0, -0.5, 1.5])
HOURLY = {"place_every": 1200.0, "place_stops": 4}


def house(**options: object) -> MachineTwin:
    """Two layers of the house, on a machine that creeps and whose mounts give, and is as described in all else."""
    machine = with_severity(load_twin("house-printer"), "rough", ("creep", "exits"))
    chosen = PrintOptions(layers=2, plant="quasi-static", period=2.0, seed=51009, **options)  # type: ignore[arg-type]
    return twin_of(ROBOT, HOUSE, machine, chosen)


@cache
def path() -> Track:
    return house().path.track


def stops(visits: PlaceVisits, begin: float, end: float, speed: float, now: float = 0.0) -> list[float]:
    """The distances, m, at which a platform stops on its way along the house's path, at a *speed*, m/s."""
    found, distance = [], begin
    while distance <= end:
        layer = int(path().layer[path().piece(distance)])
        target = Target(np.zeros(3), np.zeros(3), distance, layer, speed, True, False, False)
        while visits.is_due(path(), target, now):
            visits.stopped()
            found.append(distance)
        distance, now = distance + speed, now + 1.0
    return found


def layer(number: int, track: Track) -> tuple[float, float]:
    """Where a layer begins along the path, and how long it is, m."""
    at, begins = track.visits.number.tolist().index(number), np.append(track.visits.begin, track.length)
    return float(begins[at]), float(begins[at + 1] - begins[at])


def test_places_by_layers_divide_each_layer() -> None:
    begin, length = layer(2, path())
    wanted = begin + length * np.arange(4) / 4
    found = stops(PlaceVisits(layers=1, stops=4), 0.0, path().length, 0.1)
    np.testing.assert_allclose(found, wanted, atol=0.11)
    resumed = PlaceVisits(layers=1, stops=4)
    np.testing.assert_allclose(stops(resumed, begin + 0.3 * length, path().length, 0.1), wanted[2:], atol=0.11)


def test_places_by_time_begin_immediately_and_divide_a_layer_s_length() -> None:
    _, length = layer(1, path())
    found = stops(PlaceVisits(every=2000.0, stops=4), 0.0, path().length, 0.1)
    gaps = np.diff(found)
    np.testing.assert_allclose(gaps[:3], length / 4, atol=0.11)
    assert found[0] <= 0.11
    assert found[4] == pytest.approx(200.0, abs=0.11)  # 2000 s on
    late = stops(PlaceVisits(every=2000.0, stops=4), 100.0, path().length, 0.1, now=1000.0)
    assert late[0] == pytest.approx(200.0, abs=0.11)  # resumed: with the next visit


def test_one_place_by_layers_is_at_their_beginning() -> None:
    begin, _ = layer(2, path())
    np.testing.assert_allclose(stops(PlaceVisits(layers=1), 0.0, path().length, 0.1), [begin], atol=0.11)
    assert stops(PlaceVisits(), 0.0, path().length, 1.0) == []


def printed(**options: object) -> tuple[float, DeadReckoning, list[int]]:
    """Mean error in space, m, of the second layer's end of a print, what estimated, and its places along layers, mm."""
    twin = house(**options)
    machine, printer = begin_print(twin, plan_print(twin))
    attendant, errors, places = attendant_of(machine, printer, twin.choices), TrueErrors(twin, machine), []
    measure = attendant.measure

    def kept(layer: int, along: int) -> None:
        places.append(along)
        measure(layer, along)

    attendant.measure = kept
    run_loop(printer, attendant, errors)
    assert printer.finished
    assert isinstance(printer.estimator, DeadReckoning)
    return errors.path.result().space.mean, printer.estimator, places


def test_a_print_learns_from_its_places() -> None:
    """Creep and mounts of a machine: half of the error that places one by one leave is gone, and mounts are found."""
    alone, untaught, at = printed(**HOURLY)
    together, taught, also = printed(**HOURLY, place_learn=True)
    assert len(at) >= 4
    assert len(also) >= 4
    assert untaught.learnt is None
    learnt = taught.learnt
    assert learnt is not None
    assert together < 0.5 * alone
    off = learnt.used[:, MOUNT] - 1e-5  # of the severity
    assert (np.abs(off) < 3.0 * learnt.known.sigmas[:, MOUNT]).all()
    assert (learnt.known.sigmas[:, MOUNT] < 0.9e-5).all()


def counts_to(place: np.ndarray) -> np.ndarray:
    """Counts (4,) paid out to a place, m, from where the estimators begin."""
    winch, paid = load_twin("house-printer").owner.winch, inverse(ROBOT, place).lengths - inverse(ROBOT, PLACE).lengths
    return np.rint(paid / 0.1 / (2.0 * np.pi) * winch.counts * winch.ratio).astype(np.int64)


def counted(time: float, counts: np.ndarray) -> SensorFrame:
    return SensorFrame(time, (Encoders(time, counts),))


def test_what_was_learnt_is_saved_with_a_print() -> None:
    """A print that is resumed where it stood is at the same places afterwards, and knows them as well."""
    owner = load_twin("house-printer").owner
    began = estimator("encoders", ROBOT, owner, PLACE, place_sigma=1e-3)
    assert isinstance(began, DeadReckoning)
    counts = np.zeros(4, dtype=np.int64)
    for k, away in enumerate(([0.02, 0.0, -0.03], [-0.01, 0.01, -0.02])):
        before, counts = counts, counts_to(PLACE + (k + 1.0) * np.array([-0.4, 0.3, -0.1]))
        for part in range(20):
            began.step(counted(300.0 * k + part, before + (counts - before) * (part + 1) // 20))
        began.place_measured(began.step(counted(300.0 * k + 20.0, counts)).position + np.array(away))
    for time in (400.0, 400.1, 400.2):
        there = began.step(counted(time, counts))
    snapshot = save(began)
    resumed = estimator("encoders", ROBOT, owner, there.position, place_sigma=1e-3)
    assert isinstance(resumed, DeadReckoning)
    restore(resumed, snapshot)
    again = resumed.step(counted(400.5, np.zeros(4, dtype=np.int64)))
    np.testing.assert_allclose(again.position, there.position, atol=1e-5)
    moved = counts_to(PLACE + np.array([-0.7, 0.5, -0.2])) - counts
    for one, at in ((began, counts + moved), (resumed, moved)):
        one.step(counted(401.0, at))
    one, other = (each.step(counted(402.0, at)) for each, at in ((began, counts + moved), (resumed, moved)))
    assert np.linalg.norm(one.position - there.position) > 0.01
    np.testing.assert_allclose(other.position, one.position, atol=1e-4)  # creep of its first step
    for each, at in ((began, counts + moved), (resumed, moved)):
        each.place_measured(one.position + np.array([0.01, -0.01, 0.02]))
        assert each.learnt is not None
        assert each.step(counted(403.0, at)).valid
    assert began.learnt is not None
    assert resumed.learnt is not None
    np.testing.assert_allclose(resumed.learnt.known.sigmas, began.learnt.known.sigmas, rtol=1e-3)
    away = (resumed.learnt.known.values - began.learnt.known.values) / began.learnt.known.sigmas
    assert np.abs(away).max() < 0.02


def test_before_the_first_counts_nothing_is_learnt() -> None:
    made = estimator("encoders", ROBOT, load_twin("house-printer").owner, PLACE, place_sigma=1e-3)
    assert isinstance(made, DeadReckoning)
    with pytest.raises(AnswerError, match="has read no encoder yet"):
        made.place_measured(PLACE)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"place_every": 5.0}, "place every = 5 s: must be 60 s or more, or 0: never"),
        ({"place_every": float("inf")}, "place every = inf s"),
        ({"place_stops": 0}, "place stops = 0: must be from 1 to 100"),
        (
            {"place_stops": 2},
            "place stops: give place layers or place every, which set when positions are measured; both are 0",
        ),
        ({"place_learn": True}, "place learn: give place layers or place every"),
        ({"place_every": 60.0, "place_learn": True, "place_tensions": True}, "give one of them, not both"),
    ],
)
def test_options_that_do_not_fit(options: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        twin_of(ROBOT, HOUSE, None, PrintOptions(**options))


def test_machines_that_places_do_not_teach() -> None:
    merlet, ring = load("merlet2023"), load_job(EXAMPLES / "blind-machines.toml")
    with pytest.raises(InputError, match="place learn: machine 'merlet2023': cable that lies so irregularly"):
        twin_of(merlet, ring, None, PrintOptions("encoders", place_every=60.0, place_learn=True))
    with pytest.raises(InputError, match="place every: is for point platforms in no plane, by encoders alone"):
        twin_of(merlet, ring, None, PrintOptions(place_every=60.0))


def test_a_print_with_other_places_is_another_print() -> None:
    """All of them are in the options that a resumed print must have."""
    one = PrintOptions(**HOURLY, place_learn=True)  # type: ignore[arg-type]
    assert all(replace(one, **{key: PrintOptions.__dataclass_fields__[key].default}) != one for key in
               ("place_every", "place_stops", "place_learn"))  # fmt: skip
