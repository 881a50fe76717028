"""The reports of accuracy: whole, self-contained, the same each time, and right for studies of every kind."""

import base64
import dataclasses
import html
import re
from functools import cache

import numpy as np
import pytest
from matplotlib.image import imread

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.analyses.accuracy.error_region import Region, hull_of
from cablewright.analyses.accuracy.spread import FirstOrder, MonteCarlo
from cablewright.analyses.sheave_ratio import SheaveRule
from cablewright.apps import style
from cablewright.apps.pictures.accuracy import _binned, _worst_of_each, along, contributions, displaced_by, plane
from cablewright.apps.pictures.error_region import region as region_picture
from cablewright.apps.pictures.workspace import workspace_errors
from cablewright.apps.report.accuracy import write, write_place
from cablewright.apps.report.document import script
from cablewright.foundation.errors import EnvironmentFault
from cablewright.kernels.layout import Code
from cablewright.live.position_sets import Places
from cablewright.robot import load
from cablewright.robot.uncertainty import modulus_ranges
from cablewright.studies.accuracy import (
    AccuracyStudy,
    accuracy,
)
from cases import nozzle_errors, some

EVIL = "</script><script>alert(1)</script>\"'&<b> $\\frac{1}$ $x_"


@cache
def studied(shape: str, name: str = "house-printer", **options) -> AccuracyStudy:
    """A small study of each shape."""
    robot = load(name)
    if shape == "workspace":
        return accuracy(robot, Places.workspace(2.5 if name == "house-printer" else 1.4), **options)
    if shape == "plane":
        return accuracy(robot, Places.plane(robot, 1.0, None, 1.5), **options)
    if shape == "helix":
        return accuracy(robot, Places.helix(robot, 2.0, 1.0, 0.5, 3.0, 0.5), **options)
    angle = np.linspace(0.0, 2.0 * np.pi, 30)
    positions = np.column_stack([2.0 * np.cos(angle), np.sin(angle), np.ones(30)])
    return accuracy(robot, Places("path", positions, 2.0 * angle), **options)


@cache
def placed(name: str = "house-printer"):
    robot = load(name)
    return accuracy(robot, [1.0, 0.5, 1.5] + [0.0] * (robot.n - 3))


def renamed(study: AccuracyStudy, name: str) -> AccuracyStudy:
    """The study of a robot, and a first line, of that name."""
    robot = study.accuracy.robot
    line = robot.lines[0].model_copy(update={"name": name})
    robot = robot.model_copy(update={"name": name, "description": name, "lines": (line, *robot.lines[1:])})
    ranges = modulus_ranges(robot)
    return dataclasses.replace(study, accuracy=dataclasses.replace(study.accuracy, robot=robot, ranges=ranges))


def holed(study: AccuracyStudy, gone) -> AccuracyStudy:
    """The study without an answer where *gone*."""
    found = study.accuracy
    spread = dataclasses.replace(
        found.spread,
        **{
            name: np.where(gone.reshape(-1, *(1,) * (value.ndim - 1)), np.nan, value)
            for name, value in found.spread.__dict__.items()
            if value.dtype != np.int64
        },
    )
    changed = dataclasses.replace(
        found,
        codes=np.where(gone, Code.INFEASIBLE, found.codes),
        nominal=np.where(gone[:, None], np.nan, found.nominal),
        spread=spread,
    )
    return dataclasses.replace(study, accuracy=changed)


def told(page: str) -> str:
    """What a reader reads: no pictures, no scripts, no markup."""
    page = re.sub(r"<(script|style)\b.*?</\1>|</?a\b[^>]*>", "", page, flags=re.DOTALL)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]*>", " ", page)))


def is_drawn(path) -> bool:
    """Whether a PNG has more than its background."""
    return float(np.ptp(imread(path)[..., :3])) > 0.5


def has_nan(text: str) -> bool:
    return re.search(r"\bnan\b", text) is not None


@pytest.mark.parametrize(
    ("shape", "name", "drawn"),
    [
        ("workspace", "house-printer", "workspace"),
        pytest.param("workspace", "cogiro", "workspace", marks=pytest.mark.slow),
        ("plane", "house-printer", "plane"),
        pytest.param("plane", "cogiro", "plane", marks=pytest.mark.slow),
        ("helix", "house-printer", "along"),
        pytest.param("path", "house-printer", "along", marks=pytest.mark.slow),
        ("path", "cogiro", "along"),
    ],
)
def test_report_and_pictures_of_a_study(folder, shape, name, drawn):
    method = FirstOrder() if name == "cogiro" else "vertices"
    report = write(studied(shape, name, method=method), folder)
    assert report == folder / "report.html"
    assert {path.name for path in folder.iterdir()} == {"report.html", "contributions.png", f"{drawn}.png"}
    assert all(is_drawn(path) for path in folder.glob("*.png"))
    page = report.read_text(encoding="utf-8")
    embedded = {base64.b64decode(data) for data in re.findall(r'src="data:image/png;base64,([^"]+)"', page)}
    assert embedded == {path.read_bytes() for path in folder.glob("*.png")}
    assert not has_nan(told(page))
    assert ("max turn" in told(page)) == (name == "cogiro")


@pytest.mark.usefixtures("undrawn_here")
def test_nothing_is_asked_of_any_other_place(folder):
    page = write(studied("helix"), folder).read_text(encoding="utf-8")
    own = page.replace(script(), "")  # three.js names specifications and its own pages
    assert "http://" not in own
    assert "https://" not in own
    assert not re.search(r'src="(?!data:)', page)
    assert not re.search(
        r'\bhref="(?!#)|<link|<base|<iframe|@import|url\(|fetch\(|XMLHttpRequest|import\(|WebSocket', page
    )


@pytest.mark.usefixtures("undrawn_here")
def test_figures_are_those_of_the_study(folder):
    study = studied("plane")
    text = told(write(study, folder).read_text(encoding="utf-8"))
    largest = np.nanmax(study.accuracy.spread.max_error) * 1e3
    assert f"Up to {largest:.3g} mm off" in text
    assert f"{np.nanmax(study.accuracy.nominal_error) * 1e3:.3g} mm off with the numbers of its file" in text
    assert text.index("Up to") < text.index("max error")
    assert "modulus of south-west 1 1 0.7 1.3" in text  # unit, nominal, min, max


@pytest.mark.usefixtures("undrawn_here")
def test_limits_that_end_the_workspace_are_reported(folder):
    study = studied("workspace")
    text = told(write(study, folder).read_text(encoding="utf-8"))
    for each in study.workspace.by_limit:
        assert each.limit in text


@pytest.mark.parametrize("shape", some(["workspace", "helix"]))
def test_foreign_text_is_escaped(folder, shape):
    page = write(renamed(studied(shape), EVIL), folder).read_text(encoding="utf-8")
    assert "alert(1)" in page
    assert "<script>alert" not in page
    assert "<b>" not in page
    assert page.count("<script") == page.count("</script>") == 2  # the data and the program


@pytest.mark.slow  # as the one above
def test_foreign_text_of_a_place_is_escaped(folder):
    found = placed()
    study = renamed(AccuracyStudy(Places("path", np.zeros((1, 3))), found.accuracy, None, ()), EVIL)
    evil = dataclasses.replace(found, accuracy=study.accuracy)
    page = write_place(evil, folder).read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert "<b>" not in page
    assert page.count("<script") == 2


def test_same_study_same_bytes(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write(studied("workspace"), tmp_path / name)
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes(), path.name


@pytest.mark.parametrize("name", some(["house-printer", "cogiro"]))
def test_place(folder, name):
    found = placed(name)
    report = write_place(found, folder)
    assert {path.name for path in folder.iterdir()} == {"report.html", "contributions.png", "region.png"}
    assert all(is_drawn(path) for path in folder.glob("*.png"))
    text = told(report.read_text(encoding="utf-8"))
    left = found.remains["full"].spread.max_error[0]
    assert f"Full compensation removes {(1 - left / found.accuracy.spread.max_error[0]) * 100:.3g} % of that" in text
    assert f"inner points {found.region.interior.samples}" in text
    assert "corners are worst yes" in text
    assert all(each.words in text for each in COMPENSATIONS.values())
    assert ("Tensions of smallest deviation" in text) == (found.best is not None)
    assert not has_nan(text)


@pytest.mark.usefixtures("undrawn_here")
def test_place_where_an_inner_point_is_worse(folder):
    found = placed()
    worse = dataclasses.replace(found.region.interior, corner_is_worst=False, max_error=0.0777)
    changed = dataclasses.replace(found, region=dataclasses.replace(found.region, interior=worse))
    text = told(write_place(changed, folder).read_text(encoding="utf-8"))
    assert "Some points within the ranges are worse than all corners: up to 77.7 mm off" in text
    assert "corners are worst no" in text


@pytest.mark.usefixtures("undrawn_here")
def test_place_without_what_may_be_missing(folder):
    found = placed()
    bare = dataclasses.replace(found.region, points=found.region.points[:0], interior=None)
    text = told(write_place(dataclasses.replace(found, region=bare, best=None, remains={}), folder).read_text("utf-8"))
    assert not (folder / "region.png").exists()
    assert "Full compensation" not in text
    assert "Tensions of smallest deviation" not in text


@pytest.mark.usefixtures("undrawn_here")
def test_place_fully_compensated_gains_nothing(folder):
    robot = load("house-printer")
    found = accuracy(robot, [1.0, 0.5, 1.5], compensation="full")
    text = told(write_place(found, folder).read_text(encoding="utf-8"))
    assert "is less than 0.001 mm off with the numbers of its file" in text
    assert "Full compensation" not in text


@pytest.mark.usefixtures("undrawn_here")
def test_no_place_answered(folder):
    study = studied("plane")
    lost = holed(study, np.ones(len(study.accuracy.codes), dtype=bool))
    text = told(write(lost, folder).read_text(encoding="utf-8"))
    assert {path.name for path in folder.iterdir()} == {"report.html"}
    assert "Nothing can be said" in text
    assert f"At {len(lost.accuracy.codes)} of {len(lost.accuracy.codes)} places: no tensions within the limits" in text
    assert not has_nan(text)


@pytest.mark.parametrize("shape", some(["workspace", "helix", "plane", "path"], 2))
@pytest.mark.parametrize("kept", some(["half", "one"]))
def test_some_places_answered(folder, shape, kept):
    study = studied(shape)
    count = len(study.accuracy.codes)
    gone = np.arange(count) % 2 == 1 if kept == "half" else np.arange(count) != count // 2
    lost = holed(study, gone)
    text = told(write(lost, folder).read_text(encoding="utf-8"))
    assert f"{(lost.accuracy.codes == Code.INFEASIBLE).sum()} of {count} places: no tensions within the limits" in text
    assert not has_nan(text)
    assert all(is_drawn(path) for path in folder.glob("*.png"))


@pytest.mark.usefixtures("undrawn_here")
def test_warnings(folder):
    study = studied("helix")
    spread = study.accuracy.spread
    spread = dataclasses.replace(
        spread, nonlinearity=np.full_like(spread.nonlinearity, 0.062), unsolved=np.ones_like(spread.unsolved)
    )
    rules = (SheaveRule("south-west", 12.5, 20.0, holds=False), SheaveRule("north-west", 25.0, 20.0, holds=True))
    found = dataclasses.replace(study.accuracy, spread=spread, method="first-order")
    changed = dataclasses.replace(study, accuracy=found, rules=rules)
    text = told(write(changed, folder).read_text(encoding="utf-8"))
    assert "First order deviates by up to 6.2 % of the spread" in text
    assert f"{len(spread.unsolved)} solves have no sound equilibrium and are left out" in text
    assert "not over 20 times that of the cable, which wears it: south-west (12.5)" in text
    assert "north-west (25)" not in text


@pytest.mark.usefixtures("undrawn_here")
def test_small_ranges_need_no_warning(folder):
    robot = load("house-printer")
    page = write(studied("path", ranges=modulus_ranges(robot, 0.99, 1.01)), folder).read_text(encoding="utf-8")
    assert 'class="notice"' not in page


@pytest.mark.usefixtures("undrawn_here")
def test_samples_have_a_likely_error(folder):
    text = told(write(studied("path", method=MonteCarlo(200)), folder).read_text(encoding="utf-8"))
    assert "error of 95 % of samples" in text


def test_one_uncertain_number(folder):
    robot = load("house-printer")
    found = accuracy(robot, [1.0, 0.5, 1.5], modulus_ranges(robot)[:1])
    text = told(write_place(found, folder).read_text(encoding="utf-8"))
    assert "one parameter is uncertain" in text
    assert "region of the corners 0 mm^3" in text
    assert is_drawn(folder / "region.png")


@pytest.mark.parametrize("axes", some([3, 0, 2, 1], 2))
def test_region_of_any_dimension(axes):
    points = np.random.default_rng(1).normal(size=(40, 3)) * 1e-3
    points[:, axes:] = 0.0
    points = points[:1] if axes == 0 else points
    found = Region(np.array([0.0, 0.0, 1e-4]), np.zeros(3), points, np.zeros((len(points), 1)), hull_of(points), None)
    with style.drawing():
        assert style.png(region_picture(found)).startswith(b"\x89PNG")
        assert style.png(region_picture(found, points[::2])).startswith(b"\x89PNG")


def test_wanted_place_is_reported_where_it_is_too_far_to_draw():
    found = placed().region
    far = dataclasses.replace(found, wanted=found.nominal + np.array([0.0, 0.0, 0.5]))
    near = dataclasses.replace(found, wanted=found.nominal + np.array([0.0, 0.0, 1e-3]))
    with style.drawing():
        assert "500\N{NO-BREAK SPACE}mm from the nominal one" in region_picture(far).get_supxlabel()
        drawn = region_picture(near)
    assert drawn.get_supxlabel() == ""
    assert "commanded place" in [text.get_text() for text in drawn.legends[0].get_texts()]


def test_most_important_numbers_come_first_and_are_twenty():
    robot = load("cogiro")
    ranges = modulus_ranges(robot)
    wide = tuple(dataclasses.replace(one, low=one.low - 0.01 * k) for k, one in enumerate(ranges * 4))
    found = nozzle_errors(robot, [0.0, 0.0, 1.5, 0.0, 0.0, 0.0], ranges)
    effects = np.tile(found.spread.effects, (1, 1, 4)) * np.linspace(1.0, 2.0, 32)
    spread = dataclasses.replace(found.spread, effects=effects, worst_values=np.tile(found.spread.worst_values, 4))
    found = dataclasses.replace(found, ranges=wide, spread=spread)
    with style.drawing():
        axes = contributions(found).axes[0]
    lengths = [bar.get_width() for bar in axes.patches[:20]]
    assert len(axes.get_yticklabels()) == 20
    assert lengths == sorted(lengths, reverse=True)
    assert lengths[0] == pytest.approx(np.linalg.norm(effects[0], axis=0).max() * 1e3)


def test_axes_of_the_parts_of_an_error():
    with style.drawing():
        level = along(studied("path")).axes[-1]
        rising = along(studied("helix")).axes[-1]
    assert level.get_xlabel() == "distance along the path in m"
    assert rising.get_ylabel() == "height of the nozzle in m"


def test_displacement_is_exaggerated_by_a_round_number():
    study = studied("helix")
    times = displaced_by(study)
    assert float(f"{times:.0e}"[0]) in {1.0, 2.0, 5.0}
    largest = np.nanmax(np.linalg.norm(study.accuracy.worst_offset, axis=1)) * times
    size = np.linalg.norm(np.ptp(study.places.positions, axis=0))
    assert 0.04 * size < largest <= 0.12 * size * (1 + 1e-9)


def test_thinned_path_keeps_its_worst_place():
    errors = np.sin(np.arange(10_000.0))
    errors[4321], errors[77:200] = 5.0, np.nan
    kept = _worst_of_each(errors, 100)
    assert 4321 in kept
    assert len(kept) <= 101
    assert (np.diff(kept) > 0).all()
    assert kept[0] == 0
    assert kept[-1] == 9999


def test_stretches_hold_all_values():
    at = np.random.default_rng(0).uniform(0.0, 3.0, 5000)
    places, low, middle, high = _binned(at, at**2, 10)
    assert len(places) == 10
    assert (low <= middle).all()
    assert (middle <= high).all()
    assert low[0] == pytest.approx((at**2).min())
    assert high[-1] == pytest.approx((at**2).max())


def test_no_workspace_no_picture():
    with style.drawing():
        assert workspace_errors(studied("helix")) is None


def test_surfaces_are_drawn_over_holes():
    study = studied("plane")
    with style.drawing():
        assert style.png(plane(holed(study, np.arange(len(study.accuracy.codes)) % 3 == 0))).startswith(b"\x89PNG")


def test_a_folder_that_is_not_there_cannot_be_written(folder):
    with pytest.raises(EnvironmentFault, match=r"nowhere/.*: cannot be written: No such file"):
        write(studied("path"), folder / "nowhere")
