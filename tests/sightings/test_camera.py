from pathlib import Path

import numpy as np
import pytest
from benchmarks.campaigns import tag_pictures
from PIL import Image

import cablewright as cw
from cablewright.calibration.sightings import detection
from cablewright.calibration.sightings.camera import camera_text, load_camera
from cablewright.calibration.sightings.detection import detected
from cablewright.calibration.sightings.intrinsics import _camera, sheet
from cablewright.models.rotation import matrices

LENS = np.array([520.0, 520.0, 326.0, 235.0, -0.12, 0.05, 1e-3, -6e-4, 0.0])

SIZES = "image_width: 640\nimage_height: 480\n"
LENS_OF = "distortion_coefficients:\n data"


def _pictures(folder: Path, count: int, turn: float) -> None:
    rng, layout = np.random.default_rng(3), sheet()
    middle = np.mean([tag.at for tag in layout.tags], axis=0)
    for at in range(count):
        turned = matrices([*rng.uniform(-turn, turn, 2), rng.uniform(-1.5, 1.5)]) @ np.diag([1.0, -1.0, -1.0])
        place = np.array([*rng.uniform(-0.05, 0.05, 2), rng.uniform(0.33, 0.45)])
        tags = [
            tag_pictures.Tag(tag.number, tag.size, place + turned @ (tag.at - middle), turned) for tag in layout.tags
        ]
        Image.fromarray(tag_pictures.picture(LENS, 640, 480, tags, rng)).save(folder / f"sheet-{at}.png")


def test_a_lens_is_found_from_pixels_to_its_stated_sigmas(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tags are detected once in each picture; only their edges are measured again with each better lens."""
    _pictures(tmp_path, 6, 0.7)
    searched = list[int]()
    monkeypatch.setattr(detection, "detected", lambda picture: searched.append(1) or list(detected(picture)))
    found = cw.camera(tmp_path)
    assert len(searched) == 6
    assert not found.refusal
    assert found.residual is not None
    assert found.residual < 0.1
    free = found.sigmas > 0.0
    assert found.sigmas[0] < 1.0
    assert np.abs((found.camera.lens - LENS)[free] / found.sigmas[free]).max() < 3.5
    (tmp_path / "phone.toml").write_text(camera_text(found.camera, ("a comment",)))
    assert load_camera(tmp_path / "phone.toml") == found.camera


def test_too_few_pictures_are_an_error(tmp_path: Path) -> None:
    _pictures(tmp_path, 2, 0.3)
    with pytest.raises(cw.InputError, match=r"2 of 2 pictures show 4 tags of the sheet, at least 5 must"):
        cw.camera(tmp_path)


def test_files_of_opencv_are_read(tmp_path: Path) -> None:
    found = load_camera("examples/phone.yml")
    assert (found.width, found.height) == (1920, 1080)
    assert found.focal == (1512.0, 1511.6)
    assert found.distortion == (0.112, -0.22, 0.0004, -0.0007, 0.0)
    rows = "<rows>3</rows><cols>3</cols><dt>d</dt>"
    (tmp_path / "lens.xml").write_text(
        '<?xml version="1.0"?><opencv_storage><image_Width>640</image_Width><image_Height>480</image_Height>'
        f'<Camera_Matrix type_id="opencv-matrix">{rows}<data>500. 0. 320. 0. 501. 240. 0. 0. 1.</data></Camera_Matrix>'
        '<Distortion_Coefficients type_id="opencv-matrix"><data>0.1 -0.2 0. 0.</data></Distortion_Coefficients>'
        "</opencv_storage>"
    )
    other = load_camera(tmp_path / "lens.xml")
    assert (other.width, other.focal, other.distortion) == (640, (500.0, 501.0), (0.1, -0.2, 0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("image_width: 640\n", "no image_height with 1 finite numbers"),
        ("image_width: nan\nimage_height: 480\n", "no image_width with 1 finite numbers"),
        ("image_width: 640\nimage_height: 1e400\n", "no image_height with 1 finite numbers"),
        ("image_width: 640\nimage_height: x\n", "no image_height with 1 finite numbers"),
        (
            "image_width: 640\nimage_height: 480\ncamera_matrix:\n data: [1, 2]\n",
            "no camera_matrix with 9 finite numbers",
        ),
        (
            f"{SIZES}camera_matrix:\n data: [9, 0, 320, 0, 9, 240, 0, 0, 1]\n{LENS_OF}: [0, 0, 0, 0, 0]\n",
            "focal = .*: must be over 32 px",
        ),
        (
            f"{SIZES}camera_matrix:\n data: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n{LENS_OF}: [0, 0, 0, 0, 0, 1, 0, 0]\n",
            "distortion_coefficients has 8 numbers",
        ),
    ],
)
def test_a_bad_file_of_opencv_is_an_error_in_one_line(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "bad.yml").write_text(f"%YAML:1.0\n---\n{text}")
    with pytest.raises(cw.InputError, match=words):
        load_camera(tmp_path / "bad.yml")


@pytest.mark.parametrize(("size", "words"), [((63, 100), "width = 63"), ((100, 20_001), "height = 20001")])
def test_pictures_of_a_size_that_no_camera_has_are_an_error(tmp_path: Path, size: tuple[int, int], words: str) -> None:
    Image.new("L", size).save(tmp_path / "odd.png")
    with pytest.raises(cw.InputError, match=f"odd.png: {words}") as error:
        cw.camera(tmp_path)
    assert "\n" not in str(error.value)


def test_a_lens_out_of_range_is_an_error_in_one_line() -> None:
    camera = load_camera("examples/phone.yml")
    lens = np.array([*camera.focal, -5.0, *camera.lens[3:]])
    with pytest.raises(cw.InputError, match="the lens that fits the pictures: principal") as error:
        _camera(camera, lens, camera.spread)
    assert "\n" not in str(error.value)
