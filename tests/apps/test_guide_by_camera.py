"""Guided calibrations by camera: a folder of pictures is all that is kept between two calls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from benchmarks.campaigns import tag_pictures
from benchmarks.campaigns.camera_rooms import Room, Setup, _shown, exit_errors, room
from PIL import Image

import cablewright as cw
from cablewright.calibration.measurements import Measured, write_measured
from cablewright.calibration.poses.simulation import measure
from cablewright.calibration.sightings.camera import camera_text
from cablewright.calibration.sightings.expected import expected, looking, standpoints

MACHINE = cw.load("ipanema")
SMALL = Setup(poses=4, width=960, height=720, focal=700.0, size=0.2, encoder=1e-4)
CARRIED = replace(SMALL, camera="platform", focal=500.0)


class Maker:
    """A person who follows the guide: moves the platform, takes a picture, writes the lengths down."""

    def __init__(self, made: Room, setup: Setup, folder: Path, camera: tuple[Any, Any]) -> None:
        self.made, self.setup, self.folder, self.camera = made, setup, folder, camera
        self.poses = np.zeros((0, 6))
        self.rng = np.random.default_rng(3)
        seen = made.data.sightings
        assert seen is not None
        (folder / "phone.toml").write_text(camera_text(seen.camera))
        (folder / "tags.toml").write_text(tomlkit.dumps(seen.layout.model_dump(mode="json", exclude_none=True)))
        (folder / "data.toml").write_text('schema = 1\nsigma.encoder = "0.1 mm"\n')
        (folder / "pictures").mkdir()
        self.layout = seen.layout

    def measure(self, poses: list[list[float]]) -> None:
        for pose in poses:
            self.poses = np.concatenate([self.poses, [pose]])
            shown = _shown(self.layout, self.setup, self.made.tags, np.array(pose), self.camera)
            grey = tag_pictures.picture(
                self.made.lens, self.setup.width, self.setup.height, shown, self.rng, self.setup.flaws
            )
            Image.fromarray(grey).save(self.folder / "pictures" / f"pose-{len(self.poses):02d}.png")
        counted = measure(self.made.robot, self.poses, 0.0, self.rng).measured.counted
        noise = np.random.default_rng(1).normal(0.0, 1e-4, counted.shape)
        (self.folder / "data.csv").write_text(write_measured(Measured(counted + noise), MACHINE))

    def arguments(self) -> list[Any]:
        given = (("--pictures", "pictures"), ("--camera", "phone.toml"), ("--tags", "tags.toml"))
        return ["calibrate", "ipanema", self.folder / "data.csv", *(p for k, v in given for p in (k, self.folder / v))]


def test_a_folder_leads_from_nothing_to_a_good_calibration(cli: Callable[..., Any], tmp_path: Path) -> None:
    made = room(MACHINE, SMALL, 3, pixels=False)
    assert made.data.sightings is not None
    maker = Maker(made, SMALL, tmp_path, made.camera)
    ask = [*maker.arguments(), "--guide", "--rough", "0.05", "--need", "3 mm", "--json"]
    first = cli(*ask, "--plot", tmp_path / "room.svg").json
    assert (first["advice"], first["poses"], len(first["next"])) == ("measure", 0, 9)
    assert first["camera"].startswith("put the camera at (")
    assert first["next"][0]["why"].startswith("pose-01.jpg, with tags ")
    assert (tmp_path / "room.svg").read_text().startswith("<?xml")
    at = np.array([float(word) for word in first["camera"].split("(")[1].split(")")[0].split(",")])
    aim = np.array([float(word) for word in first["camera"].split("(")[2].split(")")[0].split(",")])
    maker.camera = (at, looking(at, aim))
    maker.measure([each["pose"] for each in first["next"][:5]])
    resumed = cli(*ask).json
    assert (resumed["poses"], len(resumed["next"]), resumed["sigma"]) == (5, 4, None)
    assert resumed["next"][0]["why"].startswith("pose-06.jpg")
    before = {tuple(each["pose"]) for each in first["next"][:5]}
    assert not before & {tuple(each["pose"]) for each in resumed["next"]}
    maker.measure([each["pose"] for each in resumed["next"]])
    for _ in range(4):
        later = cli(*ask).json
        if later["advice"] == "stop":
            break
        maker.measure([each["pose"] for each in later["next"]])
    assert later["advice"] == "stop"
    assert later["sigma"] < 3e-3
    assert later["camera"].endswith("leave it there")
    found = cli(*maker.arguments(), "--rough", "0.05", "--need", "3 mm", "--out", tmp_path / "new.toml", "--json").json
    assert found["verdict"] == "good"
    assert np.abs(exit_errors(made.robot, cw.load(str(tmp_path / "new.toml")), own_frame=True)).max() < 8e-3


def test_missing_pictures_are_named_and_do_not_count(cli: Callable[..., Any], tmp_path: Path) -> None:
    made = room(MACHINE, SMALL, 3, pixels=False)
    maker = Maker(made, SMALL, tmp_path, made.camera)
    ask = [*maker.arguments(), "--guide", "--rough", "0.05", "--json"]
    (tmp_path / "pictures" / "pose-01.png").write_bytes(b"none")
    assert cli(*ask).err.endswith("has pictures: write a row of lengths for each\n")
    maker.measure(made.poses[:3].tolist())
    (tmp_path / "pictures" / "pose-02.png").unlink()
    found = cli(*ask).json
    assert found["poses"] == 2
    assert any("take pose-02.jpg there" in reason for reason in found["reasons"])
    assert found["next"][0]["why"].startswith("pose-04.jpg")
    with_only = cli(*[each for each in ask if each != "--camera" and each != tmp_path / "phone.toml"])
    missing = "cablewright: --camera: is missing; pictures require --pictures, --camera and --tags\n"
    assert with_only.err == missing
    (tmp_path / "data.csv").unlink()  # nor are they ignored before there are data
    assert cli(*[each for each in ask if each not in ("--camera", tmp_path / "phone.toml")]).err == missing
    assert "is the picture of --guide" in cli(*maker.arguments(), "--plot", tmp_path / "room.svg").err


def test_it_counts_on_the_tags_that_a_camera_sees() -> None:
    """The sightings that are expected are those that exact projections of the tags show."""
    made = room(MACHINE, replace(SMALL, poses=6), 5)
    seen = made.data.sightings
    assert seen is not None
    place, rotation = made.camera
    told, both = expected(replace(seen, place=place, rotation=rotation), made.poses), 0
    for rendered, planned in zip(seen.pictures, told.pictures, strict=True):
        assert rendered is not None
        assert planned is not None
        shown = {each.number: each.corners for each in rendered.sightings}
        for each in planned.sightings:
            if each.number in shown:
                assert np.abs(each.corners - shown[each.number]).max() < 25.0  # tags, lens and file differ a little
                both += 1
    assert both > 0.8 * told.counts.sum() > 15


def test_a_camera_far_from_the_tags_is_not_proposed() -> None:
    made = room(MACHINE, SMALL, 3, pixels=False)
    seen = made.data.sightings
    assert seen is not None
    found = cw.guide(MACHINE, None, sightings=replace(seen, pictures=()), rough=0.05)
    assert found.view is not None
    middle = np.array([each.pose[:3] for each in found.next_poses]).mean(axis=0)
    counts = [float(expected(each, made.poses).counts.sum()) for each in standpoints(seen, MACHINE, middle)]
    chosen = float(expected(found.view.seen, made.poses).counts.sum())
    assert chosen > np.median(counts)


def test_a_camera_on_the_platform_is_planned_from_its_mount() -> None:
    made = room(MACHINE, CARRIED, 3, pixels=False)
    seen = made.data.sightings
    assert seen is not None
    layout = seen.layout.model_copy(update={"tags": seen.layout.tags[::3]})
    found = cw.guide(MACHINE, None, sightings=replace(seen, layout=layout, pictures=()), rough=0.02)
    assert found.camera == "the camera is on the platform"
    assert all("with tags" in each.why for each in found.next_poses)
    assert len(found.next_poses) == 9
