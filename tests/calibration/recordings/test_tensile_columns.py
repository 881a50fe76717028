"""Tensile tests with more than one column of elongation: the extensometer's, or an error of one line.

Oracle: EA is the slope of the force over the strain that made the columns.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.calibration.tensile.creep import creep
from cablewright.calibration.tensile.modulus import TensileResult, modulus
from cablewright.calibration.tensile.recording import read_test
from cablewright.foundation.errors import InputError

EA, LENGTH = 40e3, 0.8
FORCE = 500.0 * (1.0 - np.cos(np.pi * np.linspace(0.0, 6.0, 1200)))  # N, three cycles
STRAIN = FORCE / EA


def table(tmp_path: Path, **columns: np.ndarray) -> Path:
    path = tmp_path / "test.csv"
    rows = np.column_stack([*columns.values(), FORCE])
    text = "\n".join(",".join(f"{value:.7f}" for value in row) for row in rows.tolist())
    path.write_text(f"{','.join([*columns, 'Load (N)'])}\n{text}\n")
    return path


def judged(path: Path) -> TensileResult:
    return modulus(path, initial_length=LENGTH, section=3e-6, breaking_load=1.8e3)


@pytest.mark.parametrize("factor", [1.5, 0.7, 1.03])
@pytest.mark.parametrize("strain", ["Strain (%)", "Tensile strain (Strain 1) (%)", "Strain 1 [%]", "strain_%"])
@pytest.mark.parametrize("other", ["Extension (mm)", "Displacement (mm)"])
@pytest.mark.parametrize("first", [False, True])
def test_the_extensometer_counts(tmp_path: Path, factor: float, strain: str, other: str, first: bool) -> None:
    columns = {other: 1e3 * factor * LENGTH * STRAIN, strain: 100.0 * STRAIN}
    found = judged(table(tmp_path, **dict(list(columns.items())[:: -1 if first else 1])))
    low = LENGTH * (1.0 + 0.05 * 1.8e3 / EA)  # Eq. 22 has the length at the lower load
    assert found.axial_stiffness == pytest.approx(EA * low / LENGTH, rel=1e-3)
    (note,) = found.notes
    assert repr(strain) in note
    assert repr(other) in note
    assert f"{factor:.3g} times as large" in note


def test_frames_that_yield_are_no_constant_ratio(tmp_path: Path) -> None:
    """Grips that slip at first: the extension is no multiple of the strain."""
    slip = 1e-3 * np.minimum(FORCE, 60.0) / 60.0
    found = judged(table(tmp_path, **{"Extension (mm)": 1e3 * (LENGTH * STRAIN + slip), "Strain (%)": 100.0 * STRAIN}))
    assert found.axial_stiffness == pytest.approx(EA, rel=5e-3)
    assert "'Extension (mm)' is" in found.notes[0]


@pytest.mark.parametrize(
    "name", ["Transverse strain (%)", "Plastic strain (%)", "True strain (%)", "Lateral strain [%]"]
)
def test_strains_across_the_specimen_are_left_out(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="no column 'elongation'"):
        read_test(table(tmp_path, **{name: 30.0 * STRAIN}), gauge=LENGTH)
    found = judged(table(tmp_path, **{"Extension (mm)": 1e3 * LENGTH * STRAIN, name: 30.0 * STRAIN}))
    assert found.axial_stiffness == pytest.approx(EA, rel=5e-3)
    assert found.notes == ()


def test_columns_that_no_crosshead_explains(tmp_path: Path) -> None:
    elongation = 1e3 * LENGTH * STRAIN
    with pytest.raises(InputError, match=r"'Strain \(%\)' times the initial length differ, .*check the units"):
        judged(table(tmp_path, **{"Extension (mm)": elongation, "Strain (%)": STRAIN}))  # mm/mm
    with pytest.raises(InputError, match=r"columns 'Extension .* and 'Corrected .*: keep the one"):
        judged(table(tmp_path, **{"Extension (mm)": 2.0 * elongation, "Corrected extension (mm)": elongation}))


def test_a_number_in_quotes_may_not_hold_the_separator(tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    path.write_text('Extension (mm),Load (N)\n1.0,"1,030.0"\n')
    with pytest.raises(InputError, match=r"line 2: 3 cells; the header has 2; a number in quotes holds ','"):
        read_test(path)


def test_columns_of_one_motion_need_no_note(tmp_path: Path) -> None:
    rounded = np.round(100.0 * STRAIN, 2)
    for zero in (0.0, 5.0):  # mm: crossheads count from anywhere
        columns = {"Extension (mm)": 1e3 * LENGTH * STRAIN + zero, "Strain (%)": rounded}
        assert read_test(table(tmp_path, **columns), gauge=LENGTH).notes == ()


def test_a_strain_of_the_crosshead_is_left_out(tmp_path: Path) -> None:
    columns = {"Extension (mm)": 1e3 * LENGTH * STRAIN, "Tensile strain (Displacement) (mm/mm)": 2.0 * STRAIN}
    found = judged(table(tmp_path, **columns, **{"Strain rate (1/s)": FORCE}))
    assert found.axial_stiffness == pytest.approx(EA, rel=5e-3)
    assert found.notes == ()


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        ({"Elongation (mm)": 1.5e3 * LENGTH * STRAIN, "Strain (%)": 100.0 * STRAIN}, "differ, ranges 30 and 20 mm"),
        ({"Extension (mm)": 1e3 * LENGTH * STRAIN, "Strain (%)": 0.0 * STRAIN}, "differ, ranges 20 and 0 mm"),
        ({"Strain 1 (%)": STRAIN, "Strain 2 (%)": STRAIN}, "more than one column 'strain'"),
        ({"Extension (mm)": STRAIN, "Extensometer (mm)": STRAIN}, "more than one column 'elongation'"),
        ({"Extension (mm)": STRAIN, "Strain": STRAIN}, "column 'Strain': give its unit"),
    ],
    ids=lambda case: case if isinstance(case, str) else "",
)
def test_what_is_rejected(tmp_path: Path, columns: dict[str, np.ndarray], says: str) -> None:
    with pytest.raises(InputError) as error:
        judged(table(tmp_path, **columns))
    assert says in str(error.value)
    assert "\n" not in str(error.value)


def test_creep_takes_the_extensometer_too(tmp_path: Path) -> None:
    time = np.concatenate([[0.0], np.geomspace(0.5, 7200.0, len(FORCE) - 1)])
    force = np.where(time > 0.0, 1000.0, 0.0)
    strain = force / EA + 1e-6 * force * np.log1p(time) / np.log1p(3600.0)
    found = []
    for factor in (1.0, 1.5):
        rows = np.column_stack([time, 1e3 * factor * LENGTH * strain, 100.0 * strain, force]).tolist()
        text = "\n".join(",".join(f"{value:.7f}" for value in row) for row in rows)
        path = tmp_path / "creep.csv"
        path.write_text(f"Time (s),Extension (mm),Strain (%),Load (N)\n{text}\n")
        found.append(creep(path, initial_length=LENGTH))
    assert found[1].stiffness == pytest.approx(found[0].stiffness, rel=1e-4)
    assert any("1.5 times as large" in note for note in found[1].notes)
