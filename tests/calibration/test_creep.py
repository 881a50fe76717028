"""Creep of a cable from a test: against the law in closed form, superposed, and sigmas that hold over 200 tests."""

from __future__ import annotations

import random
import tomllib
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.calibration.tensile.creep import MAX_SAMPLES, CreepResult, creep
from cablewright.calibration.tensile.recording import TensileTest, read_test
from cablewright.foundation.errors import InputError
from cablewright.models.climate_and_creep import by_temperature
from cablewright.models.creep import HOUR, histories, log_response, voigt_response
from cablewright.robot.cable import Creep

ROOT = Path(__file__).resolve().parents[2]
LENGTH, STIFFNESS, ALPHA = 2.0, 480e3, -12e-6
TAUS, COMPLIANCES = (60.0, 1200.0), np.array([0.4e-7, 0.5e-7, 1.6e-7])  # 1/N after an hour
HELD = ((0.0, 0.0), (10.0, 0.0), (15.0, 2000.0), (3615.0, 2000.0), (3620.0, 200.0), (4220.0, 200.0),
        (4225.0, 2000.0), (10800.0, 2000.0))  # fmt: skip
CYCLES = tuple((300.0 * k, 200.0 + (1800.0 if k % 2 else 0.0)) for k in range(25))


def superposed(times: np.ndarray, corners: tuple[tuple[float, float], ...], pieces: int = 400) -> np.ndarray:
    """Creep at *times* under loads that change linearly between *corners*, by small steps, each in closed form."""
    out = np.zeros_like(times)
    for (begin, low), (end, high) in pairwise(corners):
        if high == low:
            continue
        for k in range(pieces):
            after = np.maximum(times - (begin + (end - begin) * (k + 0.5) / pieces), 0.0)
            answer = COMPLIANCES[0] * voigt_response(after, TAUS[0]) + COMPLIANCES[1] * voigt_response(after, TAUS[1])
            out += (high - low) / pieces * (answer + COMPLIANCES[2] * log_response(after))
    return out


def sampled(corners: tuple[tuple[float, float], ...]) -> np.ndarray:
    """Every 10 s, and from each corner on at steps that grow from 0.5 s."""
    last, grown = corners[-1][0], np.concatenate([[0.0], np.geomspace(0.5, 60.0, 25)])
    fine = np.concatenate([begin + grown for begin, _ in corners])
    return np.unique(np.round(np.concatenate([np.arange(0.0, last, 10.0), fine[fine <= last], [last]]), 3))


def recorded(
    corners: tuple[tuple[float, float], ...], noise: float = 0.0, seed: int = 0, heat: float = 0.0
) -> TensileTest:
    """A test of the cable above, with *noise* of the elongation, m, and a temperature that swings by *heat*, K."""
    times = sampled(corners)
    force = np.interp(times, *np.array(corners).T)
    warm = 20.0 + heat * np.sin(times / 2000.0)
    strain = force / STIFFNESS + superposed(times, corners) + ALPHA * (warm - warm[0]) + 3e-5
    elongation = LENGTH * strain + noise * np.random.default_rng(seed).normal(size=len(times))
    return TensileTest(force, elongation, time=times, temperature=warm if heat else None)


def errors(found: CreepResult) -> np.ndarray:
    """The error of the result over its sigma: 1 / EA and the parts of the creep."""
    true = np.concatenate([[1.0 / STIFFNESS], COMPLIANCES])
    sigmas = np.sqrt(np.diagonal(found.covariance))[:4]
    return (np.concatenate([[found.elastic], found.compliances]) - true) / sigmas


@pytest.mark.parametrize("corners", [HELD, CYCLES], ids=["held", "cycles"])
def test_histories_are_small_steps_superposed(corners) -> None:
    times = sampled(corners)
    force = np.interp(times, *np.array(corners).T)
    found = histories(times, force - force[0], TAUS) @ COMPLIANCES
    wanted = superposed(times, corners) if corners is HELD else superposed(times, corners, 2000)
    assert np.abs(found - wanted).max() < 2e-3 * np.abs(wanted).max()


def test_it_is_linear_forgets_and_returns() -> None:
    """Twice the load, twice the creep; and what was unloaded for long has crept back but for the logarithm."""
    times = np.concatenate([[0.0], np.geomspace(0.1, 1e5, 400)])
    load = np.where(times > 0.0, 700.0, 0.0)
    one, two = (histories(times, size * load, TAUS) for size in (1.0, 2.0))
    np.testing.assert_allclose(two, 2.0 * one, rtol=1e-12)
    np.testing.assert_allclose(one[-1, :2], 700.0 * np.array([voigt_response(1e5, tau) for tau in TAUS]), rtol=1e-9)
    gone = np.where((times > 0.0) & (times < 1000.0), 700.0, 0.0)
    assert (histories(times, gone, TAUS)[-1] < 1e-2 * one[-1]).all()


@pytest.mark.parametrize("corners", [HELD, CYCLES], ids=["held", "cycles"])
def test_without_noise_the_result_is_exact(corners) -> None:
    found = creep(recorded(corners, heat=8.0), initial_length=LENGTH)
    assert found.stiffness == pytest.approx(STIFFNESS, rel=1e-4)
    assert found.after_hour == pytest.approx(COMPLIANCES.sum(), rel=3e-3)
    np.testing.assert_allclose(found.compliances, COMPLIANCES, rtol=0.1)
    assert found.expansion == pytest.approx(ALPHA, rel=1e-2)
    assert found.offset == pytest.approx(3e-5 + corners[0][1] / STIFFNESS, abs=1e-6)


@pytest.mark.parametrize(
    "corners", [pytest.param(HELD, id="held"), pytest.param(CYCLES, id="cycles", marks=pytest.mark.slow)]
)
def test_sigmas_hold_over_200_tests(corners) -> None:
    base = recorded(corners, heat=0.9)
    found = []
    for seed in range(200):
        noise = 4e-6 * np.random.default_rng(1000 + seed).normal(size=len(base.force))
        test = TensileTest(base.force, base.elongation + noise, time=base.time, temperature=base.temperature)
        found.append(errors(creep(test, initial_length=LENGTH)))
    inside = (np.abs(found) < 1.96).mean(axis=0)
    assert (inside >= 0.90).all()
    assert (inside <= 0.98).all()


WARMED = {
    "temperature": lambda t: 295.15 + 6.0 * np.sin(t / 2000.0),
    "humidity": lambda t: 0.5 + 0.2 * np.sin(t / 1300.0),
}
ENERGY, EXPONENT = 130e3, 2.0


def warmed(corners: tuple[tuple[float, float], ...], exponent: float = EXPONENT) -> TensileTest:
    """A test without noise in a climate that changes, of a cable whose law is that of its mean under load."""
    times = sampled(corners)[::3]
    force = np.interp(times, *np.array(corners).T)
    loads = force - force[0]
    climate = {name: swing(times) for name, swing in WARMED.items()}
    under = np.abs(loads) >= 0.5 * np.abs(loads).max()
    heat = climate["temperature"] - 273.15
    damp = climate["humidity"] - round(climate["humidity"][under].mean(), 2)
    pace = np.exp(ENERGY * by_temperature(heat, round(heat[under].mean(), 1)) + exponent * damp)
    strain = force / STIFFNESS + histories(times, loads, TAUS, pace) @ COMPLIANCES + ALPHA * (heat - heat[0])
    return TensileTest(force, LENGTH * strain, time=times, **climate)


@pytest.mark.parametrize(
    ("corners", "tests", "shares"),
    [
        pytest.param(HELD, 40, (0.87, 1.0), id="held"),
        pytest.param(HELD, 200, (0.9, 0.98), id="held, more", marks=pytest.mark.slow),
        pytest.param(CYCLES, 200, (0.9, 0.98), id="cycles", marks=pytest.mark.slow),
    ],
)
def test_the_pace_in_a_climate_is_reported_with_sigmas_that_hold(
    corners, tests: int, shares: tuple[float, float]
) -> None:
    """Errors over their sigmas: the share below 1.96, and the mean of their squares."""
    base, off = warmed(corners), []
    for seed in range(tests):
        noise = 4e-6 * np.random.default_rng(4000 + seed).normal(size=len(base.force))
        test = TensileTest(base.force, base.elongation + noise, time=base.time, temperature=base.temperature,
                           humidity=base.humidity)  # fmt: skip
        found = creep(test, initial_length=LENGTH)
        assert found.activation_energy is not None
        assert found.humidity_exponent is not None
        off.append(
            [
                *errors(found),
                (found.activation_energy - ENERGY) / found.activation_energy_sigma,
                (found.humidity_exponent - EXPONENT) / found.humidity_exponent_sigma,
            ]
        )
    inside = (np.abs(off) < 1.96).mean(axis=0)
    assert (inside >= shares[0]).all()
    assert (inside <= shares[1]).all()
    np.testing.assert_allclose(np.square(off).mean(axis=0), 1.0, atol=3.5 * np.sqrt(2.0 / tests))


def test_climate_parameters_of_a_creep_test_fit_into_a_robot_file(tmp_path: Path) -> None:
    test = warmed(HELD)
    rows = zip(*(np.array(each).tolist() for each in (test.time, test.force, test.elongation, test.temperature)),
               (100.0 * test.humidity).tolist(), strict=True)  # fmt: skip
    text = "\n".join(",".join(f"{each:.10g}" for each in row) for row in rows)
    (tmp_path / "test.csv").write_text(f"time (s),force (N),elongation (m),temperature,humidity (%)\n{text}\n")
    found = creep(tmp_path / "test.csv", initial_length=LENGTH)
    assert found.activation_energy == pytest.approx(ENERGY, rel=1e-3)
    assert found.humidity_exponent == pytest.approx(EXPONENT, rel=1e-3)
    assert found.expansion == pytest.approx(ALPHA, rel=1e-3)
    law = Creep.model_validate(tomllib.loads(found.robot_file_text)["cable"]["creep"])
    assert law.activation_energy == pytest.approx(ENERGY, rel=1e-3)
    assert (law.reference_temperature, law.reference_humidity) == (found.temperature, found.humidity)
    assert found.temperature == pytest.approx(22.0, abs=6.0)


def test_a_constant_climate_or_a_cable_without_creep_determines_no_pace() -> None:
    test = warmed(HELD)
    calm = {"temperature": 295.0 + 0.5 * np.sin(test.time / 2000.0), "humidity": np.full(len(test.force), 0.5)}
    mild = TensileTest(test.force, test.elongation, time=test.time, **calm)
    found = creep(mild, initial_length=LENGTH)
    assert (found.activation_energy, found.humidity_exponent) == (None, None)
    noise = 4e-6 * np.random.default_rng(1).normal(size=len(test.force))
    elastic = TensileTest(test.force, LENGTH * test.force / STIFFNESS + noise, time=test.time,
                          temperature=test.temperature)  # fmt: skip
    found = creep(elastic, initial_length=LENGTH)
    assert found.activation_energy is None
    assert "the climate changes, but the test does not determine the activation energy to 30000" in found.notes
    assert "activation_energy" not in found.robot_file_text


def test_of_two_that_change_together_the_one_that_is_reported_stays() -> None:
    """A humidity that mirrors the temperature leaves the energy alone; and one of an exponent of 0 does not harm it."""
    test, noise = warmed(HELD, 0.0), 4e-6 * np.random.default_rng(2).normal(size=len(warmed(HELD).force))
    mirrored = 0.5 - 0.02 * (test.temperature - 295.15)
    found = creep(TensileTest(test.force, test.elongation + noise, time=test.time, temperature=test.temperature,
                              humidity=mirrored), initial_length=LENGTH)  # fmt: skip
    assert found.humidity_exponent is None
    assert found.activation_energy == pytest.approx(ENERGY, rel=0.05)
    assert np.abs(errors(found)).max() < 3.5
    assert any("does not determine the humidity exponent" in note for note in found.notes)
    free = TensileTest(test.force, test.elongation + noise, time=test.time, temperature=test.temperature,
                       humidity=test.humidity)  # fmt: skip
    both = creep(free, initial_length=LENGTH)
    assert both.humidity_exponent == pytest.approx(0.0, abs=4.0 * (both.humidity_exponent_sigma or 0.0))


@pytest.mark.parametrize("exponent", [-9.0, 0.0, 8.0])
def test_a_large_exponent_is_found_from_afar(exponent: float) -> None:
    found = creep(warmed(HELD, exponent), initial_length=LENGTH)
    assert found.humidity_exponent == pytest.approx(exponent, abs=1e-2)
    assert found.activation_energy == pytest.approx(ENERGY, rel=1e-2)


def test_a_cable_that_creeps_the_same_in_every_climate_is_reported_as_such() -> None:
    base = recorded(HELD, heat=8.0)
    noise = 4e-6 * np.random.default_rng(5).normal(size=len(base.force))
    found = creep(TensileTest(base.force, base.elongation + noise, time=base.time, temperature=base.temperature),
                  initial_length=LENGTH)  # fmt: skip
    assert found.activation_energy is not None
    assert found.activation_energy_sigma is not None
    assert abs(found.activation_energy) < 3.0 * found.activation_energy_sigma < 10e3


def test_an_elastic_cable_without_noise_is_one_in_any_climate() -> None:
    test = warmed(HELD)
    found = creep(TensileTest(test.force, LENGTH * test.force / STIFFNESS, time=test.time,
                              temperature=test.temperature), initial_length=LENGTH)  # fmt: skip
    assert found.stiffness == pytest.approx(STIFFNESS, rel=1e-9)
    assert found.activation_energy is None


def test_what_is_wrong_with_temperatures_is_said() -> None:
    test = warmed(HELD, 0.0)
    spoiled = test.temperature.copy()
    spoiled[3] = 0.0
    neither = creep(
        TensileTest(test.force, test.elongation, time=test.time, temperature=spoiled), initial_length=LENGTH
    )
    assert neither.activation_energy is None
    assert any("neither in K nor in degrees Celsius" in note for note in neither.notes)
    mirrored = TensileTest(test.force, test.elongation, time=test.time,
                           temperature=2.0 * 295.15 - test.temperature)  # fmt: skip
    found = creep(mirrored, initial_length=LENGTH)
    assert any("the activation energy is below 0" in note for note in found.notes)
    assert "activation_energy = 0" in found.robot_file_text


@pytest.mark.parametrize("value", [1.2, -0.1])
def test_a_humidity_is_a_share(value: float) -> None:
    humidity = np.full(30, 0.5)
    humidity[7] = value
    with pytest.raises(InputError, match=rf"the test, sample 8: humidity = {value}: must be"):
        TensileTest(np.arange(30.0), np.arange(30.0), time=np.arange(30.0), humidity=humidity)


def test_residuals_that_wander_widen_the_sigmas() -> None:
    """With noise that is constant over 50 samples sigmas of white noise would be far too small."""
    base, within = recorded(HELD), []
    for seed in range(60):
        walk = np.random.default_rng(seed).normal(size=len(base.force) // 50 + 2)
        noise = 4e-6 * np.interp(np.arange(len(base.force)) / 50.0, np.arange(len(walk)), walk)
        found = creep(TensileTest(base.force, base.elongation + noise, time=base.time), initial_length=LENGTH)
        assert any("residuals wander" in note for note in found.notes)
        within.append(np.abs(errors(found)) < 1.96)
    assert np.mean(within) > 0.85


def test_a_cable_that_creeps_otherwise_is_noted() -> None:
    base = recorded(HELD, noise=1e-6)
    settled = 2e-4 * (1.0 - np.exp(-base.force / 700.0)) * (np.maximum.accumulate(base.force) > 0.0)
    found = creep(TensileTest(base.force, base.elongation + settled, time=base.time), initial_length=LENGTH)
    assert any("residuals wander" in note for note in found.notes)


def test_logarithmic_creep_alone() -> None:
    found = creep(recorded(HELD, noise=2e-6), initial_length=LENGTH, retardations=())
    assert len(found.compliances) == 1
    assert any("residuals wander" in note for note in found.notes)
    assert [row["part"] for row in found.law] == ["logarithmic"]


def test_the_table_ends_with_the_test() -> None:
    found = creep(recorded(HELD, noise=2e-6), initial_length=LENGTH)
    times = [row["time"] for row in found.table]
    assert times[:-1] == [60.0, 600.0, HOUR]
    assert times[-1] == found.loaded == pytest.approx(10183.0, abs=5.0)  # all but the ten minutes of rest
    size, sigma = found.compliance_at(found.loaded)
    assert found.uncertainty_text.endswith(f"range = [0.0, {size + 2 * sigma:.2g}]")


def cut(test: TensileTest, end: float, every: int = 1) -> TensileTest:
    assert test.time is not None
    kept = np.flatnonzero(test.time <= end)[::every]
    return TensileTest(test.force[kept], test.elongation[kept], time=test.time[kept])


def test_rest_is_no_time_under_load() -> None:
    """100 s of load and three hours of rest do not determine an element of 20 min under load."""
    times = np.arange(0.0, 10900.0, 10.0)
    force = np.where((times > 0.0) & (times <= 100.0), 1000.0, 0.0)
    with pytest.raises(InputError, match=r"the element of 20 min needs a load for 20 min, the test has 100 s"):
        creep(TensileTest(force, force * 1e-6, time=times), initial_length=LENGTH)


@pytest.mark.parametrize("unit", ["C", "degC", "F"])
def test_a_unit_that_is_not_known_is_said(unit: str, tmp_path: Path) -> None:
    rows = [f"{k},{k},{1e-3 * k},20" for k in range(30)]
    (tmp_path / "test.csv").write_text("\n".join([f"time,force,elongation,temperature ({unit})", *rows]))
    with pytest.raises(InputError, match=r"unknown unit '.*'; a unit may follow, as in 'temperature \(K\)', one of K"):
        read_test(tmp_path / "test.csv", timed=True)


@pytest.mark.parametrize(
    ("test", "options", "message"),
    [
        (cut(recorded(HELD), 610.0), {}, "the element of 20 min needs a load for 20 min, the test has 9.96 min"),
        (cut(recorded(HELD), 60.0), {"retardations": ()}, "logarithmic creep needs two decades of time, from 1 s to"),
        (cut(recorded(HELD), 1e4, 40), {}, "the element of 60 s has 2 samples within 60 s of the load: 3 determine it"),
        (TensileTest(np.arange(30.0), np.arange(30.0)), {}, "no column 'time', which creep needs"),
        (TensileTest(np.ones(30), np.arange(30.0), time=np.arange(30.0)), {}, "the force never changes"),
        (recorded(HELD), {"retardations": (60.0, 30.0)}, "retardations = 60, 30 s: expected up to 4 that rise"),
        (recorded(HELD), {"initial_length": 0.0}, "initial length = 0 m: must be over 0"),
        (TensileTest(np.r_[0.0, np.ones(999)], -np.r_[0.0, np.ones(999)], time=np.arange(1000.0)),
         {"retardations": (60.0,)}, "the elongation does not rise with the force"),
        (TensileTest(np.r_[0.0, np.ones(MAX_SAMPLES)], np.zeros(MAX_SAMPLES + 1), time=np.arange(MAX_SAMPLES + 1.0)),
         {}, "100001 samples; at most 100000 are taken"),
    ],
)  # fmt: skip
def test_a_test_that_shows_no_creep_is_one_line(test: TensileTest, options: dict, message: str) -> None:
    with pytest.raises(InputError) as caught:
        creep(test, **{"initial_length": LENGTH, **options})
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_times_must_rise(tmp_path: Path) -> None:
    rows = [f"{k if k != 12 else 3},{k},{1e-3 * k}" for k in range(30)]
    (tmp_path / "test.csv").write_text("\n".join(["time (s),force (N),elongation (mm)", *rows]))
    with pytest.raises(InputError, match="line 14: time = 3 s follows 11 s: times must rise"):
        read_test(tmp_path / "test.csv", timed=True)
    assert read_test(tmp_path / "test.csv").time is None
    with pytest.raises(InputError, match="30 forces, but 29 numbers of temperature"):
        TensileTest(np.arange(30.0), np.arange(30.0), temperature=np.zeros(29))


EXAMPLE_ENERGY = 145e3  # J/mol


def example() -> str:
    """The rows of `examples/creep.csv`."""
    times, draws = sampled(HELD), random.Random(2022)
    force = np.interp(times, *np.array(HELD).T)
    warm = 21.0 + 3.0 * np.sin(times / 3000.0)
    pace = np.exp(EXAMPLE_ENERGY * by_temperature(warm, 22.5))
    strain = force / STIFFNESS + histories(times, force, TAUS, pace) @ COMPLIANCES + ALPHA * (warm - warm[0])
    rows = ["# synthetic: no machine has measured it; tests/calibration/test_creep.py has the rule",
            "time (s),force (kN),elongation (mm),temperature (K)"]  # fmt: skip
    for t, f, e, w in zip(times, force, strain, warm, strict=True):
        seen = f / 1e3 + draws.gauss(0.0, 0.001), 1e3 * LENGTH * e + draws.gauss(0.0, 0.002)
        rows.append(f"{t:g},{seen[0]:.4f},{seen[1]:.4f},{w + 273.15:.2f}")
    return "\n".join(rows) + "\n"


def test_the_example_is_this_cable() -> None:
    file = ROOT / "examples" / "creep.csv"
    assert file.read_text(encoding="utf-8") == example()
    found = cw.creep(file, initial_length=LENGTH)
    assert np.abs(errors(found)).max() < 3.5
    assert found.expansion == pytest.approx(ALPHA, rel=0.1)
    assert found.temperature == 22.5
    assert found.activation_energy is not None
    assert found.activation_energy_sigma is not None
    assert abs(found.activation_energy - EXAMPLE_ENERGY) < 3.0 * found.activation_energy_sigma
