"""Jobs: TOML in, one line out where it is wrong."""

import pytest

from cablewright.foundation.errors import InputError
from cablewright.printing.job import Bead, Job, Motion, Sampling, load_job

GOOD = """
schema = 1
name = "walls"
gcode = "part.gcode"
scale = 20
origin = [1, "50 cm", "20 mm"]
[bead]
width = "40 mm"
[motion]
travel_speed = "30 m/min"
[sampling]
step = 0.1
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "part.gcode").write_text("M83\nG1 X10 E1\nG2 X20 R5 E1\n")
    (tmp_path / "sub").mkdir()
    return tmp_path


def write(folder, text: str):
    file = folder / "job.toml"
    file.write_text(text)
    return file


def test_read(folder):
    job = load_job(write(folder, GOOD))
    assert job.gcode == folder / "part.gcode"
    assert (job.name, job.scale, job.origin) == ("walls", 20, (1, 0.5, 0.02))
    assert job.bead == Bead(width=0.04)
    assert job.motion == Motion(travel_speed=0.5)
    assert job.sampling == Sampling(step=0.1)
    assert hash(job) == hash(load_job(folder / "job.toml"))


def test_bare_gcode(folder):
    job = load_job(str(folder / "part.gcode"))
    assert job == Job(name="part", gcode=folder / "part.gcode")
    assert (job.scale, job.origin) == (1, (0, 0, 0))
    samples = job.samples(job.toolpath())
    assert samples.positions[-1] == pytest.approx([0.02, 0, 0])
    assert job.time_law(samples).duration > 0


def test_from_file_to_time(folder):
    job = load_job(write(folder, GOOD))
    samples = job.samples(job.toolpath())
    assert samples.positions[0] == pytest.approx([1, 0.5, 0.02])
    assert samples.positions[-1] == pytest.approx([1.4, 0.5, 0.02])
    assert samples.speed_limit == pytest.approx(0.3)
    assert job.time_law(samples).duration > samples.distance[-1] / 0.3


def test_where_the_gcode_may_be(folder):
    for place in ("./part.gcode", "sub/../part.gcode", str(folder / "part.gcode")):
        assert load_job(write(folder, GOOD.replace("part.gcode", place))).toolpath().layer_count == 1


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("schema = 1", "", "missing key 'schema'; write schema = 1"),
        ("schema = 1", "schema = 2", "schema = 2: written for a newer cablewright"),
        ("schema = 1", "schema = true", "schema = True: must be an integer from 1 to 1"),
        ("schema = 1", "schema = '1'", "schema = '1': must be an integer"),
        ('name = "walls"', "", "name: is missing"),
        ('name = "walls"', "nmae = 'x'", "nmae = 'x': unknown key; did you mean 'name'?"),
        ("width", "widht", "bead.widht = '40 mm': unknown key; did you mean 'width'?"),
        ('"40 mm"', '"40 kg"', "bead.width = '40 kg': must be a finite length"),
        ('"40 mm"', "0", "bead.width = 0: must be at least 1e-06"),
        ('"40 mm"', "nan", "bead.width = nan: must be a finite length"),
        ('"40 mm"', '"9**9**9 mm"', "bead.width = '9**9**9 mm': must be a finite length"),
        ('"30 m/min"', '"30 m"', "motion.travel_speed = '30 m': must be a finite speed"),
        ("scale = 20", "scale = -1", "scale = -1: must be at least 0.0001"),
        ("scale = 20", "scale = inf", "scale = inf: must be a finite number"),
        ("scale = 20", "scale = '20'", "scale = '20': must be a valid number"),
        ("scale = 20", "scale = true", "scale = True: must be a valid number"),
        ('[1, "50 cm", "20 mm"]', "[1, 2]", "origin[2]: is missing"),
        ('[1, "50 cm", "20 mm"]', "[1, 2, 3, 4]", "origin = [1, 2, 3, 4]: "),
        ('"20 mm"', '"x"', "origin[2] = 'x': must be a finite length"),
        ('"part.gcode"', "3", "gcode = 3: "),
        ('"part.gcode"', '"none.gcode"', "gcode = 'none.gcode': no such file"),
        ('"part.gcode"', '"sub"', "gcode = 'sub': no such file"),
        ('"part.gcode"', '""', "gcode = '': no such file"),
        ('"part.gcode"', '"a\\u0000b"', "no such file"),
        ('"part.gcode"', '"../part.gcode"', "leaves the folder of the job; a file within it, or a full path"),
        ('"part.gcode"', '"sub/../../part.gcode"', "leaves the folder"),
        ('"20 mm"', "1e7", "origin[2] = 10000000.0: must be at most 1e+06"),
        ('"30 m/min"', "1e20", "motion.travel_speed = 1e+20: must be at most 1000"),
        ('"30 m/min"', "1e300", "motion.travel_speed = 1e+300: must be at most 1e+30 m/s"),
        ("[bead]", "[bead", "not TOML"),
    ],
)
def test_one_line_says_what_is_wrong(old, new, message, folder):
    assert old in GOOD
    file = write(folder, GOOD.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_job(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_bare_file_that_is_not_there(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        load_job(tmp_path / "none.gcode").toolpath()
    with pytest.raises(InputError, match="no such file"):
        load_job(tmp_path / "none.toml")
