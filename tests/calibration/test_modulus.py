"""A tensile test judged: laws that hold for every specimen, and specimens whose figures are known in closed form."""

from __future__ import annotations

import math
import random
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cablewright.calibration.tensile import recording
from cablewright.calibration.tensile.modulus import modulus as young_modulus
from cablewright.calibration.tensile.recording import TensileTest, read_test
from cablewright.foundation.errors import InputError
from cases import some

ROOT = Path(__file__).resolve().parents[2]
LENGTH, SECTION, BREAKING = 2.0, 12.566370614359172e-6, 10290.0
LOW, HIGH = 0.05 * BREAKING, 0.5 * BREAKING
TOP = 6000.0  # N
GIVEN = {"initial_length": LENGTH, "section": SECTION, "breaking_load": BREAKING}


def there_and_back(cycles: int = 1, samples: int = 200, top: float = TOP) -> np.ndarray:
    ramp = np.linspace(0.0, top, samples)
    return np.tile(np.concatenate([ramp, ramp[::-1]]), cycles)


def linear(force: np.ndarray, modulus: float = 102.2e9) -> TensileTest:
    """A specimen of which each metre at the lower load stretches in proportion: the law of Eq. 22."""
    per_newton = LENGTH / (SECTION * modulus - LOW)  # so that initial length + elongation at LOW is l_init
    return TensileTest(force, force * per_newton)


class Rayleigh:
    """Friction between wires after Rayleigh: from each turning point on, compliance grows in proportion to the way.

    Loading takes x/k + b x^2, unloading gives y/k + b y^2, x and y counted from its beginning; loops close.
    """

    def __init__(self, k: float = 640e3, share: float = 0.15, top: float = TOP) -> None:
        self.k, self.b, self.top = k, share / (k * top), top

    def loading(self, x: np.ndarray | float) -> np.ndarray | float:
        return x / self.k + self.b * x * x

    def unloading(self, x: np.ndarray | float) -> np.ndarray | float:
        return self.loading(self.top) - self.loading(self.top - x)

    def test(self, cycles: int = 1, samples: int = 4000, settling: float = 0.0) -> TensileTest:
        """The first loading takes ``settling`` (m) more and keeps it."""
        x = np.linspace(0.0, self.top, samples)
        force, elongation = [], []
        for cycle in range(cycles):
            kept = settling * x / self.top if cycle == 0 else settling
            force += [x, x[::-1]]
            elongation += [self.loading(x) + kept, self.unloading(x[::-1]) + settling]
        return TensileTest(np.concatenate(force), np.concatenate(elongation))

    def secant(self, curve) -> float:
        low, high = float(curve(LOW)), float(curve(HIGH))
        return (LENGTH + low) * (HIGH - LOW) / (SECTION * (high - low))

    def hysteresis(self) -> float:
        def loop(x: float) -> float:  # integral of unloading - loading = 2 b x (top - x)
            return 2 * self.b * (self.top * x * x / 2 - x**3 / 3)

        def work(x: float) -> float:  # integral of x d(loading)
            return x * x / (2 * self.k) + 2 * self.b * x**3 / 3

        return (loop(HIGH) - loop(LOW)) / (work(HIGH) - work(LOW))


@given(modulus=st.floats(1e9, 5e11), cycles=st.integers(1, 3), samples=st.integers(60, 300))
def test_a_linear_specimen_gives_its_modulus(modulus: float, cycles: int, samples: int) -> None:
    found = young_modulus(linear(there_and_back(cycles, samples), modulus), **GIVEN)
    assert found.modulus == pytest.approx(modulus, rel=1e-12)
    assert found.loading == pytest.approx((modulus,) * cycles, rel=1e-12)
    assert found.unloading == pytest.approx((modulus,) * cycles, rel=1e-12)
    assert found.branch_factors == pytest.approx((1, 1), rel=1e-12)
    assert found.tangent_factors == pytest.approx((1, 1), rel=1e-9)
    assert found.modulus_range == (1.0, 1.0)
    assert found.hysteresis == pytest.approx((0,) * cycles, abs=1e-9)
    assert found.permanent_set == pytest.approx((0,) * (cycles - 1), abs=1e-12)
    assert found.r_squared == pytest.approx(1, abs=1e-12)
    assert found.cycles == cycles


def test_the_length_is_that_at_the_lower_load() -> None:
    """Eq. 22: l_init is the cable's length at 5 % of the breaking load."""
    test = linear(there_and_back())
    found = young_modulus(test, **GIVEN)
    assert found.length == pytest.approx(LENGTH + np.interp(LOW, test.force[:200], test.elongation[:200]), rel=1e-12)
    assert found.modulus == found.length * (HIGH - LOW) / (SECTION * found.stretch)
    assert found.axial_stiffness == found.modulus * SECTION


def test_scales() -> None:
    test = Rayleigh().test(2)
    one = young_modulus(test, **GIVEN)
    double = young_modulus(test, **GIVEN | {"section": 2 * SECTION})
    assert double.modulus == pytest.approx(one.modulus / 2, rel=1e-12)
    assert double.axial_stiffness == pytest.approx(one.axial_stiffness, rel=1e-12)
    assert double.tangent_factors == pytest.approx(one.tangent_factors, rel=1e-12)
    longer = TensileTest(test.force, 3 * test.elongation)
    assert young_modulus(longer, **GIVEN | {"initial_length": 3 * LENGTH}).modulus == pytest.approx(
        one.modulus, rel=1e-12
    )
    stronger = TensileTest(2 * test.force, test.elongation)
    twice = young_modulus(stronger, **GIVEN | {"breaking_load": 2 * BREAKING})
    assert twice.modulus == pytest.approx(2 * one.modulus, rel=1e-12)
    assert twice.hysteresis == pytest.approx(one.hysteresis, rel=1e-9)


@pytest.mark.parametrize("share", [0.0, 0.05, 0.15, 0.3])
def test_friction_in_closed_form(share: float) -> None:
    law = Rayleigh(share=share)
    found = young_modulus(law.test(2), **GIVEN)
    assert found.modulus == pytest.approx(law.secant(law.loading), rel=1e-6)
    assert found.unloading == pytest.approx((law.secant(law.unloading),) * 2, rel=1e-6)
    assert found.hysteresis == pytest.approx((law.hysteresis(),) * 2, abs=1e-6)
    assert found.permanent_set == pytest.approx((0,), abs=1e-12)


def test_tangents_in_closed_form() -> None:
    """Of a quadratic, a least-squares slope over a window is very nearly the slope at its middle."""
    law = Rayleigh(share=0.15)
    (up, down) = young_modulus(law.test(), **GIVEN).branches
    assert up.rising
    assert not down.rising
    x = up.tangent_forces
    scale = (LENGTH + up.ends[0]) / SECTION
    assert up.tangents == pytest.approx(scale / (1 / law.k + 2 * law.b * x), rel=2e-3)
    scale = (LENGTH + down.ends[0]) / SECTION
    assert down.tangents == pytest.approx(scale / (1 / law.k + 2 * law.b * (TOP - down.tangent_forces)), rel=2e-3)
    assert up.force[0] >= LOW
    assert up.force[-1] <= HIGH


def test_the_settled_cycle_is_nominal() -> None:
    law = Rayleigh()
    found = young_modulus(law.test(3, settling=1e-3), **GIVEN)
    assert found.loading[0] < found.loading[1]
    assert found.modulus == found.loading[2] == pytest.approx(found.loading[1], rel=1e-9)
    expected = 1e-3 * (1 - LOW / TOP)  # what the first loading has not yet taken at the lower load
    assert found.permanent_set == pytest.approx((expected, 0.0), abs=1e-9)
    assert found.branch_factors[0] == pytest.approx(found.loading[0] / found.modulus, rel=1e-12)
    assert found.notes == ()


@pytest.mark.parametrize("seed", some(range(5)))
def test_noise(seed: int) -> None:
    """Noise of 0.3 % of the breaking load and of 5 um neither cuts branches nor moves the modulus by 1 %."""
    law, rng = Rayleigh(), np.random.default_rng(seed)
    clean = law.test(3, samples=1500)
    noisy = TensileTest(
        clean.force + rng.normal(0, 0.003 * BREAKING, len(clean.force)),
        clean.elongation + rng.normal(0, 5e-6, len(clean.force)),
    )
    found, exact = young_modulus(noisy, **GIVEN), young_modulus(clean, **GIVEN)
    assert found.cycles == 3
    assert found.modulus == pytest.approx(exact.modulus, rel=0.01)
    assert found.hysteresis == pytest.approx(exact.hysteresis, abs=0.01)
    assert found.tangent_factors == pytest.approx(exact.tangent_factors, abs=0.05)


def test_dwells_change_nothing() -> None:
    """Waiting at the top and at the bottom, with creep and noise, is outside the band."""
    rng = np.random.default_rng(1)
    test = Rayleigh().test(2, samples=500)
    force, elongation = test.force.reshape(4, -1), test.elongation.reshape(4, -1)
    creep = np.linspace(0, 1e-4, 300)
    parts_f, parts_e = [], []
    for f, e, up in zip(force, elongation, (True, False, True, False), strict=True):
        parts_f += [f, f[-1] + rng.normal(0, 5.0, 300)]
        parts_e += [e + (0 if up else 1e-4), e[-1] + (creep if up else np.full(300, 1e-4))]
    found = young_modulus(TensileTest(np.concatenate(parts_f), np.concatenate(parts_e)), **GIVEN)
    exact = young_modulus(test, **GIVEN)
    assert found.cycles == 2
    assert found.modulus == pytest.approx(exact.modulus, rel=1e-9)


def test_a_preload_and_half_cycles_are_not_branches_of_the_band() -> None:
    half = there_and_back(1, 100, top=0.3 * BREAKING)
    found = young_modulus(linear(np.concatenate([half, there_and_back(2)])), **GIVEN)
    assert found.cycles == 2
    assert found.partial == 2
    assert found.modulus == pytest.approx(102.2e9, rel=1e-12)


def test_a_break_at_the_end_is_left_out_and_reported() -> None:
    pull = np.linspace(0, 0.98 * BREAKING, 300)
    test = linear(np.concatenate([there_and_back(2), pull, np.zeros(5)]))
    found = young_modulus(test, **GIVEN)
    assert len(found.loading) == 3
    assert len(found.unloading) == 2
    assert "unloading from sample" in found.notes[0]
    assert "left out: 0 samples within the band" in found.notes[0]


def test_a_false_sample_cannot_pass_for_a_branch() -> None:
    """The load cell reads zero once in mid-loading: what follows would reach over the band with too little stretch."""
    good = linear(there_and_back(3, 400))
    force = good.force.copy()
    force[1600 + 120] = 0.0
    found = young_modulus(TensileTest(force, good.elongation), **GIVEN)
    assert len(found.loading) == 2
    assert "force jumps by" in found.notes[0]
    assert found.modulus == pytest.approx(102.2e9, rel=1e-12)


def test_notes_for_the_careful() -> None:
    once = young_modulus(linear(np.linspace(0, TOP, 100)), **GIVEN)
    assert once.cycles == 0
    assert once.unloading == once.hysteresis == once.permanent_set == ()
    assert any("one full loading only" in note for note in once.notes)
    assert any("no full unloading" in note for note in once.notes)
    settling = young_modulus(Rayleigh().test(2, settling=1e-3), **GIVEN)
    assert "not settled" in settling.notes[0]
    test = linear(there_and_back(2))
    moved = young_modulus(TensileTest(test.force, test.elongation + 0.5), **GIVEN)
    assert "is it zero where the initial length was measured?" in moved.notes[0]


def test_another_band() -> None:
    law = Rayleigh()
    test = law.test(samples=20000)
    found = young_modulus(test, **GIVEN, band=(0.1, 0.3))
    low, high = law.loading(0.1 * BREAKING), law.loading(0.3 * BREAKING)
    assert found.modulus == pytest.approx((LENGTH + low) * 0.2 * BREAKING / (SECTION * (high - low)), rel=1e-6)


def ramp(change=lambda force, elongation: (force, elongation)) -> TensileTest:
    test = linear(there_and_back(2))
    return TensileTest(*change(test.force.copy(), test.elongation.copy()))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda f, e: (0.8 * f, e), "the highest 4800 N, 46.65 % of the breaking load"),
        (lambda f, e: (f + 600, e), "the lowest load is 600 N"),
        (lambda f, e: (f[200:400], e[200:400]), "there are only unloadings"),
        (lambda f, e: (-f, e), "tension must be positive"),
        (lambda f, e: (-f, -e), "tension must be positive"),
        (lambda f, e: (f, -e), "elongation does not rise with force"),
        (lambda f, e: (f, 0 * e), "elongation does not rise with force"),
        (lambda f, e: (f[::20], e[::20]), "samples within the band; at least 20"),
        (lambda f, e: (f, np.where(f > 0.5 * TOP, e + 4e-3, e)), "elongation jumps by"),
        (lambda f, e: (f, np.where(abs(f - 2500) < 400, 5e-3 - e, e)), "is left out"),
        (lambda f, e: (1e3 * f, e), "over twice the breaking load"),
        (lambda f, e: (f, 1e3 * e), "check the units of elongation"),
        (lambda f, e: (f, 1e-3 * e), "modulus = 1.0"),
        (lambda f, e: (f + 0 * f[0], e[:-1]), "800 forces, but 799 elongations"),
        (lambda f, e: (f[:19], e[:19]), "19 samples; at least 20"),
        (lambda f, e: (np.append(f[1:], np.nan), e), "sample 800: force = nan: must be finite"),
        (lambda f, e: (f, np.append(np.inf, e[1:])), "sample 1: elongation = inf: must be finite"),
        (lambda f, e: (np.append(1e10, f[1:]), e), "sample 1: force = 1e+10: must be finite and at most 1e+09 N"),
        (lambda f, e: (f[None], e), "one number for each sample"),
    ],
)
def test_recordings_that_say_nothing(change, says: str) -> None:
    with pytest.raises(InputError) as refused:
        young_modulus(ramp(change), **GIVEN)
    assert says in str(refused.value)


def test_a_specimen_that_slips() -> None:
    """Elongation runs on while the force falls a little: no cable does that."""

    force = np.concatenate([np.linspace(0, 1600, 80), np.linspace(1600, 1300, 90), np.linspace(1300, TOP, 230)])
    with pytest.raises(InputError, match="has it slipped"):
        young_modulus(TensileTest(force, 3e-5 * np.arange(len(force))), **GIVEN)


@pytest.mark.parametrize("name", ["initial_length", "section", "breaking_load"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, 1e-300, 1e300])
def test_arguments_out_of_bounds(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name.replace("_", " ")):
        young_modulus(ramp(), **GIVEN | {name: value})


@pytest.mark.parametrize("band", [(0.0, 0.5), (0.5, 0.5), (0.5, 0.05), (0.05, 1.1), (math.nan, 0.5), (0.05, math.nan)])
def test_bands_out_of_bounds(band: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="band"):
        young_modulus(ramp(), **GIVEN, band=band)


def test_a_section_in_the_wrong_unit() -> None:
    with pytest.raises(InputError, match=r"section = 12\.57 m\^2: must be over 0, from"):
        young_modulus(ramp(), **GIVEN | {"section": 12.57})


@settings(max_examples=200)
@given(st.lists(st.tuples(st.floats(-100, 7000), st.floats(-0.01, 0.02)), min_size=20, max_size=120))
def test_whatever_was_recorded(points: list[tuple[float, float]]) -> None:
    """A result whose figures hang together, or one line."""
    force, elongation = map(np.array, zip(*points, strict=True))
    try:
        found = young_modulus(TensileTest(force, elongation), **GIVEN)
    except InputError:  # one line, by its constructor
        return
    assert found.modulus > 0
    assert found.branch_factors[0] <= 1 <= found.branch_factors[1]


# The reader.


def written(tmp_path: Path, text: str | bytes) -> Path:
    path = tmp_path / "test.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def table(header: str, row: str = "{f},{e}", force: float = 1.0, elongation: float = 1.0) -> str:
    test = linear(there_and_back(1, 50))
    rows = [
        row.format(f=repr(float(f)), e=repr(float(e)))
        for f, e in zip(test.force * force, test.elongation * elongation, strict=True)
    ]
    return "\n".join([header, *rows]) + "\n"


@pytest.mark.parametrize(
    ("header", "row", "force", "elongation"),
    [
        ("force,elongation", "{f},{e}", 1, 1),
        ("elongation,force", "{e},{f}", 1, 1),
        ("time,force (kN),note,elongation (mm)", "0,{f},grip left,{e}", 1e-3, 1e3),
        ("Force [N];Elongation [um]", "{f};{e}", 1, 1e6),
        ("FORCE_kN\tELONGATION_mm", "{f}\t{e}", 1e-3, 1e3),
        ('"force ( kN )" , "elongation"', ' "{f}" , {e} ', 1e-3, 1),
        ("force_rate,force,elongation", "nonsense,{f},{e}", 1, 1),
        ("force/kN;elongation mm;", "{f};{e};", 1e-3, 1e3),
        ("\ufeff# a comment\n\n  # another\r\nforce,elongation", "{f},{e}", 1, 1),
    ],
)
def test_how_columns_are_written_does_not_matter(tmp_path, header, row, force, elongation) -> None:
    plain = read_test(written(tmp_path, table("force,elongation")))
    other = read_test(written(tmp_path, table(header, row, force, elongation)))
    assert other.force == pytest.approx(plain.force, rel=1e-12)
    assert other.elongation == pytest.approx(plain.elongation, rel=1e-12)
    assert young_modulus(other, **GIVEN).modulus == pytest.approx(102.2e9, rel=1e-12)


def test_lines_are_those_of_the_file(tmp_path) -> None:
    test = read_test(written(tmp_path, "# made\n" + table("force,elongation").replace("\n", "\r\n\r\n")))
    assert list(test.lines[:3]) == [4, 6, 8]
    assert test.place(0) == "line 4"
    with pytest.raises(ValueError, match="read-only"):
        test.force[0] = 1.0


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "empty; expected a header with columns force and elongation"),
        ("# only words\n\n", "empty"),
        (
            "time,elongation\n1,2",
            "line 1: no column 'force', also called load, tensile force, tensile load, standard force, (a unit may",
        ),
        ("forse,elongation\n1,2", "is it 'forse'? then call that 'force'"),
        ("force,elongatoin\n1,2", "is it 'elongatoin'? then call that 'elongation'"),
        ("force,way\n1,2", "no column 'elongation'"),
        ("Time,Weg\n1,2", "the header has 'Time', 'Weg'"),
        ("Time,Load cell,Crosshead extension\n1,2,3", "is it 'Load cell'? then call that 'force'"),
        ("load,Crosshead extension\n1,2", "is it 'Crosshead extension'? then call that 'elongation'"),
        ("load,extension,displacement\n1,2,3", "more than one column 'elongation': 'extension' and 'displacement'"),
        ("load,strain (%)\n1,2", "no column 'elongation'"),  # of a specimen of unknown length
        ("1,2\n3,4", "line 1: no column 'force'"),
        ("force (lbf),elongation", "column 'force (lbf)': unknown unit 'lbf'"),
        ("force (KN),elongation", "unknown unit 'KN'"),
        ("force_GN,elongation", "no column 'force'"),
        ("force,force (kN),elongation", "more than one column 'force': 'force' and 'force (kN)'; keep one"),
        ("force,elongation\n1,2\n3", "line 3: 1 cells; the header has 2"),
        ("force,elongation\n1,2,3", "line 2: 3 cells; the header has 2"),
        ("force;elongation\n1,5;2,5", "line 2: force = '1,5': must be a finite number, with a decimal point"),
        ("force,elongation\nN,mm", "0 samples; at least 20 are required"),
        ("force (N),elongation\nN,mm", "column 'force (N) (N)': unknown unit"),
        ("force,elongation\n1,", "line 2: elongation = '': must be"),
        ("force,elongation\n1,nan", "elongation = 'nan'"),
        ("force,elongation\n1,inf", "elongation = 'inf'"),
        ("force,elongation\n1_0,1", "force = '1_0'"),
        ("force,elongation\n\u0661,1", "force = '\u0661'"),
        ("force,elongation\n1 kN,1", "force = '1 kN'"),
        ("force,elongation\n0x10,1", "force = '0x10'"),
        ("force,elongation\n__import__('os'),1", "force = \"__import__('os')\""),
        ("force,elongation\n" + "9" * 100 + "x,1", "999...'"),
        ("force,elongation\n1,2\n1,2", "2 samples; at least 20"),
        ("force,elongation\n" + 20 * "1,2\n" + "1e999,2", "line 22: force = inf: must be finite"),
        ("force,elongation\n" + 20 * "1,2\n" + "1,-1e6", "line 22: elongation = -1e+06: must be finite and at most"),
        ("force,elongation\n" + "1" * 5000, "line 2: longer than 4096 bytes"),
        (b"force,elongation\n\xff,1", "line 2: not UTF-8"),
        ("force,elongation\n1,2".encode("utf-16"), "line 1: not UTF-8"),
        (b"force,elongation\n\0,1", "force = '\\x00'"),
    ],
)
def test_files_that_are_none(tmp_path, text, says: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(InputError) as refused:
        read_test(path)
    assert str(refused.value).startswith(str(path))
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


def test_files_that_are_not_there(tmp_path) -> None:
    for path, says in ((tmp_path / "no.csv", "no such file"), (tmp_path, "not a regular file"), ("a\0b", "a.*b")):
        with pytest.raises(InputError, match=says):
            read_test(path)


def test_files_that_are_too_large(tmp_path, monkeypatch) -> None:
    path = written(tmp_path, table("force,elongation"))
    monkeypatch.setattr(recording, "MAX_ROWS", 99)
    with pytest.raises(InputError, match="line 101: more than 99 rows"):
        read_test(path)
    monkeypatch.setattr(recording, "MAX_BYTES", 1000)
    with pytest.raises(InputError, match="larger than 1000 bytes"):
        read_test(path)


CELL = st.one_of(st.floats().map(repr), st.integers().map(str), st.text(max_size=4))
ROW = st.lists(CELL, max_size=4).map(",".join)
HEADER = st.sampled_from(["force,elongation", "force (kN);elongation_mm", "force\telongation", "forse,elongation", ""])


def judged(path: Path) -> None:
    try:
        test = read_test(path)
    except InputError:  # one line, by its constructor
        return
    assert test.force.shape == test.elongation.shape == (len(test.lines),)
    assert np.isfinite(test.force).all()
    assert np.isfinite(test.elongation).all()


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("fuzz") / "test.csv"


@given(data=st.binary(max_size=200))
def test_any_bytes(file: Path, data: bytes) -> None:
    file.write_bytes(data)
    judged(file)


@given(header=HEADER, rows=st.lists(ROW, max_size=6), mark=st.sampled_from(",;\t"))
def test_any_rows(file: Path, header: str, rows: list[str], mark: str) -> None:
    text = "\n".join([header, *rows, *(30 * [f"1{mark}2"])])
    file.write_bytes(text.encode("utf-8", "surrogatepass"))
    judged(file)


@given(wound=st.binary(max_size=8), at=st.integers(0, 400))
def test_a_good_file_with_a_wound(file: Path, wound: bytes, at: int) -> None:
    good = table("force,elongation").encode()
    file.write_bytes(good[:at] + wound + good[at:])
    judged(file)


# The example.


def example() -> str:
    """The rule of examples/tensile.csv."""
    rng, top, preload = random.Random(2021), 6.0, 0.1  # kN
    way = top - preload
    title = "# Synthetic, no machine has measured this: the rule is in tests/calibration/test_modulus.py."

    def wires(x: float) -> float:
        return 1.34 * (x + 0.15 * x * x / way)

    lines = [title, "time (s),force (kN),elongation (mm)"]
    for cycle in range(3):
        for step in range(131):
            up, down = min(step, 65) / 65, max(step - 65, 0) / 65
            x = way * (up - down)
            friction = wires(x) if step <= 65 else wires(way) - wires(way - x)
            bedding = 0.25 * (1 - math.exp(-x / 0.8))
            settled = 0.6 * up if cycle == 0 else 0.6
            force = preload + x + rng.gauss(0, 0.008)
            elongation = friction + bedding + settled + rng.gauss(0, 0.002)
            lines.append(f"{131 * cycle + step},{force:.3f},{elongation:.3f}")
    return "\n".join(lines) + "\n"


def test_the_example_follows_its_rule() -> None:
    assert (ROOT / "examples" / "tensile.csv").read_text() == example()


def test_the_example_is_the_cable_of_the_paper() -> None:
    found = young_modulus(read_test(ROOT / "examples" / "tensile.csv"), **GIVEN)
    assert found.modulus == pytest.approx(102.2e9, rel=0.01)
    assert found.cycles == 3
    assert found.notes == ()


MACHINES = (  # header, units below it; size of the written number in the unit, N and m
    ("Time,Extension,Load", "(s),(mm),(kN)", 1e-3, 1e3),
    ('"Time","Extension","Load"', '"(s)","(mm)","(N)"', 1.0, 1e3),
    ("Time,Displacement,Force", "s,mm,kN", 1e-3, 1e3),
    ("Test time [s],Tensile extension [mm],Tensile load [kN]", "", 1e-3, 1e3),
    ("Time,Elongation,Standard force", "s,m,N", 1.0, 1.0),
    ("Time,Strain,Load", "[-],[%],[N]", 1.0, 100.0 / 2.0),
    ("Time (s),Strain (mm/mm),Load (N)", "", 1.0, 1.0 / 2.0),
)


@pytest.mark.parametrize("machine", MACHINES, ids=lambda machine: machine[0])
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_headers_of_testing_machines_give_the_same_numbers(tmp_path: Path, machine, separator: str) -> None:
    header, units, of_force, of_elongation = machine
    force, elongation = np.linspace(80.0, 900.0, 40), np.linspace(0.002, 0.0225, 40)
    quote = '"' if header.startswith('"') else ""
    rows = [
        ",".join(f"{quote}{cell!r}{quote}" for cell in row)
        for row in zip(range(40), (elongation * of_elongation).tolist(), (force * of_force).tolist(), strict=True)
    ]
    lines = [header, *([units] if units else []), *rows]
    path = written(tmp_path, "\n".join(lines).replace(",", separator))
    read = read_test(path, gauge=2.0)
    np.testing.assert_allclose(read.force, force, rtol=1e-12)
    np.testing.assert_allclose(read.elongation, elongation, rtol=1e-12)


def test_strain_without_a_unit_is_rejected(tmp_path: Path) -> None:
    path = written(tmp_path, "load,strain\n" + "1,2\n" * 30)
    with pytest.raises(InputError, match=r"column 'strain': give its unit"):
        read_test(path, gauge=1.0)


def test_force_counts_before_what_machines_call_it(tmp_path: Path) -> None:
    path = written(tmp_path, "force,load,elongation\n" + "1,9,3\n" * 30)
    assert (read_test(path).force == 1.0).all()
