"""The report as a file: whole, self-contained, the same each time, and right for checks of every kind."""

import base64
import dataclasses
import hashlib
import html
import json
import re

import matplotlib as mpl
import numpy as np
import pytest

from apps.report.synthetic import (
    SPIRE,
    arrays_of,
    changed,
    first_sample,
    house_check,
    make_check,
    ring_robot,
    small_job,
)
from cablewright.apps.report.check import write
from cablewright.apps.report.document import script
from cablewright.foundation.errors import EnvironmentFault
from cablewright.robot import load
from cases import some

SOLVED = ("uncompensated", "compensated", "elastic_only", "tensions", "lowest_tension", "highest_tension")
SOLVED += ("lengths", "winch_speed")
PICTURES = {"plan.png", "path-3d.png", "tensions.png", "error-height.png", "limits.png", "motion.png"}


def page_of(checked, folder) -> str:
    check, layers = checked
    return write(check, folder, layers).read_text(encoding="utf-8")


def told(page: str) -> str:
    """What a reader reads: no pictures, no scripts, no markup."""
    page = re.sub(r"<(script|style)\b.*?</\1>|</?a\b[^>]*>", "", page, flags=re.DOTALL)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]*>", " ", page)))


def page_in(folder) -> str:
    return (folder / "report.html").read_text(encoding="utf-8")


def test_report_and_pictures_are_written_whole(written):
    assert {path.name for path in written.iterdir()} == PICTURES | {"report.html"}
    for name in PICTURES:
        assert (written / name).read_bytes().startswith(b"\x89PNG")


def test_pictures_are_in_the_page(written):
    page = page_in(written)
    embedded = {base64.b64decode(data) for data in re.findall(r'src="data:image/png;base64,([^"]+)"', page)}
    assert embedded == {(written / name).read_bytes() for name in PICTURES}
    assert all(alt for alt in re.findall(r'alt="([^"]*)"', page))


def test_nothing_is_asked_of_any_other_place(written):
    page = page_in(written)
    own = page.replace(script(), "")  # three.js names specifications and its own pages
    assert "http://" not in own
    assert "https://" not in own
    assert not re.search(r'src="(?!data:)', page)
    assert not re.search(
        r'\bhref="(?!#)|<link|<base|<iframe|@import|url\(|fetch\(|XMLHttpRequest|import\(|WebSocket', page
    )


def test_policy_allows_exactly_the_script_and_style_of_the_page(written):
    page = page_in(written)
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', page)[1]
    assert policy.startswith("default-src 'none'; img-src data:;")
    style, script = (
        re.search(r"<style>(.*?)</style>", page, re.S)[1],
        re.search(r"<script>(.*?)</script>", page, re.S)[1],
    )
    for kind, text in (("style-src", style), ("script-src", script)):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"{kind} 'sha256-{digest}'" in policy


@pytest.mark.usefixtures("undrawn_here")
def test_foreign_text_is_escaped_everywhere(tmp_path, folder):
    evil = "</script><script>alert(1)</script>\"'&<b>"
    robot = ring_robot(4)
    line = robot.lines[0].model_copy(update={"name": evil})
    robot = robot.model_copy(
        update={"name": evil, "description": evil, "source": evil, "lines": (line, *robot.lines[1:])}
    )
    job = small_job(tmp_path).model_copy(update={"name": evil})
    check, layers = make_check(robot, job)
    check = dataclasses.replace(
        check, verdict=evil, not_checked=(evil,), toolpath=dataclasses.replace(check.toolpath, unknown={evil: 1})
    )
    check = dataclasses.replace(check, findings=(dataclasses.replace(check.findings[0], limit=evil, unit=evil),))
    page = page_of((check, layers), folder)
    assert "alert(1)" in page
    assert "<script>alert" not in page
    assert "<b>" not in page
    assert page.count("<script") == page.count("</script>") == 2  # the data and the program
    data = json.loads(re.search(r'id="scene">(.*?)</script>', page, re.S)[1])
    assert data["lines"][0]["name"] == evil


def test_names_that_a_font_or_mathematics_would_stumble_on(tmp_path, folder):
    robot = ring_robot(3)
    names = ("$\\frac{1}$ $x_", "北西 \x07 \u202e", "a" * 60)
    lines = tuple(line.model_copy(update={"name": name}) for line, name in zip(robot.lines, names, strict=True))
    write_all = make_check(robot.model_copy(update={"lines": lines}), small_job(tmp_path))
    assert "北西" in page_of(write_all, folder)


@pytest.mark.slow  # as in test_accuracy.py
def test_same_check_same_bytes(small, written, folder):
    check, layers = small
    assert write(check, folder, layers) == folder / "report.html"
    for path in written.iterdir():
        assert path.read_bytes() == (folder / path.name).read_bytes(), path.name


@pytest.mark.usefixtures("undrawn_here")
@pytest.mark.parametrize(("feasible", "word", "other"), [(True, "Can be", "Cannot be"), (False, "Cannot be", "Can be")])
def test_verdict_is_first_and_in_words(tmp_path, folder, feasible, word, other):
    check, layers = make_check(ring_robot(4), small_job(tmp_path), feasible=feasible)
    page = page_of((check, layers), folder)
    assert f'class="verdict {"yes" if feasible else "no"}"' in page
    text = told(page)
    assert f"{word} printed" in text
    assert f"{other} printed" not in text
    assert text.index(check.verdict) < text.index("extruded length")


def test_key_figures_are_those_of_the_check(small, written):
    check, _ = small
    text = told(page_in(written))
    assert "layers 3 " in text
    assert f"extruded length {check.samples.extruded_length:#.4g} m" in text
    assert f"max error without compensation {np.max(check.error_uncompensated) * 1e3:#.3g} mm" in text
    assert "expected error 7.00 mm" in text
    assert f"min tension {check.statics.lines.lowest_tension.min():#.4g} N" in text
    assert f"max tension {check.statics.lines.highest_tension.max():#.4g} N" in text


def test_what_is_not_known_is_said(written):
    text = told(page_in(written))
    assert "Not checked wind interference of lines: switched off" in text
    assert "max winch torque - " in text


@pytest.mark.usefixtures("undrawn_here")
def test_nothing_solved(small, folder):
    check, layers = small
    lost = {name: np.full_like(arrays_of(check)[name], np.nan) for name in SOLVED}
    check = changed(check, lost | {"codes": np.ones_like(check.codes)})
    text = told(page_of((check, layers), folder))
    assert "samples: the solver did not converge." in text
    assert "Not drawn: no error is known." in text
    assert "max error without compensation - " in text
    assert not (folder / "tensions.png").exists()


@pytest.mark.slow  # as with nothing solved, above
def test_half_of_it_solved(small, folder):
    check, layers = small
    gone = np.arange(len(check.samples)) % 2 == 0
    holed = {name: np.where(gone[:, None], np.nan, arrays_of(check)[name]) for name in SOLVED}
    check = changed(check, holed | {"codes": np.where(gone, 7, 0)})
    text = told(page_of((check, layers), folder))
    assert f"At {gone.sum()} of {len(gone)} samples: no tensions within the limits balance the load." in text
    assert "nan" not in text


@pytest.mark.parametrize("m", some([12, 1, 2, 4, 8, 64]))
def test_any_number_of_lines(tmp_path, folder, m):
    text = told(page_of(make_check(ring_robot(m), small_job(tmp_path)), folder))
    assert (f"Of {m} lines, the 8 with tensions nearest to their limits are drawn." in text) == (m > 8)
    assert f"line {m - 1}" in text  # the table has them all
    assert all((folder / name).stat().st_size < 300_000 for name in PICTURES)


@pytest.mark.usefixtures("undrawn_here")
def test_one_sample(small, folder):
    text = told(page_of(first_sample(*small), folder))
    assert "Not drawn: nothing is extruded." in text
    assert "<canvas" not in text


@pytest.mark.usefixtures("undrawn_here")
def test_lines_that_differ_are_distinguished(tmp_path, folder):
    mixed, plain = load("house-printer"), ring_robot(4)
    lines = (*mixed.lines[:2], *plain.lines[:2])
    text = told(page_of(make_check(mixed.model_copy(update={"lines": lines}), small_job(tmp_path)), folder))
    assert "through an eyelet, a fixed point (line 0, line 1)" in text


@pytest.mark.usefixtures("undrawn_here")
def test_one_long_layer_and_no_travel(tmp_path, folder):
    spiral = "".join(f"G1 X{500 * np.cos(a):.3f} Y{500 * np.sin(a):.3f} Z{a:.3f} E1\n" for a in np.linspace(0, 60, 900))
    text = told(page_of(make_check(ring_robot(4), small_job(tmp_path, "G21\nG90\nM83\nG1 F900\n" + spiral)), folder))
    assert "in each part of the path" in text


def test_settings_of_the_process_stay_as_they_were(small, folder):
    with mpl.rc_context({"font.size": 31, "text.usetex": True, "axes.grid": False}):
        before = dict(mpl.rcParams)
        page_of(small, folder)
        assert dict(mpl.rcParams) == before


@pytest.mark.usefixtures("undrawn_here")
def test_a_folder_that_is_not_there_cannot_be_written(small, folder):
    check, layers = small
    with pytest.raises(EnvironmentFault, match=r"nowhere/.*: cannot be written: No such file"):
        write(check, folder / "nowhere", layers)


@pytest.mark.usefixtures("undrawn_here")
def test_nothing_half_written_is_left(small, folder, monkeypatch):
    (folder / "plan.png").mkdir()  # a folder is not replaced by a file
    check, layers = small
    with pytest.raises(EnvironmentFault, match=r"plan\.png: cannot be written"):
        write(check, folder, layers)
    assert {path.name for path in folder.iterdir()} == {"plan.png"}


@pytest.mark.slow  # pages above are of smaller jobs; the house is checked in tests/studies/test_check.py
def test_house(folder):
    check, layers = house_check()
    text = told(page_of((check, layers), folder))
    assert "layers 140" in text
    assert "in each layer" in text
    assert "max winch torque" in text
    assert all((folder / name).stat().st_size < 300_000 for name in PICTURES)
    assert (folder / "report.html").stat().st_size < 3_000_000


def test_spire_is_what_the_small_check_prints(small):
    assert small[0].toolpath.layer_count == SPIRE.count(";LAYER")
