"""Creep that goes faster in heat and damp: against reduced time in closed form, in the plant and in the estimators."""

from __future__ import annotations

import math
from functools import cache

import mpmath
import numpy as np
import pytest

from cablewright.estimation.climate import FeltAir
from cablewright.foundation.signals import Climate, Command, Scan, SensorFrame
from cablewright.live.estimators import estimator
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.machine.simulated.true_state import air_at
from cablewright.models.climate_and_creep import GAS, Air, CreepPace, by_temperature
from cablewright.models.creep import CreepMemory, histories, log_response, memory_of, voigt_response
from cablewright.robot import Robot, load
from cablewright.robot.cable import Creep
from cases import some

ENERGY, EXPONENT = 145e3, 1.5
LAW = Creep(
    retardations=(60.0, 1200.0), compliances=(2e-7, 3e-7), logarithmic=5e-7, activation_energy=ENERGY,
    reference_temperature=22.0, humidity_exponent=EXPONENT, reference_humidity=0.4,
)  # fmt: skip
REFERENCE, WARM = Air(22.0, 0.4), Air(30.0, 0.6)


def memory(law: Creep = LAW) -> CreepMemory:
    found = memory_of([law, None])
    assert found is not None
    return found


def response(counted: float) -> float:
    """Strain per load of the law, *counted* s after a load began."""
    at = np.array([counted])
    voigt = sum(c * float(voigt_response(at, tau)[0]) for c, tau in zip(LAW.compliances, LAW.retardations, strict=True))
    return voigt + LAW.logarithmic * float(log_response(at)[0])


def test_the_pace_is_arrhenius_law_and_exponential() -> None:
    with mpmath.workdps(30):
        gas, zero = mpmath.mpf("8.31446261815324"), mpmath.mpf("273.15")
        heat = ENERGY / gas * (1 / (22 + zero) - 1 / (30 + zero))
        exact = float(mpmath.exp(heat + mpmath.mpf(EXPONENT) * mpmath.mpf("0.2")))
    pace = CreepPace([LAW, None])
    assert pace.at(WARM) == pytest.approx([exact, 1.0], rel=1e-5)
    assert pace.at(REFERENCE) == pytest.approx([1.0, 1.0])
    assert math.exp(ENERGY * by_temperature(26.0, 22.0)) == pytest.approx(2.2, abs=0.05)  # twice as fast for 4 K
    assert by_temperature(30.0, 22.0) == pytest.approx(-by_temperature(22.0, 30.0))
    assert pytest.approx(8.314462618, rel=1e-6) == GAS


def test_in_an_air_that_stays_time_is_stretched() -> None:
    loads, pace = np.array([300.0, 300.0]), float(CreepPace([LAW]).at(WARM)[0])
    for passed in (1.0, 60.0, 3600.0):
        warm = memory()
        warm.feel(WARM)
        warm.advance(loads, loads, passed)
        assert warm.strain[0] == pytest.approx(300.0 * response(pace * passed), rel=1e-3)
        assert warm.strain[1] == 0.0
        assert warm.gain(loads, 10.0)[0] == pytest.approx(
            300.0 * (response(pace * (passed + 10.0)) - response(pace * passed)), rel=0.02
        )


def test_of_a_climate_that_changes_only_the_time_counted_matters() -> None:
    """Cold, warm and cold again creep as far as one air for all of the counted time."""
    load, paces = np.array([300.0, 0.0]), {air: float(CreepPace([LAW]).at(air)[0]) for air in (REFERENCE, WARM)}
    changing = memory()
    for air, passed in ((REFERENCE, 600.0), (WARM, 1000.0), (REFERENCE, 300.0)):
        changing.feel(air)
        changing.advance(load, load, passed)
    counted = 900.0 + 1000.0 * paces[WARM]
    assert changing.strain[0] == pytest.approx(300.0 * response(counted), rel=1e-3)
    times = np.array([0.0, 600.0, 600.0 + 1e-6, 1600.0, 1600.0 + 1e-6, 1900.0])
    of_test = histories(times, np.full(6, 300.0), LAW.retardations, np.repeat([1.0, paces[WARM], 1.0], 2))
    assert of_test[-1] @ [*LAW.compliances, LAW.logarithmic] == pytest.approx(changing.strain[0], rel=1e-3)


def test_without_a_climate_it_is_as_before_to_the_bit() -> None:
    plain = LAW.model_copy(update={"activation_energy": 0.0, "humidity_exponent": 0.0})
    random, one, two = np.random.default_rng(3), memory(plain), memory()
    for _ in range(30):
        before, after = random.uniform(0.0, 400.0, (2, 2))
        one.feel(WARM)
        for each in (one, two):
            each.advance(before, after, 7.0)
    assert (one.stretched == two.stretched).all()


def test_air_is_a_median_that_no_spike_moves() -> None:
    felt = FeltAir()
    for k, temperature in enumerate((85.0, math.nan, 20.0)):  # a spike at first is none of the median either
        assert felt.read(Climate(float(k), temperature, 0.5)).temperature is None
    for k, temperature in enumerate((20.2, 999.9, -273.15, 20.1)):
        found = felt.read(Climate(3.0 + k, temperature, 0.5 + 0.01 * k))
    assert found == Air(20.15, 0.51)
    for k in range(5):
        found = felt.read(Climate(10.0 + k, 25.0, math.nan))
    assert found == Air(25.0, 0.51)


def test_who_has_no_hygrometer_has_a_thermometer() -> None:
    pace = CreepPace([LAW, None])
    assert pace.at(Air(30.0, None)) == pytest.approx(pace.at(Air(30.0, LAW.reference_humidity)))
    assert pace.at(Air(None, 0.6)) == pytest.approx(pace.at(Air(LAW.reference_temperature, 0.6)))
    assert pace.at(Air(None, None)) == pytest.approx([1.0, 1.0])


ROBOT, PLACE = load("merlet2023"), np.array([0.3, -0.4, 1.2])


def robot_of(law: Creep) -> Robot:
    """A robot of cables that creep by a *law*, and do not expand, which no estimator counts."""
    cable = {"creep": law, "thermal_expansion": None}
    lines = (line.model_copy(update={"cable": line.cable.model_copy(update=cable)}) for line in ROBOT.lines)
    return ROBOT.model_copy(update={"lines": tuple(lines)})


HEAVY = LAW.model_copy(
    update={"compliances": (1e-6, 1e-6), "logarithmic": 3e-6, "humidity_exponent": 0.0, "reference_temperature": 22.0}
)


def room(temperature: float, warming: float = 0.0) -> TwinSettings:
    """The library's machine, its quasi-static plant by half seconds; in a room that warms by *rise* in 900 s."""
    twin = load_twin("merlet2023").with_simulation(quasi_static_period=0.5)
    swing = warming / math.sin(2.0 * math.pi * 900.0 / 86400.0)
    climate = twin.simulation.climate.model_copy(update={"temperature": temperature, "swing": swing})
    return twin.with_simulation(climate=climate)


def sunk(temperature: float) -> float:
    """How far the platform of cables with `HEAVY` creep sinks in 300 s in a room, m."""
    machine = SimulatedMachine(robot_of(HEAVY), room(temperature), PLACE, seed=5, plant="quasi-static")
    begin = machine.truth.position[2]
    while machine.time < 300.0:
        machine.step(Command(machine.time, np.zeros(4)))
    return float(begin - machine.truth.position[2])


def test_a_platform_sinks_faster_in_a_warm_room() -> None:
    mild, hot = sunk(22.0), sunk(34.0)
    law = HEAVY.model_copy(update={"activation_energy": 0.0})
    one, several = memory(law), memory(law)
    load, pace = np.ones(2), float(CreepPace([HEAVY]).at(Air(34.0, 0.5))[0])
    one.advance(load, load, 300.0)
    several.advance(load, load, 300.0 * pace)
    assert mild > 5e-3
    assert hot / mild == pytest.approx(several.strain[0] / one.strain[0], rel=0.05)


@cache
def seen(name: str, warming: float, until: float = 450.0) -> tuple[float, float, float]:
    """How far a platform sinks while its room warms, and by an estimator with a thermometer, and without one.

    Until that time, s, in which there are lidars up to 120 s.
    """
    twin, robot = room(22.0, warming), robot_of(HEAVY)
    machine = SimulatedMachine(robot, twin, PLACE, seed=5, plant="quasi-static")
    both = [estimator(name, robot, twin.owner, PLACE) for _ in range(2)]
    heights, begin = np.zeros(3), np.zeros(3)
    while machine.time < until:
        frame = machine.step(Command(machine.time, np.zeros(4)))
        told = tuple(each for each in frame.readings if machine.time <= 120.0 or not isinstance(each, Scan))
        cold = tuple(each for each in told if not isinstance(each, Climate))
        found = [one.step(SensorFrame(frame.time, each)) for one, each in zip(both, (told, cold), strict=True)]
        heights = np.array([machine.truth.position[2], *(each.position[2] for each in found)])
        if machine.time <= 120.0:
            begin = heights
    true, known, unknown = (begin - heights).tolist()
    return true, known, unknown


@pytest.mark.parametrize("name", some(["encoders", "paper"]))
def test_who_has_a_thermometer_knows_it_and_who_has_none_does_not(name: str) -> None:
    true, known, unknown = seen(name, 15.0)
    assert known == pytest.approx(true, rel=0.05)
    assert unknown < 0.9 * true


def test_the_filter_sees_by_line_angles_what_warms() -> None:
    true, known, unknown = seen("filter", 15.0, until=900.0)
    assert known == pytest.approx(true, rel=0.1)
    assert unknown == pytest.approx(true, rel=0.1)


def test_at_the_temperature_of_the_law_a_thermometer_changes_nothing() -> None:
    true, known, unknown = seen("encoders", 0.0)
    assert known == pytest.approx(true, rel=0.05)
    assert known == pytest.approx(unknown, rel=0.02)


def test_the_plant_is_resumed_exactly() -> None:
    twin, robot = room(34.0), robot_of(HEAVY)
    whole = SimulatedMachine(robot, twin, PLACE, seed=5, plant="quasi-static")
    for _ in range(40):
        whole.step(Command(whole.time, np.zeros(4)))
    snapshot = whole.snapshot()
    for _ in range(40):
        whole.step(Command(whole.time, np.zeros(4)))
    part = SimulatedMachine.resumed(robot, twin, snapshot, seed=5, plant="quasi-static")
    for _ in range(40):
        part.step(Command(part.time, np.zeros(4)))
    assert (part.truth.position == whole.truth.position).all()


def test_air_of_the_plant_swings_over_a_day() -> None:
    climate = load_twin("merlet2023").simulation.climate
    assert air_at(climate, 0.0) == (climate.temperature, climate.humidity)
    assert air_at(climate, 21600.0)[0] == pytest.approx(climate.temperature + climate.swing)


@pytest.mark.parametrize(
    ("key", "value"),
    [("activation_energy", -1.0), ("activation_energy", 2e6), ("reference_temperature", -300.0),
     ("reference_humidity", 50.0), ("humidity_exponent", math.nan), ("humidity_exponent", 21.0)],
)  # fmt: skip
def test_what_no_cable_has_is_rejected(key: str, value: float) -> None:
    with pytest.raises(ValueError, match=key):
        Creep(**{"logarithmic": 1e-7, key: value})
