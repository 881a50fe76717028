"""Cable on a drum: lengths are integrals of radii, layers are where they should be, walks have their law."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from cablewright.foundation.errors import InputError
from cablewright.models.coil import Coil, wind

CORE, WIDTH, DIAMETER, PITCH = 0.05, 0.075, 0.003, 0.0026


def coil(seed: int | None = None, capacity: float = 60.0) -> Coil:
    random = None if seed is None else np.random.default_rng(seed)
    walks = {"radius_walk": 1e-3, "sideways_walk": 3e-3, "memory": 10.0}
    return wind(capacity, CORE, WIDTH, DIAMETER, PITCH, random=random, **walks)


@pytest.mark.parametrize("seed", [None, 1])
def test_a_length_is_the_integral_of_the_radius(seed: int | None) -> None:
    made = coil(seed)
    for angle in (0.5, 40.3, 170.0, 700.1):
        ends = [*np.arange(0.0, angle, 2 * np.pi), angle]
        integral = sum(quad(made.radius, begin, end)[0] for begin, end in pairwise(ends))
        assert made.length(angle) == pytest.approx(integral, rel=1e-9)
        assert made.angle(made.length(angle)) == pytest.approx(angle, rel=1e-12)


def test_layers_lie_on_each_other_and_go_to_and_fro() -> None:
    made = coil()
    per_layer = 25
    assert made.radii[0] == CORE
    assert made.radii[per_layer - 1] == CORE
    assert made.radii[per_layer] == CORE + PITCH
    assert made.radii[2 * per_layer] == CORE + 2 * PITCH
    assert (np.abs(made.sideways) <= WIDTH / 2).all()
    assert (np.diff(made.sideways[:per_layer]) > 0).all()
    assert (np.diff(made.sideways[per_layer : 2 * per_layer]) < 0).all()
    assert made.wound[-1] >= 60.0


def test_the_walk_has_its_deviation_and_its_memory() -> None:
    off = np.concatenate([coil(seed, 250.0).radii - coil(None, 250.0).radii for seed in range(40)])
    assert off.std() == pytest.approx(1e-3, rel=0.1)
    pairs = np.array([(walk[:-10], walk[10:]) for walk in np.split(off, 40)])
    alike = np.mean(pairs[:, 0] * pairs[:, 1]) / np.mean(pairs**2)
    assert alike == pytest.approx(np.exp(-1.0), abs=0.1)


def test_what_no_drum_is_is_rejected() -> None:
    with pytest.raises(InputError, match="too narrow for one turn"):
        wind(10.0, CORE, 0.002, DIAMETER, PITCH)
    with pytest.raises(InputError, match="radius_walk"):
        wind(10.0, CORE, WIDTH, DIAMETER, PITCH, radius_walk=0.02)
    with pytest.raises(InputError, match="more than 200000 turns"):
        wind(1e4, 1e-6, WIDTH, DIAMETER, PITCH)
    made = coil()
    for asked in (-0.1, made.wound[-1] + 1.0):
        with pytest.raises(InputError, match="it holds"):
            made.angle(asked)
    with pytest.raises(InputError, match="it holds"):
        made.length(-1.0)
