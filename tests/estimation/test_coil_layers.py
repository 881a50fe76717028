"""Where the layers of a coil end: expected radii beside coils that are wound at random."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from cablewright.estimation.kalman.coil_layers import CoilLayers
from cablewright.models.coil import Coil, wind

CORE, WIDTH, DIAMETER, PITCH, HELD = 0.05, 0.075, 3e-3, 2.6e-3, 25.0
WALK, TURNS = 1e-3, 10.0
REGULAR = wind(250.0, CORE, WIDTH, DIAMETER, PITCH)
LAYERS = CoilLayers([REGULAR], HELD, PITCH, WALK, TURNS)


def irregular(seed: int) -> Coil:
    random = np.random.default_rng(seed)
    return wind(60.0, CORE, WIDTH, DIAMETER, PITCH, random=random, radius_walk=WALK, memory=TURNS)


def test_far_from_the_ends_of_layers_a_radius_is_that_of_its_layer() -> None:
    for out, layer in ((6.0, 2), (12.0, 1), (24.0, 0)):
        assert LAYERS.radii(np.array([out]))[0] == pytest.approx(CORE + layer * PITCH, abs=1e-9)


def test_expected_radii_are_the_means_of_coils_wound_at_random() -> None:
    coils, turns = [irregular(seed) for seed in range(600)], np.arange(200)
    for out in np.arange(8.0, 10.5, 0.25):
        wound = [coil.angle(HELD - out) / (2.0 * np.pi) for coil in coils]
        layers = np.interp(wound, turns, PITCH * (turns // 25))
        assert LAYERS.radii(np.array([out]))[0] - CORE == pytest.approx(layers.mean(), abs=0.06 * PITCH)


def test_over_the_end_of_a_layer_the_doubt_is_one_step() -> None:
    """However finely the way is cut, and either way."""
    for parts in (7, 300):
        lengths = np.linspace(7.0, 11.0, parts + 1)
        for way in (lengths, lengths[::-1]):
            radii = np.array([LAYERS.radii(np.array([out])) for out in way])
            total = sum(LAYERS.doubt(b - a, b)[0] for a, b in pairwise(radii))
            assert np.sqrt(total) == pytest.approx(PITCH / (CORE + 1.5 * PITCH), rel=0.05)
            assert radii[-1] - radii[0] == pytest.approx(np.sign(way[0] - way[-1]) * PITCH, abs=1e-6)


def test_lengths_that_no_winch_has_are_taken_as_its_nearest() -> None:
    assert LAYERS.radii(np.array([-1.0]))[0] == LAYERS.radii(np.array([0.0]))[0]
    assert LAYERS.radii(np.array([99.0]))[0] == pytest.approx(CORE)
