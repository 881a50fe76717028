"""A robot as arrays: what each word of the description becomes."""

from __future__ import annotations

import numpy as np
import pytest

import cases
from cablewright.foundation.errors import InputError
from cablewright.kernels import layout
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.pack import pack
from cablewright.models.statics import Model
from cablewright.robot import load

HOUSE = load("house-printer")


@pytest.mark.parametrize("model", list(cases.models(*CableLaw)), ids=cases.name)
def test_arrays_are_what_kernels_are_compiled_for(model: Model) -> None:
    packed = model.packed
    for array in (packed.lines, packed.platform):
        assert array.dtype == np.float64
        assert array.flags.c_contiguous
        assert array.flags.writeable
        assert np.isfinite(array).all()
    assert packed.lines.shape == (model.m, layout.COLUMNS)
    assert packed.freedoms == model.n == len(cases.random_poses(model, 1)[0])
    assert packed.platform.shape == (layout.PLATFORM,)
    assert packed.platform[layout.PLATFORM_WEIGHT] == model.robot.platform.mass * model.robot.scene.gravity


def test_a_model_is_packed_once() -> None:
    assert Model(load("house-printer")).packed is Model(load("house-printer")).packed


def test_cable_laws_differ_in_weight_and_compliance_alone() -> None:
    full, elastic, rigid = (pack(HOUSE, Fidelity(law)).lines for law in reversed(CableLaw))
    cable = HOUSE.lines[0].cable
    assert (full[:, layout.WEIGHT] == cable.linear_density * HOUSE.scene.gravity).all()
    assert (elastic[:, layout.WEIGHT] == 0.0).all()
    assert (elastic[:, layout.FREE_COMPLIANCE] == 1.0 / cable.stiffness).all()
    assert (elastic[:, layout.DEAD_COMPLIANCE] == 1.0 / cable.stiffness).all()
    assert (elastic[:, layout.ARC_COMPLIANCE] == 0.0).all()  # its file says so
    compliances = [layout.FREE_COMPLIANCE, layout.DEAD_COMPLIANCE, layout.ARC_COMPLIANCE]
    assert (rigid[:, compliances] == 0.0).all()
    others = np.setdiff1d(np.arange(layout.COLUMNS), [layout.WEIGHT, *compliances])
    np.testing.assert_array_equal(full[:, others], rigid[:, others])


def test_limits_replace_those_of_every_line() -> None:
    limits = [layout.TENSION_MIN, layout.TENSION_MAX]
    assert (pack(HOUSE, Fidelity()).lines[:, limits] == (20.0, 5150.0)).all()
    assert (pack(HOUSE, Fidelity(), (1.0, 2.0)).lines[:, limits] == (1.0, 2.0)).all()
    assert (pack(HOUSE, Fidelity()).lines[:, layout.BREAKING] == 10290.0).all()


def test_a_lever_needs_the_dead_span_that_holds_it() -> None:
    loose = cases.replaced(HOUSE, "loose", winch_exit=None, dead_length=15.0)
    with pytest.raises(InputError, match="line 'south-west': a universal joint needs winch_exit"):
        pack(loose, Fidelity())
    assert (pack(loose, Fidelity(sheave=SheaveLaw.SWIVEL)).lines[:, layout.DEAD_LENGTH] == 15.0).all()
