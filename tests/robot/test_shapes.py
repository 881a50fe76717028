"""What lines may touch, in robot files: beams of the frame and boxes of the platform."""

from __future__ import annotations

import pytest

from cablewright.foundation.errors import InputError
from cablewright.robot import Beam, Box, library_text, loads, update

BEAM = '[[scene.beams]]\nstart = [0, 0, 0]\nend = [0, 0, "150 cm"]\nradius = "5 cm"\n'
BOX = '[[platform.boxes]]\nlowest = [-0.1, -0.1, "-20 cm"]\nhighest = [0.1, 0.1, 0]\n'


@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_they_are_read_with_units_and_written_back(name: str) -> None:
    text = library_text(name) + BEAM + BOX
    robot = loads(text)
    assert robot.scene.beams == (Beam(start=(0, 0, 0), end=(0, 0, 1.5), radius=0.05),)
    assert robot.platform.boxes == (Box(lowest=(-0.1, -0.1, -0.2), highest=(0.1, 0.1, 0)),)
    assert hash(robot) == hash(loads(text))
    thicker = robot.scene.beams[0].model_copy(update={"radius": 0.06})
    changed = update(text, robot.model_copy(update={"scene": robot.scene.model_copy(update={"beams": (thicker,)})}))
    assert 'radius = "6 cm"' in changed


@pytest.mark.parametrize(
    ("line", "instead", "says"),
    [
        ('radius = "5 cm"', "radius = 0", "scene.beams[0].radius = 0"),
        ('radius = "5 cm"', 'radius = "5 kg"', "must be a finite length"),
        ("start = [0, 0, 0]", "start = [0, 0]", "scene.beams[0].start"),
        ("highest = [0.1, 0.1, 0]", "highest = [0.1, -0.1, 0]", "platform.boxes[0].highest = [0.1, -0.1, 0]: must be"),
        ("highest = [0.1, 0.1, 0]", "higest = [0.1, 0.1, 0]", "did you mean 'highest'"),
        ("highest = [0.1, 0.1, 0]", "highest = [0.1, 0.1, nan]", "platform.boxes[0].highest"),
    ],
)
def test_what_is_no_shape_is_rejected(line: str, instead: str, says: str) -> None:
    for name in ("house-printer", "cogiro"):
        with pytest.raises(InputError) as caught:
            loads((library_text(name) + BEAM + BOX).replace(line, instead))
        assert says in str(caught.value)
        assert "\n" not in str(caught.value)
