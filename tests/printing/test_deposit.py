"""What a path lays: boxes below the nozzle's way, from the sample at their end on."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.printing.gcode import parse
from cablewright.printing.growing_part import PIECE_LENGTH, deposit
from cablewright.printing.job import Bead
from cablewright.printing.path import sample

BEAD = Bead(width=0.06, height=0.02)
CODE = b"""G21 G90 M83
;LAYER:0
G1 X0 Y0 Z20 F6000
G1 X1000 Y0 E10
G1 X1000 Y500
G1 X1000 Y1000 E5
;LAYER:1
G1 X0 Y1000 Z40 E10
G1 X0 Y1000 Z340 E3
"""


@pytest.fixture
def laid(tmp_path):
    file = tmp_path / "part.gcode"
    file.write_bytes(CODE)
    samples = sample(parse(file), step=0.05)
    return samples, deposit(samples, BEAD)


def test_as_much_lies_as_was_laid(laid) -> None:
    samples, found = laid
    lengths = 2.0 * found.half[:, 0] - BEAD.width
    assert lengths.sum() == pytest.approx(samples.extruded_length)
    assert lengths.max() <= PIECE_LENGTH + 0.05 + 1e-12
    assert len(found) == 4 + 2 + 4 + 2


def test_a_strand_hangs_below_the_way(laid) -> None:
    samples, found = laid
    level = np.abs(found.along[:, 2]) < 0.9
    up = np.cross(found.along, found.across)
    assert (up[level, 2] > 0.9).all()
    np.testing.assert_allclose(np.linalg.norm(found.along, axis=1), 1.0)
    np.testing.assert_allclose((found.along * found.across).sum(axis=1), 0.0, atol=1e-15)
    top = found.centre + 0.5 * BEAD.height * up + found.along * (found.half[:, :1] - 0.5 * BEAD.width)
    np.testing.assert_allclose(top[level], samples.positions[found.sample[level]], atol=1e-12)
    column = found.centre[~level] + found.along[~level] * (found.half[~level, :1] - 0.5 * BEAD.width)
    np.testing.assert_allclose(column, samples.positions[found.sample[~level]], atol=1e-12)
    np.testing.assert_allclose(found.half[~level, 1:], 0.03)


@pytest.mark.parametrize("lean", [0.0, 15.0, 40.0])
def test_a_strand_on_a_board_lies_between_the_board_and_the_way(tmp_path, lean: float) -> None:
    out = np.array([0.0, -np.cos(np.radians(lean)), np.sin(np.radians(lean))])
    up = np.cross(out, [1.0, 0.0, 0.0])
    rows = [f"G1 X{1e3 * x:.6f} Y{1e3 * u * up[1]:.6f} Z{1e3 * u * up[2]:.6f} E9" for x, u in ((1, 0), (1, 1), (0, 0))]
    (tmp_path / "part.gcode").write_text("\n".join(["G21 G90 M83", ";LAYER:0", *rows]))
    samples = sample(parse(tmp_path / "part.gcode"), step=0.05)
    found = deposit(samples, BEAD, up=tuple(out))
    np.testing.assert_allclose(found.across @ out, 0.0, atol=1e-9)
    np.testing.assert_allclose(np.cross(found.along, found.across) @ out, 1.0, atol=1e-9)
    np.testing.assert_allclose(found.centre @ out, -0.5 * BEAD.height, atol=1e-9)
    np.testing.assert_allclose(found.half[:, 1:], np.tile([0.5 * BEAD.width, 0.5 * BEAD.height], (len(found), 1)))


def test_pieces_come_in_order_and_belong_to_their_layer(laid) -> None:
    samples, found = laid
    assert (np.diff(found.sample) > 0).all()
    assert samples.extruding[found.sample].all()
    np.testing.assert_array_equal(found.layer, samples.layer[found.sample])
