"""Natural frequencies of a line beside a chain of masses: tension, density, and where sag shows the modulus."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

import cablewright as cw
from cablewright.foundation.errors import InputError
from cablewright.models.line_vibration import (
    observable_below,
    parameter_of,
    sag_parameter,
    sag_stiffening,
    string_frequency,
)
from cablewright.models.statics import Model
from cablewright.solvers.taut import taut_at

ROBOT, LINE, POSE = cw.load("merlet2023"), "north-west", (0.0, 0.0, 1.0)


def chain(tension: float, span: float, density: float, stiffness: float, gravity: float) -> tuple[float, float]:
    """First frequency across the plane of the sag, and first symmetric one in it, Hz, of 400 masses on a level span."""
    n = 400
    x = np.linspace(0.0, span, n + 1)
    y = -density * gravity * x * (span - x) / (2.0 * tension)
    steps = np.diff(np.column_stack([x, y]), axis=0)
    sizes = np.linalg.norm(steps, axis=1)
    u = steps / sizes[:, None]
    pulls = tension / u[:, 0]
    across, in_plane = np.zeros((n + 1, n + 1)), np.zeros((2 * n + 2, 2 * n + 2))
    for i in range(n):
        own = np.array([[1.0, -1.0], [-1.0, 1.0]])
        across[i : i + 2, i : i + 2] += pulls[i] / sizes[i] * own
        stiff = stiffness / sizes[i] * np.outer(u[i], u[i]) + pulls[i] / sizes[i] * (np.eye(2) - np.outer(u[i], u[i]))
        in_plane[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += np.kron(own, stiff)
    mass = density * span / n
    first = math.sqrt(float(eigh(across[1:-1, 1:-1] / mass, eigvals_only=True, subset_by_index=[0, 0])[0])) / math.tau
    squares, ways = eigh(in_plane[2:-2, 2:-2] / mass, subset_by_index=[0, 3])
    symmetric = next(k for k in range(4) if abs(ways[1::2, k].sum()) > 1.0)
    return first, math.sqrt(float(squares[symmetric])) / math.tau


@pytest.mark.parametrize("tension", [60.0, 150.0, 600.0])
def test_frequencies_are_those_of_a_chain_of_masses(tension: float) -> None:
    span, density, stiffness = 8.0, 0.05, 2e5
    across, in_plane = chain(tension, span, density, stiffness, 9.81)
    assert string_frequency(tension, span, density) == pytest.approx(across, rel=2e-3)
    ratio, slope = sag_stiffening(sag_parameter(density * 9.81, span, tension, stiffness))
    assert ratio == pytest.approx(in_plane / across, rel=5e-3)
    more, _ = sag_stiffening(1.001 * sag_parameter(density * 9.81, span, tension, stiffness))
    assert math.log(more / ratio) / math.log(1.001) == pytest.approx(slope, rel=2e-3)


def test_a_frequency_gives_the_tension_or_the_density() -> None:
    expected = cw.line_vibration(ROBOT, POSE, LINE, 10.0)
    held = cw.inverse(ROBOT, POSE)
    at = [line.name for line in ROBOT.lines].index(LINE)
    assert expected.expected_tension == pytest.approx(held.tensions[at])
    assert expected.span == pytest.approx(taut_at(Model(ROBOT), np.array(POSE)).free[at])
    found = cw.line_vibration(ROBOT, POSE, LINE, expected.expected_frequency, sigma=0.01)
    density = ROBOT.lines[at].cable.linear_density
    assert (found.tension, found.density) == pytest.approx((found.expected_tension, density))
    assert found.tension_sigma / found.tension == pytest.approx(2.0 * 0.01 / found.frequency)
    by_cell = cw.line_vibration(ROBOT, POSE, LINE, found.frequency, tension=1.1 * found.tension)
    assert by_cell.density == pytest.approx(1.1 * density)
    assert by_cell.tension == pytest.approx(found.tension)


def test_sag_shows_the_modulus_at_low_tensions_alone() -> None:
    expected = cw.line_vibration(ROBOT, POSE, LINE, 10.0, sigma=0.02)
    taut = cw.line_vibration(ROBOT, POSE, LINE, 13.6, sigma=0.02, in_plane=13.7)
    assert (taut.modulus, taut.modulus_factor) == ("not observable", None)
    low = 0.5 * expected.modulus_below
    frequency = string_frequency(low, expected.span, ROBOT.lines[0].cable.linear_density or 0.0)
    slack = cw.line_vibration(ROBOT, POSE, LINE, frequency, sigma=0.002 * frequency)
    true = frequency * sag_stiffening(0.8 * slack.sag_parameter)[0]
    found = cw.line_vibration(ROBOT, POSE, LINE, frequency, sigma=0.002 * frequency, in_plane=true)
    assert found.modulus == "observable"
    assert found.modulus_factor == pytest.approx(0.8, rel=1e-6)
    assert found.modulus_sigma is not None
    assert 0.0 < found.modulus_sigma < 0.2
    assert observable_below(0.0, 1.0, 1e5, 1e-3) == 0.0
    assert observable_below(1.0, 5.0, 1e5, 0.5) == 0.0


def test_a_record_of_a_struck_line_has_its_frequency(tmp_path: Path) -> None:
    rng, times = np.random.default_rng(1), np.arange(0.0, 8.0, 0.005)
    wanted = cw.line_vibration(ROBOT, POSE, LINE, 10.0).expected_frequency * 0.97
    wave = np.exp(-0.3 * times) * np.sin(math.tau * wanted * times) + 0.3 * np.sin(math.tau * 1.1 * times)
    file = tmp_path / "struck.csv"
    rows = np.column_stack([times, 2.0 * wave + 0.05 * rng.normal(size=len(times))])
    file.write_text("t (s),ax\n" + "\n".join(f"{t:.4f},{a:.6f}" for t, a in rows) + "\n")
    found = cw.line_vibration(ROBOT, POSE, LINE, file)
    assert found.frequency == pytest.approx(wanted, abs=5.0 * found.frequency_sigma)
    assert found.frequency_sigma < 0.01
    file.write_text("t,ax\n" + "\n".join(f"{t:.4f},{math.exp(-0.3 * t) * math.sin(3.0 * t):.6f}" for t in times) + "\n")
    with pytest.raises(InputError, match="a line's first mode is expected at"):
        cw.line_vibration(ROBOT, POSE, LINE, file)
    file.write_text("a,b\n1,2\n")
    with pytest.raises(InputError, match="expected a column t"):
        cw.line_vibration(ROBOT, POSE, LINE, file)


def test_what_cannot_vibrate_is_rejected() -> None:
    with pytest.raises(InputError, match="unknown line 'north'"):
        cw.line_vibration(ROBOT, POSE, "north", 10.0)
    with pytest.raises(InputError, match="frequency = 0: must be over 0 Hz"):
        cw.line_vibration(ROBOT, POSE, LINE, 0.0)
    with pytest.raises(InputError, match="sigma = -1: must be over 0"):
        cw.line_vibration(ROBOT, POSE, LINE, 10.0, sigma=-1.0)
    light = ROBOT.lines[0].cable.model_copy(update={"linear_density": 0.0})
    lines = tuple(line.model_copy(update={"cable": light}) for line in ROBOT.lines)
    with pytest.raises(InputError, match="has no linear_density, which a vibration needs"):
        cw.line_vibration(ROBOT.model_copy(update={"lines": lines}), POSE, LINE, 10.0)


@pytest.mark.parametrize("parameter", [1e-4, 0.3, 5.0, 39.0])
def test_the_ratio_of_frequencies_gives_the_parameter_of_sag(parameter: float) -> None:
    assert parameter_of(sag_stiffening(parameter)[0]) == pytest.approx(parameter, rel=1e-9)


@pytest.mark.parametrize("ratio", [0.9, 1.0, 2.001])
def test_a_ratio_of_another_mode_gives_none(ratio: float) -> None:
    assert parameter_of(ratio) is None


@pytest.mark.parametrize(("share", "known"), [(0.02, False), (0.5, False), (1.0, True), (12.0, True)])
def test_whether_the_modulus_is_observable_depends_on_the_one_found(share: float, known: bool) -> None:
    """The tension is one at which the file's EA is just observable; the line has a *share* of it."""
    first = cw.line_vibration(ROBOT, POSE, LINE, 10.0, sigma=0.02)
    frequency = string_frequency(0.9 * first.modulus_below, first.span, ROBOT.lines[0].cable.linear_density or 0.0)
    slack = cw.line_vibration(ROBOT, POSE, LINE, frequency, sigma=0.002 * frequency)
    second = frequency * sag_stiffening(share * slack.sag_parameter)[0]
    found = cw.line_vibration(ROBOT, POSE, LINE, frequency, sigma=0.002 * frequency, in_plane=second)
    assert (found.modulus == "observable") is known
    assert found.modulus_factor == (pytest.approx(share, rel=1e-6) if known else None)
