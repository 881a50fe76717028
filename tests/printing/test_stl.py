"""STL files: both forms, every way in which one may be broken, and noise."""

from __future__ import annotations

import struct
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.printing import stl
from cablewright.printing.stl import read_stl

SEED = 20210831
CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 2.0) for z in (0.0, 3.0)])
SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def cuboid() -> np.ndarray:
    """Twelve triangles (12, 3, 3) about a volume."""
    rows = [row for a, b, c, d in SIDES for row in ((a, b, c), (a, c, d))]
    return CORNERS[np.array(rows)]


def binary(triangles: np.ndarray, header: bytes = b"made by hand") -> bytes:
    records = b"".join(struct.pack("<12fH", 0, 0, 0, *row.ravel(), 0) for row in triangles)
    return header.ljust(80, b"\0") + struct.pack("<I", len(triangles)) + records


def text(triangles: np.ndarray) -> str:
    facets = (
        "facet normal 0 0 0\n outer loop\n"
        + "".join(f"  vertex {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in row)
        + " endloop\nendfacet\n"
        for row in triangles
    )
    return "solid box\n" + "".join(facets) + "endsolid box\n"


@pytest.fixture
def write(tmp_path: Path):
    def to_file(content: bytes | str) -> Path:
        file = tmp_path / "part.stl"
        file.write_bytes(content.encode() if isinstance(content, str) else content)
        return file

    return to_file


def test_both_forms_are_one_mesh(write) -> None:
    triangles = cuboid()
    for content in (binary(triangles), binary(triangles, b"solid, says its header"), text(triangles)):
        mesh = read_stl(write(content))
        np.testing.assert_array_equal(mesh.corners, triangles)
        assert mesh.is_closed
        assert (len(mesh.triangles), len(mesh.vertices)) == (12, 8)
        assert not mesh.triangles.flags.writeable
        assert not mesh.vertices.flags.writeable
    np.testing.assert_allclose(read_stl(write(text(triangles)), 1e-3).corners, 1e-3 * triangles)


def test_what_is_not_closed_is_known(write) -> None:
    triangles = cuboid()
    turned = triangles.copy()
    turned[3] = turned[3, ::-1]
    doubled = np.concatenate([triangles, triangles[:1]])
    flat = np.concatenate([triangles, triangles[:1, [0, 0, 1]]])  # nothing that bounds anything
    assert [read_stl(write(binary(t))).is_closed for t in (triangles[1:], turned, doubled, flat)] == [False] * 3 + [
        True
    ]


def test_a_long_file_that_ends_in_other_things_is_read(write) -> None:
    assert len(read_stl(write(binary(cuboid()) + b"colours")).triangles) == 12


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "0 bytes, too few"),
        (b"not a mesh", "too few"),
        (binary(cuboid())[:-1], "truncated: 12 triangles by its header take 684 bytes, it has 683"),
        (b"\0" * 80 + b"\xff\xff\xff\xff", "its header states 4294967295 triangles; at most"),
        (binary(cuboid()[:0]), "holds no triangle"),
        ("solid nothing\nendsolid nothing\n" + " " * 80, "holds no triangle"),
        (binary(np.full((1, 3, 3), np.nan)), "triangle 1: a coordinate is not finite"),
        (binary(cuboid()[:1])[:96] + b"\x01\x00\xa0\x7f" + binary(cuboid()[:1])[100:], "triangle 1: a coordinate"),
        (text(cuboid()).replace("vertex 0 0 0", "vertex 0 1e308 0", 1), "triangle 1: a coordinate"),
        (binary(np.full((1, 3, 3), np.inf)), "triangle 1: a coordinate is not finite"),
        (binary(np.full((1, 3, 3), 3e38)), "over 1e+06 m"),
        (text(cuboid()).replace("vertex 0 0 0", "vertex 0 nan 0"), "line 4: a vertex must be 3 finite numbers"),
        (text(cuboid()).replace("vertex 0 0 0", "vertex 0 0"), "line 4: a vertex must be 3 finite numbers"),
        (text(cuboid()).replace("vertex 0 0 0", "vertex a b c"), "line 4: a vertex must be 3 finite numbers"),
        (text(cuboid())[:-200], "must be part of a facet of three vertices"),
        (text(cuboid()).removesuffix("endsolid box\n"), "truncated: the last line is no endsolid"),
        (
            text(cuboid()).replace("  vertex 0 0 0\n", "", 1),
            "line 6: 'endloop': must be part of a facet of three vertices",
        ),
        (text(cuboid()).replace("  vertex 0 0 0\n", "  vertex 0 0 0\n" * 2, 1), "a facet of three vertices"),
        ("solid box\n" + "x" * 5000, "line 2: too long"),
    ],
)
def test_a_broken_file_is_rejected_in_one_line(write, content: bytes | str, says: str) -> None:
    with pytest.raises(InputError) as caught:
        read_stl(write(content))
    message = str(caught.value)
    assert "part.stl" in message
    assert says in message
    assert "\n" not in message


@pytest.mark.parametrize("scale", [0.0, -1.0, 1e-10, 1e10, float("nan"), float("inf")])
def test_a_scale_is_a_number_above_zero(write, scale: float) -> None:
    with pytest.raises(InputError, match="mesh scale"):
        read_stl(write(binary(cuboid())), scale)


def test_no_file_a_folder_and_a_nul(tmp_path: Path) -> None:
    for path, says in ((tmp_path / "no.stl", "no such file"), (tmp_path, "not a regular"), (Path("a\0b"), "null")):
        with pytest.raises(InputError, match=says):
            read_stl(path)


def test_a_text_of_too_many_triangles_is_rejected(write, monkeypatch) -> None:
    monkeypatch.setattr(stl, "MAX_TRIANGLES", 5)
    with pytest.raises(InputError, match="at most 4096 bytes, 5 triangles"):
        read_stl(write(text(cuboid())))
    with pytest.raises(InputError, match="its header states 12 triangles; at most 5"):
        read_stl(write(binary(cuboid())))


@pytest.mark.parametrize("form", ["binary", "text"])
def test_noise_is_a_mesh_or_rejected(write, form: str) -> None:
    rng = np.random.default_rng(SEED)
    whole = binary(cuboid()) if form == "binary" else text(cuboid()).encode()
    for _ in range(400):
        content = bytearray(whole)
        for _ in range(rng.integers(1, 6)):
            at = int(rng.integers(len(content)))
            if rng.uniform() < 0.3:
                del content[at : at + int(rng.integers(1, 60))]
            else:
                content[at] = int(rng.integers(256))
        with suppress(InputError):
            mesh = read_stl(write(bytes(content)))
            assert mesh.corners.shape[1:] == (3, 3)
            assert np.isfinite(mesh.corners).all()
            assert mesh.is_closed in (True, False)
