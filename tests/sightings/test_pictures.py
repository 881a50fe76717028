import io
import zlib
from pathlib import Path

import numpy as np
import pytest
from benchmarks.campaigns import tag_pictures
from PIL import Image

import cablewright as cw
from cablewright.calibration.sightings.pictures import by_pose, read_picture

LENS = np.array([500.0, 500.0, 200.0, 150.0, 0.0, 0.0, 0.0, 0.0, 0.0])
CAMERA = cw.Camera(width=400, height=300, focal=(500.0, 500.0), principal=(200.0, 150.0))
LAYOUT = cw.TagLayout(tags=(cw.Tag(number=5, size=0.1, at=(0.0, 0.0, 0.0)),))
AHEAD = np.diag([1.0, -1.0, -1.0])


def _picture(*tags: tuple[int, float]) -> Image.Image:
    shown = [tag_pictures.Tag(number, 0.1, np.array([x, 0.0, 0.8]), AHEAD) for number, x in tags]
    return Image.fromarray(tag_pictures.picture(LENS, 400, 300, shown, np.random.default_rng(0)))


def _read(folder: Path, picture: Image.Image, **more: object) -> cw.Sightings:
    picture.save(folder / "pose-1.jpg", quality=95, **more)
    return cw.read_sightings(folder, LAYOUT, CAMERA, 1)


def test_a_tag_is_read_from_a_file(tmp_path: Path) -> None:
    assert _read(tmp_path, _picture((5, 0.0))).counts.tolist() == [1]


@pytest.mark.parametrize(
    ("tags", "words"),
    [((), "shows no tag"), (((17, 0.0),), "shows tags 17, none of which is in the layout")],
    ids=["no tags", "another sheet"],
)
def test_a_picture_without_tags_of_the_layout_says_so(
    tmp_path: Path, tags: tuple[tuple[int, float], ...], words: str
) -> None:
    seen = _read(tmp_path, _picture(*tags))
    assert seen.counts.tolist() == [0]
    assert seen.pictures[0] is not None
    assert seen.pictures[0].left_out == (words,)


def test_a_tag_twice_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(cw.InputError, match=r"pose-1.jpg: tag 5 is in it 2 times; cover or remove the others"):
        _read(tmp_path, _picture((5, -0.15), (5, 0.15)))


def test_a_picture_of_another_size_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(cw.InputError, match=r"300 x 200 pixels, but the camera's pictures have 400 x 300"):
        _read(tmp_path, _picture((5, 0.0)).resize((300, 200)))


def test_the_rotation_of_exif_is_not_applied(tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[0x0112] = 6  # turned by a viewer
    assert _read(tmp_path, _picture((5, 0.0)), exif=exif).counts.tolist() == [1]


def test_a_truncated_picture_is_an_error_in_one_line(tmp_path: Path) -> None:
    data = io.BytesIO()
    _picture((5, 0.0)).save(data, "JPEG")
    (tmp_path / "pose-1.jpg").write_bytes(data.getvalue()[: len(data.getvalue()) // 2])
    with pytest.raises(cw.InputError, match=r"pose-1.jpg: damaged: .*; copy it from the camera again") as error:
        read_picture(tmp_path / "pose-1.jpg")
    assert "\n" not in str(error.value)


def test_a_hundred_megapixels_are_rejected_before_they_are_decoded(tmp_path: Path) -> None:
    head = b"\x00\x00\x00\x0dIHDR" + (10_000).to_bytes(4, "big") * 2 + b"\x08\x00\x00\x00\x00"
    head += zlib.crc32(head[4:]).to_bytes(4, "big")
    (tmp_path / "big.png").write_bytes(b"\x89PNG\r\n\x1a\n" + head + b"\x00\x00\x00\x00IDAT\x35\xaf\x06\x1e")
    with pytest.raises(cw.InputError, match=r"10000 x 10000 pixels; at most 64 million are read"):
        read_picture(tmp_path / "big.png")


def test_grey_levels_of_16_bits_are_scaled_not_clipped(tmp_path: Path) -> None:
    grey = np.array([[0, 257, 32_896, 65_535]], dtype=np.uint16)
    Image.fromarray(grey).save(tmp_path / "deep.png")
    assert read_picture(tmp_path / "deep.png").tolist() == [[0.0, 1.0, 128.0, 255.0]]


def test_what_is_no_picture_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "text.jpg").write_text("no picture")
    with pytest.raises(cw.InputError, match=r"text.jpg: not a JPEG or PNG picture"):
        read_picture(tmp_path / "text.jpg")


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (("scene.jpg",), "its name does not end with a number; expected that of its pose, 1 to 3"),
        (("pose-4.jpg",), "its name is of pose 4"),
        (("IMG_1000002.jpg",), "its name is of pose 1000002"),
        (("a-2.jpg", "b-02.png"), "pose 2 has a picture already, a-2.jpg"),
        ((), "no pictures; expected files"),
    ],
)
def test_names_of_pictures_say_their_pose(tmp_path: Path, names: tuple[str, ...], words: str) -> None:
    for name in names:
        (tmp_path / name).touch()
    with pytest.raises(cw.InputError, match=words):
        list(by_pose([tmp_path], 3))
