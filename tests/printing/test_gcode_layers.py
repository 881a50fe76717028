"""Which layer a move belongs to."""

import pytest

from cablewright.foundation.errors import InputError


def three(*markers: str) -> str:
    return "G1 X9\n" + "".join(f"{marker}\nG92 E0\nG1 X0\nG1 X1 E1\n" for marker in markers)


@pytest.mark.parametrize(
    ("markers", "layers"),
    [
        ((";LAYER:0", ";LAYER:1", ";LAYER:2"), [1, 2, 3]),
        ((";LAYER:0 Z:1", ";LAYER:1 Z:2\r", ";LAYER:7\t"), [1, 2, 8]),
        ((";LAYER_CHANGE", ";LAYER_CHANGE ", ";LAYER_CHANGE\r"), [1, 2, 3]),
        (("; layer 1", ";layer 2", "; layer 3, Z = 0.6"), [1, 2, 3]),
        ((";LAYER:-2", ";LAYER:-1", ";LAYER:0"), [1, 2, 3]),
        ((";LAYER:0", ";LAYER_CHANGE", "; layer 9"), [1, 1, 1]),
        (("; layer 4", ";LAYER:7", "; layer 5"), [4, 4, 5]),
    ],
)
def test_markers(markers, layers, read):
    path = read(three(*markers))
    assert path.layer.tolist() == [0] + [layer for layer in layers for _ in range(2)]
    assert path.layer_count == len(set(layers))


@pytest.mark.parametrize(
    "comment",
    [
        "; layer_height = 0.2",
        "; layer 3 = x",
        "; first_layer_height = 1",
        "; before_layer_gcode = ;LAYER:9",
        "; layer",
        "; layer 0.2",
        ";LAYER_CHANGES",
        ";LAYER:x",
        ";LAYER:3.5",
        " ;LAYER:5",
        "M117 ;LAYER:5",
        "G1 X5 ;LAYER:5",
        "; next ;LAYER:5",
        "(;LAYER:5)",
    ],
)
@pytest.mark.parametrize("marker", [";LAYER:0", ";LAYER_CHANGE", "; layer 0"])
def test_what_is_no_marker(comment, marker, read):
    path = read(f"{marker}\nG1 X1 E1\n{comment}\nG1 X2 E2\n{comment}\nG1 X3 E3\n")
    assert set(path.layer.tolist()) == {1}


def test_settings_at_the_end_of_a_file_make_no_layers(read):
    settings = "; layer_height = 0.2\n; bottom_solid_layers = 3\n; layer_gcode = ;LAYER_CHANGE\\n;LAYER:[layer_num]\n"
    path = read(";LAYER:0\nG1 X1 E1\n" + settings)
    assert path.layer_count == 1


def test_a_layer_without_material_does_not_count(read):
    assert read(";LAYER:0\nG1 X1 E1\n;LAYER:1\nG1 X5\n").layer_count == 1


class TestWithoutMarkers:
    def test_heights_counted_upwards(self, read):
        path = read("M83\nG1 Z2\nG1 X1 E1\nG1 Z9\nG1 X5\nG1 Z4\nG1 X1 E1\nG1 Z2\nG1 X0 E1\nG1 X1\n")
        assert path.layer.tolist() == [0, 1, 1, 1, 1, 2, 2, 1, 1]
        assert path.layer_count == 2

    def test_rounding_makes_no_layer(self, read):
        path = read("M83\nG91\nG1 Z0.1\nG1 Z0.2\nG1 X1 E1\nG90\nG1 Z0.3\nG1 X2 E1\n")
        assert path.layer_count == 1


def test_absurd_layer_number(read):
    with pytest.raises(InputError, match=r"line 1: ';LAYER:99999999': layer 99999999 is out of range"):
        read(";LAYER:99999999\nG1 X1 E1\n")
