"""The data of the turnable view, unpacked as its program does."""

import base64
import json
import re

import numpy as np

from apps.report.synthetic import house_check
from cablewright.apps.report.digest import Digest
from cablewright.apps.report.viewer import canvas, script

PEN_UP = 255


def unpacked(digest):
    data = json.loads(re.search(r'id="view-data">(.*?)</script>', canvas(digest), re.S)[1])
    grid = np.frombuffer(base64.b64decode(data["xyz"]), dtype="<u2").reshape(-1, 3)
    level = np.frombuffer(base64.b64decode(data["level"]), dtype=np.uint8)
    return data, grid * data["step"] + data["origin"], level


def test_points_are_those_of_the_path_to_a_grid_step(small):
    digest = Digest(*small)
    data, points, level = unpacked(digest)
    assert len(points) == len(level)
    nearest = np.linalg.norm(points[:, None] - digest.check.samples.positions, axis=2).min(axis=1)
    assert nearest.max() <= data["step"]
    drawn = np.linalg.norm(np.diff(points, axis=0), axis=1)[level[1:] != PEN_UP].sum()
    assert abs(drawn - digest.check.samples.extruded_length) < 1e-3


def test_colours_rise_with_the_error(small):
    digest = Digest(*small)
    data, points, level = unpacked(digest)
    assert level[0] == PEN_UP
    assert level[level != PEN_UP].max() == len(data["ramp"]) - 1
    top = points[np.argmax(np.where(level == PEN_UP, -1, level))]
    error = digest.check.error_uncompensated[np.argmin(np.linalg.norm(digest.check.samples.positions - top, axis=1))]
    assert error * 1e3 > data["low"] + 0.9 * (data["high"] - data["low"])


def test_a_house_stays_small():
    digest = Digest(*house_check())
    _, points, _ = unpacked(digest)
    assert 8_000 < len(points) < 25_000
    assert len(canvas(digest)) < 300_000


def test_the_program_is_short_and_asks_for_nothing():
    text = script()
    assert len(text.splitlines()) < 150
    assert "</script" not in text
    assert not re.search(r"fetch|import|eval|innerHTML|document\.write", text)
